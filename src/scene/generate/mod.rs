//! Bodies placed by rule.

mod chainmail;
mod isotropic;
mod occupied;

pub(super) use chainmail::MAX_RING_RATIO;
pub(super) use isotropic::reachable_fraction;

use super::error::SceneError;
use super::{Generate, Scene};
use crate::bodies::Bodies;
use crate::separation::Placed;
use glam::{DQuat, DVec3};

/// Adds the bodies of the scene's rule `index`, all in the group of number `group`.
pub(super) fn add(scene: &Scene, index: usize, bodies: &mut Bodies, group: u32) -> Result<(), SceneError> {
    match &scene.generate[index] {
        Generate::Isotropic { count, shape, volume_fraction, .. } => {
            let order = isotropic::Order {
                count: *count,
                shape: *shape,
                volume_fraction: *volume_fraction,
                planar: scene.planar,
                seed: scene.seed,
                rule: index,
            };
            isotropic::add(&order, bodies, group)
        }
        Generate::Chainmail { columns, rows, major_radius, minor_radius, .. } => {
            chainmail::add(*columns, *rows, *major_radius, *minor_radius, bodies, group);
            Ok(())
        }
        rule @ Generate::Founder { .. } => {
            // The quarter turn about y takes the axis, body z, to x.
            let orientation =
                DQuat::from_xyzw(0.0, std::f64::consts::FRAC_1_SQRT_2, 0.0, std::f64::consts::FRAC_1_SQRT_2);
            bodies.push(Placed { shape: rule.shape(), position: DVec3::ZERO, orientation }, group);
            Ok(())
        }
    }
}
