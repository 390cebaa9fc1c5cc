//! The rows of a step on the CPU: made from near pairs and from violations, and what of them the next step starts from.

use super::narrow_phase::{self, Known, Near};
use super::{At, Cpu};
use crate::constraint::{self, FEATURE_OF_SURFACES, FIXED, Mover, sub_sphere_separations};
use crate::dynamics;
use crate::relcp::Warm;
use crate::separation::Separation;
use crate::walls::{number_of, surface_of};
use glam::DVec3;

impl<const D: usize> Cpu<D> {
    /// Appends the row of `near` with multiplier `gamma`; `at` says where it was found.
    pub(super) fn append(&mut self, near: &Near, gamma: f64, at: At) {
        let (pair, row) = (self.row_pair(near.pair), self.row(near, at));
        constraint::append(&mut self.problem, pair, row);
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
        pair.map(|number| surface_of(number).map_or(number, |surface| (self.start.len() + surface) as u32))
    }

    /// The pair of a row.
    fn pair_of(&self, row: usize) -> [u32; 2] {
        self.problem.pair[row].map(|place| match (place as usize).checked_sub(self.start.len()) {
            Some(surface) => number_of(surface),
            None => place,
        })
    }

    /// Moves the offset of the first row of a pair that overlaps at the trial; `false` where that is not the row of this overlap.
    pub(super) fn tighten(&mut self, near: &Near) -> bool {
        let Some(row) = self.first_row(near) else { return false };
        let (there, _) = self.row(near, At::Trial);
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

    /// Rows of the smooth surfaces of all near pairs, and of bodies near walls.
    pub(super) fn append_near_surfaces(&mut self, pairs: &[[u32; 2]]) {
        let known = narrow_phase::remembered(&self.recalled);
        let here = self.here();
        let limit = |a: usize, b: usize| self.cutoff + self.reach[a] + self.reach[b];
        let mut near = narrow_phase::within(pairs, &known, Self::SEPARATE, |a, b| here.pair(a, b), limit);
        let walls = self.near_walls(|i| here.placed(i), |i| self.cutoff + self.reach[i]);
        self.known = near.iter().map(Known::from).collect();
        join(&mut near, walls);
        if self.middle.is_none() {
            self.start_overlap = near.iter().fold(0.0, |deepest, near| deepest.max(-near.found.separation));
        }
        let warm = std::mem::take(&mut self.recalled);
        let mut cursor = warm.iter().peekable();
        for near in &near {
            let mut gamma = 0.0;
            while let Some(w) = cursor.next_if(|w| key_of_surfaces(w) <= (near.pair, near.feature)) {
                if key_of_surfaces(w) == (near.pair, near.feature) {
                    gamma += w.gamma;
                }
            }
            self.append(&self.at_end_lengths(*near), gamma, At::FirstRows);
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
            let [of_a, of_b] = here.pair(a, b);
            let proxies = [self.proxies[a].as_slice(), self.proxies[b].as_slice()];
            sub_sphere_separations([&of_a, &of_b], proxies, limit, |feature, found| {
                rows.push(Near { pair, feature, found })
            });
        }
        join(&mut rows, self.sub_spheres_near_walls(|i| here.placed(i), |i| self.cutoff + self.reach[i]));
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

/// Which first row of smooth surfaces takes up a multiplier: that of the pair, and of the place where a body touches a wall.
fn key_of_surfaces(w: &Warm) -> ([u32; 2], u32) {
    (w.pair, if surface_of(w.pair[1]).is_some() { w.feature } else { FEATURE_OF_SURFACES })
}
