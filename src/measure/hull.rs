//! Area of the convex hull of planar bodies.
//!
//! The bodies' farthest points at equally spaced angles `d` apart are the corners of a polygon in the hull, whose area is Gauss's formula. The hull's
//! straight edges are exact; of its arcs, which have the bodies' radii and not the colony's, `d^2 / 6` of a disc's area is missing.

use super::View;
use super::interior::support;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Angles: of a lone disc's area 1.3e-5 is missing, of a colony's far less.
const ANGLES: usize = 720;

/// Area of the convex hull of all bodies; zero without bodies.
pub(super) fn area(view: &View<'_>) -> f64 {
    let angle = |k: usize| TAU * k as f64 / ANGLES as f64;
    let corners: Vec<DVec3> = (0..ANGLES).into_par_iter().map(|k| farthest(view, angle(k))).collect();
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| 0.5 * (a.x * b.y - a.y * b.x)).sum()
}

/// The bodies' farthest point at an angle, from the centre.
fn farthest(view: &View<'_>, angle: f64) -> DVec3 {
    let bodies = view.bodies();
    let normal = DVec3::new(angle.cos(), angle.sin(), 0.0);
    let along = |i: usize| (bodies.position[i] - view.centre).dot(normal);
    let centres = (0..bodies.len()).map(along).fold(f64::NEG_INFINITY, f64::max);
    // A body whose ball does not come up to the farthest centre cannot decide.
    (0..bodies.len())
        .filter(|&i| along(i) + bodies.shape[i].bounding_radius() >= centres)
        .map(|i| bodies.position[i] - view.centre + support(&bodies.shape[i], bodies.orientation[i], normal))
        .max_by(|a, b| a.dot(normal).total_cmp(&b.dot(normal)))
        .unwrap_or(DVec3::ZERO)
}
