//! The verbs of a timestep on the CPU, in f64, generic over the number of unknowns of a body.
//!
//! A step passes through stages, each in a file of its own: its `start`, how bodies move on their own (`motions`),
//! where `first` rows are made and which pairs have one (`near`), the `row_set`, the `solve` and the `trial`. A stage
//! writes what it owns and reads those before it. `pairs` holds one record a pair for all of them.
//!
//! Parallel loops write to places of their own or collect in order, so the bits do not depend on the number of threads.
//! Where several processes take the steps, each has a `domain` of the bodies.

mod again;
mod domain;
pub(super) mod first;
mod motions;
mod narrow_phase;
mod near;
mod pairs;
mod row_set;
mod setup;
mod solve;
mod start;
mod together;
mod trial;
pub(super) mod two_sided;
mod walls;

#[cfg(feature = "mpi")]
pub(crate) use domain::{Part, among};
#[cfg(feature = "mpi")]
pub(crate) use together::{Given, shares};

use crate::bodies::{Bodies, Lineage};
use crate::broad_phase::{Aabb, Candidates};
use crate::constraint::{RowSource, RowSourceError};
use crate::dynamics::{ForceField, Pose, Waiting};
use crate::freedom::PLANAR;
use crate::lcp::{Outcome, Problem, Status, Stored};
use crate::separation::{planar_separation, separation};
use crate::shape::Shape;
use crate::step::{
    Backend, Divided, Effect, Fault, JOINED, Model, Overlap, Passed, Phases, Piece, RetryBackend, State, TwoSided,
};
use crate::walls::surface_of;
use crate::warm::Warm;
use domain::Domain;
use first::First;
use glam::DVec3;
use motions::Motions;
use narrow_phase::Separate;
use near::Stages;
use pairs::Pairs;
use rayon::prelude::*;
use row_set::RowSet;
use setup::Setup;
use solve::Solve;
use start::Start;
use std::time::{Duration, Instant};
use trial::Trial;

/// A loop over fewer bodies than this runs on one thread: below it, handing out the work costs more than it saves
/// (a body's share of any of these loops is 20 to 100 ns, waking a thread some 5 us).
const LEAST_BODIES_A_TASK: usize = 512;

/// The CPU backend. `D` is [`crate::freedom::PLANAR`] or [`crate::freedom::SPATIAL`].
pub struct Cpu<const D: usize> {
    setup: Setup,
    /// The last accepted state.
    state: State,
    /// What of a step that is taken in pieces comes next, and the cells that wait in it.
    next: Option<(Piece, Waiting)>,
    start: Start,
    motions: Motions,
    first: First,
    pairs: Pairs,
    rows: RowSet<D>,
    solve: Solve<D>,
    trial: Trial<D>,
    candidates: Candidates,
    /// Rows that a step may go back to.
    kept: Option<RowSet<D>>,
    /// Forces beside the scene's own.
    added_forces: usize,
    /// What of a step is this process's, where several take it.
    domain: Option<Domain>,
    phases: Phases,
}

impl<const D: usize> Cpu<D> {
    const SEPARATE: Separate = if D == PLANAR { planar_separation } else { separation };

    /// A backend for `model` in `state`.
    pub fn new(model: &Model, mut state: State) -> Result<Self, RowSourceError> {
        let setup = Setup::new(model, &state.bodies);
        setup.source.proxies(&state.bodies.shape)?;
        if let Some(cells) = &model.cells {
            cells.settle(&mut state.bodies);
        }
        let now = |strain: crate::dynamics::Strain| strain.periods(model.time.after(state.step));
        state.bodies.periods = model.strain.map_or(model.periods, now);
        state.bodies.planar = model.planar;
        state.unrounded = None;
        // What is remembered of another scene's walls is of no use.
        state.warm.retain(|w| surface_of(w.pair[1]).is_none_or(|surface| surface < setup.walls.len()));
        Ok(Cpu {
            next: None,
            start: Start::new(model.time.dt, state.next_id),
            motions: Motions::default(),
            first: First::default(),
            pairs: Pairs::default(),
            rows: RowSet::new(),
            solve: Solve::new(model),
            trial: Trial::default(),
            candidates: Candidates::in_space(model.periods),
            kept: None,
            added_forces: 0,
            domain: None,
            phases: Phases::default(),
            setup,
            state,
        })
    }

