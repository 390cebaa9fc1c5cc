//! Founder cells: one, or a row of them side by side.

use super::super::orientation::ALONG_X;
use crate::bodies::Bodies;
use crate::separation::Placed;
use crate::shape::Shape;
use glam::{DQuat, DVec3};

/// The distance between the axes of neighbours over the diameter: a gap of twice the default cutoff, so that no cell
/// pushes another in the first step.
const SPACING: f64 = 1.2;

/// Their orientation: along x, turned about z.
pub(super) fn orientation(angle: f64) -> DQuat {
    // The constant keeps the bits of founders without an angle.
    if angle == 0.0 { ALONG_X } else { DQuat::from_rotation_z(angle.to_radians()) * ALONG_X }
}

/// Places `count` cells, the middle of their row at `position`.
pub(super) fn add(
    [diameter, length]: [f64; 2],
    position: DVec3,
    angle: f64,
    count: u64,
    bodies: &mut Bodies,
    group: u32,
) {
    let shape = Shape::Spherocylinder { diameter, length };
    let orientation = orientation(angle);
    let across = orientation * DVec3::Y;
    for k in 0..count {
        let off = k as f64 - 0.5 * (count - 1) as f64;
        let position = if off == 0.0 { position } else { position + SPACING * diameter * off * across };
        bodies.push(Placed { shape, position, orientation }, group);
    }
}
