//! Rows by branches on the device: each smooth branch of a pair's separation that may become active has its own row.
//!
//! A pair has one entry in the list of pairs. A mask in the entry marks the branches that get a row next. Their
//! contacts are staged at the indices of the future rows, and the rows are made from them. Each row stores the index of
//! its branch, which is the key of its stored multiplier.

use super::Setup;
use super::branch_source::{self, FIRST_ROW, geometry, plain};
use super::lists::{Lists, remembered};
use super::part::Part;
use super::row_inputs::RowInputs;
use super::row_set::{Move, MoveArgs, RememberArgs, RowSet};
use super::source::{changing, moved, numbers, stretched, with_direction, with_parts};
use super::start::Stages;
use super::states::{Poses, Shapes};
use crate::constraint::LEAST_ALIGNED;
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, arrays, fragment, functions, kernels};
use crate::lcp::gpu::DeviceProblem;
use crate::separation::branches::gpu::Branched;
use crate::step::Surplus;

pub(super) use branch_source::carry_branches;

functions! {
    pub(super) Choose = struct ChooseArgs<'a> {
        at_trial: bool, violating: f32, made: RowInputs<'a>, start: &'a Poses, remembered: &'a Buffer,
    }
    pub(super) Stage = struct StageArgs<'a> { made: RowInputs<'a>, row_start: &'a Buffer, own: &'a Branches }
    pub(super) Aim = struct AimArgs<'a> {
        start: &'a Poses, made: RowInputs<'a>, row_start: &'a Buffer, own: &'a Branches,
    }
    pub(super) StretchBranches = struct StretchBranchesArgs<'a> {
        made: RowInputs<'a>, grown: &'a Shapes, row_start: &'a Buffer, own: &'a Branches,
    }
    pub(super) CountBranches = struct CountBranchesArgs<'a> {
        has_rows: bool, made: RowInputs<'a>, problem: &'a DeviceProblem, counts: &'a Buffer,
    }
    pub(super) AppendBranches = struct AppendBranchesArgs<'a> {
        first: bool, surplus_part: f64, surplus_most: f64, made: RowInputs<'a>, problem: &'a DeviceProblem, own: &'a Branches,
    }
    pub(super) StartBranches = struct StartBranchesArgs<'a> {
        first: bool, made: RowInputs<'a>, problem: &'a DeviceProblem, own: &'a Branches, remembered: &'a Buffer,
    }
    pub(super) CarryBranches = struct CarryBranchesArgs<'a> {
        lists: &'a Lists, old: &'a Lists, old_pair: &'a Buffer,
    }
    pub(super) Match = struct MatchArgs<'a> {
        made: RowInputs<'a>, problem: &'a DeviceProblem, next_start: &'a Buffer, own: &'a Branches,
    }
    pub(super) TightenBranches = struct TightenBranchesArgs<'a> {
        places: u64, made: RowInputs<'a>, problem: &'a DeviceProblem, own: &'a Branches,
    }
    pub(super) Tightened = struct TightenedArgs<'a> {
        made: RowInputs<'a>, next_start: &'a Buffer, own: &'a Branches,
    }
    pub(super) RememberBranches = struct RememberBranchesArgs<'a> {
        accepted: bool, lists: &'a Lists, problem: &'a DeviceProblem, own: &'a Branches, remembered: &'a Buffer,
    }
}

