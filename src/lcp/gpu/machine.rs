//! Runs tapes: buffers, kernels, and the two ways to run a tape.
//!
//! A large problem needs one dispatch per stage. All dispatches but the first few are indirect, so that the stages
//! after the last iteration of a batch cost almost nothing. A single workgroup runs a small problem, a whole batch at
//! once.

use super::clusters::Tables;
use super::kernels::{Kernels, MOST_EXACT, Variant};
use super::layout::{DIAGONAL, FIRST_CONSTANT, GRID_WORDS, HALT, NUMBERS, Parameters, REDUCTIONS, Slots};
use super::number::Operation;
use super::problem::DeviceProblem;
use super::room::Room;
use super::shape::{Shape, ShapeWork, StageArguments};
use super::stage::{Action, Bodies, Product, Rows, Segment, Stage, Work};
use super::straight::{self, ELEMENT_WORDS, Part, Rounds};
use crate::gpu::{Bound, Buffer, Gpu, GpuError, Kernel, Precision, Recorder, WORKGROUP};
use crate::lcp::clusters::LOCAL_STEPS;
use std::ops::Range;

/// Workgroups of a stage at most; beyond, invocations take several rows. Each of them brings the partial sums of all
/// together, so that very many cost more than they gain. On lavapipe 2 to 64 cost the same within the noise at 2,900
/// rows; others were not measured on hardware.
const MOST_GROUPS: u64 = 512;

/// Rows or bodies up to which one workgroup does it all, unless set otherwise. Pairs of eight rows may need
/// 60,000 rounds for a pass over so many rows, and drivers before Mesa 23 end loops after 65,535. On lavapipe with two
/// threads a colony to 1,024 cells (3,300 rows) took 206 s, and with twice as many rows, where the driver does not end
/// loops, 140.
const LARGEST_SMALL_ON_SOFTWARE: u64 = 2048;

/// The same on hardware, where one workgroup is a small part of the device. On an NVIDIA H200 an iteration of 32 to 512
/// rows took 0.4 to 1.0 of the time of dispatches in f32, and 0.6 to 1.6 in f64, where 256 rows are even.
const LARGEST_SMALL: u64 = 128;

/// Looks of the first batch and of the others. A solve of `n` iterations then waits at most `2 + n / 64` times, some
/// refused claims included, and one that needs few wastes little: what follows the last iteration costs some empty
/// dispatches.
const LOOKS_OF_BATCHES: [usize; 2] = [16, 80];

pub(crate) struct Machine {
    variant: Variant,
    kernels: Kernels,
    pub largest_small: u64,
    /// Workgroups of a stage at most.
    pub most_groups: u64,
    /// Looks of the first batch of a solve and of the others; of a small problem at most so many.
    pub looks: [usize; 2],
    /// Looks that the last solve of a small problem needed.
    pub last_looks: usize,
    program: Buffer,
    /// Where the vectors and numbers of repeated elements are.
    rounds: Buffer,
    scalars: Buffer,
    vectors: Buffer,
    partial: Buffer,
    grid: Buffer,
    gathered: Buffer,
    /// What rounding has left off the velocities.
    velocity_rest: Buffer,
    lists: Buffer,
    /// The blocks of pairs of more than two rows.
    entries: Buffer,
    /// Where each row's pair ends, marked at its first row.
    span: Buffer,
    /// The tables of clusters, how many there are, and what their local LCPs lead to.
    clusters: Buffer,
    part_start: Buffer,
    clusters_made: u64,
    displacement: Buffer,
}

/// Partial sums of one stage, of the next, and of what confirms a look.
const PARTS: u64 = 3;

/// The gradient `g` at `x` is made afresh, and the residual there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Confirmation {
    pub x: u32,
    pub low: Option<u32>,
    pub g: u32,
    /// The place of the number that becomes the residual.
    pub residual: u32,
}

