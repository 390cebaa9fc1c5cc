//! The sphere: the one shape without an axis. Volume `4/3 pi r^3`, inertia `2/5 m r^2`.

use super::{ProxyError, ProxySphere, ShapeError, check_size};
use glam::DVec3;
use std::f64::consts::PI;

pub(super) fn validate(radius: f64) -> Result<(), ShapeError> {
    check_size("radius", radius)
}

pub(super) fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

pub(super) fn unit_inertia(radius: f64) -> DVec3 {
    DVec3::splat(0.4 * volume(radius) * radius * radius)
}

pub(super) fn check_proxy(count: usize) -> Result<(), ProxyError> {
    if count == 0 { Err(ProxyError::TooFew { count, least: 1 }) } else { Ok(()) }
}

/// A sphere is its own proxy.
pub(super) fn proxy(radius: f64, count: usize) -> Result<Vec<ProxySphere>, ProxyError> {
    check_proxy(count)?;
    Ok(vec![ProxySphere { centre: DVec3::ZERO, radius }])
}
