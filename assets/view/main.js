"use strict";
// What the user does, and what is shown for it.

const KEYS = [
  ["Space", "play, or stop"], ["← →", "the state before, the state after"], ["Home End", "the first state, the last state"],
  ["< >", "slower, faster"], ["C", "the next colour; with Shift the one before"], ["1 2 3 4", "from the top, front, right, obliquely"],
  ["Shift + arrows", "turn"], ["[ ]", "turn in the plane of the picture"], ["W A S D", "move"], ["+ −", "enlarge, reduce"], ["R", "fit the picture"],
  ["F", "move the picked body to the middle"], ["Esc", "pick no body"], ["G", "walls and cell on or off"], ["X", "shadows on or off"],
  ["T", "dark or light"], ["H", "these keys"],
];
const SPEEDS = [1, 2, 5, 10, 25, 50];
/** Linear light of the paper, and the colours of lines, by theme. */
const THEMES = {
  light: { paper: light([1, 0, 0]), wall: [0.25, 0.25, 0.3, 0.9], accent: light([0.5, 0.2, 0.06]), line: [0.7, 0, 0.23, 1] },
  dark: { paper: light([0.17, 0, -0.015]), wall: [0.75, 0.75, 0.8, 0.9], accent: light([0.78, 0.15, 0.05]), line: [1, 0.49, 0.61, 1] },
};
/** After this many milliseconds without motion the picture is drawn finely. */
const REST = 150;

class Viewer {
  constructor(run) {
    this.run = run;
    this.canvas = byId("picture");
    this.painter = new Painter(this.canvas);
    this.camera = new Camera();
    this.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
    this.colour = run.header.quantities.findIndex((quantity) => quantity.name === run.header.colour);
    this.picked = -1;
    this.walls = true;
    this.shadows = true;
    this.planar = run.header.planar;
    const { walls, periods, states } = run.header;
    const bounded = walls.length > 0 || periods.some((period) => period !== null);
    const all = bounded ? extentOf(SIDES.top, run.states) : null;
    this.all = all;
    this.wall_ends = this.wallsAt(run.header.states[0]);
    this.cell_ends = this.cellAt(run.header.states[0]);
    // The picture is fitted to those that end.
    const moving = states.some((state) => state.walls || state.periods) ? states : states.slice(0, 1);
    const closed = walls.map((wall, k) => k).filter((k) => isClosed(walls[k]));
    this.framed = moving.flatMap((state) => closed.flatMap((k) => this.wallsAt(state, k)).concat(this.cellAt(state)));
    this.build();
    this.setTheme(this.theme);
    this.show(run.states.length - 1);
    this.look(this.planar ? "top" : "oblique");
  }

  build() {
    const { header, states } = this.run;
    document.title = `${header.name} – relcp`;
    byId("name").textContent = header.name;
    header.quantities.forEach(({ name, text, missing }, k) => {
      const option = made("option", missing ? `${name} (not there)` : name);
      Object.assign(option, { value: k, disabled: missing !== null, title: missing ?? text });
      byId("colour").append(option);
    });
    SPEEDS.forEach((speed) => byId("speed").append(Object.assign(made("option", `${speed} /s`), { value: speed })));
    byId("speed").value = SPEEDS.find((speed) => speed >= states.length / 10) ?? 50;
    byId("at").max = states.length - 1;
    byId("key-table").append(...KEYS.map(([key, what]) => made("tr", null, [made("td", null, [made("kbd", key)]), made("td", what)])));
    byId("walls").hidden = !this.wall_ends.length && !this.cell_ends.length;
    byId("measures").hidden = !header.steps;
    if (header.steps) byId("plot-note").textContent = header.steps.note;
    showAbout(header);
    this.listen();
  }

