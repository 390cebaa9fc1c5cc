//! A simulation: a scene's bodies and the backend that steps them.

use super::StepReport;
use crate::bodies::Bodies;
use crate::scene::Scene;
use crate::separation::Separation;
use glam::DVec3;

/// What a step remembers of a near pair, to start the next step from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warm {
    /// The pair, `a < b`.
    pub pair: [u32; 2],
    /// The sum of its rows' multipliers.
    pub gamma: f64,
    /// Its last normal.
    pub normal: DVec3,
}

/// Everything that a run needs, beside its scene, to go on to the same bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Steps taken.
    pub step: u64,
    /// The id that the next body born will get.
    pub next_id: u64,
    /// The bodies.
    pub bodies: Bodies,
    /// What the last step remembers of its near pairs, sorted by pair.
    pub warm: Vec<Warm>,
}

/// Why a step could not be taken. The simulation keeps its last accepted state.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// A number that is not finite turned up.
    #[error("step {step}: {what} is not finite (body {body})")]
    NotFinite {
        /// The step that was being taken.
        step: u64,
        /// Which quantity.
        what: &'static str,
        /// The first body concerned.
        body: usize,
    },
}

/// A scene's bodies and the backend that steps them.
pub struct Simulation {
    scene: Scene,
    state: State,
}

impl Simulation {
    /// Starts a validated scene (see [`crate::scene`]): its bodies, those given and those generated.
    pub fn new(scene: Scene, bodies: Bodies) -> Self {
        let next_id = bodies.lineage.iter().map(|l| l.id + 1).max().unwrap_or(0);
        Simulation { scene, state: State { step: 0, next_id, bodies, warm: Vec::new() } }
    }

    /// Goes on from a state that a run of the same scene was saved in.
    pub fn resume(scene: Scene, state: State) -> Self {
        Simulation { scene, state }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The state after the last accepted step.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The time after the last accepted step.
    pub fn time(&self) -> f64 {
        self.scene.time.after(self.state.step)
    }

    /// Whether the scene's end is reached.
    pub fn done(&self) -> bool {
        self.state.step >= self.scene.time.steps()
    }

    /// Takes one step.
    pub fn step(&mut self) -> Result<StepReport, Fault> {
        unreachable!("written next")
    }

    /// Every pair of bodies whose separation is at most `cutoff`, sorted by pair.
    pub fn contacts(&self, _cutoff: f64) -> Vec<([usize; 2], Separation)> {
        unreachable!("written next")
    }
}
