"use strict";
// What may be laid over the bodies: their axes, their way to the next state, the ways that they came, their bonds. Each
// is lines of six numbers, from the run's middle.

/** Trails go back over so many states; beyond so many bodies only the picked one has a trail. */
const TRAIL = 30;
const MOST_TRAILS = 3000;
/** The part of a way that its head takes. */
const HEAD = 0.25;

const OVERLAYS = {
  axes: ["Axes", "the axis of each body", axisLines],
  ways: ["Velocities", "the way of each body to the next state, by its velocity between both", wayLines],
  trails: ["Trails", "the ways that bodies came", trailLines],
  bonds: ["Bonds", "the bonds that hold", bondLines],
};

const centreOf = (state, i) => [state.place[3 * i], state.place[3 * i + 1], state.place[3 * i + 2]];
const turnOf = (state, i) => state.turn.subarray(4 * i, 4 * i + 4);

/** A vector turned by a quaternion x, y, z, w, or back. */
function rotated([x, y, z, w], v, back = false) {
  const q = back ? [-x, -y, -z] : [x, y, z];
  const t = cross(q, v).map((part) => 2 * part);
  return plus(plus(v, t, w), cross(q, t));
}

/** The row of each body of the table in a state; -1 where it is not there. */
function rowsOf(run, state) {
  if (state.rows?.length === run.table.count) return state.rows;
  state.rows = new Int32Array(run.table.count).fill(-1);
  for (let i = 0; i < state.bodies; i++) state.rows[state.list[i]] = i;
  return state.rows;
}

function axisLines(viewer) {
  const { state } = viewer;
  const ends = [];
  for (let i = 0; i < state.bodies; i++) {
    const [kind, a, b, c] = state.shape.subarray(4 * i, 4 * i + 4);
    if (kind === 0 || viewer.isHidden(i)) continue;
    const longest = kind >= 3 ? [a, b, c].indexOf(Math.max(a, b, c)) : 2;
    const reach = kind === 1 ? a + b : kind === 2 ? 0.6 * a : Math.max(a, b, c);
    const axis = rotated(turnOf(state, i), [0, 1, 2].map((k) => (k === longest ? reach : 0)));
    ends.push(...plus(centreOf(state, i), axis, -1), ...plus(centreOf(state, i), axis));
  }
  return ends;
}

function wayLines(viewer) {
  const { state, run } = viewer;
  const other = run.states[viewer.at + 1] ?? run.states[viewer.at - 1];
  if (!other) return [];
  const way = other.time > state.time ? 1 : -1;
  const rows = rowsOf(run, other);
  const ends = [];
  for (let i = 0; i < state.bodies; i++) {
    const j = rows[state.list[i]];
    if (j < 0 || viewer.isHidden(i)) continue;
    const from = centreOf(state, i);
    const gone = plus(viewer.nearest(centreOf(other, j), from), from, -1).map((x) => way * x);
    const to = plus(from, gone);
    const aside = cross(viewer.camera.axes[2], gone).map((x) => 0.5 * HEAD * x);
    const neck = plus(to, gone, -HEAD);
    ends.push(...from, ...to, ...plus(neck, aside), ...to, ...plus(neck, aside, -1), ...to);
  }
  return ends;
}

function trailLines(viewer) {
  const { state, run, at } = viewer;
  const chosen = state.bodies <= MOST_TRAILS ? Array.from({ length: state.bodies }, (_, i) => i) : viewer.picked_row >= 0 ? [viewer.picked_row] : [];
  const last = new Map(chosen.filter((i) => !viewer.isHidden(i)).map((i) => [state.list[i], centreOf(state, i)]));
  const ends = [];
  for (let k = at - 1; k >= Math.max(at - TRAIL, 0); k--) {
    const rows = rowsOf(run, run.states[k]);
    for (const [row, to] of last) {
      const i = rows[row];
      if (i < 0) {
        last.delete(row);
        continue;
      }
      const centre = centreOf(run.states[k], i);
      const near = viewer.nearest(centre, to);
      ends.push(...near, ...to);
      last.set(row, near);
    }
  }
  return ends;
}

/** Lines of the bonds that hold, through the centres, as an end may be inside of its body. */
function bondLines(viewer) {
  const { state } = viewer;
  const ends = [];
  const add = (i, j, points) => {
    if (viewer.isHidden(i) || viewer.isHidden(j)) return;
    const [a, b] = [i, j].map((body, k) => plus(centreOf(state, body), rotated(turnOf(state, body), points[k])));
    const near = viewer.nearest(b, a);
    ends.push(...centreOf(state, i), ...a, ...a, ...near, ...near, ...viewer.nearest(centreOf(state, j), a));
  };
  if (state.bonds) {
    const { a, b, ends: of } = state.bonds;
    for (let k = 0; k < a.length; k++) add(a[k], b[k], of.map((axes) => axes.map((values) => values[k])));
  } else {
    statedBonds(viewer, add);
  }
  return ends;
}

/** The scene's bonds, of a run whose states do not have them. */
function statedBonds({ state, run, at }, add) {
  const rows = rowsOf(run, state);
  const broken = new Set(run.header.states[at].broken_bonds ?? []);
  run.header.bonds.forEach(([ids, points], number) => {
    const [i, j] = ids.map((id) => rows[run.table.rows.get(id) ?? -1] ?? -1);
    if (i >= 0 && j >= 0 && !broken.has(number)) add(i, j, points);
  });
}

/** A number from 0 to 1 for a body's id, such that ids near each other are far apart. */
const ownHue = (id) => (id * 0.6180339887498949) % 1;

/** The generation whose bodies are the clones that colours show. */
const CLONES = 3;

/** A hue of each body of a state: by its id, or by its ancestor of the third generation. */
function huesOf(run, state, name) {
  const { table } = run;
  const hues = new Float32Array(state.bodies);
  const clone = (row) => {
    let at = row;
    while (table.generation[at] > CLONES && table.hasParent[at] && table.rows.has(table.parents[at])) at = table.rows.get(table.parents[at]);
    return at;
  };
  for (let i = 0; i < state.bodies; i++) {
    const row = state.list[i];
    hues[i] = ownHue(table.ids[name === "clone" ? clone(row) : row]);
  }
  return hues;
}

/** Quantities that the page finds by itself. */
const OWN_HUES = [
  { name: "clone", text: "its ancestor of the third generation: bodies of one clone have one hue", kind: "hue", scale: null, missing: null },
  { name: "body", text: "its id: bodies near each other have other hues", kind: "hue", scale: null, missing: null },
];

/** The colour that shows something of a run, where none was asked for. */
function tellingColour({ header, table, states }) {
  const there = (name) => header.quantities.some((quantity) => quantity.name === name && quantity.missing === null);
  if (there("group") && header.groups.length > 1) return "group";
  if (table.hasParent.some((has) => has)) return "clone";
  const kinds = new Set(table.kind.subarray(0, table.count));
  if (kinds.has(2)) return "body";
  if (kinds.size === 1 && kinds.has(0)) return states.length > 1 && there("speed") ? "speed" : "body";
  return "orientation";
}
