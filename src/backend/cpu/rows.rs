//! The rows of a step on the CPU: made from near pairs and from violations, and what of them the next step starts from.

use super::Cpu;
use super::narrow_phase::{self, Known, Near};
use crate::constraint::{self, FEATURE_OF_SURFACES, Mover, sub_sphere_separations};
use crate::dynamics::Twist;
use crate::relcp::Warm;
use glam::DVec3;

impl<const D: usize> Cpu<D> {
    /// Appends the row of `near` with multiplier `gamma`; `at_trial` says where it was found.
    pub(super) fn append(&mut self, near: &Near, feature: u32, gamma: f64, at_trial: bool) {
        let [a, b] = near.pair.map(|body| Mover {
            motion: &self.motion[body as usize],
            reached_with: if at_trial { self.twist[body as usize] } else { Twist::default() },
        });
        constraint::append(&mut self.problem, near.pair, &near.found, [a, b], self.dt);
        self.feature.push(feature);
        self.gamma.push(gamma);
    }

    /// Rows of the smooth surfaces of all near pairs.
    pub(super) fn append_near_surfaces(&mut self, pairs: &[[u32; 2]]) {
        let known = narrow_phase::remembered(&self.state.warm);
        let limit = |a: usize, b: usize| self.cutoff + self.reach[a] + self.reach[b];
        let near = narrow_phase::within(pairs, &known, Self::SEPARATE, |i| self.start.placed(i), limit);
        self.known = near.iter().map(Known::from).collect();
        let warm = std::mem::take(&mut self.state.warm);
        let mut cursor = warm.iter().peekable();
        for near in &near {
            let mut gamma = 0.0;
            while let Some(w) = cursor.next_if(|w| w.pair <= near.pair) {
                if w.pair == near.pair {
                    gamma += w.gamma;
                }
            }
            self.append(near, FEATURE_OF_SURFACES, gamma, false);
        }
        self.state.warm = warm;
    }

    /// Rows of all near pairs of sub-spheres.
    pub(super) fn append_near_sub_spheres(&mut self, pairs: &[[u32; 2]]) {
        let warm = std::mem::take(&mut self.state.warm);
        let mut rows = Vec::new();
        for &pair in pairs {
            let [a, b] = pair.map(|i| i as usize);
            let limit = self.cutoff + self.reach[a] + self.reach[b];
            let placed = [&self.start.placed(a), &self.start.placed(b)];
            let proxies = [self.proxies[a].as_slice(), self.proxies[b].as_slice()];
            sub_sphere_separations(placed, proxies, limit, |feature, found| rows.push((Near { pair, found }, feature)));
        }
        let mut cursor = warm.iter().peekable();
        for (near, feature) in &rows {
            let key = (near.pair, *feature);
            while cursor.next_if(|w| (w.pair, w.feature) < key).is_some() {}
            let gamma = cursor.next_if(|w| (w.pair, w.feature) == key).map_or(0.0, |w| w.gamma);
            self.append(near, *feature, gamma, false);
        }
        self.known = narrow_phase::remembered(&warm);
        self.state.warm = warm;
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
