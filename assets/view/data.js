"use strict";
// The run inside the page: blocks of zlib in base64, unpacked by the browser itself. A block is columns of whole
// numbers, each
// as its bytes of the lowest order, then those of the next, and so on. src/view/columns.rs writes what this reads.

/** The bytes of a block, which then leaves the page. */
async function unpacked(name) {
  const element = document.getElementById(name);
  const text = element.textContent.trim();
  element.remove();
  let bytes;
  if (Uint8Array.fromBase64) {
    bytes = Uint8Array.fromBase64(text);
  } else {
    const letters = atob(text);
    bytes = new Uint8Array(letters.length);
    for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  }
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The columns of a block by name; `layout` lists name, count and bytes a number. */
function columns(bytes, layout) {
  const found = {};
  let at = 0;
  for (const [name, count, planes] of layout) {
    const values = new Uint32Array(count);
    for (let plane = 0; plane < planes; plane++, at += count) {
      const [part, shift] = [bytes.subarray(at, at + count), 8 * plane];
      for (let i = 0; i < count; i++) values[i] |= part[i] << shift;
    }
    found[name] = values;
  }
  if (at !== bytes.length) throw new Error("the data in this page are damaged");
  return found;
}

/** 0, 1, 2, 3, 4, ... for 0, -1, 1, -2, 2, ..., and back. */
const signed = (v) => (v >>> 1) ^ -(v & 1);
const asFloat = (words) => new Float32Array(words.buffer, words.byteOffset, words.length);

/** What all states share of each body that was ever recorded. */
function readTable(header, bytes) {
  const table = columns(bytes, header.table.columns);
  const count = header.table.bodies;
  const long = (low, high) => Float64Array.from({ length: count }, (_, i) => table[high][i] * 4294967296 + table[low][i]);
  const ids = long("id", "id_high");
  const parents = long("parent", "parent_high");
  const rows = new Map();
  for (let i = 0; i < count; i++) rows.set(ids[i], i);
  const sizes = ["size_1", "size_2", "size_3"].map((name) => asFloat(table[name]));
  const daughters = new Map();
  for (let i = 0; i < count; i++) {
    if (!table.has_parent[i]) continue;
    if (!daughters.has(parents[i])) daughters.set(parents[i], []);
    daughters.get(parents[i]).push(i);
  }
  return {
    count, ids, parents, rows, sizes, daughters, hasParent: table.has_parent, birth: asFloat(table.birth),
    generation: table.generation, group: table.group, kind: table.kind, reference: table.reference,
    place: new Int32Array(3 * count), turn: unturned(count), list: new Uint32Array(0), bonds: null,
  };
}

function unturned(count) {
  const turns = new Float32Array(4 * count);
  for (let i = 3; i < turns.length; i += 4) turns[i] = 1;
  return turns;
}

/** The next state; `table` keeps where each body was last, since the states hold differences. */
function readState(header, table, about, bytes) {
  const read = columns(bytes, about.columns);
  if (read.row) {
    let row = 0;
    for (let i = 0; i < about.bodies; i++) read.row[i] = row += signed(read.row[i]);
    table.list = read.row;
  }
  const state = { ...about, list: table.list, place: new Float32Array(3 * about.bodies), values: {} };
  readPlaces(header, table, read, state);
  readTurns(table, read, state);
  readShapes(table, read, state);
  if (read.bond_a) table.bonds = readBonds(read);
  state.bonds = table.bonds;
  for (const name of header.measured) if (read[name]) state.values[name] = new Uint16Array(read[name]);
  state.contacts = about.contacts === null ? null : readContacts(header, read, state);
  return state;
}

function readPlaces(header, table, read, state) {
  const { place } = state;
  const last = table.place;
  [read.x, read.y, read.z].forEach((differences, k) => {
    const middle = header.middle[k], step = header.length_step;
    for (let i = 0; i < state.bodies; i++) {
      const at = last[3 * state.list[i] + k] += signed(differences[i]);
      place[3 * i + k] = (at - middle) * step;
    }
  });
}

/** A turn is the last one times a small one, of which the largest part is left out. */
function readTurns(table, read, state) {
  const turns = new Float32Array(4 * state.bodies);
  const { turn_1, turn_2, turn_3, turn_largest } = read;
  const last = table.turn;
  for (let i = 0; i < state.bodies; i++) {
    const p = signed(turn_1[i]) / TURN_STEPS, q = signed(turn_2[i]) / TURN_STEPS, r = signed(turn_3[i]) / TURN_STEPS;
    const s = Math.sqrt(Math.max(1 - p * p - q * q - r * r, 0));
    const largest = turn_largest[i];
    const a = largest === 0 ? s : p, b = largest === 1 ? s : largest === 0 ? p : q;
    const c = largest === 2 ? s : largest === 3 ? r : q, d = largest === 3 ? s : r;
    const at = 4 * state.list[i];
    const x = last[at], y = last[at + 1], z = last[at + 2], w = last[at + 3];
    const e = w * a + d * x + (y * c - z * b), f = w * b + d * y + (z * a - x * c);
    const g = w * c + d * z + (x * b - y * a), h = w * d - (x * a + y * b + z * c);
    const norm = Math.sqrt(e * e + f * f + g * g + h * h);
    turns[4 * i] = last[at] = e / norm;
    turns[4 * i + 1] = last[at + 1] = f / norm;
    turns[4 * i + 2] = last[at + 2] = g / norm;
    turns[4 * i + 3] = last[at + 3] = h / norm;
  }
  state.turn = turns;
}

/** Steps of a turn's part to one: the parts beside the largest are at most a root of a half. */
const TURN_STEPS = 32767 * Math.SQRT2;

/** The kind, of a superellipsoid with its exponents behind the point; and half a segment or a circle's radius and the radius, or semi-axes. */
function readShapes(table, read, state) {
  const shape = state.shape = new Float32Array(4 * state.bodies);
  const { sizes } = table;
  const half = read.half_length;
  const [low, high] = state.ranges.half_length ?? [0, 0];
  for (let i = 0; i < state.bodies; i++) {
    const row = state.list[i];
    const kind = table.kind[row] & 7;
    shape[4 * i] = kind + (table.kind[row] >>> 3) / 1048576;
    const length = half && (kind === 1 || kind === 3) ? low + (high - low) * half[i] / 65535 : 0;
    // An ellipsoid that grows keeps the radii of curvature of its tips, those on its last axis.
    const across = kind === 3 && length > 0 ? Math.sqrt(length / sizes[2][row]) : 1;
    shape[4 * i + 1] = kind === 1 && half ? length : across * sizes[0][row];
    shape[4 * i + 2] = across * sizes[1][row];
    shape[4 * i + 3] = kind === 3 && length > 0 ? length : sizes[2][row];
  }
}

/** The bonds that hold: the rows of their bodies in the state, and where they end on these. */
function readBonds(read) {
  const ends = ["a", "b"].map((which) => ["x", "y", "z"].map((axis) => asFloat(read[`bond_${which}${axis}`])));
  return { a: read.bond_a, b: read.bond_b, ends };
}

function readContacts(header, read, state) {
  const count = state.contacts;
  const found = { count, a: read.contact_a, b: read.contact_b, force: null, gap: null, point: new Float32Array(3 * count) };
  const axes = [read.contact_x, read.contact_y, read.contact_z];
  const unpack = (name) => {
    const [low, high] = state.ranges[name];
    return Float32Array.from(read[name], (v) => low + (high - low) * v / 65535);
  };
  found.gap = unpack("contact_gap");
  if (read.contact_force) found.force = unpack("contact_force");
  for (let i = 0, a = 0; i < count; i++) {
    found.a[i] = a += found.a[i];
    found.b[i] = (a + signed(found.b[i])) >>> 0;
    for (let k = 0; k < 3; k++) found.point[3 * i + k] = state.place[3 * a + k] + signed(axes[k][i]) * header.length_step;
  }
  return found;
}

/** Everything, telling how far it is. */
async function readRun(tell) {
  const header = JSON.parse(new TextDecoder().decode(await unpacked("run")));
  const table = readTable(header, await unpacked("bodies"));
  const states = [];
  let next = unpacked("state-0");
  for (let i = 0; i < header.states.length; i++) {
    tell(i, header.states.length);
    const bytes = await next;
    // The browser unpacks the next state while this one is read.
    if (i + 1 < header.states.length) next = unpacked(`state-${i + 1}`);
    states.push(readState(header, table, header.states[i], bytes));
  }
  delete table.place;
  delete table.turn;
  return { header, table, states };
}

/** The value of a quantity of each body of a state, or none where the state does not have it. */
function valuesOf(run, state, name) {
  const { table } = run;
  const of = (value) => {
    const values = new Float32Array(state.bodies);
    for (let i = 0; i < values.length; i++) values[i] = value(i, state.list[i]);
    return values;
  };
  if (name === "age") return of((_, row) => state.time - table.birth[row]);
  if (name === "generation") return of((_, row) => table.generation[row]);
  if (name === "group") return of((_, row) => (table.group[row] === 0xffffffff ? 0 : table.group[row] + 1));
  if (name === "length") return of((i) => 2 * reachOf(state.shape, i));
  const packed = state.values[name];
  if (!packed) return null;
  const [low, high] = state.ranges[name];
  return of((i) => low + (high - low) * packed[i] / 65535);
}

/** The exponents of a superellipsoid, by its kind: of ten bits each, from 2 to 10. */
function exponentsOf(kind) {
  const code = Math.round((kind - 4) * 1048576);
  return [code & 1023, code >>> 10].map((part) => Number((2 + part * 8 / 1023).toFixed(2)));
}

/** The norm of two numbers that are not negative. */
function normOf(a, b, n) {
  return n === Infinity ? Math.max(a, b) : (a ** n + b ** n) ** (1 / n);
}

/** The bounding radius. */
function reachOf(shape, i) {
  const [kind, a, b, c] = shape.subarray(4 * i, 4 * i + 4);
  if (kind < 4) return kind <= 2 ? a + b : Math.max(a, b, c);
  // Of exponent n the farthest point is as far as the norm with 2 n / (n - 2).
  const [p, q] = exponentsOf(kind).map((n) => (n > 2 ? 2 * n / (n - 2) : Infinity));
  const unit = Math.max(a, b, c);
  return unit * normOf(normOf(a / unit, b / unit, q), c / unit, p);
}

/** The smallest diameter. */
function thicknessOf(shape, i) {
  const b = shape[4 * i + 2];
  return 2 * (shape[4 * i] <= 2 ? b : Math.min(shape[4 * i + 1], b, shape[4 * i + 3]));
}
