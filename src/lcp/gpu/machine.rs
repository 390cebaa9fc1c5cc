//! Runs tapes: buffers, kernels, and the two ways to run a tape.
//!
//! A large problem takes one dispatch a stage; all but the first few are indirect, so that what follows the last
//! iteration of a batch costs next to nothing. A small one is run by a single workgroup, whole batches at once.

use super::kernels::{Kernels, MOST_EXACT, Variant};
use super::layout::{FIRST_CONSTANT, GRID_WORDS, HALT, NUMBERS, Parameters, REDUCTIONS, Slots};
use super::problem::DeviceProblem;
use super::shape::StageArguments;
use super::tape::{Stage, Sums, Tape};
use super::turns::{self, Part, TURN_WORDS};
use crate::gpu::{Bound, Buffer, Gpu, GpuError, Kernel, Precision, Recorder, WORKGROUP};
use std::ops::Range;

/// Workgroups of a stage at most; beyond, invocations take several rows.
const MOST_GROUPS: u64 = 1024;

/// Rows, pairs or bodies up to which one workgroup does it all, unless set otherwise. On lavapipe it took a third of
/// the time at 32 rows, half of it at 256 and 0.6 of it at 1,024, with two busy cores.
const LARGEST_SMALL_ON_SOFTWARE: u64 = 1024;

/// The same on hardware: not measured; there one workgroup is a small part of the device.
const LARGEST_SMALL: u64 = 128;

pub(crate) struct Machine {
    variant: Variant,
    kernels: Kernels,
    pub largest_small: u64,
    program: Buffer,
    scalars: Buffer,
    vectors: Buffer,
    partial: Buffer,
    grid: Buffer,
    gathered: Buffer,
    lists: Buffer,
    /// The blocks of pairs of more than two rows.
    entries: Buffer,
}

/// One run of one tape.
struct Run<'a, 'g> {
    machine: &'a Machine,
    problem: &'a DeviceProblem,
    tape: &'a Tape,
    record: Recorder<'g>,
    base: Parameters,
    /// Workgroups for rows and pairs, and for bodies.
    groups: [u64; 2],
    /// Rows or pairs, and bodies, beyond one an invocation.
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
            program: Buffer::new(gpu, "lcp-program", 16, 1)?,
            scalars: Buffer::new(gpu, "lcp-numbers", real, u64::from(NUMBERS))?,
            vectors: Buffer::new(gpu, "lcp-vectors", real, 1)?,
            partial: Buffer::new(gpu, "lcp-partial", real, u64::from(REDUCTIONS) * MOST_GROUPS)?,
            grid: Buffer::new(gpu, "lcp-grid", 4, GRID_WORDS as u64)?,
            gathered: Buffer::new(gpu, "lcp-gathered", 4 * real, 1)?,
            lists: Buffer::new(gpu, "lcp-lists", 4, 1)?,
            entries: Buffer::new(gpu, "lcp-entries", real, 1)?,
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

    fn is_small(&self, problem: &DeviceProblem) -> bool {
        problem.rows.max(problem.pairs).max(problem.bodies) <= self.largest_small
    }

