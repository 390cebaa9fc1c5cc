//! Which backend computed which steps of a run.

use crate::simulation::Simulation;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The steps from one start or resumption of a run to the next, and their backend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Leg {
    /// `cpu` or `gpu`.
    pub machine: String,
    /// The device's adapter; null on the CPU.
    pub adapter: Option<String>,
    /// The precision: `f32` or `f64`.
    pub precision: String,
    /// The first step of the leg.
    pub from_step: u64,
    /// The time before that step.
    pub time: f64,
    /// The bodies before that step.
    pub bodies: usize,
}

impl Leg {
    /// The leg that a simulation begins with its next step.
    pub(super) fn of(simulation: &Simulation) -> Leg {
        Leg {
            machine: simulation.machine().into(),
            adapter: simulation.device().map(|gpu| format!("{} ({})", gpu.name(), gpu.driver())),
            precision: simulation.precision().name().into(),
            from_step: simulation.steps() + 1,
            time: simulation.time(),
            bodies: simulation.bodies(),
        }
    }
}

/// Displays its start and its backend.
impl fmt::Display for Leg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "from step {} with {} bodies: ", self.from_step, self.bodies)?;
        match &self.adapter {
            Some(adapter) => write!(f, "{adapter} in {}", self.precision),
            None => write!(f, "the CPU"),
        }
    }
}
