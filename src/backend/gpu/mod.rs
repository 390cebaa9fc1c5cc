//! The verbs of a timestep on a device: the bodies, their pairs, the rows and the LCP stay there. The host orders the
//! work and reads a few words a stage: how many rows, whether the list of candidates still holds, the residual, the
//! overlap.
//!
//! Only what the scene needs is made: kernels for the pairs that its shapes can form, buffers for the rows that there
//! are.

mod again;
mod ahead;
mod ancestry;
mod bonds;
mod branch_source;
mod branches;
mod candidates;
mod contacts;
mod effect;
mod growing;
mod heat;
mod held;
mod keeper;
mod midpoint;
mod passing;
mod periodic;
mod read_back;
mod rows;
mod separations;
mod setup;
mod source;
mod states;
#[cfg(test)]
mod tests;
mod unrounded;
mod walls;
mod warm;

use crate::bodies::{Bodies, Lineage};
use crate::constraint::RowSource;
use crate::dynamics::ForceField;
use crate::freedom::{PLANAR, SPATIAL};
use crate::gpu::{Buffer, Gpu, GpuError, LatticePeriods, Made, Precision};
use crate::lcp::{self, Outcome, Settings, Stored};
use crate::step::{Effect, Fault, Model, Overlap, Passed, Phases, State, Take, TwoSided, Unrounded, Verbs};
use crate::walls::surface_of;
use crate::warm::Warm;
use ancestry::Ancestry;
use bonds::BondBuffers;
use candidates::Candidates;
pub use contacts::{contacts, wall_contacts};
use growing::GrowthBuffers;
use heat::Ids;
use held::Held;
use midpoint::Part;
use rows::Rows;
use separations::Report;
pub(crate) use setup::Setup;
use source::Kernels;
use states::{Poses, Shapes, States};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

fn words(words: [u32; 4]) -> [u8; 16] {
    bytemuck::cast(words)
}

/// The GPU backend.
pub struct Device {
    gpu: Arc<Gpu>,
    /// For the CPU, which takes steps again that fail.
    model: Model,
    setup: Setup,
    kernels: Kernels,
    plugged: Vec<Box<dyn ForceField>>,
    /// Whether the kernel of forces reads the loads that the host and other kernels make.
    takes_loads: bool,
    step: u64,
    bodies: u64,
    /// Bodies of the last accepted state.
    accepted_bodies: u64,
    part: Part,
    /// Whether first rows are made where the last velocities lead.
    ahead: bool,
    states: States,
    ancestry: Ancestry,
    /// How many bodies each rule of removal has removed.
    removed: Vec<u64>,
    groups_of: Buffer,
    growth: GrowthBuffers,
    held: Option<Held>,
    /// The bodies' ids, where there is Brownian motion.
    ids: Option<Ids>,
    bonds: Option<BondBuffers>,
    loads: Buffer,
    motions: Buffer,
    boxes: Buffer,
    report: Buffer,
    blank: Buffer,
    candidates: Candidates,
    rows: Rows,
    solver: lcp::gpu::Solver,
    /// Rows that there will be once violations are appended.
    next_rows: u64,
    /// The overlap from which on a pair of the last trial is a violation.
    violating: f64,
    /// How far a point of a surface moves to the last trial, at most, and how far by its turn alone.
    farthest: f64,
    turned: f64,
    /// What was found of the last trial, and the deepest overlap where the step's first rows were made.
    trial_report: Report,
    start_overlap: f64,
    state: OnceLock<State>,
    phases: Phases,
}

impl Device {
    /// Whether a device can do all that a scene asks for.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for what only the CPU does.
    pub fn check(model: &Model) -> Result<(), GpuError> {
        match model.contact.method.row_source() {
            RowSource::Surfaces => Ok(()),
            RowSource::SubSpheres { .. } => Err(GpuError::Unsupported { what: "multi-sphere rows".into() }),
        }
    }

