//! Implicit bonds in a step: their rows, how far these are off at the trial, and which of them break.
//!
//! First rows are made where the last velocities lead, so that a bond that turns pulls in its direction at the step's
//! end to second order; where that is no good, at the start. A trial that is off by more than the overlap tolerance has
//! all rows made again there. Multipliers start from zero in each step.

use super::Cpu;
use super::first::First;
use super::friction::Making;
use super::row_set::{BondRows, RowSet};
use super::setup::Setup;
use super::start::Start;
use super::team::Team;
use crate::bodies::{Bodies, HeldBond};
use crate::constraint::bond::{Line, Stretch, lines};
use crate::constraint::{Mover, velocity};
use crate::dynamics::bonds::daughters::{is_parted, part};
use crate::dynamics::{self, BondName, Pose, Twist};
use crate::freedom::PLANAR;
use glam::DVec3;
use std::collections::BTreeMap;

/// First rows are made where the last velocities lead if a bond turns by less than 60 degrees on the way there, and its
/// length changes by less than a factor of two.
const LEAST_COSINE: f64 = 0.5;
const MOST_STRETCHED: f64 = 2.0;

/// The pulls of bonds that resist turns have their directions to this part: a chain of 50 rods that are rigid against
/// bends, with gaps of a twentieth of their length, ends at 2e-9 under its own weight at `dt` of 0.1, where the pulls
/// of its bends are 500 times its weight.
const DIRECTION: f64 = 1e-7;

/// Rows of bonds are made anew so often at the trial itself: most steps take fewer (docs/bonds.md).
const AT_THE_TRIAL: u32 = 24;
/// The part of the way is halved after so many more.
const HALVING: u32 = 12;

/// The part of the way from where rows of bonds were made last to the trial, where they are made anew after so many
/// times. Where a step is long for short bonds, the trial is as far on the other side of the solution each time.
fn part_of_way(renewals: u32) -> f64 {
    renewals.checked_sub(AT_THE_TRIAL).map_or(1.0, |more| 0.5_f64.powi(1 + (more / HALVING) as i32))
}

/// What a bond's rows and multipliers do.
struct Pull<const D: usize> {
    /// The force on the second body.
    force: DVec3,
    /// The torque on it about the bond's end there.
    couple: DVec3,
    /// What it moves the two bodies by in the scaled unknowns.
    moved: [[f64; D]; 2],
}

impl<const D: usize> Pull<D> {
    /// That of some of the rows.
    fn of(lines: &[Line<D>], gamma: &[f64]) -> Self {
        let mut pull = Pull { force: DVec3::ZERO, couple: DVec3::ZERO, moved: [[0.0; D]; 2] };
        for (line, gamma) in lines.iter().zip(gamma) {
            pull.force += *gamma * line.direction;
            pull.couple += *gamma * line.couple;
            let moved = pull.moved.as_flattened_mut().iter_mut();
            moved.zip(line.row.0.as_flattened()).for_each(|(moved, j)| *moved += gamma * j);
        }
        pull
    }
}

/// The forces of implicit bonds on their second bodies, and the torques about their ends there, by number.
pub(super) fn pulls<const D: usize>(rows: &RowSet<D>) -> BTreeMap<usize, [DVec3; 2]> {
    let pull = |(of, gamma): (&BondRows<D>, &[f64])| {
        let Pull { force, couple, .. } = Pull::of(&of.lines[..of.own], gamma);
        (of.bond, [force, couple])
    };
    rows.bonds().map(pull).collect()
}

impl<const D: usize> BondRows<D> {
    /// The sum of what its own rows move the bodies by in the scaled unknowns.
    fn size(&self, gamma: &[f64]) -> f64 {
        self.lines[..self.own].iter().zip(gamma).map(|(line, gamma)| gamma.abs() * line.square().sqrt()).sum()
    }

    /// By how much the bond with these rows at the trial, where its bodies have the scaled velocities `at`, is off its
    /// law, a length: the error of its length, and how far its pull is from one in its present direction. `before` are
    /// the rows that the multipliers belong to.
    fn error(&self, before: &BondRows<D>, gamma: &[f64], at: [&[f64; D]; 2]) -> f64 {
        let along = |line: &Line<D>| {
            let dot = |j: &[f64; D], v: &[f64; D]| j.iter().zip(v).map(|(j, v)| j * v).sum::<f64>();
            dot(&line.row.0[0], at[0]) + dot(&line.row.0[1], at[1])
        };
        let own = &self.lines[..self.own];
        let gap = |(line, gamma): (&Line<D>, &f64)| (line.row.1 + along(line) + line.compliance * gamma).abs();
        let gap = own.iter().zip(gamma).map(gap).fold(0.0, f64::max);
        let [was, is] = [Pull::of(&before.lines, gamma), Pull::of(own, gamma)];
        let aside = was.moved.as_flattened().iter().zip(is.moved.as_flattened()).map(|(a, b)| (a - b) * (a - b));
        let aside: f64 = aside.sum();
        let longest = own.iter().map(Line::square).fold(0.0, f64::max);
        let turned = (aside * longest).sqrt();
        // Bends of short bonds have large pulls against each other.
        let rounding = if self.turns { DIRECTION * before.size(gamma) * longest.sqrt() } else { 0.0 };
        gap.max(if turned > rounding { turned } else { 0.0 })
    }
}

