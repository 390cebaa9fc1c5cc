"use strict";
// Hands: a body of a run that goes on is dragged with a spring, bodies are placed and removed while it pauses. What is
// done here becomes `changes` of the scene; src/cli/live/routes.rs answers.

/** Milliseconds between two places of a hand that are told: each is one of the scene's changes. */
const HAND_EACH = 100;
/** A hand that does not move says so often that it is there. */
const HAND_IS_THERE = 1000;

class Hands {
  constructor(live) {
    this.live = live;
    this.viewer = live.viewer;
    this.held = null;
    this.tool = "look";
    this.viewer.hands = this;
    this.viewer.more_lines = () => this.lines();
    this.build();
  }

  build() {
    const tools = [["look", "Look", "V", "a drag turns or moves the picture"], ["drag", "Drag bodies", "B", "a drag pulls a body with a spring"],
      ["place", "Place", "I", "a click places a body, while the run pauses"]];
    this.buttons = new Map(tools.map(([tool, text, key, title]) => {
      const button = Object.assign(made("button", text), { title: `${title} (${key})`, type: "button" });
      button.addEventListener("click", () => this.use(tool));
      this.viewer.more_keys[key.toLowerCase()] = () => this.use(tool);
      return [tool, button];
    }));
    this.shape = made("select", null, ["as the picked one", "ball", "rod", "ellipsoid", "ring"].map((text) => made("option", text)));
    this.shape.setAttribute("aria-label", "What is placed");
    this.shape.value = "ball";
    this.take = Object.assign(made("button", "Remove"), { title: "the picked body, while the run pauses (Delete)", type: "button" });
    this.take.addEventListener("click", () => this.remove());
    this.viewer.more_keys.Delete = () => this.remove();
    this.row = made("div", null, [...this.buttons.values(), this.shape, this.take]);
    this.row.className = "row";
    this.live.said.before(this.row);
    const keys = tools.map(([, , key, title]) => [key, title]).concat([["Delete", "remove the picked body, while the run pauses"]]);
    byId("key-table").append(...keys.map(([key, what]) => made("tr", null, [made("td", null, [made("kbd", key)]), made("td", what)])));
    this.use("look");
  }

  use(tool) {
    this.tool = tool;
    for (const [name, button] of this.buttons) button.setAttribute("aria-pressed", String(name === tool));
    this.viewer.canvas.style.cursor = { drag: "pointer", place: "crosshair" }[tool] ?? "";
    this.tell();
  }

  /** Shows what can be done now. */
  tell() {
    const { phase } = this.live.status;
    const over = phase === "ended" || phase === "saving";
    this.buttons.get("drag").disabled = over;
    this.buttons.get("place").disabled = this.shape.disabled = phase !== "paused";
    this.take.disabled = phase !== "paused" || this.viewer.picked_row < 0 || !this.newest();
  }

  newest() {
    return this.viewer.at === this.viewer.run.states.length - 1;
  }

  /** A press on the picture; whether it is a hand's. */
  press([x, y]) {
    if (this.tool !== "drag" || this.held || !this.newest()) return false;
    const { viewer } = this;
    const i = viewer.painter.bodyAt(x, y);
    if (i < 0) return false;
    const { state } = viewer;
    const [centre, turn] = [3, 4].map((n) => Array.from((n === 3 ? state.place : state.turn).subarray(n * i, n * i + n)));
    // The point that is seen, or in a planar run the one in the plane.
    const seen = viewer.pointAt(x, y);
    if (viewer.planar) seen[2] = centre[2];
    const row = state.list[i];
    this.held = { row, id: viewer.run.table.ids[row], point: rotated(turn, plus(seen, centre, -1), true), start: seen, from: [x, y], target: seen };
    viewer.setPicked(row);
    this.pull();
    return true;
  }

  move([x, y]) {
    const { held } = this;
    if (!held) return;
    const { camera, planar } = this.viewer;
    const [right, down] = [x - held.from[0], y - held.from[1]].map((pixels) => pixels / this.viewer.scaleAt(held.start));
    held.target = plus(plus(held.start, camera.axes[0], right), camera.axes[1], -down);
    if (planar) held.target[2] = held.start[2];
    this.viewer.request();
  }

  release() {
    if (this.held) this.held.over = true;
  }