    /// A backend for `model` in `state` on `gpu`.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for what only the CPU does, or what the device refuses.
    pub fn new(gpu: Arc<Gpu>, precision: Precision, model: &Model, mut state: State) -> Result<Self, GpuError> {
        gpu.check(precision)?;
        Device::check(model)?;
        let setup = Setup::new(model, &state.bodies.shape, precision)?;
        if let Some(cells) = &setup.growth {
            cells.settle(&mut state.bodies);
        }
        state.bodies.periods =
            model.strain.map_or(setup.periods, |strain| strain.periods(model.time.after(state.step)));
        state.bodies.planar = model.planar;
        let (real, bodies) = (precision.bytes(), state.bodies.len() as u64);
        let unrounded = unrounded::unrounded(&setup, &state)?;
        let states = States::new(&gpu, &setup, bodies)?;
        states.write(&gpu, &setup, &state.bodies.shape, &unrounded);
        let mut ancestry = Ancestry::of(&setup, &state, unrounded.prescribed());
        let width = setup.motion_width() as usize;
        let mut device = Device {
            plugged: Vec::new(),
            takes_loads: setup.makes_loads(),
            step: state.step,
            bodies,
            accepted_bodies: bodies,
            part: setup.first_part(),
            ahead: false,
            states,
            growth: GrowthBuffers::new(&gpu, &setup, &mut ancestry)?,
            held: Held::new(&gpu, &model.fixed.flags(&state.bodies))?,
            ids: Ids::new(&gpu, &setup)?,
            bonds: BondBuffers::new(&gpu, &setup, &state.bodies.broken_bonds)?,
            groups_of: Buffer::with(&gpu, "groups", 4, bytemuck::cast_slice(&ancestry.group))?,
            ancestry,
            removed: state.removed.clone(),
            loads: Buffer::new(&gpu, "loads", 8 * real, 1)?,
            motions: Buffer::new(&gpu, "motions", 4 * width * real, bodies)?,
            boxes: Buffer::new(&gpu, "boxes", 4 * real, bodies)?,
            report: Buffer::new(&gpu, "report", 4, Report::BYTES / 4)?,
            blank: Buffer::with(&gpu, "blank report", 4, bytemuck::bytes_of(&Report::blank()))?,
            candidates: Candidates::new(&gpu, &setup, state.warm.clone())?,
            rows: Rows::new(&gpu, &setup)?,
            solver: lcp::gpu::Solver::new(&gpu, precision, setup.planar, model.solver, model.lcp)?,
            kernels: Kernels::make(&gpu, &setup)?,
            next_rows: 0,
            violating: model.contact.overlap_tolerance,
            farthest: 0.0,
            turned: 0.0,
            trial_report: Report::blank(),
            start_overlap: 0.0,
            state: OnceLock::from(state),
            phases: Phases::default(),
            setup,
            model: model.clone(),
            gpu,
        };
        device.compile_solver()?;
        Ok(device)
    }

    /// Compiles the kernels of the solver for as many bodies as there are, where that is not done yet. All others are
    /// compiled when the backend is made.
    fn compile_solver(&mut self) -> Result<(), GpuError> {
        self.solver.compile(&self.gpu, self.bodies)
    }

    /// Searches for candidate pairs so far.
    pub fn searches(&self) -> u64 {
        self.candidates.searches
    }

    fn grows(&self) -> bool {
        self.setup.growth.is_some()
    }

    fn step_start(&self) -> f64 {
        self.model.time.after(self.step)
    }

    /// Takes the periods where the present part begins and at its end, where they change.
    fn place_cell(&mut self, [begin, end]: [f64; 2]) -> Result<(), GpuError> {
        let Some(strain) = &self.setup.strain else { return Ok(()) };
        let periods = strain.periods(end);
        self.setup.periods_here = LatticePeriods::of(self.setup.lattice, strain.periods(begin).numbers())?;
        if periods != self.setup.periods {
            self.setup.lattice_periods = LatticePeriods::of(self.setup.lattice, periods.numbers())?;
            self.setup.periods = periods;
            self.candidates.place_cell(self.setup.lattice_periods);
        }
        Ok(())
    }

    fn parameters(&self) -> [u8; 16] {
        words([self.bodies as u32, 0, 0, 0])
    }

    /// The bodies of the present step in a state.
    fn download(&self, poses: &Poses, shapes: &Shapes) -> Result<Bodies, GpuError> {
        let Ancestry { lineage, group, .. } = &self.ancestry;
        Ok(self.download_first(poses, shapes, (lineage.clone(), group.clone()))?.0)
    }

