//! The trial: `U`, `C(U)`, and the overlaps there.

use super::LEAST_BODIES_A_TASK;
use super::motions::Motions;
use super::narrow_phase::Near;
use super::near::LEAST_PAIRS_A_TASK;
use super::row_set::RowSet;
use super::setup::Setup;
use super::start::Start;
use super::trouble::Trouble;
use super::walls::past_wall;
use crate::bodies::Bodies;
use crate::constraint::{self, sub_sphere_separations};
use crate::dynamics::{self, Pose, Twist};
use crate::freedom::{pack, unpack};
use crate::lcp;
use crate::separation::{Placed, branches};
use crate::step::{Overlap, Rows};
use crate::walls::surface_of;
use rayon::prelude::*;

/// The trial of the present multipliers.
#[derive(Default)]
pub(super) struct Trial<const D: usize> {
    pub(super) twist: Vec<Twist>,
    pub(super) poses: Vec<Pose>,
    /// The pairs, and bodies at walls, that overlap; sorted by pair.
    pub(super) overlapping: Vec<Near>,
    /// The poses that these were found at, if in the present part of a step.
    seen: Vec<Pose>,
    /// The overlap from which on a pair is a violation.
    violating: f64,
    /// `J^T gamma`.
    pub(super) scaled: Vec<[f64; D]>,
    /// The part of it of bonds; empty where there are none.
    pub(super) bonded: Vec<[f64; D]>,
}

impl<const D: usize> Trial<D> {
    /// Begins a part of a step.
    pub(super) fn begin(&mut self) {
        self.seen.clear();
    }

    /// Which bodies rest since the last trial of this part; empty if it is the first one.
    pub(super) fn rests(&self) -> Vec<bool> {
        let of_body = |(seen, now): (&Pose, &Pose)| seen == now;
        if self.seen.len() == self.poses.len() {
            let both = self.seen.par_iter().zip(&self.poses).with_min_len(LEAST_BODIES_A_TASK);
            both.map(of_body).collect()
        } else {
            Vec::new()
        }
    }

    /// Computes the trial's velocities in the scaled unknowns.
    pub(super) fn set_scaled(&mut self, rows: &RowSet<D>) {
        lcp::velocity_into(&rows.problem, &rows.gamma, &mut self.scaled);
    }

    /// Computes the trial's twists and poses. Returns the first body whose velocity is not finite; else the first whose
    /// pose is not.
    pub(super) fn set(&mut self, motions: &Motions, start: &Start) -> Option<Trouble> {
        let (dt, scaled) = (start.interval, &self.scaled);
        let of_body = |i: usize| {
            if start.is_held(i) {
                return (Twist::default(), start.pose(i));
            }
            let twist = constraint::velocity(&motions.motion[i], &scaled[i], dt);
            (twist, dynamics::advance(start.pose(i), twist, dt))
        };
        (0..start.bodies.len())
            .into_par_iter()
            .with_min_len(LEAST_BODIES_A_TASK)
            .map(of_body)
            .unzip_into_vecs(&mut self.twist, &mut self.poses);
        let finite = |t: &Twist| t.linear.is_finite() && t.angular.is_finite();
        // Other processes check their bodies.
        let own = || {
            let all = (0..self.twist.len()).into_par_iter().with_min_len(LEAST_BODIES_A_TASK);
            all.filter(|i| !start.is_foreign(*i))
        };
        if let Some(body) = own().find_first(|i| !finite(&self.twist[*i])) {
            return Some(Trouble { kind: 0, body, number: 0.0 });
        }
        // A finite velocity can still be too large to arrive anywhere: the square of a quaternion's length overflows.
        let arrives = |p: &Pose| p.position.is_finite() && p.orientation.is_normalized();
        let lost = own().find_first(|i| !arrives(&self.poses[*i]));
        lost.map(|body| Trouble { kind: 1, body, number: 0.0 })
    }

