//! The longest step in which a bond is stable.
//!
//! The step takes a bond's pull as it is at its start. A stretch `d` so becomes `(1 - dt k M) d` in an overdamped step,
//! with `M` the mobility of the two points towards each other, and grows without bound where `dt k M > 2`; in a
//! midpoint step, `1 - z + z^2 / 2` with `z = dt k M`, likewise. Without drag a body with inertia is moved by the
//! velocity that the pull has changed, which is stable where `dt^2 k M <= 4` (the leapfrog's limit).

use super::Bond;
use crate::dynamics::Dynamics;
use crate::dynamics::overdamped::resistances;
use crate::shape::Shape;
use glam::DVec3;
use nalgebra::{Matrix3, Vector3};

/// What the stability of a bond depends on beside itself.
pub(crate) struct Stiffness<'a> {
    pub dynamics: &'a Dynamics,
    pub shapes: [&'a Shape; 2],
    /// Which of both bodies do not move.
    pub fixed: [bool; 2],
    /// From each centre to its point, space axes, where it is known.
    pub arms: [Option<DVec3>; 2],
    /// From the first point to the other, where it is known.
    pub way: Option<DVec3>,
}

impl Stiffness<'_> {
    /// The longest step in which the bond alone is stable; `None` where that is not known: with inertia and drag, where
    /// drag allows longer steps than inertia alone.
    pub fn longest_step(&self, bond: &Bond) -> Option<f64> {
        match self.dynamics {
            Dynamics::Overdamped { drag } => {
                let point = |end: usize| self.mobility(*drag, end);
                let rate = bond.stiffness * self.along(bond, point(0) + point(1));
                Some(2.0 / rate)
            }
            law => {
                if law.drag_beside_inertia().is_some() {
                    return None;
                }
                let density = law.density()?;
                let moving = self.shapes.iter().zip(self.fixed).filter(|(_, fixed)| !fixed);
                let lightness: f64 = moving.map(|(shape, _)| 1.0 / (density * shape.volume())).sum();
                Some(2.0 / (bond.stiffness * lightness).sqrt())
            }
        }
    }

    /// The mobility of a point of an overdamped body: translational and rotational. A fixed body has none.
    fn mobility(&self, drag: f64, end: usize) -> Matrix3<f64> {
        if self.fixed[end] {
            return Matrix3::zeros();
        }
        let (linear, turning) = resistances(drag, self.shapes[end]);
        let arm = self.arms[end].map_or(Vector3::zeros(), |arm| Vector3::from(arm.to_array()));
        let across = Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose();
        Matrix3::from_diagonal_element(1.0 / linear) + across / turning
    }

    /// Of a mobility the part that a bond's stretch has: along its direction, and where it has no length along every
    /// one. Where the direction is not known it is the least of all.
    fn along(&self, bond: &Bond, mobility: Matrix3<f64>) -> f64 {
        let values = mobility.symmetric_eigenvalues();
        if bond.length == 0.0 {
            return values.max();
        }
        let direction = self.way.and_then(DVec3::try_normalize).map(|way| Vector3::from(way.to_array()));
        direction.map_or(values.min(), |way| way.dot(&(mobility * way)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rods end to end, overdamped: at their tips `1 / xi L` along them, four times that across.
    #[test]
    fn a_joint_of_two_rods_is_stable_by_the_mobility_of_their_tips() {
        let rod = Shape::Spherocylinder { diameter: 0.2, length: 2.0 };
        let dynamics = Dynamics::Overdamped { drag: 1.5 };
        let arms = [Some(DVec3::X), Some(-DVec3::X)];
        let of = |fixed| Stiffness { dynamics: &dynamics, shapes: [&rod; 2], fixed, arms, way: Some(0.1 * DVec3::X) };
        let stiffness = of([false; 2]);
        let bond = |length| Bond { length, ..Bond::new([0, 1], [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], 10.0) };
        let (linear, along) = (1.0 / (1.5 * 2.0), stiffness.longest_step(&bond(0.1)).unwrap());
        assert!((along - 2.0 / (10.0 * 2.0 * linear)).abs() < 1e-12, "{along}");
        let every = stiffness.longest_step(&bond(0.0)).unwrap();
        assert!((every - 0.25 * along).abs() < 1e-12, "{every}");
        let tether = of([true, false]).longest_step(&bond(0.1)).unwrap();
        assert!((tether - 2.0 * along).abs() < 1e-12, "a fixed end does not move: {tether}");
    }
}