    /// As many bodies of a state as have a lineage.
    fn download_first(
        &self,
        poses: &Poses,
        shapes: &Shapes,
        (lineage, group): (Vec<Lineage>, Vec<u32>),
    ) -> Result<(Bodies, Unrounded), GpuError> {
        let read = unrounded::download(&self.gpu, &self.setup, poses, shapes, lineage.len() as u64)?;
        let bodies = Bodies {
            periods: self.setup.periods,
            planar: self.setup.planar,
            shape: read.shape,
            position: read.position,
            orientation: read.orientation,
            velocity: read.velocity,
            angular_velocity: read.angular_velocity,
            group,
            lineage,
            broken_bonds: self.broken_bonds()?,
        };
        Ok((bodies, read.unrounded))
    }

    /// The state after the last accepted step, read where it is not known yet.
    fn known_state(&self) -> Result<&State, GpuError> {
        if self.state.get().is_none() {
            let state = self.read_state()?;
            let _ = self.state.set(state);
        }
        self.state.get().ok_or_else(|| GpuError::Refused { message: "the state is not there".into() })
    }

    fn read_state(&self) -> Result<State, GpuError> {
        let (lineage, group, next_id) = self.ancestry.accepted();
        // The list of a step whose cells divided knows of pairs of bodies that were not born.
        let born = |body: u32| u64::from(body) < self.accepted_bodies;
        let mut warm = self.remembered()?;
        warm.retain(|w| born(w.pair[0]) && (born(w.pair[1]) || surface_of(w.pair[1]).is_some()));
        let States { accepted, accepted_shapes, .. } = &self.states;
        let (bodies, mut unrounded) = self.download_first(accepted, accepted_shapes, (lineage, group))?;
        unrounded.prescribe(&self.ancestry.accepted_lengths());
        Ok(State { step: self.step, next_id, bodies, warm, removed: self.removed.clone(), unrounded: Some(unrounded) })
    }

    fn remembered(&self) -> Result<Vec<Warm>, GpuError> {
        self.candidates.remembered(&self.gpu, &self.setup)
    }

    fn not_finite(&self, body: u32) -> Fault {
        Fault::NotFinite { step: self.step + 1, what: "velocity or pose", body: body as usize }
    }
}

impl Verbs for Device {
    fn begin(&mut self) -> Result<(), Fault> {
        self.gpu.begin_step();
        self.part = self.setup.first_part();
        self.ahead = self.setup.leads_ahead();
        if self.grows() {
            let begun = Instant::now();
            self.grow()?;
            self.compile_solver()?;
            self.phases.growth += begun.elapsed();
        }
        let begun = Instant::now();
        self.set_motion()?;
        self.phases.integrate += begun.elapsed();
        Ok(())
    }

    fn middle(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        self.make_middle()?;
        self.phases.integrate += begun.elapsed();
        Ok(())
    }

