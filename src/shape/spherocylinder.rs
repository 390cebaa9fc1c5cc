//! The spherocylinder: a segment on the body's z, thickened. `length` is tip to tip.
//!
//! Inertia: the cylinder's, plus that of two half balls shifted outwards; a half ball's second moment about a line
//! through the centre of its flat face is `2/5 m r^2` and its centre of mass lies `3/8 r` from that face.

use super::{Centreline, ProxyError, ProxySphere, ShapeError, check_aspect, check_axis_count, check_size};
use glam::{DQuat, DVec3};
use std::f64::consts::PI;

pub(super) fn validate(diameter: f64, length: f64) -> Result<(), ShapeError> {
    check_size("diameter", diameter)?;
    check_size("length", length)?;
    if length < diameter {
        return Err(ShapeError::ShorterThanDiameter { length, diameter });
    }
    check_aspect("length", length, diameter)
}

#[inline]
pub(super) fn centreline(diameter: f64, length: f64) -> Centreline {
    Centreline::Segment { half: 0.5 * (length - diameter) }
}

pub(super) fn volume(diameter: f64, length: f64) -> f64 {
    let radius = 0.5 * diameter;
    PI * radius * radius * (length - diameter + 4.0 / 3.0 * radius)
}

pub(super) fn unit_inertia(diameter: f64, length: f64) -> DVec3 {
    let (radius, straight) = (0.5 * diameter, length - diameter);
    let cylinder = PI * radius * radius * straight;
    let ball = 4.0 / 3.0 * PI * radius.powi(3);
    let along = (0.5 * cylinder + 0.4 * ball) * radius * radius;
    let across = cylinder * (straight * straight / 12.0 + 0.25 * radius * radius)
        + ball * (0.4 * radius * radius + 0.25 * straight * straight + 0.375 * straight * radius);
    DVec3::new(across, across, along)
}

#[inline]
pub(super) fn half_extents(diameter: f64, length: f64, orientation: DQuat) -> DVec3 {
    (orientation * DVec3::Z).abs() * (0.5 * (length - diameter)) + DVec3::splat(0.5 * diameter)
}

/// Equal spheres, equally spaced on the segment, the outermost on its ends: where the surface is a cylinder every
/// sphere touches it along a circle, and at the tips the proxy is exact. Far apart spheres leave grooves, or gaps: a
/// coarse proxy is what the method is compared with, so a gap is not refused here.
pub(super) fn proxy(diameter: f64, length: f64, count: usize) -> Result<Vec<ProxySphere>, ProxyError> {
    check_axis_count(count)?;
    let side = (count / 2) as i64;
    let spacing = 0.5 * (length - diameter) / side as f64;
    let radius = 0.5 * diameter;
    Ok((-side..=side).map(|i| ProxySphere { centre: DVec3::Z * (spacing * i as f64), radius }).collect())
}

/// Bretherton's constants of a thin rod along z; one as long as it is thick is a ball.
pub(super) fn bretherton(diameter: f64, length: f64) -> DVec3 {
    if length == diameter { DVec3::ZERO } else { DVec3::new(-1.0, 1.0, 0.0) }
}
