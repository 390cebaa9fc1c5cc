//! Bodies placed by rule.

mod chainmail;
mod isotropic;
mod occupied;

pub(super) use chainmail::MAX_RING_RATIO;
pub(super) use isotropic::reachable_fraction;

use super::error::{FaultKind, SceneError};
use super::{Generate, Scene};
use crate::bodies::Bodies;
use crate::separation::Placed;
use crate::walls::Walls;
use glam::{DQuat, DVec3};

/// Adds the bodies of the scene's rule `index`, all in the group of number `group`, and inside of the walls.
pub(super) fn add(scene: &Scene, index: usize, bodies: &mut Bodies, group: u32) -> Result<(), SceneError> {
    let (first, walls) = (bodies.len(), Walls::of(scene));
    place(scene, index, &walls, bodies, group)?;
    for i in first..bodies.len() {
        if let Some((depth, wall)) =
            walls.deepest(&bodies.placed(i)).filter(|(d, _)| *d > scene.contact.overlap_tolerance)
        {
            let key = format!("generate.{index}.{}", scene.generate[index].name());
            return Err(SceneError::new(FaultKind::Placement, key, scene.outside(depth, wall)));
        }
    }
    Ok(())
}

fn place(scene: &Scene, index: usize, walls: &Walls, bodies: &mut Bodies, group: u32) -> Result<(), SceneError> {
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
            isotropic::add(&order, walls, bodies, group)
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
