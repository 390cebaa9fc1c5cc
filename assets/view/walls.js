"use strict";
// Walls as translucent surfaces, and walls and the periodic cell as lines, six numbers each, from the run's middle. In a planar run they are cut by the
// plane.

/** Lines along a side of a plane that is drawn as a patch, and to a turn of a circle. */
const PATCH = 8;
const TURN = 96;

/** The lines of all walls; `extent` is the box of the bodies along x, y and z, `origin` the run's middle in space. */
function wallLines(walls, planar, extent, origin) {
  const size = Math.hypot(...plus(extent[1], extent[0], -1)) || 1;
  const near = extent[0].map((x, k) => (x + extent[1][k]) / 2);
  const at = (point) => plus(point, origin, -1);
  const lines = [];
  for (const wall of walls) {
    const [name, it] = Object.entries(wall)[0];
    if (name === "half_space") {
      const normal = unit(it.normal);
      plane(lines, at(normal.map((x) => x * it.offset)), normal, near, size, planar);
    } else if (name === "channel") {
      const normal = unit(it.normal);
      for (const side of [-0.5, 0.5]) plane(lines, at(plus(it.center, normal, side * it.width)), normal, near, size, planar);
    } else if (name === "box") {
      box(lines, at(it.minimum), at(it.maximum), planar);
    } else if (name === "sphere") {
      const centre = at(it.center);
      if (planar) {
        circle(lines, [centre[0], centre[1], 0], [1, 0, 0], [0, 1, 0], Math.sqrt(Math.max(it.radius ** 2 - centre[2] ** 2, 0)));
      } else {
        const axes = SIDES.top;
        for (let k = 0; k < 3; k++) circle(lines, centre, axes[k], axes[(k + 1) % 3], it.radius);
      }
    } else if (name === "cylinder") {
      cylinder(lines, at(it.center), unit(it.axis), it.radius, it.length ?? null, size, planar);
    }
  }
  return lines;
}

/** What `make` draws of one wall where it has moved to; `place` is null where it never moves. */
function placedWall(make, wall, place, planar, extent, origin) {
  if (!place) return make([wall], planar, extent, origin);
  const reference = plus(place.reference, origin, -1);
  const [w, ...v] = place.turn;
  const about = (point, sign) => {
    const across = cross(v, point).map((x) => 2 * sign * x);
    return plus(plus(point, across, w), cross(v, across), sign);
  };
  // The bodies' box as the wall sees it.
  const middle = extent[0].map((x, k) => (x + extent[1][k]) / 2);
  const back = plus(reference, about(plus(plus(middle, reference, -1), place.shift, -1), -1));
  const seen = extent.map((corner) => plus(back, plus(corner, middle, -1)));
  const lines = make([wall], planar, seen, origin);
  for (let k = 0; k < lines.length; k += 3) {
    const point = plus(plus(reference, about(plus(lines.slice(k, k + 3), reference, -1), 1)), place.shift);
    for (let axis = 0; axis < 3; axis++) lines[k + axis] = point[axis];
  }
  return lines;
}

/** Whether a wall has an end in every direction. */
function isClosed(wall) {
  return "box" in wall || "sphere" in wall || ("cylinder" in wall && (wall.cylinder.length ?? null) !== null);
}

/** The periodic cell about the origin; along open axes it is as long as the bodies reach. */
function cellLines(periods, planar, extent, origin) {
  if (!periods.some((period) => period !== null)) return [];
  const side = (sign) => periods.map((period, k) => (period === null ? extent[sign < 0 ? 0 : 1][k] : sign * period / 2 - origin[k]));
  const lines = [];
  box(lines, side(-1), side(1), planar);
  return lines;
}

