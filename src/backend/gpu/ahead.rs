//! Where first rows are made: in the plane a part of a step ahead, where the last velocities lead, if no overlap there
//! is deep; in a cell whose lengths change where its flow leads; else where the step begins.

use super::midpoint::Part;
use super::separations::Report;
use super::states::Poses;
use super::{Device, Setup};
use crate::backend::cpu::first::DEEPEST_AHEAD;
use crate::gpu::Recorder;

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

impl Device {
    /// Where first rows are made.
    pub(super) fn first(&self) -> &Poses {
        self.states.first(self.part, self.leads())
    }

    /// Whether that is elsewhere than the present part begins.
    pub(super) fn leads(&self) -> bool {
        self.is_ahead() || self.setup.strain.is_some()
    }

    /// Whether first rows of the present part are made ahead of its start.
    pub(super) fn is_ahead(&self) -> bool {
        self.ahead && self.part != Part::FromMiddle
    }

    /// Records where the flow of a changing cell leads bodies.
    fn record_carried(&self, record: &mut Recorder<'_>) {
        let (Some(kernel), Some(strain)) = (&self.kernels.carried, &self.setup.strain) else { return };
        let (start, ahead) = (self.start(), self.first());
        let buffers = [
            ("cells", &start.cells),
            ("remainders", &start.remainders),
            ("orientations", &start.orientations),
            ("motions", &self.motions),
            ("ahead_cells", &ahead.cells),
            ("ahead_remainders", &ahead.remainders),
            ("ahead_orientations", &ahead.orientations),
        ];
        let rates = self.setup.precision.encode(strain.rates(self.step_start()).to_array());
        let parameters = [self.timed([self.bodies as u32, 0, 0, 0]), rates].concat();
        record.run(kernel, &parameters, &buffers, self.bodies);
    }

    /// Records the poses ahead, and that bodies come there with their last velocities.
    pub(super) fn record_ahead(&self, record: &mut Recorder<'_>) {
        self.record_carried(record);
        let kernel = self.kernels.branches.as_ref().and_then(|kernels| kernels.ahead.as_ref());
        let (Some(kernel), true) = (kernel, self.is_ahead()) else { return };
        let (start, ahead) = (self.start(), self.first());
        let buffers = [
            ("cells", &start.cells),
            ("remainders", &start.remainders),
            ("orientations", &start.orientations),
            ("twists", &start.twists),
            ("motions", &self.motions),
            ("ahead_cells", &ahead.cells),
            ("ahead_remainders", &ahead.remainders),
            ("ahead_orientations", &ahead.orientations),
        ];
        record.run(kernel, &self.timed([self.bodies as u32, 0, 0, 0]), &buffers, self.bodies);
    }

    /// Whether bodies overlap so deeply ahead that normals there may point to the wrong side.
    pub(super) fn is_led_astray(&self, found: &Report) -> bool {
        self.is_ahead() && f64::from(f32::from_bits(found.worst)) > DEEPEST_AHEAD * self.setup.thinnest
    }
}
