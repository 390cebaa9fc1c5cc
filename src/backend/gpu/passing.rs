//! Bodies that pass each other. A kernel computes how far any surface moves. If that is far enough, further kernels
//! test whether any two bodies move so far relative to each other. Only if they do, the host checks the path of the
//! step.

use super::Setup;
use super::lists::Lists;
use super::motions::Motions;
use super::narrow_phase::{NarrowPhase, Report};
use super::source::sheared::beside_images;
use super::source::{changing, of_pairs, reporting, with_bodies};
use super::start::Stages;
use super::states::{Poses, Shapes};
use crate::broad_phase::gpu::Boxes;
use crate::gpu::{Buffer, GpuError, LatticePeriods, Source, fragment, functions, kernels};
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

kernels! {
    /// The kernels of bodies that pass each other.
    pub(super) struct PassingKernels for setup: &Setup {
        stray: Stray = reporting(with_bodies(setup, "stray")).include(fragment!("step/stray.wgsl")),
        passing: Passing = passing(setup),
    }
}

/// The kernel that finds pairs that may have tunnelled.
fn passing(setup: &Setup) -> Source {
    let source = reporting(of_pairs(setup, "passing")).real("DEEPER", DEEPER).include(fragment!("step/passing.wgsl"));
    changing(setup, beside_images(setup, source, "motions[first_b].xyz - motions[first_a].xyz"))
}

impl PassingKernels {
    /// Whether two bodies may have tunnelled: the bodies of a candidate pair with a large enough relative motion, or
    /// any two bodies if some leave their stored boxes on the path from the poses `from`.
    ///
    /// Stored boxes contain the bodies at the trial, and the stored boxes of two bodies that are not a candidate pair
    /// are disjoint. A body starts outside its box by at most `strayed`, and its rotation adds at most `turned`. Two
    /// such bodies overlap by at most twice the sum; tunnelling needs `DEEPER` of a thickness.
    pub fn some_may_pass(
        &self,
        stages: Stages<'_>,
        (narrow, motions): (&NarrowPhase, &Motions),
        from: &Poses,
        turned: f64,
    ) -> Result<bool, GpuError> {
        let Stages { setup, states, start, .. } = stages;
        let (bodies, shapes, report) = (start.bodies, states.end_shapes(), &narrow.report);
        let (lists, stored) = (&narrow.candidates.lists, &narrow.candidates.stored);
        let mut record = stages.gpu.record();
        record.stage("narrow phase");
        // No kernel has written these words since the report was reset.
        self.stray.call(&mut record, bodies, StrayArgs { stages, from, shapes, stored, report });
        let (pairs, periods, start) = (lists.body_pairs, start.periods_here, states.start());
        let passing = PassingArgs { pairs, periods, stages, lists, start, shapes, motions, report };
        self.passing.call(&mut record, pairs, passing);
        let read = record.read(&[(&narrow.report, 0..Report::BYTES)])?;
        let report: Report = bytemuck::pod_read_unaligned(&read[0]);
        let left = f64::from(f32::from_bits(report.strayed)) + turned;
        // A value that is not a number counts as a possible passage.
        let inside = 2.0 * left < DEEPER * setup.thinnest;
        Ok(report.passing > 0 || !inside)
    }
}
