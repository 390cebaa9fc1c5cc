//! Fixed directions for normals that geometry leaves open. The same input gives the same normal, to the bit.

use glam::DVec3;

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

/// A unit vector at right angles to both; where they are parallel, one at right angles to the longer.
pub(super) fn common_perpendicular(u: DVec3, v: DVec3) -> DVec3 {
    /// Sine below which the cross product of unit vectors holds no digit: ten roundings.
    const PARALLEL_SINE: f64 = 2e-15;
    let cross = u.cross(v);
    let sine = cross.length();
    if sine > PARALLEL_SINE {
        cross / sine
    } else if u.length_squared() >= v.length_squared() {
        perpendicular(u)
    } else {
        perpendicular(v)
    }
}