    /// The present LCP and its multipliers, for diagnosis and tests.
    pub fn lcp(&self) -> (&Problem<D>, &[f64]) {
        (&self.rows.problem, &self.rows.gamma)
    }

    /// Which of its pair's contacts each row is of.
    pub fn features(&self) -> &[u32] {
        &self.rows.feature
    }

    /// The number of the step that is being taken.
    fn step(&self) -> u64 {
        self.state.step + 1
    }

    /// What the next step starts from: for each pair with rows, their multipliers and the last normal.
    fn left(&self) -> Vec<Warm> {
        let mut warm = self.rows.left(&self.pairs);
        for w in warm.iter_mut().filter(|_| self.start.proxies.is_empty()) {
            if let Some(surface) = surface_of(w.pair[1]) {
                let placed = self.trial.placed(&self.start, w.pair[0] as usize);
                w.normal = walls::normal_at(self.start.walls(&self.setup), &placed, surface, w.feature);
            }
        }
        warm
    }

    /// Makes first rows where [`First::predict`] or [`First::set_middle`] chose.
    fn append_first(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        self.check_periods()?;
        let Cpu { setup, start, motions, first, pairs, rows, candidates, domain, phases, .. } = self;
        rows.clear(start.bodies.len(), setup.walls.len());
        let margin = |i: usize| 0.5 * setup.cutoff + motions.reach[i].either;
        let boxes = boxes(&start.here().shape, |i| first.pose(i), margin);
        let candidates = together::candidates(domain, candidates, &boxes)?;
        phases.broad_phase += begun.elapsed();
        let begun = Instant::now();
        pairs.recall();
        let stages = Stages { setup, start, motions };
        let (near, gamma) = match setup.source {
            RowSource::Surfaces => stages.of_surfaces((candidates, Self::SEPARATE, D == PLANAR), first, pairs),
            RowSource::SubSpheres { .. } => stages.of_sub_spheres(candidates, first, pairs),
        };
        if let Some(domain) = domain {
            first.overlap = domain.largest(first.overlap);
        }
        for (near, gamma) in near.iter().zip(gamma) {
            let near = stages.at_end_lengths(*near);
            rows.append(&near, motions.row(start, &near, &first.reached), gamma);
        }
        if start.middle.is_some() {
            start.make_proxies(setup)?;
        }
        phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    /// Answers all violations: the first row of a contact is tightened where it can be, others are appended.
    fn answer_violations(&mut self, tightens: bool) {
        let Cpu { setup, start, motions, pairs, rows, trial, phases, .. } = self;
        timed(&mut phases.narrow_phase, || {
            for near in trial.violations(setup, start) {
                let row: ([[f64; D]; 2], f64) = motions.row(start, &near, &trial.twist);
                if !(tightens && rows.tighten(&near, pairs, &row.0, &trial.scaled)) {
                    rows.append(&near, row, 0.0);
                }
            }
        });
    }
}

/// The boxes of all bodies in the poses `pose(i)`, each widened by `margin(i)`.
fn boxes(shapes: &[Shape], pose: impl Fn(usize) -> Pose + Sync, margin: impl Fn(usize) -> f64 + Sync) -> Vec<Aabb> {
    let of_body = |i: usize| {
        let pose = pose(i);
        let half = shapes[i].half_extents(pose.orientation) + DVec3::splat(margin(i));
        Aabb { min: pose.position - half, max: pose.position + half }
    };
    (0..shapes.len()).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).map(of_body).collect()
}

/// Runs `work` and adds its wall time to `total`.
fn timed<T>(total: &mut Duration, work: impl FnOnce() -> T) -> T {
    let begun = Instant::now();
    let out = work();
    *total += begun.elapsed();
    out
}

impl<const D: usize> Backend for Cpu<D> {
    fn begin(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let step = self.step();
        // A step that is taken again was led astray once: its pieces are linearised at their starts.
        let whole = self.next.is_none() && !self.start.parting;
        let taken = self.next.take().unwrap_or((Piece::WHOLE, Waiting::None));
        let places = self.begin_with(taken)?;
        let Cpu { setup, start, motions, first, solve, candidates, phases, .. } = self;
        candidates.set_periods(start.periods);
        solve.begin(places);
        phases.growth += begun.elapsed();
        let begun = Instant::now();
        setup.prepare(start, step)?;
        first.predict(setup, start, D == PLANAR && setup.leads_ahead && whole);
        motions.set(setup, start, first, step);
        phases.integrate += begun.elapsed();
        Ok(())
    }

