//! Runs tapes: buffers, kernels, and the two ways to run a tape.
//!
//! A large problem needs one dispatch per stage. All dispatches but the first few are indirect, so that the stages
//! after the last iteration of a batch cost almost nothing. A single workgroup runs a small problem, a whole batch at
//! once.

use super::clusters::Tables;
use super::kernels::Kernels;
use super::layout::{DIAGONAL, FIRST_CONSTANT, HALT, MOST_GROUPS, Slots, TOLERANCE, Variant};
use super::memory::Memory;
use super::number::Operation;
use super::problem::DeviceProblem;
use super::room::Room;
use super::run::Run;
use super::shape::StageArguments;
use super::stage::{Action, Bodies, Product, Rows, Segment, Stage, Work};
use super::straight::{self, Part};
use crate::gpu::{Gpu, GpuError, Precision, WORKGROUP};
use crate::lcp::friction::packed::PackedContacts;
use std::ops::Range;

/// The largest number of rows or bodies of a problem that one workgroup solves, unless set otherwise. Pairs of eight
/// rows may need 60,000 rounds for a pass over this many rows, and drivers before Mesa 23 end loops after 65,535. On
/// lavapipe with two threads a colony to 1,024 cells (3,300 rows) took 206 s; with twice this limit, on a driver that
/// does not end loops, 140 s.
const LARGEST_SMALL_ON_SOFTWARE: u64 = 2048;

/// The same on hardware, where one workgroup is a small part of the device. On an NVIDIA H200, an iteration of 32 to
/// 512 rows took 0.4 to 1.0 of the time of dispatches in f32, and 0.6 to 1.6 in f64, where 256 rows take the same time.
const LARGEST_SMALL: u64 = 128;

/// Checks in the first batch and in the others. A solve of `n` iterations then waits at most `2 + n / 64` times,
/// including some for refuted candidates. A solve with few iterations wastes little: the stages after the last
/// iteration cost only empty dispatches.
const LOOKS_OF_BATCHES: [usize; 2] = [16, 80];

pub(crate) struct Machine {
    variant: Variant,
    pub(super) kernels: Kernels,
    pub(super) memory: Memory,
    pub largest_small: u64,
    /// The largest number of workgroups of a stage.
    pub most_groups: u64,
    /// The numbers of checks in the first batch of a solve and in the others; upper limits for a small problem.
    pub looks: [usize; 2],
    /// The number of checks that the last solve of a small problem needed.
    pub last_looks: usize,
    /// The number of clusters of the problem.
    pub(super) clusters_made: u64,
    /// The tolerance of problems with friction.
    pub(super) tolerance: f64,
}

/// A confirmation: the gradient `g` at `x` is recomputed, and the residual there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Confirmation {
    pub x: u32,
    pub low: Option<u32>,
    pub g: u32,
    /// The offset of the scalar that becomes the residual.
    pub residual: u32,
}

/// The start of a run, and the values to read after it.
#[derive(Clone, Debug, Default)]
pub(super) struct Task {
    /// The number of vectors.
    pub vectors: u32,
    /// Whether no check has ended the batch yet.
    pub afresh: bool,
    /// The confirmation to execute after the run, if a check ended the batch.
    pub confirm: Option<Confirmation>,
    /// Ranges of scalars to read.
    pub read: Vec<Range<u32>>,
}