kernels! {
    /// The kernels of a scene whose rows are by branches.
    pub(super) struct BranchKernels for setup: &Setup {
        choose: Choose = branch_source::choose(setup),
        count: CountBranches = plain(setup, "count").include(fragment!("constraint/count_branches.wgsl")),
        append: AppendBranches = with_parts(setup, numbers(plain(setup, "append")))
            .include(fragment!("constraint/row.wgsl"))
            .include(fragment!("constraint/surplus.wgsl"))
            .include(fragment!("constraint/append_branches.wgsl")),
        remember: RememberBranches = with_direction(plain(setup, "remember"))
            .include(fragment!("constraint/remember_branches.wgsl")),
        stage: Stage = changing(setup, geometry(setup, "stage").include(fragment!("constraint/stage.wgsl"))),
        start: StartBranches = plain(setup, "start").include(fragment!("constraint/start_branches.wgsl")),
        matched: Match = plain(setup, "match").include(fragment!("constraint/match.wgsl")),
        tighten: TightenBranches = with_parts(setup, plain(setup, "tighten").real("LEAST_ALIGNED", LEAST_ALIGNED))
            .include(fragment!("constraint/share.wgsl"))
            .include(fragment!("constraint/tighten_branches.wgsl")),
        tightened: Tightened = plain(setup, "tightened").include(fragment!("constraint/tightened.wgsl")),
        move_words: Move = moved(setup, "move words", "u32", 1),
        /// Only if first rows are made at positions extrapolated with the last velocities, and if the separation of
        /// some branches follows from their number.
        aim: Option<Aim> = (setup.leads_ahead() && Branched::of(&setup.shapes).has_ends()).then(|| branch_source::aim(setup)),
        /// Updates staged contacts to later lengths, in scenes with growth and midpoint steps.
        stretch: Option<StretchBranches> = (setup.midpoint && setup.growth.is_some())
            .then(|| stretched(setup).include(fragment!("dynamics/stretch_branches.wgsl"))),
    }
}

/// The data of rows by branches, in addition to the rows.
pub(super) struct Branches {
    /// Three vectors per row, see `shaders/constraint/stage.wgsl`.
    staged: Buffer,
    /// The branch of each row, with [`FIRST_ROW`]; and a spare buffer.
    features: Buffer,
    spare_features: Buffer,
    /// One word per staged contact, see `shaders/constraint/match.wgsl`.
    partners: Buffer,
    /// For each pair and branch, the multiplier at the end of the first half of a step.
    middle: Buffer,
    pub kernels: BranchKernels,
}

arrays! { Branches { staged, features, partners } }

impl Branches {
    /// The buffers for a scene; `None` if it has the paper's rows.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Option<Self>, GpuError> {
        if setup.branches == 0 {
            return Ok(None);
        }
        let features = || Buffer::new(gpu, "branches of rows", 4, 0);
        Ok(Some(Branches {
            staged: Buffer::new(gpu, "staged contacts", 12 * setup.precision.bytes(), 0)?,
            features: features()?,
            spare_features: features()?,
            partners: Buffer::new(gpu, "rows to tighten", 4, 0)?,
            middle: remembered(gpu, setup)?,
            kernels: BranchKernels::make(gpu, setup)?,
        }))
    }

    /// Moves the branch data of rows to the rows' new indices.
    pub fn move_all(
        &mut self,
        gpu: &Gpu,
        record: &mut Recorder<'_>,
        targets: &Buffer,
        [old_rows, rows]: [u64; 2],
    ) -> Result<(), GpuError> {
        let (from, to) = (&mut self.features, &mut self.spare_features);
        to.reserve(gpu, rows)?;
        self.kernels.move_words.call(record, old_rows, MoveArgs { rows: old_rows, targets, source: from, moved: to });
        std::mem::swap(from, to);
        Ok(())
    }

    /// The contacts of the rows made last.
    pub fn staged(&self) -> &Buffer {
        &self.staged
    }

    /// The branch of each row, for tests.
    pub fn read(&self, gpu: &Gpu, rows: u64) -> Result<Vec<u32>, GpuError> {
        let read = gpu.record().read(&[(&self.features, 0..4 * rows)])?;
        let features: Vec<u32> = bytemuck::pod_collect_to_vec(&read[0]);
        Ok(features.into_iter().map(|feature| feature & !FIRST_ROW).collect())
    }

    fn stage(&self, record: &mut Recorder<'_>, made: RowInputs<'_>, row_start: &Buffer) {
        self.kernels.stage.call(record, made.pairs(), StageArgs { made, row_start, own: self });
    }

    fn aim(&self, record: &mut Recorder<'_>, made: RowInputs<'_>, row_start: &Buffer) {
        let (Some(aim), true) = (&self.kernels.aim, made.ahead) else { return };
        let start = made.stages.states.start();
        aim.call(record, made.pairs(), AimArgs { start, made, row_start, own: self });
    }

    fn stretch(&self, record: &mut Recorder<'_>, made: RowInputs<'_>, row_start: &Buffer) {
        let (Some(stretch), Part::FromMiddle) = (&self.kernels.stretch, made.part()) else { return };
        let grown = made.stages.states.end_shapes();
        stretch.call(record, made.pairs(), StretchBranchesArgs { made, grown, row_start, own: self });
    }
}

