//! Orientations of a scene: `[w, x, y, z]`, normalized on reading, or the direction of the body's axis.

use super::{Body, Scene};
use glam::{DQuat, DVec3};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

/// The quarter turn about y, which takes the axis of a rod, body z, to x.
pub(super) const ALONG_X: DQuat = DQuat::from_xyzw(0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);

const IDENTITY: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

impl Body {
    /// Its orientation, from `orientation`, `axis` or `angle`; the identity without these.
    ///
    /// ```
    /// use relcp::{Shape, scene::Body};
    /// let mut rod = Body::new(Shape::Spherocylinder { diameter: 0.5, length: 2.0 }, [0.0; 3]);
    /// rod.axis = Some([0.0, 3.0, 0.0]);
    /// let axis = rod.rotation() * glam::DVec3::Z;
    /// assert!((axis - glam::DVec3::Y).length() < 1e-15);
    /// ```
    pub fn rotation(&self) -> DQuat {
        match (self.axis, self.angle) {
            (Some(axis), _) => along(DVec3::from(axis)),
            (None, Some(angle)) => DQuat::from_rotation_z(angle.to_radians()) * ALONG_X,
            (None, None) => unit(self.orientation.unwrap_or(IDENTITY)),
        }
    }

    /// The key that sets the orientation.
    pub(super) fn orientation_key(&self) -> &'static str {
        match (self.axis, self.angle) {
            (Some(_), _) => "axis",
            (None, Some(_)) => "angle",
            (None, None) => "orientation",
        }
    }
}

/// The rotation that takes z to an axis and leaves y in the x-y plane: first about y, then about z.
pub(super) fn along(axis: DVec3) -> DQuat {
    let across = axis.truncate().length();
    if across == 0.0 {
        return if axis.z < 0.0 { DQuat::from_rotation_y(2.0 * FRAC_PI_2) } else { DQuat::IDENTITY };
    }
    DQuat::from_rotation_z(axis.y.atan2(axis.x)) * DQuat::from_rotation_y(across.atan2(axis.z))
}

impl Scene {
    /// Writes the identity for a body without an orientation.
    pub(super) fn write_orientations(&mut self) {
        for body in self.bodies.iter_mut().filter(|body| body.axis.is_none() && body.angle.is_none()) {
            body.orientation.get_or_insert(IDENTITY);
        }
    }
}

/// How far a squared norm may be from one to count as normalized: rounding of a normalized quaternion stays below four
/// epsilons. Such a quaternion is left unchanged, so that a state that was written is read to the same bits.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The norm, without overflow or underflow.
pub(crate) fn norm(q: [f64; 4]) -> f64 {
    let scale = q.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if scale == 0.0 {
        return 0.0;
    }
    scale * q.iter().map(|x| (x / scale).powi(2)).sum::<f64>().sqrt()
}

fn normalized(q: [f64; 4]) -> [f64; 4] {
    let square: f64 = q.iter().map(|x| x * x).sum();
    if (square - 1.0).abs() <= ROUNDING {
        return q;
    }
    let norm = norm(q);
    q.map(|x| x / norm)
}

/// The rotation, normalized.
pub(crate) fn unit(q: [f64; 4]) -> DQuat {
    let [w, x, y, z] = normalized(q);
    DQuat::from_xyzw(x, y, z, w)
}

/// As in a scene file.
pub(super) fn written(q: DQuat) -> [f64; 4] {
    [q.w, q.x, q.y, q.z]
}

#[cfg(feature = "files")]
impl Scene {
    pub(super) fn normalize_orientations(&mut self) {
        for body in &mut self.bodies {
            body.orientation = body.orientation.map(normalized);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalizing_is_idempotent_and_survives_extremes() {
        for q in [[2.0, 0.0, 0.0, 0.0], [1e-5, 2e-5, -3e-5, 1e-6], [1e60, 1e60, 0.0, 1.0], [0.3, -0.4, 0.5, 0.6]] {
            let once = normalized(q);
            assert_eq!(normalized(once), once);
            assert!((norm(once) - 1.0).abs() < 1e-15, "{q:?}");
        }
        assert_eq!(norm([0.0; 4]), 0.0);
    }
}