impl Machine {
    pub fn new(gpu: &Gpu, variant: Variant) -> Result<Self, GpuError> {
        Ok(Machine {
            kernels: Kernels::default(),
            memory: Memory::new(gpu, &variant)?,
            largest_small: if gpu.is_software() { LARGEST_SMALL_ON_SOFTWARE } else { LARGEST_SMALL },
            most_groups: MOST_GROUPS,
            looks: LOOKS_OF_BATCHES,
            last_looks: LOOKS_OF_BATCHES[0],
            clusters_made: 0,
            tolerance: 0.0,
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
        let element = (self.variant.element() * self.precision().bytes()) as u64;
        let offset = u64::from(vector) * problem.stride() * element;
        self.memory.vectors.write(gpu, offset, &self.precision().encode(numbers.iter().copied()));
        gpu.record().submit()
    }

    #[cfg(test)]
    pub fn read(&self, gpu: &Gpu, problem: &DeviceProblem, vector: u32) -> Result<Vec<f64>, GpuError> {
        let element = (self.variant.element() * self.precision().bytes()) as u64;
        let begin = u64::from(vector) * problem.stride() * element;
        let read = gpu.record().read(&[(&self.memory.vectors, begin..begin + problem.rows * element)])?;
        Ok(self.precision().decode(&read[0]))
    }

    /// Writes what contacts with friction have beside their normal rows.
    pub fn write_contacts(&mut self, gpu: &Gpu, of: &PackedContacts) -> Result<(), GpuError> {
        let precision = self.precision();
        let Memory { tangents, contacts, gammas, .. } = &mut self.memory;
        for (buffer, numbers) in [(tangents, &of.tangents), (contacts, &of.contacts), (gammas, &of.gammas)] {
            buffer.reserve(gpu, numbers.len() as u64 / 4)?;
            buffer.write(gpu, 0, &precision.encode(numbers.iter().copied()));
        }
        Ok(())
    }

    /// Reads the multipliers of contacts with friction: four numbers each.
    pub fn read_gammas(&self, gpu: &Gpu, problem: &DeviceProblem) -> Result<Vec<f64>, GpuError> {
        let gammas = &self.memory.gammas;
        let read = gpu.record().read(&[(gammas, 0..problem.rows * gammas.element() as u64)])?;
        Ok(self.precision().decode(&read[0]))
    }

    /// Creates the clusters of a problem from its pairs, which are read back.
    pub fn make_clusters(&mut self, gpu: &Gpu, problem: &DeviceProblem) -> Result<(), GpuError> {
        let mut record = gpu.record();
        record.stage("lcp-clusters");
        let ranges = [(&problem.pair, 0..8 * problem.rows), (&problem.block_start, 0..4 * (problem.pairs + 1))];
        let [pairs, starts] = <[Vec<u8>; 2]>::try_from(record.read(&ranges)?).unwrap_or_default();
        let pairs: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(&pairs);
        let starts: Vec<u32> = bytemuck::pod_collect_to_vec(&starts);
        let tables = Tables::of(problem.bodies as usize, &pairs, &starts);
        let memory = &mut self.memory;
        memory.clusters.reserve(gpu, tables.words.len() as u64)?;
        memory.clusters.write(gpu, 0, bytemuck::cast_slice(&tables.words));
        memory.part_start.reserve(gpu, tables.part_start.len() as u64)?;
        memory.part_start.write(gpu, 0, bytemuck::cast_slice(&tables.part_start));
        memory.displacement.reserve(gpu, tables.parts())?;
        self.clusters_made = tables.clusters as u64;
        Ok(())
    }

    /// Whether one workgroup solves the problem. This does not depend on the number of empty slots: that number depends
    /// on when candidates were searched, which differs between a run and one that continues from its state, and the two
    /// paths round differently.
    pub fn is_small(&self, problem: &DeviceProblem) -> bool {
        let Slots { clusters, friction, .. } = self.variant.slots;
        !clusters && friction.is_none() && problem.rows.max(problem.bodies) <= self.largest_small
    }

    /// Runs a segment on a problem, and reads scalars.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        problem: &DeviceProblem,
        segment: &Segment,
        constants: &[f64],
        task: &Task,
    ) -> Result<Vec<f64>, GpuError> {
        let small = self.is_small(problem);
        let mut record = gpu.record();
        self.memory.reserve(&mut record, &self.variant, problem, (task.vectors, small))?;
        let items = [problem.rows, problem.bodies];
        let groups = items.map(|n| n.div_ceil(u64::from(WORKGROUP)).clamp(1, self.most_groups));
        self.write_numbers(gpu, constants, task.afresh.then_some(groups));
        self.kernels.make_common(gpu, self.variant, small)?;
        let confirmation = task.confirm.map(|confirm| self.confirmation(confirm)).unwrap_or_default();
        let mut run;
        if small {
            let parts = self.program(gpu, problem, segment, &confirmation, constants)?;
            run = Run::new(self, problem, record, groups);
            run.small(&parts);
        } else {
            let arguments = self.arguments(gpu, segment, &confirmation, constants)?;
            run = Run::new(self, problem, record, groups);
            run.large(segment, &confirmation, &arguments);
        }
        let (mut record, real) = (run.record, self.variant.precision.bytes() as u64);
        if task.read.is_empty() {
            record.submit()?;
            return Ok(Vec::new());
        }
        let bytes = |range: &Range<u32>| u64::from(range.start) * real..u64::from(range.end) * real;
        let ranges: Vec<_> = task.read.iter().map(|range| (&self.memory.scalars, bytes(range))).collect();
        let read = record.read(&ranges)?;
        Ok(read.iter().flat_map(|bytes| self.variant.precision.decode(bytes)).collect())
    }

    /// Writes the constants of a tape. With `afresh`, also resets the mark of the check that ended the batch, and sets
    /// the number of workgroups of stages until a check ends it.
    fn write_numbers(&self, gpu: &Gpu, constants: &[f64], afresh: Option<[u64; 2]>) {
        let precision = self.variant.precision;
        let numbers = |from: u32, numbers: &[f64]| {
            let encoded = precision.encode(numbers.iter().copied());
            self.memory.scalars.write(gpu, u64::from(from) * precision.bytes() as u64, &encoded);
        };
        if let Some(groups) = afresh {
            numbers(HALT, &[0.0]);
            let grid = [groups[0] as u32, 1, 1, groups[1] as u32, 1, 1];
            self.memory.grid.write(gpu, 0, bytemuck::cast_slice(&grid));
        }
        numbers(FIRST_CONSTANT, constants);
        if self.variant.slots.friction.is_some() {
            numbers(TOLERANCE, &[self.tolerance]);
        }
    }

    /// Writes a segment as the program of one workgroup and compiles its kernels. Returns its parts.
    fn program(
        &mut self,
        gpu: &Gpu,
        problem: &DeviceProblem,
        segment: &Segment,
        confirmation: &[Stage],
        constants: &[f64],
    ) -> Result<Vec<Part>, GpuError> {
        let size = [problem.rows, problem.pairs, problem.bodies].map(|n| n as u32);
        let program = straight::of(segment, confirmation, constants, size, self.variant.small_workgroup);
        for part in &program.parts {
            if let Part::Rounds(rounds) = part {
                self.kernels.make_straight(gpu, self.variant, &rounds.shapes)?;
            }
        }
        let memory = &mut self.memory;
        memory.program.reserve(gpu, program.words.len() as u64 / 4)?;
        memory.program.write(gpu, 0, bytemuck::cast_slice(&program.words));
        if !program.places.is_empty() {
            memory.rounds.reserve(gpu, program.places.len() as u64)?;
            memory.rounds.write(gpu, 0, bytemuck::cast_slice(&program.places));
        }
        Ok(program.parts)
    }

    /// The arguments of all stages; compiles their kernels.
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

    /// The stages of a confirmation.
    fn confirmation(&self, Confirmation { x, low, g, residual }: Confirmation) -> Vec<Stage> {
        let exact = low.is_some();
        let none = FIRST_CONSTANT;
        let of = |action: Action, out, [a, b, c]: [u32; 3]| [action as u32, out, a, b, c, none, none, 0];
        let before = match self.variant.slots.friction {
            None => vec![of(Action::Residual, 0, [x, g, DIAGONAL])],
            Some(friction) => vec![
                of(Action::Comply, g, [g, x, friction.compliance]),
                of(Action::Residual, 0, [x, g, friction.correction]),
            ],
        };
        let rows = Rows {
            product: Some(Product { out: g, add_q: true, exact }),
            before,
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
}
