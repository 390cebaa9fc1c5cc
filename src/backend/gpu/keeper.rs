//! The state that a device keeps, and the steps that it takes.

use super::Device;
use crate::bodies::{Bodies, Lineage};
use crate::dynamics::ForceField;
use crate::gpu::{Gpu, Precision};
use crate::step::{Divided, Fault, Keep, Keeper, LIFE_WORDS, Lives, Plan, State, StepReport, Stepper, step};

impl Keeper for Device {
    fn steps(&self) -> u64 {
        self.step
    }

    fn bodies(&self) -> usize {
        self.accepted_bodies as usize
    }

    fn state(&self) -> Result<&State, Fault> {
        Ok(self.known_state()?)
    }

    fn restore(&mut self, state: &State) -> Result<(), Fault> {
        let (mut state, time) = (state.clone(), self.model.time.after(state.step));
        state.bodies.periods = self.setup.strain.map_or(self.setup.periods, |strain| strain.periods(time));
        state.bodies.planar = self.setup.planar;
        Ok(self.load(state)?)
    }

    fn add_force(&mut self, force: Box<dyn ForceField>) {
        self.plugged.push(force);
    }

    fn all_bodies(&self) -> Result<&Bodies, Fault> {
        Ok(&self.known_state()?.bodies)
    }

    /// They would have to be read.
    fn known_bodies(&self) -> Option<&Bodies> {
        None
    }

    fn local_bodies(&self) -> Result<&Bodies, Fault> {
        Ok(&self.known_state()?.bodies)
    }

    fn lives(&self) -> Result<Lives<'_>, Fault> {
        Ok(Lives::of_all(&self.ancestry.lineage, &self.ancestry.group))
    }

    fn divided(&mut self, before: &[Lineage]) -> Result<Vec<Divided>, Fault> {
        Ok(Divided::between(before, &self.ancestry.lineage, &self.ancestry.group))
    }

    fn all_gather(&self, own: Vec<[u64; LIFE_WORDS]>) -> Vec<[u64; LIFE_WORDS]> {
        own
    }

    fn remove(&mut self, keep: &[bool], removed: &[u64]) -> Result<(), Fault> {
        let mut state = self.known_state()?.clone();
        self.ancestry.write_lengths(&mut state.bodies);
        state.remove(keep, removed);
        Ok(self.load(state)?)
    }
}

impl Stepper for Device {
    fn step(&mut self, plan: &Plan, keep: &mut Keep) -> Result<StepReport, Fault> {
        step(self, plan, keep)
    }

    fn device(&self) -> Option<&Gpu> {
        Some(&self.gpu)
    }

    fn precision(&self) -> Precision {
        self.setup.precision
    }
}
