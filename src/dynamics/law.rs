//! The laws of motion that a scene may name.

use super::damping::rates;
use super::{Drag, Inertial, Law, Overdamped};
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
        /// Drag: the coefficient `xi` of this law, or an object with `parallel`, `perpendicular` and `rotation`, or
        /// with `viscosity`.
        drag: Drag,
    },
    /// Newton's and Euler's equations with inelastic contact.
    Inertial {
        /// Mass per volume of every body.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        density: f64,
        /// Drag, with the resistance of the overdamped law: `m u' = F - xi L u` and `I w' = T - (xi L^3 / 12) w`; a
        /// number or an object as there. Without it: no drag.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        drag: Option<Drag>,
    },
}

impl Default for Dynamics {
    fn default() -> Self {
        Dynamics::Overdamped { drag: Drag::Even(1.0) }
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

    /// The drag of the overdamped law.
    pub fn drag(&self) -> Option<Drag> {
        match *self {
            Dynamics::Overdamped { drag } => Some(drag),
            Dynamics::Inertial { .. } => None,
        }
    }

    /// The law's name, which is its key in a scene.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Dynamics::Overdamped { .. } => "overdamped",
            Dynamics::Inertial { .. } => "inertial",
        }
    }

    /// The drag of either law.
    pub fn any_drag(&self) -> Option<Drag> {
        match *self {
            Dynamics::Overdamped { drag } => Some(drag),
            Dynamics::Inertial { drag, .. } => drag,
        }
    }

    /// The drag beside inertia.
    pub fn drag_beside_inertia(&self) -> Option<Drag> {
        match *self {
            Dynamics::Overdamped { .. } => None,
            Dynamics::Inertial { drag, .. } => drag,
        }
    }

    /// How far a force of 1 moves the centre of a body at rest in a step, in the direction of least resistance, and by
    /// what a torque of 1 about each of its axes turns it.
    pub(crate) fn yields(&self, shape: &Shape, dt: f64) -> (f64, DVec3) {
        match *self {
            Dynamics::Overdamped { drag } => {
                let resistance = drag.resistance(shape);
                (dt / resistance.linear.least(), dt / resistance.turning.axes())
            }
            Dynamics::Inertial { density, drag } => {
                let share = |rate: f64| if rate > 0.0 { -(-rate * dt).exp_m1() / (rate * dt) } else { 1.0 };
                let (rate, turning) = match drag.map(|drag| rates(drag, density, shape)) {
                    Some((rate, turning)) => (rate.least(), turning),
                    None => (0.0, DVec3::ZERO),
                };
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
