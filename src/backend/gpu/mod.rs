//! The verbs of a timestep on a device: the bodies, their pairs, the rows and the LCP stay there. The host orders the work and reads a
//! few words a stage: how many rows, whether the list of candidates still holds, the residual, the overlap.
//!
//! Only what the scene needs is made: kernels for the pairs that its shapes can form, buffers for the rows that there are.

mod candidates;
mod growing;
mod passing;
mod periodic;
mod rows;
mod source;
mod state;
#[cfg(test)]
mod tests;
mod walls;

use super::{Backend, Overlap};
use crate::bodies::{Bodies, Lineage};
use crate::constraint::RowSource;
use crate::dynamics::{Cells, ForceField};
use crate::freedom::{PLANAR, SPATIAL};
use crate::gpu::{Buffer, Gpu, GpuError, Kernel, Lattice, LatticePeriods, Precision, Recorder};
use crate::lcp::{self, Outcome, Problem, Settings, Stored};
use crate::periodic::Periods;
use crate::relcp::{Fault, Passed, Phases, State, Warm};
use crate::scene::{Dynamics, Force, Scene, Stepping};
use crate::shape::Shape;
use crate::walls::Walls;
use bytemuck::Zeroable;
use candidates::Candidates;
use rows::Rows;
use source::Kernels;
use state::{Poses, Shapes};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// Steps of a growing length: a length's coarse part is a multiple of the longest length over this, which a float holds exactly.
const LENGTHS: f64 = 1_048_576.0;

/// What a scene means to its kernels.
pub(crate) struct Setup {
    pub precision: Precision,
    pub planar: bool,
    pub lattice: Lattice,
    pub periods: Periods,
    pub lattice_periods: LatticePeriods,
    pub dt: f64,
    pub cutoff: f64,
    pub dynamics: Dynamics,
    pub forces: Vec<Force>,
    pub groups: Vec<String>,
    pub growth: Option<Cells>,
    pub length_pitch: f64,
    pub shapes: Vec<Shape>,
    pub walls: Walls,
}

impl Setup {
    /// The scene's, for bodies of these shapes.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] where a shape is a custom one, or the bodies are too thin or too thick for 32-bit floats.
    pub fn new(scene: &Scene, shapes: &[Shape], precision: Precision) -> Result<Self, GpuError> {
        if shapes.iter().any(|shape| matches!(shape, Shape::Convex(_))) {
            return Err(GpuError::Unsupported { what: "custom shapes".into() });
        }
        let thickness = shapes.iter().map(Shape::thickness).fold(f64::INFINITY, f64::min);
        let lengths = shapes.iter().filter_map(Shape::growing_length);
        let longest = lengths.chain(scene.growth.map(|g| g.division_lengths()[1])).fold(0.0, f64::max);
        let periods = Periods::of(scene);
        // Without bodies any lattice will do that has room for the periods.
        let none = periods.shortest().map_or(1.0, |period| 0.5 * period);
        let lattice = Lattice::for_thickness(if thickness.is_finite() { thickness } else { none })?;
        Ok(Setup {
            precision,
            planar: scene.planar,
            lattice,
            periods,
            lattice_periods: LatticePeriods::new(lattice, periods.lengths())?,
            dt: scene.time.dt,
            cutoff: scene.cutoff_of(shapes.iter().copied()),
            dynamics: scene.dynamics,
            forces: scene.forces.clone(),
            groups: scene.group_names(),
            growth: Cells::of(scene),
            length_pitch: (longest / LENGTHS).max(f64::MIN_POSITIVE).log2().ceil().exp2(),
            shapes: shapes.to_vec(),
            walls: Walls::of(scene),
        })
    }

    /// Vectors of a body's motion: laws whose rotational mobility is a matrix need two more.
    pub fn motion_width(&self) -> u32 {
        match self.dynamics {
            Dynamics::Overdamped { .. } => 4,
            Dynamics::Inertial { .. } => 6,
        }
    }
}

/// What the host reads of a stage: `Report` of `shaders/relcp/report.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Report {
    outside: u32,
    not_finite: u32,
    violations: u32,
    worst: u32,
    worst_pair: u32,
    worst_a: u32,
    worst_b: u32,
    largest: u32,
    farthest: u32,
    unused: [u32; 3],
}

