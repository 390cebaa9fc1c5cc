//! Rows by branches on the device: each smooth branch of a pair's separation that may become active has its own row.
//!
//! A pair has one entry in the list of pairs. A mask in the entry marks the branches that get a row next. Their
//! contacts are staged at the indices of the future rows, and the rows are made from them. Each row stores the index of
//! its branch, which is the key of its stored multiplier.

use super::branch_source::{BranchKernels, FIRST_ROW};
use super::candidates::Lists;
use super::near::RowInputs;
use super::row_set::RowSet;
use super::source::Kernels;
use super::start::{Part, Stages};
use super::{Setup, words};
use crate::gpu::{Buffer, Gpu, GpuError, Recorder};

/// What rows by branches need beside the rows.
pub(super) struct Branches {
    /// Three vectors a row, see `shaders/constraint/stage.wgsl`.
    staged: Buffer,
    /// By row: the branch, and [`FIRST_ROW`]; and a spare.
    pub features: [Buffer; 2],
    /// By staged contact, see `shaders/constraint/match.wgsl`.
    partners: Buffer,
    /// By pair and branch: what the first half of a step ended with.
    middle: Buffer,
}

impl Branches {
    /// Those of a scene; none where it has the paper's rows.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Option<Self>, GpuError> {
        if setup.branches == 0 {
            return Ok(None);
        }
        let features = || Buffer::new(gpu, "branches of rows", 4, 0);
        Ok(Some(Branches {
            staged: Buffer::new(gpu, "staged contacts", 12 * setup.precision.bytes(), 0)?,
            features: [features()?, features()?],
            partners: Buffer::new(gpu, "rows to tighten", 4, 0)?,
            middle: remembered(gpu, setup)?,
        }))
    }

    /// Moves what rows have of branches to the rows' new places.
    pub fn move_all(
        &mut self,
        gpu: &Gpu,
        kernels: &BranchKernels,
        record: &mut Recorder<'_>,
        targets: &Buffer,
        [old_rows, rows]: [u64; 2],
    ) -> Result<(), GpuError> {
        let [from, to] = &mut self.features;
        to.reserve(gpu, rows)?;
        record.run(
            &kernels.move_words,
            &words([old_rows as u32, 0, 0, 0]),
            &[("targets", targets), ("source", from), ("moved", to)],
            old_rows,
        );
        std::mem::swap(from, to);
        Ok(())
    }

    /// The branch of each row, for tests.
    pub fn read(&self, gpu: &Gpu, rows: u64) -> Result<Vec<u32>, GpuError> {
        let read = gpu.record().read(&[(&self.features[0], 0..4 * rows)])?;
        let features: Vec<u32> = bytemuck::pod_collect_to_vec(&read[0]);
        Ok(features.into_iter().map(|feature| feature & !FIRST_ROW).collect())
    }

    fn stage(&self, kernels: &BranchKernels, record: &mut Recorder<'_>, made: RowInputs<'_>, row_start: &Buffer) {
        let RowInputs { stages, lists, poses, shapes, .. } = made;
        let buffers = [
            ("pairs", &lists.pairs),
            ("cells", &poses.cells),
            ("remainders", &poses.remainders),
            ("orientations", &poses.orientations),
            ("shapes", &shapes.shapes),
            ("contacts", &lists.contacts),
            ("row_start", row_start),
            ("staged", &self.staged),
        ];
        let parameters = stages.start.of_pairs(stages.setup, &words([lists.pairs_count as u32, 0, 0, 0]));
        record.run(&kernels.stage, &parameters, &buffers, lists.pairs_count);
    }

    fn aim(&self, kernels: &BranchKernels, record: &mut Recorder<'_>, made: RowInputs<'_>, row_start: &Buffer) {
        let (Some(aim), true) = (&kernels.aim, made.ahead) else { return };
        let RowInputs { stages, lists, shapes, .. } = made;
        let last = stages.states.start();
        let buffers = [
            ("pairs", &lists.pairs),
            ("cells", &last.cells),
            ("remainders", &last.remainders),
            ("orientations", &last.orientations),
            ("twists", &last.twists),
            ("shapes", &shapes.shapes),
            ("row_start", row_start),
            ("staged", &self.staged),
        ];
        let parameters = stages.timed([lists.pairs_count as u32, 0, 0, 0]);
        record.run(aim, &stages.start.of_pairs(stages.setup, &parameters), &buffers, lists.pairs_count);
    }

    fn stretch(&self, kernels: &BranchKernels, record: &mut Recorder<'_>, made: RowInputs<'_>, row_start: &Buffer) {
        let (Some(stretch), Part::FromMiddle) = (&kernels.stretch, made.part()) else { return };
        let RowInputs { stages, lists, poses, shapes, .. } = made;
        let buffers = [
            ("pairs", &lists.pairs),
            ("orientations", &poses.orientations),
            ("shapes", &shapes.shapes),
            ("grown", &stages.states.end_shapes().shapes),
            ("row_start", row_start),
            ("staged", &self.staged),
        ];
        record.run(stretch, &words([lists.pairs_count as u32, 0, 0, 0]), &buffers, lists.pairs_count);
    }
}

