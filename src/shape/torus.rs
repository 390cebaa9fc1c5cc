//! The torus: a circle in the body's x-y plane, thickened. Volume `2 pi^2 R r^2`; inertia of the solid about its axis
//! `m (R^2 + 3/4 r^2)`, across it `m (R^2 / 2 + 5/8 r^2)`.

use super::{ProxyError, ProxySphere, ShapeError, check_aspect, check_size};
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

/// Bretherton's constants of a thin disc across z.
pub(super) const BRETHERTON: DVec3 = DVec3::new(1.0, -1.0, 0.0);

pub(super) fn validate(major_radius: f64, minor_radius: f64) -> Result<(), ShapeError> {
    check_size("major_radius", major_radius)?;
    check_size("minor_radius", minor_radius)?;
    if minor_radius >= major_radius {
        return Err(ShapeError::NoHole { major_radius, minor_radius });
    }
    check_aspect("minor_radius", major_radius, minor_radius)
}

pub(super) fn volume(major_radius: f64, minor_radius: f64) -> f64 {
    2.0 * PI * PI * major_radius * minor_radius * minor_radius
}

pub(super) fn unit_inertia(major_radius: f64, minor_radius: f64) -> DVec3 {
    let (major, minor) = (major_radius * major_radius, minor_radius * minor_radius);
    let across = 0.5 * major + 0.625 * minor;
    DVec3::new(across, across, major + 0.75 * minor) * volume(major_radius, minor_radius)
}

/// The circle reaches `R sqrt(1 - k_i^2)` along axis `i`, with `k` its normal; the root is taken of the other two
/// components, which does not cancel where `k` lies on an axis.
#[inline]
pub(super) fn half_extents(major_radius: f64, minor_radius: f64, orientation: DQuat) -> DVec3 {
    let k = orientation * DVec3::Z;
    let across = DVec3::new(k.y.hypot(k.z), k.z.hypot(k.x), k.x.hypot(k.y));
    across * major_radius + DVec3::splat(minor_radius)
}

pub(super) fn check_proxy(major_radius: f64, minor_radius: f64, count: usize) -> Result<(), ProxyError> {
    let least = (PI / (minor_radius / major_radius).asin()).ceil() as usize;
    if count < least { Err(ProxyError::TooFew { count, least }) } else { Ok(()) }
}

/// Equal spheres on the centreline, equally spaced, the first on the body's x; neighbours must overlap or touch
/// (chord at most `2 r`), or another ring could slip through.
pub(super) fn proxy(major_radius: f64, minor_radius: f64, count: usize) -> Result<Vec<ProxySphere>, ProxyError> {
    check_proxy(major_radius, minor_radius, count)?;
    let at = |i: usize| {
        let (sine, cosine) = (TAU * i as f64 / count as f64).sin_cos();
        ProxySphere { centre: DVec3::new(cosine, sine, 0.0) * major_radius, radius: minor_radius }
    };
    Ok((0..count).map(at).collect())
}
