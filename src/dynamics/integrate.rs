//! `C(U)`: the configuration reached from `C^k` with one constant generalized velocity.
//!
//! `x(U) = x^k + dt u` and `q(U) = normalize(q^k + dt/2 (0, w) (x) q^k)`: a turn by `2 atan(|dt w| / 2)` about `w`.

use super::Twist;
use glam::{DQuat, DVec3};

/// Where a body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Centre.
    pub position: DVec3,
    /// Unit quaternion taking body axes to space.
    pub orientation: DQuat,
}

/// The pose reached from `from` in `dt` with the constant velocity `twist`.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relcp::dynamics::{Pose, Twist, advance};
/// let from = Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY };
/// let to = advance(from, Twist { linear: DVec3::X, angular: DVec3::ZERO }, 0.5);
/// assert_eq!(to.position, DVec3::new(0.5, 0.0, 0.0));
/// ```
#[inline]
pub fn advance(from: Pose, twist: Twist, dt: f64) -> Pose {
    let q = from.orientation;
    let half = 0.5 * dt * twist.angular;
    let turn = DQuat::from_xyzw(half.x, half.y, half.z, 0.0) * q;
    Pose { position: from.position + dt * twist.linear, orientation: (q + turn).normalize() }
}
