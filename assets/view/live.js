"use strict";
// A run that goes on: its states as they are made, its controls, and the keys of its scene that may change.
// src/view/live.rs writes a state, src/cli/live/routes.rs answers what is asked here.

/** Bytes of states that the page keeps; beyond, every second older one goes. */
const MOST_KEPT = 4e8;
/** About so many bytes has a body in a state here, with its contacts. */
const BODY_BYTES = 200;
/** Points of the curves that the page keeps. */
const MOST_POINTS = 4800;
/** By this part a picture is fitted larger than the bodies reach, so that it is not fitted again at once. */
const SPARE = 0.08;
/** Milliseconds before the program is asked again that did not answer, and how often. */
const AGAIN = 1500;
const TRIES = 4;
const RATES = [["as they come", null], ["1 /s", 1], ["5 /s", 5], ["20 /s", 20], ["100 /s", 100], ["500 /s", 500], ["2000 /s", 2000]];

const sizeOfColumns = (layout) => layout.reduce((sum, [, count, planes]) => sum + count * planes, 0);

/** A document with its length before it, and what follows. */
function documentIn(bytes) {
  const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
  return [JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length))), bytes.subarray(4 + length)];
}

/** A state, which stands for itself: its page's description, its table of bodies, and the state with rows of this table. */
function readLive(bytes) {
  const [header, rest] = documentIn(bytes);
  const length = sizeOfColumns(header.table.columns);
  const table = readTable(header, rest.subarray(0, length));
  const state = readState(header, table, header.states[0], rest.subarray(length));
  return { header, table, state };
}

/** What the program answers to a question about news: they, and a state if there is one. */
async function news(step, version) {
  const has = step === null ? "" : `&step=${step}`;
  const answer = await fetch(`next?version=${version}${has}`, { cache: "no-store" });
  if (!answer.ok) throw new Error(`the program refuses to tell more (${answer.status})`);
  const [told, rest] = documentIn(new Uint8Array(await answer.arrayBuffer()));
  return { ...told, state: told.state ? readLive(rest) : null };
}

/** Adds the bodies of a state's table that are new; gives the row of each here. */
function mergeTable(table, more) {
  const rows = new Uint32Array(more.count);
  const lists = ["ids", "parents", "hasParent", "birth", "generation", "group", "kind"];
  for (let i = 0; i < more.count; i++) {
    let row = table.rows.get(more.ids[i]);
    if (row === undefined) {
      row = table.count++;
      if (row >= table.ids.length) {
        for (const name of lists) {
          const larger = new table[name].constructor(2 * row + 16);
          larger.set(table[name]);
          table[name] = larger;
        }
      }
      for (const name of lists) table[name][row] = more[name][i];
      table.rows.set(more.ids[i], row);
      if (more.hasParent[i]) {
        if (!table.daughters.has(more.parents[i])) table.daughters.set(more.parents[i], []);
        table.daughters.get(more.parents[i]).push(row);
      }
    }
    rows[i] = row;
  }
  return rows;
}

class Live {
  constructor(viewer, first) {
    this.viewer = viewer;
    this.status = first.status;
    this.step = first.state.state.step;
    this.kept = BODY_BYTES * first.state.state.bodies;
    this.rows = new Map();
    this.build();
    this.addPoints(first.points);
    this.fitted();
    this.tell();
    this.readKeys();
    this.follow();
  }

