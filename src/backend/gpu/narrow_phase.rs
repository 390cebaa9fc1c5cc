//! The separations of a step on the device, with a complete list of candidates for them, and the values that the host
//! reads.

use super::candidates::Candidates;
use super::lists::Lists;
use super::part::Part;
use super::parted::Parted;
use super::row_inputs::RowInputs;
use super::source::{NEAR, VIOLATING, base, narrow_sources, reporting, with_flags};
use super::start::Stages;
use super::states::Poses;
use super::{Device, Setup};
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, fragment, functions, kernels};
use crate::step::{Fault, Overlap};
use crate::walls::{AtSurface, Walls};
use crate::warm::Warm;
use bytemuck::Zeroable;
use std::time::Instant;

functions! {
    pub(super) Narrow = struct NarrowArgs<'a> {
        pairs: u64, at_trial: bool, violating: f32, made: RowInputs<'a>, report: &'a Buffer,
    }
    pub(super) Overlaps = struct OverlapsArgs<'a> { pass_number: u64, lists: &'a Lists, report: &'a Buffer }
}

kernels! {
    /// The kernels of separations.
    pub(super) struct NarrowKernels for setup: &Setup {
        /// One kernel for each pair of families that the scene's shapes can form.
        narrow: Vec<Narrow> = narrow_sources(setup),
        overlap: Overlaps = reporting(with_flags(base(setup, "overlap"))).include(fragment!("step/overlap.wgsl")),
    }
}

/// The data that the host reads of a stage: `Report` of `shaders/step/report.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Report {
    pub(super) outside: u32,
    pub(super) not_finite: u32,
    pub(super) violations: u32,
    pub(super) worst: u32,
    pub(super) worst_pair: u32,
    pub(super) worst_a: u32,
    pub(super) worst_b: u32,
    pub(super) largest: u32,
    pub(super) farthest: u32,
    pub(super) turned: u32,
    pub(super) strayed: u32,
    pub(super) passing: u32,
    pub(super) largest_move: u32,
    pub(super) moved: u32,
    pub(super) axial_spin: u32,
    pub(super) push_gap: u32,
    pub(super) push_pair: u32,
    pub(super) apart: u32,
    pub(super) thrown: u32,
    /// The size of the struct must divide the offsets in an ensemble's buffer.
    padding: u32,
}

impl Report {
    pub(super) const BYTES: u64 = size_of::<Report>() as u64;

    pub(super) fn blank() -> Self {
        let none = u32::MAX;
        Report { not_finite: none, worst_pair: none, moved: none, push_pair: none, ..Report::zeroed() }
    }

    pub(super) fn overlap(&self, of: &Walls) -> Overlap {
        let found = self.worst_pair != u32::MAX;
        let surface = AtSurface::of_number(self.worst_b).filter(|_| found);
        let wall = surface.map(|at| [self.worst_a as usize, of.wall_of(at.surface)]);
        let pair = (found && wall.is_none()).then_some([self.worst_a as usize, self.worst_b as usize]);
        let worst = f64::from(f32::from_bits(self.worst));
        Overlap { worst, pair, wall, violations: self.violations as usize, proxy: None, stretch: 0.0, bond: None }
    }
}

/// The candidate pairs, and the results of their separations that the host reads.
pub(super) struct NarrowPhase {
    pub candidates: Candidates,
    pub report: Buffer,
    blank: Buffer,
    kernels: NarrowKernels,
}

impl NarrowPhase {
    pub fn new(gpu: &Gpu, setup: &Setup, warm: Vec<Warm>) -> Result<Self, GpuError> {
        Ok(NarrowPhase {
            report: Buffer::new(gpu, "report", 4, Report::BYTES / 4)?,
            blank: Buffer::with(gpu, "blank report", 4, bytemuck::bytes_of(&Report::blank()))?,
            candidates: Candidates::new(gpu, setup, warm)?,
            kernels: NarrowKernels::make(gpu, setup)?,
        })
    }

    /// Records the reset of the report, and the check whether the list of candidates is complete for the boxes.
    fn record_look(
        &mut self,
        stages: Stages<'_>,
        record: &mut Recorder<'_>,
        (first, boxes): (&Poses, &Buffer),
    ) -> Result<(), GpuError> {
        let NarrowPhase { candidates, report, blank, .. } = self;
        record.copy(blank, 0, report, 0, Report::BYTES);
        candidates.inside(stages.gpu, record, (first, boxes, report), stages.start.bodies)
    }