  listen() {
    const on = (id, event, act) => byId(id).addEventListener(event, act);
    on("play", "click", () => this.play(!this.playing));
    on("at", "input", (event) => { this.play(false); this.show(Number(event.target.value)); });
    on("colour", "change", (event) => this.setColour(Number(event.target.value)));
    on("fit", "change", () => this.setColour(this.colour));
    on("view", "change", (event) => { if (event.target.value) this.look(event.target.value); });
    on("reset", "click", () => this.look());
    on("walls", "click", () => this.toggleWalls());
    on("theme", "click", () => this.setTheme(this.theme === "dark" ? "light" : "dark"));
    on("help", "click", () => byId("keys").showModal());
    on("plot", "click", (event) => this.showNearest(timeAt(this.run.header.steps, event.offsetX / event.target.clientWidth)));
    new ResizeObserver(() => this.request()).observe(this.canvas);
    new ResizeObserver(() => this.replot()).observe(byId("side"));
    document.addEventListener("keydown", (event) => this.key(event));
    this.canvas.addEventListener("webglcontextlost", () => fail(new Error("the browser has taken the graphics away; load the page again")));
    listenToPointers(this, this.canvas);
  }

  get state() {
    return this.run.states[this.at];
  }

  show(at) {
    this.at = Math.min(Math.max(at, 0), this.run.states.length - 1);
    const { state } = this;
    byId("at").value = this.at;
    byId("at").setAttribute("aria-valuetext", `time ${shown(state.time)}`);
    byId("state").textContent = `${this.at + 1} of ${this.run.states.length}, step ${state.step}`;
    byId("caption").textContent = `t = ${shown(state.time, 6)}   n = ${state.bodies}`;
    this.wall_ends = this.wallsAt(this.run.header.states[this.at]);
    this.cell_ends = this.cellAt(this.run.header.states[this.at]);
    this.painter.setState(state);
    this.setColour(this.colour);
    this.setPicked(this.picked);
    this.replot();
  }

  showNearest(time) {
    const far = this.run.states.map((state) => Math.abs(state.time - time));
    this.play(false);
    this.show(far.indexOf(Math.min(...far)));
  }

  play(on) {
    clearInterval(this.playing);
    this.playing = undefined;
    if (on) {
      if (this.at === this.run.states.length - 1) this.show(0);
      let last = performance.now();
      // A timer that is late takes more states at once.
      this.playing = setInterval(() => {
        const each = 1000 / Number(byId("speed").value);
        const due = Math.floor((performance.now() - last) / each);
        if (due < 1) return;
        last += due * each;
        this.show(this.at + due);
        if (this.at === this.run.states.length - 1) this.play(false);
      }, 15);
    }
    byId("play").textContent = this.playing ? "❚❚" : "▶";
    byId("play").setAttribute("aria-label", this.playing ? "Stop" : "Play");
  }

  setColour(index) {
    this.colour = index;
    const quantity = this.run.header.quantities[index];
    byId("colour").value = index;
    const { state } = this;
    const parts = new Float32Array(state.bodies).fill(-1);
    let [scale, note] = [quantity.scale, quantity.kind === "cyclic" ? "of the axis in the x-y plane; pale out of it" : ""];
    if (quantity.kind === "sequential") {
      const values = valuesOf(this.run, state, quantity.name);
      if (byId("fit").value === "each") scale = state.scales[quantity.name] ?? scale;
      if (values) {
        const [low, high] = scale;
        values.forEach((value, i) => { parts[i] = high > low ? Math.min(Math.max((value - low) / (high - low), 0), 1) : 0; });
      } else {
        note = state.missing[quantity.name] ?? "not known in this state";
      }
    }
    this.painter.setParts(parts);
    drawLegend(quantity, scale, note);
    this.request();
  }

  nextColour(way) {
    const { quantities } = this.run.header;
    let next = this.colour;
    do next = (next + way + quantities.length) % quantities.length; while (quantities[next].missing);
    this.setColour(next);
  }

  /** Picks a body by its row in the table of all bodies; -1 for none. */
  setPicked(row) {
    this.picked = row;
    showPicked(this.run, this.state, row, (other) => this.setPicked(other));
    this.picked_row = row < 0 ? -1 : this.state.list.indexOf(row);
    this.contact_lines = this.picked_row < 0 ? [] : this.forceLines(this.picked_row);
    this.request();
  }

  pickAt(x, y) {
    const row = this.painter.bodyAt(x, y);
    this.setPicked(row < 0 ? -1 : this.state.list[row]);
  }

