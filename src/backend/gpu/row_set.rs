//! The rows of a step on the device. They are sorted by pair, and within a pair by the order in which they were made.
//! When pairs get more rows, all rows move to their new indices and do not change otherwise.

use super::Setup;
use super::branches::{Branches, CountBranchesArgs};
use super::lists::Lists;
use super::part::Part;
use super::row_inputs::{RowInputs, Stretch};
use super::source::{NEAR, VIOLATING, base, moved, numbers, stretched, with_direction, with_flags, with_parts};
use super::start::Stages;
use crate::constraint::LEAST_ALIGNED;
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, Scan, fragment, functions, kernels};
use crate::lcp::gpu::DeviceProblem;
use crate::step::Surplus;
use bytemuck::pod_read_unaligned;

functions! {
    pub(super) Count = struct CountArgs<'a> {
        has_rows: bool, threshold: u32, made: RowInputs<'a>, problem: &'a DeviceProblem, counts: &'a Buffer,
    }
    pub(super) Append = struct AppendArgs<'a> {
        threshold: u32, warm: bool, surplus_part: f64, surplus_most: f64, made: RowInputs<'a>, problem: &'a DeviceProblem,
    }
    pub(super) Remember = struct RememberArgs<'a> { lists: &'a Lists, problem: &'a DeviceProblem }
    pub(super) Recall = struct RecallArgs<'a> {
        made: RowInputs<'a>, old_start: &'a Buffer, old_gamma: &'a Buffer, problem: &'a DeviceProblem,
        is_first: &'a Buffer,
    }
    pub(super) Tighten = struct TightenArgs<'a> {
        made: RowInputs<'a>, problem: &'a DeviceProblem, is_first: &'a Buffer,
    }
    pub(super) Target = struct TargetArgs<'a> {
        pairs: u64, mapped: bool, old_start: &'a Buffer, new_start: &'a Buffer, old_pair: &'a Buffer,
        targets: &'a Buffer,
    }
    pub(super) Move = struct MoveArgs<'a> { rows: u64, targets: &'a Buffer, source: &'a Buffer, moved: &'a Buffer }
    pub(super) IncidenceCount = struct IncidenceCountArgs<'a> {
        made: RowInputs<'a>, problem: &'a DeviceProblem, counts: &'a Buffer,
    }
    pub(super) IncidenceFill = struct IncidenceFillArgs<'a> { made: RowInputs<'a>, problem: &'a DeviceProblem }
}

kernels! {
    /// The kernels of rows.
    pub(super) struct RowKernels for setup: &Setup {
        target: Target = base(setup, "target").include(fragment!("constraint/target.wgsl")),
        move_pairs: Move = moved(setup, "move pairs", "vec2<u32>", 1),
        move_blocks: Move = moved(setup, "move blocks", "vec4r", if setup.planar { 2 } else { 4 }),
        move_reals: Move = moved(setup, "move numbers", "real", 1),
        incidence_count: IncidenceCount =
            base(setup, "incidence count").include(fragment!("constraint/incidence_count.wgsl")),
        incidence_fill: IncidenceFill =
            base(setup, "incidence fill").include(fragment!("constraint/incidence_fill.wgsl")),
        /// With the paper's rows.
        paper: Option<PaperKernels> = (setup.branches == 0).then_some(setup),
        /// With the paper's rows and midpoint steps.
        middle: Option<MiddleRowKernels> = setup.makes_rows_again().then_some(setup),
        /// The separations at later lengths, in such scenes with growth.
        stretch: Option<Stretch> = (setup.makes_rows_again() && setup.growth.is_some())
            .then(|| stretched(setup).include(fragment!("dynamics/stretch.wgsl"))),
    }
}

kernels! {
    /// The kernels of the paper's rows.
    pub(super) struct PaperKernels for setup: &Setup {
        count: Count = base(setup, "count").include(fragment!("constraint/count.wgsl")),
        append: Append = with_parts(setup, numbers(base(setup, "append")))
            .include(fragment!("constraint/row.wgsl"))
            .include(fragment!("constraint/surplus.wgsl"))
            .include(fragment!("constraint/append.wgsl")),
        remember: Remember =
            with_direction(base(setup, "remember")).include(fragment!("constraint/remember.wgsl")),
    }
}