/// A buffer of what pairs remember of their branches.
pub(super) fn remembered(gpu: &Gpu, setup: &Setup) -> Result<Buffer, GpuError> {
    Buffer::new(gpu, "multipliers of branches", setup.branches.max(1) as usize * setup.precision.bytes(), 0)
}

impl RowSet {
    /// Chooses the branches of all pairs that get a row next: of near pairs where first rows are made, or of violating
    /// ones at the trial.
    pub fn choose_branches(
        &mut self,
        record: &mut Recorder<'_>,
        made: RowInputs<'_>,
        violating: Option<f64>,
    ) -> Result<(), GpuError> {
        let RowInputs { stages, lists, poses, shapes, .. } = made;
        let Stages { gpu, setup, kernels, states, start } = stages;
        let (Some(own), Some(of_branches)) = (&mut self.branches, &kernels.branches) else { return Ok(()) };
        let mut from = &lists.remembered;
        if made.part() == Part::FromMiddle && violating.is_none() {
            own.middle.reserve(gpu, lists.pairs_count)?;
            let problem = &self.problem;
            let buffers = [
                ("row_start", &problem.block_start),
                ("gamma", &problem.gamma),
                ("features", &own.features[0]),
                ("remembered", &own.middle),
                ("contacts", &lists.contacts),
            ];
            record.run(&kernels.remember, &words([lists.pairs_count as u32, 0, 0, 0]), &buffers, lists.pairs_count);
            from = &own.middle;
        }
        let bits = (violating.unwrap_or(0.0) as f32).to_bits();
        let of_kernel = [lists.pairs_count as u32, u32::from(violating.is_some()), bits, 0];
        let buffers = [
            ("pairs", &lists.pairs),
            ("cells", &poses.cells),
            ("remainders", &poses.remainders),
            ("orientations", &poses.orientations),
            ("shapes", &shapes.shapes),
            ("twists", &states.start().twists),
            ("remembered", from),
            ("contacts", &lists.contacts),
        ];
        let parameters = stages.timed(of_kernel);
        record.run(&of_branches.choose, &start.of_pairs(setup, &parameters), &buffers, lists.pairs_count);
        Ok(())
    }

