//! The verbs of a timestep on a device. The bodies, their pairs, the rows and the LCP stay on the device. The host
//! controls the work and reads a few words per stage: the number of rows, whether the list of candidates is still
//! valid, the residual, the overlap.
//!
//! A step has the same stages as on the CPU. Each stage has its own file, buffers and kernels: `start`, `motions`,
//! `first` (the state in which the first rows are made), `near`, `row_set`, `solve` and `trial`. `states` contains the
//! poses and shapes that all stages read, `source` what the texts of kernels share. `narrow_phase` contains the
//! candidate pairs and the separation values that the host reads. `Stages` contains the inputs of a stage.
//!
//! Only the objects that the scene needs are created: kernels for the pairs that its shapes can form, buffers for the
//! rows that exist.

mod again;
mod ancestry;
mod bonds;
mod branch_source;
mod branches;
mod candidates;
mod contacts;
mod effect;
mod first;
mod growing;
mod heat;
mod held;
mod hosted;
mod keeper;
mod lists;
mod motions;
mod narrow_phase;
mod near;
mod part;
mod parted;
mod passing;
mod read_back;
mod row_inputs;
mod row_set;
mod setup;
mod solve;
mod source;
mod start;
mod states;
#[cfg(test)]
mod tests;
mod trial;
mod unrounded;
mod verbs;
mod walls;
mod warm;

use crate::constraint::RowSource;
use crate::gpu::{Gpu, GpuError, Made, Precision};
use crate::step::{Model, Phases, State};
pub use contacts::{contacts, wall_contacts};
use effect::{EffectKernels, Effects};
use first::First;
use hosted::HostedRows;
use keeper::Accepted;
use motions::Motions;
use narrow_phase::NarrowPhase;
use passing::PassingKernels;
use row_set::RowSet;
pub(crate) use setup::Setup;
use solve::Solve;
use start::{Stages, Start};
use states::States;
use std::sync::{Arc, OnceLock};
use trial::Trial;

/// The GPU backend.
pub struct Device {
    gpu: Arc<Gpu>,
    /// For the CPU, which repeats failed steps.
    model: Model,
    setup: Setup,
    accepted: Accepted,
    states: States,
    start: Start,
    motions: Motions,
    first: First,
    narrow: NarrowPhase,
    rows: RowSet,
    solve: Solve,
    /// The host's part of steps with friction, restitution or implicit bonds.
    hosted: Option<HostedRows>,
    trial: Trial,
    effect: EffectKernels,
    passing: PassingKernels,
    phases: Phases,
    /// How many implicit bonds broke when the last trial was accepted.
    broken: u32,
}

impl Device {
    /// Whether the device supports everything in a scene.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for features that only the CPU has.
    pub fn check(model: &Model) -> Result<(), GpuError> {
        if !model.walls.loaded().is_empty() {
            return Err(GpuError::Unsupported { what: "walls under a load".into() });
        }
        match model.contact.method.row_source() {
            RowSource::Surfaces => Ok(()),
            RowSource::SubSpheres { .. } => Err(GpuError::Unsupported { what: "multi-sphere rows".into() }),
        }
    }

    /// A backend for `model` in `state` on `gpu`.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for features that only the CPU has, or an error of the device.
    pub fn new(gpu: Arc<Gpu>, precision: Precision, model: &Model, mut state: State) -> Result<Self, GpuError> {
        gpu.check(precision)?;
        Device::check(model)?;
        let mut setup = Setup::new(model, &state.bodies.shape, precision)?;
        setup.keep_pitch(&state);
        if let Some(cells) = &setup.growth {
            cells.settle(&mut state.bodies);
        }
        state.bodies.periods =
            model.strain.map_or(setup.periods, |strain| strain.periods(model.time.after(state.step)));
        state.bodies.planar = model.planar;
        let unrounded = unrounded::unrounded(&setup, &state)?;
        let bodies = state.bodies.len() as u64;
        let hosted = HostedRows::new(&gpu, &setup, model, &state)?;
        let states = States::new(&gpu, &setup, bodies)?;
        states.write(&gpu, &setup, &state.bodies.shape, &unrounded);
        Ok(Device {
            states,
            start: Start::new(&gpu, &setup, model, &state, &unrounded)?,
            motions: Motions::new(&gpu, &setup, model, &state.bodies)?,
            first: First::new(&gpu, &setup)?,
            narrow: NarrowPhase::new(&gpu, &setup, state.warm.clone())?,
            rows: RowSet::new(&gpu, &setup)?,
            solve: Solve::new(&gpu, &setup, model, (bodies, hosted.is_some()))?,
            hosted,
            trial: Trial::new(&gpu, &setup, model.contact.overlap_tolerance)?,
            effect: EffectKernels::make(&gpu, &setup)?,
            passing: PassingKernels::make(&gpu, &setup)?,
            accepted: Accepted { state: OnceLock::from(state.clone()), ..Accepted::of(&state) },
            phases: Phases::default(),
            broken: 0,
            setup,
            model: model.clone(),
            gpu,
        })
    }

    /// The number of searches for candidate pairs so far.
    pub fn searches(&self) -> u64 {
        self.narrow.candidates.searches
    }

    fn stages(&self) -> Stages<'_> {
        let Device { gpu, setup, states, start, .. } = self;
        Stages { gpu, setup, states, start }
    }

    /// The effect of contact up to the trial.
    fn effects(&self) -> Effects<'_> {
        let Device { motions, first, narrow, rows, solve, effect: kernels, .. } = self;
        let (tolerance, overlap) = (solve.tolerance, first.overlap);
        Effects { kernels, stages: self.stages(), motions, narrow, rows, tolerance, overlap }
    }
}
