//! A simulation: a scene's bodies and the backend that steps them.

use super::{StepReport, step};
use crate::backend::{Backend, cpu::Cpu};
use crate::bodies::Bodies;
use crate::broad_phase::{Aabb, BroadPhase, Grid};
use crate::constraint::RowSourceError;
use crate::dynamics::ForceField;
use crate::freedom::{PLANAR, SPATIAL};
use crate::scene::Scene;
use crate::separation::{Separation, separation};
use glam::DVec3;
use rayon::prelude::*;

/// What a step remembers of a near pair, to start the next step from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warm {
    /// The pair, `a < b`.
    pub pair: [u32; 2],
    /// Which of the pair's contacts, where a method makes several at once.
    pub feature: u32,
    /// The sum of its rows' multipliers.
    pub gamma: f64,
    /// Its last normal; zero where none was found.
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
    /// What the last step remembers of its near pairs, sorted by pair and feature.
    pub warm: Vec<Warm>,
}

/// Why a step could not be taken. The simulation keeps its last accepted state.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// A number that is not finite turned up.
    #[error(
        "step {step}: the {what} of body {body} is not finite; its forces are too large for dt, or a plugged-in force is not finite"
    )]
    NotFinite {
        /// The step that was being taken.
        step: u64,
        /// Which quantity.
        what: &'static str,
        /// The first body concerned.
        body: usize,
    },
    /// A body has no multi-sphere proxy of the count that the scene asks for.
    #[error("no multi-sphere proxy: {0}")]
    NoProxy(#[from] RowSourceError),
}

/// A scene's bodies and the backend that steps them.
///
/// ```
/// use relcp::{relcp::Simulation, scene};
/// let scene = scene::load("two-ellipsoids", &["time.end=0.1".into()])?;
/// let bodies = scene.build()?;
/// let mut simulation = Simulation::new(scene, bodies)?;
/// while !simulation.done() {
///     let report = simulation.step()?;
///     assert!(report.max_overlap <= 1e-5);
/// }
/// assert_eq!(simulation.state().bodies.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Simulation {
    scene: Scene,
    backend: Box<dyn Backend>,
}

impl Simulation {
    /// Starts a validated scene from the bodies that [`Scene::build`] made.
    ///
    /// # Errors
    /// [`Fault::NoProxy`] where the method is multi-sphere and a body has no proxy of that count.
    pub fn new(scene: Scene, bodies: Bodies) -> Result<Self, Fault> {
        // A parent's id is taken too, although the parent is no more.
        let taken = bodies.lineage.iter().map(|l| l.id.max(l.parent.unwrap_or(0)));
        let next_id = taken.max().map_or(0, |id| id + 1);
        Self::resume(scene, State { step: 0, next_id, bodies, warm: Vec::new() })
    }

    /// Goes on from a state that a run of the same scene was saved in, to the same bits.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn resume(scene: Scene, state: State) -> Result<Self, Fault> {
        let backend: Box<dyn Backend> = if scene.planar {
            Box::new(Cpu::<PLANAR>::new(&scene, state)?)
        } else {
            Box::new(Cpu::<SPATIAL>::new(&scene, state)?)
        };
        Ok(Simulation { scene, backend })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The state after the last accepted step.
    pub fn state(&self) -> &State {
        self.backend.state()
    }

    /// The time after the last accepted step.
    pub fn time(&self) -> f64 {
        self.scene.time.after(self.state().step)
    }

    /// Whether the scene's end is reached.
    pub fn done(&self) -> bool {
        self.state().step >= self.scene.time.steps()
    }

    /// Adds an external force, beside the scene's own.
    pub fn add_force(&mut self, force: Box<dyn ForceField>) {
        self.backend.add_force(force);
    }

    /// Takes one step.
    ///
    /// # Errors
    /// A [`Fault`]; the state is then still that of the last accepted step.
    pub fn step(&mut self) -> Result<StepReport, Fault> {
        let mut report = step(self.backend.as_mut(), &self.scene.contact)?;
        report.time = self.scene.time.after(report.step);
        Ok(report)
    }

    /// Every pair of bodies whose separation is at most `cutoff`, sorted by pair. See [`contacts`].
    pub fn contacts(&self, cutoff: f64) -> Vec<([usize; 2], Separation)> {
        contacts(&self.state().bodies, cutoff)
    }
}

/// Every pair of bodies whose separation is at most `cutoff`, sorted by pair, computed afresh from the bodies alone: it shares no
/// cached candidates, warm normals or shortcuts with the steps, so it audits them.
pub fn contacts(bodies: &Bodies, cutoff: f64) -> Vec<([usize; 2], Separation)> {
    let boxes: Vec<Aabb> = (0..bodies.len())
        .map(|i| {
            let half = bodies.shape[i].half_extents(bodies.orientation[i]) + DVec3::splat(0.5 * cutoff.max(0.0));
            Aabb { min: bodies.position[i] - half, max: bodies.position[i] + half }
        })
        .collect();
    let mut pairs = Vec::new();
    Grid::default().pairs(&boxes, &mut pairs);
    pairs
        .par_iter()
        .map(|pair| pair.map(|i| i as usize))
        .filter_map(|[a, b]| Some(([a, b], separation(&bodies.placed(a), &bodies.placed(b), None)?)))
        .filter(|(_, found)| found.separation <= cutoff)
        .collect()
}
