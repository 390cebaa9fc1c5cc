//! What a simulation starts from, and what computes it.

use super::{Compute, Simulation};
use crate::bodies::Bodies;
use crate::error::Error;
use crate::scene::Scene;
use crate::step::State;

/// A simulation that is about to start: see [`Simulation::builder`].
#[must_use = "a builder starts nothing before `build`"]
#[derive(Clone)]
pub struct SimulationBuilder {
    scene: Scene,
    start: Start,
    compute: Compute,
}

/// The configuration that the first step starts from.
#[derive(Clone)]
enum Start {
    /// That of [`Scene::build`].
    Scene,
    /// These bodies, at the scene's start.
    Bodies(Bodies),
    /// A saved state.
    State(State),
}

impl SimulationBuilder {
    pub(super) fn new(scene: Scene) -> Self {
        SimulationBuilder { scene, start: Start::Scene, compute: Compute::Cpu }
    }

    /// Starts from these bodies in place of the scene's own. They must have been built from this scene
    /// ([`Scene::build`]), so that their groups and periods are the scene's; shapes and poses may have been changed
    /// since. It takes the place of an earlier [`resume`](SimulationBuilder::resume).
    pub fn bodies(mut self, bodies: Bodies) -> Self {
        self.start = Start::Bodies(bodies);
        self
    }

    /// Continues from a state that a simulation of the same scene was saved in. On the CPU the bits are those of an
    /// uninterrupted simulation. On a device they may differ: the order of its sums depends on when the candidate pairs
    /// were last searched for. It takes the place of earlier [`bodies`](SimulationBuilder::bodies).
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
    /// * [`Error::Scene`]: what [`Scene::build`] refuses, where neither bodies nor a state were given.
    /// * [`Error::Fault`]: [`Fault::NoProxy`](crate::Fault::NoProxy) where the method is multi-sphere and a body has no
    ///   proxy of that count; [`Fault::NoSeparation`](crate::Fault::NoSeparation) where two of the shapes have no
    ///   separation; [`Fault::Device`](crate::Fault::Device) where a device fails or cannot do what the scene asks for.
    pub fn build(self) -> Result<Simulation, Error> {
        let state = match self.start {
            Start::Scene => State::new(self.scene.build()?),
            Start::Bodies(bodies) => State::new(bodies),
            Start::State(state) => state,
        };
        Ok(Simulation::start(&self.compute, self.scene, state)?)
    }
}
