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
use crate::bodies::{Bodies, HeldBond};
use crate::constraint::{Row, RowSourceError};
use crate::dynamics::bonds::Bonds;
use crate::dynamics::bonds::daughters::{bonds_of, is_parted};
use crate::dynamics::{Bond, BondName, Cells, Motion};
use crate::freedom::{PLANAR, SPATIAL};
use crate::gpu::Precision;
use crate::lcp::{Alone, Outcome, PackedContacts, Problem};
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
    /// What these contacts have beside their normal rows, for a solve on the device. None if there are other rows, or
    /// no friction.
    fn packed(&self, contacts: &[usize]) -> Option<PackedContacts>;
    /// Takes over the multipliers of these contacts from a solve to a tolerance on the device.
    fn take_solved(&mut self, contacts: &[usize], gammas: &[f64], outcome: &Outcome, tolerance: f64);
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
    /// Ends a step with the trial, and returns what breaks.
    fn accept(&mut self) -> Broken;
    /// The forces and torques of implicit bonds at the end of the last step, by number.
    fn pulls(&self) -> &BTreeMap<usize, [DVec3; 2]>;
    /// The bonds of daughters that hold in the state `bodies` after the last step.
    fn held_daughters(&self, bodies: &Bodies) -> Vec<HeldBond>;
    /// What contacts ended the last step with, sorted by pair and feature.
    fn warm(&self) -> &[Warm];
    /// Continues from another state.
    fn load(&mut self, state: &State);
    /// The present problem and its multipliers, for diagnosis and tests.
    fn lcp(&self) -> (Problem<SPATIAL>, Vec<f64>);
}

/// The implicit bonds that break at the end of a step.
#[derive(Default)]
pub struct Broken {
    /// Those of the scene, by number.
    pub of_scene: Vec<u32>,
    /// The bodies of those of daughters: the one that is bonded at its upper end, then the other.
    pub of_daughters: Vec<[usize; 2]>,
}

/// Whether the host has a part in the steps of a scene on a device.
pub fn is_hosted(model: &Model) -> bool {
    let daughters = model.cells.as_ref().is_some_and(Cells::bond_daughters);
    let bonds = daughters || model.bonds.first_implicit().is_some() || model.bonds.any_without_contact();
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
    /// The bonds of daughters of the last step, and the number of each.
    daughters: (Bonds, Vec<usize>),
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
        let mut own =
            OnHost { cpu, precision, normals: Vec::new(), pulls: BTreeMap::new(), daughters: Default::default() };
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

    fn packed(&self, contacts: &[usize]) -> Option<PackedContacts> {
        let rows = &self.cpu.rows;
        if rows.bonded() > 0 || !rows.is_frictional() {
            return None;
        }
        let mut packed = PackedContacts::default();
        for contact in contacts {
            packed.push(&rows.problem, &rows.gamma, self.normals[*contact]);
        }
        Some(packed)
    }

    fn take_solved(&mut self, contacts: &[usize], gammas: &[f64], outcome: &Outcome, tolerance: f64) {
        let Cpu { solve, rows, .. } = &mut self.cpu;
        for (contact, found) in contacts.iter().zip(gammas.chunks_exact(4)) {
            rows.take_multipliers(self.normals[*contact], found);
        }
        solve.take_solved(outcome, tolerance);
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

    fn accept(&mut self) -> Broken {
        let Cpu { setup, start, rows, trial, .. } = &mut self.cpu;
        // Normals are the device's.
        let warm = rows.warm_start(&Pairs::default(), &trial.scaled);
        self.pulls = pulls(rows);
        let before = start.bodies.broken_bonds.clone();
        let mut end = std::mem::take(&mut start.bodies);
        let of_daughters = start.break_bonds(setup, rows, &mut end);
        let first = setup.bonds.list().len();
        self.daughters = (start.daughters().clone(), (first..).take(start.daughters().list().len()).collect());
        self.set_warm(&warm);
        end.broken_bonds.retain(|bond| before.binary_search(bond).is_err());
        Broken { of_scene: end.broken_bonds, of_daughters }
    }

    fn pulls(&self) -> &BTreeMap<usize, [DVec3; 2]> {
        &self.pulls
    }

    fn held_daughters(&self, bodies: &Bodies) -> Vec<HeldBond> {
        let (bonds, numbers) = &self.daughters;
        let list = bonds.list().iter().zip(numbers).enumerate();
        let held = |(at, (bond, number)): (usize, (&Bond, &usize))| {
            let held = bonds.as_held(at, bond.bodies, bodies, self.pulls.get(number).copied());
            HeldBond { number: *number as u32, ..held }
        };
        list.filter(|(_, (bond, _))| !is_parted(bodies, bond.bodies)).map(held).collect()
    }

    fn warm(&self) -> &[Warm] {
        &self.cpu.state.warm
    }

    fn load(&mut self, state: &State) {
        self.set_warm(&state.warm);
        let (bodies, setup) = (&state.bodies, &self.cpu.setup);
        self.pulls = bodies.bonds.iter().map(|of| (of.number as usize, [of.force, of.torque])).collect();
        let cells = setup.growth.as_ref().filter(|cells| cells.bond_daughters());
        let bonds = cells.map_or_else(Bonds::default, |cells| bonds_of(bodies, cells));
        // The numbers that they had in the step before, some of whose bonds broke.
        let first = setup.bonds.list().len();
        let number = |(at, bond): (usize, &Bond)| {
            let pair = bond.bodies.map(|body| body as u32);
            let held = bodies.bonds.iter().find(|of| of.bodies == pair && of.number as usize >= first);
            held.map_or(first + at, |of| of.number as usize)
        };
        let numbers = bonds.list().iter().enumerate().map(number).collect();
        self.daughters = (bonds, numbers);
    }

    fn lcp(&self) -> (Problem<SPATIAL>, Vec<f64>) {
        let Problem { bodies, pair, jacobian, q, cones, compliance } = self.cpu.rows.problem.clone();
        let block = |block: &[f64; D]| std::array::from_fn(|k| block.get(k).copied().unwrap_or(0.0));
        let jacobian = jacobian.iter().map(|blocks| blocks.each_ref().map(block)).collect();
        (Problem { bodies, pair, jacobian, q, cones, compliance }, self.cpu.rows.gamma.clone())
    }
}
