//! The rows of a step, their multipliers, and the warm start for the next step.

use super::narrow_phase::Near;
use super::pairs::Pairs;
use crate::constraint;
use crate::lcp::Problem;
use crate::walls::{in_rows, of_rows};
use crate::warm::Warm;
use glam::DVec3;

/// A row that replaces all rows of its branch, with its blocks, offset and multiplier.
pub(super) type NewRow<const D: usize> = (Near, ([[f64; D]; 2], f64), f64);

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

/// The LCP of a step with its multipliers. First rows come first, sorted by pair and feature, then those of violations.
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
}

impl<const D: usize> RowSet<D> {
    pub(super) fn new() -> Self {
        RowSet { problem: Problem::default(), feature: Vec::new(), gamma: Vec::new(), changed: true, bodies: 0 }
    }

    pub(super) fn clear(&mut self, bodies: usize, surfaces: usize) {
        constraint::clear(&mut self.problem, bodies + surfaces);
        self.bodies = bodies;
        self.feature.clear();
        self.gamma.clear();
        self.changed = true;
    }

    /// Appends the row of `near` with multiplier `gamma`.
    pub(super) fn append(&mut self, near: &Near, row: ([[f64; D]; 2], f64), gamma: f64) {
        let pair = near.pair.map(|number| in_rows(number, self.bodies));
        constraint::append(&mut self.problem, pair, row);
        self.changed = true;
        self.feature.push(near.feature);
        self.gamma.push(gamma);
    }

    /// Moves the offset of the first row of `near`, which overlaps at the trial; `false` where that is not the row of
    /// this overlap.
    pub(super) fn tighten(&mut self, near: &Near, pairs: &Pairs, there: &[[f64; D]; 2], scaled: &[[f64; D]]) -> bool {
        let first_rows = pairs.get(near.pair).map_or(0..0, |record| record.first_rows());
        let Some(row) = first_rows.into_iter().find(|row| self.feature[*row] == near.feature) else { return false };
        self.changed = true;
        constraint::tighten(&mut self.problem, row, (near.found.separation, there), scaled)
    }

    /// The rows of each branch that pushes, those whose multipliers together move it by more than `least`; the first of
    /// them and the sum of their multipliers, sorted by pair and feature.
    pub(super) fn pushing(&self, least: f64) -> Vec<Push> {
        self.pushing_of(least, |_| true)
    }

    /// The same of the pairs that are `asked` for: checked before rows are sorted, which is more expensive.
    pub(super) fn pushing_of(&self, least: f64, asked: impl Fn([u32; 2]) -> bool) -> Vec<Push> {
        let mut pushing: Vec<Push> = Vec::new();
        let pushes = |row: &u32| {
            let at = *row as usize;
            self.gamma[at] > 0.0 && asked(self.problem.pair[at].map(|place| of_rows(place, self.bodies)))
        };
        let mut order: Vec<u32> = (0..self.gamma.len() as u32).filter(pushes).collect();
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
        let rows = (0..self.problem.q.len()).filter(|row| self.problem.q[*row] < 0.0);
        let push = |row: usize| {
            let pair = self.problem.pair[row].map(|place| of_rows(place, self.bodies));
            Push { pair, feature: self.feature[row], gamma: 0.0, moved: -self.problem.q[row] }
        };
        let mut overlapping: Vec<Push> = rows.map(push).collect();
        overlapping.sort_by_key(|push| (push.pair, push.feature));
        overlapping.dedup_by_key(|push| (push.pair, push.feature));
        overlapping
    }

    /// Replaces all rows of a branch by one, for each branch of `rebuilt` (sorted by pair and feature).
    pub(super) fn replace_branches(&mut self, rebuilt: Vec<NewRow<D>>) {
        let mut done = vec![false; rebuilt.len()];
        let mut to = 0;
        for from in 0..self.gamma.len() {
            let pair = self.problem.pair[from].map(|place| of_rows(place, self.bodies));
            let key = (pair, self.feature[from]);
            let found = rebuilt.binary_search_by_key(&key, |(near, ..)| (near.pair, near.feature)).ok();
            if found.is_some_and(|found| std::mem::replace(&mut done[found], true)) {
                continue;
            }
            self.problem.pair[to] = self.problem.pair[from];
            self.feature[to] = self.feature[from];
            let kept = (self.problem.jacobian[from], self.problem.q[from], self.gamma[from]);
            let (jacobian, q, gamma) = found.map_or(kept, |found| {
                let (_, (jacobian, q), gamma) = rebuilt[found];
                (jacobian, q, gamma)
            });
            (self.problem.jacobian[to], self.problem.q[to], self.gamma[to]) = (jacobian, q, gamma);
            to += 1;
        }
        self.problem.pair.truncate(to);
        self.problem.jacobian.truncate(to);
        self.problem.q.truncate(to);
        self.feature.truncate(to);
        self.gamma.truncate(to);
        self.changed = true;
    }

    /// Combines the flag of changes over all processes.
    pub(super) fn set_changed(&mut self, anywhere: impl FnOnce(bool) -> bool) {
        self.changed = anywhere(self.changed);
    }

    /// Whether anything changed since the last call.
    pub(super) fn take_changed(&mut self) -> bool {
        std::mem::replace(&mut self.changed, false)
    }

    /// The multipliers, to be changed.
    pub(super) fn change_gamma(&mut self) -> &mut Vec<f64> {
        self.changed = true;
        &mut self.gamma
    }

    /// The warm start of the next step: for each contact with rows the sum of their multipliers, and the pair's last
    /// normal.
    pub(super) fn warm_start(&self, pairs: &Pairs) -> Vec<Warm> {
        let of_row = |row: usize| Warm {
            pair: self.problem.pair[row].map(|place| of_rows(place, self.bodies)),
            feature: self.feature[row],
            gamma: self.gamma[row],
            normal: DVec3::ZERO,
        };
        let mut warm: Vec<Warm> = (0..self.gamma.len()).map(of_row).collect();
        warm.sort_by_key(|w| (w.pair, w.feature));
        warm.dedup_by(|later, first| {
            let same = (later.pair, later.feature) == (first.pair, first.feature);
            if same {
                first.gamma += later.gamma;
            }
            same
        });
        pairs.copy_normals(&mut warm);
        warm
    }
}
