//! Which pairs and walls have first rows, and which rows: of the smooth surfaces, by branches, or of sub-spheres.

use super::first::First;
use super::motions::Motions;
use super::narrow_phase::{self, Earlier, Near, Separate};
use super::pairs::{Pairs, Recalled};
use super::setup::Setup;
use super::start::Start;
use super::walls;
use crate::constraint::sub_sphere_separations;
use crate::dynamics;
use crate::separation::{Separation, branch_slack, branches};
use crate::step::Rows;
use crate::walls::surface_of;
use glam::DVec3;
use rayon::prelude::*;

/// A loop over fewer pairs than this runs on one thread: the branches of a pair of rods take some 50 ns.
pub(super) const LEAST_PAIRS_A_TASK: usize = 512;

/// The stages that first rows are made from.
#[derive(Clone, Copy)]
pub(super) struct Stages<'a> {
    pub(super) setup: &'a Setup,
    pub(super) start: &'a Start,
    pub(super) motions: &'a Motions,
}

impl Stages<'_> {
    /// The rows of the smooth surfaces of all near pairs and of bodies near walls, with the multipliers that they start
    /// from; sorted. `first` learns the deepest overlap at the start.
    pub(super) fn of_surfaces(
        self,
        (candidates, separate, planar): (&[[u32; 2]], Separate, bool),
        first: &mut First,
        pairs: &mut Pairs,
    ) -> (Vec<Near>, Vec<Recalled>) {
        let Stages { setup, start, motions, .. } = self;
        let limit = |a: usize, b: usize| motions.limit(setup, start, a, b);
        let placed = |a: usize, b: usize| first.pair(start, a, b);
        let found = narrow_phase::within(candidates, (pairs, Earlier::default()), separate, placed, limit);
        let placed = |i: usize| first.placed(start, i);
        let mut walls = walls::near(start.walls(setup), start.bodies.len(), placed, |i| {
            if start.is_idle(i) { f64::NEG_INFINITY } else { setup.cutoff + motions.reach[i].either }
        });
        if let Some(middle) = start.walls_in_middle() {
            walls::turn_to(middle, &mut walls, placed);
        }
        if start.middle.is_none() {
            let deepest = |deepest: f64, near: &Near| deepest.max(-near.found.separation);
            // What a wall's motion makes of a start is no overlap of the start.
            let before = start.walls_before().map(|walls| {
                let limit = |i: usize| if start.is_idle(i) { f64::NEG_INFINITY } else { 0.0 };
                walls::near(walls, start.bodies.len(), placed, limit)
            });
            let of_bodies = |near: &Near| {
                let places = near.pair.map(|i| first.pose(i as usize).position);
                -start.separation_before(setup, places, &near.found)
            };
            // The largest is the same in any order.
            let overlaps = found.par_iter().with_min_len(LEAST_PAIRS_A_TASK).map(of_bodies);
            let overlap = overlaps.reduce(|| 0.0, f64::max);
            let overlap = before.as_ref().unwrap_or(&walls).iter().fold(overlap, deepest);
            first.overlap = overlap;
        }
        let mut rows = match setup.rows {
            Rows::Auto => self.with_branches(&found, (first, planar), pairs),
            Rows::Paper => found.clone(),
        };
        if first.ahead {
            first.aim_at_end(setup, start, &mut rows);
        }
        join(&mut rows, walls);
        let recalled = pairs.multipliers(&rows);
        pairs.keep(&found, &rows);
        (rows, recalled)
    }

    /// The branches of near pairs (sorted) that may become active in the step, and those that ended the last one with a
    /// multiplier.
    fn with_branches(self, near: &[Near], (first, planar): (&First, bool), pairs: &Pairs) -> Vec<Near> {
        let Stages { setup, start, motions, .. } = self;
        let of_pair = |near: &Near| {
            let [a, b] = near.pair.map(|i| i as usize);
            let [of_a, of_b] = first.pair(start, a, b);
            let [last_a, last_b] = [a, b].map(|i| start.bodies.twist(i));
            let turned = start.interval * (last_b.angular - last_a.angular);
            let slid = start.interval * (last_b.linear - last_a.linear + start.sheared_velocity(setup, a, b)).length();
            let slack = branch_slack(&of_a, &of_b, &near.found, (turned, slid), planar);
            let most = near.found.separation + slack;
            let recalled = pairs.recalled(pairs.get(near.pair));
            let pushed = |feature: u32| recalled.iter().filter(|w| w.feature == feature).any(|w| w.gamma > 0.0);
            let mut rows = Vec::new();
            let limit = motions.limit(setup, start, a, b);
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

    /// The rows of all near pairs of sub-spheres, likewise.
    pub(super) fn of_sub_spheres(
        self,
        candidates: &[[u32; 2]],
        first: &First,
        pairs: &Pairs,
    ) -> (Vec<Near>, Vec<Recalled>) {
        let Stages { setup, start, motions, .. } = self;
        let reach =
            |i: usize| if start.is_held(i) { f64::NEG_INFINITY } else { setup.cutoff + motions.reach[i].either };
        let mut rows = Vec::new();
        for &pair in candidates {
            let [a, b] = pair.map(|i| i as usize);
            let [of_a, of_b] = first.pair(start, a, b);
            let proxies = [start.proxies[a].as_slice(), start.proxies[b].as_slice()];
            if start.never_collide(a, b) {
                continue;
            }
            let limit = setup.cutoff + motions.reach[a].either + motions.reach[b].either;
            sub_sphere_separations([&of_a, &of_b], proxies, limit, |feature, found| {
                rows.push(Near { pair, feature, found })
            });
        }
        let placed = |i: usize| first.placed(start, i);
        let mut walls = walls::near_sub_spheres(start.walls(setup), &start.proxies, placed, reach);
        if let Some(middle) = start.walls_in_middle() {
            walls::turn_sub_spheres_to(middle, &start.proxies, &mut walls, placed);
        }
        join(&mut rows, walls);
        let mut all = Vec::with_capacity(rows.len());
        for of_pair in rows.chunk_by(|near, next| near.pair == next.pair) {
            let recalled = pairs.recalled(pairs.get(of_pair[0].pair));
            let of_row = |near: &Near| recalled.binary_search_by_key(&near.feature, |w| w.feature);
            all.extend(
                of_pair.iter().map(|near| of_row(near).map_or_else(|_| Recalled::default(), |at| recalled[at].into())),
            );
        }
        (rows, all)
    }

    /// A first row's separation with the lengths at the end of the step, where those in its middle are others.
    pub(super) fn at_end_lengths(self, mut near: Near) -> Near {
        let Stages { setup, start, .. } = self;
        if let (Some(middle), true) = (&start.middle, setup.growth.is_some()) {
            let Separation { normal, lever_a, lever_b, .. } = near.found;
            let stretch = |number: u32, lever: DVec3, normal: DVec3| match surface_of(number) {
                Some(_) => DVec3::ZERO,
                None => {
                    let body = number as usize;
                    dynamics::stretch(&middle.placed(body), &start.bodies.shape[body], lever, normal)
                }
            };
            let [a, b] = near.pair;
            near.found.separation += normal.dot(stretch(b, lever_b, -normal) - stretch(a, lever_a, normal));
        }
        near
    }
}

/// Puts bodies near walls among the near pairs.
pub(super) fn join(near: &mut Vec<Near>, walls: Vec<Near>) {
    if !walls.is_empty() {
        near.extend(walls);
        near.sort_by_key(|near| (near.pair, near.feature));
    }
}
