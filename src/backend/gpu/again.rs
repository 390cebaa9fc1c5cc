//! If a step fails on the device, the CPU takes it, in f64, from the state that the device had accepted. The device
//! continues from the resulting state.
//!
//! This copies the state to the host and back. It happens where the CPU would divide the step into pieces, or where the
//! precision of the device or its solver, which has no factorization, does not reach the tolerance.

use super::Device;
use super::keeper::Accepted;
use super::unrounded::unrounded;
use crate::backend::cpu::Cpu;
use crate::gpu::GpuError;
use crate::step::{Failed, Fault, State, Take};
use glam::DVec3;

impl Device {
    pub(super) fn take_on_cpu<const D: usize>(&mut self, take: &mut Take<'_>) -> Result<(), Fault> {
        let mut state = self.known_state()?.clone();
        // The failed step has changed normals, unless the state was read before it.
        state.warm.retain(|warm| warm.gamma > 0.0);
        state.warm.iter_mut().for_each(|warm| warm.normal = DVec3::ZERO);
        self.gpu.rest();
        let mut cpu = Cpu::<D>::new(&self.model, state)?;
        let plugged = self.motions.plugged.len();
        cpu.lend_forces(&mut self.motions.plugged);
        let taken = take(&mut cpu, Failed::OnDevice);
        self.motions.plugged = cpu.give_forces(plugged);
        // After a fault the device still holds the last accepted state, to the last bit.
        taken?;
        Ok(self.load(cpu.into_state())?)
    }

    /// Continues from a state of this scene.
    pub(super) fn load(&mut self, state: State) -> Result<(), GpuError> {
        let Device { gpu, setup, model, states, start, motions, narrow, accepted, hosted, .. } = self;
        let mut record = gpu.record();
        states.reserve(gpu, &mut record, state.bodies.len() as u64)?;
        record.submit()?;
        let unrounded = unrounded(setup, &state)?;
        states.write(gpu, setup, &state.bodies.shape, &unrounded);
        if let Some(bonds) = &motions.bonds {
            bonds.write_broken(gpu, setup, &state.bodies.broken_bonds);
        }
        start.load(gpu, setup, model, &state, &unrounded)?;
        // From here on, the host knows only what the device stores.
        *accepted = Accepted::of(&state);
        if let Some(hosted) = hosted {
            hosted.load(&state);
        }
        narrow.candidates.forget(state.warm);
        Ok(())
    }
}
