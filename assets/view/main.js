"use strict";
// What the user does, and what is shown for it.

const KEYS = [
  ["Space", "play, or stop"], ["← →", "the state before, the state after"], ["Home End", "the first state, the last state"],
  ["< >", "slower, faster"], ["C", "the next colour; with Shift the one before"], ["1 2 3 4", "from the top, front, right, obliquely"],
  ["Shift + arrows", "turn"], ["[ ]", "turn in the plane of the picture"], ["W A S D", "move"], ["+ −", "enlarge, reduce"], ["R", "fit the picture"],
  ["F", "move the picked body to the middle"], ["J K L O", "axes, velocities, trails, bonds on or off"],
  ["E Z", "perspective, haze on or off"], ["Esc", "pick no body"], ["G", "walls and cell on or off"], ["X", "shadows on or off"],
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
/** Pictures that take more milliseconds are slow. */
const SLOW = 40;

class Viewer {
  constructor(run) {
    this.run = run;
    this.canvas = byId("picture");
    this.painter = new Painter(this.canvas);
    this.camera = new Camera();
    this.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
    run.header.quantities.push(...OWN_HUES.filter(({ name }) => name === "body" || run.header.live || run.table.hasParent.some((has) => has)));
    const asked = run.header.colour ?? tellingColour(run);
    this.colour = Math.max(run.header.quantities.findIndex((quantity) => quantity.name === asked), 0);
    this.picked = -1;
    this.shows = { walls: true, shadows: true, axes: false, ways: false, trails: false, bonds: run.header.bonded, perspective: false, haze: false };
    /** Groups that are hidden, and the part of the run's depth that is not cut off. */
    this.hidden = new Set();
    this.cut_part = 1;
    this.planar = run.header.planar;
    const { walls, periods, states } = run.header;
    const bounded = walls.length > 0 || periods.some((period) => period !== null);
    const all = bounded || !this.planar ? extentOf(SIDES.top, run.states) : null;
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
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    // A run is seen once from its start, unless a link names a time.
    if (!follow(this, location.hash) && run.states.length > 1 && !still) this.play(true);
    window.addEventListener("hashchange", () => { this.play(false); follow(this, location.hash); });
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
    this.buildShown();
    showGroups(this);
    byId("measures").hidden = !header.steps && !header.measures;
    this.curves = new Set((header.measures?.curves ?? []).slice(0, MOST_CURVES).map(([name]) => name));
    showCurves(this);
    byId("plot").hidden = !header.steps;
    if (header.steps) byId("plot-note").textContent = header.steps.note;
    showAbout(header);
    showParameters(header);
    this.listen();
  }

  /** Buttons for what may be laid over the bodies, and how they are seen. */
  buildShown() {
    const { header, states } = this.run;
    const more = { perspective: ["Perspective", "what is near is larger"], haze: ["Haze", "what is far is paler"] };
    const offered = {
      axes: true, ways: states.length > 1 || header.live, trails: states.length > 1 || header.live, bonds: header.bonded,
      perspective: !this.planar, haze: !this.planar,
    };
    this.show_buttons = new Map();
    for (const [name, [text, title]] of Object.entries({ ...OVERLAYS, ...more })) {
      const button = Object.assign(made("button", text), { title });
      button.hidden = !offered[name];
      button.addEventListener("click", () => this.setShown(name, !this.shows[name]));
      byId("shown").append(button);
      this.show_buttons.set(name, button);
    }
    for (const name of this.show_buttons.keys()) this.setShown(name, this.shows[name]);
    byId("cut-row").hidden = this.planar;
  }

  setShown(name, on) {
    this.shows[name] = on;
    (name === "walls" ? byId("walls") : this.show_buttons.get(name))?.setAttribute("aria-pressed", String(on));
    this.overlaid = null;
    this.request();
  }

  /** Hides the bodies of a group, or shows them again; -1 are those without one. */
  hide(group, on) {
    if (on) this.hidden.add(group);
    else this.hidden.delete(group);
    showGroups(this);
    this.overlaid = null;
    this.setColour(this.colour);
  }

  isHidden(i) {
    if (!this.hidden.size && this.cut_part >= 1) return false;
    const { state } = this;
    const group = this.run.table.group[state.list[i]];
    if (this.hidden.has(group === 0xffffffff ? -1 : group)) return true;
    return this.cut_part < 1 && dot(this.cut, centreOf(state, i)) > this.cut[3];
  }

  /** Cuts off what is nearer to the viewer than a part of the run's depth, from the look of this moment on. */
  setCut(part) {
    this.cut_part = Math.min(Math.max(part, 0), 1);
    byId("cut").value = Math.round(1000 * this.cut_part);
    const toward = this.camera.axes[2];
    const [[, , low], [, , high]] = extentOf(this.camera.axes, [this.state]);
    this.cut = this.cut_part >= 1 ? null : [...toward, low + this.cut_part * (high - low)];
    this.overlaid = null;
    this.request();
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
    on("cut", "input", (event) => this.setCut(Number(event.target.value) / 1000));
    const keep = (act) => act(this).catch((error) => { byId("kept").textContent = error.message; });
    on("save-picture", "click", () => keep(savePicture));
    on("save-movie", "click", () => keep(saveMovie));
    on("link", "click", () => {
      location.replace(linkOf(this));
      byId("kept").textContent = "The address of this page now has camera, time, colour and pick.";
      navigator.clipboard?.writeText(location.href).then(() => { byId("kept").textContent += " It is copied."; }, () => {});
    });
    on("plot-measures", "click", (event) => this.showNearest(timeAt(this.run.header.measures, event.offsetX / event.target.clientWidth)));
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
    this.overlaid = null;
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
    if (quantity.kind === "hue") {
      parts.set(huesOf(this.run, state, quantity.name));
      note = quantity.text;
    }
    const { group } = this.run.table;
    if (this.hidden.size) for (let i = 0; i < state.bodies; i++) {
      const of = group[state.list[i]];
      if (this.hidden.has(of === 0xffffffff ? -1 : of)) parts[i] = -2;
    }
    this.painter.setParts(parts);
    drawLegend(quantity, scale, note);
    showGroups(this);
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
    this.hands?.tell();
    this.request();
  }

  pickAt(x, y) {
    if (this.hands?.click(x, y)) return;
    const row = this.painter.bodyAt(x, y);
    this.setPicked(row < 0 ? -1 : this.state.list[row]);
  }

  /** The place that is seen at a place of the page. */
  pointAt(x, y) {
    const { camera, canvas } = this;
    const height = this.painter.heightAt(x, y);
    const scale = camera.scale * this.largerAt(height);
    const [right, up] = [(x - canvas.clientWidth / 2) / scale, (canvas.clientHeight / 2 - y) / scale];
    return plus(plus(plus(camera.middle, camera.axes[0], right), camera.axes[1], up), camera.axes[2], height);
  }

  /** By how much a perspective enlarges what is at a height. */
  largerAt(height) {
    const { distance } = this.painter;
    return distance > 0 ? distance / (distance - height) : 1;
  }

  /** Pixels of the page to a length of one at a place. */
  scaleAt(place) {
    return this.camera.scale * this.largerAt(dot(plus(place, this.camera.middle, -1), this.camera.axes[2]));
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
    if (this.shows.walls) stretch(extent, axes, this.framed);
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
    return walls.flatMap((wall, k) => only === null || only === k ? placedWall(wallLines, wall, state?.walls?.[k], this.planar, this.all, origin) : []);
  }

  /** The walls of this state as triangles with normals; found once. */
  surfaces() {
    if (this.planar) return [];
    const state = this.run.header.states[this.at];
    if (this.surfaced?.state !== state) {
      const walls = state?.own_walls ?? this.run.header.walls;
      const triangles = walls.flatMap((wall, k) => placedWall(wallTriangles, wall, state?.walls?.[k], this.planar, this.all, this.run.header.origin));
      this.surfaced = { state, corners: withNormals(triangles) };
    }
    return this.surfaced.corners;
  }

  /** The periods of space in a state, and the lines of its cell. */
  periodsAt(state) {
    return state?.periods ?? this.run.header.periods;
  }

  cellAt(state) {
    return cellLines(this.periodsAt(state), this.planar, this.all, this.run.header.origin);
  }

  toggleWalls() {
    this.setShown("walls", !this.shows.walls);
  }

  /** The lines that lie over the bodies, found once for each state. */
  overlays() {
    const key = JSON.stringify([this.at, this.picked, this.shows, this.shows.ways ? this.camera.axes[2] : 0]);
    if (this.overlaid?.key !== key) {
      const theme = THEMES[this.theme];
      const inks = { axes: [theme.wall, 1.5, 0], ways: [theme.line, 1.5, 0.5], trails: [theme.wall, 1, 0.35], bonds: [theme.line, 3, 0.5] };
      const shown = Object.keys(OVERLAYS).filter((name) => this.shows[name] && !this.show_buttons.get(name).hidden);
      // A line inside of its own body is seen all the same in a planar run.
      const lines = shown.map((name) => ({ ends: OVERLAYS[name][2](this), ink: inks[name][0], width: inks[name][1], behind: Math.max(inks[name][2], name === "axes" ? 0.9 : 0) }));
      this.overlaid = { key, lines };
    }
    return this.overlaid.lines;
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
    const { steps, measures } = this.run.header;
    if ((!steps && !measures) || this.at === undefined) return;
    const style = getComputedStyle(document.documentElement);
    const ink = Object.fromEntries(["ink", "soft", "line", "accent"].map((name) => [name, style.getPropertyValue(`--${name}`)]));
    const shown = (measures?.curves ?? []).filter(([name]) => this.curves.has(name));
    byId("plot-measures").hidden = !shown.length;
    if (shown.length) drawPlot(byId("plot-measures"), measures, shown, this.state.time, ink);
    if (steps) drawPlot(byId("plot"), steps, CURVES, this.state.time, ink);
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
      " ": () => this.play(!this.playing), Home: () => { this.play(false); this.show(0); }, End: () => { this.play(false); this.show(this.run.states.length - 1); },
      c: () => this.nextColour(1), C: () => this.nextColour(-1), r: () => this.look(), g: () => this.toggleWalls(),
      1: () => this.look("top"), 2: () => this.look("front"), 3: () => this.look("right"), 4: () => this.look("oblique"),
      "+": () => zoom(1.25), "=": () => zoom(1.25), "-": () => zoom(0.8), "<": () => speed(-1), ">": () => speed(1),
      "[": () => this.turn(0, 0, -0.1), "]": () => this.turn(0, 0, 0.1), Escape: () => this.setPicked(-1), f: () => this.focus(),
      j: () => this.setShown("axes", !this.shows.axes), k: () => this.setShown("ways", !this.shows.ways),
      l: () => this.setShown("trails", !this.shows.trails), o: () => this.setShown("bonds", !this.shows.bonds),
      e: () => this.setShown("perspective", !this.shows.perspective), z: () => this.setShown("haze", !this.shows.haze),
      x: () => this.setShown("shadows", !this.shows.shadows), t: () => this.setTheme(this.theme === "dark" ? "light" : "dark"),
      h: () => byId("keys").showModal(), "?": () => byId("keys").showModal(),
    }[key];
  }

  focus() {
    if (this.picked_row < 0) return;
    this.camera.middle = Array.from(this.state.place.subarray(3 * this.picked_row, 3 * this.picked_row + 3));
    this.request();
  }

  /** Draws soon, and finely when nothing has moved for a while. Where drawing is slow, the next picture waits for the last one. */
  request() {
    clearTimeout(this.resting);
    this.resting = undefined;
    this.asked = true;
    if (this.drawing) return;
    this.drawing = requestAnimationFrame(() => {
      this.asked = false;
      this.draw(false);
      this.painter.drawn().then((took) => {
        this.took = took;
        if (this.slow) this.next();
      });
      this.slow = this.took > SLOW;
      if (!this.slow) this.next();
    });
  }

  next() {
    this.drawing = undefined;
    if (this.asked) return this.request();
    // Only now: a slow browser has waited longer than that for this frame, and the coarse picture would come last.
    this.resting = setTimeout(() => {
      this.resting = undefined;
      this.draw(true);
    }, this.playing ? 10 * REST : Math.max(REST, this.took ?? 0));
    return undefined;
  }

  draw(fine) {
    const { canvas } = this;
    const ratio = window.devicePixelRatio || 1;
    const size = [canvas.clientWidth, canvas.clientHeight].map((side) => Math.max(Math.round(side * ratio), 1));
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    const theme = THEMES[this.theme];
    const faint = theme.wall.map((part, k) => (k === 3 && !this.planar ? 0.45 * part : part));
    const wall = (ends, ink = theme.wall) => ({ ends: this.shows.walls ? ends : [], ink, width: 1.5, behind: 0.25 });
    const { kind } = this.run.header.quantities[this.colour];
    this.painter.draw({
      camera: this.camera, colour: { sequential: 0, cyclic: 1, none: 2, hue: 3 }[kind], planar: this.planar, paper: theme.paper, accent: theme.accent,
      picked: this.picked_row, shadows: this.shows.shadows, perspective: this.shows.perspective, haze: this.shows.haze, cut: this.cut,
      surfaces: { corners: this.shows.walls ? this.surfaces() : [], ink: theme.wall.slice(0, 3) },
      lines: [wall(this.wall_ends, faint), wall(this.cell_ends), ...this.overlays(), ...this.contact_lines, ...(this.more_lines?.() ?? [])],
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
    await viewer.painter.drawn();
    // Milliseconds since the page was asked for.
    viewer.opened = { read: unpacked, drawn: performance.now() };
    window.viewer = viewer;
  } catch (error) {
    fail(error);
    throw error;
  }
}