/// What a run starts with and what it reads.
#[derive(Clone, Debug, Default)]
pub(super) struct Task {
    /// How many vectors there are.
    pub vectors: u32,
    /// Whether no look has ended the batch yet.
    pub afresh: bool,
    /// What is done afterwards, if a look ended the batch.
    pub confirm: Option<Confirmation>,
    /// Ranges of numbers to read.
    pub read: Vec<Range<u32>>,
}

/// One run of one segment.
struct Run<'a, 'g> {
    machine: &'a Machine,
    problem: &'a DeviceProblem,
    record: Recorder<'g>,
    base: Parameters,
    /// Workgroups for rows, and for bodies.
    groups: [u64; 2],
    /// Rows, and bodies, beyond one an invocation.
    beyond: [u64; 2],
    /// Whether a look was made, so that the rest may be skipped.
    looked: bool,
}

impl Machine {
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self, GpuError> {
        let real = variant.precision.bytes();
        Ok(Machine {
            kernels: Kernels::default(),
            largest_small: if gpu.is_software() { LARGEST_SMALL_ON_SOFTWARE } else { LARGEST_SMALL },
            most_groups: MOST_GROUPS,
            looks: LOOKS_OF_BATCHES,
            last_looks: LOOKS_OF_BATCHES[0],
            program: Buffer::new(gpu, "lcp-program", 16, 1)?,
            rounds: Buffer::new(gpu, "lcp-rounds", 4 * ELEMENT_WORDS, 1)?,
            scalars: Buffer::new(gpu, "lcp-numbers", real, u64::from(NUMBERS))?,
            vectors: Buffer::new(gpu, "lcp-vectors", real, 1)?,
            partial: Buffer::new(gpu, "lcp-partial", real, PARTS * u64::from(REDUCTIONS) * MOST_GROUPS)?,
            grid: Buffer::new(gpu, "lcp-grid", 4, GRID_WORDS as u64)?,
            gathered: Buffer::new(gpu, "lcp-gathered", 4 * real, 1)?,
            velocity_rest: Buffer::new(gpu, "lcp-velocity-rest", 4 * real, 1)?,
            lists: Buffer::new(gpu, "lcp-lists", 4, 1)?,
            entries: Buffer::new(gpu, "lcp-entries", real, 1)?,
            span: Buffer::new(gpu, "lcp-spans", 4, 1)?,
            clusters: Buffer::new(gpu, "lcp-clusters", 4, 1)?,
            part_start: Buffer::new(gpu, "lcp-part-starts", 4, 1)?,
            clusters_made: 0,
            displacement: Buffer::new(gpu, "lcp-displacements", real, 1)?,
            variant,
        })
    }

    pub fn slots(&self) -> Slots {
        self.variant.slots
    }

    pub fn precision(&self) -> Precision {
        self.variant.precision
    }

    pub fn planar(&self) -> bool {
        self.variant.planar
    }

    #[cfg(test)]
    pub fn write(&self, gpu: &Gpu, problem: &DeviceProblem, vector: u32, numbers: &[f64]) -> Result<(), GpuError> {
        let offset = u64::from(vector) * problem.rows.next_multiple_of(64) * self.precision().bytes() as u64;
        self.vectors.write(gpu, offset, &self.precision().encode(numbers.iter().copied()));
        gpu.record().submit()
    }

    #[cfg(test)]
    pub fn read(&self, gpu: &Gpu, problem: &DeviceProblem, vector: u32) -> Result<Vec<f64>, GpuError> {
        let real = self.precision().bytes() as u64;
        let begin = u64::from(vector) * problem.rows.next_multiple_of(64) * real;
        let read = gpu.record().read(&[(&self.vectors, begin..begin + problem.rows * real)])?;
        Ok(self.precision().decode(&read[0]))
    }

