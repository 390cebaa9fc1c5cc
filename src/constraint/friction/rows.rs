//! The tangent rows of a contact.

use super::super::{Mover, Row, blocks, torque_arm};
use crate::freedom::PLANAR;
use crate::separation::Separation;
use glam::DVec3;

/// The tangents are made from x unless the normal is as near to it as this, and then from y.
const NEAR_X: f64 = 0.7;

/// The tangents of a contact, from its normal alone; in the plane there is one, and the second is zero.
pub(crate) fn tangents<const D: usize>(normal: DVec3) -> [DVec3; 2] {
    if D == PLANAR {
        return [DVec3::Z.cross(normal), DVec3::ZERO];
    }
    let across = if normal.x.abs() < NEAR_X { DVec3::X } else { DVec3::Y };
    let first = normal.cross(across).normalize();
    [first, normal.cross(first)]
}

/// The elastic slip of a contact that sticks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ElasticSlip {
    /// `k`, a length over a force.
    pub compliance: f64,
    /// The friction force on the second body that the contact ended the last step with; zero for a new contact.
    pub held: DVec3,
}

/// A tangent row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tangent<const D: usize> {
    pub direction: DVec3,
    pub row: Row<D>,
    /// The multiplier that the contact ended the last step with.
    pub held: f64,
}

/// What friction adds to a contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sliding<const D: usize> {
    pub mu: f64,
    pub compliance: f64,
    /// In the plane only the first.
    tangents: [Tangent<D>; 2],
}

impl<const D: usize> Sliding<D> {
    /// That of a contact with separation `found`, whose surfaces move against each other by `surfaces` beside their
    /// bodies, a velocity.
    pub fn new(
        mu: f64,
        found: &Separation,
        [a, b]: [Mover<'_>; 2],
        surfaces: DVec3,
        slip: ElasticSlip,
        dt: f64,
    ) -> Self {
        let middle = 0.5 * found.separation * found.normal;
        let [lever_a, lever_b] = [found.lever_a + middle, found.lever_b - middle];
        let [free_a, free_b] = [a, b].map(|mover| mover.motion.free);
        let tangent = |direction: DVec3| {
            let arm_a = torque_arm(lever_a, direction, a.reached_with.angular, dt);
            let arm_b = torque_arm(lever_b, direction, b.reached_with.angular, dt);
            let linear = direction.dot(free_b.linear - free_a.linear + surfaces);
            let free = dt * (linear + arm_b.dot(free_b.angular) - arm_a.dot(free_a.angular));
            let held = slip.held.dot(direction);
            let jacobian = blocks([a, b], direction, [arm_a, arm_b], dt);
            Tangent { direction, row: (jacobian, free - slip.compliance * held), held }
        };
        Sliding { mu, compliance: slip.compliance, tangents: tangents::<D>(found.normal).map(tangent) }
    }

    /// The tangent rows.
    pub fn tangents(&self) -> &[Tangent<D>] {
        if D == PLANAR { &self.tangents[..1] } else { &self.tangents }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::freedom::SPATIAL;

    #[test]
    fn tangents_are_unit_vectors_at_right_angles() {
        for normal in [DVec3::X, DVec3::Y, DVec3::NEG_Z, DVec3::new(1.0, 2.0, -3.0).normalize()] {
            let [first, second] = tangents::<SPATIAL>(normal);
            assert!((first.length() - 1.0).abs() < 1e-15 && (second.length() - 1.0).abs() < 1e-15);
            assert!(first.cross(second).abs_diff_eq(normal, 1e-15), "{normal}");
        }
        let [in_plane, none] = tangents::<PLANAR>(DVec3::X);
        assert_eq!((in_plane, none), (DVec3::Y, DVec3::ZERO));
    }
}
