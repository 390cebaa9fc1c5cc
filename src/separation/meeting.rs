//! The normal of two curves at their nearest points, even if these are so near that the gap between them has lost its
//! digits.
//!
//! At the nearest points, the normal is at right angles to a curve that continues on both sides; at a curve's end it
//! does not lean back along the curve. Far apart, the gap satisfies this by itself. Near each other, its rounding is
//! not small beside it, so these conditions are enforced.
//!
//! Degenerate cases: curves that cross, or nearly do (their common perpendicular); curves that meet otherwise, such as
//! an end on the other curve, overlapping curves and coinciding points (a fixed common perpendicular).

use super::direction::{across, common_perpendicular, normal_to};
use glam::DVec3;

/// Distance, as a fraction of the sizes, below which curves nearly meet; above it the gap has ten digits. Times the
/// sine between the curves, it is the distance below which they cross and the normal follows from their directions.
const NEAR: f64 = 1e-6;
/// Gap, as a fraction of the sizes, that is rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// The same for the part of the gap beside the common perpendicular of crossing curves, as a fraction of the sizes and
/// of the gap: their positions have rounding errors too.
const ASIDE: (f64, f64) = (32.0 * f64::EPSILON, 1e-4);
/// A position on a segment within this part of its half length of an end is the end.
const END_ROUNDING: f64 = 1e-12;

/// One of two curves at its nearest point.
#[derive(Clone, Copy)]
pub(super) struct CurvePoint {
    /// Its unit direction there; zero for a point.
    pub along: DVec3,
    /// The side, along `along`, on which the curve ends there; zero for a point. None if it continues.
    pub end: Option<f64>,
}

impl CurvePoint {
    /// A segment along `axis`, at a position on it.
    #[inline]
    pub fn of_segment(axis: DVec3, half: f64, at: f64) -> CurvePoint {
        CurvePoint { along: axis, end: (at.abs() >= half * (1.0 - END_ROUNDING)).then_some(at) }
    }

    /// Whether a normal along `way` must be at right angles to the curve: where the curve continues, and at an end from
    /// which the normal would lean back.
    #[inline]
    fn holds(self, way: DVec3) -> bool {
        self.end.is_none_or(|end| way.dot(self.along) * end < 0.0)
    }
}

/// The unit vector from a curve to the other, from the gap between their nearest points, and its length. If they cross,
/// its sign follows `toward`. `size` is the scale of the gap's rounding.
#[inline]
pub(super) fn normal(
    points: impl FnOnce() -> [CurvePoint; 2],
    gap: DVec3,
    distance: f64,
    toward: DVec3,
    size: f64,
) -> DVec3 {
    if distance > NEAR * size { gap / distance } else { nearly_met(points(), gap, distance, toward, size) }
}

#[cold]
#[inline(never)]
fn nearly_met([a, b]: [CurvePoint; 2], gap: DVec3, distance: f64, toward: DVec3, size: f64) -> DVec3 {
    let sine = a.along.cross(b.along).length();
    // Their common perpendicular, if the gap is along it: not at an end that rounding has moved inside.
    let perpendicular = || {
        let unit = normal_to(a.along, b.along)?;
        ((gap - unit * gap.dot(unit)).length() <= ASIDE.0 * size + ASIDE.1 * distance).then_some(unit)
    };
    let both_go_on = a.end.is_none() && b.end.is_none();
    if both_go_on
        && distance < NEAR * size * sine
        && let Some(unit) = perpendicular()
    {
        return if toward.dot(unit) < 0.0 { -unit } else { unit };
    }
    // The normal points towards b, so for b its sign is opposite. Curves that continue come first.
    let b_turned = CurvePoint { end: b.end.map(|end| -end), ..b };
    let (first, second) = if a.end.is_none() { (a, b_turned) } else { (b_turned, a) };
    let off = |v: DVec3, point: CurvePoint| across(v, point.along).unwrap_or(DVec3::ZERO);
    let left = match first.holds(gap) {
        false if second.holds(gap) => off(gap, second),
        false => gap,
        true if !second.holds(off(gap, first)) => off(gap, first),
        // A normal at right angles to one of two nearly parallel curves is also at right angles to the other.
        true if distance >= size * sine => off(gap, first),
        // The curves determine the common perpendicular better than the gap does.
        true => match perpendicular() {
            Some(unit) => unit * gap.dot(unit),
            None if gap.dot(first.along).abs() > gap.dot(second.along).abs() => off(gap, second),
            None => off(gap, first),
        },
    };
    let length = left.length();
    if length > ROUNDING * size { left / length } else { common_perpendicular(a.along, b.along) }
}