    /// Makes the clusters of a problem, from its pairs, which are read back.
    pub fn make_clusters(&mut self, gpu: &Gpu, problem: &DeviceProblem) -> Result<(), GpuError> {
        let mut record = gpu.record();
        record.stage("lcp-clusters");
        let ranges = [(&problem.pair, 0..8 * problem.rows), (&problem.block_start, 0..4 * (problem.pairs + 1))];
        let [pairs, starts] = <[Vec<u8>; 2]>::try_from(record.read(&ranges)?).unwrap_or_default();
        let pairs: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(&pairs);
        let starts: Vec<u32> = bytemuck::pod_collect_to_vec(&starts);
        let tables = Tables::of(problem.bodies as usize, &pairs, &starts);
        self.clusters.reserve(gpu, tables.words.len() as u64)?;
        self.clusters.write(gpu, 0, bytemuck::cast_slice(&tables.words));
        self.part_start.reserve(gpu, tables.part_start.len() as u64)?;
        self.part_start.write(gpu, 0, bytemuck::cast_slice(&tables.part_start));
        self.displacement.reserve(gpu, tables.parts())?;
        self.clusters_made = tables.clusters as u64;
        Ok(())
    }

    /// Whether one workgroup does it all. How many slots are empty has no part in it: it follows from when candidates
    /// were searched for, which differs between a run and one that goes on from its state, and the two ways round
    /// differently.
    pub fn is_small(&self, problem: &DeviceProblem) -> bool {
        !self.variant.slots.clusters && problem.rows.max(problem.bodies) <= self.largest_small
    }

    /// Runs a segment on a problem, and reads numbers.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        problem: &DeviceProblem,
        segment: &Segment,
        constants: &[f64],
        task: &Task,
    ) -> Result<Vec<f64>, GpuError> {
        let stride = problem.rows.next_multiple_of(64);
        let small = self.is_small(problem);
        let mut record = gpu.record();
        self.vectors.reserve_and_keep(gpu, &mut record, u64::from(task.vectors) * stride)?;
        if small {
            self.lists.reserve(gpu, 4 * problem.rows + problem.pairs + problem.bodies + 2)?;
        } else {
            self.gathered.reserve(gpu, 2 * problem.rows * if problem.planar { 1 } else { 2 })?;
        }
        if self.variant.slots.coupling.is_some() {
            self.entries.reserve(gpu, problem.rows * u64::from(MOST_EXACT))?;
            self.span.reserve(gpu, problem.rows)?;
        }
        if self.variant.slots.low.is_some() {
            self.velocity_rest.reserve(gpu, problem.bodies * if problem.planar { 1 } else { 2 })?;
        }
        let items = [problem.rows, problem.bodies];
        let groups = items.map(|n| n.div_ceil(u64::from(WORKGROUP)).clamp(1, self.most_groups));
        let base = Parameters {
            rows: problem.rows as u32,
            pairs: problem.pairs as u32,
            bodies: problem.bodies as u32,
            stride: stride as u32,
            groups: groups[0] as u32,
            ..Parameters::default()
        };
        let real = self.variant.precision.bytes() as u64;
        let numbers = |from: u32, numbers: &[f64]| {
            self.scalars.write(gpu, u64::from(from) * real, &self.variant.precision.encode(numbers.iter().copied()));
        };
        if task.afresh {
            numbers(HALT, &[0.0]);
            let grid = [groups[0] as u32, 1, 1, groups[1] as u32, 1, 1];
            self.grid.write(gpu, 0, bytemuck::cast_slice(&grid));
        }
        numbers(FIRST_CONSTANT, constants);
        self.kernels.make_common(gpu, self.variant, small)?;
        let beyond = [0, 1].map(|grid| items[grid].saturating_sub(groups[grid] * u64::from(WORKGROUP)));
        let confirmation = task.confirm.map(confirmation).unwrap_or_default();
        if small {
            let size = [base.rows, base.pairs, base.bodies];
            let program = straight::of(segment, &confirmation, constants, size, self.variant.small_workgroup);
            for part in &program.parts {
                if let Part::Rounds(rounds) = part {
                    self.kernels.make_straight(gpu, self.variant, &rounds.shapes)?;
                }
            }
            self.program.reserve(gpu, program.words.len() as u64 / 4)?;
            self.program.write(gpu, 0, bytemuck::cast_slice(&program.words));
            if !program.places.is_empty() {
                self.rounds.reserve(gpu, program.places.len() as u64)?;
                self.rounds.write(gpu, 0, bytemuck::cast_slice(&program.places));
            }
            let mut run = Run { machine: self, problem, record, base, groups, beyond, looked: false };
            run.small(&program.parts);
            record = run.record;
        } else {
            let arguments = self.arguments(gpu, segment, &confirmation, constants)?;
            let mut run = Run { machine: self, problem, record, base, groups, beyond, looked: false };
            run.large(segment, &confirmation, &arguments);
            record = run.record;
        }
        if task.read.is_empty() {
            record.submit()?;
            return Ok(Vec::new());
        }
        let bytes = |range: &Range<u32>| u64::from(range.start) * real..u64::from(range.end) * real;
        let ranges: Vec<_> = task.read.iter().map(|range| (&self.scalars, bytes(range))).collect();
        let read = record.read(&ranges)?;
        Ok(read.iter().flat_map(|bytes| self.variant.precision.decode(bytes)).collect())
    }

    /// The arguments of all stages, whose kernels are compiled.
    fn arguments(
        &mut self,
        gpu: &Gpu,
        segment: &Segment,
        confirmation: &[Stage],
        constants: &[f64],
    ) -> Result<Vec<StageArguments>, GpuError> {
        let mut all = Vec::new();
        let mut kinds = segment.carried.clone();
        for stage in &segment.stages {
            let arguments = StageArguments::of(constants, stage, &kinds);
            debug_assert_eq!([arguments.vectors.len(), arguments.numbers.len()], Room::of(stage).places());
            all.push(arguments);
            kinds = stage.kinds();
        }
        kinds.clear();
        for stage in confirmation {
            let mut arguments = StageArguments::of(constants, stage, &kinds);
            arguments.shape.confirms = true;
            all.push(arguments);
            kinds = stage.kinds();
        }
        for arguments in &all {
            self.kernels.make(gpu, self.variant, &arguments.shape)?;
        }
        Ok(all)
    }
}

