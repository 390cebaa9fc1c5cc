//! The rows and solves of a device's steps that the host has: those of scenes with friction, restitution or implicit
//! bonds. The device finds the contacts, makes their normal rows and computes the trials. Here tangents and the rows of
//! bonds are added, as in the CPU's own steps, and the problem is solved in f64.

use super::Cpu;
use super::bonds::pulls;
use super::friction::{Making, Stick};
use super::narrow_phase::Near;
use super::pairs::Pairs;
use super::row_set::Contact;
use super::team::all_places;
use crate::bodies::Bodies;
use crate::constraint::{Row, RowSourceError};
use crate::dynamics::{BondName, Motion};
use crate::freedom::{PLANAR, SPATIAL};
use crate::gpu::Precision;
use crate::lcp::{Alone, Outcome, Problem};
use crate::separation::Separation;
use crate::step::{Effect, Fault, Model, State};
use crate::warm::Warm;
use glam::DVec3;
use std::collections::BTreeMap;

/// The work on a body is rounded by this many roundings of the device's numbers: those of the blocks of `J` of its
/// contacts, which lose momentum.
const ROUNDINGS_OF_WORK: f64 = 8.0;

/// The start of a step on a device.
pub struct DeviceStart {
    /// The steps that were taken before.
    pub steps: u64,
    /// The bodies with their lengths in this step, and by how much each has grown.
    pub bodies: Bodies,
    pub lengthened: Vec<f64>,
    /// Free velocities and mobilities.
    pub motion: Vec<Motion>,
}

/// A normal row that a device made.
pub struct DeviceRow {
    /// The second of the pair may be a surface of a wall.
    pub pair: [u32; 2],
    /// Which of the pair's contacts.
    pub feature: u32,
    pub found: Separation,
    /// The blocks of `J`; in the plane their first three numbers.
    pub blocks: [[f64; SPATIAL]; 2],
    pub offset: f64,
}

/// The host's part of a device's steps. Contacts are numbered in the order in which they are appended.
pub trait Hosted: Send {
    /// Begins a step.
    fn begin(&mut self, start: DeviceStart) -> Result<(), Fault>;
    /// The pairs that bonds keep from colliding in it, the lower body first, ascending.
    fn without_contact(&self) -> &[[u32; 2]];
    /// Makes the first contacts, at the start or where the last velocities lead, from their normal rows. `overlap` is
    /// the deepest overlap there. Returns whether offsets changed, since contacts bounce.
    fn make_first(&mut self, made: &[DeviceRow], ahead: bool, overlap: f64) -> bool;
    /// Appends contacts that were found at the trial.
    fn append(&mut self, made: &[DeviceRow]);
    /// The number of contacts, and of all rows.
    fn contacts(&self) -> usize;
    fn rows(&self) -> usize;
    /// The offset of a contact's normal row, and a new one.
    fn offset(&self, contact: usize) -> f64;
    fn set_offset(&mut self, contact: usize, offset: f64);
    /// Solves from the present multipliers.
    fn solve(&mut self, tolerance: f64) -> Outcome;
    /// Solves in the sense of the least overlap: see [`crate::step::Verbs::relax`].
    fn relax(&mut self, allowed: f64) -> Option<Outcome>;
    /// Computes the velocities of the present multipliers.
    fn set_trial(&mut self);
    /// The multiplier of a contact's normal row.
    fn multiplier(&self, contact: usize) -> f64;
    /// `J^T gamma` of a body at the trial; in the plane its first three numbers.
    fn velocity(&self, body: usize) -> [f64; SPATIAL];
    /// The effect of contact up to the trial, as [`crate::step::Verbs::effect`].
    fn effect(&self, gap: f64) -> Effect;
    /// By how much the worst implicit bond is off at the trial, a length; and which one it is.
    fn stretch(&self) -> (f64, Option<(BondName, [usize; 2])>);
    /// Makes the rows of implicit bonds again at the trial.
    fn renew_bonds(&mut self);
    /// Ends a step with the trial, and returns the implicit bonds that break.
    fn accept(&mut self) -> Vec<u32>;
    /// The forces and torques of implicit bonds at the end of the last step, by number.
    fn pulls(&self) -> &BTreeMap<usize, [DVec3; 2]>;
    /// What contacts ended the last step with, sorted by pair and feature.
    fn warm(&self) -> &[Warm];
    /// Continues from another state.
    fn load(&mut self, state: &State);
    /// The present problem and its multipliers, for diagnosis and tests.
    fn lcp(&self) -> (Problem<SPATIAL>, Vec<f64>);
}