  /** Lines from the body's centre over its contacts to the others' centres, the thicker the harder they push. */
  forceLines(i) {
    const { state } = this;
    const centre = (k) => Array.from(state.place.subarray(3 * k, 3 * k + 3));
    const found = contactsOf(state, i);
    const most = found.reduce((a, { force }) => Math.max(a, force || 0), 0);
    return found.map(({ other, force, point }) => {
      const near = this.nearest(point, centre(i));
      const ends = [...centre(i), ...near];
      if (other < state.bodies) ends.push(...near, ...this.nearest(centre(other), near));
      return { ends, ink: THEMES[this.theme].line, width: most > 0 ? 1.5 + 6 * (force || 0) / most : 2, behind: 0.9 };
    });
  }

  /** The image of a point that is nearest to another one. */
  nearest(point, to) {
    const state = this.run.header.states[this.at];
    const [along, across, offset] = state.tilt ?? [0, 0, 0];
    const periods = this.periodsAt(state);
    const turns = offset ? Math.round((point[across] - to[across]) / periods[across]) : 0;
    return point.map((x, k) => {
      const period = periods[k];
      const from = k === along ? x - turns * offset : x;
      return period === null ? x : from - period * Math.round((from - to[k]) / period);
    });
  }

  look(side = byId("view").value) {
    byId("view").value = side;
    const axes = SIDES[side] ?? this.camera.axes;
    const extent = extentOf(axes, this.run.states);
    if (this.walls) stretch(extent, axes, this.framed);
    this.camera.fit(axes, extent, this.canvas.clientWidth, this.canvas.clientHeight);
    this.request();
  }

  /** Turns the bodies; the picture then shows no side any more. */
  turn(right, down, roll = 0) {
    if (roll) this.camera.roll(roll);
    else this.camera.orbit(right, down);
    byId("view").value = "";
    this.request();
  }

  /** The lines of the walls, or of one of them, in a state. */
  wallsAt(state, only = null) {
    const { origin } = this.run.header;
    // Walls of a run that goes on may be changed.
    const walls = state?.own_walls ?? this.run.header.walls;
    return walls.flatMap((wall, k) => only === null || only === k ? placedWallLines(wall, state?.walls?.[k], this.planar, this.all, origin) : []);
  }

  /** The periods of space in a state, and the lines of its cell. */
  periodsAt(state) {
    return state?.periods ?? this.run.header.periods;
  }

  cellAt(state) {
    return cellLines(this.periodsAt(state), this.planar, this.all, this.run.header.origin);
  }

  toggleWalls() {
    this.walls = !this.walls;
    byId("walls").setAttribute("aria-pressed", String(this.walls));
    this.request();
  }

  setTheme(theme) {
    this.theme = theme;
    document.documentElement.classList.toggle("dark", theme === "dark");
    byId("theme").textContent = theme === "dark" ? "Light" : "Dark";
    if (this.at !== undefined) {
      this.setPicked(this.picked);
      this.replot();
    }
  }

