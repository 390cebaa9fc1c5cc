//! The region where a simulation starts, and the check that no body runs away from it.
//!
//! A body a million thicknesses away was driven there by a force that grows with the distance, or by steps that are too
//! long for the forces. Without the check such a run would continue with meaningless numbers.

use crate::bodies::Bodies;
use crate::step::Fault;
use glam::DVec3;

/// A body has run away if it is this many of its thicknesses from the initial region.
const FARTHEST: f64 = 1e6;

/// The ball of the initial centres of all bodies.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InitialRegion {
    middle: DVec3,
    radius: f64,
}

impl InitialRegion {
    pub fn of(bodies: &Bodies) -> InitialRegion {
        let [low, high] = bodies
            .position
            .iter()
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]);
        if bodies.is_empty() {
            InitialRegion::default()
        } else {
            InitialRegion { middle: 0.5 * (low + high), radius: 0.5 * low.distance(high) }
        }
    }

    /// Its centre and radius.
    #[cfg(feature = "mpi")]
    pub fn numbers(self) -> [f64; 4] {
        let [x, y, z] = self.middle.to_array();
        [x, y, z, self.radius]
    }

    /// The ball of this centre and radius.
    #[cfg(feature = "mpi")]
    pub fn of_numbers([x, y, z, radius]: [f64; 4]) -> InitialRegion {
        InitialRegion { middle: DVec3::new(x, y, z), radius }
    }

    /// The first body that has run away, as a fault of the step.
    pub fn runaway(&self, bodies: &Bodies, step: u64) -> Option<Fault> {
        let left =
            |i: usize| self.middle.distance(bodies.position[i]) - self.radius > FARTHEST * bodies.shape[i].thickness();
        let body = (0..bodies.len()).find(|i| left(*i))?;
        Some(Fault::RunAway { step, body, distance: self.middle.distance(bodies.position[body]) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::separation::Placed;
    use crate::shape::Shape;
    use glam::DQuat;

    fn balls(x: &[f64]) -> Bodies {
        let mut bodies = Bodies::default();
        for x in x {
            let shape = Shape::Sphere { radius: 0.5 };
            bodies.push(Placed { shape, position: DVec3::new(*x, 0.0, 0.0), orientation: DQuat::IDENTITY }, 0);
        }
        bodies
    }

    #[test]
    fn a_body_has_run_away_a_million_thicknesses_from_all() {
        let region = InitialRegion::of(&balls(&[1e9, 1e9 + 10.0]));
        assert_eq!(region.runaway(&balls(&[1e9 - 9e5, 1e9 + 9e5]), 3), None);
        let fault = region.runaway(&balls(&[1e9, 1e9 + 1.1e6]), 3).unwrap();
        assert!(matches!(fault, Fault::RunAway { step: 3, body: 1, .. }), "{fault}");
        assert_eq!(InitialRegion::of(&balls(&[])).runaway(&balls(&[]), 1), None);
    }
}
