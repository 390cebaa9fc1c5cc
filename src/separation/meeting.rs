//! The normal of two curves at their nearest points, also where these are so near that the gap between them has lost
//! its digits.
//!
//! At nearest points the normal is at right angles to a curve that goes on on both sides, and at a curve's end it does
//! not lean back along it. Far apart the gap is so by itself. Nearly met, its rounding is not small beside it, and what
//! the curves say of the normal is held to.
//!
//! Degenerate cases: curves that cross, or nearly do (their common perpendicular); curves that meet otherwise, such as
//! an end on the other curve, curves along each other and points that coincide (a fixed common perpendicular).

use super::direction::{across, common_perpendicular, normal_to};
use glam::DVec3;

/// Distance, as a fraction of the sizes, under which curves nearly meet, above which the gap has ten digits; times the
/// sine between them, under which they cross and the normal is read from their directions.
const NEAR: f64 = 1e-6;
/// Gap, as a fraction of the sizes, that is rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// The same, and as a fraction of the gap, of what of it lies beside the common perpendicular of curves that cross:
/// their places have roundings too.
const ASIDE: (f64, f64) = (32.0 * f64::EPSILON, 1e-4);
/// A place of a segment within this part of its half length of an end is the end.
const END_ROUNDING: f64 = 1e-12;

/// One of two curves at its nearest point.
#[derive(Clone, Copy)]
pub(super) struct CurvePoint {
    /// Its unit direction there; zero of a point.
    pub along: DVec3,
    /// On which side of it, along `along`, it ends there; zero of a point. Where it goes on: none.
    pub end: Option<f64>,
}

impl CurvePoint {
    /// A segment along `axis`, at a place of it.
    #[inline]
    pub fn of_segment(axis: DVec3, half: f64, at: f64) -> CurvePoint {
        CurvePoint { along: axis, end: (at.abs() >= half * (1.0 - END_ROUNDING)).then_some(at) }
    }

    /// Whether a normal along `way` must be at right angles to the curve: where it goes on, and at an end that it would
    /// lean back from.
    #[inline]
    fn holds(self, way: DVec3) -> bool {
        self.end.is_none_or(|end| way.dot(self.along) * end < 0.0)
    }
}

/// The unit vector from a curve to the other, given the gap between their nearest points, and its length. Where they
/// cross it is turned with `toward`. `size` is what the gap's rounding is a fraction of.
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
    // Their common perpendicular, where the gap is along it: not at an end that rounding has moved inside.
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
    // The normal arrives at b, which is to b as if it left it the other way. What goes on comes first.
    let b_turned = CurvePoint { end: b.end.map(|end| -end), ..b };
    let (first, second) = if a.end.is_none() { (a, b_turned) } else { (b_turned, a) };
    let off = |v: DVec3, point: CurvePoint| across(v, point.along).unwrap_or(DVec3::ZERO);
    let left = match first.holds(gap) {
        false if second.holds(gap) => off(gap, second),
        false => gap,
        true if !second.holds(off(gap, first)) => off(gap, first),
        // Of nearly parallel curves, what is at right angles to one is so to the other.
        true if distance >= size * sine => off(gap, first),
        // The gap knows worse than the curves do what is at right angles to both.
        true => match perpendicular() {
            Some(unit) => unit * gap.dot(unit),
            None if gap.dot(first.along).abs() > gap.dot(second.along).abs() => off(gap, second),
            None => off(gap, first),
        },
    };
    let length = left.length();
    if length > ROUNDING * size { left / length } else { common_perpendicular(a.along, b.along) }
}
