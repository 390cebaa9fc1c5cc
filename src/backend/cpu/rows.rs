//! The rows of a step on the CPU: made from near pairs and from violations, and what of them the next step starts from.

use super::narrow_phase::{self, Known, Near};
use super::{At, Cpu};
use crate::constraint::{self, FIXED, Mover, sub_sphere_separations};
use crate::dynamics::{self, Pose};
use crate::freedom::PLANAR;
use crate::separation::{Placed, Separation, branch_slack, branches};
use crate::step::Rows;
use crate::walls::{in_rows, of_rows, surface_of};
use crate::warm::Warm;
use glam::DVec3;
use rayon::prelude::*;

/// A loop over fewer pairs than this runs on one thread: the branches of a pair of rods take some 50 ns.
const LEAST_PAIRS_A_TASK: usize = 512;

impl<const D: usize> Cpu<D> {
    /// Appends the row of `near` with multiplier `gamma`; `at` says where it was found.
    pub(super) fn append(&mut self, near: &Near, gamma: f64, at: At) {
        let (pair, row) = (self.row_pair(near.pair), self.row(near, at));
        constraint::append(&mut self.problem, pair, row);
        self.changed = true;
        self.feature.push(near.feature);
        self.gamma.push(gamma);
    }

    /// The blocks and the offset of the row of `near`.
    fn row(&self, near: &Near, at: At) -> ([[f64; D]; 2], f64) {
        let mover = |number: u32| match surface_of(number) {
            Some(_) => FIXED,
            None => {
                let body = number as usize;
                Mover { motion: &self.motion[body], reached_with: self.reached_at(body, at) }
            }
        };
        constraint::row(&near.found, near.pair.map(mover), self.interval)
    }

    /// A pair as rows have it: the surfaces of walls come after all bodies.
    fn row_pair(&self, pair: [u32; 2]) -> [u32; 2] {
        pair.map(|number| in_rows(number, self.start.len()))
    }

    /// The pair of a row.
    fn pair_of(&self, row: usize) -> [u32; 2] {
        self.problem.pair[row].map(|place| of_rows(place, self.start.len()))
    }

    /// Moves the offset of the first row of a pair that overlaps at the trial; `false` where that is not the row of
    /// this overlap.
    pub(super) fn tighten(&mut self, near: &Near) -> bool {
        let Some(row) = self.first_row(near) else { return false };
        let (there, _) = self.row(near, At::Trial);
        self.changed = true;
        constraint::tighten(&mut self.problem, row, (near.found.separation, &there), &self.scaled)
    }

    /// The first row of a pair's contact: they stand sorted.
    fn first_row(&self, near: &Near) -> Option<usize> {
        let wanted = (self.row_pair(near.pair), near.feature);
        let key = |row: usize| (self.problem.pair[row], self.feature[row]);
        let (mut low, mut high) = (0, self.first_rows);
        while low < high {
            let middle = low.midpoint(high);
            if key(middle) < wanted { low = middle + 1 } else { high = middle }
        }
        (low < self.first_rows && key(low) == wanted).then_some(low)
    }

    /// A first row's separation with the lengths at the end of the step, where those in its middle are others.
    fn at_end_lengths(&self, mut near: Near) -> Near {
        if let (Some(middle), true) = (&self.middle, self.growth.is_some()) {
            let Separation { normal, lever_a, lever_b, .. } = near.found;
            let stretch = |number: u32, lever: DVec3, normal: DVec3| match surface_of(number) {
                Some(_) => DVec3::ZERO,
                None => dynamics::stretch(
                    &middle.placed(number as usize),
                    &self.start.shape[number as usize],
                    lever,
                    normal,
                ),
            };
            let [a, b] = near.pair;
            near.found.separation += normal.dot(stretch(b, lever_b, -normal) - stretch(a, lever_a, normal));
        }
        near
    }

    /// Body `i` where first rows are made.
    fn placed_first(&self, i: usize) -> Placed {
        let Pose { position, orientation } = self.first[i];
        Placed { shape: self.here().shape[i], position, orientation }
    }

