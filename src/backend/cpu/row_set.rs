//! The rows of a step, their multipliers, and the warm start for the next step. Those of bonds come first.

use super::narrow_phase::Near;
use super::pairs::Pairs;
use crate::constraint::bond::Line;
use crate::constraint::{self, Row, friction::Sliding};
use crate::dynamics::Twist;
use crate::lcp::{Cone, Problem};
use crate::walls::{in_rows, of_rows};
use crate::warm::Warm;
use glam::DVec3;
use rayon::prelude::*;

/// The rows of a contact: its normal row, and where it has friction its tangent rows.
#[derive(Clone, Copy)]
pub(super) struct Contact<const D: usize> {
    pub(super) normal: Row<D>,
    pub(super) sliding: Option<Sliding<D>>,
}

/// A contact that replaces all those of its branch, with the multiplier of its normal row.
pub(super) type NewContact<const D: usize> = (Near, Contact<D>, f64);

/// The rows of a contact with friction.
pub(super) struct FrictionCone {
    pub(super) normal: usize,
    pub(super) tangents: std::ops::Range<usize>,
    pub(super) mu: f64,
}

/// What friction needs of each row.
#[derive(Clone, Copy, Default)]
struct Acting {
    /// The tangent of a tangent row.
    tangent: DVec3,
    /// The multiplier that its contact ended the last step with.
    held: f64,
}

/// How far a contact that bounces is to part in the step, a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounce {
    pub(super) pair: [u32; 2],
    pub(super) feature: u32,
    pub(super) apart: f64,
}

/// A branch that pushes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Push {
    pub(super) pair: [u32; 2],
    pub(super) feature: u32,
    /// The sum of its rows' multipliers.
    pub(super) gamma: f64,
    /// By how much they move it, a length.
    pub(super) moved: f64,
}

/// A bond with its rows in a step.
#[derive(Clone, Debug)]
pub(super) struct BondRows<const D: usize> {
    pub(super) bond: usize,
    pub(super) pair: [usize; 2],
    /// Its rows, the further ones of its geometric stiffness last.
    pub(super) lines: Vec<Line<D>>,
    /// How many of them are its own.
    pub(super) own: usize,
    /// Whether it resists turns.
    pub(super) turns: bool,
}

/// A pass over fewer rows than this runs on one thread: a row takes some 10 ns.
const LEAST_ROWS_A_PASS: usize = 2_048;

/// The feature of rows of bonds.
const FEATURE_OF_BONDS: u32 = u32::MAX;

/// The LCP of a step with its multipliers. The rows of bonds come first, then first rows, sorted by pair and feature,
/// then those of violations.
#[derive(Clone)]
pub(super) struct RowSet<const D: usize> {
    pub(super) problem: Problem<D>,
    /// Which of its pair's contacts each row is of.
    pub(super) feature: Vec<u32>,
    pub(super) gamma: Vec<f64>,
    /// Whether rows or multipliers were made or moved since the last solve.
    changed: bool,
    /// Bodies of the step: in pairs of rows the surfaces of walls come after them.
    bodies: usize,
    /// Whether contacts may have friction.
    frictional: bool,
    /// Whether rows have cones: contacts may have friction, or there are implicit bonds. Without it the following lists
    /// are empty.
    coned: bool,
    /// The implicit bonds, and how many rows they have.
    bonds: Vec<BondRows<D>>,
    bonded: usize,
    /// How often the rows of bonds were made anew.
    renewals: u32,
    /// The velocities of all bodies that lead to where they were made anew last; empty before.
    bonds_made_at: Vec<Twist>,
    acting: Vec<Acting>,
    /// The normal rows of the first contacts.
    first: Vec<u32>,
    /// The first contacts that bounce, sorted by pair and feature.
    bounces: Vec<Bounce>,
}

impl<const D: usize> RowSet<D> {
    pub(super) fn new() -> Self {
        RowSet {
            problem: Problem::default(),
            feature: Vec::new(),
            gamma: Vec::new(),
            changed: true,
            bodies: 0,
            frictional: false,
            coned: false,
            bonds: Vec::new(),
            bonded: 0,
            renewals: 0,
            bonds_made_at: Vec::new(),
            acting: Vec::new(),
            first: Vec::new(),
            bounces: Vec::new(),
        }
    }

