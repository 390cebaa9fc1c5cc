//! The initial state and the backend of a simulation.

use super::{Compute, Simulation};
use crate::bodies::Bodies;
use crate::error::Error;
use crate::scene::Scene;
use crate::step::State;

/// Builds a simulation: see [`Simulation::builder`].
#[must_use = "a builder does nothing before `build`"]
#[derive(Clone)]
pub struct SimulationBuilder {
    scene: Scene,
    start: Start,
    compute: Compute,
}

/// The configuration that the first step starts from.
#[derive(Clone)]
enum Start {
    /// The bodies of [`Scene::build`].
    Scene,
    /// These bodies, at the scene's start time.
    Bodies(Bodies),
    /// A saved state.
    State(State),
}

impl SimulationBuilder {
    pub(super) fn new(scene: Scene) -> Self {
        SimulationBuilder { scene, start: Start::Scene, compute: Compute::Cpu }
    }

    /// Starts from these bodies instead of the scene's own. They must come from [`Scene::build`] of this scene, so that
    /// their groups and periods match; their shapes and poses may differ. Replaces an earlier
    /// [`resume`](SimulationBuilder::resume).
    pub fn bodies(mut self, bodies: Bodies) -> Self {
        self.start = Start::Bodies(bodies);
        self
    }

    /// Continues from a saved state of a simulation of the same scene. On the CPU the bits are those of an
    /// uninterrupted simulation. On a device they may differ: the order of its sums depends on when it last searched
    /// for candidate pairs. Replaces earlier [`bodies`](SimulationBuilder::bodies).
    pub fn resume(mut self, state: State) -> Self {
        self.start = Start::State(state);
        self
    }

    /// Computes on the CPU or on a device: the CPU by default.
    pub fn on(mut self, compute: &Compute) -> Self {
        self.compute = compute.clone();
        self
    }

    /// Starts the simulation.
    ///
    /// # Errors
    /// * [`Error::Scene`]: from [`Scene::build`], if neither bodies nor a state were set.
    /// * [`Error::Fault`]: [`Fault::NoProxy`](crate::Fault::NoProxy) if the method is multi-sphere and a body has no
    ///   proxy of that count; [`Fault::Device`](crate::Fault::Device) if a device fails or does not support the scene.
    pub fn build(self) -> Result<Simulation, Error> {
        let state = match self.start {
            Start::Scene => State::new(self.scene.build()?),
            Start::Bodies(bodies) => State::new(bodies),
            Start::State(state) => state,
        };
        Ok(Simulation::start(&self.compute, self.scene, state)?)
    }
}
