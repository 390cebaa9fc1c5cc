"use strict";
// The panel beside the picture: the legend of the colours, the plot of the run's steps, what is known of a picked body.

/** Dark blue over green to yellow in Oklab; hues of an axis by twice its angle. As src/render/colour.rs. */
const RAMP = [[0.52, 0, -0.14], [0.62, -0.08, -0.07], [0.72, -0.13, 0.04], [0.82, -0.07, 0.15], [0.91, 0.01, 0.16]];

function ramp(part) {
  const place = Math.min(Math.max(part, 0), 1) * 4;
  const below = Math.min(Math.floor(place), 3);
  return RAMP[below].map((x, k) => x + (RAMP[below + 1][k] - x) * (place - below));
}
const hue = (angle) => [0.74, 0.125 * Math.cos(2 * angle + 0.45), 0.125 * Math.sin(2 * angle + 0.45)];

/** Linear light of a colour in Oklab. */
function light([lightness, a, b]) {
  const [l, m, s] = [[0.39633778, 0.21580376], [-0.105561346, -0.06385417], [-0.08948418, -1.2914855]]
    .map(([p, q]) => (lightness + p * a + q * b) ** 3);
  return [[4.0767417, -3.3077116, 0.23096994], [-1.268438, 2.6097574, -0.34131938], [-0.0041960863, -0.7034186, 1.7076147]]
    .map((row) => Math.min(Math.max(row[0] * l + row[1] * m + row[2] * s, 0), 1));
}

function css(colour) {
  const encode = (v) => Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
  return `rgb(${light(colour).map(encode).join(",")})`;
}

/** A number with as many digits as a reader needs. */
function shown(value, digits = 4) {
  if (!Number.isFinite(value)) return "not known";
  if (value !== 0 && (Math.abs(value) < 1e-3 || Math.abs(value) >= 1e6)) return value.toExponential(Math.max(digits - 2, 0));
  return String(Number(value.toPrecision(digits)));
}

/** A whole number as it is, others with three digits. */
const shortly = (value) => (Number.isInteger(value) ? String(value) : shown(value, 3));

const byId = (id) => document.getElementById(id);

function made(tag, text, parts = []) {
  const element = document.createElement(tag);
  if (text !== null) element.textContent = text;
  element.append(...parts);
  return element;
}

function drawLegend(quantity, scale, note) {
  byId("legend").hidden = quantity.kind === "none";
  if (quantity.kind === "none") return;
  // Names of groups stand beside their colours in the panel.
  for (const id of ["legend-scale", "legend-low", "legend-high"]) byId(id).hidden = quantity.kind === "hue" || quantity.name === "group";
  byId("legend-name").textContent = quantity.name;
  const ends = quantity.kind === "cyclic" ? ["0°", "180°"]
    : scale ? [shown(scale[0]), (scale[2] > scale[1] ? "> " : "") + shown(scale[1])] : ["", ""];
  ["legend-low", "legend-high"].forEach((id, k) => { byId(id).textContent = ends[k]; });
  byId("legend-note").textContent = note;
  const canvas = byId("legend-scale");
  canvas.width = 256;
  const context = canvas.getContext("2d");
  for (let x = 0; x < 256; x++) {
    context.fillStyle = css(quantity.kind === "cyclic" ? hue(Math.PI * x / 255) : ramp(x / 255));
    context.fillRect(x, 0, 1, canvas.height);
  }
}

/** A bar of a round length, at most a fifth of the picture. */
function drawBar(scale, width) {
  const most = width / 5 / scale;
  const power = 10 ** Math.floor(Math.log10(most));
  const round = [5, 2, 1].find((k) => k * power <= most) * power;
  byId("bar").style.width = `${round * scale}px`;
  byId("bar").firstElementChild.textContent = shown(round, 3);
}

/** Pixels of a curve's strip. */
const STRIP = 58;
/** So many measures are drawn at first: more strips are a long way to scroll. */
const MOST_CURVES = 12;
const CURVES = [["bodies", "bodies"], ["constraints", "constraints"], ["recursions", "recursions"], ["max_overlap", "overlap"]];

/** The groups with their colours; a click hides one. */
function showGroups(viewer) {
  const { header, table } = viewer.run;
  const place = byId("groups");
  place.hidden = header.groups.length === 0;
  if (place.hidden || viewer.at === undefined) return;
  const { state } = viewer;
  const counts = new Map();
  for (let i = 0; i < state.bodies; i++) {
    const of = table.group[state.list[i]];
    const group = of === 0xffffffff ? -1 : of;
    counts.set(group, (counts.get(group) ?? 0) + 1);
  }
  const quantity = header.quantities[viewer.colour];
  const [low, high] = quantity.scale ?? [0, 1];
  const known = header.groups.map((name, k) => [k, name]).concat(counts.has(-1) ? [[-1, "no group"]] : []);
  place.replaceChildren(...known.map(([group, name]) => {
    const swatch = made("i", "");
    if (quantity.name === "group") swatch.style.background = css(ramp(high > low ? (group + 1 - low) / (high - low) : 0));
    const button = made("button", null, [swatch, made("span", `${name}  ${counts.get(group) ?? 0}`)]);
    button.title = "hide or show";
    button.setAttribute("aria-pressed", String(!viewer.hidden.has(group)));
    button.addEventListener("click", () => viewer.hide(group, !viewer.hidden.has(group)));
    return button;
  }));
}

