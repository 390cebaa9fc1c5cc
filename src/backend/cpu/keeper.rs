//! The state that the CPU keeps, and the steps that it takes.

use super::Cpu;
use super::team::Team;
use crate::bodies::{Bodies, Lineage};
use crate::dynamics::ForceField;
use crate::fields::Concentration;
use crate::gpu::{Gpu, Precision};
use crate::step::{Divided, Fault, Keep, Keeper, LIFE_WORDS, Lives, Plan, State, StepReport, Stepper, step};

impl<const D: usize, T: Team> Keeper for Cpu<D, T> {
    fn steps(&self) -> u64 {
        self.state.step
    }

    fn bodies(&self) -> usize {
        self.team.body_count(self.state.bodies.len())
    }

    fn state(&self) -> Result<&State, Fault> {
        Ok(self.team.whole_state(&self.setup, &self.state))
    }

    fn restore(&mut self, state: &State) -> Result<(), Fault> {
        self.state.clone_from(state);
        self.state.unrounded = None;
        self.team.reset();
        (self.next, self.start.parting, self.start.shake) = (None, false, None);
        Ok(())
    }

    fn add_force(&mut self, force: Box<dyn ForceField>) {
        self.setup.forces.push(force);
    }

    fn take_forces(&mut self) -> Vec<Box<dyn ForceField>> {
        self.setup.forces.split_off(self.setup.scene_forces)
    }

    fn all_bodies(&self) -> Result<&Bodies, Fault> {
        Ok(self.team.all_bodies(&self.state.bodies))
    }

    fn known_bodies(&self) -> Option<&Bodies> {
        self.team.known_bodies(&self.state.bodies)
    }

    fn local_bodies(&self) -> Result<&Bodies, Fault> {
        Ok(&self.state.bodies)
    }

    fn lives(&self) -> Result<Lives<'_>, Fault> {
        Ok(self.team.lives(&self.state.bodies))
    }

    fn divided(&mut self, before: &[Lineage]) -> Result<Vec<Divided>, Fault> {
        Ok(self.team.divided(&self.state.bodies, before))
    }

    fn all_gather(&self, own: Vec<[u64; LIFE_WORDS]>) -> Vec<[u64; LIFE_WORDS]> {
        self.team.all_gather(own)
    }

    fn set_fields(&mut self, fields: Vec<Concentration>) {
        self.state.fields = fields;
    }

    fn remove(&mut self, keep: &[bool], removed: &[u64]) -> Result<(), Fault> {
        self.team.remove(&mut self.state, keep, removed);
        Ok(())
    }
}

impl<const D: usize, T: Team> Stepper for Cpu<D, T> {
    fn step(&mut self, plan: &Plan, keep: &mut Keep) -> Result<StepReport, Fault> {
        self.team.announce_step();
        let stepped = loop {
            let stepped = step(self, plan, keep);
            if stepped.is_ok() || !self.team.needs_retry() {
                break stepped;
            }
        };
        self.team.check_agreement(stepped)
    }

    fn device(&self) -> Option<&Gpu> {
        None
    }

    fn precision(&self) -> Precision {
        Precision::F64
    }
}