  build() {
    const button = (text, title, act) => {
      const made_one = Object.assign(made("button", text), { title });
      made_one.addEventListener("click", act);
      return made_one;
    };
    this.toggle = button("Play", "P", () => this.playOrPause());
    this.one = button("Step", "N", () => this.control({ do: "step" }));
    this.finish = button("End and save", "makes this state the end of the run", () => this.control({ do: "end" }));
    this.rate = made("select", null, RATES.map(([text], k) => Object.assign(made("option", text), { value: k })));
    this.rate.addEventListener("change", () => this.control({ do: "speed", steps_a_second: RATES[this.rate.value][1] }));
    const row = made("div", null, [this.toggle, this.one, this.finish, made("label", "Steps ", [this.rate])]);
    row.className = "row";
    this.said = Object.assign(made("p", ""), { className: "hint" });
    this.said.setAttribute("role", "status");
    this.filter = Object.assign(made("input", null), { type: "search", placeholder: "find a key" });
    this.filter.addEventListener("input", () => this.filterKeys());
    this.fields = made("tbody", null);
    this.other = [made("input", null), made("input", null)];
    this.other.forEach((input, k) => Object.assign(input, { placeholder: ["another key", "value"][k], spellcheck: false }));
    const others = made("tr", null, this.other.map((input) => made("td", null, [input])));
    const table = made("div", null, [made("table", null, [this.fields, made("tfoot", null, [others])])]);
    table.className = "scroll keys";
    this.fault = Object.assign(made("p", ""), { className: "fault" });
    this.fault.setAttribute("role", "alert");
    const form = made("form", null, [this.filter, table, Object.assign(made("button", "Set"), { type: "submit" }), this.fault]);
    form.addEventListener("submit", (event) => { event.preventDefault(); this.change(); });
    this.section = made("section", null, [row, this.said, made("details", null, [made("summary", "Change keys of the scene"), form])]);
    this.section.id = "live";
    byId("name").after(this.section);
    byId("measures").querySelector("h2").textContent = "Steps so far";
    byId("speed").value = 10;
    this.viewer.more_keys = { p: () => this.playOrPause(), n: () => this.control({ do: "step" }) };
    this.hands = new Hands(this);
    const keys = [["P", "let the run play, or pause"], ["N", "one step of the run"]];
    byId("key-table").prepend(...keys.map(([key, what]) => made("tr", null, [made("td", null, [made("kbd", key)]), made("td", what)])));
  }

  /** Asks for what is new, as often as it is drawn. */
  async follow() {
    let failures = 0;
    while (this.status.phase !== "ended" || this.behind) {
      if (document.hidden) await new Promise((go) => document.addEventListener("visibilitychange", go, { once: true }));
      try {
        // After a change the present state may have other bodies.
        const again = this.again && this.status.phase !== "ended";
        this.again = false;
        const told = await news(again ? null : this.step, this.status.version);
        failures = 0;
        this.behind = false;
        if (told.state) this.add(told.state);
        this.addPoints(told.points);
        if (told.status.version !== this.status.version) {
          this.again = told.status.changes !== this.status.changes && !told.state;
          this.status = told.status;
          this.readKeys();
        }
        this.tell();
        if (told.state) await new Promise(requestAnimationFrame).then(() => this.viewer.painter.drawn());
      } catch (error) {
        if (++failures > TRIES) {
          this.status = { ...this.status, phase: "ended", message: `The program does not answer any more (${error.message}). What it has told stays here.` };
          this.tell();
          return;
        }
        await new Promise((go) => setTimeout(go, AGAIN));
      }
    }
  }

  add({ header, table, state }) {
    const { viewer } = this;
    const { run } = viewer;
    const follows = viewer.at === run.states.length - 1 && !viewer.playing;
    const rows = mergeTable(run.table, table);
    state.list = state.list.map((row) => rows[row]);
    if (state.step === this.step) {
      run.states.pop();
      run.header.states.pop();
    }
    const about = { ...header.states[0], own_walls: header.walls };
    run.states.push(state);
    run.header.states.push(about);
    this.step = state.step;
    this.kept += BODY_BYTES * state.bodies;
    if (this.kept > MOST_KEPT) this.thin();
    this.mergeQuantities(header.quantities);
    byId("at").max = run.states.length - 1;
    if (follows) {
      this.keepInView(state);
      viewer.show(run.states.length - 1);
    } else {
      viewer.show(viewer.at);
    }
  }

  /** Leaves out every second state but the last ones. */
  thin() {
    const { viewer } = this;
    const { run } = viewer;
    const last = run.states.length - 1;
    const stays = (_, k) => k % 2 === 0 || k >= last - 1;
    viewer.at = [...Array(viewer.at).keys()].filter((k) => stays(null, k)).length;
    run.states = run.states.filter(stays);
    run.header.states = run.header.states.filter(stays);
    this.kept = run.states.reduce((sum, state) => sum + BODY_BYTES * state.bodies, 0);
  }

