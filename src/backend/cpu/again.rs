//! Repeats failed steps on the CPU, also for a device.

use super::Cpu;
use super::team::Team;
use crate::dynamics::{ForceField, Waiting};
use crate::lcp::Outcome;
use crate::step::{Crowd, Fault, Piece, RetryBackend, Shake, State, Wedge, max_overlap_but};
use std::collections::{BTreeSet, HashSet};

impl<const D: usize, T: Team> Cpu<D, T> {
    /// Takes over forces beside the scene's own; [`Cpu::give_forces`] returns them.
    pub fn lend_forces(&mut self, forces: &mut Vec<Box<dyn ForceField>>) {
        self.setup.forces.append(forces);
    }

    /// Returns the last `count` forces.
    pub fn give_forces(&mut self, count: usize) -> Vec<Box<dyn ForceField>> {
        self.setup.forces.split_off(self.setup.forces.len() - count)
    }

    /// The state, for a device to continue from.
    pub fn into_state(self) -> State {
        self.state
    }
}

impl<const D: usize, T: Team> RetryBackend for Cpu<D, T> {
    fn prepare(&mut self, piece: Piece, waiting: &Waiting) {
        self.next = Some((piece, waiting.clone()));
    }

    fn part(&mut self, parting: bool) {
        self.start.parting = parting;
    }

    fn shake(&mut self, shake: Option<Shake>) {
        self.start.shake = shake;
    }

    fn bounce(&mut self, bouncing: bool) {
        self.start.without_restitution = !bouncing;
    }

    fn set_multipliers(&mut self, gamma: &[f64]) {
        let own = self.rows.change_gamma();
        own.fill(0.0);
        own.iter_mut().zip(gamma).for_each(|(own, gamma)| *own = *gamma);
    }

    fn regularize(&mut self, compliance: f64) -> Result<Outcome, Fault> {
        Ok(self.solve.relax_by(&mut self.rows, compliance))
    }

    fn crowded(&self, crowd: Crowd) -> Vec<u64> {
        let bodies: BTreeSet<u32> = match crowd {
            Crowd::Wedged => self.find_wedge().bodies.into_iter().map(|body| body as u32).collect(),
            Crowd::Overlapping => {
                let tolerance = self.setup.overlap_tolerance;
                let over = self.trial.overlapping.iter().filter(|near| near.found.separation < -tolerance);
                over.flat_map(|near| near.pair).collect()
            }
            Crowd::Pressed => self.rows.pushing_rows().flat_map(|(pair, _)| *pair).collect(),
        };
        let before: HashSet<u64> = self.state.bodies.lineage.iter().map(|line| line.id).collect();
        let mother = |line: &crate::bodies::Lineage| match line.parent {
            Some(parent) if !before.contains(&line.id) => parent,
            _ => line.id,
        };
        // The surfaces of walls come after all bodies.
        let lines = bodies.into_iter().filter_map(|body| self.start.bodies.lineage.get(body as usize));
        lines.map(mother).collect::<BTreeSet<u64>>().into_iter().collect()
    }

    fn wedge(&self) -> Wedge {
        self.find_wedge()
    }

    fn has_births(&self) -> bool {
        self.start.next_id > self.state.next_id
    }

    fn start_overlap(&self) -> f64 {
        self.first.overlap
    }

    fn rest_overlap(&self) -> f64 {
        let bodies = &self.state.bodies;
        let stretch = self.setup.bonds.rigid_stretch(bodies);
        max_overlap_but(&self.setup.fixed, bodies, self.start.walls_before().unwrap_or(&self.setup.walls)).max(stretch)
    }
}
