//! The rows of a step on the CPU: made from near pairs and from violations, and what of them the next step starts from.

use super::narrow_phase::{self, Known, Near};
use super::{At, Cpu};
use crate::constraint::{self, FEATURE_OF_SURFACES, Mover, sub_sphere_separations};
use crate::dynamics;
use crate::relcp::Warm;
use crate::separation::Separation;
use glam::DVec3;

impl<const D: usize> Cpu<D> {
    /// Appends the row of `near` with multiplier `gamma`; `at` says where it was found.
    pub(super) fn append(&mut self, near: &Near, feature: u32, gamma: f64, at: At) {
        let reached = near.pair.map(|body| self.reached_at(body as usize, at));
        let mover = |side: usize| Mover { motion: &self.motion[near.pair[side] as usize], reached_with: reached[side] };
        constraint::append(&mut self.problem, near.pair, &near.found, [mover(0), mover(1)], self.interval);
        self.feature.push(feature);
        self.gamma.push(gamma);
    }

    /// Moves the offset of the first row of a pair that overlaps at the trial; `false` where that is not the row of this overlap.
    pub(super) fn tighten(&mut self, near: &Near) -> bool {
        let first = &self.problem.pair[..self.first_rows];
        let Ok(row) = first.binary_search(&near.pair) else { return false };
        let found = (near.found.separation, near.found.normal);
        constraint::tighten(&mut self.problem, row, found, &self.scaled)
    }

    /// A first row's separation with the lengths at the end of the step, where those in its middle are others.
    fn at_end_lengths(&self, mut near: Near) -> Near {
        if let (Some(middle), true) = (&self.middle, self.growth.is_some()) {
            let [a, b] = near.pair.map(|i| i as usize);
            let Separation { normal, lever_a, lever_b, .. } = near.found;
            let on_a = dynamics::stretch(&middle.placed(a), &self.start.shape[a], lever_a, normal);
            let on_b = dynamics::stretch(&middle.placed(b), &self.start.shape[b], lever_b, -normal);
            near.found.separation += normal.dot(on_b - on_a);
        }
        near
    }

    /// Rows of the smooth surfaces of all near pairs.
    pub(super) fn append_near_surfaces(&mut self, pairs: &[[u32; 2]]) {
        let known = narrow_phase::remembered(&self.recalled);
        let here = self.here();
        let limit = |a: usize, b: usize| self.cutoff + self.reach[a] + self.reach[b];
        let near = narrow_phase::within(pairs, &known, Self::SEPARATE, |i| here.placed(i), limit);
        self.known = near.iter().map(Known::from).collect();
        let warm = std::mem::take(&mut self.recalled);
        let mut cursor = warm.iter().peekable();
        for near in &near {
            let mut gamma = 0.0;
            while let Some(w) = cursor.next_if(|w| w.pair <= near.pair) {
                if w.pair == near.pair {
                    gamma += w.gamma;
                }
            }
            self.append(&self.at_end_lengths(*near), FEATURE_OF_SURFACES, gamma, At::FirstRows);
        }
    }

    /// Rows of all near pairs of sub-spheres.
    pub(super) fn append_near_sub_spheres(&mut self, pairs: &[[u32; 2]]) {
        let warm = std::mem::take(&mut self.recalled);
        let here = self.here();
        let mut rows = Vec::new();
        for &pair in pairs {
            let [a, b] = pair.map(|i| i as usize);
            let limit = self.cutoff + self.reach[a] + self.reach[b];
            let placed = [&here.placed(a), &here.placed(b)];
            let proxies = [self.proxies[a].as_slice(), self.proxies[b].as_slice()];
            sub_sphere_separations(placed, proxies, limit, |feature, found| rows.push((Near { pair, found }, feature)));
        }
        let mut cursor = warm.iter().peekable();
        for (near, feature) in &rows {
            let key = (near.pair, *feature);
            while cursor.next_if(|w| (w.pair, w.feature) < key).is_some() {}
            let gamma = cursor.next_if(|w| (w.pair, w.feature) == key).map_or(0.0, |w| w.gamma);
            self.append(&self.at_end_lengths(*near), *feature, gamma, At::FirstRows);
        }
        self.known = narrow_phase::remembered(&warm);
    }

    /// What the next step starts from: for each pair with rows, their multipliers and the last normal.
    pub(super) fn remember(&self) -> Vec<Warm> {
        let mut warm: Vec<Warm> = (0..self.gamma.len())
            .map(|row| Warm {
                pair: self.problem.pair[row],
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
        warm
    }
}
