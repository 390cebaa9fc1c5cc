//! Bodies that pass each other. A kernel computes how far any surface moves. If that is far enough, further kernels
//! test whether any two bodies move so far relative to each other. Only if they do, the host checks the path of the
//! step.

use super::motions::Motions;
use super::narrow_phase::{NarrowPhase, Report};
use super::start::Stages;
use super::states::Poses;
use crate::gpu::GpuError;
use crate::step::DEEPER;

impl NarrowPhase {
    /// Whether two bodies may have passed: a candidate pair that moves far enough against each other, or any other two
    /// where bodies leave their stored boxes on the way from the poses `from`.
    ///
    /// Stored boxes hold the bodies at the trial, and those of two bodies that are no candidate pair are disjoint. A
    /// body starts outside its box by at most `strayed`, and by its turn comes outside by at most `turned` more. Two
    /// such bodies overlap by at most twice the sum, which must reach `DEEPER` of a thickness.
    pub fn some_may_pass(
        &self,
        stages: Stages<'_>,
        motions: &Motions,
        from: &Poses,
        turned: f64,
    ) -> Result<bool, GpuError> {
        let Stages { setup, kernels, states, start, .. } = stages;
        let (bodies, shapes) = (start.bodies, &states.end_shapes().shapes);
        let (lists, stored) = (&self.candidates.lists, &self.candidates.stored);
        let mut record = stages.gpu.record();
        record.stage("narrow phase");
        // Nothing has written these words since the report was made blank.
        let buffers = [
            ("cells", &from.cells),
            ("remainders", &from.remainders),
            ("orientations", &from.orientations),
            ("shapes", shapes),
            ("stored_cells", &stored[0]),
            ("stored_remainders", &stored[1]),
            ("stored_boxes", &stored[2]),
            ("report", &self.report),
        ];
        record.run(&kernels.stray, &start.parameters(), &buffers, bodies);
        let buffers = [
            ("pairs", &lists.pairs),
            ("cells", &states.start().cells),
            ("remainders", &states.start().remainders),
            ("shapes", shapes),
            ("motions", &motions.motions),
            ("report", &self.report),
        ];
        let parameters = stages.timed([lists.body_pairs as u32, 0, 0, 0]);
        record.run(&kernels.passing, &start.of_pairs_here(setup, &parameters), &buffers, lists.body_pairs);
        let read = record.read(&[(&self.report, 0..Report::BYTES)])?;
        let report: Report = bytemuck::pod_read_unaligned(&read[0]);
        let left = f64::from(f32::from_bits(report.strayed)) + turned;
        // What is not a number may be anything.
        let inside = 2.0 * left < DEEPER * setup.thinnest;
        Ok(report.passing > 0 || !inside)
    }
}