/** The run's measures by name; a click draws one or leaves it out. */
function showCurves(viewer) {
  const { measures } = viewer.run.header;
  byId("curves").hidden = !measures || measures.curves.length < 2;
  if (byId("curves").hidden) return;
  byId("curve-names").replaceChildren(...measures.curves.map(([name, title]) => {
    const button = made("button", title);
    button.setAttribute("aria-pressed", String(viewer.curves.has(name)));
    button.addEventListener("click", () => {
      if (!viewer.curves.delete(name)) viewer.curves.add(name);
      button.setAttribute("aria-pressed", String(viewer.curves.has(name)));
      viewer.replot();
    });
    return button;
  }));
  const all = measures.curves.length;
  byId("curves").firstElementChild.textContent = `Which of ${all} measures`;
}

/** The numbers of the scene. */
function showParameters({ name, version, parameters }) {
  byId("scene").hidden = !parameters?.length;
  // The last digits of a sum of defaults say nothing.
  const short = (value) => (typeof value === "number" ? String(Number(value.toPrecision(12))) : JSON.stringify(value));
  const rows = (parameters ?? []).map(([key, value]) => made("tr", null, [made("th", key), made("td", short(value))]));
  byId("scene-text").replaceChildren(made("p", `${name}, by relcp ${version}`), made("table", null, [made("tbody", null, rows)]));
}

/** Columns of the run against time, a strip each, with a line at `time`. */
function drawPlot(canvas, steps, curves, time, ink) {
  canvas.style.height = `${curves.length * STRIP + 16}px`;
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.font = "12px system-ui, sans-serif";
  const [first, last] = [steps.time[0], steps.time[steps.time.length - 1]];
  const x = (t) => 1 + (width - 2) * (last > first ? (t - first) / (last - first) : 0.5);
  const strip = (height - 16) / curves.length;
  let here = 0;
  while (here + 1 < steps.time.length && steps.time[here + 1] <= time) here++;
  curves.forEach(([name, title], k) => {
    const values = steps[name];
    const known = values.filter((v) => Number.isFinite(v));
    const low = known.reduce((a, b) => Math.min(a, b), 0);
    const [top, bottom] = [k * strip + 18, (k + 1) * strip - 4];
    const most = known.reduce((a, b) => Math.max(a, b), 0);
    const y = (v) => bottom - (most > low ? (bottom - top) * (v - low) / (most - low) : 0);
    context.fillStyle = ink.line;
    context.fillRect(0, y(0), width, 1);
    context.strokeStyle = ink.ink;
    context.lineWidth = 1.2;
    context.beginPath();
    values.forEach((v, i) => { if (Number.isFinite(v)) context.lineTo(x(steps.time[i]), y(v)); });
    context.stroke();
    context.fillStyle = ink.soft;
    context.fillText(title, 0, top - 5);
    context.textAlign = "right";
    context.fillText(`${low < 0 ? `from ${shortly(low)} ` : ""}to ${shortly(most)}`, width, top - 5);
    context.textAlign = "left";
    context.fillStyle = ink.accent;
    context.fillText(Number.isFinite(values[here]) ? shortly(values[here]) : "–", Math.max(84, 8 + context.measureText(title).width), top - 5);
    context.fillRect(x(Math.min(Math.max(time, first), last)) - 0.75, top, 1.5, bottom - top);
  });
  context.fillStyle = ink.soft;
  context.fillText(shown(first), 0, height - 3);
  context.textAlign = "right";
  context.fillText(`time ${shown(last)}`, width, height - 3);
}

/** The time at a place of the plot, from 0 to 1 of its width. */
function timeAt(steps, part) {
  const [first, last] = [steps.time[0], steps.time[steps.time.length - 1]];
  return first + (last - first) * part;
}

function sizeOf(state, i) {
  const [kind, a, b, c] = state.shape.subarray(4 * i, 4 * i + 4);
  if (kind === 0) return `sphere, radius ${shown(b)}`;
  if (kind === 1) return `rod, diameter ${shown(2 * b)}, length ${shown(2 * (a + b))}`;
  if (kind === 2) return `ring, radius ${shown(a)}, tube's radius ${shown(b)}`;
  const radii = `semi-axes ${[a, b, c].map((r) => shown(r)).join(", ")}`;
  return kind === 3 ? `ellipsoid, ${radii}` : `superellipsoid, ${radii}, exponents ${exponentsOf(kind).join(", ")}`;
}