    pub(super) fn clear(&mut self, bodies: usize, surfaces: usize, frictional: bool) {
        constraint::clear(&mut self.problem, bodies + surfaces);
        (self.bodies, self.frictional, self.coned) = (bodies, frictional, frictional);
        self.bonds.clear();
        (self.bonded, self.renewals) = (0, 0);
        self.bonds_made_at.clear();
        self.feature.clear();
        self.gamma.clear();
        self.acting.clear();
        self.first.clear();
        self.bounces.clear();
        self.changed = true;
    }

    /// Takes note that a first contact bounces, in their order.
    pub(super) fn bounces(&mut self, bounce: Bounce) {
        self.bounces.push(bounce);
    }

    /// How far the contact of `near` is to part, a length.
    pub(super) fn bounced(&self, near: &Near) -> f64 {
        let at = self.bounces.binary_search_by_key(&(near.pair, near.feature), |bounce| (bounce.pair, bounce.feature));
        at.map_or(0.0, |at| self.bounces[at].apart)
    }

    /// Appends a first contact, as [`RowSet::append`].
    pub(super) fn append_first(&mut self, near: &Near, contact: &Contact<D>, gamma: f64) {
        if self.coned {
            self.first.push(self.gamma.len() as u32);
        }
        self.append(near, contact, gamma);
    }

    /// Appends the rows of `near` with the multiplier `gamma` of the normal row.
    pub(super) fn append(&mut self, near: &Near, contact: &Contact<D>, gamma: f64) {
        let pair = near.pair.map(|number| in_rows(number, self.bodies));
        let mu = contact.sliding.map(|sliding| sliding.mu);
        self.push_row((pair, near.feature), contact.normal, gamma);
        if self.coned {
            self.push_cone(mu.map_or(Cone::Ray, Cone::Friction), 0.0, Acting::default());
        }
        if let Some(sliding) = &contact.sliding {
            for tangent in sliding.tangents() {
                self.push_row((pair, near.feature), tangent.row, tangent.held);
                let acting = Acting { tangent: tangent.direction, held: tangent.held };
                self.push_cone(Cone::Tangent, sliding.compliance, acting);
            }
        }
    }

    fn push_row(&mut self, (pair, feature): ([u32; 2], u32), row: Row<D>, gamma: f64) {
        constraint::append(&mut self.problem, pair, row);
        self.changed = true;
        self.feature.push(feature);
        self.gamma.push(gamma);
    }

    fn push_cone(&mut self, cone: Cone, compliance: f64, acting: Acting) {
        self.problem.cones.push(cone);
        self.problem.compliance.push(compliance);
        self.acting.push(acting);
    }

    /// Replaces the rows of all implicit bonds, whose multipliers they keep; further rows start from zero. The
    /// first ones need a set without rows.
    pub(super) fn replace_bonds(&mut self, bonds: Vec<BondRows<D>>) {
        if bonds.is_empty() && self.bonds.is_empty() {
            return;
        }
        self.renewals += u32::from(!self.bonds.is_empty());
        let (old, before) = (std::mem::replace(&mut self.bonds, bonds), self.bonded);
        let kept = self.gamma[..before].to_vec();
        let lines = || self.bonds.iter().flat_map(|of| of.lines.iter().map(move |line| (of, line)));
        let mut at = 0;
        let mut gamma = Vec::new();
        for (i, of) in self.bonds.iter().enumerate() {
            let own = old.get(i).map_or(&[][..], |old| &kept[at..at + old.own]);
            gamma.extend((0..of.lines.len()).map(|line| own.get(line).copied().unwrap_or(0.0)));
            at += old.get(i).map_or(0, |old| old.lines.len());
        }
        let rows = gamma.len();
        let turns = self.bonds.iter().any(|of| of.turns);
        let cone = if turns { Cone::Linked } else { Cone::Free };
        let problem = &mut self.problem;
        problem.pair.splice(..before, lines().map(|(of, _)| of.pair.map(|body| body as u32)));
        problem.jacobian.splice(..before, lines().map(|(_, line)| line.row.0));
        problem.q.splice(..before, lines().map(|(_, line)| line.row.1));
        problem.cones.splice(..before, std::iter::repeat_n(cone, rows));
        problem.compliance.splice(..before, lines().map(|(_, line)| line.compliance));
        self.feature.splice(..before, std::iter::repeat_n(FEATURE_OF_BONDS, rows));
        self.acting.splice(..before, std::iter::repeat_n(Acting::default(), rows));
        self.gamma.splice(..before, gamma);
        for first in &mut self.first {
            *first = *first - before as u32 + rows as u32;
        }
        (self.bonded, self.coned, self.changed) = (rows, true, true);
    }