    /// Runs a tape on a problem with so many vectors, and reads ranges of numbers.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        problem: &DeviceProblem,
        tape: &Tape,
        vectors: u32,
        read: &[Range<u32>],
    ) -> Result<Vec<f64>, GpuError> {
        let stride = problem.rows.next_multiple_of(64);
        let small = self.is_small(problem);
        let mut record = gpu.record();
        self.vectors.reserve_and_keep(gpu, &mut record, u64::from(vectors) * stride)?;
        if small {
            self.lists.reserve(gpu, 4 * problem.rows + problem.pairs + problem.bodies + 2)?;
        } else {
            self.gathered.reserve(gpu, 2 * problem.rows * if problem.planar { 1 } else { 2 })?;
        }
        if self.variant.slots.coupling.is_some() {
            self.entries.reserve(gpu, problem.rows * u64::from(MOST_EXACT))?;
        }
        let items = [problem.rows.max(problem.pairs), problem.bodies];
        let groups = items.map(|n| n.div_ceil(u64::from(WORKGROUP)).clamp(1, MOST_GROUPS));
        let base = Parameters {
            rows: problem.rows as u32,
            pairs: problem.pairs as u32,
            bodies: problem.bodies as u32,
            stride: stride as u32,
            groups: groups[0] as u32,
            ..Parameters::default()
        };
        let mut program = program(tape);
        let (mut parts, mut arguments) = (Vec::new(), Vec::new());
        if small {
            let turns;
            (parts, turns) = turns::of(tape, [base.rows, base.pairs, base.bodies]);
            program.extend(turns.as_flattened());
        } else {
            arguments = tape.stages.iter().map(|stage| StageArguments::of(tape, stage)).collect();
        }
        self.program.reserve(gpu, program.len() as u64 / 4)?;
        self.program.write(gpu, 0, bytemuck::cast_slice(&program));
        let real = self.variant.precision.bytes() as u64;
        // No look ended this batch yet.
        let numbers = |from: u32, numbers: &[f64]| {
            self.scalars.write(gpu, u64::from(from) * real, &self.variant.precision.encode(numbers.iter().copied()));
        };
        numbers(FIRST_CONSTANT, tape.constants());
        numbers(HALT, &[0.0]);
        let grid = [groups[0] as u32, 1, 1, groups[1] as u32, 1, 1];
        self.grid.write(gpu, 0, bytemuck::cast_slice(&grid));
        self.kernels.make_common(gpu, self.variant, small)?;
        for arguments in arguments.iter().flatten() {
            self.kernels.make(gpu, self.variant, &arguments.shape)?;
        }
        let beyond = [0, 1].map(|grid| items[grid].saturating_sub(groups[grid] * u64::from(WORKGROUP)));
        let mut run = Run { machine: self, problem, tape, record, base, groups, beyond, looked: false };
        if small {
            run.small(&parts)
        } else {
            run.large(&arguments)
        }
        let mut record = run.record;
        if read.is_empty() {
            record.submit()?;
            return Ok(Vec::new());
        }
        let bytes = |range: &Range<u32>| u64::from(range.start) * real..u64::from(range.end) * real;
        let ranges: Vec<_> = read.iter().map(|range| (&self.scalars, bytes(range))).collect();
        let read = record.read(&ranges)?;
        Ok(read.iter().flat_map(|bytes| self.variant.precision.decode(bytes)).collect())
    }
}

/// The tape as words for the device: instructions and operations.
fn program(tape: &Tape) -> Vec<u32> {
    let mut words: Vec<u32> = tape.instructions.as_flattened().to_vec();
    words.extend(tape.operations.as_flattened());
    words
}

/// Where an operation stands in the program.
fn operation(tape: &Tape, index: usize) -> u32 {
    (2 * tape.instructions.len() + index) as u32
}

impl Run<'_, '_> {
    /// One dispatch a stage.
    fn large(&mut self, arguments: &[Option<StageArguments>]) {
        let (machine, problem) = (self.machine, self.problem);
        let Some(kernels) = machine.kernels.large() else { return };
        let [scalars, vectors, partial] = [&machine.scalars, &machine.vectors, &machine.partial];
        for (stage, arguments) in self.tape.stages.iter().zip(arguments) {
            self.record.stage(stage.name());
            match *stage {
                Stage::Rows { product, sums, .. } => {
                    let mut buffers = vec![("scalars", scalars), ("vectors", vectors), ("partial", partial)];
                    if product.is_some() {
                        buffers.extend([
                            ("pair", &problem.pair),
                            ("jacobian", &problem.jacobian),
                            ("velocity", &problem.velocity),
                        ]);
                    }
                    let add_q = product.is_some_and(|product| product.add_q);
                    self.rows(arguments.as_ref(), sums, add_q, &buffers);
                }
                Stage::Pairs { sums, .. } => {
                    let buffers = [
                        ("scalars", scalars),
                        ("vectors", vectors),
                        ("partial", partial),
                        ("block_start", &problem.block_start),
                        ("entries", &machine.entries),
                    ];
                    self.rows(arguments.as_ref(), sums, false, &buffers);
                }
                Stage::Bodies { x } => {
                    let parameters = Parameters { x, ..self.base };
                    let buffers = [
                        ("vectors", vectors),
                        ("incidence_start", &problem.incidence_start),
                        ("incidence", &problem.incidence),
                        ("gathered", &machine.gathered),
                        ("velocity", &problem.velocity),
                    ];
                    self.dispatch(&kernels.bodies, &parameters, &buffers, 1);
                }
                Stage::Finish { begin, end, kinds, sums } => {
                    let [first, last] = [begin, end].map(|index| operation(self.tape, index));
                    let parameters = Parameters { first, last, kinds, reductions: sums, ..self.base };
                    let buffers = [
                        ("program", &machine.program),
                        ("scalars", scalars),
                        ("partial", partial),
                        ("grid", &machine.grid),
                    ];
                    self.record.run_groups(&kernels.finish, bytemuck::bytes_of(&parameters), &buffers, 1);
                    self.looked |= self.tape.looks_in(begin, end);
                }
                Stage::PrepareRows => {
                    self.prepare_rows();
                    let buffers = [
                        ("incidence_start", &problem.incidence_start),
                        ("incidence", &problem.incidence),
                        ("jacobian", &problem.jacobian),
                        ("gathered", &machine.gathered),
                    ];
                    let parameters = bytemuck::bytes_of(&self.base);
                    self.record.run(&kernels.prepare_entries, parameters, &buffers, 2 * problem.rows);
                }
                Stage::PreparePairs => self.prepare_pairs(),
                Stage::Export { x } => self.export(x),
            }
        }
    }

