//! The arrays of the bonds and joints that hold, and back.

use super::blocks::{f64s, sane, u32s};
use super::error::StateError;
use super::npz::{Archive, Block};
use crate::bodies::HeldBond;
use glam::DVec3;

/// The forces of bonds, which states have as those of contacts.
const FORCE: &str = "bond_force";
const TORQUE: &str = "bond_torque";

/// The bonds that hold, one row each, with their forces if requested.
pub(super) fn bond_blocks(bonds: &[HeldBond], with_forces: bool) -> Vec<Block> {
    if bonds.is_empty() {
        return Vec::new();
    }
    let both = |[[a, b, c], [d, e, f]]: [[f64; 3]; 2]| [a, b, c, d, e, f];
    let mut blocks = vec![
        u32s("bond", bonds.iter().map(|bond| [bond.number])),
        u32s("bond_bodies", bonds.iter().map(|bond| bond.bodies)),
        f64s("bond_at", bonds.iter().map(|bond| both(bond.at.map(|at| at.to_array())))),
        f64s("bond_length", bonds.iter().map(|bond| [bond.length])),
        u32s("bond_contact", bonds.iter().map(|bond| [u32::from(bond.contact)])),
        f64s("bond_energy", bonds.iter().map(|bond| [bond.bending_energy])),
    ];
    if with_forces {
        blocks.push(f64s(FORCE, bonds.iter().map(|bond| bond.force.to_array())));
        blocks.push(f64s(TORQUE, bonds.iter().map(|bond| bond.torque.to_array())));
    }
    blocks
}

/// Reads the arrays of [`bond_blocks`]; every bond must be of two of the `bodies` bodies. Forces that are not there are
/// NaN.
pub(super) fn read_bonds(source: &mut Archive, [rows, bodies]: [usize; 2]) -> Result<Vec<HeldBond>, StateError> {
    let numbers = source.u32s::<1>("bond", rows)?;
    let pairs = source.u32s::<2>("bond_bodies", rows)?;
    let at = sane("bond_at", source.f64s::<6>("bond_at", rows)?)?;
    let lengths = sane("bond_length", source.f64s::<1>("bond_length", rows)?)?;
    let contacts = source.u32s::<1>("bond_contact", rows)?;
    let energies = source.f64s::<1>("bond_energy", rows)?;
    let mut forces = |name: &'static str| {
        if source.has(name) { source.f64s::<3>(name, rows) } else { Ok(vec![[f64::NAN; 3]; rows]) }
    };
    let (forces, torques) = (forces(FORCE)?, forces(TORQUE)?);
    let known = |pair: [u32; 2]| pair[0] != pair[1] && pair.iter().all(|body| (*body as usize) < bodies);
    if let Some(row) = pairs.iter().position(|pair| !known(*pair)) {
        return Err(StateError::row("bond_bodies", row));
    }
    let bond = |row: usize| {
        let [a, b, c, d, e, f] = at[row];
        HeldBond {
            number: numbers[row][0],
            bodies: pairs[row],
            at: [DVec3::new(a, b, c), DVec3::new(d, e, f)],
            length: lengths[row][0],
            force: forces[row].into(),
            torque: torques[row].into(),
            bending_energy: energies[row][0],
            contact: contacts[row] != [0],
        }
    };
    Ok((0..rows).map(bond).collect())
}