    /// The number of rows of bonds.
    #[cfg(feature = "gpu")]
    pub(super) fn bonded(&self) -> usize {
        self.bonded
    }

    /// How often the rows of bonds were made anew.
    pub(super) fn renewals(&self) -> u32 {
        self.renewals
    }

    /// The velocities that lead to where the rows of bonds were made anew last.
    pub(super) fn take_bonds_made_at(&mut self) -> Vec<Twist> {
        std::mem::take(&mut self.bonds_made_at)
    }

    /// Sets them.
    pub(super) fn set_bonds_made_at(&mut self, twists: Vec<Twist>) {
        self.bonds_made_at = twists;
    }

    /// The implicit bonds with their multipliers.
    pub(super) fn bonds(&self) -> impl Iterator<Item = (&BondRows<D>, &[f64])> {
        let mut at = 0;
        self.bonds.iter().map(move |of| {
            let rows = at..at + of.lines.len();
            at = rows.end;
            (of, &self.gamma[rows])
        })
    }

    /// `J^T gamma` of the rows of bonds alone; empty where there are none.
    pub(super) fn velocity_of_bonds(&self, out: &mut Vec<[f64; D]>) {
        out.clear();
        if self.bonded == 0 {
            return;
        }
        out.resize(self.problem.bodies, [0.0; D]);
        let rows = self.problem.pair.iter().zip(&self.problem.jacobian).zip(&self.gamma).take(self.bonded);
        for ((pair, blocks), gamma) in rows {
            for (body, block) in pair.iter().zip(blocks) {
                out[*body as usize].iter_mut().zip(block).for_each(|(v, j)| *v += gamma * j);
            }
        }
    }

    /// Whether a row is the normal row of a contact.
    fn is_contact(&self, row: usize) -> bool {
        row >= self.bonded && !self.is_tangent(row)
    }

    /// Whether a row is a tangent row.
    fn is_tangent(&self, row: usize) -> bool {
        self.problem.cones.get(row) == Some(&Cone::Tangent)
    }

    /// Whether a normal row pushes whose pair is `asked` for.
    pub(super) fn any_pushes(&self, asked: impl Fn([u32; 2]) -> bool + Sync) -> bool {
        (0..self.gamma.len()).into_par_iter().with_min_len(LEAST_ROWS_A_PASS).any(|row| self.pushes(row, &asked))
    }

    fn pushes(&self, row: usize, asked: impl Fn([u32; 2]) -> bool) -> bool {
        let pair = || self.problem.pair[row].map(|place| of_rows(place, self.bodies));
        self.gamma[row] > 0.0 && self.is_contact(row) && asked(pair())
    }

    /// The normal rows that push, and their multipliers.
    pub(super) fn pushing_rows(&self) -> impl Iterator<Item = (&[u32; 2], f64)> {
        let rows = self.problem.pair.iter().zip(&self.gamma).enumerate();
        rows.filter(|(row, (_, gamma))| **gamma > 0.0 && self.is_contact(*row)).map(|(_, (pair, gamma))| (pair, *gamma))
    }

    /// Whether contacts may have friction.
    pub(super) fn is_frictional(&self) -> bool {
        self.frictional
    }

    /// The contacts with friction.
    pub(super) fn cones(&self) -> impl Iterator<Item = FrictionCone> {
        let rows = self.problem.cones.iter().enumerate();
        rows.filter_map(|(normal, cone)| match *cone {
            Cone::Friction(mu) => Some(FrictionCone { normal, tangents: self.tangents_of(normal), mu }),
            _ => None,
        })
    }

    /// The multiplier that the contact of a tangent row ended the last step with.
    pub(super) fn held_at(&self, row: usize) -> f64 {
        self.acting[row].held
    }

    /// The direction of a tangent row.
    pub(super) fn tangent(&self, row: usize) -> DVec3 {
        self.acting[row].tangent
    }

