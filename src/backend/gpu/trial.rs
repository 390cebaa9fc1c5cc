//! The trial: `U`, `C(U)`, the results there, and the velocities at the end of a part of a step.

use super::first::First;
use super::motions::Motions;
use super::narrow_phase::Report;
use super::start::{Part, Stages};
use super::states::Poses;
use super::states::Shapes;
use crate::gpu::{Buffer, Recorder, functions};

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

/// The results of the last trial.
pub(super) struct Trial {
    /// The smallest overlap that counts as a violation.
    pub violating: f64,
    pub found: Report,
}

impl Trial {
    pub fn new(violating: f64) -> Self {
        Trial { violating, found: Report::blank() }
    }

    /// The largest displacement of a surface point up to the trial.
    pub fn farthest(&self) -> f64 {
        f64::from(f32::from_bits(self.found.farthest))
    }

    /// The part of that displacement by rotation alone.
    pub fn turned(&self) -> f64 {
        f64::from(f32::from_bits(self.found.turned))
    }
}

impl Stages<'_> {
    /// Records the move to `C(U)` over the present part, from the step's start.
    pub(super) fn record_move(self, record: &mut Recorder<'_>, motions: &Motions, velocities: &Buffer, trial: &Poses) {
        let (stages, start) = (self, self.states.start());
        self.kernels.trial.call(record, self.start.bodies, TrialMoveArgs { stages, start, velocities, motions, trial });
    }

    /// Records boxes that contain the bodies both in the state of the first rows and at the trial.
    pub(super) fn record_sweep(self, record: &mut Recorder<'_>, motions: &Motions, first: &First) {
        let (stages, shapes) = (self, self.states.end_shapes());
        let (first, trial) = (first.poses(self), &self.states.trial);
        self.kernels.sweep.call(record, self.start.bodies, SweepArgs { stages, first, trial, shapes, motions });
    }

    /// Records the velocities at the end of the present part, in the state `to`.
    pub(super) fn record_arrival(self, record: &mut Recorder<'_>, motions: &Motions, to: &Poses) {
        let (stages, bodies) = (self, self.start.bodies);
        let Some(arrive) = &self.kernels.arrive else {
            return self.kernels.accept.call(record, bodies, AcceptArgs { stages, motions, to });
        };
        let (by_middle, shapes) = (self.start.part == Part::FromMiddle, self.here_shapes());
        let (start, here) = (self.states.start(), self.here());
        arrive.call(record, bodies, ArriveArgs { stages, by_middle, motions, start, here, shapes, end: to });
    }
}
