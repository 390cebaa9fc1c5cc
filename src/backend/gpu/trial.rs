//! The trial: `U`, `C(U)`, the results there, and the velocities at the end of a part of a step.

use super::Setup;
use super::motions::Motions;
use super::narrow_phase::Report;
use super::part::Part;
use super::source::{base, damping, dragged, turned, with_bodies, with_factor};
use super::start::Stages;
use super::states::{Poses, Shapes};
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, fragment, functions, kernels};

functions! {
    pub(super) TrialMove = struct TrialMoveArgs<'a> {
        stages: Stages<'a>, start: &'a Poses, velocities: &'a Buffer, motions: &'a Motions, trial: &'a Poses,
    }
    pub(super) Sweep = struct SweepArgs<'a> {
        stages: Stages<'a>, first: &'a Poses, trial: &'a Poses, shapes: &'a Shapes, motions: &'a Motions,
    }
    pub(super) Accept = struct AcceptArgs<'a> { stages: Stages<'a>, motions: &'a Motions, to: &'a Poses }
    pub(super) Arrive = struct ArriveArgs<'a> {
        stages: Stages<'a>, by_middle: bool, motions: &'a Motions, start: &'a Poses, here: &'a Poses,
        shapes: &'a Shapes, end: &'a Poses,
    }
}

kernels! {
    /// The kernels of trials and of what follows them.
    pub(super) struct TrialKernels for setup: &Setup {
        trial: TrialMove =
            dragged::of_trial(setup, with_factor(setup, "trial").include(fragment!("dynamics/trial.wgsl"))),
        sweep: Sweep = with_bodies(setup, "sweep").include(fragment!("broad_phase/sweep.wgsl")),
        accept: Accept = base(setup, "accept").include(fragment!("dynamics/accept.wgsl")),
        /// With inertia, instead of `accept`.
        arrive: Option<Arrive> =
            setup.inertia().then(|| match damping(setup) {
                Some(source) => {
                    dragged::of_arrival(setup, source("arrive").include(fragment!("dynamics/damped_arrive.wgsl")))
                }
                None => turned(setup, "arrive").include(fragment!("dynamics/arrive.wgsl")),
            }),
    }
}

/// The trials of a step, and the results of the last one.
pub(super) struct Trial {
    /// The smallest overlap that counts as a violation.
    pub violating: f64,
    pub found: Report,
    kernels: TrialKernels,
}

impl Trial {
    pub fn new(gpu: &Gpu, setup: &Setup, violating: f64) -> Result<Self, GpuError> {
        Ok(Trial { violating, found: Report::blank(), kernels: TrialKernels::make(gpu, setup)? })
    }

    /// The largest displacement of a surface point up to the trial.
    pub fn farthest(&self) -> f64 {
        f64::from(f32::from_bits(self.found.farthest))
    }

    /// The part of that displacement by rotation alone.
    pub fn turned(&self) -> f64 {
        f64::from(f32::from_bits(self.found.turned))
    }

    /// Records the move to `C(U)` over the present part, from the step's start.
    pub fn record_move(
        &self,
        stages: Stages<'_>,
        record: &mut Recorder<'_>,
        (motions, velocities): (&Motions, &Buffer),
        trial: &Poses,
    ) {
        let start = stages.states.start();
        let moved = TrialMoveArgs { stages, start, velocities, motions, trial };
        self.kernels.trial.call(record, stages.start.bodies, moved);
    }

    /// Records boxes that contain the bodies both in the poses of the first rows and at the trial.
    pub fn record_sweep(&self, stages: Stages<'_>, record: &mut Recorder<'_>, motions: &Motions, first: &Poses) {
        let (shapes, trial) = (stages.states.end_shapes(), &stages.states.trial);
        self.kernels.sweep.call(record, stages.start.bodies, SweepArgs { stages, first, trial, shapes, motions });
    }

    /// Records the velocities at the end of the present part, in the state `to`.
    pub fn record_arrival(&self, stages: Stages<'_>, record: &mut Recorder<'_>, motions: &Motions, to: &Poses) {
        let bodies = stages.start.bodies;
        let Some(arrive) = &self.kernels.arrive else {
            return self.kernels.accept.call(record, bodies, AcceptArgs { stages, motions, to });
        };
        let (by_middle, shapes) = (stages.start.part == Part::FromMiddle, stages.here_shapes());
        let (start, here) = (stages.states.start(), stages.here());
        arrive.call(record, bodies, ArriveArgs { stages, by_middle, motions, start, here, shapes, end: to });
    }
}
