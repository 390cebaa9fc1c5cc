//! The trial: `U`, `C(U)`, the results there, and the velocities at the end of a part of a step.

use super::first::First;
use super::motions::Motions;
use super::narrow_phase::Report;
use super::start::{Part, Stages};
use super::states::Poses;
use super::words;
use crate::gpu::{Buffer, Recorder};

/// What was found of the last trial.
pub(super) struct Trial {
    /// The overlap from which on a pair is a violation.
    pub violating: f64,
    pub found: Report,
}

impl Trial {
    pub fn new(violating: f64) -> Self {
        Trial { violating, found: Report::blank() }
    }

    /// How far a point of a surface moves to it, at most.
    pub fn farthest(&self) -> f64 {
        f64::from(f32::from_bits(self.found.farthest))
    }

    /// How far by its turn alone.
    pub fn turned(&self) -> f64 {
        f64::from(f32::from_bits(self.found.turned))
    }
}

impl Stages<'_> {
    /// Records the move to `C(U)` over the present part, from the step's start.
    pub(super) fn record_move(self, record: &mut Recorder<'_>, motions: &Motions, velocity: &Buffer, to: &Poses) {
        let (start, bodies) = (self.states.start(), self.start.bodies);
        let buffers = [
            ("cells", &start.cells),
            ("remainders", &start.remainders),
            ("orientations", &start.orientations),
            ("velocities", velocity),
            ("motions", &motions.motions),
            ("trial_cells", &to.cells),
            ("trial_remainders", &to.remainders),
            ("trial_orientations", &to.orientations),
        ];
        record.run(&self.kernels.trial, &self.timed([bodies as u32, 0, 0, 0]), &buffers, bodies);
    }

    /// Records boxes that hold the bodies where first rows are made and at the trial.
    pub(super) fn record_sweep(self, record: &mut Recorder<'_>, motions: &Motions, first: &First) {
        let (first, trial) = (first.poses(self), &self.states.trial);
        let buffers = [
            ("cells", &first.cells),
            ("remainders", &first.remainders),
            ("trial_cells", &trial.cells),
            ("trial_remainders", &trial.remainders),
            ("trial_orientations", &trial.orientations),
            ("shapes", &self.states.end_shapes().shapes),
            ("boxes", &motions.boxes),
        ];
        record.run(&self.kernels.sweep, &self.start.parameters(), &buffers, self.start.bodies);
    }

    /// Records the velocities that the present part ends with, in the state that it moved `to`.
    pub(super) fn record_arrival(self, record: &mut Recorder<'_>, motions: &Motions, to: &Poses) {
        let Stages { setup, kernels, start, .. } = self;
        let Some(arrive) = &kernels.arrive else {
            let buffers = [("motions", &motions.motions), ("twists", &to.twists)];
            record.run(&kernels.accept, &start.parameters(), &buffers, start.bodies);
            return;
        };
        let buffers = [
            ("motions", &motions.motions),
            ("start_twists", &self.states.start().twists),
            ("orientations", &self.here().orientations),
            ("shapes", &self.here_shapes().shapes),
            ("ended", &to.orientations),
            ("twists", &to.twists),
        ];
        let parameters = [start.bodies as u32, u32::from(start.part == Part::FromMiddle), 0, 0];
        let parameters = if setup.is_damped() { self.timed(parameters) } else { words(parameters).to_vec() };
        record.run(arrive, &parameters, &buffers, start.bodies);
    }
}
