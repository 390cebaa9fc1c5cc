//! Two ellipsoids: the largest `n . Delta - h_a(n) - h_b(n)` over unit normals (see `peak`).
//!
//! From a warm normal Newton converges at once. Without one, the start is the normal of a sequence of quadratic models.
//! If the maximum is so deep that it may not be unique, Newton also starts from the axes of both bodies and from the
//! common perpendiculars of each two of them: local maxima lie at the thin sides of flat and slender bodies.
//!
//! Degenerate cases: concentric bodies (no direction between centres; those axes are the starts); equal maxima (the
//! first in the order of starts).

use super::Separation;
use super::peak::{Peak, climb};
use super::support::Support;
use glam::DVec3;

/// Quadratic models solved before Newton starts.
const MODELS: usize = 3;
/// Maxima this close, as a fraction of the sizes, are equal: well above the rounding of a value, 1e-16 of the sizes.
const TIE: f64 = 1e-13;

/// The separation of `a` about the origin and `b` about `delta`.
pub(super) fn separation(delta: DVec3, a: Support, b: Support, warm: Option<DVec3>) -> Separation {
    let bodies = [a, b];
    let start = warm.and_then(DVec3::try_normalize).unwrap_or_else(|| cold_start(delta, &bodies));
    let mut peak = climb(delta, &bodies, start);
    if peak.value <= -(a.least_curvature_radius() + b.least_curvature_radius()) {
        peak = deepest(delta, &bodies, peak);
    }
    Separation { separation: peak.value, normal: peak.normal, lever_a: peak.points[0], lever_b: -peak.points[1] }
}

/// A normal near the maximum, from the direction between the centres.
fn cold_start(delta: DVec3, bodies: &[Support; 2]) -> DVec3 {
    let squares = [bodies[0].square(), bodies[1].square()];
    let mut normal = delta.try_normalize().unwrap_or(DVec3::X);
    for _ in 0..MODELS {
        let Some(next) = Peak::at(delta, bodies, normal).majorized(delta, &squares) else { break };
        normal = next;
    }
    normal
}

/// The largest of the local maxima from the axes and their common perpendiculars; `found` only if it is larger than all
/// of them, so that among equal maxima the result does not depend on a warm start.
fn deepest(delta: DVec3, bodies: &[Support; 2], found: Peak<2>) -> Peak<2> {
    let tie = TIE * (delta.length() + bodies[0].radii.max_element() + bodies[1].radii.max_element());
    let axes = bodies.map(|b| [b.axes.x_axis, b.axes.y_axis, b.axes.z_axis]);
    let crossed = axes[0].iter().flat_map(|u| axes[1].iter().filter_map(|v| u.cross(*v).try_normalize()));
    let starts = axes[0].into_iter().chain(axes[1]).chain(crossed).chain([cold_start(delta, bodies)]);
    let mut best: Option<Peak<2>> = None;
    for start in starts {
        for side in [start, -start] {
            let peak = climb(delta, bodies, side);
            if best.is_none_or(|b| peak.value > b.value + tie) {
                best = Some(peak);
            }
        }
    }
    best.filter(|b| found.value <= b.value + tie).unwrap_or(found)
}
