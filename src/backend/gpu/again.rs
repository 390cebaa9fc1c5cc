//! A step that fails on the device is taken by the CPU, in f64, from the state that the device had accepted; the device
//! goes on from the state that it leaves.
//!
//! It costs the state's way to the host and back, and happens where the CPU would cut the step into pieces, or where
//! the device's numbers or its solver, which has no factorization, end before the tolerance.

use super::unrounded::unrounded;
use super::{Ancestry, Device};
use crate::backend::cpu::Cpu;
use crate::gpu::GpuError;
use crate::step::{Failed, Fault, State, Take};
use glam::DVec3;
use std::sync::OnceLock;

impl Device {
    pub(super) fn take_on_cpu<const D: usize>(&mut self, take: &mut Take<'_>) -> Result<(), Fault> {
        let mut state = self.known_state()?.clone();
        // The step that failed has changed normals, except where the state was read before it.
        state.warm.retain(|warm| warm.gamma > 0.0);
        state.warm.iter_mut().for_each(|warm| warm.normal = DVec3::ZERO);
        self.gpu.rest();
        let mut cpu = Cpu::<D>::new(&self.model, state)?;
        let plugged = self.plugged.len();
        cpu.lend_forces(&mut self.plugged);
        let taken = take(&mut cpu, Failed::OnDevice);
        self.plugged = cpu.give_forces(plugged);
        // After a fault the device still holds the last accepted state, to the last bit.
        taken?;
        Ok(self.load(cpu.into_state())?)
    }

    /// Goes on from a state of this scene.
    pub(super) fn load(&mut self, state: State) -> Result<(), GpuError> {
        let (gpu, bodies) = (self.gpu.clone(), state.bodies.len() as u64);
        let mut record = gpu.record();
        self.states.reserve(&gpu, &mut record, bodies)?;
        record.submit()?;
        let unrounded = unrounded(&self.setup, &state)?;
        self.states.write(&gpu, &self.setup, &state.bodies.shape, &unrounded);
        self.ancestry = Ancestry::of(&self.setup, &state, unrounded.prescribed());
        if let Some(bonds) = &self.bonds {
            bonds.write_broken(&gpu, &self.setup, &state.bodies.broken_bonds);
        }
        self.removed.clone_from(&state.removed);
        if let Some(held) = &mut self.held {
            held.write(&gpu, &self.model.fixed.flags(&state.bodies))?;
        }
        self.growth.write_changed(&gpu, &self.setup, &mut self.ancestry)?;
        self.groups_of.reserve(&gpu, bodies)?;
        self.groups_of.write(&gpu, 0, bytemuck::cast_slice(&self.ancestry.group));
        (self.bodies, self.accepted_bodies, self.step) = (bodies, bodies, state.step);
        self.part = self.setup.first_part();
        self.setup.periods = state.bodies.periods;
        self.candidates.forget(state.warm);
        // What is known of the state from now on is what the device holds.
        self.state = OnceLock::new();
        Ok(())
    }
}