kernels! {
    /// The kernels of the paper's rows in the middle of a step.
    pub(super) struct MiddleRowKernels for setup: &Setup {
        /// The starting multipliers of these rows.
        recall: Recall = base(setup, "recall").include(fragment!("constraint/recall.wgsl")),
        tighten: Tighten = with_parts(setup, with_flags(base(setup, "tighten")).real("LEAST_ALIGNED", LEAST_ALIGNED))
            .include(fragment!("constraint/share.wgsl"))
            .include(fragment!("constraint/tighten.wgsl")),
    }
}

impl Setup {
    /// Whether the rows of the paper are made again in the middle of a step.
    pub(super) fn makes_rows_again(&self) -> bool {
        self.midpoint && self.branches == 0
    }
}

/// The rows, and the buffers for moving them.
pub(super) struct RowSet {
    pub problem: DeviceProblem,
    spare_pair: Buffer,
    spare_jacobian: Buffer,
    spare_q: Buffer,
    spare_gamma: Buffer,
    /// Only with rows by branches.
    pub branches: Option<Branches>,
    /// With the paper's rows and midpoint steps: one for each row that was made in the middle from a near pair, zero
    /// for the others; and a spare buffer.
    is_first: Option<[Buffer; 2]>,
    /// The next start of each pair's rows, and their total number.
    pub next_start: Buffer,
    pub next: u64,
    pub counts: Buffer,
    targets: Buffer,
    body_counts: Buffer,
    scan: Scan,
    pub kernels: RowKernels,
}

impl RowSet {
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Self, GpuError> {
        let real = setup.precision.bytes();
        let blocks = if setup.planar { 8 } else { 16 };
        let vectors = if setup.planar { 1 } else { 2 };
        let is_first = || Buffer::new(gpu, "first rows", real, 0);
        Ok(RowSet {
            problem: DeviceProblem {
                bodies: 0,
                rows: 0,
                pairs: 0,
                planar: setup.planar,
                pair: Buffer::new(gpu, "row bodies", 8, 0)?,
                jacobian: Buffer::new(gpu, "jacobian", blocks * real, 0)?,
                q: Buffer::new(gpu, "q", real, 0)?,
                block_start: Buffer::new(gpu, "row starts", 4, 1)?,
                incidence_start: Buffer::new(gpu, "incidence starts", 4, 1)?,
                incidence: Buffer::new(gpu, "incidence", 4, 0)?,
                gamma: Buffer::new(gpu, "gamma", real, 0)?,
                velocity: Buffer::new(gpu, "contact velocity", 4 * vectors * real, 0)?,
            },
            spare_pair: Buffer::new(gpu, "row bodies", 8, 0)?,
            spare_jacobian: Buffer::new(gpu, "jacobian", blocks * real, 0)?,
            spare_q: Buffer::new(gpu, "q", real, 0)?,
            spare_gamma: Buffer::new(gpu, "gamma", real, 0)?,
            branches: Branches::new(gpu, setup)?,
            is_first: if setup.makes_rows_again() { Some([is_first()?, is_first()?]) } else { None },
            next_start: Buffer::new(gpu, "row starts", 4, 1)?,
            next: 0,
            counts: Buffer::new(gpu, "row counts", 4, 0)?,
            targets: Buffer::new(gpu, "row targets", 4, 0)?,
            body_counts: Buffer::new(gpu, "incidence counts", 4, 0)?,
            scan: Scan::new(gpu)?,
            kernels: RowKernels::make(gpu, setup)?,
        })
    }

    /// Counts the rows of pairs: the existing ones, and one more for each flag of at least `threshold`, or for each
    /// chosen branch.
    pub fn count(
        &mut self,
        record: &mut Recorder<'_>,
        made: RowInputs<'_>,
        (has_rows, threshold): (bool, u32),
    ) -> Result<(), GpuError> {
        let (gpu, pairs) = (made.stages.gpu, made.pairs());
        self.counts.reserve(gpu, pairs)?;
        self.next_start.reserve(gpu, pairs + 1)?;
        let (problem, counts) = (&self.problem, &self.counts);
        if let Some(branches) = &self.branches {
            branches.kernels.count.call(record, pairs, CountBranchesArgs { has_rows, made, problem, counts });
        }
        if let Some(kernels) = &self.kernels.paper {
            kernels.count.call(record, pairs, CountArgs { has_rows, threshold, made, problem, counts });
        }
        self.scan.exclusive(record, &self.counts, &self.next_start, pairs)
    }

