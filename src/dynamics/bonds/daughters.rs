//! Bonds between daughters, which later divisions inherit.
//!
//! A division gives the two ends of the daughters that meet the same number: the mother's id and one. Each daughter
//! keeps the number at her other end. The bonds of a state are the pairs of an upper and a lower end with the same
//! number, so that inheritance needs nothing more. The numbers are two named columns of the bodies, zero where an end
//! has no bond. They are recorded with a state as all columns are.

use super::{Bending, Bond, Bonds};
use crate::bodies::{Bodies, Columns, HeldBond};
use crate::dynamics::Cells;
use crate::shape::Shape;
use std::collections::BTreeMap;

/// The columns of both ends: the lower one, at the start of body z, and the upper one.
pub(crate) const ENDS: [&str; 2] = ["lower_bond", "upper_bond"];

/// The largest number of an end that a column has exactly.
pub(crate) const LARGEST_END: u64 = 1 << 53;

/// The default gap, in diameters. Without a gap a rigid bond and the contact of both caps would say the same twice, and
/// contradict each other by rounding; in a soft bond the contact carries what presses the cells together.
const GAP: f64 = 0.01;

/// The axis of a rod.
const AXIS: [f64; 3] = [0.0, 0.0, 1.0];

/// The bond that a division makes between two daughters, from the middle of the end cap of one to that of the other. It
/// is implicit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct DaughterBond {
    /// Its stiffness, force over distance; or `"rigid"`, which is an infinite one in code.
    #[cfg_attr(feature = "files", serde(with = "super::stiffness"), schemars(with = "super::stiffness::Stiffness"))]
    pub stiffness: f64,
    /// The distance between both caps at rest: its rest length is the diameter of the cell and this. Without it: a
    /// hundredth of the diameter.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub gap: Option<f64>,
    /// Its bending stiffness, torque over angle; or `"rigid"`. Without it: cells turn freely.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", serde(with = "super::stiffness::optional"))]
    #[cfg_attr(feature = "files", schemars(with = "super::stiffness::Stiffness"))]
    pub bending: Option<f64>,
    /// The tension above which it breaks. Without it: never.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub break_force: Option<f64>,
}

impl DaughterBond {
    /// An unbreakable bond with the default gap, without bending stiffness.
    pub const fn new(stiffness: f64) -> DaughterBond {
        DaughterBond { stiffness, gap: None, bending: None, break_force: None }
    }

    /// The bond from the upper end of body `a` to the lower end of body `b`.
    fn between(&self, bodies: [usize; 2], shapes: [&Shape; 2]) -> Bond {
        let [upper, lower] = shapes.map(reach);
        Bond {
            length: shapes[0].thickness() + self.gap.unwrap_or_else(|| GAP * shapes[0].thickness()),
            implicit: Some(true),
            bending: self.bending.map(|stiffness| Bending { stiffness, axes: Some([AXIS; 2]) }),
            break_force: self.break_force,
            ..Bond::new(bodies, [[0.0, 0.0, upper], [0.0, 0.0, 0.0 - lower]], self.stiffness)
        }
    }
}

/// From a cell's centre to the middle of an end cap.
fn reach(shape: &Shape) -> f64 {
    shape.growing_length().map_or(0.0, |length| (0.5 * (length - shape.thickness())).max(0.0))
}

/// Gives the daughters of the cell `mother`, which have the places `lower` and `upper` of `count`, a bond.
pub(crate) fn join(columns: &mut Columns, count: usize, mother: u64, [lower, upper]: [usize; 2]) {
    for (end, body) in ENDS.into_iter().zip([upper, lower]) {
        columns.named_mut(end, count)[body] = mother.saturating_add(1) as f64;
    }
}

/// The bonds of daughters, with the present indices of their bodies.
pub(crate) fn bonds_of(bodies: &Bodies, cells: &Cells) -> Bonds {
    let [Some(lower), Some(upper)] = ENDS.map(|end| bodies.columns.get(end)) else { return Bonds::default() };
    // The number of an end is a whole one, and its bits are in the order of their numbers.
    let ends = |column: &[f64]| -> BTreeMap<u64, usize> {
        (0..).zip(column).filter(|(_, end)| **end > 0.0).map(|(body, end)| (end.to_bits(), body)).collect()
    };
    let lower = ends(lower);
    let bond = |(end, a): (u64, usize)| {
        let b = *lower.get(&end).filter(|b| **b != a)?;
        let settings = cells.of(bodies.group[a])?.growth.bond_daughters?;
        Some(settings.between([a, b], [&bodies.shape[a], &bodies.shape[b]]))
    };
    let list: Vec<Bond> = ends(upper).into_iter().filter_map(bond).collect();
    Bonds::new(&list, |body| bodies.lineage[body].id)
}

/// The bonds of daughters as a state has them, numbered after the `first` ones of its scene.
pub(crate) fn held_daughters(bodies: &Bodies, cells: &Cells, first: usize) -> Vec<HeldBond> {
    let bonds = bonds_of(bodies, cells);
    let held = |(number, bond): (usize, &Bond)| {
        let held = bonds.as_held(number, bond.bodies, bodies, None);
        HeldBond { number: (first + number) as u32, ..held }
    };
    bonds.list().iter().enumerate().map(held).collect()
}

/// Whether the upper end of the first of two bodies has no bond.
pub(crate) fn is_parted(bodies: &Bodies, [a, _]: [usize; 2]) -> bool {
    bodies.columns.get(ENDS[1]).is_none_or(|upper| upper[a] == 0.0)
}

/// Breaks the bond from the upper end of one body to the lower end of another, of `count`.
pub(crate) fn part(columns: &mut Columns, count: usize, [a, b]: [usize; 2]) {
    for (end, body) in ENDS.into_iter().zip([b, a]) {
        columns.named_mut(end, count)[body] = 0.0;
    }
}
