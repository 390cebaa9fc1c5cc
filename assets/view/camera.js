"use strict";
// The camera: a parallel projection, as in the pictures, so that a length is the same everywhere.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => a.map((x) => x / Math.hypot(...a));
const plus = (a, b, times = 1) => a.map((x, k) => x + times * b[k]);

const SIDES = {
  top: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  front: [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  right: [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
  oblique: oblique(-58, 24),
};
/** The part of the picture that stays free on each side, as src/render/camera.rs has it. */
const MARGIN = 0.04;

function oblique(azimuth, elevation) {
  const [a, e] = [azimuth, elevation].map((degrees) => degrees * Math.PI / 180);
  const toward = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
  const right = unit([-toward[1], toward[0], 0]);
  return [right, cross(toward, right), toward];
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** A vector turned about a unit vector. */
function turned(v, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const [aside, along] = [cross(axis, v), dot(axis, v) * (1 - c)];
  return v.map((x, k) => x * c + aside[k] * s + axis[k] * along);
}

/** How far bodies reach along right, up and toward, from the run's middle. */
function extentOf(axes, states) {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  axes.forEach((axis, k) => {
    for (const state of states) {
      const [least, most] = extentAlong(axis, state);
      low[k] = Math.min(low[k], least);
      high[k] = Math.max(high[k], most);
    }
  });
  return low[0] > high[0] ? [[-1, -1, -1], [1, 1, 1]] : [low, high];
}

/** How far a superellipsoid reaches. */
function reachAlong(kind, x, y, z) {
  const [p, q] = exponentsOf(kind).map((n) => n / (n - 1));
  return normOf(normOf(Math.abs(x), Math.abs(y), q), Math.abs(z), p);
}

function extentAlong([ex, ey, ez], { bodies, place, turn, shape }) {
  let low = Infinity, high = -Infinity;
  for (let i = 0; i < bodies; i++) {
    const x = -turn[4 * i], y = -turn[4 * i + 1], z = -turn[4 * i + 2], w = turn[4 * i + 3];
    // The axis in those of the body.
    const p = 2 * (y * ez - z * ey), q = 2 * (z * ex - x * ez), r = 2 * (x * ey - y * ex);
    const u = ex + w * p + y * r - z * q, v = ey + w * q + z * p - x * r, t = ez + w * r + x * q - y * p;
    const kind = shape[4 * i], a = shape[4 * i + 1], b = shape[4 * i + 2], c = shape[4 * i + 3];
    const reach = kind === 0 ? b : kind === 1 ? b + a * Math.abs(t) : kind === 2 ? b + a * Math.sqrt(u * u + v * v)
      : kind === 3 ? Math.sqrt(a * a * u * u + b * b * v * v + c * c * t * t) : reachAlong(kind, a * u, b * v, c * t);
    const at = place[3 * i] * ex + place[3 * i + 1] * ey + place[3 * i + 2] * ez;
    if (at - reach < low) low = at - reach;
    if (at + reach > high) high = at + reach;
  }
  return [low, high];
}

class Camera {
  constructor() {
    this.axes = SIDES.top;
    this.middle = [0, 0, 0];
    this.scale = 1;  // pixels of the page to a length of one
  }

  /** Shows an extent along these axes as large as it fits. */
  fit(axes, [low, high], width, height) {
    this.axes = axes;
    const free = 1 - 2 * MARGIN;
    this.scale = Math.min(width * free / (high[0] - low[0]), height * free / (high[1] - low[1]));
    this.middle = this.toSpace(low.map((x, k) => (x + high[k]) / 2));
  }

  toSpace(parts) {
    return [0, 1, 2].map((k) => parts[0] * this.axes[0][k] + parts[1] * this.axes[1][k] + parts[2] * this.axes[2][k]);
  }

  /** Turns the bodies by pixels to the right and down. */
  orbit(right, down) {
    for (const [axis, angle] of [[this.axes[1], -right / 200], [this.axes[0], -down / 200]]) {
      this.axes = this.axes.map((e) => turned(e, axis, angle));
    }
    // Rounding must not shear the picture.
    const toward = unit(this.axes[2]);
    const across = unit(cross(this.axes[1], toward));
    this.axes = [across, cross(toward, across), toward];
  }

  /** Turns the picture in its plane. */
  roll(angle) {
    this.axes = this.axes.map((e) => turned(e, this.axes[2], angle));
  }

  /** Moves the bodies by pixels to the right and down. */
  pan(right, down) {
    this.middle = plus(plus(this.middle, this.axes[0], -right / this.scale), this.axes[1], down / this.scale);
  }

  /** Enlarges about a place of the picture, in pixels from its middle to the right and down. */
  zoom(factor, right = 0, down = 0) {
    this.pan(-right, -down);
    this.scale *= factor;
    this.pan(right, down);
  }
}
