//! First rows: where they are made, and how they are aimed at the end of the step.
//!
//! In the plane the last velocities `U_last` lead a part [`AHEAD`] of the step ahead. Normals and levers are those of
//! that configuration. The offsets make the rows exact at the end of the step, `g(U_last) = Phi(C(U_last))`: what a
//! first row is wrong by is of second order in `U - U_last`.
//!
//! In a periodic cell whose lengths change they are made where its flow leads in the whole step.

use super::LEAST_BODIES_A_TASK;
use super::narrow_phase::Near;
use super::setup::Setup;
use super::start::Start;
use crate::constraint::torque_arm;
use crate::dynamics::{self, Pose, Twist};
use crate::separation::{Placed, branches};
use glam::DVec3;
use rayon::prelude::*;

/// The part of a step that first rows are made ahead of its start, where the last velocities lead. The error at the end
/// of the colony of the study `work-precision` changes its sign near 1/4: with 1,024 steps it is 3.9e-2, 2.7e-3, 6.5e-2
/// and 1.5e-1 for 0, 1/4, 1/2 and 1. Midpoint steps, whose rows are made at the middle, get worse with it: 8e-4,
/// 1.5e-3, 2.3e-3 and 4.0e-3.
pub(crate) const AHEAD: f64 = 0.25;

/// First rows are made where the last velocities lead if no overlap there is deeper than this part of the thinnest
/// body, and aimed at the end of the step if this moves their offsets by less. Deeper, normals may point to the wrong
/// side; a larger move is no curvature, but a body that has gone through another.
pub(crate) const DEEPEST_AHEAD: f64 = 0.125;

/// Where first rows are made.
#[derive(Default)]
pub(super) struct First {
    /// Whether that is where the last velocities lead.
    pub(super) ahead: bool,
    /// The velocities that lead from the start to there, in the length of the part, and the poses there.
    pub(super) reached: Vec<Twist>,
    poses: Vec<Pose>,
    /// The deepest overlap where the first rows of the start were made.
    pub(super) overlap: f64,
}

impl First {
    /// Chooses where the last velocities lead in a part of the step, or its start; in a cell whose lengths change where
    /// its flow leads, so that nothing depends on which image a body is.
    pub(super) fn predict(&mut self, setup: &Setup, start: &Start, ahead: bool) {
        self.ahead = ahead;
        let bodies = start.bodies.len();
        self.reached.clear();
        let carried = setup.strain.filter(|_| !start.parting);
        if let Some(strain) = carried {
            let rates = strain.rates(start.time);
            let of = |x: &DVec3| Twist { linear: strain.velocity(*x, rates), angular: DVec3::ZERO };
            let positions = start.bodies.position.par_iter().with_min_len(LEAST_BODIES_A_TASK);
            positions.map(of).collect_into_vec(&mut self.reached);
        } else if ahead {
            let part = |v: DVec3| AHEAD * v;
            let of_last = |Twist { linear, angular }| Twist { linear: part(linear), angular: part(angular) };
            let last = (0..bodies).into_par_iter().with_min_len(LEAST_BODIES_A_TASK);
            last.map(|i| of_last(start.bodies.twist(i))).collect_into_vec(&mut self.reached);
        } else {
            self.reached.resize(bodies, Twist::default());
        }
        let reached = &self.reached;
        let of_body = |i: usize| match ahead || carried.is_some() {
            true => dynamics::advance(start.pose(i), reached[i], start.interval),
            false => start.pose(i),
        };
        (0..bodies).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).map(of_body).collect_into_vec(&mut self.poses);
    }

    /// Chooses the middle of the step: the poses and velocities of the trial of its first half.
    pub(super) fn set_middle(&mut self, twists: &[Twist], poses: &[Pose]) {
        // `dt/2 U_h` is `dt` times half of it.
        let half = |t: &Twist| Twist { linear: 0.5 * t.linear, angular: 0.5 * t.angular };
        self.reached.clear();
        self.reached.extend(twists.iter().map(half));
        self.poses.clear();
        self.poses.extend_from_slice(poses);
    }

    pub(super) fn pose(&self, i: usize) -> Pose {
        self.poses[i]
    }

    /// Body `i` there.
    pub(super) fn placed(&self, start: &Start, i: usize) -> Placed {
        let Pose { position, orientation } = self.poses[i];
        Placed { shape: start.bodies_at_loads().shape[i], position, orientation }
    }

    pub(super) fn pair(&self, start: &Start, a: usize, b: usize) -> [Placed; 2] {
        start.periods.pair(self.placed(start, a), self.placed(start, b))
    }

    /// Whether an overlap there is too deep for rows ahead.
    pub(super) fn is_too_deep(&self, setup: &Setup) -> bool {
        self.ahead && self.overlap > DEEPEST_AHEAD * setup.thinnest
    }

    /// Moves the separations of near pairs that were found ahead so that their rows are exact where the last velocities
    /// lead at the end of the step. Walls keep their own: a place of a body at a wall moves along a line but for the
    /// turning of its lever.
    pub(super) fn aim_at_end(&self, setup: &Setup, start: &Start, near: &mut [Near]) {
        let dt = start.interval;
        let at_end = |i: usize| start.placed_at(i, dynamics::advance(start.pose(i), start.bodies.twist(i), dt));
        // Once a body, which has several near pairs.
        let bodies = 0..start.bodies.len();
        let ends: Vec<Placed> = bodies.into_par_iter().with_min_len(LEAST_BODIES_A_TASK).map(at_end).collect();
        // What is left of the way, and the turning that led ahead.
        let left = |i: usize| {
            let (last, reached) = (start.bodies.twist(i), self.reached[i]);
            (last.linear - reached.linear, last.angular - reached.angular, reached.angular)
        };
        near.par_iter_mut().with_min_len(LEAST_BODIES_A_TASK).for_each(|near| {
            let [a, b] = near.pair.map(|i| i as usize);
            let [of_a, of_b] = start.periods.pair(ends[a], ends[b]);
            let Some(separation) = branches::separation_at(&of_a, &of_b, near.feature) else { return };
            let (linear_a, angular_a, turned_a) = left(a);
            let (linear_b, angular_b, turned_b) = left(b);
            let found = &mut near.found;
            let arm_a = torque_arm(found.lever_a, found.normal, turned_a, dt);
            let arm_b = torque_arm(found.lever_b, found.normal, turned_b, dt);
            let rate = found.normal.dot(linear_b - linear_a) + arm_b.dot(angular_b) - arm_a.dot(angular_a);
            let aimed = separation - dt * rate;
            if (aimed - found.separation).abs() <= DEEPEST_AHEAD * setup.thinnest {
                found.separation = aimed;
            }
        });
    }
}
