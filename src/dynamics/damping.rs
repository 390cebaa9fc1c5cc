//! The decay of a body's motion by drag, with inertia: `m u' = F - xi L u`, and about each principal axis `I w' = T -
//! (xi L^3 / 12) w`. Both are solved exactly for a steady force:
//!
//! ```text
//! u(t) = e^-a u(0) + (1 - e^-a) / a  t F / m,   a = t xi L / m
//! ```
//!
//! so that no step is too long to be stable. [Drag] that depends on the direction has another `xi L` along each axis of
//! the body, those of the step's start or of its middle.

use super::Drag;
use super::along::{Along, along_axes};
use crate::shape::Shape;
use glam::{DQuat, DVec3};

/// Parts, of a velocity or of an impulse and of its turning about each principal axis, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Of what is linear.
    pub linear: Along,
    /// About the principal axes.
    pub turning: DVec3,
}

impl Parts {
    /// A vector of turning, space axes, of which these parts about the body's axes remain.
    pub fn of_turning(&self, orientation: DQuat, v: DVec3) -> DVec3 {
        along_axes(orientation, self.turning, v)
    }
}

/// What drag leaves of a body's motion in a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// Of the velocities.
    pub kept: Parts,
    /// Of a steady force's impulse.
    pub share: Parts,
}

impl Damping {
    /// Over `time`, for a body of this shape and density.
    pub fn over(time: f64, drag: Drag, density: f64, shape: &Shape) -> Damping {
        let (linear, turning) = rates(drag, density, shape);
        let (a, b) = (linear.with(|rate| time * rate), time * turning);
        Damping {
            kept: Parts { linear: a.with(|a| (-a).exp()), turning: b.map(|b| (-b).exp()) },
            share: Parts { linear: a.with(share), turning: b.map(share) },
        }
    }
}

/// The rates at which velocities relax: the resistances over mass and moments of inertia.
pub fn rates(drag: Drag, density: f64, shape: &Shape) -> (Along, DVec3) {
    let resistance = drag.resistance(shape);
    let mass = density * shape.volume();
    (resistance.linear.with(|linear| linear / mass), resistance.turning.axes() / (density * shape.unit_inertia()))
}

/// `(1 - e^-a) / a`.
fn share(a: f64) -> f64 {
    if a > 0.0 { -(-a).exp_m1() / a } else { 1.0 }
}
