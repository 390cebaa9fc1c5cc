//! Directions that geometry leaves undetermined or nearly so. The same input gives the same direction, to the bit.
//!
//! A vector that should be zero is rounding, and rounding has a direction too. So a difference gives a direction only
//! if it is larger than its rounding. A vector that must be at right angles to an axis is projected. One projection
//! leaves a rounding error of the whole vector, which is not small beside a small rest; a second projection leaves a
//! rounding error of the rest.

use glam::DVec3;

/// Sine below which a part is small beside the whole: above it, one projection is exact to 1e-13.
const SMALL_SINE: f64 = 1e-3;
/// Sine below which a part is rounding of the whole: some five roundings.
pub(super) const ROUNDING_SINE: f64 = 1e-15;

/// A unit vector at right angles to `v`: the cross product of `v` and the axis of space along which it has the smallest
/// component, the first among equals. The x axis if `v` is zero.
pub(super) fn perpendicular(v: DVec3) -> DVec3 {
    let size = v.abs();
    let least = if size.x <= size.y && size.x <= size.z {
        DVec3::X
    } else if size.y <= size.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    v.cross(least).try_normalize().unwrap_or(DVec3::X)
}

/// The part of `v` at right angles to the unit vector `axis`; `None` if `v` is along it up to rounding.
#[inline]
pub(super) fn across(v: DVec3, axis: DVec3) -> Option<DVec3> {
    let (all, once) = (v.length_squared(), v - axis * axis.dot(v));
    if once.length_squared() > SMALL_SINE * SMALL_SINE * all {
        return Some(once);
    }
    let twice = once - axis * axis.dot(once);
    (twice.length_squared() > ROUNDING_SINE * ROUNDING_SINE * all).then_some(twice)
}

/// The unit vector along `u x v` of unit vectors; `None` if they are parallel up to rounding. At right angles to both,
/// even if they are nearly parallel.
#[inline]
pub(super) fn normal_to(u: DVec3, v: DVec3) -> Option<DVec3> {
    let cross = u.cross(v);
    let sine = cross.length();
    if sine > SMALL_SINE { Some(cross / sine) } else { Some(u.cross(across(v, u)?.normalize())) }
}

/// A unit vector at right angles to both, which have length one or zero; if they are parallel, one at right angles to
/// the longer.
pub(super) fn common_perpendicular(u: DVec3, v: DVec3) -> DVec3 {
    match (u == DVec3::ZERO, v == DVec3::ZERO) {
        (true, _) => perpendicular(v),
        (_, true) => perpendicular(u),
        _ => normal_to(u, v)
            .unwrap_or_else(|| perpendicular(if u.length_squared() >= v.length_squared() { u } else { v })),
    }
}
