"use strict";
// Drawing with WebGL 2. First each body casts the rays of its rectangle (body.frag) into a picture of numbers, then
// these are
// lit (shade.frag), then lines are laid over them (line.frag).

/** Half the width of a shadow's soft edge, in thicknesses of a middling body, and in samples at the least. */
const SOFTNESS = 0.10;
const LEAST_SOFTNESS = 1.5;
/** A middling body's thickness in pixels from which shadows are worth their time. */
const SHADOW_FROM = 1.5;
/** Samples along a side of the light's picture. */
const SHADOW_SIDE = 2048;
/** Bodies in a row of the tables that the vertices read. */
const TABLE_WIDTH = 1024;
/** Beyond so many bodies a picture in motion has no shadows. */
const SHADOWS_IN_MOTION = 20000;
/** How far the eye of a perspective is, in halves of the picture's longer side. */
const EYE = 4;
/** How much of the farthest is lost in haze, where that is on. */
const HAZE = 0.75;
/** Where the main light comes from, along right, up and toward. */
const KEY_LIGHT = unit([-0.46, 0.60, 0.655]);

class Painter {
  constructor(canvas) {
    const options = { antialias: false, alpha: false, depth: false, preserveDrawingBuffer: true, powerPreference: "high-performance" };
    const gl = canvas.getContext("webgl2", options);
    if (!gl) throw new Error("this browser has no WebGL 2, or it is switched off");
    this.gl = gl;
    this.canvas = canvas;
    this.conservative = Boolean(gl.getExtension("EXT_conservative_depth"));
    this.of_bodies = new Map();
    this.shade = program(gl, SHADERS["shade.vert"], SHADERS["shade.frag"]);
    this.line = program(gl, SHADERS["line.vert"], SHADERS["line.frag"]);
    this.surface = program(gl, SHADERS["surface.vert"], SHADERS["surface.frag"]);
    this.tables = [3, 4, 4, 1].map((parts) => ({ parts, texture: null, rows: 0 }));
    this.quads = gl.createVertexArray();
    this.corners_of_quads = gl.createBuffer();
    this.quads_made = 0;
    this.lines = gl.createVertexArray();
    this.ends = gl.createBuffer();
    gl.bindVertexArray(this.lines);
    this.attribute(0, this.ends, 3, 24, 0);
    this.attribute(1, this.ends, 3, 24, 12);
    this.surfaces = gl.createVertexArray();
    this.corners = gl.createBuffer();
    gl.bindVertexArray(this.surfaces);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
    [0, 1].forEach((at) => {
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 24, 12 * at);
    });
    this.empty = gl.createVertexArray();
    this.shadow = this.target(SHADOW_SIDE, SHADOW_SIDE, false);
    this.shadowOf = null;
    this.count = 0;
  }

  attribute(at, buffer, parts, stride, offset) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, parts, gl.FLOAT, false, stride, offset);
    gl.vertexAttribDivisor(at, 1);
  }

  /** The program that casts rays: of the kinds of bodies that there are, and with what is on; `depths` for depths alone. */
  bodyProgram({ cut, distance }, depths) {
    const words = [`KINDS ${this.kinds}`];
    if (cut) words.push("CUT");
    if (distance > 0) words.push("PERSPECTIVE");
    if (depths) words.push("DEPTHS");
    const key = words.join();
    if (!this.of_bodies.has(key)) {
      const [vertex, fragment] = ["body.vert", "body.frag"].map((name) => {
        const lines = SHADERS[name].split("\n");
        // The version stands in the first line.
        lines.splice(1, 0, ...words.map((word) => `#define ${word}`));
        return lines.join("\n");
      });
      const body = fragment
        .replace("//DEPTH_OUT", this.conservative ? "layout(depth_greater) out highp float gl_FragDepth;" : "")
        .replace("//DEPTH", this.conservative ? "#extension GL_EXT_conservative_depth : require" : "");
      this.of_bodies.set(key, program(this.gl, vertex, body));
    }
    return this.of_bodies.get(key);
  }

  /** Fills one of the tables that have a texel for each body. */
  table(table, values) {
    const { gl } = this;
    const { parts } = table;
    const count = values.length / parts, whole = Math.floor(count / TABLE_WIDTH), rows = Math.max(Math.ceil(count / TABLE_WIDTH), 1);
    const [kept, format] = { 1: [gl.R32F, gl.RED], 3: [gl.RGB32F, gl.RGB], 4: [gl.RGBA32F, gl.RGBA] }[parts];
    if (table.rows < rows) {
      gl.deleteTexture(table.texture);
      table.texture = gl.createTexture();
      table.rows = rows;
      gl.bindTexture(gl.TEXTURE_2D, table.texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, kept, TABLE_WIDTH, rows);
      for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
    }
    gl.bindTexture(gl.TEXTURE_2D, table.texture);
    const fill = (first, wide, high) => gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, first, wide, high, format, gl.FLOAT, values, first * TABLE_WIDTH * parts);
    if (whole) fill(0, TABLE_WIDTH, whole);
    if (count % TABLE_WIDTH) fill(whole, count % TABLE_WIDTH, 1);
  }

  /** Two triangles for each of so many bodies. */
  makeQuads(count) {
    if (count <= this.quads_made) return;
    const { gl } = this;
    const corners = new Uint32Array(6 * count);
    for (let i = 0, k = 0; i < count; i++) for (const corner of [0, 1, 2, 2, 1, 3]) corners[k++] = 4 * i + corner;
    gl.bindVertexArray(this.quads);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.corners_of_quads);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    this.quads_made = count;
  }

  /** A picture of numbers with depths, or of depths alone. */
  target(width, height, numbers) {
    const { gl } = this;
    const made = { frame: gl.createFramebuffer(), width, height };
    const texture = (format) => {
      const it = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, it);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
      for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
      return it;
    };
    gl.bindFramebuffer(gl.FRAMEBUFFER, made.frame);
    made.depth = texture(gl.DEPTH_COMPONENT24);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, made.depth, 0);
    if (numbers) {
      made.met = texture(gl.RGBA32UI);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, made.met, 0);
    } else {
      gl.drawBuffers([gl.NONE]);
    }
    return made;
  }

  release(target) {
    this.gl.deleteTexture(target.depth);
    this.gl.deleteTexture(target.met);
    this.gl.deleteFramebuffer(target.frame);
  }

  /** The bodies to draw from now on. */
  setState(state) {
    [state.place, state.turn, state.shape].forEach((values, k) => this.table(this.tables[k], values));
    this.makeQuads(state.bodies);
    this.count = state.bodies;
    this.state = state;
    this.kinds = 0;
    for (let i = 0; i < state.bodies; i++) this.kinds |= 1 << state.shape[4 * i];
    this.shadowOf = null;
    const thickness = new Float32Array(state.bodies).map((_, i) => thicknessOf(state.shape, i)).sort();
    this.thickness = state.bodies ? thickness[state.bodies >> 1] : 0;
    let far = 0;
    for (let i = 0; i < state.bodies; i++) {
      const x = state.place[3 * i], y = state.place[3 * i + 1], z = state.place[3 * i + 2];
      far = Math.max(far, Math.sqrt(x * x + y * y + z * z) + reachOf(state.shape, i));
    }
    this.far = far;
  }

  /** The place of each body on the scale of colours; below zero where it has none. */
  setParts(parts) {
    // What is hidden casts no shadow.
    this.shadowOf = null;
    this.table(this.tables[3], parts);
  }

  fill(buffer, values) {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, buffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, values, this.gl.DYNAMIC_DRAW);
  }

  /** Draws; `look` has camera, colour, planar, paper, accent, picked, lines, surfaces, cut, perspective and haze; `fine` is with two rays along a pixel's side. */
  draw(look, fine) {
    const { gl, canvas } = this;
    const [width, height] = [canvas.width, canvas.height];
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    const samples = fine && 2 * Math.max(width, height) <= most ? 2 : 1;
    if (!this.numbers || this.numbers.width !== width * samples || this.numbers.height !== height * samples) {
      if (this.numbers) this.release(this.numbers);
      this.numbers = this.target(width * samples, height * samples, true);
    }
    this.samples = samples;
    const { camera } = look;
    const ratio = canvas.width / canvas.clientWidth;
    const view = {
      axes: camera.axes, middle: camera.middle, pixels: camera.scale * ratio,
      half: [width / (2 * camera.scale * ratio), height / (2 * camera.scale * ratio)], far: this.far + Math.hypot(...camera.middle), cut: look.cut ?? null,
    };
    view.distance = look.perspective && !look.planar ? EYE * Math.max(...view.half) : 0;
    this.distance = view.distance;
    const shadows = look.shadows && !look.planar && this.thickness * view.pixels >= SHADOW_FROM && this.count > 0
      && (fine || this.count <= SHADOWS_IN_MOTION);
    if (shadows) this.castShadow(camera.axes, view.cut);
    this.cast(this.numbers, view, look.colour);
    this.light(view, look, shadows);
    this.drawSurfaces(view, look.surfaces, shadows);
    for (const lines of look.lines) this.drawLines(view, lines);
  }

  /** Casts the rays of all bodies. */
  cast(target, view, colour) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame);
    gl.viewport(0, 0, target.width, target.height);
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    if (target.met) gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    const { places } = use(gl, this.bodyProgram(view, !target.met));
    this.placeCamera(places, view);
    gl.uniform1f(places.depth, 1.01 * view.far);
    gl.uniform1f(places.pixels, view.pixels);
    gl.uniform1i(places.colour, colour);
    if (view.cut) gl.uniform4fv(places.cut, view.cut);
    ["places", "turns", "shapes", "parts"].forEach((name, k) => this.bind(k, this.tables[k].texture, places[name]));
    gl.bindVertexArray(this.quads);
    if (this.count) gl.drawElements(gl.TRIANGLES, 6 * this.count, gl.UNSIGNED_INT, 0);
    gl.disable(gl.DEPTH_TEST);
  }

  placeCamera(places, view) {
    this.gl.uniformMatrix3fv(places.axes, false, view.axes.flat());
    this.gl.uniform3fv(places.middle, view.middle);
    this.gl.uniform2fv(places.half_size, view.half);
    this.gl.uniform1f(places.distance_, view.distance);
  }

  /** The bodies as the main light sees them, which comes from over the viewer's left shoulder. */
  castShadow(axes, cut) {
    const key = JSON.stringify([axes, cut]);
    if (this.shadowOf === key) return;
    this.shadowOf = key;
    const toward = unit([0, 1, 2].map((k) => KEY_LIGHT[0] * axes[0][k] + KEY_LIGHT[1] * axes[1][k] + KEY_LIGHT[2] * axes[2][k]));
    const across = unit(cross(axes[1], toward));
    const light = [across, cross(toward, across), toward];
    const [low, high] = extentOf(light, [this.state]);
    const middle = low.map((x, k) => (x + high[k]) / 2);
    const half = 1.02 * Math.max(high[0] - low[0], high[1] - low[1]) / 2;
    const space = [0, 1, 2].map((k) => middle[0] * light[0][k] + middle[1] * light[1][k] + middle[2] * light[2][k]);
    const view = { axes: light, middle: space, half: [half, half], pixels: SHADOW_SIDE / (2 * half), far: this.far + Math.hypot(...space), cut, distance: 0 };
    this.light_view = view;
    this.cast(this.shadow, view, 2);
  }

  light(view, look, shadows) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    const { places } = use(gl, this.shade);
    const sample = 1 / (view.pixels * this.samples);
    this.bind(0, this.numbers.met, places.met);
    this.bind(1, this.shadow.depth, places.shadow);
    gl.uniform1i(places.samples, this.samples);
    gl.uniform1f(places.sample_length, sample);
    gl.uniform1f(places.typical, this.thickness / sample);
    gl.uniform3fv(places.paper, look.paper);
    gl.uniform3fv(places.accent, look.accent);
    gl.uniform1i(places.picked, look.picked + 1);
    gl.uniform1f(places.distance_, view.distance);
    gl.uniform3fv(places.haze, look.haze ? [HAZE, this.far / 2, 1 / (1.5 * this.far || 1)] : [0, 0, 1]);
    this.placeLight(places, view, shadows);
    gl.bindVertexArray(this.empty);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  placeLight(places, view, shadows) {
    const { gl } = this;
    gl.uniform1i(places.shadows, shadows ? 1 : 0);
    if (shadows) {
      const it = this.light_view;
      const seen = (v) => view.axes.map((axis) => dot(axis, v));
      gl.uniformMatrix3fv(places.light_axes, false, it.axes.flatMap(seen));
      gl.uniform3fv(places.light_middle, seen(plus(it.middle, view.middle, -1)));
      gl.uniform3fv(places.light_scale, [it.half[0], it.half[1], 1.01 * it.far]);
      gl.uniform1f(places.softness, Math.max(SOFTNESS * this.thickness * it.pixels, LEAST_SOFTNESS));
    }
  }

  /** Triangles: corners with their normals as six numbers each, and their ink. */
  drawSurfaces(view, { corners, ink }, shadows) {
    if (!corners.length) return;
    const { gl } = this;
    const { places } = use(gl, this.surface);
    this.fill(this.corners, Float32Array.from(corners));
    this.placeCamera(places, view);
    this.bind(0, this.numbers.met, places.met);
    this.bind(1, this.shadow.depth, places.shadow);
    gl.uniform1i(places.samples, this.samples);
    gl.uniform3fv(places.ink, ink);
    this.placeLight(places, view, shadows);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindVertexArray(this.surfaces);
    gl.drawArrays(gl.TRIANGLES, 0, corners.length / 6);
    gl.disable(gl.BLEND);
  }

  bind(unit, texture, place) {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(this.gl.TEXTURE_2D, texture);
    this.gl.uniform1i(place, unit);
  }

  /** Lines: ends as six numbers each, ink, width in pixels of the page, and how much is left of the ink behind bodies. */
  drawLines(view, { ends, ink, width, behind }) {
    if (!ends.length) return;
    const { gl } = this;
    const { places } = use(gl, this.line);
    const ratio = this.canvas.width / this.canvas.clientWidth;
    this.fill(this.ends, Float32Array.from(ends));
    this.placeCamera(places, view);
    gl.uniform2f(places.pixel, 1 / view.pixels, 1 / view.pixels);
    gl.uniform1f(places.width, Math.max(width * ratio, 1));
    gl.uniform4fv(places.ink, ink);
    gl.uniform1f(places.behind, behind);
    gl.uniform1i(places.samples, this.samples);
    this.bind(0, this.numbers.met, places.met);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindVertexArray(this.lines);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, ends.length / 6);
    gl.disable(gl.BLEND);
  }

  /** Waits until all is there that was drawn so far; gives the milliseconds. */
  async drawn() {
    const { gl } = this;
    const begun = performance.now();
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    while (fence && gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.UNSIGNALED) await new Promise((go) => setTimeout(go, 4));
    gl.deleteSync(fence);
    return performance.now() - begun;
  }

  /** The height of what is seen at a place of the page, towards the viewer from the picture's middle; 0 of nothing. */
  heightAt(x, y) {
    return new Float32Array(this.metAt(x, y).buffer)[1];
  }

  /** The row of the body that is seen at a place of the page, from the canvas's top left; -1 where there is none. */
  bodyAt(x, y) {
    return this.metAt(x, y)[0] - 1;
  }

  metAt(x, y) {
    const { gl, numbers, samples } = this;
    const ratio = this.canvas.width / this.canvas.clientWidth * samples;
    const read = new Uint32Array(4);
    gl.bindFramebuffer(gl.FRAMEBUFFER, numbers.frame);
    gl.readPixels(Math.floor(x * ratio), numbers.height - 1 - Math.floor(y * ratio), 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, read);
    return read;
  }
}

function program(gl, vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(`a shader is refused: ${gl.getShaderInfoLog(shader)}`);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(`a shader is refused: ${gl.getProgramInfoLog(made)}`);
  const places = {};
  for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); k++) {
    const { name } = gl.getActiveUniform(made, k);
    places[name] = gl.getUniformLocation(made, name);
  }
  return { made, places };
}

function use(gl, of) {
  gl.useProgram(of.made);
  return of;
}
