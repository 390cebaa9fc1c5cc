//! The unknowns of one body: what a scene needs and no more.
//!
//! A body in space has six (three of translation, three of rotation); a body of a planar scene has three
//! (x, y and the turn about z). Everything that holds generalized velocities or wrenches is generic over this
//! number, so a planar scene carries no out-of-plane unknowns anywhere, rather than projecting them away.

use glam::DVec3;

/// Unknowns of a body that moves in the x-y plane: `(x, y, turn about z)`.
pub const PLANAR: usize = 3;
/// Unknowns of a body that moves in space: `(x, y, z, turn about x, y, z)`.
pub const SPATIAL: usize = 6;

/// Packs a linear and an angular part (velocities, or a force and a torque) into the unknowns of one body.
///
/// ```
/// use glam::DVec3;
/// use relcp::internals::freedom::{pack, PLANAR};
/// assert_eq!(pack::<PLANAR>(DVec3::new(1.0, 2.0, 0.0), DVec3::Z * 3.0), [1.0, 2.0, 3.0]);
/// ```
#[inline]
pub fn pack<const D: usize>(linear: DVec3, angular: DVec3) -> [f64; D] {
    let mut out = [0.0; D];
    if D == PLANAR {
        out.copy_from_slice(&[linear.x, linear.y, angular.z]);
    } else {
        out.copy_from_slice(&[linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]);
    }
    out
}

/// The linear and the angular part of one body's unknowns; what the scene does not carry is exactly zero.
#[inline]
pub fn unpack<const D: usize>(packed: &[f64; D]) -> (DVec3, DVec3) {
    if D == PLANAR {
        (DVec3::new(packed[0], packed[1], 0.0), DVec3::new(0.0, 0.0, packed[2]))
    } else {
        (DVec3::new(packed[0], packed[1], packed[2]), DVec3::new(packed[3], packed[4], packed[5]))
    }
}
