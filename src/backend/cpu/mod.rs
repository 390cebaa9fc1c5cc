//! The verbs of a timestep on the CPU, in f64, generic over the number of unknowns of a body.
//!
//! A step passes through stages, each in a file of its own: its `start`, how bodies move on their own (`motions`),
//! where `first` rows are made and which pairs have one (`near`), the `row_set`, the `solve` and the `trial`. A stage
//! writes what it owns and reads those before it. `pairs` holds one record a pair for all of them.
//!
//! Parallel loops write to places of their own or collect in order, so the bits do not depend on the number of threads.

mod again;
pub(super) mod first;
mod motions;
mod narrow_phase;
mod near;
mod pairs;
mod row_set;
mod setup;
mod sharing;
mod solve;
mod start;
mod trial;
mod walls;

use crate::broad_phase::{Aabb, Candidates};
use crate::constraint::{RowSource, RowSourceError};
use crate::dynamics::{ForceField, Pose, Waiting};
use crate::freedom::PLANAR;
use crate::lcp::{Outcome, Problem, Status, Stored};
use crate::processes::Processes;
use crate::separation::{planar_separation, separation};
use crate::shape::Shape;
use crate::step::{Backend, Fault, Model, Overlap, Passed, Phases, Piece, RetryBackend, State, passed};
use crate::walls::surface_of;
use crate::warm::Warm;
use first::First;
use glam::DVec3;
use motions::Motions;
use narrow_phase::Separate;
use near::Stages;
use pairs::Pairs;
use rayon::prelude::*;
use row_set::RowSet;
use setup::Setup;
use sharing::shared;
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
    /// Forces beside the scene's own.
    added_forces: usize,
    /// Those that share its work.
    processes: Option<Processes>,
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
            added_forces: 0,
            processes: None,
            phases: Phases::default(),
            setup,
            state,
        })
    }

    /// Shares the work on pairs and rows with other processes, which must take the same steps from the same state.
    #[cfg(feature = "mpi")]
    pub fn share(mut self, processes: Processes) -> Self {
        if processes.size() > 1 {
            self.processes = Some(processes);
            self.solve.share(processes);
        }
        self
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
        let step = self.step();
        let Cpu { setup, start, motions, first, pairs, rows, candidates, processes, phases, .. } = self;
        motions.check_periods(setup, start, step)?;
        rows.clear(start.bodies.len(), setup.walls.len());
        let margin = |i: usize| 0.5 * setup.cutoff + motions.reach[i].either;
        let candidates = candidates.ensure(&boxes(&start.here().shape, |i| first.pose(i), margin));
        phases.broad_phase += begun.elapsed();
        let begun = Instant::now();
        pairs.recall();
        let stages = Stages { setup, start, motions, processes: *processes };
        let (near, gamma) = match setup.source {
            RowSource::Surfaces => stages.of_surfaces((candidates, Self::SEPARATE, D == PLANAR), first, pairs),
            RowSource::SubSpheres { .. } => stages.of_sub_spheres(candidates, first, pairs),
        };
        for (near, gamma) in near.iter().zip(gamma) {
            let near = stages.at_end_lengths(*near);
            rows.append(&near, motions.row(&near, &first.reached, start.interval), gamma);
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
                let row: ([[f64; D]; 2], f64) = motions.row(&near, &trial.twist, start.interval);
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
        let Cpu { setup, state, next, start, motions, first, pairs, solve, candidates, phases, .. } = self;
        // A step that is taken again was led astray once: its pieces are linearised at their starts.
        let whole = next.is_none() && !start.parting;
        start.begin(setup, state, next.take().unwrap_or((Piece::WHOLE, Waiting::None)))?;
        candidates.set_periods(start.periods);
        solve.begin();
        pairs.remember(&state.warm);
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
        self.trial.set(&self.rows, &self.motions, &self.start, step)?;
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
        let Cpu { phases, solve, rows, .. } = self;
        let outcome = timed(&mut phases.solve, || solve.solve(rows, tolerance));
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
        let step = self.step();
        let Cpu { setup, start, motions, pairs, rows, trial, candidates, processes, phases, .. } = self;
        trial.set(rows, motions, start, step)?;
        phases.integrate += begun.elapsed();
        let begun = Instant::now();
        let candidates = candidates.ensure(&boxes(&start.bodies.shape, |i| trial.poses[i], |_| 0.0));
        phases.broad_phase += begun.elapsed();
        let begun = Instant::now();
        let placed = |a: usize, b: usize| trial.pair(start, a, b);
        let limit = |a: usize, b: usize| if start.is_held(a) && start.is_held(b) { f64::NEG_INFINITY } else { 0.0 };
        let mut overlapping = shared(*processes, candidates.len(), |part| {
            narrow_phase::within(&candidates[part], pairs, Self::SEPARATE, placed, limit)
        });
        pairs.renew(&overlapping);
        let bodies = start.bodies.len();
        let limit = |i: usize| if start.is_held(i) { f64::NEG_INFINITY } else { 0.0 };
        near::join(&mut overlapping, walls::near(start.walls(setup), bodies, |i| trial.placed(start, i), limit));
        let overlap = trial.set_overlapping(setup, start, overlapping, violating);
        phases.narrow_phase += begun.elapsed();
        Ok(overlap)
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
        let Cpu { setup, phases, start, trial, .. } = self;
        Ok(timed(&mut phases.narrow_phase, || {
            let shear = setup.strain.and_then(|strain| strain.shear());
            passed(&start.bodies, &trial.twist, (start.interval, shear), |a, b| Self::SEPARATE(a, b, None))
        }))
    }

    fn accept(&mut self) -> Result<Phases, Fault> {
        let begun = Instant::now();
        // What parts bodies in no time is no force, and no motion.
        self.state.warm = if self.start.parting { Vec::new() } else { self.left() };
        let Cpu { setup, state, start, motions, trial, phases, .. } = self;
        let arrived = trial.arrived(setup, start, motions);
        let mut end = std::mem::take(&mut start.bodies);
        end.periods = start.periods;
        trial.arrive(&mut end, &arrived);
        if let Some(incidence) = &start.bonds {
            setup.bonds.find_broken(incidence, &mut end);
        }
        start.bodies = std::mem::replace(&mut state.bodies, end);
        state.next_id = start.next_id;
        state.step += u64::from(start.piece.ends_step() && !start.parting);
        phases.integrate += begun.elapsed();
        Ok(std::mem::take(phases))
    }

    fn take_again(&mut self, take: &mut dyn FnMut(&mut dyn RetryBackend) -> Result<(), Fault>) -> Result<(), Fault> {
        take(self)
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
        self.rows.gamma.len()
    }

    fn steps(&self) -> u64 {
        self.state.step
    }

    fn bodies(&self) -> usize {
        self.state.bodies.len()
    }

    fn state(&self) -> Result<&State, Fault> {
        Ok(&self.state)
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
        self.state.remove(keep, removed);
        Ok(())
    }
}