impl Report {
    const BYTES: u64 = size_of::<Report>() as u64;

    fn blank() -> Self {
        Report { not_finite: u32::MAX, worst_pair: u32::MAX, ..Report::zeroed() }
    }

    fn overlap(&self, of: &Walls) -> Overlap {
        let found = self.worst_pair != u32::MAX;
        let surface = walls::surface_of(self.worst_b).filter(|_| found);
        let wall = surface.map(|(surface, _)| [self.worst_a as usize, of.wall_of(surface)]);
        let pair = (found && wall.is_none()).then_some([self.worst_a as usize, self.worst_b as usize]);
        let worst = f64::from(f32::from_bits(self.worst));
        Overlap { worst, pair, wall, violations: self.violations as usize, proxy: None }
    }
}

fn words(words: [u32; 4]) -> [u8; 16] {
    bytemuck::cast(words)
}

/// Who the bodies are: kept on the host.
#[derive(Clone, Default)]
struct Ancestry {
    lineage: Vec<Lineage>,
    group: Vec<u32>,
    /// Growing lengths, NaN for bodies that do not grow.
    length: Vec<f64>,
    /// The lengths at which they divide, and their rates of growth in the step; empty where no body grows.
    division: Vec<f64>,
    rate: Vec<f64>,
    next_id: u64,
}

/// The GPU backend.
pub struct Device {
    gpu: Arc<Gpu>,
    setup: Setup,
    kernels: Kernels,
    start_time: f64,
    plugged: Vec<Box<dyn ForceField>>,
    /// Whether the kernel of forces reads loads from the host.
    takes_loads: bool,
    step: u64,
    bodies: u64,
    /// Bodies of the last accepted state.
    accepted_bodies: u64,
    /// States: the last accepted one, the trial, and where bodies grow the step's start.
    poses: Vec<Poses>,
    /// Shapes: the last accepted ones, and where bodies grow those of this step.
    shapes: Vec<Shapes>,
    ancestry: Ancestry,
    /// That of the last accepted state, where this step's differs.
    before: Option<Ancestry>,
    groups_of: Buffer,
    /// What each body grows by in a step, as a part of its length.
    growths: Buffer,
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
    /// How far a point of a surface moves to the last trial, at most.
    farthest: f64,
    state: OnceLock<State>,
    phases: Phases,
}

impl Device {
    /// Whether a device can do all that a scene asks for.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for what only the CPU does.
    pub fn check(scene: &Scene) -> Result<(), GpuError> {
        let what = if scene.contact.method.row_source() != RowSource::Surfaces {
            "multi-sphere rows"
        } else if scene.time.stepping == Stepping::Midpoint {
            "midpoint stepping"
        } else {
            return Ok(());
        };
        Err(GpuError::Unsupported { what: what.into() })
    }