  mergeQuantities(more) {
    more.forEach(({ scale, missing }, k) => {
      const own = this.viewer.run.header.quantities[k];
      if (scale) {
        own.scale = own.scale ? [Math.min(own.scale[0], scale[0]), Math.max(own.scale[1], scale[1]), Math.max(own.scale[2], scale[2])] : scale;
      }
      if (own.missing !== null && missing === null) {
        own.missing = null;
        Object.assign(byId("colour").options[k], { disabled: false, title: own.text, textContent: own.name });
      }
    });
  }

  /** Fits the picture again where bodies leave it, unless the user has moved it. */
  keepInView(state) {
    const { viewer } = this;
    const { camera, canvas } = viewer;
    if (viewer.all) viewer.all = joined(viewer.all, extentOf(SIDES.top, [state]));
    const moved = this.camera.axes !== camera.axes || this.camera.scale !== camera.scale || this.camera.middle !== camera.middle;
    if (moved) return;
    const now = extentOf(camera.axes, [state]);
    const inside = [0, 1].every((k) => now[0][k] >= this.extent[0][k] && now[1][k] <= this.extent[1][k]);
    if (inside) return;
    this.extent = joined(this.extent, now);
    for (let k = 0; k < 2; k++) {
      const spare = SPARE * (this.extent[1][k] - this.extent[0][k]);
      this.extent[0][k] -= spare;
      this.extent[1][k] += spare;
    }
    camera.fit(camera.axes, this.extent, canvas.clientWidth, canvas.clientHeight);
    this.camera = { axes: camera.axes, scale: camera.scale, middle: camera.middle };
  }

  /** Remembers the fitted picture. */
  fitted() {
    const { camera, run, framed } = this.viewer;
    this.camera = { axes: camera.axes, scale: camera.scale, middle: camera.middle };
    this.extent = extentOf(camera.axes, run.states);
    stretch(this.extent, camera.axes, framed);
  }

  addPoints(points) {
    if (!points.length) return;
    const names = ["time", "bodies", "constraints", "recursions", "max_overlap"];
    const { header } = this.viewer.run;
    const steps = header.steps ??= { note: "Since the program was started. Click for the nearest state.", ...Object.fromEntries(names.map((name) => [name, []])) };
    // A question for a whole state is answered with all points.
    const told = steps.time.at(-1) ?? -Infinity;
    for (const point of points) if (point.time > told) names.forEach((name) => steps[name].push(point[name]));
    if (steps.time.length > MOST_POINTS) {
      for (const name of names) {
        const last = name === "time" || name === "bodies";
        const halved = [];
        for (let k = 0; k < steps[name].length; k += 2) {
          const [a, b] = [steps[name][k], steps[name][k + 1] ?? steps[name][k]];
          halved.push(last ? b : Math.max(a, b));
        }
        steps[name] = halved;
      }
    }
    byId("measures").hidden = byId("plot").hidden = false;
    byId("plot-note").textContent = steps.note;
    this.viewer.replot();
  }

  tell() {
    const { phase, message, end, changes, steps_a_second } = this.status;
    const { states } = this.viewer.run;
    const playing = phase === "playing";
    const over = phase === "ended" || phase === "saving";
    this.toggle.textContent = playing ? "Pause" : "Play";
    for (const control of [this.toggle, this.one, this.finish, this.rate]) control.disabled = over;
    this.hands.tell();
    const rate = RATES.findIndex(([, value]) => value === steps_a_second);
    if (document.activeElement !== this.rate) this.rate.value = rate;
    const time = shown(states[states.length - 1].time, 6);
    const changed = changes ? `, ${changes} ${changes === 1 ? "change" : "changes"} of the scene` : "";
    const words = { paused: "It pauses", playing: "It plays", saving: "It has ended and is being saved", ended: "It has ended" };
    this.said.textContent = `${words[phase]} at time ${time} of ${shown(end, 6)}${changed}.${message ? ` ${message}` : ""}`;
  }