    fn middle(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let step = self.step();
        self.set_trial()?;
        let left = self.left();
        let Cpu { setup, start, motions, first, pairs, trial, phases, .. } = self;
        pairs.remember(&left);
        let mut middle = start.bodies.clone();
        middle.periods = start.periods;
        trial.arrive(&mut middle, &trial.arrived(setup, start, motions));
        start.set_middle(setup, middle);
        first.set_middle(trial);
        setup.prepare(start, step)?;
        motions.set(setup, start, first, step);
        phases.integrate += begun.elapsed();
        Ok(())
    }

    fn append_near(&mut self) -> Result<(), Fault> {
        self.append_first()?;
        if self.first.is_too_deep(&self.setup) {
            self.first.predict(&self.setup, &self.start, false);
            self.motions.set(&self.setup, &self.start, &self.first, self.state.step + 1);
            self.append_first()?;
        }
        Ok(())
    }

    fn solve(&mut self, tolerance: f64) -> Result<Outcome, Fault> {
        let Cpu { phases, solve, rows, domain, .. } = self;
        let outcome = timed(&mut phases.solve, || {
            if let Some(domain) = domain {
                rows.set_changed(|changed| domain.largest(f64::from(u8::from(changed))) > 0.0);
            }
            solve.solve(rows, tolerance)
        });
        if outcome.status == Status::TooLarge {
            return Err(Fault::TooLarge { step: self.step(), rows: self.constraints() });
        }
        Ok(outcome)
    }

    fn relax(&mut self, allowed: f64) -> Result<Option<Outcome>, Fault> {
        let Cpu { phases, solve, rows, .. } = self;
        Ok(timed(&mut phases.solve, || solve.relax(rows, allowed)))
    }

    fn trial(&mut self, violating: f64) -> Result<Overlap, Fault> {
        let begun = Instant::now();
        self.set_trial()?;
        let Cpu { setup, start, pairs, trial, candidates, domain, phases, .. } = self;
        phases.integrate += begun.elapsed();
        let begun = Instant::now();
        let boxes = boxes(&start.bodies.shape, |i| trial.poses[i], |_| 0.0);
        let candidates = together::candidates(domain, candidates, &boxes)?;
        phases.broad_phase += begun.elapsed();
        let begun = Instant::now();
        let placed = |a: usize, b: usize| trial.pair(start, a, b);
        let limit = |a: usize, b: usize| if start.is_held(a) && start.is_held(b) { f64::NEG_INFINITY } else { 0.0 };
        let mut overlapping = narrow_phase::within(candidates, pairs, Self::SEPARATE, placed, limit);
        pairs.renew(&overlapping);
        let bodies = start.bodies.len();
        let limit = |i: usize| if start.is_idle(i) { f64::NEG_INFINITY } else { 0.0 };
        near::join(&mut overlapping, walls::near(start.walls(setup), bodies, |i| trial.placed(start, i), limit));
        let mut overlap = trial.set_overlapping(setup, start, overlapping, violating);
        if let Some(domain) = domain {
            let worst = trial.worst().map(|near| (near.pair, near.found.separation));
            overlap = domain.all_overlaps(&overlap, worst, &setup.walls);
        }
        phases.narrow_phase += begun.elapsed();
        Ok(overlap)
    }

    fn effect(&mut self, gap: f64) -> Result<Effect, Fault> {
        let begun = Instant::now();
        let effect = self.find_effect(gap);
        let effect = self.domain.as_ref().map_or(effect, |domain| domain.all_effects(effect));
        self.phases.narrow_phase += begun.elapsed();
        Ok(effect)
    }

    fn two_sided(&mut self) -> Option<&mut dyn TwoSided> {
        if self.is_shared_out() { None } else { Some(self) }
    }

    fn throws(&mut self, gap: f64) -> Result<bool, Fault> {
        Ok(self.effect(gap)?.apart > 0)
    }

    fn append_violations(&mut self) -> Result<(), Fault> {
        self.answer_violations(false);
        Ok(())
    }

    fn tighten_violations(&mut self) -> Result<(), Fault> {
        self.answer_violations(true);
        Ok(())
    }

    fn passed(&mut self) -> Result<Option<Passed>, Fault> {
        let begun = Instant::now();
        let passed = self.find_passed();
        self.phases.narrow_phase += begun.elapsed();
        Ok(passed)
    }