    /// The rows after `row` that are of its contact.
    pub(super) fn tangents_of(&self, row: usize) -> std::ops::Range<usize> {
        let mut end = row + 1;
        while self.is_tangent(end) {
            end += 1;
        }
        row + 1..end
    }

    /// The friction force that a row's contact exerts on its second body.
    pub(super) fn friction_force(&self, row: usize) -> DVec3 {
        self.tangents_of(row).map(|tangent| self.gamma[tangent] * self.acting[tangent].tangent).sum()
    }

    /// The friction force that a branch ended the last step with, where it has a first contact.
    pub(super) fn held(&self, pairs: &Pairs, near: &Near) -> DVec3 {
        let Some(row) = self.first_row(pairs, near).filter(|_| self.frictional) else { return DVec3::ZERO };
        self.tangents_of(row).map(|tangent| self.acting[tangent].held * self.acting[tangent].tangent).sum()
    }

    /// The normal row of the first contact of a branch.
    fn first_row(&self, pairs: &Pairs, near: &Near) -> Option<usize> {
        let contacts = pairs.get(near.pair).map_or(0..0, |record| record.first_rows());
        let mut rows = contacts.map(|contact| if self.coned { self.first[contact] as usize } else { contact });
        rows.find(|row| self.feature[*row] == near.feature)
    }

    /// Moves the offset of the first row of `near`, which overlaps at the trial; `false` where that is not the row of
    /// this overlap.
    pub(super) fn tighten(&mut self, near: &Near, pairs: &Pairs, there: &[[f64; D]; 2], scaled: &[[f64; D]]) -> bool {
        let Some(row) = self.first_row(pairs, near) else { return false };
        self.changed = true;
        constraint::tighten(&mut self.problem, row, (near.found.separation, there), scaled)
    }

    /// Sets the offset of a row.
    #[cfg(feature = "gpu")]
    pub(super) fn set_offset(&mut self, row: usize, offset: f64) {
        self.changed |= self.problem.q[row] != offset;
        self.problem.q[row] = offset;
    }

    /// The rows of each branch that pushes, those whose multipliers together move it by more than `least`; the first of
    /// them and the sum of their multipliers, sorted by pair and feature.
    pub(super) fn pushing(&self, least: f64) -> Vec<Push> {
        self.pushing_of(least, |_| true)
    }

    /// The same of the pairs that are `asked` for: checked before rows are sorted, which is more expensive.
    pub(super) fn pushing_of(&self, least: f64, asked: impl Fn([u32; 2]) -> bool + Sync) -> Vec<Push> {
        let mut pushing: Vec<Push> = Vec::new();
        let rows = (0..self.gamma.len() as u32).into_par_iter().with_min_len(LEAST_ROWS_A_PASS);
        let mut order: Vec<u32> = rows.filter(|row| self.pushes(*row as usize, &asked)).collect();
        let key = |row: &u32| (self.problem.pair[*row as usize], self.feature[*row as usize], *row);
        order.sort_unstable_by_key(key);
        for row in order {
            let at = row as usize;
            let pair = self.problem.pair[at].map(|place| of_rows(place, self.bodies));
            let moved = self.gamma[at] * self.problem.jacobian[at].iter().flatten().map(|j| j * j).sum::<f64>();
            match pushing.last_mut().filter(|push| (push.pair, push.feature) == (pair, self.feature[at])) {
                Some(push) => {
                    push.gamma += self.gamma[at];
                    push.moved += moved;
                }
                None => pushing.push(Push { pair, feature: self.feature[at], gamma: self.gamma[at], moved }),
            }
        }
        pushing.retain(|push| push.moved > least);
        pushing
    }

    /// The branches that overlap where nothing pushes, sorted by pair and feature; each moves by its overlap.
    pub(super) fn overlapping(&self) -> Vec<Push> {
        let rows = (0..self.problem.q.len()).filter(|row| self.problem.q[*row] < 0.0 && self.is_contact(*row));
        let push = |row: usize| {
            let pair = self.problem.pair[row].map(|place| of_rows(place, self.bodies));
            Push { pair, feature: self.feature[row], gamma: 0.0, moved: -self.problem.q[row] }
        };
        let mut overlapping: Vec<Push> = rows.map(push).collect();
        overlapping.sort_by_key(|push| (push.pair, push.feature));
        overlapping.dedup_by_key(|push| (push.pair, push.feature));
        overlapping
    }

