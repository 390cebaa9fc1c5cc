//! Area of the convex hull of planar bodies.
//!
//! The bodies' farthest points at equally spaced angles `d` apart are corners of the hull. Between two of them the
//! boundary is an arc of one body, or a straight edge with an arc at each end; the edge's angle is found by bisection,
//! so that edges are exact. The segment between a chord `c` and an arc that turns by `d` has 2/3 of the area of the
//! triangle between chord and tangents, `c^2 tan(d/2) / 6`, as for a parabola (Archimedes): the error is of the order
//! of `d^4` of a body's area. The area of the polygon follows from Gauss's formula.

use super::View;
use super::interior::support;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// The number of angles. The area of a single body is then exact to 1e-10 for a disc, 2e-8 for an ellipse of 1:5, 3e-7
/// for 1:10, 4e-6 for 1:20.
const ANGLES: usize = 720;

/// Halvings of the step between two angles: down to rounding.
const HALVINGS: usize = 50;

/// A corner of the hull.
#[derive(Clone, Copy)]
struct Corner {
    angle: f64,
    body: usize,
    /// From the centre.
    point: DVec3,
}

/// Area of the convex hull of all bodies; there must be one.
pub(super) fn area(view: &View<'_>) -> f64 {
    let step = TAU / ANGLES as f64;
    let mut corners: Vec<Corner> = (0..ANGLES).into_par_iter().map(|k| farthest(view, step * k as f64)).collect();
    corners.extend(corners.first().map(|first| Corner { angle: TAU, ..*first }));
    corners.windows(2).map(|ends| between(view, ends[0], ends[1])).sum()
}

/// The area between the centre and the boundary from one corner to the next.
fn between(view: &View<'_>, from: Corner, to: Corner) -> f64 {
    let reach = view.bodies().shape[from.body].bounding_radius();
    // A longer chord of a body is a straight edge.
    if from.body == to.body && from.point.distance(to.point) <= 2.0 * (to.angle - from.angle) * reach {
        return arc(from, to);
    }
    let (mut before, mut after) = (from, to);
    for _ in 0..HALVINGS {
        let middle = farther(view, [from.body, to.body], 0.5 * (before.angle + after.angle));
        if middle.point.distance_squared(before.point) < middle.point.distance_squared(after.point) {
            before = middle;
        } else {
            after = middle;
        }
    }
    arc(from, before) + triangle(before, after) + arc(after, to)
}

/// The triangle with the centre.
fn triangle(a: Corner, b: Corner) -> f64 {
    0.5 * (a.point.x * b.point.y - a.point.y * b.point.x)
}

fn arc(a: Corner, b: Corner) -> f64 {
    triangle(a, b) + a.point.distance_squared(b.point) * (0.5 * (b.angle - a.angle)).tan() / 6.0
}

/// The farthest point of a body at an angle.
fn corner(view: &View<'_>, body: usize, angle: f64) -> Corner {
    let bodies = view.bodies();
    let tip = support(&bodies.shape[body], bodies.orientation[body], direction(angle));
    Corner { angle, body, point: bodies.position[body] - view.centre + tip }
}

fn direction(angle: f64) -> DVec3 {
    DVec3::new(angle.cos(), angle.sin(), 0.0)
}

/// The farther of two bodies at an angle.
fn farther(view: &View<'_>, pair: [usize; 2], angle: f64) -> Corner {
    let [a, b] = pair.map(|body| corner(view, body, angle));
    if a.point.dot(direction(angle)) >= b.point.dot(direction(angle)) { a } else { b }
}

/// The farthest point of all bodies at an angle.
fn farthest(view: &View<'_>, angle: f64) -> Corner {
    let bodies = view.bodies();
    let normal = direction(angle);
    let along = |i: usize| (bodies.position[i] - view.centre).dot(normal);
    let centres = (0..bodies.len()).map(along).fold(f64::NEG_INFINITY, f64::max);
    // A body whose bounding ball does not reach the farthest centre cannot be the farthest.
    (0..bodies.len())
        .filter(|&i| along(i) + bodies.shape[i].bounding_radius() >= centres)
        .map(|i| corner(view, i, angle))
        .max_by(|a, b| a.point.dot(normal).total_cmp(&b.point.dot(normal)))
        .unwrap_or(Corner { angle, body: 0, point: DVec3::ZERO })
}