    fn accept(&mut self) -> Result<Phases, Fault> {
        let begun = Instant::now();
        // What parts bodies in no time is no force, and no motion.
        let left = if self.start.parting { Vec::new() } else { self.left() };
        let Cpu { setup, state, start, motions, rows, trial, domain, phases, .. } = self;
        state.warm = match domain {
            Some(domain) => domain.by_number(left),
            None => left,
        };
        let arrived = trial.arrived(setup, start, motions);
        let end = together::arrive(domain, (setup, start), rows, trial, &arrived);
        start.bodies = std::mem::replace(&mut state.bodies, end);
        state.next_id = start.next_id;
        state.step += u64::from(start.piece.ends_step() && !start.parting);
        phases.integrate += begun.elapsed();
        Ok(std::mem::take(phases))
    }

    fn take_again(&mut self, take: &mut dyn FnMut(&mut dyn RetryBackend) -> Result<(), Fault>) -> Result<(), Fault> {
        // Pieces are taken by everyone alone.
        if let Some(domain) = &mut self.domain {
            domain.make_whole(&mut self.state);
            domain.resting = true;
        }
        let taken = take(self);
        if let Some(domain) = &mut self.domain {
            domain.resting = false;
        }
        taken
    }

    fn begins_anew(&self) -> bool {
        self.domain.as_ref().is_some_and(Domain::begins_anew)
    }

    fn is_shared_out(&self) -> bool {
        self.domain.as_ref().is_some_and(Domain::is_shared)
    }

    fn is_partial(&self) -> bool {
        self.domain.as_ref().is_some_and(Domain::is_partial)
    }

    fn placed(&self) -> Result<&Bodies, Fault> {
        let bodies = &self.state.bodies;
        Ok(self.domain.as_ref().map_or(bodies, |domain| domain.everywhere(bodies)))
    }

    fn here(&self) -> Result<&Bodies, Fault> {
        Ok(&self.state.bodies)
    }

    fn number(&self, i: usize) -> Option<usize> {
        self.domain.as_ref().map_or(Some(i), |domain| domain.own_number(i).map(|number| number as usize))
    }

    fn join(&self, own: Vec<[u64; JOINED]>) -> Vec<[u64; JOINED]> {
        match &self.domain {
            Some(domain) => domain.join(own),
            None => own,
        }
    }

    fn divided(&mut self, before: &[Lineage]) -> Result<Vec<Divided>, Fault> {
        let known = self.domain.as_mut().and_then(|domain| domain.divided());
        if let Some(known) = known {
            return Ok(known);
        }
        let lines = self.domain.as_mut().and_then(|domain| domain.lines_before());
        let (lineage, group) = self.identities()?;
        Ok(Divided::between(lines.as_deref().unwrap_or(before), lineage, group))
    }

    fn multipliers(&self) -> Result<Vec<f64>, Fault> {
        let mut start = self.rows.gamma.clone();
        start.resize(self.rows.problem.q.len(), 0.0);
        Ok(start)
    }

    fn stored_lcp(&self, start: Vec<f64>) -> Result<Stored, Fault> {
        Ok(Stored::new(&self.rows.problem, start, &self.rows.gamma))
    }

    fn constraints(&self) -> usize {
        if self.is_shared_out() { self.solve.all_rows() } else { self.rows.gamma.len() }
    }

    fn steps(&self) -> u64 {
        self.state.step
    }

    fn bodies(&self) -> usize {
        let here = self.state.bodies.len();
        self.domain.as_ref().map_or(here, |domain| domain.bodies(here))
    }

    fn state(&self) -> Result<&State, Fault> {
        Ok(self.domain.as_ref().map_or(&self.state, |domain| domain.gathered(&self.state)))
    }

    fn add_force(&mut self, force: Box<dyn ForceField>) {
        self.setup.forces.push(force);
        self.added_forces += 1;
    }

    fn take_forces(&mut self) -> Vec<Box<dyn ForceField>> {
        let added = std::mem::take(&mut self.added_forces);
        self.give_forces(added)
    }

    fn go_on_from(&mut self, state: State) -> Result<(), Fault> {
        self.restore(&state);
        Ok(())
    }

    fn remove(&mut self, keep: &[bool], removed: &[u64]) -> Result<(), Fault> {
        match &mut self.domain {
            Some(domain) => domain.remove(&mut self.state, keep, removed),
            None => self.state.remove(keep, removed),
        }
        Ok(())
    }
}