  /** Tells where the hand is until it lets go. */
  async pull() {
    const { held } = this;
    const { origin } = this.viewer.run.header;
    let [last, told] = ["", 0];
    while (!held.over && !held.refused) {
      const target = plus(held.target, origin);
      const text = JSON.stringify(target);
      if (text !== last || performance.now() - told > HAND_IS_THERE) {
        [last, told] = [text, performance.now()];
        held.refused = !await this.live.post("hand", { body: held.id, point: held.point, target });
      }
      await new Promise((go) => setTimeout(go, HAND_EACH));
    }
    if (!held.refused) {
      // The last place counts, also of a quick hand.
      const target = plus(held.target, origin);
      if (JSON.stringify(target) !== last) await this.live.post("hand", { body: held.id, point: held.point, target });
      await this.live.post("hand", { body: held.id });
    }
    this.held = null;
    this.viewer.request();
  }

  /** The spring. */
  lines() {
    const { held, viewer } = this;
    const i = held ? viewer.state.list.indexOf(held.row) : -1;
    if (i < 0) return [];
    const { place, turn } = viewer.state;
    const from = plus(Array.from(place.subarray(3 * i, 3 * i + 3)), rotated(turn.subarray(4 * i, 4 * i + 4), held.point));
    return [{ ends: [...from, ...held.target], ink: THEMES[viewer.theme].line, width: 3, behind: 0.9 }];
  }

  /** A click on the picture; whether it places a body. */
  click(x, y) {
    if (this.tool !== "place" || this.live.status.phase !== "paused") return false;
    const { viewer } = this;
    const { camera, planar } = viewer;
    const [right, down] = [x - viewer.canvas.clientWidth / 2, y - viewer.canvas.clientHeight / 2].map((pixels) => pixels / camera.scale);
    let at = plus(plus(camera.middle, camera.axes[0], right), camera.axes[1], -down);
    if (planar) {
      // Where the line of sight meets the plane.
      const toward = camera.axes[2];
      const plane = viewer.state.bodies ? viewer.state.place[2] : 0;
      if (Math.abs(toward[2]) > 0.05) at = plus(at, toward, (plane - at[2]) / toward[2]);
      at[2] = plane;
    }
    this.live.post("bodies", { add: [{ ...this.body(), position: plus(at, viewer.run.header.origin) }] });
    return true;
  }

  /** What is placed, without its place. */
  body() {
    const { viewer } = this;
    const { state, planar } = viewer;
    const size = viewer.painter.thickness || 1;
    const flat = ([x, y]) => (planar ? (Math.hypot(x, y) > 0 ? [x, y, 0] : [1, 0, 0]) : null);
    const across = flat(viewer.camera.axes[0]) ?? viewer.camera.axes[0];
    const kind = this.shape.value;
    if (kind === "as the picked one" && viewer.picked_row >= 0) {
      const i = viewer.picked_row;
      const [of, a, b, c] = Array.from(state.shape.subarray(4 * i, 4 * i + 4), (x) => Number(x.toPrecision(7)));
      const [x, y, z, w] = state.turn.subarray(4 * i, 4 * i + 4);
      const shape = [{ sphere: { radius: b } }, { spherocylinder: { diameter: 2 * b, length: 2 * (a + b) } },
        { torus: { major_radius: a, minor_radius: b } }, { ellipsoid: { radii: [a, b, c] } }][of]
        ?? { superellipsoid: { radii: [a, b, c], exponents: exponentsOf(state.shape[4 * i]) } };
      const axis = rotated([x, y, z, w], [0, 0, 1]);
      // A planar scene's bodies are mirrored by its plane, to more digits than the page has.
      const turned = !planar ? { orientation: [w, x, y, z] } : { axis: Math.abs(axis[2]) > 0.5 ? [0, 0, 1] : flat(axis) };
      const group = viewer.run.header.groups[viewer.run.table.group[state.list[i]]];
      return { shape, ...turned, ...(group ? { group } : {}) };
    }
    if (kind === "rod") return { shape: { spherocylinder: { diameter: size, length: 3 * size } }, axis: across };
    if (kind === "ellipsoid") return { shape: { ellipsoid: { radii: [size / 2, size / 2, size] } }, axis: across };
    if (kind === "ring") return { shape: { torus: { major_radius: 3 * size, minor_radius: size / 2 } }, axis: viewer.camera.axes[2] };
    return { shape: { sphere: { radius: size / 2 } } };
  }

  remove() {
    const { viewer } = this;
    if (this.live.status.phase !== "paused" || viewer.picked_row < 0) return;
    this.live.post("bodies", { remove: [viewer.run.table.ids[viewer.picked]] });
  }
}