/// The stages of a confirmation.
fn confirmation(Confirmation { x, low, g, residual }: Confirmation) -> Vec<Stage> {
    let exact = low.is_some();
    let words = [Action::Residual as u32, 0, x, g, DIAGONAL, FIRST_CONSTANT, FIRST_CONSTANT, 0];
    let rows = Rows {
        product: Some(Product { out: g, add_q: true, exact }),
        before: vec![words],
        kinds: vec![Action::Residual.kind()],
        ..Rows::default()
    };
    let take = [Operation::Take as u32 | residual << 8, 0, 0, 0];
    vec![
        Stage { operations: Vec::new(), work: Work::Bodies(Bodies { x, low, instead: None, exact }) },
        Stage { operations: Vec::new(), work: Work::Rows(rows) },
        Stage { operations: vec![take], work: Work::Numbers },
    ]
}

/// The buffers of a stage's variables.
fn buffers<'a>(machine: &'a Machine, problem: &'a DeviceProblem, shape: &Shape) -> Vec<Bound<'a>> {
    let buffer = |name| match name {
        "scalars" => &machine.scalars,
        "partial" => &machine.partial,
        "entries" => &machine.entries,
        "gathered" => &machine.gathered,
        "grid" => &machine.grid,
        "velocity_rest" => &machine.velocity_rest,
        "span" => &machine.span,
        "pair" => &problem.pair,
        "jacobian" => &problem.jacobian,
        "velocity" => &problem.velocity,
        "clusters" => &machine.clusters,
        "part_start" => &machine.part_start,
        "displacement" => &machine.displacement,
        "incidence_start" => &problem.incidence_start,
        "incidence" => &problem.incidence,
        _ => &machine.vectors,
    };
    shape.variables().into_iter().map(|(name, ..)| (name, buffer(name))).collect()
}

