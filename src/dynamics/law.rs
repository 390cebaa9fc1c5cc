//! The laws of motion that a scene may name.

use super::damping::rates;
use super::overdamped::resistances;
use super::{Inertial, Law, Overdamped};
use crate::shape::Shape;
use glam::DVec3;

/// The law of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Dynamics {
    /// Inertia is negligible: `u = F / (drag L)`, `w = 12 T / (drag L^3)` with `L` the major axis length.
    Overdamped {
        /// Drag coefficient `xi`.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        drag: f64,
    },
    /// Newton's and Euler's equations with inelastic contact.
    Inertial {
        /// Mass per volume of every body.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        density: f64,
        /// Drag coefficient `xi`, with the resistance of the overdamped law: `m u' = F - xi L u` and `I w' = T - (xi
        /// L^3 / 12) w`. Without it: no drag.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        drag: Option<f64>,
    },
}

impl Default for Dynamics {
    fn default() -> Self {
        Dynamics::Overdamped { drag: 1.0 }
    }
}

impl Dynamics {
    /// Mass per volume of every body; `None` for a law without inertia.
    pub fn density(&self) -> Option<f64> {
        match *self {
            Dynamics::Overdamped { .. } => None,
            Dynamics::Inertial { density, .. } => Some(density),
        }
    }

    /// The drag coefficient of the overdamped law.
    pub fn drag(&self) -> Option<f64> {
        match *self {
            Dynamics::Overdamped { drag } => Some(drag),
            Dynamics::Inertial { .. } => None,
        }
    }

    /// The law's name and that of its coefficient, which are their keys in a scene, with the coefficient.
    pub(crate) fn coefficient(&self) -> ([&'static str; 2], f64) {
        match *self {
            Dynamics::Overdamped { drag } => (["overdamped", "drag"], drag),
            Dynamics::Inertial { density, .. } => (["inertial", "density"], density),
        }
    }

    /// The drag coefficient beside inertia.
    pub fn drag_beside_inertia(&self) -> Option<f64> {
        match *self {
            Dynamics::Overdamped { .. } => None,
            Dynamics::Inertial { drag, .. } => drag,
        }
    }

    /// How far a force of 1 moves the centre of a body at rest in a step, and by what a torque of 1 about each of its
    /// axes turns it.
    pub(crate) fn yields(&self, shape: &Shape, dt: f64) -> (f64, DVec3) {
        match *self {
            Dynamics::Overdamped { drag } => {
                let (linear, turning) = resistances(drag, shape);
                (dt / linear, DVec3::splat(dt / turning))
            }
            Dynamics::Inertial { density, drag } => {
                let share = |rate: f64| if rate > 0.0 { -(-rate * dt).exp_m1() / (rate * dt) } else { 1.0 };
                let (rate, turning) = drag.map_or((0.0, DVec3::ZERO), |drag| rates(drag, density, shape));
                let shares = DVec3::new(share(turning.x), share(turning.y), share(turning.z));
                let fallen = dt * dt / density;
                (fallen * share(rate) / shape.volume(), fallen * shares / shape.unit_inertia())
            }
        }
    }

    /// Whether velocities are a part of the state.
    pub fn has_inertia(&self) -> bool {
        self.density().is_some()
    }
}

/// The law that a scene names.
pub fn law(dynamics: &Dynamics) -> Box<dyn Law> {
    match *dynamics {
        Dynamics::Overdamped { drag } => Box::new(Overdamped { drag }),
        Dynamics::Inertial { density, drag } => Box::new(Inertial { density, drag }),
    }
}
