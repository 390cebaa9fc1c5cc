//! Poses, velocities and boxes of bodies, and the motion `C(U)`: the configuration reached from `C^k` with one constant
//! generalized velocity.
//!
//! `x(U) = x^k + dt u` and `q(U) = normalize(q^k + dt/2 (0, w) (x) q^k)`: a turn by `2 atan(|dt w| / 2)` about `w`.

use glam::{DQuat, DVec3};

/// Where a body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Centre.
    pub position: DVec3,
    /// Unit quaternion taking body axes to space.
    pub orientation: DQuat,
}

/// A generalized velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Velocity of the centre.
    pub linear: DVec3,
    /// Angular velocity, space axes.
    pub angular: DVec3,
}

/// The pose reached from `from` in `dt` with the constant velocity `twist`.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relcp::internals::dynamics::{Pose, Twist, advance};
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

/// An axis-aligned box, closed: it holds its faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lowest corner.
    pub min: DVec3,
    /// Highest corner.
    pub max: DVec3,
}

impl Aabb {
    /// The box of centre `centre` that reaches `half` to each side.
    pub fn from_centre(centre: DVec3, half: DVec3) -> Self {
        Aabb { min: centre - half, max: centre + half }
    }

    /// Whether both corners are finite and no edge is negative. A box that is not proper touches nothing.
    pub fn is_proper(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }

    /// Whether two proper boxes share a point, faces counted.
    pub fn touches(&self, other: &Aabb) -> bool {
        // No early way out: which of the six fails is hard to foresee.
        let (a, b) = (self, other);
        ((a.min.x <= b.max.x) & (a.min.y <= b.max.y) & (a.min.z <= b.max.z))
            & ((b.min.x <= a.max.x) & (b.min.y <= a.max.y) & (b.min.z <= a.max.z))
    }

    /// Whether `other` lies inside this box, faces counted.
    pub fn contains(&self, other: &Aabb) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// The box pushed out by `margin` on every side.
    pub fn inflated(&self, margin: f64) -> Self {
        Aabb { min: self.min - margin, max: self.max + margin }
    }
}