impl Run<'_, '_> {
    /// One dispatch a stage.
    fn large(&mut self, segment: &Segment, confirmation: &[Stage], arguments: &[StageArguments]) {
        // Where in the partial sums a stage leaves its own: by turns, so that those before it are still there.
        let part = |nth: u64| (nth * u64::from(REDUCTIONS) * self.groups[0]) as u32;
        let [even, odd, last] = [0, 1, 2].map(part);
        let mut looks = segment.looks_before;
        let mut into_odd = segment.run % 2 == 1;
        let (own, after) = arguments.split_at(segment.stages.len().min(arguments.len()));
        for (stage, arguments) in segment.stages.iter().zip(own) {
            let (sums_from, sums_into) = if into_odd { (even, odd) } else { (odd, even) };
            let parameters = Parameters { looks, sums_from, sums_into, ..self.base };
            self.stage(stage, arguments, parameters);
            looks += stage.looks();
            into_odd = !into_odd;
        }
        for (stage, arguments) in confirmation.iter().zip(after) {
            let parameters = Parameters { looks, sums_from: last, sums_into: last, ..self.base };
            self.stage(stage, arguments, parameters);
        }
    }

    fn stage(&mut self, stage: &Stage, arguments: &StageArguments, parameters: Parameters) {
        self.record.stage(stage.name());
        match stage.work {
            Work::PrepareRows => {
                self.prepare_rows();
                self.prepare_entries();
            }
            Work::PreparePairs => self.prepare_pairs(),
            Work::Export { x } => self.export(x),
            Work::Clusters(_) => self.in_clusters(arguments, parameters),
            Work::Numbers | Work::Rows(_) | Work::Bodies(_) => self.dispatch(arguments, parameters),
        }
    }

    /// Dispatches a stage: directly, until it may have to be skipped.
    fn dispatch(&mut self, arguments: &StageArguments, mut parameters: Parameters) {
        let shape = &arguments.shape;
        let Some(kernel) = self.machine.kernels.stage(shape) else { return };
        parameters.base = arguments.base;
        parameters.pass(&arguments.vectors, &arguments.numbers);
        let parameters = bytemuck::bytes_of(&parameters);
        let buffers = buffers(self.machine, self.problem, shape);
        let grid = usize::from(shape.is_bodies());
        let groups = if shape.work == ShapeWork::Numbers { 1 } else { self.groups[grid] };
        if shape.work != ShapeWork::Numbers {
            self.record.weigh(self.beyond[grid]);
        }
        if self.looked && !shape.looks() && !shape.confirms {
            let grid = (&self.machine.grid, 12 * grid as u64);
            self.record.run_indirect(kernel, parameters, &buffers, grid, groups);
        } else {
            self.record.run_groups(kernel, parameters, &buffers, groups);
        }
        self.looked |= shape.looks();
    }

    /// Dispatches a stage of clusters, one workgroup each. It finds out itself whether it is to be skipped.
    fn in_clusters(&mut self, arguments: &StageArguments, mut parameters: Parameters) {
        let shape = &arguments.shape;
        let Some(kernel) = self.machine.kernels.stage(shape) else { return };
        let clusters = self.machine.clusters_made;
        parameters.base = arguments.base;
        parameters.first = clusters as u32;
        parameters.pass(&arguments.vectors, &arguments.numbers);
        // Each step is about as long as another stage.
        self.record.weigh(LOCAL_STEPS as u64 * clusters * u64::from(WORKGROUP));
        let buffers = buffers(self.machine, self.problem, shape);
        self.record.run_groups(kernel, bytemuck::bytes_of(&parameters), &buffers, clusters.max(1));
        self.looked |= shape.looks();
    }

    fn prepare_entries(&mut self) {
        let (machine, problem) = (self.machine, self.problem);
        let buffers = [
            ("incidence_start", &problem.incidence_start),
            ("incidence", &problem.incidence),
            ("jacobian", &problem.jacobian),
            ("gathered", &machine.gathered),
        ];
        if let Some(kernel) = machine.kernels.prepare_entries() {
            self.record.run(kernel, bytemuck::bytes_of(&self.base), &buffers, 2 * problem.rows);
        }
    }