impl RowSet {
    /// Chooses the branches of all pairs that get a row next: branches of near pairs for first rows, or of violating
    /// pairs at the trial.
    pub fn choose_branches(
        &mut self,
        record: &mut Recorder<'_>,
        made: RowInputs<'_>,
        violating: Option<f64>,
    ) -> Result<(), GpuError> {
        let RowInputs { stages: Stages { gpu, states, .. }, lists, .. } = made;
        let Some(own) = &mut self.branches else { return Ok(()) };
        let mut remembered = &lists.remembered;
        if made.part() == Part::FromMiddle && violating.is_none() {
            own.middle.reserve(gpu, made.pairs())?;
            let own = &*own;
            remembered = &own.middle;
            let kept = RememberBranchesArgs { accepted: false, lists, problem: &self.problem, own, remembered };
            own.kernels.remember.call(record, made.pairs(), kept);
        }
        let (at_trial, violating, start) = (violating.is_some(), violating.unwrap_or(0.0) as f32, states.start());
        let chosen = ChooseArgs { at_trial, violating, made, start, remembered };
        own.kernels.choose.call(record, made.pairs(), chosen);
        Ok(())
    }

    /// Makes the rows of all chosen branches: `first` rows, or rows of violations with a surplus. The starts of the
    /// pairs' rows already include them.
    pub(super) fn append_branches(
        &mut self,
        record: &mut Recorder<'_>,
        made: RowInputs<'_>,
        (first, surplus): (bool, Surplus),
    ) -> Result<(), GpuError> {
        let (problem, gpu) = (&self.problem, made.stages.gpu);
        let Some(own) = &mut self.branches else { return Ok(()) };
        own.staged.reserve(gpu, problem.rows)?;
        own.features.reserve(gpu, problem.rows)?;
        let own = &*own;
        own.stage(record, made, &problem.block_start);
        if first {
            own.stretch(record, made, &problem.block_start);
            own.aim(record, made, &problem.block_start);
        }
        let Surplus { part: surplus_part, most: surplus_most } = surplus;
        let appended = AppendBranchesArgs { first, surplus_part, surplus_most, made, problem, own };
        own.kernels.append.call(record, made.pairs(), appended);
        let remembered = if made.part() == Part::FromMiddle { &own.middle } else { &made.lists.remembered };
        own.kernels.start.call(record, made.pairs(), StartBranchesArgs { first, made, problem, own, remembered });
        Ok(())
    }

    /// Moves the offsets of first rows to the violations of their branches, which reduces the number of violations.
    pub(super) fn tighten_branches(&mut self, record: &mut Recorder<'_>, made: RowInputs<'_>) -> Result<(), GpuError> {
        let (problem, gpu) = (&self.problem, made.stages.gpu);
        let Some(own) = &mut self.branches else { return Ok(()) };
        // One row for each violation, after the existing ones.
        let rows = self.next;
        own.staged.reserve(gpu, rows)?;
        own.partners.reserve(gpu, rows)?;
        let own = &*own;
        own.stage(record, made, &self.next_start);
        let (pairs, next_start) = (made.pairs(), &self.next_start);
        own.kernels.matched.call(record, pairs, MatchArgs { made, problem, next_start, own });
        own.kernels.tighten.call(record, rows, TightenBranchesArgs { places: rows, made, problem, own });
        own.kernels.tightened.call(record, pairs, TightenedArgs { made, next_start, own });
        Ok(())
    }

    /// Records the warm start of the next step.
    pub fn remember(&self, record: &mut Recorder<'_>, lists: &Lists) {
        let (problem, pairs) = (&self.problem, lists.pairs_count);
        if let Some(own) = &self.branches {
            let remembered = &lists.remembered;
            let kept = RememberBranchesArgs { accepted: true, lists, problem, own, remembered };
            own.kernels.remember.call(record, pairs, kept);
        }
        if let Some(kernels) = &self.kernels.paper {
            kernels.remember.call(record, pairs, RememberArgs { lists, problem });
        }
    }
}