function link(text, act) {
  const button = made("button", text);
  button.className = "link";
  button.addEventListener("click", act);
  return button;
}

/** What is known of body `row` of the table in a state; `go` picks another one. */
function showPicked(run, state, row, go) {
  const { table, header } = run;
  const place = byId("picked");
  if (row < 0) {
    place.replaceChildren(Object.assign(made("p", "Click a body to see what it is."), { className: "hint" }));
    return;
  }
  const i = state.list.indexOf(row);
  const to = (id) => (table.rows.has(id) ? link(String(id), () => go(table.rows.get(id))) : document.createTextNode(String(id)));
  const lines = [];
  const add = (name, ...parts) => lines.push(made("tr", null, [made("th", name), made("td", null, parts)]));
  const group = table.group[row];
  if (group !== 0xffffffff) add("group", header.groups[group] ?? String(group));
  add("parent", table.hasParent[row] ? to(table.parents[row]) : "none, a founder");
  add("generation", String(table.generation[row]));
  if (table.hasParent[row]) add("lineage", ...lineage(table, row, to));
  const daughters = table.daughters.get(table.ids[row]) ?? [];
  if (daughters.length) add("daughters", ...spaced(daughters.map((daughter) => to(table.ids[daughter]))));
  add("born", shown(table.birth[row], 6));
  if (i < 0) {
    add("now", state.time < table.birth[row] ? "not born yet" : daughters.length ? "it has divided" : "not in this state");
  } else {
    describe(run, state, i, add);
  }
  const parts = [made("h2", `Body ${table.ids[row]}`), made("table", null, [made("tbody", null, lines)])];
  if (i >= 0) parts.push(...contactTable(run, state, i, to));
  place.replaceChildren(...parts);
}

function spaced(parts) {
  return parts.flatMap((part, k) => (k ? [", ", part] : [part]));
}

function lineage(table, row, to) {
  const chain = [];
  for (let at = row; at !== undefined && table.hasParent[at] && chain.length < 64; at = table.rows.get(table.parents[at])) {
    chain.push(to(table.parents[at]));
  }
  return spaced(chain);
}

function describe(run, state, i, add) {
  const { header } = run;
  add("shape", sizeOf(state, i));
  add("row", String(i));
  const centre = [0, 1, 2].map((k) => state.place[3 * i + k] + header.origin[k]);
  add("centre", centre.map((x) => shown(x, 5)).join(", "));
  for (const { name, kind, missing } of header.quantities) {
    if (kind !== "sequential" || missing || name === "generation" || name === "contacts" || name === "group") continue;
    const values = valuesOf(run, state, name);
    if (values) add(name, shown(values[i]));
  }
}

/** The contacts of the body in row `i`, the hardest pushed first. */
function contactsOf(state, i) {
  const found = [];
  const { contacts } = state;
  for (let k = 0; contacts && k < contacts.count; k++) {
    if (contacts.a[k] === i || contacts.b[k] === i) {
      found.push({
        other: contacts.a[k] === i ? contacts.b[k] : contacts.a[k], gap: contacts.gap[k],
        force: contacts.force ? contacts.force[k] : NaN, point: Array.from(contacts.point.subarray(3 * k, 3 * k + 3)),
      });
    }
  }
  return found.sort((p, q) => (q.force || 0) - (p.force || 0));
}

function contactTable(run, state, i, to) {
  if (!state.contacts) return [Object.assign(made("p", run.header.contacts_left_out), { className: "hint" })];
  const found = contactsOf(state, i);
  const title = made("h2", found.length === 1 ? "1 contact" : `${found.length} contacts`);
  if (!found.length) return [title];
  const known = state.contacts.force !== null;
  const name = (other) => (other < state.bodies ? to(run.table.ids[state.list[other]]) : `wall ${other - state.bodies}`);
  const rows = found.map(({ other, gap, force }) =>
    made("tr", null, [made("td", null, [name(other)]), made("td", known ? shown(force) : ""), made("td", shown(gap, 3))]));
  const heads = made("tr", null, ["with", known ? "force" : "", "separation"].map((text) => made("th", text)));
  const scroll = made("div", null, [made("table", null, [made("thead", null, [heads]), made("tbody", null, rows)])]);
  scroll.className = "scroll";
  const parts = [title, scroll];
  if (!known) parts.push(Object.assign(made("p", "This state does not know its contact forces."), { className: "hint" }));
  return parts;
}

function showAbout(header) {
  byId("about-text").replaceChildren(...header.about.map((text) => made("p", text)));
}