    /// The distance within which a pair is near where first rows are made.
    fn limit(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (&self.reach[a], &self.reach[b]);
        match self.rows {
            Rows::Paper => self.cutoff + a.either + b.either,
            Rows::Auto => self.cutoff + (b.linear - a.linear).length() + a.angular + b.angular,
        }
    }

    /// Rows of the smooth surfaces of all near pairs, and of bodies near walls.
    pub(super) fn append_near_surfaces(&mut self, pairs: &[[u32; 2]]) {
        let known = narrow_phase::remembered(&self.recalled);
        let periods = self.start.periods;
        let placed = |a: usize, b: usize| periods.pair(self.placed_first(a), self.placed_first(b));
        let limit = |a: usize, b: usize| self.limit(a, b);
        let mut near = narrow_phase::within(pairs, &known, Self::SEPARATE, placed, limit);
        let walls = self.near_walls(|i| self.placed_first(i), |i| self.cutoff + self.reach[i].either);
        self.known = near.iter().map(Known::from).collect();
        if self.middle.is_none() {
            let deepest = |deepest: f64, near: &Near| deepest.max(-near.found.separation);
            self.start_overlap = near.iter().chain(&walls).fold(0.0, deepest);
        }
        let warm = std::mem::take(&mut self.recalled);
        if self.rows == Rows::Auto {
            near = self.with_branches(&near, &warm);
        }
        if self.ahead {
            self.aim_at_end(&mut near);
        }
        join(&mut near, walls);
        for (near, gamma) in near.iter().zip(multipliers(&near, &warm)) {
            self.append(&self.at_end_lengths(*near), gamma, At::FirstRows);
        }
        self.recalled = warm;
    }

    /// The branches of near pairs (sorted) that may become active in the step, and those that ended the last one with a
    /// multiplier.
    fn with_branches(&self, near: &[Near], warm: &[Warm]) -> Vec<Near> {
        let of_pair = |near: &Near| {
            let [a, b] = near.pair.map(|i| i as usize);
            let [of_a, of_b] = self.start.periods.pair(self.placed_first(a), self.placed_first(b));
            let [last_a, last_b] = [a, b].map(|i| self.start.twist(i));
            let turned = self.interval * (last_b.angular - last_a.angular);
            let slid = self.interval * (last_b.linear - last_a.linear).length();
            let slack = branch_slack(&of_a, &of_b, &near.found, (turned, slid), D == PLANAR);
            let most = near.found.separation + slack;
            let first = warm.partition_point(|w| w.pair < near.pair);
            let pushed = |feature: u32| {
                let of_pair = warm[first..].iter().take_while(|w| w.pair == near.pair);
                of_pair.filter(|w| w.feature == feature).any(|w| w.gamma > 0.0)
            };
            let mut rows = Vec::new();
            let limit = self.limit(a, b);
            branches(&of_a, &of_b, &near.found, limit - near.found.separation, |feature, found| {
                if found.separation <= most || pushed(feature) {
                    rows.push(Near { pair: near.pair, feature, found });
                }
            });
            if rows.is_empty() {
                branches(&of_a, &of_b, &near.found, 0.0, |feature, found| {
                    rows.push(Near { pair: near.pair, feature, found });
                });
            }
            rows
        };
        near.par_iter().with_min_len(LEAST_PAIRS_A_TASK).flat_map_iter(of_pair).collect()
    }

    /// All violations of a trial: the overlaps of more than was asked about, with the paper's rows one a pair, else
    /// each branch.
    pub(super) fn violated(&self, overlapping: &[Near]) -> Vec<Near> {
        let over = overlapping.iter().filter(|near| near.found.separation < -self.violating);
        if self.rows == Rows::Paper {
            return over.copied().collect();
        }
        let mut violated = Vec::new();
        for near in over {
            if surface_of(near.pair[1]).is_some() {
                violated.push(*near);
                continue;
            }
            let [a, b] = near.pair.map(|i| i as usize);
            let [of_a, of_b] = self.pair_at_trial(a, b);
            branches(&of_a, &of_b, &near.found, -self.violating - near.found.separation, |feature, found| {
                violated.push(Near { pair: near.pair, feature, found });
            });
        }
        violated
    }