    /// Records the separations of all pairs in the given poses. At the trial, pairs that overlap by at least
    /// `violating` are violations.
    fn record_separations(
        &self,
        record: &mut Recorder<'_>,
        made: RowInputs<'_>,
        (at_trial, violating): (bool, f64),
        parted: Option<&Parted>,
    ) {
        let RowInputs { stages: Stages { start, .. }, lists, .. } = made;
        let (pairs, violating, report) = (lists.body_pairs, violating as f32, &self.report);
        for kernel in &self.kernels.narrow {
            kernel.call(record, pairs, NarrowArgs { pairs, at_trial, violating, made, report });
        }
        if let Some(surfaces) = &self.candidates.surfaces {
            surfaces.separate(record, made, (at_trial, violating));
        }
        if let Some(held) = &start.held {
            held.ignore(record, lists);
        }
        if let Some(parted) = parted {
            parted.part(record, lists);
        }
    }

    /// Records the deepest overlap, and at the trial also its pair.
    fn record_overlap(&self, Stages { setup, .. }: Stages<'_>, record: &mut Recorder<'_>, at_trial: bool) {
        let (lists, pairs) = (&self.candidates.lists, self.candidates.lists.pairs_count);
        // Where first rows are made, only the deepest overlap is needed.
        let passes = if at_trial { 3 } else { usize::from(setup.branches > 0) };
        for (pass, threads) in [(1, pairs), (2, pairs), (3, 1)].into_iter().take(passes) {
            let searched = OverlapsArgs { pass_number: pass, lists, report: &self.report };
            self.kernels.overlap.call(record, threads, searched);
        }
    }
}

impl Device {
    /// The separations at the start, in the middle or at the trial, with a complete list of candidates, and the number
    /// of rows that follow. `prepared` is the work recorded before.
    pub(super) fn separate(&mut self, prepared: Recorder<'_>, at_trial: bool) -> Result<Report, Fault> {
        let gpu = self.gpu.clone();
        let mut prepared = Some(prepared);
        loop {
            let mut record = prepared.take().unwrap_or_else(|| gpu.record());
            record.stage("narrow phase");
            let Device { setup, states, start, motions, first, narrow, .. } = &mut *self;
            let stages = Stages { gpu: &gpu, setup, states, start };
            narrow.record_look(stages, &mut record, (first.poses(stages), &motions.boxes))?;
            let listed = narrow.candidates.is_for(start.bodies);
            if listed {
                self.record_separations(&mut record, at_trial)?;
            }
            let pairs = if listed { self.narrow.candidates.lists.pairs_count } else { 0 };
            let total = if listed { 4 * pairs..4 * pairs + 4 } else { 0..0 };
            let read = record.read(&[(&self.narrow.report, 0..Report::BYTES), (&self.rows.next_start, total)])?;
            let report: Report = bytemuck::pod_read_unaligned(&read[0]);
            if report.not_finite != u32::MAX {
                let body = report.not_finite as usize;
                return Err(Fault::NotFinite { step: self.start.step, what: "velocity or pose", body });
            }
            if !at_trial {
                self.motions.check_periods(self.stages(), f32::from_bits(report.largest))?;
            }
            if listed && report.outside == 0 {
                self.rows.next = u64::from(bytemuck::pod_read_unaligned::<u32>(&read[1]));
                self.narrow.candidates.used();
                return Ok(report);
            }
            self.search(&report, at_trial)?;
        }
    }

    fn record_separations(&mut self, record: &mut Recorder<'_>, at_trial: bool) -> Result<(), GpuError> {
        let (stages, violating) = (self.stages(), self.trial.violating);
        let (lists, motions) = (&self.narrow.candidates.lists, &self.motions);
        let made = RowInputs::of(stages, &self.first, lists, motions, at_trial);
        let parted = self.hosted.as_ref().and_then(|hosted| hosted.parted.as_ref());
        self.narrow.record_separations(record, made, (at_trial, violating), parted);
        if at_trial {
            self.effects().record(record, 1);
        }
        self.narrow.record_overlap(stages, record, at_trial);
        let (rows, made) = self.row_inputs(at_trial);
        rows.choose_branches(record, made, at_trial.then_some(violating))?;
        rows.count(record, made, if at_trial { (true, VIOLATING) } else { (false, NEAR) })
    }

    fn search(&mut self, report: &Report, at_trial: bool) -> Result<(), GpuError> {
        let begun = Instant::now();
        let largest = f64::from(f32::from_bits(report.largest));
        let Device { gpu, setup, states, start, motions, first, narrow, rows, .. } = &mut *self;
        let stages = Stages { gpu, setup, states, start };
        // In the middle, the rows of the whole step start from the multipliers of the first half's rows.
        let rows = (at_trial || start.part == Part::FromMiddle).then_some(rows);
        let boxes = (first.poses(stages), states.end_shapes(), &motions.boxes, largest);
        narrow.candidates.search(gpu, setup, boxes, start.bodies, rows)?;
        let spent = begun.elapsed();
        self.phases.broad_phase += spent;
        // The caller counts this call as narrow phase, so the time counted elsewhere is subtracted.
        self.phases.narrow_phase = self.phases.narrow_phase.saturating_sub(spent);
        Ok(())
    }
}
