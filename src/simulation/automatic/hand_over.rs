//! Hands a simulation's state over between the CPU and a device. What was in use stays idle beside what is in use, so
//! that kernels are compiled once.

use super::machines::Machines;
use super::{Auto, Automatic, Leg, Machine};
use crate::simulation::Simulation;
use crate::step::{Fault, State, StepReport};
use std::mem::replace;

/// A simulation and what tells its time.
struct OnMachines<'a> {
    simulation: &'a mut Simulation,
    automatic: &'a Automatic,
}

impl Auto {
    /// Takes a step of the simulation, on the machine that suits it.
    pub(in crate::simulation) fn step(&mut self, simulation: &mut Simulation) -> Result<StepReport, Fault> {
        let Auto { automatic, chooser } = self;
        chooser.step(&mut OnMachines { simulation, automatic })
    }
}

impl OnMachines<'_> {
    /// Goes on from a state on the machine that is idle, which is made where there is none.
    fn exchange(&mut self, state: State) -> Result<(), Fault> {
        let Simulation { scene, backend, idle, .. } = &mut *self.simulation;
        let mut next = match idle.take() {
            Some(mut idle) => {
                idle.restore(&state)?;
                idle
            }
            // A simulation begins on the CPU.
            None => self.automatic.open()?.backend(scene, state)?,
        };
        for force in backend.take_forces() {
            next.add_force(force);
        }
        *idle = Some(replace(backend, next));
        Ok(())
    }
}

impl Machines for OnMachines<'_> {
    fn now(&self) -> f64 {
        (self.automatic.clock)(self.simulation.machine())
    }

    fn steps(&self) -> u64 {
        self.simulation.steps()
    }

    fn bodies(&self) -> usize {
        self.simulation.bodies()
    }

    fn step(&mut self) -> Result<StepReport, Fault> {
        self.simulation.take_step()
    }

    fn finish(&mut self) -> Result<(), Fault> {
        match self.simulation.device() {
            Some(gpu) => Ok(gpu.wait()?),
            None => Ok(()),
        }
    }

    fn keep(&mut self) -> Result<(), Fault> {
        let Simulation { backend, idle, .. } = &mut *self.simulation;
        match idle {
            Some(idle) => idle.restore(backend.state()?),
            None => Ok(()),
        }
    }

    fn go_to(&mut self, machine: Machine) -> Result<(), Fault> {
        if self.simulation.machine() == machine {
            return Ok(());
        }
        let state = self.simulation.state()?.clone();
        self.exchange(state)
    }

    fn fall_back(&mut self, steps: u64) -> Result<(), Fault> {
        let Simulation { backend, idle, .. } = &mut *self.simulation;
        let Some(cpu) = idle.as_mut().filter(|idle| idle.device().is_none()) else { return Ok(()) };
        if cpu.steps() != steps {
            let state = backend.state()?;
            if state.step != steps {
                return Err(Fault::Device(crate::gpu::GpuError::Refused { message: "the state is gone".into() }));
            }
            cpu.restore(state)?;
        }
        for force in backend.take_forces() {
            cpu.add_force(force);
        }
        std::mem::swap(backend, cpu);
        // What failed is not used again.
        *idle = None;
        Ok(())
    }

    fn record(&mut self, leg: Leg) {
        self.simulation.record(leg);
    }
}