    fn append_near(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let gpu = self.gpu.clone();
        let mut found = self.separate(gpu.record(), false)?;
        if self.is_led_astray(&found) {
            self.ahead = false;
            self.set_motion()?;
            found = self.separate(gpu.record(), false)?;
        }
        if self.part != Part::FromMiddle {
            self.start_overlap = f64::from(f32::from_bits(found.worst));
        }
        let mut record = gpu.record();
        record.stage("narrow phase");
        self.record_first_rows(&mut record)?;
        let Device { rows, kernels, candidates, bodies, .. } = &mut *self;
        rows.incidence(&gpu, kernels, &mut record, &candidates.lists, *bodies)?;
        record.submit()?;
        self.phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    fn solve(&mut self, tolerance: f64) -> Result<Outcome, Fault> {
        let begun = Instant::now();
        self.solver.set_settings(Settings { tolerance, ..self.solver.settings() });
        let Device { gpu, kernels, candidates, rows, solver, .. } = &mut *self;
        let problem = &mut rows.problem;
        let outcome = match (&mut candidates.surfaces, &kernels.walls) {
            (Some(surfaces), Some(kernels)) => {
                surfaces.join_places(gpu, kernels, &candidates.lists, &problem.block_start)?;
                surfaces.exchange_starts(&mut problem.block_start);
                let outcome = solver.solve(gpu, problem);
                surfaces.exchange_starts(&mut problem.block_start);
                outcome?
            }
            _ => solver.solve(gpu, problem)?,
        };
        self.phases.solve += begun.elapsed();
        Ok(outcome)
    }

    fn trial(&mut self, violating: f64) -> Result<Overlap, Fault> {
        self.violating = violating - self.setup.rounding;
        let begun = Instant::now();
        let (gpu, bodies) = (self.gpu.clone(), self.bodies);
        let mut record = gpu.record();
        record.stage("integrate");
        let (first, trial) = (self.first(), &self.states.trial);
        self.record_move(&mut record, trial);
        let buffers = [
            ("cells", &first.cells),
            ("remainders", &first.remainders),
            ("trial_cells", &trial.cells),
            ("trial_remainders", &trial.remainders),
            ("trial_orientations", &trial.orientations),
            ("shapes", &self.start_shapes().shapes),
            ("boxes", &self.boxes),
        ];
        record.run(&self.kernels.sweep, &self.parameters(), &buffers, bodies);
        let report = self.separate(record, true)?;
        self.farthest = f64::from(f32::from_bits(report.farthest));
        self.turned = f64::from(f32::from_bits(report.turned));
        self.trial_report = report;
        self.phases.narrow_phase += begun.elapsed();
        let mut overlap = report.overlap(&self.setup.walls);
        if overlap.worst > 0.0 {
            overlap.worst += self.setup.rounding;
        }
        Ok(overlap)
    }

    fn append_violations(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let gpu = self.gpu.clone();
        let mut record = gpu.record();
        record.stage("narrow phase");
        let bodies = self.bodies;
        let (rows, kernels, made, next_rows) = self.made(true);
        rows.extend(&gpu, kernels, &mut record, made, next_rows)?;
        rows.incidence(&gpu, kernels, &mut record, made.lists, bodies)?;
        record.submit()?;
        self.phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    fn tighten_violations(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        self.tighten()?;
        self.phases.narrow_phase += begun.elapsed();
        if self.next_rows > self.rows.problem.rows { self.append_violations() } else { Ok(()) }
    }

    fn effect(&mut self, _gap: f64) -> Result<Effect, Fault> {
        // Kernels have the gap of all steps.
        Ok(self.effect_of_trial()?)
    }

    /// The CPU can, which takes the step then.
    fn relax(&mut self, _allowed: f64) -> Result<Option<Outcome>, Fault> {
        Ok(None)
    }

    fn two_sided(&mut self) -> Option<&mut dyn TwoSided> {
        None
    }

    /// The effect tells it at the end of the attempt.
    fn throws(&mut self, _gap: f64) -> Result<bool, Fault> {
        Ok(false)
    }

    fn passed(&mut self) -> Result<Option<Passed>, Fault> {
        let begun = Instant::now();
        let passed = self.passed_on_the_way()?;
        self.phases.narrow_phase += begun.elapsed();
        Ok(passed)
    }

    fn accept(&mut self) -> Result<Phases, Fault> {
        let begun = Instant::now();
        let (gpu, bodies) = (self.gpu.clone(), self.bodies);
        let mut record = gpu.record();
        record.stage("integrate");
        self.record_arrival(&mut record, &self.states.trial);
        self.record_breaking(&mut record, &self.states.trial);
        self.rows.remember(&self.kernels, &mut record, &self.candidates.lists);
        record.submit()?;
        self.states.accept();
        self.accepted_bodies = bodies;
        self.step += 1;
        let ends = self.step_start();
        self.ancestry.accept(if self.setup.midpoint { 2 } else { 1 }, ends);
        self.state = OnceLock::new();
        self.phases.integrate += begun.elapsed();
        Ok(std::mem::take(&mut self.phases))
    }

    fn take_again(&mut self, take: &mut Take<'_>) -> Result<(), Fault> {
        if self.setup.planar { self.take_on_cpu::<PLANAR>(take) } else { self.take_on_cpu::<SPATIAL>(take) }
    }

    fn multipliers(&self) -> Result<Vec<f64>, Fault> {
        let problem = &self.rows.problem;
        let bytes = problem.rows * problem.gamma.element() as u64;
        let read = self.gpu.record().read(&[(&problem.gamma, 0..bytes)])?;
        Ok(self.setup.precision.decode(&read[0]))
    }

    fn stored_lcp(&self, start: Vec<f64>) -> Result<Stored, Fault> {
        if self.setup.planar {
            let (problem, gamma) = self.lcp::<PLANAR>()?;
            return Ok(Stored::new(&problem, start, &gamma));
        }
        let (problem, gamma) = self.lcp::<SPATIAL>()?;
        Ok(Stored::new(&problem, start, &gamma))
    }

    fn constraints(&self) -> usize {
        self.rows.problem.rows as usize
    }
}