  /** What the program says to a request; its refusal is shown. */
  async post(place, body) {
    this.fault.textContent = "";
    if (this.status.phase === "ended") {
      this.fault.textContent = "The run has ended.";
      return null;
    }
    try {
      const answer = await fetch(place, { method: "POST", headers: { "Content-Type": "application/json" }, body: typeof body === "string" ? body : JSON.stringify(body) });
      const said = await answer.json();
      if (answer.ok) return said;
      this.fault.textContent = [said.error, said.help].filter(Boolean).join(" – ");
    } catch (error) {
      this.fault.textContent = `The program does not answer (${error.message}).`;
    }
    this.fault.scrollIntoView({ block: "nearest" });
    return null;
  }

  control(what) {
    return this.post("control", what);
  }

  playOrPause() {
    this.viewer.play(false);
    this.viewer.show(this.viewer.run.states.length - 1);
    return this.control({ do: this.status.phase === "playing" ? "pause" : "play" });
  }

  async readKeys() {
    if (this.status.phase === "ended" || this.status.phase === "saving") return;
    let keys;
    try {
      keys = await (await fetch("keys", { cache: "no-store" })).json();
    } catch {
      return;
    }
    const names = new Set(keys.map(([key]) => key));
    for (const [key, { row }] of this.rows) {
      if (names.has(key)) continue;
      row.remove();
      this.rows.delete(key);
    }
    for (const [key, value] of keys) {
      const text = JSON.stringify(value);
      let field = this.rows.get(key);
      if (!field) {
        const input = Object.assign(made("input", null), { spellcheck: false, autocomplete: "off", value: text });
        input.setAttribute("aria-label", key);
        // A long key breaks between its words.
        const words = key.split(/(?<=[._])/).flatMap((word) => [word, document.createElement("wbr")]);
        field = { input, row: made("tr", null, [made("th", null, words), made("td", null, [input])]), text };
        input.addEventListener("input", () => input.classList.toggle("edited", input.value.trim() !== field.text));
        this.fields.append(field.row);
        this.rows.set(key, field);
      }
      // What the user is about to set stays.
      if (field.input.value.trim() === field.text) field.input.value = text;
      field.text = text;
      field.input.classList.toggle("edited", field.input.value.trim() !== text);
    }
    this.filterKeys();
  }

  filterKeys() {
    const words = this.filter.value.toLowerCase();
    for (const [key, { row, input, text }] of this.rows) row.hidden = !key.toLowerCase().includes(words) && input.value.trim() === text;
  }

  /** Sets all keys that were edited, as one change. */
  async change() {
    // The reader of scenes says what is wrong with what is no number.
    // As it was written: a whole number may have more digits than a number here.
    const valueOf = (text) => { try { JSON.parse(text); return text; } catch { return JSON.stringify(text); } };
    const set = {};
    for (const [key, { input, text }] of this.rows) if (input.value.trim() !== text) set[key] = valueOf(input.value.trim());
    const [other, value] = this.other.map((input) => input.value.trim());
    if (other) set[other] = valueOf(value);
    if (!Object.keys(set).length) {
      this.fault.textContent = "No value was edited.";
      return;
    }
    const pairs = Object.entries(set).map(([key, value]) => `${JSON.stringify(key)}: ${value}`);
    const said = await this.post("change", `{ ${pairs.join(", ")} }`);
    if (!said) return;
    for (const key of Object.keys(set)) {
      const field = this.rows.get(key);
      if (field) field.text = field.input.value.trim();
    }
    this.other.forEach((input) => { input.value = ""; });
    await this.readKeys();
  }
}

function joined([low, high], [other_low, other_high]) {
  return [low.map((x, k) => Math.min(x, other_low[k])), high.map((x, k) => Math.max(x, other_high[k]))];
}

async function startLive() {
  let first;
  await start(async () => {
    byId("busy").textContent = "waiting for the run";
    for (let version = 0; !first?.state; version = first.status.version) first = await news(null, version);
    const { header, table, state } = first.state;
    header.states[0].own_walls = header.walls;
    header.live = true;
    return { header, table, states: [state] };
  });
  window.live = new Live(window.viewer, first);
}
