//! A sheet of interlaced rings, in the weave of European four-in-one mail.
//!
//! Centres are on a square lattice of the x-y plane. Every ring is tilted about the diagonal `(1, 1, 0)`, by plus
//! [`TILT`] if column + row is even and by minus if it is odd, so that each ring is linked with exactly its four
//! neighbours.

use crate::bodies::Bodies;
use crate::separation::Placed;
use crate::shape::Shape;
use glam::{DQuat, DVec3};

/// Lattice spacing over the major radius. Rings of equal tilt that are neighbours on the diagonal lie in one plane and
/// need a wide spacing: their centrelines are `sqrt(2) SPACING - 2` major radii apart. Linked rings need a narrow one.
const SPACING: f64 = 1.6;
/// Tilt in radians. A search over spacing and tilt (0.002 and half a degree apart) found the two limits balanced here:
/// no two centrelines are nearer than 0.2627 major radii, the most that this weave allows.
const TILT: f64 = 0.45;
/// Largest minor radius over the major radius: between surfaces 0.0227 major radii are left.
pub(in super::super) const MAX_RING_RATIO: f64 = 0.12;

/// Places `columns * rows` rings, row by row.
pub(super) fn add(columns: u64, rows: u64, major_radius: f64, minor_radius: f64, bodies: &mut Bodies, group: u32) {
    let spacing = SPACING * major_radius;
    let middle = DVec3::new(0.5 * (columns - 1) as f64, 0.5 * (rows - 1) as f64, 0.0);
    let shape = Shape::Torus { major_radius, minor_radius };
    for row in 0..rows {
        for column in 0..columns {
            let position = spacing * (DVec3::new(column as f64, row as f64, 0.0) - middle);
            let tilt = if (column + row).is_multiple_of(2) { TILT } else { -TILT };
            let orientation = DQuat::from_axis_angle(DVec3::new(1.0, 1.0, 0.0).normalize(), tilt);
            bodies.push(Placed { shape, position, orientation }, group);
        }
    }
}
