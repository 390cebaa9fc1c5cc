//! The separations of a step on the device, with a list of candidates that is complete for them, and what the host
//! reads of them.

use super::midpoint::Part;
use super::{Device, words};
use crate::gpu::{Gpu, GpuError, Recorder};
use crate::step::{Fault, Overlap};
use crate::walls::{AtSurface, Walls};
use bytemuck::Zeroable;
use std::time::Instant;

/// What the host reads of a stage: `Report` of `shaders/step/report.wgsl`.
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
    /// Its bytes must divide the places of an ensemble's buffer.
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
        Overlap { worst, pair, wall, violations: self.violations as usize, proxy: None }
    }
}

impl Device {
    /// The separations at the start, in the middle or at the trial, with a list of candidates that is complete for it,
    /// and how many rows there will be. `prepared` is what was recorded to be done before.
    pub(super) fn separate(&mut self, prepared: Recorder<'_>, at_trial: bool) -> Result<Report, Fault> {
        let gpu = self.gpu.clone();
        let mut prepared = Some(prepared);
        loop {
            let mut record = prepared.take().unwrap_or_else(|| gpu.record());
            record.stage("narrow phase");
            record.copy(&self.blank, 0, &self.report, 0, Report::BYTES);
            let (part, leads) = (self.part, self.leads());
            let Device { candidates, kernels, bodies, boxes, report, states, .. } = &mut *self;
            let first = states.first(part, leads);
            candidates.inside(&gpu, kernels, &mut record, (first, boxes, report), *bodies)?;
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
        let (poses, shapes) =
            if at_trial { (&self.states.trial, self.start_shapes()) } else { (self.first(), self.here_shapes()) };
        let (lists, pairs) = (&self.candidates.lists, self.candidates.lists.pairs_count);
        let of_bodies = lists.body_pairs;
        let by_motions = self.setup.branches > 0;
        let parameters = [of_bodies as u32, u32::from(at_trial), (self.violating as f32).to_bits(), 0];
        let parameters = if by_motions { self.timed(parameters) } else { words(parameters).to_vec() };
        let parameters = self.setup.of_pairs(&parameters);
        for kernel in &self.kernels.narrow {
            let buffers = [
                ("pairs", &lists.pairs),
                ("cells", &poses.cells),
                ("remainders", &poses.remainders),
                ("orientations", &poses.orientations),
                ("shapes", &shapes.shapes),
                if by_motions { ("motions", &self.motions) } else { ("boxes", &self.boxes) },
                ("contacts", &lists.contacts),
                ("report", &self.report),
            ];
            record.run(kernel, &parameters, &buffers, of_bodies);
        }
        if let (Some(surfaces), Some(kernels)) = (&self.candidates.surfaces, &self.kernels.walls) {
            surfaces.separate(kernels, record, lists, (poses, shapes, &self.boxes), (at_trial, self.violating));
        }
        if let Some(held) = &self.held {
            held.ignore(&self.kernels, record, lists);
        }
        if at_trial {
            self.record_effect(record, shapes, 1);
        }
        // Where first rows are made the deepest overlap alone is asked for.
        let passes = if at_trial { 3 } else { usize::from(by_motions) };
        for (pass, threads) in [(1, pairs), (2, pairs), (3, 1)].into_iter().take(passes) {
            let buffers = [("pairs", &lists.pairs), ("contacts", &lists.contacts), ("report", &self.report)];
            record.run(&self.kernels.overlap, &words([pairs as u32, pass, 0, 0]), &buffers, threads);
        }
        self.record_count(gpu, record, at_trial)
    }

    /// Records how many rows there will be, by the flags of pairs or by branches.
    fn record_count(&mut self, gpu: &Gpu, record: &mut Recorder<'_>, at_trial: bool) -> Result<(), GpuError> {
        let violating = at_trial.then_some(self.violating);
        let (rows, kernels, made, _) = self.made(at_trial);
        rows.choose_branches(gpu, kernels, record, made, violating)?;
        let what = if at_trial { (true, 2) } else { (false, 1) };
        rows.count(gpu, kernels, record, &made.lists.contacts, made.lists.pairs_count, what)
    }

    fn search(&mut self, report: &Report, at_trial: bool) -> Result<(), GpuError> {
        let begun = Instant::now();
        let largest = f64::from(f32::from_bits(report.largest));
        let gpu = self.gpu.clone();
        let (part, leads) = (self.part, self.leads());
        let Device { candidates, setup, kernels, boxes, rows, bodies, states, .. } = &mut *self;
        let (first, shapes) = (states.first(part, leads), states.end_shapes());
        // In the middle the rows of the first half say what its end's rows start from.
        let rows = (at_trial || part == Part::FromMiddle).then_some(rows);
        candidates.search(&gpu, setup, kernels, (first, shapes, boxes, largest), *bodies, rows)?;
        let spent = begun.elapsed();
        self.phases.broad_phase += spent;
        // The caller counts all its time as narrow phase.
        self.phases.narrow_phase = self.phases.narrow_phase.saturating_sub(spent);
        Ok(())
    }
}
