//! Brownian motion on the device: its kernel writes random loads into the array of those that the host computes.

use super::source::{base, damped};
use super::{Device, Setup};
use crate::dynamics::{Dynamics, draw};
use crate::gpu::{Buffer, Gpu, GpuError, Kernel, Recorder, Source, fragment};
use crate::shape::gpu::add_shapes_to;

/// The kernel of random loads; none where the scene has no heat.
pub(super) fn source(setup: &Setup) -> Option<Source> {
    let heat = setup.heat?;
    let [seed_low, seed_high] = draw::halves(heat.seed);
    let source = add_shapes_to(base(setup, "heat"))
        .integer("SEED_LOW", seed_low)
        .integer("SEED_HIGH", seed_high)
        .integer("BLOCK_SHIFT", draw::BLOCK_SHIFT)
        .integer("MULTIPLIER_0", draw::MULTIPLIERS[0])
        .integer("MULTIPLIER_1", draw::MULTIPLIERS[1])
        .integer("KEY_STEP_0", draw::KEY_STEPS[0])
        .integer("KEY_STEP_1", draw::KEY_STEPS[1])
        .real("TEMPERATURE", heat.thermal.temperature)
        .include(fragment!("dynamics/draw.wgsl"));
    let source = match heat.dynamics {
        Dynamics::Overdamped { drag } => source.real("DRAG", drag).include(fragment!("dynamics/heat_overdamped.wgsl")),
        // Without drag there is no random load; validation refuses such a scene.
        Dynamics::Inertial { density, drag } => {
            damped(source, density, drag.unwrap_or(0.0)).include(fragment!("dynamics/heat_damped.wgsl"))
        }
    };
    Some(source.include(fragment!("dynamics/heat.wgsl")))
}

/// The ids of the bodies, which their random numbers belong to.
pub(super) struct Ids {
    buffer: Buffer,
    /// What the buffer holds.
    written: Vec<[u32; 2]>,
}

impl Ids {
    /// Those of a scene; none where it has no heat.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Option<Self>, GpuError> {
        let made = |_| Ok(Ids { buffer: Buffer::new(gpu, "ids", 8, 1)?, written: Vec::new() });
        setup.heat.map(made).transpose()
    }
}

impl Device {
    /// Writes the ids of the present bodies where they have changed, and makes room for their loads.
    pub(super) fn write_ids(&mut self) -> Result<(), GpuError> {
        let (gpu, bodies) = (self.gpu.clone(), self.bodies);
        let Some(ids) = &mut self.ids else { return Ok(()) };
        self.loads.reserve(&gpu, bodies)?;
        let words: Vec<[u32; 2]> = self.ancestry.lineage.iter().map(|line| draw::halves(line.id)).collect();
        if words != ids.written {
            ids.buffer.reserve(&gpu, bodies)?;
            ids.buffer.write(&gpu, 0, bytemuck::cast_slice(&words));
            ids.written = words;
        }
        Ok(())
    }

    /// Records the random loads of the step, beside those that the host has written where it has.
    pub(super) fn record_heat(&self, record: &mut Recorder<'_>) {
        let (Some(heat), Some(ids)) = (&self.kernels.heat, &self.ids) else { return };
        let heat: &Kernel = heat;
        let [low, high] = draw::halves(self.step + 1);
        let parameters = self.timed([self.bodies as u32, u32::from(!self.plugged.is_empty()), low, high]);
        let (here, shapes) = (self.here(), self.here_shapes());
        let buffers = [
            ("ids", &ids.buffer),
            ("shapes", &shapes.shapes),
            ("orientations", &here.orientations),
            ("loads", &self.loads),
        ];
        record.run(heat, &parameters, &buffers, self.bodies);
    }
}
