//! The nearest points of two segments; a point is a segment of zero length.
//!
//! The squared distance of `s u_a` and `Delta + t u_b` is a convex quadratic in (s, t). Its minimum over the strip `|s|
//! <= half_a` has `s` at the foot of the common perpendicular, clamped to the segment; with `t` optimal for that `s`
//! and clamped, and `s` optimal for that `t` and clamped, the result is the minimum over the box (D. Eberly, "Robust
//! computation of distance between line segments"; C. Ericson, "Real-time collision detection", 5.1.9). The foot is
//! computed from the cross product of the axes, not from `1 - cos^2`, so it keeps its digits for nearly parallel axes.
//!
//! Degenerate cases: a segment of zero length; parallel axes (`middle_of_shared`); crossing segments and points that
//! coincide (`meeting`).

use super::Nearest;
use super::meeting::{self, CurvePoint};
use glam::DVec3;

/// A segment about the origin: `axis` times `-half` to `half`. A point has a zero axis.
#[derive(Clone, Copy)]
pub(super) struct Segment {
    pub axis: DVec3,
    pub half: f64,
}

impl Segment {
    /// The segment of zero length.
    pub const POINT: Segment = Segment { axis: DVec3::ZERO, half: 0.0 };
}

/// Sine of the angle below which axes count as parallel and the contact point moves to the middle of the shared
/// interval. At this angle the ends of segments 1000 diameters long differ by 1e-9 diameters, so that the points still
/// agree with the separation to 1e-9; quaternions are rounded to 1e-16, far inside.
const PARALLEL_SINE: f64 = 1e-12;

/// Nearest points of the segment `a` about the origin and `b` about `delta`.
#[inline]
pub(super) fn nearest(delta: DVec3, a: Segment, b: Segment) -> Nearest {
    let cross = a.axis.cross(b.axis);
    let sine2 = cross.length_squared();
    let cosine = a.axis.dot(b.axis);
    let (along_a, along_b) = (delta.dot(a.axis), delta.dot(b.axis));
    let foot = if sine2 > 0.0 { delta.dot(b.axis.cross(cross)) / sine2 } else { along_a };
    let t = (cosine * foot.clamp(-a.half, a.half) - along_b).clamp(-b.half, b.half);
    let s = (cosine * t + along_a).clamp(-a.half, a.half);
    let gap = delta + b.axis * t - a.axis * s;
    let distance = gap.length();
    let points = || [CurvePoint::of_segment(a.axis, a.half, s), CurvePoint::of_segment(b.axis, b.half, t)];
    let normal = meeting::normal(points, gap, distance, delta, a.half + b.half + delta.length());
    let (s, t) = if sine2 < 1e3 * PARALLEL_SINE * PARALLEL_SINE && a.half > 0.0 && b.half > 0.0 {
        middle_of_shared(along_a, along_b, cosine, sine2, (a.half, b.half), (s, t))
    } else {
        (s, t)
    };
    Nearest { from: a.axis * s, to: b.axis * t, normal, distance }
}

/// Whether the common perpendicular of two segments ends inside both.
pub(super) fn cross_inside(delta: DVec3, a: Segment, b: Segment) -> bool {
    let cross = a.axis.cross(b.axis);
    let sine2 = cross.length_squared();
    if sine2 < PARALLEL_SINE * PARALLEL_SINE {
        return false;
    }
    let s = delta.dot(b.axis.cross(cross)) / sine2;
    let t = delta.dot(a.axis.cross(cross)) / sine2;
    s.abs() < a.half && t.abs() < b.half
}

/// If the axes are parallel, every point of the interval in which the segments face each other is nearest: take its
/// middle. The nearest point of nearly parallel axes jumps from end to end as the angle changes sign; the transition
/// from it to the middle is a smooth function of the angle.
fn middle_of_shared(
    along_a: f64,
    along_b: f64,
    cosine: f64,
    sine2: f64,
    (half_a, half_b): (f64, f64),
    (s, t): (f64, f64),
) -> (f64, f64) {
    let low = (-half_a).max(along_a - half_b);
    let high = half_a.min(along_a + half_b);
    if low >= high {
        return (s, t);
    }
    let middle = 0.5 * (low + high);
    let opposite = (cosine * middle - along_b).clamp(-half_b, half_b);
    let angle = sine2 / (PARALLEL_SINE * PARALLEL_SINE);
    let weight = 1.0 / (1.0 + angle * angle);
    (s + weight * (middle - s), t + weight * (opposite - t))
}