    /// Rows of all near pairs of sub-spheres.
    pub(super) fn append_near_sub_spheres(&mut self, pairs: &[[u32; 2]]) {
        let warm = std::mem::take(&mut self.recalled);
        let mut rows = Vec::new();
        for &pair in pairs {
            let [a, b] = pair.map(|i| i as usize);
            let limit = self.cutoff + self.reach[a].either + self.reach[b].either;
            let [of_a, of_b] = self.start.periods.pair(self.placed_first(a), self.placed_first(b));
            let proxies = [self.proxies[a].as_slice(), self.proxies[b].as_slice()];
            sub_sphere_separations([&of_a, &of_b], proxies, limit, |feature, found| {
                rows.push(Near { pair, feature, found })
            });
        }
        join(&mut rows, self.sub_spheres_near_walls(|i| self.placed_first(i), |i| self.cutoff + self.reach[i].either));
        let mut cursor = warm.iter().peekable();
        for near in &rows {
            let key = (near.pair, near.feature);
            while cursor.next_if(|w| (w.pair, w.feature) < key).is_some() {}
            let gamma = cursor.next_if(|w| (w.pair, w.feature) == key).map_or(0.0, |w| w.gamma);
            self.append(&self.at_end_lengths(*near), gamma, At::FirstRows);
        }
        self.known = narrow_phase::remembered(&warm);
    }

    /// What the next step starts from: for each pair with rows, their multipliers and the last normal.
    pub(super) fn remember(&self) -> Vec<Warm> {
        let mut warm: Vec<Warm> = (0..self.gamma.len())
            .map(|row| Warm {
                pair: self.pair_of(row),
                feature: self.feature[row],
                gamma: self.gamma[row],
                normal: DVec3::ZERO,
            })
            .collect();
        warm.sort_by_key(|w| (w.pair, w.feature));
        warm.dedup_by(|later, first| {
            let same = (later.pair, later.feature) == (first.pair, first.feature);
            if same {
                first.gamma += later.gamma;
            }
            same
        });
        narrow_phase::copy_normals(&self.known, &mut warm);
        for w in warm.iter_mut().filter(|_| self.proxies.is_empty()) {
            if let Some(surface) = surface_of(w.pair[1]) {
                w.normal = self.wall_normal(w.pair[0] as usize, surface, w.feature);
            }
        }
        warm
    }
}

/// Puts bodies near walls among the near pairs.
pub(super) fn join(near: &mut Vec<Near>, walls: Vec<Near>) {
    if !walls.is_empty() {
        near.extend(walls);
        near.sort_by_key(|near| (near.pair, near.feature));
    }
}

/// The multipliers that first rows (sorted by pair and feature) start from: those that their branches ended the last
/// step with. What a branch without a row ended with goes to the pair's nearest one.
fn multipliers(rows: &[Near], warm: &[Warm]) -> Vec<f64> {
    let mut gamma = vec![0.0; rows.len()];
    let mut first = 0;
    for of_pair in warm.chunk_by(|w, v| w.pair == v.pair) {
        let pair = of_pair[0].pair;
        first += rows[first..].partition_point(|near| near.pair < pair);
        let count = rows[first..].partition_point(|near| near.pair == pair);
        let of_rows = &rows[first..first + count];
        let Some(nearest) =
            (0..count).min_by(|i, j| of_rows[*i].found.separation.total_cmp(&of_rows[*j].found.separation))
        else {
            continue;
        };
        let wall = surface_of(pair[1]).is_some();
        for w in of_pair {
            let own = of_rows.iter().position(|near| near.feature == w.feature);
            if let Some(row) = own.or((!wall).then_some(nearest)) {
                gamma[first + row] += w.gamma;
            }
        }
    }
    gamma
}