impl Making<'_> {
    /// The rows of a bond with its bodies in these poses, where the velocities `reached` lead. `pull` is the force on
    /// the second body at the last solve.
    fn bond<const D: usize>(
        &self,
        (bond, pair): (usize, [usize; 2]),
        poses: [Pose; 2],
        reached: [Twist; 2],
        pull: DVec3,
    ) -> BondRows<D> {
        let Making { setup, start, motions, .. } = *self;
        let (bonds, number) = start.bonds_with(setup, bond);
        let of = &bonds.list()[number];
        let (arms, way) = bonds.between_poses(number, &start.periods, poses);
        let mut turns = bonds.turns(number, (poses, way), D == PLANAR);
        let mut compliance = Some(of.stiffness.recip());
        if start.parting {
            turns.retain(|turn| turn.compliance == 0.0);
            compliance = compliance.filter(|compliance| *compliance == 0.0);
        }
        let (resists, reach) = (bonds.resists_turns(number), bonds.reach(number));
        let stretch = Stretch { arms, way, length: of.length, compliance, turns, reach, pull };
        let mover = |end: usize| Mover { motion: &motions.motion[pair[end]], reached_with: reached[end], axis: None };
        let (lines, own) = lines(&stretch, [mover(0), mover(1)], start.interval);
        BondRows { bond, pair, lines, own, turns: resists }
    }

    /// The first rows of a bond.
    fn first_bond<const D: usize>(&self, held: (usize, [usize; 2]), first: &First) -> BondRows<D> {
        let Making { setup, start, .. } = *self;
        let (bond, pair) = held;
        let still = [Twist::default(); 2];
        let begin = pair.map(|i| start.pose(i));
        if setup.strain.is_some() && !start.parting {
            // Where the flow of the cell leads, as contacts.
            return self.bond(held, pair.map(|i| first.pose(i)), pair.map(|i| first.reached[i]), DVec3::ZERO);
        }
        if start.leads && setup.heat.is_none() {
            let last = pair.map(|i| if start.is_held(i) { Twist::default() } else { start.bodies.twist(i) });
            let there = [0, 1].map(|end| dynamics::advance(begin[end], last[end], start.interval));
            let (bonds, number) = start.bonds_with(setup, bond);
            let way = |poses| bonds.between_poses(number, &start.periods, poses).1;
            if leads_well(way(begin), way(there)) {
                return self.bond(held, there, last, DVec3::ZERO);
            }
        }
        self.bond(held, begin, still, DVec3::ZERO)
    }
}

/// Whether rows may be made where a bond is `there`.
fn leads_well(begin: DVec3, there: DVec3) -> bool {
    let (from, to) = (begin.length(), there.length());
    begin.dot(there) >= LEAST_COSINE * from * to && to <= MOST_STRETCHED * from && from <= MOST_STRETCHED * to
}

impl Start {
    /// What messages call a bond.
    fn name_of_bond(&self, setup: &Setup, bond: usize) -> BondName {
        if bond < setup.bonds.list().len() { setup.bonds.name(bond) } else { BondName::DAUGHTERS }
    }

    /// Whether the step that begins may use the last velocities, and which implicit bonds act in it.
    pub(super) fn hold(&mut self, setup: &Setup, leads: bool) {
        self.leads = leads;
        self.held_bonds = self.acting_bonds(setup);
    }
}

impl<const D: usize, T: Team> Cpu<D, T> {
    /// The first rows of all implicit bonds.
    pub(super) fn first_bonds(&self) -> Vec<BondRows<D>> {
        let Cpu { setup, start, motions, first, stick, .. } = self;
        let making = Making { setup, start, motions, stick: *stick };
        start.held_bonds.iter().map(|held| making.first_bond(*held, first)).collect()
    }

    /// Their rows where a body has this pose, to which this velocity leads.
    fn bonds_at(&self, place: impl Fn(usize) -> (Pose, Twist)) -> Vec<BondRows<D>> {
        let Cpu { setup, start, motions, stick, rows, .. } = self;
        let making = Making { setup, start, motions, stick: *stick };
        let again = |(of, gamma): (&BondRows<D>, &[f64])| {
            let BondRows { bond, pair, own, .. } = *of;
            let pull = Pull::of(&of.lines[..own], gamma).force;
            let places = pair.map(&place);
            making.bond((bond, pair), places.map(|(pose, _)| pose), places.map(|(_, twist)| twist), pull)
        };
        rows.bonds().map(again).collect()
    }

