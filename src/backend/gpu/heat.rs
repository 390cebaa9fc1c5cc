//! Brownian motion on the device. Its kernel writes random loads into the array of the loads that the host computes.

use super::Setup;
use super::source::{base, damped, dragged};
use super::start::Stages;
use super::states::{Poses, Shapes};
use crate::bodies::Lineage;
use crate::dynamics::{Drag, Dynamics, draw};
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, Source, fragment, functions};
use crate::shape::gpu::add_shapes_to;

functions! {
    pub(super) RandomLoads = struct RandomLoadsArgs<'a> {
        adds: bool, step_low: u32, step_high: u32, stages: Stages<'a>, ids: &'a Buffer, shapes: &'a Shapes,
        here: &'a Poses, loads: &'a Buffer,
    }
}

/// The kernel of random loads; `None` for a scene without Brownian motion.
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
        Dynamics::Overdamped { drag } => dragged::heated(source, drag),
        // Without drag there are no random loads; validation rejects such a scene.
        Dynamics::Inertial { density, drag } => {
            let drag = drag.unwrap_or(Drag::Even(0.0));
            dragged::heated_with_inertia(damped(source, density, drag), drag)
        }
    };
    Some(dragged::of_heat(setup, source.include(fragment!("dynamics/heat.wgsl"))))
}

/// The ids of the bodies, which select their random numbers.
pub(super) struct Ids {
    buffer: Buffer,
    /// The contents of the buffer.
    written: Vec<[u32; 2]>,
    kernel: RandomLoads,
}

impl Ids {
    /// The buffer for a scene; `None` without Brownian motion.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Option<Self>, GpuError> {
        let Some(source) = source(setup) else { return Ok(None) };
        let (buffer, kernel) = (Buffer::new(gpu, "ids", 8, 1)?, RandomLoads::make(gpu, source)?);
        Ok(Some(Ids { buffer, written: Vec::new(), kernel }))
    }

    /// Writes the ids of the present bodies if they have changed.
    pub fn write(&mut self, gpu: &Gpu, lineage: &[Lineage]) -> Result<(), GpuError> {
        let words: Vec<[u32; 2]> = lineage.iter().map(|line| draw::halves(line.id)).collect();
        if words != self.written {
            self.buffer.reserve(gpu, words.len() as u64)?;
            self.buffer.write(gpu, 0, bytemuck::cast_slice(&words));
            self.written = words;
        }
        Ok(())
    }

    /// Records the random loads of the step. With `adds`, they are added to loads that the host has written.
    pub fn record(&self, stages: Stages<'_>, record: &mut Recorder<'_>, loads: &Buffer, adds: bool) {
        let [step_low, step_high] = draw::halves(stages.start.step);
        let (ids, shapes, here) = (&self.buffer, stages.here_shapes(), stages.here());
        let warmed = RandomLoadsArgs { adds, step_low, step_high, stages, ids, shapes, here, loads };
        self.kernel.call(record, stages.start.bodies, warmed);
    }
}
