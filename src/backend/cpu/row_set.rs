//! The rows of a step, their multipliers, and what of them the next step starts from.

use super::narrow_phase::Near;
use super::pairs::Pairs;
use crate::constraint;
use crate::lcp::Problem;
use crate::walls::{in_rows, of_rows};
use crate::warm::Warm;
use glam::DVec3;

/// The LCP of a step with its multipliers. First rows stand sorted by pair and feature, those of violations after them.
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

    /// Learns from whether anything changed here whether it did anywhere.
    pub(super) fn set_changed(&mut self, anywhere: impl FnOnce(bool) -> bool) {
        self.changed = anywhere(self.changed);
    }

    /// Whether anything changed since this was asked last.
    pub(super) fn take_changed(&mut self) -> bool {
        std::mem::replace(&mut self.changed, false)
    }

    /// The multipliers, to be changed.
    pub(super) fn change_gamma(&mut self) -> &mut Vec<f64> {
        self.changed = true;
        &mut self.gamma
    }

    /// What the next step starts from: for each contact with rows the sum of their multipliers, and the pair's last
    /// normal.
    pub(super) fn left(&self, pairs: &Pairs) -> Vec<Warm> {
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