    fn rows(&mut self, arguments: Option<&StageArguments>, sums: Sums, add_q: bool, buffers: &[Bound<'_>]) {
        let Some(arguments) = arguments else { return };
        let Some(kernel) = self.machine.kernels.stage(&arguments.shape) else { return };
        let Sums { first: reduction, count: reductions, kinds } = sums;
        let add_q = u32::from(add_q);
        let mut parameters = Parameters { reduction, reductions, kinds, add_q, ..self.base };
        parameters.vectors[..arguments.vectors.len()].copy_from_slice(&arguments.vectors);
        parameters.numbers[..arguments.numbers.len()].copy_from_slice(&arguments.numbers);
        self.dispatch(kernel, &parameters, buffers, 0);
    }

    /// Dispatches a stage: directly, until it may have to be skipped. Grid 0 is for rows and pairs, 1 for bodies.
    fn dispatch(&mut self, kernel: &Kernel, parameters: &Parameters, buffers: &[Bound<'_>], grid: usize) {
        let parameters = bytemuck::bytes_of(parameters);
        self.record.weigh(self.beyond[grid]);
        if self.looked {
            let groups = (&self.machine.grid, 12 * grid as u64);
            self.record.run_indirect(kernel, parameters, buffers, groups, self.groups[grid]);
        } else {
            self.record.run_groups(kernel, parameters, buffers, self.groups[grid]);
        }
    }

    /// One workgroup for all stages, in dispatches that are long but not too long.
    fn small(&mut self, parts: &[Part]) {
        let mut place = operation(self.tape, self.tape.operations.len());
        for part in parts {
            match part {
                Part::Turns(turns) => {
                    let last = place + (turns * TURN_WORDS / 4) as u32;
                    self.small_dispatch(place, last);
                    place = last;
                }
                Part::Other(Stage::PrepareRows) => {
                    self.prepare_rows();
                    self.make_lists();
                }
                Part::Other(Stage::PreparePairs) => self.prepare_pairs(),
                Part::Other(Stage::Export { x }) => self.export(*x),
                Part::Other(_) => {}
            }
        }
    }

    fn small_dispatch(&mut self, first: u32, last: u32) {
        if first == last {
            return;
        }
        self.record.stage("lcp-small");
        let (machine, problem) = (self.machine, self.problem);
        let parameters = Parameters { first, last, ..self.base };
        let mut buffers = vec![
            ("program", &machine.program),
            ("scalars", &machine.scalars),
            ("vectors", &machine.vectors),
            ("velocity", &problem.velocity),
            ("jacobian", &problem.jacobian),
            ("lists", &machine.lists),
        ];
        if self.machine.variant.slots.coupling.is_some() {
            buffers.push(("entries", &machine.entries));
        }
        if let Some(kernel) = machine.kernels.small() {
            self.record.run_groups(kernel, bytemuck::bytes_of(&parameters), &buffers, 1);
        }
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