    /// Replaces all contacts of a branch by one, for each branch of `rebuilt` (sorted by pair and feature). The new
    /// contact stands where the first of them stood.
    pub(super) fn replace_branches(&mut self, rebuilt: &[NewContact<D>]) {
        let mut done = vec![false; rebuilt.len()];
        let RowSet { frictional, coned, bodies, .. } = *self;
        let old = std::mem::replace(self, RowSet { frictional, coned, bodies, ..RowSet::new() });
        self.bounces.clone_from(&old.bounces);
        self.problem.bodies = old.problem.bodies;
        (self.bonds, self.bonded, self.renewals) = (old.bonds.clone(), old.bonded, old.renewals);
        self.bonds_made_at.clone_from(&old.bonds_made_at);
        (0..old.bonded).for_each(|row| self.copy_row(&old, row));
        let mut first = old.first.iter().peekable();
        for row in (0..old.gamma.len()).filter(|row| old.is_contact(*row)) {
            let is_first = first.next_if_eq(&&(row as u32)).is_some();
            let pair = old.problem.pair[row].map(|place| of_rows(place, self.bodies));
            let key = (pair, old.feature[row]);
            let found = rebuilt.binary_search_by_key(&key, |(near, ..)| (near.pair, near.feature)).ok();
            let again = found.is_some_and(|found| std::mem::replace(&mut done[found], true));
            if is_first {
                self.first.push(self.gamma.len() as u32);
            }
            match found {
                Some(_) if again => {}
                Some(found) => {
                    let (near, contact, gamma) = &rebuilt[found];
                    self.append(near, contact, *gamma);
                }
                None => self.copy_contact(&old, row),
            }
        }
    }

    /// Appends a contact of another set.
    fn copy_contact(&mut self, from: &RowSet<D>, normal: usize) {
        for row in std::iter::once(normal).chain(from.tangents_of(normal)) {
            self.copy_row(from, row);
        }
    }

    fn copy_row(&mut self, from: &RowSet<D>, row: usize) {
        let problem = &from.problem;
        let of = (problem.pair[row], from.feature[row]);
        self.push_row(of, (problem.jacobian[row], problem.q[row]), from.gamma[row]);
        if self.coned {
            self.push_cone(problem.cones[row], problem.compliance[row], from.acting[row]);
        }
    }

    /// Combines the flag of changes over all processes.
    pub(super) fn set_changed(&mut self, anywhere: impl FnOnce(bool) -> bool) {
        self.changed = anywhere(self.changed);
    }

    /// Whether anything changed since the last call.
    pub(super) fn take_changed(&mut self) -> bool {
        std::mem::replace(&mut self.changed, false)
    }

    /// Takes over the multipliers of the contact whose normal row this is.
    #[cfg(feature = "gpu")]
    pub(super) fn take_multipliers(&mut self, normal: usize, found: &[f64]) {
        self.changed = true;
        crate::lcp::PackedContacts::take(found, &self.problem, &mut self.gamma, normal);
    }

    /// The multipliers, to be changed.
    pub(super) fn change_gamma(&mut self) -> &mut Vec<f64> {
        self.changed = true;
        &mut self.gamma
    }

    /// The warm start of the next step: for each contact with rows the sum of their multipliers, and the pair's last
    /// normal. `scaled` are the scaled velocities of contact at the trial.
    pub(super) fn warm_start(&self, pairs: &Pairs, scaled: &[[f64; D]]) -> Vec<Warm> {
        let of_row = |row: usize| Warm {
            pair: self.problem.pair[row].map(|place| of_rows(place, self.bodies)),
            feature: self.feature[row],
            gamma: self.gamma[row],
            normal: DVec3::ZERO,
            tangent: self.kept_friction(row, scaled),
        };
        let rows = (0..self.gamma.len()).into_par_iter().with_min_len(LEAST_ROWS_A_PASS);
        let mut warm: Vec<Warm> = rows.filter(|row| self.is_contact(*row)).map(of_row).collect();
        warm.par_sort_by_key(|w| (w.pair, w.feature));
        warm.dedup_by(|later, first| {
            let same = (later.pair, later.feature) == (first.pair, first.feature);
            if same {
                first.gamma += later.gamma;
                first.tangent += later.tangent;
            }
            same
        });
        pairs.copy_normals(&mut warm);
        warm
    }
}
