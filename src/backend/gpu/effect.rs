//! The effect of contact during a trial, on the device. Two kernels, one for the bodies and one for the pairs, write it
//! into the report of a trial, which the host reads in any case. If contacts of a step push bodies apart that do not
//! touch, the CPU repeats the step, as after a failure, because only the CPU can remake its rows.
//!
//! Differences from the CPU: only the nearest separation of a pair that pushes is checked; with the paper's rows, pairs
//! are not checked; bodies and pairs are named only where a guarantee is violated; energy is not measured.

use super::Setup;
use super::lists::Lists;
use super::motions::Motions;
use super::narrow_phase::{NarrowPhase, Report};
use super::row_set::RowSet;
use super::source::{numbers, reporting, with_bodies, with_flags};
use super::start::Stages;
use super::states::{Poses, Shapes};
use crate::backend::cpu::two_sided::THROWN;
use crate::gpu::{Buffer, GpuError, Recorder, Source, fragment, functions, kernels};
use crate::lcp::gpu::DeviceProblem;
use crate::step::{Effect, GAP};
use crate::walls::{AtSurface, number_of};
use bytemuck::pod_read_unaligned;

functions! {
    pub(super) Farthest = struct FarthestArgs<'a> {
        pass_number: u32, stages: Stages<'a>, shapes: &'a Shapes, trial: &'a Poses, motions: &'a Motions,
        report: &'a Buffer,
    }
    pub(super) Pushes = struct PushesArgs<'a> {
        pass_number: u32, least: f32, start_overlap: f32, stages: Stages<'a>, lists: &'a Lists,
        problem: &'a DeviceProblem, shapes: &'a Shapes, motions: &'a Motions, report: &'a Buffer,
    }
}

kernels! {
    /// The kernels of the effect of contact.
    pub(super) struct EffectKernels for setup: &Setup {
        farthest: Farthest = farthest(setup),
        pushes: Option<Pushes> = pushes(setup),
    }
}

impl Setup {
    /// The fraction of the thinner body's thickness up to which the separations of a trial are computed. Contacts that
    /// push must touch within this limit.
    pub(super) fn gap(&self) -> f64 {
        if self.branches > 0 { GAP } else { 0.0 }
    }
}

/// The kernel for bodies.
fn farthest(setup: &Setup) -> Source {
    reporting(with_bodies(setup, "farthest"))
        .include(fragment!("dynamics/axis.wgsl"))
        .include(fragment!("step/contact_move.wgsl"))
        .include(fragment!("step/farthest.wgsl"))
}

/// The kernel for pairs; `None` with the paper's rows.
fn pushes(setup: &Setup) -> Option<Source> {
    (setup.branches > 0).then(|| {
        reporting(numbers(with_flags(with_bodies(setup, "pushes"))))
            .real("GAP", setup.gap())
            .real("THROWN", THROWN)
            .integer("ROW_VECTORS", if setup.planar { 2 } else { 4 })
            .include(fragment!("step/contact_move.wgsl"))
            .include(fragment!("step/pushes.wgsl"))
    })
}

/// The inputs of the kernels for the effect of contact.
pub(super) struct Effects<'a> {
    pub kernels: &'a EffectKernels,
    pub stages: Stages<'a>,
    pub motions: &'a Motions,
    pub narrow: &'a NarrowPhase,
    pub rows: &'a RowSet,
    /// The tolerance of the last solve, and the deepest overlap where the step's first rows were made.
    pub tolerance: f64,
    pub overlap: f64,
}

impl Effects<'_> {
    /// Records the effect of contact up to the trial. A second pass finds the body and the pair with the largest
    /// effect.
    pub fn record(&self, record: &mut Recorder<'_>, pass_number: u32) {
        let (stages, motions, report) = (self.stages, self.motions, &self.narrow.report);
        let (shapes, trial) = (stages.states.end_shapes(), &stages.states.trial);
        let farthest = FarthestArgs { pass_number, stages, shapes, trial, motions, report };
        self.kernels.farthest.call(record, stages.start.bodies, farthest);
        let Some(kernel) = &self.kernels.pushes else { return };
        let (lists, problem) = (&self.narrow.candidates.lists, &self.rows.problem);
        let (least, start_overlap) = (self.tolerance as f32, self.overlap as f32);
        let pushes = PushesArgs { pass_number, least, start_overlap, stages, lists, problem, shapes, motions, report };
        kernel.call(record, lists.pairs_count, pushes);
    }

    /// The effect of contact up to a trial with this report.
    pub fn of_trial(&self, found: &Report) -> Result<Effect, GpuError> {
        let of = |bits: u32| f64::from(f32::from_bits(bits));
        let mut effect = Effect {
            largest_move: of(found.largest_move),
            push_gap: of(found.push_gap),
            apart: found.apart as usize,
            thrown: found.thrown as usize,
            axial_spin: of(found.axial_spin),
            energy_allowed: f64::INFINITY,
            ..Effect::default()
        };
        if effect.breaks_a_promise() {
            self.name_the_most(&mut effect)?;
        }
        Ok(effect)
    }

    /// Finds the body that contact moves farthest and the pair that pushes at the largest separation.
    fn name_the_most(&self, effect: &mut Effect) -> Result<(), GpuError> {
        let gpu = self.stages.gpu;
        let mut record = gpu.record();
        record.stage("narrow phase");
        self.record(&mut record, 2);
        let read = record.read(&[(&self.narrow.report, 0..Report::BYTES)])?;
        let Report { moved, push_pair, .. } = pod_read_unaligned(&read[0]);
        effect.moved = (moved != u32::MAX).then_some(moved as usize);
        if push_pair != u32::MAX {
            let at = 8 * u64::from(push_pair);
            let read = gpu.record().read(&[(&self.narrow.candidates.lists.pairs, at..at + 8)])?;
            let [a, b]: [u32; 2] = pod_read_unaligned(&read[0]);
            effect.push_pair = Some([a, AtSurface::of_number(b).map_or(b, |at| number_of(at.surface))]);
        }
        Ok(())
    }
}
