//! Inertial motion: Newton's and Euler's equations, `U = U^k + dt M^-1 (F + D gamma)` with the gyroscopic torque in `F`.
//!
//! Contact is inelastic: the complementarity conditions bring approaching surfaces to rest against each other.

use super::{Factor, Law, Load, Motion, Twist};
use crate::bodies::Bodies;
use glam::DMat3;

/// Solid bodies of one density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass per volume.
    pub density: f64,
}

impl Law for Inertial {
    fn inertia(&self) -> bool {
        true
    }

    fn motion(&self, bodies: &Bodies, i: usize, load: Load, dt: f64) -> Motion {
        let shape = bodies.shape[i];
        let mass = self.density * shape.volume();
        let moments = self.density * shape.unit_inertia();
        let axes = DMat3::from_quat(bodies.orientation[i]);
        let angular = bodies.angular_velocity[i];
        let in_body = axes.transpose() * angular;
        let gyroscopic = axes * in_body.cross(moments * in_body);
        let acceleration = axes * ((axes.transpose() * (load.torque - gyroscopic)) / moments);
        let root = (dt / moments).map(f64::sqrt);
        Motion {
            free: Twist { linear: bodies.velocity[i] + dt / mass * load.force, angular: angular + dt * acceleration },
            factor: Factor {
                translation: (dt / mass).sqrt(),
                rotation: axes * DMat3::from_diagonal(root) * axes.transpose(),
            },
        }
    }
}
