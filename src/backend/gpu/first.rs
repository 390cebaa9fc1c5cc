//! The state in which the first rows are made. In the plane it is the state one part of a step ahead, extrapolated with
//! the last velocities, if no overlap there is deep. In a cell whose lengths change it is the state to which its flow
//! leads. Otherwise it is the state at the beginning of the step.

use super::Setup;
use super::motions::Motions;
use super::narrow_phase::Report;
use super::start::{Part, Stages};
use super::states::Poses;
use crate::backend::cpu::first::DEEPEST_AHEAD;
use crate::gpu::{Recorder, functions};

functions! {
    pub(super) Ahead = struct AheadArgs<'a> {
        stages: Stages<'a>, start: &'a Poses, motions: &'a Motions, ahead: &'a Poses,
    }
    pub(super) Carried = struct CarriedArgs<'a> {
        stages: Stages<'a>, start: &'a Poses, motions: &'a Motions, ahead: &'a Poses,
    }
}

impl Setup {
    /// Whether first rows may be made at positions extrapolated with the last velocities.
    pub fn leads_ahead(&self) -> bool {
        self.planar
            && self.branches > 0
            && !self.midpoint
            && !self.inertia()
            && self.heat.is_none()
            && self.strain.is_none()
    }
}

/// The state where first rows are made.
#[derive(Default)]
pub(super) struct First {
    /// Whether the first rows at the start are made at extrapolated positions.
    pub ahead: bool,
    /// The deepest overlap in that state.
    pub overlap: f64,
}

impl First {
    /// Whether the first rows of a part are made at extrapolated positions.
    pub fn is_ahead(&self, part: Part) -> bool {
        self.ahead && part != Part::FromMiddle
    }

    /// The poses where the first rows of the present part are made.
    pub fn poses<'a>(&self, stages: Stages<'a>) -> &'a Poses {
        let Stages { setup, states, start, .. } = stages;
        states.first(start.part, self.is_ahead(start.part) || setup.strain.is_some())
    }

    /// Whether bodies overlap so deeply at extrapolated positions that normals may point to the wrong side.
    pub fn is_led_astray(&self, setup: &Setup, part: Part, found: &Report) -> bool {
        self.is_ahead(part) && f64::from(f32::from_bits(found.worst)) > DEEPEST_AHEAD * setup.thinnest
    }

    /// Records the poses where first rows are made, and the velocities that lead there.
    pub fn record(&self, stages: Stages<'_>, record: &mut Recorder<'_>, motions: &Motions) {
        self.record_carried(stages, record, motions);
        let kernel = stages.kernels.branches.as_ref().and_then(|kernels| kernels.ahead.as_ref());
        let (Some(kernel), true) = (kernel, self.is_ahead(stages.start.part)) else { return };
        let (start, ahead) = (stages.states.start(), self.poses(stages));
        kernel.call(record, stages.start.bodies, AheadArgs { stages, start, motions, ahead });
    }

    /// Records the poses to which the flow of a changing cell leads bodies.
    fn record_carried(&self, stages: Stages<'_>, record: &mut Recorder<'_>, motions: &Motions) {
        let Some(kernel) = &stages.kernels.carried else { return };
        let (start, ahead) = (stages.states.start(), self.poses(stages));
        kernel.call(record, stages.start.bodies, CarriedArgs { stages, start, motions, ahead });
    }
}
