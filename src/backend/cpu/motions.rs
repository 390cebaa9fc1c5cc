//! The free motions of bodies in a step, how far they may still go, and the rows that follow from them.

use super::LEAST_BODIES_A_TASK;
use super::first::First;
use super::narrow_phase::Near;
use super::setup::Setup;
use super::start::Start;
use super::trouble::Trouble;
use crate::constraint::{self, FIXED, Mover, Row};
use crate::dynamics::{ForceField, Load, Motion, Twist};
use crate::step::Rows;
use crate::walls::surface_of;
use glam::DVec3;
use rayon::prelude::*;

/// How far a body may still move on its own from where first rows are made, lengths: its centre, its surface as it
/// turns, and both.
#[derive(Clone, Copy, Default)]
pub(super) struct Reach {
    linear: DVec3,
    angular: f64,
    pub(super) either: f64,
}

/// Loads, effective mobilities and free velocities, and reaches, by body.
#[derive(Default)]
pub(super) struct Motions {
    pub(super) motion: Vec<Motion>,
    pub(super) reach: Vec<Reach>,
}

impl Motions {
    pub(super) fn set(&mut self, setup: &Setup, start: &Start, first: &First, step: u64) {
        let heat = setup.heat.filter(|_| !start.parting);
        let (dt, here) = (start.interval, start.bodies_at_loads());
        let time = start.time_of_loads();
        let (law, forces) = setup.law(start.parting);
        let share = |force: &dyn ForceField| force.share(start.span());
        let acting = forces.iter().map(|force| (force, share(force.as_ref())));
        let acting: Vec<_> = acting.filter(|(_, share)| *share > 0.0).collect();
        let of_body = |i: usize| {
            if start.is_held(i) {
                return (*FIXED.motion, Reach::default());
            }
            let mut load = Load::default();
            for (force, share) in &acting {
                load += *share * force.load(here, i, time);
            }
            if let Some(incidence) = &start.bonds {
                load += setup.bonds.load(incidence, here, i);
            }
            if let Some(heat) = heat {
                let numbers = (here.lineage[i].id, step);
                load += heat.load(&here.shape[i], here.orientation[i], numbers, start.step_length(setup));
            }
            let mut motion = match &start.middle {
                Some(middle) => law.motion_by_middle(&start.bodies, middle, i, load, dt),
                None => law.motion(here, i, load, dt),
            };
            if let Some(shake) = &start.shake {
                motion.free = shake.of_body(&here.shape[i], here.lineage[i].id, (setup.seed, step), dt);
            }
            let reached = first.reached[i];
            let linear = motion.free.linear - reached.linear;
            let angular = (motion.free.angular - reached.angular).length() * here.shape[i].bounding_radius();
            (motion, Reach { linear: dt * linear, angular: dt * angular, either: dt * (linear.length() + angular) })
        };
        (0..here.len())
            .into_par_iter()
            .with_min_len(LEAST_BODIES_A_TASK)
            .map(of_body)
            .unzip_into_vecs(&mut self.motion, &mut self.reach);
    }

    /// The distance within which a pair is near where first rows are made; less than any where neither moves.
    pub(super) fn limit(&self, setup: &Setup, start: &Start, a: usize, b: usize) -> f64 {
        if start.never_collide(a, b) {
            return f64::NEG_INFINITY;
        }
        let (a, b) = (&self.reach[a], &self.reach[b]);
        match setup.rows {
            Rows::Paper => setup.cutoff + a.either + b.either,
            Rows::Auto => setup.cutoff + (b.linear - a.linear).length() + a.angular + b.angular,
        }
    }

    /// The blocks and the offset of the normal row of `near`, which was found where the velocities `reached` lead in
    /// the present part.
    pub(super) fn row<const D: usize>(&self, start: &Start, near: &Near, reached: &[Twist]) -> Row<D> {
        let movers = near.pair.map(|number| self.mover(start, number, reached));
        constraint::row(&near.found, movers, start.interval)
    }

    /// A body's or a wall's part in the rows of a contact.
    pub(super) fn mover<'a>(&'a self, start: &'a Start, number: u32, reached: &[Twist]) -> Mover<'a> {
        match surface_of(number) {
            Some(surface) => start.loaded_wall(surface).map_or(FIXED, |wall| wall.mover(start.interval)),
            None => {
                let body = number as usize;
                let axis = start.axis_of_revolution(body);
                Mover { motion: &self.motion[body], reached_with: reached[body], axis }
            }
        }
    }

    /// The first body that reaches, or moves freely in this step, too far for the shortest period, so that other images
    /// than the nearest could come near; else the first so far away that nearest images are made of rounding.
    pub(super) fn beyond_periods(&self, setup: &Setup, start: &Start) -> Option<Trouble> {
        let Start { bodies, .. } = start;
        let period = start.periods.shortest()?;
        let span = |body: usize| 2.0 * (bodies.shape[body].bounding_radius() + self.reach[body].either) + setup.cutoff;
        // Not a number is refused.
        let fits = |body: usize| span(body) <= 0.5 * period;
        let all = || {
            let all = (0..bodies.len()).into_par_iter().with_min_len(LEAST_BODIES_A_TASK);
            all.filter(|body| !start.is_foreign(*body))
        };
        if let Some(body) = all().find_first(|body| !fits(*body)) {
            return Some(Trouble { kind: 0, body, number: span(body) });
        }
        let far = |body: usize| start.periods.farthest(bodies.position[body]) * f64::EPSILON > setup.overlap_tolerance;
        all().find_first(|body| far(*body)).map(|body| Trouble { kind: 1, body, number: 0.0 })
    }
}
