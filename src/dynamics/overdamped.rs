//! Overdamped local drag. A number: `u = F / (xi L)`, `w = 12 T / (xi L^3)`, `L` the major axis length (the paper's
//! ellipsoid mobility). Other [drag](Drag) depends on the direction.

use super::along::{Root, about};
use super::{Drag, Ending, Factor, Law, Load, Motion, Twist};
use crate::bodies::Bodies;
use glam::{DMat3, DVec3};

/// Inertia is negligible; each body is slowed by a drag of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overdamped {
    /// The drag.
    pub drag: Drag,
}

impl Law for Overdamped {
    fn motion(&self, bodies: &Bodies, i: usize, load: Load, _dt: f64) -> Motion {
        match self.drag {
            Drag::Even(xi) => even(xi, bodies.shape[i].major_axis(), load),
            drag => by_axes(drag, bodies, i, load),
        }
    }
}

fn even(xi: f64, length: f64, load: Load) -> Motion {
    let translation = 1.0 / (xi * length);
    let rotation = 12.0 / (xi * length.powi(3));
    Motion {
        free: Twist { linear: translation * load.force, angular: rotation * load.torque },
        factor: Factor {
            translation: Root::Even(translation.sqrt()),
            rotation: DMat3::from_diagonal(DVec3::splat(rotation.sqrt())),
        },
        ending: Ending::default(),
    }
}

fn by_axes(drag: Drag, bodies: &Bodies, i: usize, load: Load) -> Motion {
    let (resistance, orientation) = (drag.resistance(&bodies.shape[i]), bodies.orientation[i]);
    let [translation, rotation] = [resistance.linear, resistance.turning].map(|of| of.with(f64::recip));
    Motion {
        free: Twist { linear: translation.of(orientation, load.force), angular: rotation.of(orientation, load.torque) },
        factor: Factor {
            translation: translation.with(f64::sqrt).root(orientation),
            rotation: about(orientation, rotation.with(f64::sqrt).axes()),
        },
        ending: Ending::default(),
    }
}