  replot() {
    if (!this.run.header.steps || this.at === undefined) return;
    const style = getComputedStyle(document.documentElement);
    const ink = Object.fromEntries(["ink", "soft", "line", "accent"].map((name) => [name, style.getPropertyValue(`--${name}`)]));
    drawPlot(this.run.header.steps, this.state.time, ink);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || byId("keys").open) return;
    // A focused control keeps its own keys.
    const { tagName } = event.target;
    if (tagName === "SELECT" || (tagName === "INPUT" && event.target.type !== "range")) return;
    if ((tagName === "INPUT" && /^(Arrow|Home|End|Page)/.test(event.key))) return;
    if ((tagName === "BUTTON" || tagName === "SUMMARY") && (event.key === " " || event.key === "Enter")) return;
    const act = this.actionOf(event);
    if (!act) return;
    event.preventDefault();
    act();
  }

  actionOf({ key, shiftKey }) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[key];
    if (way) return shiftKey ? () => this.turn(20 * way[0], 20 * way[1]) : way[0] ? () => { this.play(false); this.show(this.at + way[0]); } : null;
    if (this.more_keys?.[key]) return this.more_keys[key];
    const moves = { w: [0, 40], s: [0, -40], a: [40, 0], d: [-40, 0] }[key];
    if (moves) return () => { this.camera.pan(...moves); this.request(); };
    const speed = (by) => {
      const at = SPEEDS.indexOf(Number(byId("speed").value)) + by;
      if (SPEEDS[at]) byId("speed").value = SPEEDS[at];
    };
    const zoom = (factor) => { this.camera.zoom(factor); this.request(); };
    return {
      " ": () => this.play(!this.playing), Home: () => this.show(0), End: () => this.show(this.run.states.length - 1),
      c: () => this.nextColour(1), C: () => this.nextColour(-1), r: () => this.look(), g: () => this.toggleWalls(),
      1: () => this.look("top"), 2: () => this.look("front"), 3: () => this.look("right"), 4: () => this.look("oblique"),
      "+": () => zoom(1.25), "=": () => zoom(1.25), "-": () => zoom(0.8), "<": () => speed(-1), ">": () => speed(1),
      "[": () => this.turn(0, 0, -0.1), "]": () => this.turn(0, 0, 0.1), Escape: () => this.setPicked(-1), f: () => this.focus(),
      x: () => { this.shadows = !this.shadows; this.request(); }, t: () => this.setTheme(this.theme === "dark" ? "light" : "dark"),
      h: () => byId("keys").showModal(), "?": () => byId("keys").showModal(),
    }[key];
  }

  focus() {
    if (this.picked_row < 0) return;
    this.camera.middle = Array.from(this.state.place.subarray(3 * this.picked_row, 3 * this.picked_row + 3));
    this.request();
  }

  /** Draws soon, and finely when nothing has moved for a while. */
  request() {
    clearTimeout(this.resting);
    if (this.drawing) return;
    this.drawing = requestAnimationFrame(() => {
      this.drawing = undefined;
      this.draw(false);
      // Only now: a slow browser has waited longer than that for this frame, and the coarse picture would come last.
      this.resting = setTimeout(() => this.draw(true), this.playing ? 10 * REST : REST);
    });
  }

  draw(fine) {
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    const size = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(Math.round(side * ratio), 1));
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    const theme = THEMES[this.theme];
    const wall = (ends) => ({ ends: this.walls ? ends : [], ink: theme.wall, width: 1.5, behind: 0.25 });
    const { kind } = this.run.header.quantities[this.colour];
    this.painter.draw({
      camera: this.camera, colour: { sequential: 0, cyclic: 1, none: 2 }[kind], planar: this.planar, paper: theme.paper, accent: theme.accent,
      picked: this.picked_row, shadows: this.shadows, lines: [wall(this.wall_ends), wall(this.cell_ends), ...this.contact_lines],
    }, fine);
    drawBar(this.camera.scale, canvas.clientWidth);
    this.drawn_finely = fine;
  }
}

/** Makes an extent along these axes hold lines too. */
function stretch([low, high], axes, ends) {
  for (let i = 0; i < ends.length; i += 3) {
    axes.forEach((axis, k) => {
      const at = dot(axis, ends.slice(i, i + 3));
      low[k] = Math.min(low[k], at);
      high[k] = Math.max(high[k], at);
    });
  }
}

function fail(error) {
  const busy = byId("busy");
  busy.hidden = false;
  busy.textContent = `This run cannot be shown: ${error.message}.`;
}

/** Shows the run that `read` gives, telling how far it is. */
async function start(read) {
  try {
    if (!window.DecompressionStream) throw new Error("this browser is too old to unpack it; see the list of browsers in docs/view.md");
    const run = await read((done, all) => {
      byId("busy").textContent = `reading state ${done + 1} of ${all}`;
    });
    byId("busy").hidden = true;
    const unpacked = performance.now();
    const viewer = new Viewer(run);
    viewer.draw(false);
    // Milliseconds since the page was asked for.
    viewer.opened = { read: unpacked, drawn: performance.now() };
    window.viewer = viewer;
  } catch (error) {
    fail(error);
    throw error;
  }
}
