//! The state in which the first rows are made. In the plane it is the state one part of a step ahead, extrapolated with
//! the last velocities, if no overlap there is deep. In a cell whose lengths change it is the state to which its flow
//! leads. Otherwise it is the state at the beginning of the step.

use super::Setup;
use super::narrow_phase::Report;
use super::start::{Part, Stages};
use super::states::Poses;
use crate::backend::cpu::first::DEEPEST_AHEAD;
use crate::gpu::{Buffer, Recorder};

impl Setup {
    /// Whether first rows may be made where the last velocities lead.
    pub fn leads_ahead(&self) -> bool {
        self.planar
            && self.branches > 0
            && !self.midpoint
            && !self.inertia()
            && self.heat.is_none()
            && self.strain.is_none()
    }
}

/// Where first rows are made.
#[derive(Default)]
pub(super) struct First {
    /// Whether those of the start are made where the last velocities lead.
    pub ahead: bool,
    /// The deepest overlap where they were made.
    pub overlap: f64,
}

impl First {
    /// Whether first rows of a part are made where the last velocities lead.
    pub fn is_ahead(&self, part: Part) -> bool {
        self.ahead && part != Part::FromMiddle
    }

    /// Where first rows of the present part are made.
    pub fn poses<'a>(&self, stages: Stages<'a>) -> &'a Poses {
        let Stages { setup, states, start, .. } = stages;
        states.first(start.part, self.is_ahead(start.part) || setup.strain.is_some())
    }

    /// Whether bodies overlap so deeply ahead that normals there may point to the wrong side.
    pub fn is_led_astray(&self, setup: &Setup, part: Part, found: &Report) -> bool {
        self.is_ahead(part) && f64::from(f32::from_bits(found.worst)) > DEEPEST_AHEAD * setup.thinnest
    }

    /// Records where first rows are made, and with which velocities bodies come there.
    pub fn record(&self, stages: Stages<'_>, record: &mut Recorder<'_>, motions: &Buffer) {
        self.record_carried(stages, record, motions);
        let kernel = stages.kernels.branches.as_ref().and_then(|kernels| kernels.ahead.as_ref());
        let (Some(kernel), true) = (kernel, self.is_ahead(stages.start.part)) else { return };
        let (start, ahead, bodies) = (stages.states.start(), self.poses(stages), stages.start.bodies);
        let buffers = [
            ("cells", &start.cells),
            ("remainders", &start.remainders),
            ("orientations", &start.orientations),
            ("twists", &start.twists),
            ("motions", motions),
            ("ahead_cells", &ahead.cells),
            ("ahead_remainders", &ahead.remainders),
            ("ahead_orientations", &ahead.orientations),
        ];
        record.run(kernel, &stages.timed([bodies as u32, 0, 0, 0]), &buffers, bodies);
    }

    /// Records where the flow of a changing cell leads bodies.
    fn record_carried(&self, stages: Stages<'_>, record: &mut Recorder<'_>, motions: &Buffer) {
        let Stages { setup, kernels, .. } = stages;
        let (Some(kernel), Some(strain)) = (&kernels.carried, &setup.strain) else { return };
        let (start, ahead, bodies) = (stages.states.start(), self.poses(stages), stages.start.bodies);
        let buffers = [
            ("cells", &start.cells),
            ("remainders", &start.remainders),
            ("orientations", &start.orientations),
            ("motions", motions),
            ("ahead_cells", &ahead.cells),
            ("ahead_remainders", &ahead.remainders),
            ("ahead_orientations", &ahead.orientations),
        ];
        let rates = setup.precision.encode(strain.rates(stages.start.time).to_array());
        let parameters = [stages.timed([bodies as u32, 0, 0, 0]), rates].concat();
        record.run(kernel, &parameters, &buffers, bodies);
    }
}