function crossing(normal) {
  const other = Math.abs(normal[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const first = unit(cross(other, normal));
  return [first, cross(normal, first)];
}

function plane(lines, point, normal, near, size, planar) {
  // The patch lies where the bodies are.
  const foot = plus(near, normal, dot(plus(point, near, -1), normal));
  if (planar) {
    const along = unit([-normal[1], normal[0], 0]);
    lines.push(...plus(foot, along, -size), ...plus(foot, along, size));
    return;
  }
  const [u, v] = crossing(normal);
  const reach = 0.6 * size;
  for (let k = 0; k <= PATCH; k++) {
    const way = reach * (2 * k / PATCH - 1);
    for (const [a, b] of [[u, v], [v, u]]) {
      lines.push(...plus(plus(foot, a, way), b, -reach), ...plus(plus(foot, a, way), b, reach));
    }
  }
}

function box(lines, low, high, planar) {
  const corner = (bits) => [0, 1, 2].map((k) => (planar && k === 2 ? 0 : bits >> k & 1 ? high[k] : low[k]));
  for (let from = 0; from < (planar ? 4 : 8); from++) {
    for (let k = 0; k < (planar ? 2 : 3); k++) if (!(from >> k & 1)) lines.push(...corner(from), ...corner(from | 1 << k));
  }
}

function circle(lines, centre, u, v, radius) {
  const at = (k) => {
    const angle = 2 * Math.PI * k / TURN;
    return plus(plus(centre, u, radius * Math.cos(angle)), v, radius * Math.sin(angle));
  };
  for (let k = 0; k < TURN; k++) lines.push(...at(k), ...at(k + 1));
}

function cylinder(lines, centre, axis, radius, length, size, planar) {
  const [u, v] = crossing(axis);
  if (planar && Math.abs(axis[2]) > 0.5) return circle(lines, [centre[0], centre[1], 0], [1, 0, 0], [0, 1, 0], radius);
  const half = length === null ? size : length / 2;
  const ends = [-half, half].map((way) => plus(centre, axis, way));
  const sides = planar ? [unit([-axis[1], axis[0], 0])] : Array.from({ length: 6 }, (_, k) => turned(u, axis, k * Math.PI / 6));
  for (const side of sides) {
    for (const sign of [-radius, radius]) lines.push(...plus(ends[0], side, sign), ...plus(ends[1], side, sign));
    if (planar && length !== null) for (const end of ends) lines.push(...plus(end, side, -radius), ...plus(end, side, radius));
  }
  if (planar) return undefined;
  for (const end of length === null ? [centre, ...ends] : ends) circle(lines, end, u, v, radius);
  return undefined;
}

/** Parts of a sphere from pole to pole. */
const BELTS = 24;

/** The triangles of all walls in space, three numbers a corner. */
function wallTriangles(walls, planar, extent, origin) {
  const triangles = [];
  if (planar) return triangles;
  const size = Math.hypot(...plus(extent[1], extent[0], -1)) || 1;
  const near = extent[0].map((x, k) => (x + extent[1][k]) / 2);
  const at = (point) => plus(point, origin, -1);
  const quad = (a, b, c, d) => triangles.push(...a, ...b, ...c, ...a, ...c, ...d);
  const patch = (point, normal) => {
    const foot = plus(near, normal, dot(plus(point, near, -1), normal));
    const [u, v] = crossing(normal).map((axis) => axis.map((x) => 0.6 * size * x));
    const corner = (p, q) => plus(plus(foot, u, p), v, q);
    quad(corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1));
  };
  for (const wall of walls) {
    const [name, it] = Object.entries(wall)[0];
    if (name === "half_space") {
      const normal = unit(it.normal);
      patch(at(normal.map((x) => x * it.offset)), normal);
    } else if (name === "channel") {
      const normal = unit(it.normal);
      for (const side of [-0.5, 0.5]) patch(at(plus(it.center, normal, side * it.width)), normal);
    } else if (name === "box") {
      const [low, high] = [at(it.minimum), at(it.maximum)];
      for (let k = 0; k < 3; k++) {
        for (const side of [low[k], high[k]]) {
          const [p, q] = [(k + 1) % 3, (k + 2) % 3];
          const corner = (a, b) => { const point = []; point[k] = side; point[p] = a[p]; point[q] = b[q]; return point; };
          quad(corner(low, low), corner(high, low), corner(high, high), corner(low, high));
        }
      }
    } else if (name === "sphere") {
      const point = (i, j) => {
        const [up, about] = [Math.PI * i / BELTS, 2 * Math.PI * j / TURN];
        return plus(at(it.center), [Math.sin(up) * Math.cos(about), Math.sin(up) * Math.sin(about), Math.cos(up)], it.radius);
      };
      for (let i = 0; i < BELTS; i++) for (let j = 0; j < TURN; j++) quad(point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
    } else if (name === "cylinder") {
      const axis = unit(it.axis);
      const [u, v] = crossing(axis);
      const closed = (it.length ?? null) !== null;
      const half = closed ? it.length / 2 : size;
      const point = (end, j) => {
        const about = 2 * Math.PI * j / TURN;
        return plus(plus(plus(at(it.center), axis, end * half), u, it.radius * Math.cos(about)), v, it.radius * Math.sin(about));
      };
      for (let j = 0; j < TURN; j++) {
        quad(point(-1, j), point(1, j), point(1, j + 1), point(-1, j + 1));
        for (const end of closed ? [-1, 1] : []) triangles.push(...plus(at(it.center), axis, end * half), ...point(end, j), ...point(end, j + 1));
      }
    }
  }
  return triangles;
}

/** The same with the normal of its triangle after each corner. */
function withNormals(triangles) {
  const corners = [];
  for (let k = 0; k < triangles.length; k += 9) {
    const [a, b, c] = [0, 3, 6].map((from) => triangles.slice(k + from, k + from + 3));
    const normal = cross(plus(b, a, -1), plus(c, a, -1));
    for (const corner of [a, b, c]) corners.push(...corner, ...normal);
  }
  return corners;
}