    /// Their rows at the trial.
    fn bonds_at_trial(&self) -> Vec<BondRows<D>> {
        self.bonds_at(|i| (self.trial.poses[i], self.trial.twist[i]))
    }

    /// By how much the worst implicit bond is off at the trial, a length; and which one it is.
    pub(super) fn stretch(&self) -> (f64, Option<(BondName, [usize; 2])>) {
        let scaled = &self.trial.scaled;
        let there = self.bonds_at_trial();
        let error = |(there, (of, gamma)): (&BondRows<D>, (&BondRows<D>, &[f64]))| {
            there.error(of, gamma, of.pair.map(|i| &scaled[i]))
        };
        let mut worst = (0.0, None);
        for (there, with) in there.iter().zip(self.rows.bonds()) {
            // Not a number is as bad as can be.
            let error = Some(error((there, with))).filter(|error| !error.is_nan()).unwrap_or(f64::INFINITY);
            if error > worst.0 {
                worst = (error, Some((self.start.name_of_bond(&self.setup, there.bond), there.pair)));
            }
        }
        worst
    }

    /// Makes the rows of all implicit bonds again at the trial, or on the way there.
    pub(super) fn make_bonds_again(&mut self) {
        let part = part_of_way(self.rows.renewals());
        let last = self.rows.take_bonds_made_at();
        let there = if part < 1.0 && last.len() == self.trial.twist.len() {
            let toward = |(from, to): (&Twist, &Twist)| Twist {
                linear: from.linear.lerp(to.linear, part),
                angular: from.angular.lerp(to.angular, part),
            };
            last.iter().zip(&self.trial.twist).map(toward).collect()
        } else {
            self.trial.twist.clone()
        };
        let rows = if part < 1.0 {
            self.bonds_at(|i| (dynamics::advance(self.start.pose(i), there[i], self.start.interval), there[i]))
        } else {
            self.bonds_at_trial()
        };
        self.rows.replace_bonds(rows);
        self.rows.set_bonds_made_at(there);
    }

    /// The velocity of a body as its free motion and bonds have it, without contact.
    pub(super) fn driven(&self, i: usize) -> Twist {
        let motion = &self.motions.motion[i];
        self.trial.bonded.get(i).map_or(motion.free, |scaled| velocity(motion, scaled, self.start.interval))
    }
}

impl Start {
    /// Breaks the implicit bonds that end the step with a tension over their strength, whose bodies are `end` then.
    /// Returns how many of them are of daughters.
    pub(super) fn break_bonds<const D: usize>(
        &self,
        setup: &Setup,
        rows: &RowSet<D>,
        end: &mut Bodies,
    ) -> Vec<[usize; 2]> {
        let breaks = |(of, gamma): &(&BondRows<D>, &[f64])| {
            let force = Pull::of(&of.lines[..of.own], gamma).force;
            let (bonds, number) = self.bonds_with(setup, of.bond);
            let bond = &bonds.list()[number];
            // A bond of some length may push.
            let tension = if bond.length > 0.0 { -gamma[0] } else { force.length() };
            bond.break_force.is_some_and(|most| tension > most)
        };
        let of_scene = setup.bonds.list().len();
        let (of_scene, of_daughters): (Vec<_>, Vec<_>) =
            rows.bonds().filter(breaks).map(|(of, _)| of).partition(|of| of.bond < of_scene);
        end.add_broken_bonds(of_scene.into_iter().map(|of| of.bond as u32).collect());
        let (of_daughters, count): (Vec<_>, _) = (of_daughters.into_iter().map(|of| of.pair).collect(), end.len());
        of_daughters.iter().for_each(|pair| part(&mut end.columns, count, *pair));
        of_daughters
    }

    /// The bonds that hold at the step's end, with bodies as they are then. Bonds of daughters keep the numbers that
    /// they had in the step.
    pub(super) fn held_after<const D: usize>(&self, setup: &Setup, rows: &RowSet<D>, end: &Bodies) -> Vec<HeldBond> {
        if setup.bonds.is_empty() && self.daughters().is_empty() {
            return Vec::new();
        }
        let pulls = pulls(rows);
        let mut held = setup.bonds.held(end, &pulls);
        let first = setup.bonds.list().len();
        let of_daughters = self.daughters().list().iter().enumerate();
        held.extend(of_daughters.filter(|(_, bond)| !is_parted(end, bond.bodies)).map(|(number, bond)| {
            let pull = pulls.get(&(first + number)).copied();
            let held = self.daughters().as_held(number, bond.bodies, end, pull);
            HeldBond { number: (first + number) as u32, ..held }
        }));
        held
    }
}
