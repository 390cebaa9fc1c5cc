//! What a state has of each bond and joint that holds: its bodies, where it ends, and what it does.

use super::Bodies;
use glam::DVec3;

/// A bond, or a joint, that holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldBond {
    /// Its number: the scene's bonds first, then those of chains, joints, and the bonds of daughters.
    pub number: u32,
    /// The rows of its two bodies.
    pub bodies: [u32; 2],
    /// Its end on each body, body axes.
    pub at: [DVec3; 2],
    /// Its rest length.
    pub length: f64,
    /// The force on the second body, at its end. That of an implicit bond is the one of the last step, zero before the
    /// first; NaN where it is not known.
    pub force: DVec3,
    /// The torque on the second body about its end, as `force`: of bends and turns that it resists.
    pub torque: DVec3,
    /// The energy of its bends and turns.
    pub bending_energy: f64,
    /// Whether its bodies collide.
    pub contact: bool,
}

impl HeldBond {
    /// From its first end to the second, and the place of the first.
    pub fn way(&self, bodies: &Bodies) -> (DVec3, DVec3) {
        let [a, b] = self.bodies.map(|body| bodies.pose(body as usize));
        let arms = [a.orientation * self.at[0], b.orientation * self.at[1]];
        (bodies.periods.nearest(b.position - a.position) + (arms[1] - arms[0]), a.position + arms[0])
    }

    /// The force along the bond, positive where it pulls its ends together. One of length 0 has no direction: its force
    /// is then all of it.
    pub fn tension(&self, bodies: &Bodies) -> f64 {
        match self.way(bodies).0.try_normalize().filter(|_| self.length > 0.0) {
            Some(along) => -self.force.dot(along),
            None => self.force.length(),
        }
    }
}

impl Bodies {
    /// The pairs of bodies that a bond keeps from colliding, the lower row first, ascending.
    pub(crate) fn without_contact(&self) -> Vec<[u32; 2]> {
        let bonds = self.bonds.iter().filter(|bond| !bond.contact);
        sorted_pairs(bonds.map(|bond| bond.bodies))
    }

    /// Keeps the bonds of bodies that are kept, whose rows are then these.
    pub(super) fn retain_bonds(&mut self, keep: &[bool]) {
        if self.bonds.is_empty() {
            return;
        }
        let mut next = 0;
        let place = |kept: &bool| {
            let own = next;
            next += u32::from(*kept);
            kept.then_some(own)
        };
        let places: Vec<Option<u32>> = keep.iter().map(place).collect();
        self.bonds.retain_mut(|bond| match bond.bodies.map(|body| places.get(body as usize).copied().flatten()) {
            [Some(a), Some(b)] => {
                bond.bodies = [a, b];
                true
            }
            _ => false,
        });
    }
}

/// Pairs with the lower number first, ascending, each once.
pub(crate) fn sorted_pairs(pairs: impl Iterator<Item = [u32; 2]>) -> Vec<[u32; 2]> {
    let mut pairs: Vec<[u32; 2]> = pairs.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::NO_GROUP;
    use crate::separation::Placed;
    use crate::shape::Shape;
    use glam::DQuat;

    fn row_of_balls(count: usize) -> Bodies {
        let mut bodies = Bodies::default();
        for i in 0..count {
            let (shape, position) = (Shape::Sphere { radius: 0.5 }, DVec3::X * 2.0 * i as f64);
            bodies.push(Placed { shape, position, orientation: DQuat::IDENTITY }, NO_GROUP);
        }
        bodies
    }

    fn bond(number: u32, bodies: [u32; 2], force: DVec3) -> HeldBond {
        let at = [DVec3::ZERO; 2];
        HeldBond { number, bodies, at, length: 1.5, force, torque: DVec3::ZERO, bending_energy: 0.0, contact: true }
    }

    #[test]
    fn a_pull_towards_the_first_body_is_a_tension() {
        let bodies = row_of_balls(2);
        assert_eq!(bond(0, [0, 1], DVec3::new(-3.0, 4.0, 0.0)).tension(&bodies), 3.0);
        assert_eq!(bond(0, [1, 0], DVec3::new(-3.0, 4.0, 0.0)).tension(&bodies), -3.0);
        let joint = HeldBond { length: 0.0, ..bond(0, [0, 1], DVec3::new(-3.0, 4.0, 0.0)) };
        assert_eq!(joint.tension(&bodies), 5.0);
    }

    #[test]
    fn bonds_follow_their_bodies_and_go_with_them() {
        let mut bodies = row_of_balls(4);
        bodies.bonds = (0..3).map(|i| bond(i, [i, i + 1], DVec3::ZERO)).collect();
        bodies.retain(&[false, true, true, true]);
        let left: Vec<_> = bodies.bonds.iter().map(|bond| (bond.number, bond.bodies)).collect();
        assert_eq!(left, [(1, [0, 1]), (2, [1, 2])]);
    }
}
