//! Bodies that pass each other. A kernel computes how far any surface moves. If that is far enough, further kernels
//! test whether any two bodies move so far relative to each other. Only if they do, the host checks the path of the
//! step.

use super::candidates::Lists;
use super::motions::Motions;
use super::narrow_phase::{NarrowPhase, Report};
use super::start::Stages;
use super::states::{Poses, Shapes};
use crate::broad_phase::gpu::Boxes;
use crate::gpu::{Buffer, GpuError, LatticePeriods, functions};
use crate::step::DEEPER;

functions! {
    pub(super) Stray = struct StrayArgs<'a> {
        stages: Stages<'a>, from: &'a Poses, shapes: &'a Shapes, stored: &'a Boxes, report: &'a Buffer,
    }
    pub(super) Passing = struct PassingArgs<'a> {
        pairs: u64, periods: LatticePeriods, stages: Stages<'a>, lists: &'a Lists, start: &'a Poses,
        shapes: &'a Shapes, motions: &'a Motions, report: &'a Buffer,
    }
}

impl NarrowPhase {
    /// Whether two bodies may have tunnelled: the bodies of a candidate pair with a large enough relative motion, or
    /// any two bodies if some leave their stored boxes on the path from the poses `from`.
    ///
    /// Stored boxes contain the bodies at the trial, and the stored boxes of two bodies that are not a candidate pair
    /// are disjoint. A body starts outside its box by at most `strayed`, and its rotation adds at most `turned`. Two
    /// such bodies overlap by at most twice the sum; tunnelling needs `DEEPER` of a thickness.
    pub fn some_may_pass(
        &self,
        stages: Stages<'_>,
        motions: &Motions,
        from: &Poses,
        turned: f64,
    ) -> Result<bool, GpuError> {
        let Stages { setup, kernels, states, start, .. } = stages;
        let (bodies, shapes, report) = (start.bodies, states.end_shapes(), &self.report);
        let (lists, stored) = (&self.candidates.lists, &self.candidates.stored);
        let mut record = stages.gpu.record();
        record.stage("narrow phase");
        // No kernel has written these words since the report was reset.
        kernels.stray.call(&mut record, bodies, StrayArgs { stages, from, shapes, stored, report });
        let (pairs, periods, start) = (lists.body_pairs, start.periods_here, states.start());
        let passing = PassingArgs { pairs, periods, stages, lists, start, shapes, motions, report };
        kernels.passing.call(&mut record, pairs, passing);
        let read = record.read(&[(&self.report, 0..Report::BYTES)])?;
        let report: Report = bytemuck::pod_read_unaligned(&read[0]);
        let left = f64::from(f32::from_bits(report.strayed)) + turned;
        // A value that is not a number counts as a possible passage.
        let inside = 2.0 * left < DEEPER * setup.thinnest;
        Ok(report.passing > 0 || !inside)
    }
}