    /// The velocities that the present part ends with.
    pub(super) fn arrived(&self, setup: &Setup, start: &Start, motions: &Motions) -> Vec<Twist> {
        let (here, (law, _)) = (start.bodies_at_loads(), setup.law(start.parting));
        let of_body = |i: usize| {
            if start.parting {
                return start.bodies.twist(i);
            }
            let twist = law.arrived(here, i, &motions.motion[i], self.twist[i], self.poses[i].orientation);
            // What the scene does not carry is exactly zero.
            let (linear, angular) = unpack::<D>(&pack(twist.linear, twist.angular));
            Twist { linear, angular }
        };
        (0..start.bodies.len()).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).map(of_body).collect()
    }

    /// Moves bodies to the trial.
    pub(super) fn arrive(&self, bodies: &mut Bodies, arrived: &[Twist]) {
        let places = bodies.position.par_iter_mut().zip(&mut bodies.orientation);
        let velocities = bodies.velocity.par_iter_mut().zip(&mut bodies.angular_velocity);
        let all = places.zip(velocities).zip(self.poses.par_iter().zip(arrived));
        all.with_min_len(LEAST_BODIES_A_TASK).for_each(
            |(((position, orientation), (linear, angular)), (pose, twist))| {
                (*position, *orientation) = (pose.position, pose.orientation);
                (*linear, *angular) = (twist.linear, twist.angular);
            },
        );
    }

    pub(super) fn placed(&self, start: &Start, i: usize) -> Placed {
        start.placed_at(i, self.poses[i])
    }

    pub(super) fn pair(&self, start: &Start, a: usize, b: usize) -> [Placed; 2] {
        start.periods.pair(self.placed(start, a), self.placed(start, b))
    }

    /// The pair that overlaps most, and by how much.
    pub(super) fn worst(&self) -> Option<&Near> {
        self.overlapping.iter().min_by(|p, q| p.found.separation.total_cmp(&q.found.separation))
    }

    /// Stores the overlapping pairs and returns the overlap.
    pub(super) fn set_overlapping(
        &mut self,
        setup: &Setup,
        start: &Start,
        overlapping: Vec<Near>,
        violating: f64,
    ) -> Overlap {
        (self.overlapping, self.violating) = (overlapping, violating);
        self.seen.clone_from(&self.poses);
        let worst = self.worst();
        let violates = |near: &&Near| near.found.separation < -violating && !start.is_foreign(near.pair[0] as usize);
        Overlap {
            worst: worst.map_or(0.0, |near| (-near.found.separation).max(0.0)),
            pair: worst.filter(|near| surface_of(near.pair[1]).is_none()).map(|near| near.pair.map(|i| i as usize)),
            wall: worst.and_then(|near| Some([near.pair[0] as usize, setup.walls.wall_of(surface_of(near.pair[1])?)])),
            violations: self.overlapping.iter().filter(violates).count(),
            proxy: self.worst_proxy_overlap(setup, start),
            stretch: 0.0,
            bond: None,
        }
    }

    fn worst_proxy_overlap(&self, setup: &Setup, start: &Start) -> Option<f64> {
        if start.proxies.is_empty() {
            return None;
        }
        // Sub-spheres lie inside their surfaces, so only pairs whose surfaces overlap can have sub-spheres that do.
        let mut worst = 0.0f64;
        for near in &self.overlapping {
            let [a, b] = near.pair.map(|i| i as usize);
            if let Some(surface) = surface_of(near.pair[1]) {
                worst = worst.max(past_wall(start.walls(setup), &start.proxies[a], &self.placed(start, a), surface));
                continue;
            }
            let [of_a, of_b] = self.pair(start, a, b);
            let proxies = [start.proxies[a].as_slice(), start.proxies[b].as_slice()];
            sub_sphere_separations([&of_a, &of_b], proxies, 0.0, |_, found| worst = worst.max(-found.separation));
        }
        Some(worst)
    }

    /// All violations: overlaps above the limit, one for each pair with the paper's rows, otherwise one for each
    /// branch.
    pub(super) fn violations(&self, setup: &Setup, start: &Start) -> Vec<Near> {
        let over = |near: &&Near| near.found.separation < -self.violating;
        if setup.rows == Rows::Paper {
            return self.overlapping.iter().filter(over).copied().collect();
        }
        let of_pair = |near: &Near| {
            if surface_of(near.pair[1]).is_some() {
                return vec![*near];
            }
            let mut violated = Vec::new();
            let [a, b] = near.pair.map(|i| i as usize);
            let [of_a, of_b] = self.pair(start, a, b);
            branches(&of_a, &of_b, &near.found, -self.violating - near.found.separation, |feature, found| {
                violated.push(Near { pair: near.pair, feature, found });
            });
            violated
        };
        self.overlapping.par_iter().with_min_len(LEAST_PAIRS_A_TASK).filter(over).flat_map_iter(of_pair).collect()
    }
}
