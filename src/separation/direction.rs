//! Directions where geometry leaves them open or hardly tells them. The same input gives the same direction, to the
//! bit.
//!
//! A vector that should be zero is rounding, and rounding has a direction too. So a direction is read from a difference
//! only where it is larger than its rounding, and what must be at right angles to an axis is made so: taken off once,
//! the part along the axis leaves a rounding of the whole vector, which beside a small rest is not small; taken off
//! twice, it leaves a rounding of the rest.

use glam::DVec3;

/// Sine under which a part is small beside the whole: above it, what is taken off once is right to 1e-13.
const SMALL_SINE: f64 = 1e-3;
/// Sine under which a part is rounding of the whole: some five roundings.
pub(super) const ROUNDING_SINE: f64 = 1e-15;

/// A unit vector at right angles to `v`: `v` crossed with the axis of space that it leans on least, the first of
/// equals. The x axis where `v` is zero.
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

/// The part of `v` at right angles to the unit vector `axis`; `None` where `v` is along it but for rounding.
#[inline]
pub(super) fn across(v: DVec3, axis: DVec3) -> Option<DVec3> {
    let (all, once) = (v.length_squared(), v - axis * axis.dot(v));
    if once.length_squared() > SMALL_SINE * SMALL_SINE * all {
        return Some(once);
    }
    let twice = once - axis * axis.dot(once);
    (twice.length_squared() > ROUNDING_SINE * ROUNDING_SINE * all).then_some(twice)
}

/// The unit vector along `u x v` of unit vectors; `None` where they are parallel but for rounding. At right angles to
/// both, however nearly parallel they are.
#[inline]
pub(super) fn normal_to(u: DVec3, v: DVec3) -> Option<DVec3> {
    let cross = u.cross(v);
    let sine = cross.length();
    if sine > SMALL_SINE { Some(cross / sine) } else { Some(u.cross(across(v, u)?.normalize())) }
}

/// A unit vector at right angles to both, which are of length one or zero; where they are parallel, one at right angles
/// to the longer.
pub(super) fn common_perpendicular(u: DVec3, v: DVec3) -> DVec3 {
    match (u == DVec3::ZERO, v == DVec3::ZERO) {
        (true, _) => perpendicular(v),
        (_, true) => perpendicular(u),
        _ => normal_to(u, v)
            .unwrap_or_else(|| perpendicular(if u.length_squared() >= v.length_squared() { u } else { v })),
    }
}