    /// Makes the first rows of a part of the step, which [`RowSet::count`] has counted.
    pub fn begin(&mut self, record: &mut Recorder<'_>, made: RowInputs<'_>) -> Result<(), GpuError> {
        if let Some(stretch) = &self.kernels.stretch {
            made.record_stretch(stretch, record);
        }
        // Rows by branches have already read the multipliers of the first half.
        match made.part() == Part::FromMiddle && self.kernels.middle.is_some() {
            true => self.begin_again(record, made),
            false => self.make_first(record, made),
        }
    }

    fn make_first(&mut self, record: &mut Recorder<'_>, made: RowInputs<'_>) -> Result<(), GpuError> {
        let (gpu, rows, problem) = (made.stages.gpu, self.next, &mut self.problem);
        for of_rows in [&mut problem.pair, &mut problem.jacobian, &mut problem.q, &mut problem.gamma] {
            of_rows.reserve(gpu, rows)?;
        }
        self.take_starts(made.pairs(), rows);
        if self.branches.is_some() {
            return self.append_branches(record, made, (true, Surplus::NONE));
        }
        self.append(record, made, (NEAR, true), Surplus::NONE);
        Ok(())
    }

    /// Replaces the rows of the first half by the first rows of the whole step, which start from their multipliers.
    fn begin_again(&mut self, record: &mut Recorder<'_>, made: RowInputs<'_>) -> Result<(), GpuError> {
        std::mem::swap(&mut self.problem.gamma, &mut self.spare_gamma);
        self.make_first(record, made)?;
        let (Some([is_first, _]), Some(kernels)) = (&mut self.is_first, &self.kernels.middle) else { return Ok(()) };
        is_first.reserve(made.stages.gpu, self.next)?;
        // The starts and multipliers of the old rows are now in the spare buffers.
        let (old_start, old_gamma, problem) = (&self.next_start, &self.spare_gamma, &self.problem);
        kernels.recall.call(record, made.pairs(), RecallArgs { made, old_start, old_gamma, problem, is_first });
        Ok(())
    }

    /// Moves the offsets of rows to the violations of the trial, and counts the rows of violations without a row to
    /// move.
    pub fn tighten(&mut self, record: &mut Recorder<'_>, made: RowInputs<'_>) -> Result<(), GpuError> {
        self.tighten_branches(record, made)?;
        self.tighten_pairs(record, made);
        self.count(record, made, (true, VIOLATING))?;
        let total = 4 * made.pairs();
        let read = record.read(&[(&self.next_start, total..total + 4)])?;
        self.next = u64::from(pod_read_unaligned::<u32>(&read[0]));
        Ok(())
    }

    /// The same for the paper's rows in the middle of a step: their pairs are no longer violations.
    fn tighten_pairs(&self, record: &mut Recorder<'_>, made: RowInputs<'_>) {
        let (Some([is_first, _]), Some(kernels)) = (&self.is_first, &self.kernels.middle) else { return };
        kernels.tighten.call(record, made.pairs(), TightenArgs { made, problem: &self.problem, is_first });
    }

    /// Makes one more row for every violating pair, which [`RowSet::count`] has counted, with a surplus.
    pub fn extend(&mut self, record: &mut Recorder<'_>, made: RowInputs<'_>, surplus: Surplus) -> Result<(), GpuError> {
        // Rows keep their pairs, so no map from old pairs to new ones is needed.
        self.move_all(made.stages.gpu, record, (made.pairs(), None), self.next)?;
        if self.branches.is_some() {
            return self.append_branches(record, made, (false, surplus));
        }
        self.append(record, made, (VIOLATING, false), surplus);
        Ok(())
    }

