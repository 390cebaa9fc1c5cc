//! Overdamped local drag: `u = F / (xi L)`, `w = 12 T / (xi L^3)`, `L` the major axis length (the paper's ellipsoid
//! mobility).

use super::{Ending, Factor, Law, Load, Motion, Twist};
use crate::bodies::Bodies;
use crate::shape::Shape;
use glam::DMat3;

/// The resistances of a body to motion and to turning, the same in all directions: `xi L` and `xi L^3 / 12`.
pub fn resistances(drag: f64, shape: &Shape) -> (f64, f64) {
    let length = shape.major_axis();
    (drag * length, drag * length.powi(3) / 12.0)
}

/// Inertia is negligible; each body is slowed by a drag of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overdamped {
    /// Drag coefficient `xi`.
    pub drag: f64,
}

impl Law for Overdamped {
    fn motion(&self, bodies: &Bodies, i: usize, load: Load, _dt: f64) -> Motion {
        let length = bodies.shape[i].major_axis();
        let translation = 1.0 / (self.drag * length);
        let rotation = 12.0 / (self.drag * length.powi(3));
        Motion {
            free: Twist { linear: translation * load.force, angular: rotation * load.torque },
            factor: Factor {
                translation: translation.sqrt(),
                rotation: DMat3::from_diagonal(glam::DVec3::splat(rotation.sqrt())),
            },
            ending: Ending::default(),
        }
    }
}