    /// Makes the rows of all chosen branches, for which the rows' starts have room: `first` ones, or those of
    /// violations.
    pub(super) fn append_branches(
        &mut self,
        record: &mut Recorder<'_>,
        made: RowInputs<'_>,
        first: bool,
    ) -> Result<(), GpuError> {
        let (problem, RowInputs { stages, lists, motions, .. }) = (&self.problem, made);
        let Stages { gpu, kernels, .. } = stages;
        let (Some(own), Some(of_branches)) = (&mut self.branches, &kernels.branches) else { return Ok(()) };
        own.staged.reserve(gpu, problem.rows)?;
        own.features[0].reserve(gpu, problem.rows)?;
        own.stage(of_branches, record, made, &problem.block_start);
        if first {
            own.stretch(of_branches, record, made, &problem.block_start);
            own.aim(of_branches, record, made, &problem.block_start);
        }
        let (pairs, bodies, first) = (lists.pairs_count, lists.bodies as u32, u32::from(first));
        let buffers = [
            ("pairs", &lists.pairs),
            ("row_start", &problem.block_start),
            ("staged", &own.staged),
            ("motions", motions),
            ("row_pairs", &problem.pair),
            ("jacobian", &problem.jacobian),
            ("q", &problem.q),
            ("features", &own.features[0]),
        ];
        let parameters = stages.timed([pairs as u32, first, bodies, 0]);
        record.run(&kernels.append, &parameters, &buffers, pairs);
        let from = if made.part() == Part::FromMiddle { &own.middle } else { &lists.remembered };
        let buffers = [
            ("row_start", &problem.block_start),
            ("staged", &own.staged),
            ("remembered", from),
            ("gamma", &problem.gamma),
        ];
        record.run(&of_branches.start, &words([pairs as u32, first, 0, 0]), &buffers, pairs);
        Ok(())
    }

    /// Moves the offsets of first rows to the violations of their branches, of which there are then fewer.
    pub(super) fn tighten_branches(&mut self, record: &mut Recorder<'_>, made: RowInputs<'_>) -> Result<(), GpuError> {
        let (problem, RowInputs { stages, lists, motions, .. }) = (&self.problem, made);
        let Stages { gpu, kernels, start, .. } = stages;
        let (Some(own), Some(kernels)) = (&mut self.branches, &kernels.branches) else { return Ok(()) };
        // One for each violation, beside those there are.
        let rows = self.next;
        own.staged.reserve(gpu, rows)?;
        own.partners.reserve(gpu, rows)?;
        own.stage(kernels, record, made, &self.next_start);
        let of_pairs = words([lists.pairs_count as u32, 0, 0, 0]);
        let buffers = [
            ("row_start", &problem.block_start),
            ("next_start", &self.next_start),
            ("features", &own.features[0]),
            ("staged", &own.staged),
            ("partners", &own.partners),
        ];
        record.run(&kernels.matched, &of_pairs, &buffers, lists.pairs_count);
        let buffers = [
            ("staged", &own.staged),
            ("row_pairs", &problem.pair),
            ("jacobian", &problem.jacobian),
            ("velocities", &problem.velocity),
            ("motions", motions),
            ("q", &problem.q),
            ("partners", &own.partners),
        ];
        let parameters = stages.timed([rows as u32, start.bodies as u32, 0, 0]);
        record.run(&kernels.tighten, &parameters, &buffers, rows);
        let buffers = [
            ("next_start", &self.next_start),
            ("staged", &own.staged),
            ("partners", &own.partners),
            ("contacts", &lists.contacts),
        ];
        record.run(&kernels.tightened, &of_pairs, &buffers, lists.pairs_count);
        Ok(())
    }

    /// Records what the next step starts from.
    pub fn remember(&self, kernels: &Kernels, record: &mut Recorder<'_>, lists: &Lists) {
        let problem = &self.problem;
        let parameters = words([lists.pairs_count as u32, 1, 0, 0]);
        match &self.branches {
            Some(own) => {
                let buffers = [
                    ("row_start", &problem.block_start),
                    ("gamma", &problem.gamma),
                    ("features", &own.features[0]),
                    ("remembered", &lists.remembered),
                    ("contacts", &lists.contacts),
                ];
                record.run(&kernels.remember, &parameters, &buffers, lists.pairs_count);
            }
            None => {
                let buffers =
                    [("row_start", &problem.block_start), ("gamma", &problem.gamma), ("contacts", &lists.contacts)];
                record.run(&kernels.remember, &parameters, &buffers, lists.pairs_count);
            }
        }
    }
}
