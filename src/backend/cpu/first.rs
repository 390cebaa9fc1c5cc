//! First rows: where they are made, which pairs and walls have one, and how they are aimed at the end of the step.
//!
//! In the plane the last velocities `U_last` lead a part [`AHEAD`] of the step ahead. Normals and levers are those of
//! that configuration. The offsets make the rows exact at the end of the step, `g(U_last) = Phi(C(U_last))`: what a
//! first row is wrong by is of second order in `U - U_last`.

use super::narrow_phase::Near;
use super::{Cpu, LEAST_BODIES_A_TASK};
use crate::constraint::{self, RowSource, torque_arm};
use crate::dynamics::{self, Pose, Twist};
use crate::separation::{Placed, branches};
use crate::step::{Fault, Model, Rows, Stepping};
use glam::DVec3;
use rayon::prelude::*;
use std::time::Instant;

/// The part of a step that first rows are made ahead of its start, where the last velocities lead. The error at the end
/// of the colony of `relcp study work-precision` changes its sign near 1/4: with 1,024 steps it is 3.9e-2, 2.7e-3,
/// 6.5e-2 and 1.5e-1 for 0, 1/4, 1/2 and 1. Steps with a middle, whose rows are made there, lose by it: 8e-4, 1.5e-3,
/// 2.3e-3 and 4.0e-3.
pub(crate) const AHEAD: f64 = 0.25;

/// First rows are made where the last velocities lead if no overlap there is deeper than this part of the thinnest
/// body, and aimed at the end of the step if this moves their offsets by less. Deeper, normals may point to the wrong
/// side; a larger move is no curvature, but a body that has gone through another.
pub(crate) const DEEPEST_AHEAD: f64 = 0.125;

impl<const D: usize> Cpu<D> {
    /// Chooses where first rows are made: where the last velocities lead in a part of the step, or at its start.
    pub(super) fn predict(&mut self, ahead: bool) {
        self.ahead = ahead;
        let bodies = self.start.len();
        self.reached.clear();
        if ahead {
            let part = |v: DVec3| AHEAD * v;
            let of_last = |Twist { linear, angular }| Twist { linear: part(linear), angular: part(angular) };
            self.reached.extend((0..bodies).map(|i| of_last(self.start.twist(i))));
        } else {
            self.reached.resize(bodies, Twist::default());
        }
        let (start, reached, dt) = (&self.start, &self.reached, self.interval);
        let of_body = |i: usize| match ahead {
            true => dynamics::advance(Self::pose_in(start, i), reached[i], dt),
            false => Self::pose_in(start, i),
        };
        (0..bodies).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).map(of_body).collect_into_vec(&mut self.first);
    }

    /// Makes the first rows where [`Cpu::predict`] chose.
    pub(super) fn append_near_where_chosen(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        self.check_periods()?;
        constraint::clear(&mut self.problem, self.start.len() + self.walls.len());
        self.feature.clear();
        self.gamma.clear();
        self.changed = true;
        let shapes = &self.here().shape;
        let boxes = self.boxes(shapes, |i| self.first[i], |i| 0.5 * self.cutoff + self.reach[i].either);
        let mut candidates = std::mem::take(&mut self.candidates);
        let pairs = candidates.ensure(&boxes);
        self.phases.broad_phase += begun.elapsed();
        let begun = Instant::now();
        match self.source {
            RowSource::Surfaces => self.append_near_surfaces(pairs),
            RowSource::SubSpheres { .. } => self.append_near_sub_spheres(pairs),
        }
        self.candidates = candidates;
        self.first_rows = self.gamma.len();
        if self.middle.is_some() {
            self.proxies = self.source.proxies(&self.start.shape).map_err(Fault::NoProxy)?;
        }
        self.phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    /// Moves the separations of near pairs that were found ahead so that their rows are exact where the last velocities
    /// lead at the end of the step. Walls keep their own: a place of a body at a wall moves along a line but for the
    /// turning of its lever.
    pub(super) fn aim_at_end(&self, near: &mut [Near]) {
        let dt = self.interval;
        let at_end = |i: usize| {
            let Pose { position, orientation } =
                dynamics::advance(Self::pose_in(&self.start, i), self.start.twist(i), dt);
            Placed { shape: self.start.shape[i], position, orientation }
        };
        // Once a body, which has several near pairs.
        let bodies = 0..self.start.len();
        let ends: Vec<Placed> = bodies.into_par_iter().with_min_len(LEAST_BODIES_A_TASK).map(at_end).collect();
        // What is left of the way, and the turning that led ahead.
        let left = |i: usize| {
            let (last, reached) = (self.start.twist(i), self.reached[i]);
            (last.linear - reached.linear, last.angular - reached.angular, reached.angular)
        };
        near.par_iter_mut().with_min_len(LEAST_BODIES_A_TASK).for_each(|near| {
            let [a, b] = near.pair.map(|i| i as usize);
            let [of_a, of_b] = self.start.periods.pair(ends[a], ends[b]);
            let Some(separation) = branches::separation_at(&of_a, &of_b, near.feature) else { return };
            let (linear_a, angular_a, turned_a) = left(a);
            let (linear_b, angular_b, turned_b) = left(b);
            let found = &mut near.found;
            let arm_a = torque_arm(found.lever_a, found.normal, turned_a, dt);
            let arm_b = torque_arm(found.lever_b, found.normal, turned_b, dt);
            let rate = found.normal.dot(linear_b - linear_a) + arm_b.dot(angular_b) - arm_a.dot(angular_a);
            let aimed = separation - dt * rate;
            if (aimed - found.separation).abs() <= DEEPEST_AHEAD * self.thinnest {
                found.separation = aimed;
            }
        });
    }
}

/// Whether first rows of a scene's steps may be made ahead of their start: in Euler steps without inertia. With inertia
/// rows at the start keep the angular momentum of a pair to rounding, and rows ahead do not.
pub(super) fn leads_ahead(model: &Model) -> bool {
    let inertial = model.dynamics.has_inertia();
    model.contact.rows_of_method() == Rows::Auto && model.time.stepping == Stepping::Euler && !inertial
}
