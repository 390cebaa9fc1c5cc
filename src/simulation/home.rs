//! Where a simulation starts, from which no body may run away.
//!
//! A body that is a million of its thicknesses off was driven there: by a force that grows with the distance, or by
//! steps that are too long for the forces. Without an end such a run goes on for ever with numbers that mean nothing.

use crate::bodies::Bodies;
use crate::step::Fault;
use glam::DVec3;

/// So many of its thicknesses from where all bodies start a body has run away.
const FARTHEST: f64 = 1e6;

/// The ball that holds the centres of the bodies that a simulation starts with.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Home {
    middle: DVec3,
    radius: f64,
}

impl Home {
    pub fn of(bodies: &Bodies) -> Home {
        let [low, high] = bodies
            .position
            .iter()
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]);
        if bodies.is_empty() {
            Home::default()
        } else {
            Home { middle: 0.5 * (low + high), radius: 0.5 * low.distance(high) }
        }
    }

    /// Its middle and its radius.
    #[cfg(feature = "mpi")]
    pub fn numbers(self) -> [f64; 4] {
        let [x, y, z] = self.middle.to_array();
        [x, y, z, self.radius]
    }

    /// The ball of these numbers.
    #[cfg(feature = "mpi")]
    pub fn of_numbers([x, y, z, radius]: [f64; 4]) -> Home {
        Home { middle: DVec3::new(x, y, z), radius }
    }

    /// The first body that has run away, as the fault of the step that it was taken in.
    pub fn left_by(&self, bodies: &Bodies, step: u64) -> Option<Fault> {
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
        let home = Home::of(&balls(&[1e9, 1e9 + 10.0]));
        assert_eq!(home.left_by(&balls(&[1e9 - 9e5, 1e9 + 9e5]), 3), None);
        let fault = home.left_by(&balls(&[1e9, 1e9 + 1.1e6]), 3).unwrap();
        assert!(matches!(fault, Fault::RunAway { step: 3, body: 1, .. }), "{fault}");
        assert_eq!(Home::of(&balls(&[])).left_by(&balls(&[]), 1), None);
    }
}