    /// A backend for `scene` in `state` on `gpu`.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for what only the CPU does, or what the device refuses.
    pub fn new(gpu: Arc<Gpu>, precision: Precision, scene: &Scene, mut state: State) -> Result<Self, GpuError> {
        gpu.check(precision)?;
        Device::check(scene)?;
        let setup = Setup::new(scene, &state.bodies.shape, precision)?;
        state.bodies.periods = setup.periods;
        let (real, bodies) = (precision.bytes(), state.bodies.len() as u64);
        let grows = setup.growth.is_some();
        let mut poses = Vec::new();
        for _ in 0..if grows { 3 } else { 2 } {
            poses.push(Poses::new(&gpu, precision, bodies)?);
        }
        poses[0].write(&gpu, precision, &setup.lattice, &state.bodies)?;
        let mut shapes = Vec::new();
        for _ in 0..if grows { 2 } else { 1 } {
            shapes.push(Shapes::new(&gpu, precision, bodies, grows)?);
        }
        shapes[0].write(&gpu, precision, &state.bodies.shape, grows.then_some(setup.length_pitch));
        let cells = setup.growth;
        let own = |of: &dyn Fn(&Cells, u64) -> f64| -> Vec<f64> {
            let of_each = |cells: &Cells| state.bodies.lineage.iter().map(|line| of(cells, line.id)).collect();
            cells.as_ref().map(of_each).unwrap_or_default()
        };
        let ancestry = Ancestry {
            division: own(&|cells, id| cells.division_length(id)),
            rate: own(&|cells, id| cells.rate(id, 0.0)),
            lineage: state.bodies.lineage.clone(),
            group: state.bodies.group.clone(),
            length: state.bodies.shape.iter().map(|s| s.growing_length().unwrap_or(f64::NAN)).collect(),
            next_id: state.next_id,
        };
        let width = setup.motion_width() as usize;
        Ok(Device {
            start_time: scene.time.start,
            plugged: Vec::new(),
            takes_loads: false,
            step: state.step,
            bodies,
            accepted_bodies: bodies,
            poses,
            shapes,
            growths: growing::growths(&gpu, &setup, &ancestry)?,
            groups_of: Buffer::with(&gpu, "groups", 4, bytemuck::cast_slice(&ancestry.group))?,
            ancestry,
            before: None,
            loads: Buffer::new(&gpu, "loads", 8 * real, 1)?,
            motions: Buffer::new(&gpu, "motions", 4 * width * real, bodies)?,
            boxes: Buffer::new(&gpu, "boxes", 4 * real, bodies)?,
            report: Buffer::new(&gpu, "report", 16, Report::BYTES / 16)?,
            blank: Buffer::with(&gpu, "blank report", 16, bytemuck::bytes_of(&Report::blank()))?,
            candidates: Candidates::new(&gpu, &setup, state.warm.clone())?,
            rows: Rows::new(&gpu, &setup)?,
            solver: lcp::gpu::Solver::new(&gpu, precision, setup.planar, scene.solver.kind, scene.lcp_settings())?,
            kernels: Kernels::new(&gpu, &setup)?,
            next_rows: 0,
            violating: scene.contact.overlap_tolerance,
            farthest: 0.0,
            state: OnceLock::from(state),
            phases: Phases::default(),
            setup,
            gpu,
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Searches for candidate pairs so far.
    pub fn searches(&self) -> u64 {
        self.candidates.searches
    }

    /// The present LCP and its multipliers, read back for diagnosis and tests. The rows stand sorted by pair in the device's order.
    ///
    /// # Errors
    /// What the device refuses.
    ///
    /// # Panics
    /// If `D` is not the scene's number of unknowns.
    pub fn lcp<const D: usize>(&self) -> Result<(Problem<D>, Vec<f64>), GpuError> {
        assert_eq!(self.setup.planar, D == PLANAR, "the scene has another number of unknowns");
        let problem = &self.rows.problem;
        let whole = |buffer: &Buffer| 0..problem.rows * buffer.element() as u64;
        let read = self.gpu.record().read(&[
            (&problem.pair, whole(&problem.pair)),
            (&problem.jacobian, whole(&problem.jacobian)),
            (&problem.q, whole(&problem.q)),
            (&problem.gamma, whole(&problem.gamma)),
        ])?;
        let [blocks, q, gamma] = [1, 2, 3].map(|i| self.setup.precision.decode(&read[i]));
        // A block is one vector of four in the plane, and two in space, the last number of each unused.
        let width = if D == PLANAR { 4 } else { 8 };
        let block = |row: usize, side: usize| -> [f64; D] {
            std::array::from_fn(|k| blocks[(2 * row + side) * width + k / 3 * 4 + k % 3])
        };
        let jacobian = (0..problem.rows as usize).map(|row| [block(row, 0), block(row, 1)]).collect();
        let pair = bytemuck::pod_collect_to_vec(&read[0]);
        // Surfaces come after all bodies.
        let bodies = self.bodies as usize + self.setup.walls.len();
        Ok((Problem { bodies, pair, jacobian, q }, gamma))
    }

    /// Each body's rows, `2 row + side`, read back for tests.
    ///
    /// # Errors
    /// What the device refuses.
    pub fn incidence(&self) -> Result<Vec<Vec<u32>>, GpuError> {
        let problem = &self.rows.problem;
        let read = self
            .gpu
            .record()
            .read(&[(&problem.incidence_start, 0..4 * (self.bodies + 1)), (&problem.incidence, 0..8 * problem.rows)])?;
        let [start, entries]: [Vec<u32>; 2] = [0, 1].map(|i| bytemuck::pod_collect_to_vec(&read[i]));
        Ok(start.windows(2).map(|w| entries[w[0] as usize..w[1] as usize].to_vec()).collect())
    }

    fn grows(&self) -> bool {
        self.setup.growth.is_some()
    }

    /// The state of the step's start: the accepted one, or where bodies grow one of its own.
    fn start(&self) -> &Poses {
        &self.poses[self.start_index()]
    }

    fn start_index(&self) -> usize {
        if self.grows() { 2 } else { 0 }
    }

    fn start_shapes(&self) -> &Shapes {
        &self.shapes[if self.grows() { 1 } else { 0 }]
    }

    fn step_start(&self) -> f64 {
        self.start_time + self.step as f64 * self.setup.dt
    }

    fn parameters(&self) -> [u8; 16] {
        words([self.bodies as u32, 0, 0, 0])
    }

    /// Forces of a library's user, computed on the host from the state there.
    fn write_loads(&mut self) -> Result<(), GpuError> {
        let bodies = self.download(self.start(), self.start_shapes(), self.bodies, &self.ancestry)?;
        let time = self.step_start();
        let load = |i: usize| {
            let mut load = crate::dynamics::Load::default();
            for force in &self.plugged {
                load += force.load(&bodies, i, time);
            }
            let (f, t) = (load.force, load.torque);
            [f.x, f.y, f.z, 0.0, t.x, t.y, t.z, 0.0]
        };
        let loads: Vec<f64> = (0..bodies.len()).flat_map(load).collect();
        self.loads.reserve(&self.gpu, self.bodies)?;
        self.loads.write(&self.gpu, 0, &self.setup.precision.encode(loads));
        Ok(())
    }

    fn download(&self, poses: &Poses, shapes: &Shapes, count: u64, ancestry: &Ancestry) -> Result<Bodies, GpuError> {
        let Setup { precision, lattice, .. } = &self.setup;
        let read = state::download(&self.gpu, *precision, lattice, poses, shapes, count, self.grows())?;
        Ok(Bodies {
            periods: self.setup.periods,
            shape: read.shape,
            position: read.position,
            orientation: read.orientation,
            velocity: read.velocity,
            angular_velocity: read.angular_velocity,
            group: ancestry.group.clone(),
            lineage: ancestry.lineage.clone(),
        })
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
        let ancestry = self.before.as_ref().unwrap_or(&self.ancestry);
        Ok(State {
            step: self.step,
            next_id: ancestry.next_id,
            bodies: self.download(&self.poses[0], &self.shapes[0], self.accepted_bodies, ancestry)?,
            warm: self.remembered()?,
        })
    }

    fn remembered(&self) -> Result<Vec<Warm>, GpuError> {
        self.candidates.remembered(&self.gpu, &self.setup)
    }

    fn not_finite(&self, body: u32) -> Fault {
        Fault::NotFinite { step: self.step + 1, what: "velocity or pose", body: body as usize }
    }

    /// The separations at the start or at the trial, with a list of candidates that is complete for it, and how many rows there will be.
    /// `prepared` is what was recorded to be done before.
    fn separate(&mut self, prepared: Recorder<'_>, at_trial: bool) -> Result<Report, Fault> {
        let gpu = self.gpu.clone();
        let mut prepared = Some(prepared);
        loop {
            let mut record = prepared.take().unwrap_or_else(|| gpu.record());
            record.stage("narrow phase");
            record.copy(&self.blank, 0, &self.report, 0, Report::BYTES);
            let start = self.start_index();
            let Device { candidates, kernels, bodies, boxes, report, poses, .. } = &mut *self;
            let start = &poses[start];
            candidates.inside(&gpu, kernels, &mut record, (start, boxes, report), *bodies)?;
            let listed = candidates.is_for(*bodies);
            if listed {
                self.record_separations(&gpu, &mut record, at_trial)?;
            }
            let pairs = if listed { self.candidates.lists.pairs_count } else { 0 };
            let total = if listed { 4 * pairs..4 * pairs + 4 } else { 0..0 };
            let read = record.read(&[(&self.report, 0..Report::BYTES), (&self.rows.next_start, total)])?;
            let report: Report = bytemuck::pod_read_unaligned(&read[0]);
            if report.not_finite != u32::MAX {
                return Err(self.not_finite(report.not_finite));
            }
            if !at_trial {
                self.check_periods(&report)?;
            }
            if listed && report.outside == 0 {
                self.next_rows = u64::from(bytemuck::pod_read_unaligned::<u32>(&read[1]));
                self.candidates.used();
                return Ok(report);
            }
            self.search(&report, at_trial)?;
        }
    }

    fn record_separations(&mut self, gpu: &Gpu, record: &mut Recorder<'_>, at_trial: bool) -> Result<(), GpuError> {
        let poses = if at_trial { &self.poses[1] } else { self.start() };
        let (lists, pairs) = (&self.candidates.lists, self.candidates.lists.pairs_count);
        let of_bodies = lists.body_pairs;
        let parameters = words([of_bodies as u32, u32::from(at_trial), (self.violating as f32).to_bits(), 0]);
        let shapes = self.start_shapes();
        for kernel in &self.kernels.narrow {
            let buffers = [
                &lists.pairs,
                &poses.cells,
                &poses.remainders,
                &poses.orientations,
                &shapes.shapes,
                &self.boxes,
                &lists.contacts,
            ];
            record.run(kernel, &parameters, &buffers, of_bodies);
        }
        if let (Some(surfaces), Some(kernels)) = (&self.candidates.surfaces, &self.kernels.walls) {
            surfaces.separate(kernels, record, lists, (poses, shapes, &self.boxes), (at_trial, self.violating));
        }
        if at_trial {
            let buffers = [&shapes.shapes, &poses.orientations, &self.motions, &self.report];
            record.run(&self.kernels.farthest, &self.parameters(), &buffers, self.bodies);
            for (pass, threads) in [(1, pairs), (2, pairs), (3, 1)] {
                let buffers = [&lists.pairs, &lists.contacts, &self.report];
                record.run(&self.kernels.overlap, &words([pairs as u32, pass, 0, 0]), &buffers, threads);
            }
        }
        let what = if at_trial { (true, 2) } else { (false, 1) };
        self.rows.count(gpu, &self.kernels, record, &lists.contacts, pairs, what)
    }

    fn search(&mut self, report: &Report, at_trial: bool) -> Result<(), GpuError> {
        let begun = Instant::now();
        let largest = f64::from(f32::from_bits(report.largest));
        let gpu = self.gpu.clone();
        let (start, grows) = (self.start_index(), self.grows());
        let Device { candidates, setup, kernels, boxes, rows, bodies, poses, shapes, .. } = &mut *self;
        let (start, shapes) = (&poses[start], &shapes[usize::from(grows)]);
        let rows = at_trial.then_some(rows);
        candidates.search(&gpu, setup, kernels, (start, shapes, boxes, largest), *bodies, rows)?;
        let spent = begun.elapsed();
        self.phases.broad_phase += spent;
        // The caller counts all its time as narrow phase.
        self.phases.narrow_phase = self.phases.narrow_phase.saturating_sub(spent);
        Ok(())
    }
}

impl Backend for Device {
    fn begin(&mut self) -> Result<(), Fault> {
        self.phases = Phases::default();
        if self.grows() {
            let begun = Instant::now();
            self.grow()?;
            self.phases.growth += begun.elapsed();
        }
        let begun = Instant::now();
        if !self.plugged.is_empty() {
            if !std::mem::replace(&mut self.takes_loads, true) {
                self.kernels.motion = Kernel::new(&self.gpu, &source::motion(&self.setup, true))?;
            }
            self.write_loads()?;
        }
        let (gpu, bodies) = (self.gpu.clone(), self.bodies);
        self.motions.reserve(&gpu, bodies)?;
        self.boxes.reserve(&gpu, bodies)?;
        let mut record = gpu.record();
        record.stage("integrate");
        let (start, shapes) = (self.start(), &self.start_shapes().shapes);
        let buffers = [
            &start.cells,
            &start.remainders,
            &start.orientations,
            shapes,
            &start.twists,
            &self.groups_of,
            &self.loads,
            &self.motions,
        ];
        record.run(&self.kernels.motion, &self.parameters(), &buffers, bodies);
        let buffers = [&start.orientations, shapes, &self.motions, &self.boxes];
        record.run(&self.kernels.boxes, &self.parameters(), &buffers, bodies);
        record.submit()?;
        self.phases.integrate += begun.elapsed();
        Ok(())
    }

    fn middle(&mut self) -> Result<(), Fault> {
        Err(GpuError::Unsupported { what: "midpoint stepping".into() }.into())
    }

    fn tighten_violations(&mut self) -> Result<(), Fault> {
        Err(GpuError::Unsupported { what: "midpoint stepping".into() }.into())
    }

    fn append_near(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let gpu = self.gpu.clone();
        self.separate(gpu.record(), false)?;
        let mut record = gpu.record();
        record.stage("narrow phase");
        let Device { rows, kernels, candidates, motions, next_rows, bodies, .. } = &mut *self;
        rows.begin(&gpu, kernels, &mut record, &candidates.lists, motions, *next_rows)?;
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
        self.violating = violating;
        let begun = Instant::now();
        let (gpu, bodies) = (self.gpu.clone(), self.bodies);
        let mut record = gpu.record();
        record.stage("integrate");
        let (start, trial) = (self.start(), &self.poses[1]);
        let buffers = [
            &start.cells,
            &start.remainders,
            &start.orientations,
            &self.rows.problem.velocity,
            &self.motions,
            &trial.cells,
            &trial.remainders,
            &trial.orientations,
        ];
        record.run(&self.kernels.trial, &self.parameters(), &buffers, bodies);
        let buffers = [
            &start.cells,
            &start.remainders,
            &trial.cells,
            &trial.remainders,
            &trial.orientations,
            &self.start_shapes().shapes,
            &self.boxes,
        ];
        record.run(&self.kernels.sweep, &self.parameters(), &buffers, bodies);
        let report = self.separate(record, true)?;
        self.farthest = f64::from(f32::from_bits(report.farthest));
        self.phases.narrow_phase += begun.elapsed();
        Ok(report.overlap(&self.setup.walls))
    }

    fn append_violations(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let gpu = self.gpu.clone();
        let mut record = gpu.record();
        record.stage("narrow phase");
        let Device { rows, kernels, candidates, motions, next_rows, bodies, .. } = &mut *self;
        rows.extend(&gpu, kernels, &mut record, &candidates.lists, motions, *next_rows)?;
        rows.incidence(&gpu, kernels, &mut record, &candidates.lists, *bodies)?;
        record.submit()?;
        self.phases.narrow_phase += begun.elapsed();
        Ok(())
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
        record.run(&self.kernels.accept, &self.parameters(), &[&self.motions, &self.poses[1].twists], bodies);
        let (lists, problem) = (&self.candidates.lists, &self.rows.problem);
        let buffers = [&problem.block_start, &problem.gamma, &lists.contacts];
        let parameters = words([lists.pairs_count as u32, 0, 0, 0]);
        record.run(&self.kernels.remember, &parameters, &buffers, lists.pairs_count);
        record.submit()?;
        self.poses.swap(0, 1);
        if self.grows() {
            self.shapes.swap(0, 1);
        }
        self.before = None;
        self.accepted_bodies = bodies;
        self.lengthen();
        self.step += 1;
        self.state = OnceLock::new();
        self.phases.integrate += begun.elapsed();
        Ok(self.phases)
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

    fn steps(&self) -> u64 {
        self.step
    }

    fn bodies(&self) -> usize {
        self.accepted_bodies as usize
    }

    fn state(&self) -> Result<&State, Fault> {
        Ok(self.known_state()?)
    }

    fn add_force(&mut self, force: Box<dyn ForceField>) {
        self.plugged.push(force);
    }

    fn precision(&self) -> Precision {
        self.setup.precision
    }

    fn device(&self) -> Option<&Gpu> {
        Some(&self.gpu)
    }
}
