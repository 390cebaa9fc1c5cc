//! The state in which the first rows are made. In the plane it is the state one part of a step ahead, extrapolated with
//! the last velocities, if no overlap there is deep. In a cell whose lengths change it is the state to which its flow
//! leads. Otherwise it is the state at the beginning of the step.

use super::Setup;
use super::motions::Motions;
use super::part::Part;
use super::source::{base, sheared};
use super::start::Stages;
use super::states::Poses;
use crate::backend::cpu::first::{AHEAD, DEEPEST_AHEAD};
use crate::gpu::{Gpu, GpuError, Made, Recorder, fragment, functions, kernels};

functions! {
    pub(super) Ahead = struct AheadArgs<'a> {
        stages: Stages<'a>, start: &'a Poses, motions: &'a Motions, ahead: &'a Poses,
    }
    pub(super) Carried = struct CarriedArgs<'a> {
        stages: Stages<'a>, start: &'a Poses, motions: &'a Motions, ahead: &'a Poses,
    }
}

kernels! {
    /// The kernels that move bodies to where first rows are made.
    pub(super) struct FirstKernels for setup: &Setup {
        /// Only if first rows are made at positions extrapolated with the last velocities.
        ahead: Option<Ahead> = setup.leads_ahead()
            .then(|| base(setup, "ahead").real("AHEAD", AHEAD).include(fragment!("dynamics/ahead.wgsl"))),
        /// In scenes with a changing cell.
        carried: Option<Carried> = setup.strain.map(|_| sheared::carried(setup)),
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
pub(super) struct First {
    /// Whether the first rows at the start are made at extrapolated positions.
    pub ahead: bool,
    /// The deepest overlap in that state.
    pub overlap: f64,
    kernels: FirstKernels,
}

impl First {
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Self, GpuError> {
        Ok(First { ahead: false, overlap: 0.0, kernels: FirstKernels::make(gpu, setup)? })
    }

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
    pub fn is_led_astray(&self, setup: &Setup, part: Part, overlap: f64) -> bool {
        self.is_ahead(part) && overlap > DEEPEST_AHEAD * setup.thinnest
    }

    /// Records the poses where first rows are made, and the velocities that lead there.
    pub fn record(&self, stages: Stages<'_>, record: &mut Recorder<'_>, motions: &Motions) {
        self.record_carried(stages, record, motions);
        let (Some(kernel), true) = (&self.kernels.ahead, self.is_ahead(stages.start.part)) else { return };
        let (start, ahead) = (stages.states.start(), self.poses(stages));
        kernel.call(record, stages.start.bodies, AheadArgs { stages, start, motions, ahead });
    }

    /// Records the poses to which the flow of a changing cell leads bodies.
    fn record_carried(&self, stages: Stages<'_>, record: &mut Recorder<'_>, motions: &Motions) {
        let Some(kernel) = &self.kernels.carried else { return };
        let (start, ahead) = (stages.states.start(), self.poses(stages));
        kernel.call(record, stages.start.bodies, CarriedArgs { stages, start, motions, ahead });
    }
}
