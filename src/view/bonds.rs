//! The bonds that hold in a state: of the scene, of chains, joints, and those of daughters.

use super::columns::Block;
use crate::bodies::{Bodies, HeldBond};
use glam::DVec3;

/// Names of the columns with both ends of each bond, along x, y and z of its bodies.
const ENDS: [[&str; 3]; 2] = [["bond_ax", "bond_ay", "bond_az"], ["bond_bx", "bond_by", "bond_bz"]];

/// What the last state had.
#[derive(Default)]
pub(super) struct Bonds {
    last: Vec<([u32; 2], [DVec3; 2])>,
    /// Whether a state had some.
    pub any: bool,
}

impl Bonds {
    /// Adds those of a state where they are not those of the last one: the rows of both bodies, and the ends.
    pub fn pack(&mut self, bodies: &Bodies, block: &mut Block) {
        let of = |bond: &HeldBond| (bond.bodies, bond.at);
        let bonds: Vec<_> = bodies.bonds.iter().map(of).collect();
        if bonds == self.last {
            return;
        }
        for (which, name) in ["bond_a", "bond_b"].into_iter().enumerate() {
            block.add(name, &bonds.iter().map(|(rows, _)| rows[which]).collect::<Vec<_>>());
        }
        for (which, names) in ENDS.iter().enumerate() {
            for (axis, name) in names.iter().enumerate() {
                block.add_floats(name, bonds.iter().map(|(_, ends)| ends[which][axis]));
            }
        }
        self.any |= !bonds.is_empty();
        self.last = bonds;
    }
}