/// Whether the host has a part in the steps of a scene on a device.
pub fn is_hosted(model: &Model) -> bool {
    let bonds = model.bonds.first_implicit().is_some() || model.bonds.any_without_contact();
    bonds || !model.friction.is_none() || !model.contact.restitution.is_none()
}

/// The host's part of the steps of a scene on a device of this precision; `None` if the device needs none.
///
/// # Errors
/// As [`Cpu::new`].
pub fn hosted(model: &Model, state: &State, precision: Precision) -> Result<Option<Box<dyn Hosted>>, RowSourceError> {
    if !is_hosted(model) {
        return Ok(None);
    }
    Ok(Some(match model.planar {
        true => Box::new(OnHost::<PLANAR>::new(model, state, precision)?),
        false => Box::new(OnHost::<SPATIAL>::new(model, state, precision)?),
    }))
}

struct OnHost<const D: usize> {
    cpu: Cpu<D>,
    precision: Precision,
    /// The normal row of each contact, counted from the first row after those of bonds.
    normals: Vec<usize>,
    pulls: BTreeMap<usize, [DVec3; 2]>,
}

impl DeviceRow {
    fn near(&self) -> Near {
        Near { pair: self.pair, feature: self.feature, found: self.found }
    }

    fn row<const D: usize>(&self) -> Row<D> {
        let block = |side: usize| std::array::from_fn(|k| self.blocks[side][k]);
        ([block(0), block(1)], self.offset)
    }
}

impl<const D: usize> OnHost<D> {
    fn new(model: &Model, state: &State, precision: Precision) -> Result<Self, RowSourceError> {
        let mut cpu = Cpu::<D>::new(model, state.clone())?;
        cpu.state.bodies = Bodies::default();
        let mut own = OnHost { cpu, precision, normals: Vec::new(), pulls: BTreeMap::new() };
        own.load(state);
        Ok(own)
    }

    /// The normal row of a contact.
    fn normal(&self, contact: usize) -> usize {
        self.cpu.rows.bonded() + self.normals[contact]
    }

    fn set_warm(&mut self, warm: &[Warm]) {
        let pushing = warm.iter().filter(|warm| self.pushes(warm));
        let kept = pushing.map(|warm| Warm { normal: DVec3::ZERO, ..*warm });
        self.cpu.state.warm = kept.collect();
        self.cpu.state.warm.sort_by_key(|warm| (warm.pair, warm.feature));
    }

    /// Whether a multiplier is not zero on the device.
    fn pushes(&self, warm: &Warm) -> bool {
        match self.precision {
            Precision::F32 => warm.gamma as f32 >= f32::MIN_POSITIVE,
            Precision::F64 => warm.gamma > 0.0,
        }
    }
}

impl<const D: usize> Hosted for OnHost<D> {
    fn begin(&mut self, begun: DeviceStart) -> Result<(), Fault> {
        let Cpu { setup, state, start, motions, pairs, stick, solve, .. } = &mut self.cpu;
        state.step = begun.steps;
        start.begin_on_device(setup, begun.steps, begun.bodies, begun.lengthened)?;
        motions.motion = begun.motion;
        pairs.remember(&state.warm);
        *stick = Stick::of(setup, start, &state.warm);
        solve.begin(all_places(setup, start), Alone);
        Ok(())
    }

    fn without_contact(&self) -> &[[u32; 2]] {
        self.cpu.start.without_contact()
    }

    fn make_first(&mut self, made: &[DeviceRow], ahead: bool, overlap: f64) -> bool {
        let Cpu { setup, start, first, .. } = &mut self.cpu;
        first.predict(setup, start, ahead);
        first.overlap = overlap;
        if !start.held_bonds.is_empty() {
            first.overlap = overlap.max(setup.bonds.rigid_stretch(&start.bodies));
        }
        let bonds = self.cpu.first_bonds();
        let Cpu { setup, start, motions, first, pairs, stick, rows, .. } = &mut self.cpu;
        rows.clear(start.bodies.len(), setup.walls.len(), stick.is_some());
        rows.replace_bonds(bonds);
        pairs.recall();
        let mut order: Vec<usize> = (0..made.len()).collect();
        order.sort_by_key(|at| (made[*at].pair, made[*at].feature));
        let near: Vec<Near> = order.iter().map(|at| made[*at].near()).collect();
        let recalled = pairs.multipliers(&near);
        self.normals.clear();
        self.normals.resize(made.len(), 0);
        let making = Making { setup, start, motions, stick: *stick };
        let mut bounced = false;
        for ((at, near), recalled) in order.into_iter().zip(&near).zip(recalled) {
            let mut contact: Contact<D> = making.contact_of(made[at].row(), near, &first.reached, recalled.tangent);
            if let Some(bounce) = start.bounce(setup, motions, near) {
                contact.normal.1 -= bounce.apart;
                rows.bounces(bounce);
                bounced = true;
            }
            self.normals[at] = rows.gamma.len() - rows.bonded();
            rows.append_first(near, &contact, recalled.gamma);
        }
        bounced
    }

