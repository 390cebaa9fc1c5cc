//! The rows of a step on the device. They stand sorted by pair, in the order in which they were made within a pair;
//! when pairs get more rows, all rows move to their new places and are changed in no other way.

use super::branches::Branches;
use super::candidates::Lists;
use super::midpoint::Part;
use super::source::{Kernels, MidpointKernels, NEAR, VIOLATING};
use super::states::{Poses, Shapes};
use super::{Setup, words};
use crate::gpu::{Buffer, Gpu, GpuError, Recorder, Scan};
use crate::lcp::gpu::DeviceProblem;

/// The rows and what their moves need.
pub(super) struct Rows {
    pub problem: DeviceProblem,
    spare_pair: Buffer,
    spare_jacobian: Buffer,
    spare_q: Buffer,
    spare_gamma: Buffer,
    /// Where rows are by branches.
    pub branches: Option<Branches>,
    /// With the paper's rows, where steps have a middle: one for each row that was made there from a near pair, zero
    /// for the others; and a spare.
    is_first: Option<[Buffer; 2]>,
    /// Where each pair's rows will begin.
    pub next_start: Buffer,
    pub counts: Buffer,
    targets: Buffer,
    body_counts: Buffer,
    scan: Scan,
}

/// What rows are made from.
#[derive(Clone, Copy)]
pub(super) struct RowInputs<'a> {
    pub lists: &'a Lists,
    pub motions: &'a Buffer,
    pub setup: &'a Setup,
    /// The part of the step that they are rows of.
    pub part: Part,
    /// Whether they are first rows made ahead of the step's start.
    pub ahead: bool,
    /// Where the bodies are and what they are there, and what they are at the part's end.
    pub poses: &'a Poses,
    pub shapes: &'a Shapes,
    pub grown: &'a Shapes,
    /// Where the step starts, with the velocities of the last one.
    pub last: &'a Poses,
}

impl Rows {
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Self, GpuError> {
        let real = setup.precision.bytes();
        let blocks = if setup.planar { 8 } else { 16 };
        let vectors = if setup.planar { 1 } else { 2 };
        let is_first = || Buffer::new(gpu, "first rows", real, 0);
        Ok(Rows {
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
            is_first: if setup.midpoint && setup.branches == 0 { Some([is_first()?, is_first()?]) } else { None },
            next_start: Buffer::new(gpu, "row starts", 4, 1)?,
            counts: Buffer::new(gpu, "row counts", 4, 0)?,
            targets: Buffer::new(gpu, "row targets", 4, 0)?,
            body_counts: Buffer::new(gpu, "incidence counts", 4, 0)?,
            scan: Scan::new(gpu)?,
        })
    }

    /// Counts the rows that pairs will have with one more for each flag of at least `threshold`, or for each branch
    /// that is chosen, beside those there are.
    pub fn count(
        &mut self,
        gpu: &Gpu,
        kernels: &Kernels,
        record: &mut Recorder<'_>,
        contacts: &Buffer,
        pairs: u64,
        (has_rows, threshold): (bool, u32),
    ) -> Result<(), GpuError> {
        self.counts.reserve(gpu, pairs)?;
        self.next_start.reserve(gpu, pairs + 1)?;
        let parameters = words([pairs as u32, u32::from(has_rows), threshold, 0]);
        record.run(
            &kernels.count,
            &parameters,
            &[("contacts", contacts), ("row_start", &self.problem.block_start), ("counts", &self.counts)],
            pairs,
        );
        self.scan.exclusive(record, &self.counts, &self.next_start, pairs)
    }

    /// The first rows of a part of the step, for which [`Rows::count`] found room.
    pub fn begin(
        &mut self,
        gpu: &Gpu,
        kernels: &Kernels,
        record: &mut Recorder<'_>,
        made: RowInputs<'_>,
        rows: u64,
    ) -> Result<(), GpuError> {
        let problem = &mut self.problem;
        problem.pair.reserve(gpu, rows)?;
        problem.jacobian.reserve(gpu, rows)?;
        problem.q.reserve(gpu, rows)?;
        problem.gamma.reserve(gpu, rows)?;
        self.take_starts(made.lists.pairs_count, rows);
        if self.branches.is_some() {
            return self.append_branches(gpu, kernels, record, made, true);
        }
        self.append(kernels, record, made, NEAR, true);
        Ok(())
    }