    /// Moves all rows whose pair is in a new list of pairs to that list: `old_pair` has the index of each pair in the
    /// old list, and `counts` its number of rows.
    pub fn carry(
        &mut self,
        gpu: &Gpu,
        record: &mut Recorder<'_>,
        pairs: u64,
        old_pair: &Buffer,
    ) -> Result<(), GpuError> {
        self.next_start.reserve(gpu, pairs + 1)?;
        self.scan.exclusive(record, &self.counts, &self.next_start, pairs)?;
        let rows = self.problem.rows;
        self.move_all(gpu, record, (pairs, Some(old_pair)), rows)
    }

    /// Records the list of rows of each body.
    pub fn incidence(&mut self, record: &mut Recorder<'_>, made: RowInputs<'_>) -> Result<(), GpuError> {
        let Stages { gpu, start, .. } = made.stages;
        let bodies = start.bodies;
        let problem = &mut self.problem;
        problem.bodies = bodies;
        self.body_counts.reserve(gpu, bodies)?;
        problem.incidence_start.reserve(gpu, bodies + 1)?;
        problem.incidence.reserve(gpu, 2 * problem.rows)?;
        problem.velocity.reserve(gpu, bodies)?;
        let (problem, counts) = (&*problem, &self.body_counts);
        self.kernels.incidence_count.call(record, bodies, IncidenceCountArgs { made, problem, counts });
        self.scan.exclusive(record, counts, &problem.incidence_start, bodies)?;
        self.kernels.incidence_fill.call(record, bodies, IncidenceFillArgs { made, problem });
        Ok(())
    }

    fn append(&self, record: &mut Recorder<'_>, made: RowInputs<'_>, (threshold, warm): (u32, bool), surplus: Surplus) {
        let Some(kernels) = &self.kernels.paper else { return };
        let Surplus { part: surplus_part, most: surplus_most } = surplus;
        let appended = AppendArgs { threshold, warm, surplus_part, surplus_most, made, problem: &self.problem };
        kernels.append.call(record, made.pairs(), appended);
    }

    fn move_all(
        &mut self,
        gpu: &Gpu,
        record: &mut Recorder<'_>,
        (pairs, old_pair): (u64, Option<&Buffer>),
        rows: u64,
    ) -> Result<(), GpuError> {
        let old_rows = self.problem.rows;
        self.targets.reserve(gpu, old_rows)?;
        let (problem, kernels) = (&mut self.problem, &self.kernels);
        if old_pair.is_some() {
            // In the middle of a step, pairs with rows may be far apart and no longer in the list.
            record.clear(&self.targets, 0..4 * old_rows);
        }
        let (targets, mapped) = (&self.targets, old_pair.is_some());
        // Without a map the kernel does not read this buffer.
        let old_pair = old_pair.unwrap_or(&self.counts);
        let (old_start, new_start) = (&problem.block_start, &self.next_start);
        kernels.target.call(record, pairs, TargetArgs { pairs, mapped, old_start, new_start, old_pair, targets });
        let moves = [
            (&kernels.move_pairs, &mut problem.pair, &mut self.spare_pair),
            (&kernels.move_blocks, &mut problem.jacobian, &mut self.spare_jacobian),
            (&kernels.move_reals, &mut problem.q, &mut self.spare_q),
            (&kernels.move_reals, &mut problem.gamma, &mut self.spare_gamma),
        ];
        for (kernel, from, to) in moves {
            to.reserve(gpu, rows)?;
            kernel.call(record, old_rows, MoveArgs { rows: old_rows, targets, source: from, moved: to });
            std::mem::swap(from, to);
        }
        if let Some([from, to]) = &mut self.is_first {
            // New rows are not marked as first rows.
            from.reserve_and_keep(gpu, record, old_rows)?;
            to.reserve(gpu, rows)?;
            record.clear(to, 0..rows * to.element() as u64);
            kernels.move_reals.call(record, old_rows, MoveArgs { rows: old_rows, targets, source: from, moved: to });
            std::mem::swap(from, to);
        }
        if let Some(branches) = &mut self.branches {
            branches.move_all(gpu, record, targets, [old_rows, rows])?;
        }
        self.take_starts(pairs, rows);
        Ok(())
    }

    fn take_starts(&mut self, pairs: u64, rows: u64) {
        std::mem::swap(&mut self.problem.block_start, &mut self.next_start);
        self.problem.pairs = pairs;
        self.problem.rows = rows;
    }
}