    fn append(&mut self, made: &[DeviceRow]) {
        let Cpu { setup, start, motions, stick, rows, trial, .. } = &mut self.cpu;
        let making = Making { setup, start, motions, stick: *stick };
        for made in made {
            let near = made.near();
            let contact: Contact<D> = making.contact_of(made.row(), &near, &trial.twist, DVec3::ZERO);
            self.normals.push(rows.gamma.len() - rows.bonded());
            rows.append(&near, &contact, 0.0);
        }
    }

    fn contacts(&self) -> usize {
        self.normals.len()
    }

    fn rows(&self) -> usize {
        self.cpu.rows.gamma.len()
    }

    fn offset(&self, contact: usize) -> f64 {
        self.cpu.rows.problem.q[self.normal(contact)]
    }

    fn set_offset(&mut self, contact: usize, offset: f64) {
        let row = self.normal(contact);
        self.cpu.rows.set_offset(row, offset);
    }

    fn solve(&mut self, tolerance: f64) -> Outcome {
        let Cpu { solve, rows, .. } = &mut self.cpu;
        solve.solve(rows, tolerance)
    }

    fn relax(&mut self, allowed: f64) -> Option<Outcome> {
        let Cpu { solve, rows, .. } = &mut self.cpu;
        solve.relax(rows, allowed)
    }

    fn set_trial(&mut self) {
        let Cpu { start, motions, rows, trial, .. } = &mut self.cpu;
        trial.set_scaled(rows);
        rows.velocity_of_bonds(&mut trial.bonded);
        // The device names bodies whose velocity is not finite.
        let _ = trial.set(motions, start);
    }

    fn multiplier(&self, contact: usize) -> f64 {
        self.cpu.rows.gamma[self.normal(contact)]
    }

    fn velocity(&self, body: usize) -> [f64; SPATIAL] {
        let of_body = &self.cpu.trial.scaled[body];
        std::array::from_fn(|k| of_body.get(k).copied().unwrap_or(0.0))
    }

    fn effect(&self, gap: f64) -> Effect {
        let mut effect = self.cpu.find_effect(gap);
        if effect.energy_allowed.is_finite() {
            let twists = self.cpu.trial.twist.iter().enumerate().filter(|(i, _)| !self.cpu.start.is_held(*i));
            let work: f64 = twists.map(|(i, twist)| self.cpu.work(i, twist).abs()).sum();
            effect.energy_allowed += ROUNDINGS_OF_WORK * self.precision.epsilon() * work;
        }
        effect
    }

    fn stretch(&self) -> (f64, Option<(BondName, [usize; 2])>) {
        self.cpu.stretch()
    }

    fn renew_bonds(&mut self) {
        self.cpu.make_bonds_again();
    }

    fn accept(&mut self) -> Vec<u32> {
        let Cpu { setup, start, rows, trial, .. } = &mut self.cpu;
        // Normals are the device's.
        let warm = rows.warm_start(&Pairs::default(), &trial.scaled);
        self.pulls = pulls(rows);
        let before = start.bodies.broken_bonds.clone();
        let mut end = std::mem::take(&mut start.bodies);
        start.break_bonds(setup, rows, &mut end);
        self.set_warm(&warm);
        end.broken_bonds.retain(|bond| before.binary_search(bond).is_err());
        end.broken_bonds
    }

    fn pulls(&self) -> &BTreeMap<usize, [DVec3; 2]> {
        &self.pulls
    }

    fn warm(&self) -> &[Warm] {
        &self.cpu.state.warm
    }

    fn load(&mut self, state: &State) {
        self.set_warm(&state.warm);
        self.pulls = state.bodies.bonds.iter().map(|of| (of.number as usize, [of.force, of.torque])).collect();
    }

    fn lcp(&self) -> (Problem<SPATIAL>, Vec<f64>) {
        let Problem { bodies, pair, jacobian, q, cones, compliance } = self.cpu.rows.problem.clone();
        let block = |block: &[f64; D]| std::array::from_fn(|k| block.get(k).copied().unwrap_or(0.0));
        let jacobian = jacobian.iter().map(|blocks| blocks.each_ref().map(block)).collect();
        (Problem { bodies, pair, jacobian, q, cones, compliance }, self.cpu.rows.gamma.clone())
    }
}