    /// The first rows of the whole step in the place of those of its first half, from whose multipliers they start.
    pub fn begin_again(
        &mut self,
        gpu: &Gpu,
        kernels: &Kernels,
        midpoint: &MidpointKernels,
        record: &mut Recorder<'_>,
        made: RowInputs<'_>,
        rows: u64,
    ) -> Result<(), GpuError> {
        // Rows by branches have read them by then.
        let Some(kernels_of_middle) = &midpoint.rows else { return self.begin(gpu, kernels, record, made, rows) };
        std::mem::swap(&mut self.problem.gamma, &mut self.spare_gamma);
        self.begin(gpu, kernels, record, made, rows)?;
        let Some([is_first, _]) = &mut self.is_first else { return Ok(()) };
        is_first.reserve(gpu, rows)?;
        // The old rows' starts and multipliers are the spare ones now.
        let Rows { problem, next_start, spare_gamma, .. } = self;
        let pairs = made.lists.pairs_count;
        let buffers = [
            ("old_start", &*next_start),
            ("old_gamma", spare_gamma),
            ("row_start", &problem.block_start),
            ("gamma", &problem.gamma),
            ("is_first", is_first),
        ];
        record.run(&kernels_of_middle.recall, &words([pairs as u32, 0, 0, 0]), &buffers, pairs);
        Ok(())
    }

    /// Moves the offsets of first rows to the violations among the contacts, which are none any longer.
    pub fn tighten(
        &self,
        midpoint: &MidpointKernels,
        record: &mut Recorder<'_>,
        RowInputs { lists, motions, setup, part, .. }: RowInputs<'_>,
        bodies: u64,
    ) {
        let (Some([is_first, _]), Some(kernels)) = (&self.is_first, &midpoint.rows) else { return };
        let problem = &self.problem;
        let buffers = [
            ("row_start", &problem.block_start),
            ("is_first", is_first),
            ("row_pairs", &problem.pair),
            ("jacobian", &problem.jacobian),
            ("velocities", &problem.velocity),
            ("motions", motions),
            ("q", &problem.q),
            ("contacts", &lists.contacts),
        ];
        let parameters = setup.timed([lists.pairs_count as u32, bodies as u32, 0, 0], setup.length_of(part));
        record.run(&kernels.tighten, &parameters, &buffers, lists.pairs_count);
    }

    /// One more row for every violating pair, for which [`Rows::count`] found room.
    pub fn extend(
        &mut self,
        gpu: &Gpu,
        kernels: &Kernels,
        record: &mut Recorder<'_>,
        made: RowInputs<'_>,
        rows: u64,
    ) -> Result<(), GpuError> {
        // Rows keep their pairs, so there is no map from old pairs to new ones.
        self.move_all(gpu, kernels, record, (made.lists.pairs_count, None), rows)?;
        if self.branches.is_some() {
            return self.append_branches(gpu, kernels, record, made, false);
        }
        self.append(kernels, record, made, VIOLATING, false);
        Ok(())
    }

    /// Takes all rows whose pair is there over to a new list of pairs: `old_pair` says which pair of the old list each
    /// was, and `counts` how many rows it has.
    pub fn carry(
        &mut self,
        gpu: &Gpu,
        kernels: &Kernels,
        record: &mut Recorder<'_>,
        pairs: u64,
        old_pair: &Buffer,
    ) -> Result<(), GpuError> {
        self.next_start.reserve(gpu, pairs + 1)?;
        self.scan.exclusive(record, &self.counts, &self.next_start, pairs)?;
        let rows = self.problem.rows;
        self.move_all(gpu, kernels, record, (pairs, Some(old_pair)), rows)
    }