    /// One workgroup for all stages, in dispatches that are long but not too long.
    fn small(&mut self, parts: &[Part]) {
        for part in parts {
            match part {
                Part::Turns { range, confirms } => {
                    let machine = self.machine;
                    let Some(kernel) = machine.kernels.small() else { return };
                    let program = ("program", &machine.program);
                    self.small_dispatch("lcp-small", kernel, program, range.clone(), *confirms);
                }
                Part::Rounds(rounds) => self.rounds(rounds),
                Part::Other(Work::PrepareRows) => {
                    self.prepare_rows();
                    self.make_lists();
                }
                Part::Other(Work::PreparePairs) => self.prepare_pairs(),
                Part::Other(Work::Export { x }) => self.export(*x),
                Part::Other(_) => {}
            }
        }
    }

    fn rounds(&mut self, Rounds { shapes, first, rounds, at_once }: &Rounds) {
        let machine = self.machine;
        let Some(kernel) = machine.kernels.straight(shapes) else { return };
        let place = |round: u32| first + round * shapes.len() as u32;
        for round in (0..*rounds).step_by(*at_once as usize) {
            let range = place(round)..place((round + at_once).min(*rounds));
            self.small_dispatch("lcp-rounds", kernel, ("rounds", &machine.rounds), range, false);
        }
    }

    fn small_dispatch(
        &mut self,
        stage: &'static str,
        kernel: &Kernel,
        program: Bound<'_>,
        range: Range<u32>,
        confirms: bool,
    ) {
        self.record.stage(stage);
        let (machine, problem) = (self.machine, self.problem);
        let (first, last) = (range.start, range.end);
        let parameters = Parameters { first, last, looks: u32::from(confirms), ..self.base };
        let mut buffers = vec![
            program,
            ("scalars", &machine.scalars),
            ("vectors", &machine.vectors),
            ("velocity", &problem.velocity),
            ("jacobian", &problem.jacobian),
            ("lists", &machine.lists),
        ];
        if self.machine.variant.slots.coupling.is_some() {
            buffers.push(("entries", &machine.entries));
        }
        if self.machine.variant.slots.low.is_some() {
            buffers.push(("velocity_rest", &machine.velocity_rest));
        }
        self.record.run_groups(kernel, bytemuck::bytes_of(&parameters), &buffers, 1);
    }

    fn prepare_rows(&mut self) {
        let problem = self.problem;
        let buffers = [
            ("pair", &problem.pair),
            ("jacobian", &problem.jacobian),
            ("offset", &problem.q),
            ("gamma", &problem.gamma),
            ("incidence_start", &problem.incidence_start),
            ("vectors", &self.machine.vectors),
        ];
        if let Some(kernel) = self.machine.kernels.prepare_rows() {
            self.record.run(kernel, bytemuck::bytes_of(&self.base), &buffers, problem.rows);
        }
    }

    fn prepare_pairs(&mut self) {
        let problem = self.problem;
        let buffers = [
            ("block_start", &problem.block_start),
            ("pair", &problem.pair),
            ("jacobian", &problem.jacobian),
            ("vectors", &self.machine.vectors),
            ("entries", &self.machine.entries),
            ("span", &self.machine.span),
        ];
        if let Some(kernel) = self.machine.kernels.prepare_pairs() {
            self.record.run(kernel, bytemuck::bytes_of(&self.base), &buffers, problem.pairs);
        }
    }

    /// All lists in one buffer: a kernel may have only eight.
    fn make_lists(&mut self) {
        let (problem, lists) = (self.problem, &self.machine.lists);
        let parts = [
            (&problem.pair, 2 * problem.rows),
            (&problem.block_start, problem.pairs + 1),
            (&problem.incidence_start, problem.bodies + 1),
            (&problem.incidence, 2 * problem.rows),
        ];
        let mut to = 0;
        for (part, words) in parts {
            self.record.copy(part, 0, lists, 4 * to, 4 * words);
            to += words;
        }
    }

    fn export(&mut self, x: u32) {
        let real = self.machine.variant.precision.bytes() as u64;
        let from = u64::from(x) * u64::from(self.base.stride) * real;
        self.record.copy(&self.machine.vectors, from, &self.problem.gamma, 0, self.problem.rows * real);
    }
}