    /// Which rows each body takes part in.
    pub fn incidence(
        &mut self,
        gpu: &Gpu,
        kernels: &Kernels,
        record: &mut Recorder<'_>,
        lists: &Lists,
        bodies: u64,
    ) -> Result<(), GpuError> {
        let problem = &mut self.problem;
        problem.bodies = bodies;
        self.body_counts.reserve(gpu, bodies)?;
        problem.incidence_start.reserve(gpu, bodies + 1)?;
        problem.incidence.reserve(gpu, 2 * problem.rows)?;
        problem.velocity.reserve(gpu, bodies)?;
        let parameters = words([bodies as u32, 0, 0, 0]);
        let (start, adjacency) = (&lists.adjacency_start, &lists.adjacency);
        record.run(
            &kernels.incidence_count,
            &parameters,
            &[
                ("adjacency_start", start),
                ("adjacency", adjacency),
                ("row_start", &problem.block_start),
                ("counts", &self.body_counts),
            ],
            bodies,
        );
        self.scan.exclusive(record, &self.body_counts, &problem.incidence_start, bodies)?;
        record.run(
            &kernels.incidence_fill,
            &parameters,
            &[
                ("adjacency_start", start),
                ("adjacency", adjacency),
                ("row_start", &problem.block_start),
                ("incidence_start", &problem.incidence_start),
                ("incidence", &problem.incidence),
            ],
            bodies,
        );
        Ok(())
    }

    fn append(&self, kernels: &Kernels, record: &mut Recorder<'_>, made: RowInputs<'_>, threshold: u32, warm: bool) {
        let (problem, RowInputs { lists, motions, setup, part, .. }) = (&self.problem, made);
        let of_kernel = [lists.pairs_count as u32, threshold, u32::from(warm), lists.bodies as u32];
        let parameters = setup.timed(of_kernel, setup.length_of(part));
        let buffers = [
            ("pairs", &lists.pairs),
            ("row_start", &problem.block_start),
            ("contacts", &lists.contacts),
            ("motions", motions),
            ("row_pairs", &problem.pair),
            ("jacobian", &problem.jacobian),
            ("q", &problem.q),
            ("gamma", &problem.gamma),
        ];
        record.run(&kernels.append, &parameters, &buffers, lists.pairs_count);
    }

    fn move_all(
        &mut self,
        gpu: &Gpu,
        kernels: &Kernels,
        record: &mut Recorder<'_>,
        (pairs, old_pair): (u64, Option<&Buffer>),
        rows: u64,
    ) -> Result<(), GpuError> {
        let old_rows = self.problem.rows;
        self.targets.reserve(gpu, old_rows)?;
        self.spare_pair.reserve(gpu, rows)?;
        self.spare_jacobian.reserve(gpu, rows)?;
        self.spare_q.reserve(gpu, rows)?;
        self.spare_gamma.reserve(gpu, rows)?;
        let problem = &mut self.problem;
        if old_pair.is_some() {
            // In the middle of a step pairs that had rows may be far apart and in no list any more.
            record.clear(&self.targets, 0..4 * old_rows);
        }
        let parameters = words([pairs as u32, u32::from(old_pair.is_some()), 0, 0]);
        // Without a map the kernel does not look at it.
        let map = old_pair.unwrap_or(&self.counts);
        let buffers = [
            ("old_start", &problem.block_start),
            ("new_start", &self.next_start),
            ("old_pair", map),
            ("targets", &self.targets),
        ];
        record.run(&kernels.target, &parameters, &buffers, pairs);
        let parameters = words([old_rows as u32, 0, 0, 0]);
        let moves = [
            (&kernels.move_pairs, &mut problem.pair, &mut self.spare_pair),
            (&kernels.move_blocks, &mut problem.jacobian, &mut self.spare_jacobian),
            (&kernels.move_reals, &mut problem.q, &mut self.spare_q),
            (&kernels.move_reals, &mut problem.gamma, &mut self.spare_gamma),
        ];
        for (kernel, from, to) in moves {
            record.run(kernel, &parameters, &[("targets", &self.targets), ("source", from), ("moved", to)], old_rows);
            std::mem::swap(from, to);
        }
        if let Some([from, to]) = &mut self.is_first {
            // New rows are not first ones.
            from.reserve_and_keep(gpu, record, old_rows)?;
            to.reserve(gpu, rows)?;
            record.clear(to, 0..rows * to.element() as u64);
            record.run(
                &kernels.move_reals,
                &parameters,
                &[("targets", &self.targets), ("source", from), ("moved", to)],
                old_rows,
            );
            std::mem::swap(from, to);
        }
        if let (Some(branches), Some(kernels)) = (&mut self.branches, &kernels.branches) {
            branches.move_all(gpu, kernels, record, &self.targets, [old_rows, rows])?;
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
