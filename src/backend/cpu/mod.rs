//! The verbs of a timestep on the CPU, in f64, generic over the number of unknowns of a body.
//!
//! A step passes through stages, each in its own file: its `start`, the free `motions` of bodies, where `first` rows
//! are made and which pairs have one (`near`), the `row_set`, the `solve` and the `trial`. A stage writes what it owns
//! and reads those before it. `pairs` holds one record a pair for all of them.
//!
//! Parallel loops write to places of their own or collect in order, so the bits do not depend on the number of threads.
//! Steps are taken by a `team` of processes, of one as a rule; where there are several, each has a `domain` of the
//! bodies.

mod again;
mod bonds;
#[cfg(feature = "mpi")]
pub(crate) mod domain;
pub(super) mod first;
mod friction;
#[cfg(feature = "gpu")]
pub(crate) mod hosted;
mod keeper;
mod loaded;
mod motions;
mod narrow_phase;
mod near;
mod pairs;
mod restitution;
mod row_set;
mod setup;
mod solve;
mod start;
mod team;
mod trial;
mod trouble;
pub(super) mod two_sided;
mod verbs;
mod walls;

use crate::broad_phase::{Aabb, Candidates};
use crate::constraint::{RowSource, RowSourceError};
use crate::dynamics::{Pose, Waiting};
use crate::freedom::PLANAR;
use crate::lcp::{Alone, Problem};
use crate::separation::{Placed, planar_separation, separation};
use crate::shape::Shape;
use crate::step::{Fault, Model, Passed, Phases, Piece, State, Surplus, passed};
use crate::walls::surface_of;
use crate::warm::Warm;
use first::First;
use friction::{Making, Stick};
use glam::DVec3;
use motions::Motions;
use narrow_phase::{Near, Separate};
use near::Stages;
use pairs::{Pairs, Recalled};
use rayon::prelude::*;
use row_set::{Contact, RowSet};
use setup::Setup;
use solve::Solve;
use start::Start;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};
use team::{LocalProblem, Team};
use trial::Trial;
use trouble::Trouble;

/// A loop over fewer bodies than this runs on one thread: below it, handing out the work costs more than it saves
/// (a body's share of any of these loops is 20 to 100 ns, waking a thread some 5 us).
const LEAST_BODIES_A_TASK: usize = 512;

/// The same for rows, which take some 200 ns to make.
const LEAST_ROWS_A_TASK: usize = 256;

/// First rows that are made together before they are appended: few enough to stay in the caches.
const ROWS_AT_A_TIME: usize = 4_096;

/// The CPU backend. `D` is [`crate::freedom::PLANAR`] or [`crate::freedom::SPATIAL`]; `T` are the processes that take
/// steps together.
pub struct Cpu<const D: usize, T: Team = Alone> {
    setup: Setup,
    /// The last accepted state.
    state: State,
    /// What of a step that is taken in pieces comes next, and the cells that wait in it.
    next: Option<(Piece, Waiting)>,
    start: Start,
    motions: Motions,
    first: First,
    pairs: Pairs,
    stick: Option<Stick>,
    rows: RowSet<D>,
    solve: Solve<D, T::Portion<D>>,
    trial: Trial<D>,
    candidates: Candidates,
    /// Rows that a step may go back to.
    kept: Option<RowSet<D>>,
    /// The bodies whose rows were rebuilt in this attempt, at another configuration than a trial.
    rebuilt: BTreeSet<u32>,
    team: T,
    phases: Phases,
    /// How many bonds broke when the last trial was accepted.
    broken: u32,
}

impl<const D: usize> Cpu<D> {
    /// A backend for `model` in `state`.
    pub fn new(model: &Model, state: State) -> Result<Self, RowSourceError> {
        Cpu::of_team(model, state, Alone)
    }
}

impl<const D: usize, T: Team> Cpu<D, T> {
    const SEPARATE: Separate = if D == PLANAR { planar_separation } else { separation };

    /// A backend of a process of a team.
    fn of_team(model: &Model, mut state: State, team: T) -> Result<Self, RowSourceError> {
        let setup = Setup::new(model, &state.bodies);
        setup.source.proxies(&state.bodies.shape)?;
        if let Some(cells) = &model.cells {
            cells.settle(&mut state.bodies);
        }
        let now = |strain: crate::dynamics::Strain| strain.periods(model.time.after(state.step));
        state.bodies.periods = model.strain.map_or(model.periods, now);
        state.bodies.planar = model.planar;
        state.unrounded = None;
        if state.bodies.walls.len() != setup.walls.loaded().len() {
            state.bodies.walls = setup.walls.first_states();
        }
        // What is remembered of another scene's walls is of no use.
        state.warm.retain(|w| surface_of(w.pair[1]).is_none_or(|surface| surface < setup.walls.len()));
        Ok(Cpu {
            next: None,
            start: Start::new(model.time.dt, state.next_id),
            motions: Motions::default(),
            first: First::default(),
            pairs: Pairs::default(),
            stick: None,
            rows: RowSet::new(),
            solve: Solve::new(model),
            trial: Trial::default(),
            candidates: Candidates::in_space(model.periods),
            kept: None,
            rebuilt: BTreeSet::new(),
            team,
            phases: Phases::default(),
            broken: 0,
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

    /// The warm start of the next step: for each pair with rows, their multipliers and the last normal.
    fn warm_start(&self) -> Vec<Warm> {
        let mut warm = self.rows.warm_start(&self.pairs, &self.trial.scaled);
        let Cpu { setup, start, trial, .. } = self;
        let at_wall = |w: &mut Warm| {
            if let Some(surface) = surface_of(w.pair[1]) {
                let placed = trial.placed(start, w.pair[0] as usize);
                w.normal = walls::normal_at(start.walls(setup), &placed, surface, w.feature);
            }
        };
        if start.proxies.is_empty() && !setup.walls.is_empty() {
            warm.par_iter_mut().with_min_len(LEAST_ROWS_A_TASK).for_each(at_wall);
        }
        warm
    }

    /// Begins a piece of a step with this process's bodies. `leads`: whether it may use the last velocities.
    fn begin_with(&mut self, taken: (Piece, Waiting), leads: bool) -> Result<(), Fault> {
        let Cpu { setup, state, start, pairs, stick, solve, team, .. } = self;
        team.begin(setup, start, state, taken);
        start.grow(setup);
        let LocalProblem { places, portion, warm } = team.distribute(setup, start, state);
        start.settle(setup)?;
        start.hold(setup, leads);
        pairs.remember(&warm);
        *stick = Stick::of(setup, start, &warm);
        solve.begin(places, portion);
        Ok(())
    }

    /// Computes the trial of the present multipliers.
    ///
    /// # Errors
    /// [`Fault::NotFinite`] names the first body whose velocity or pose is not finite.
    fn set_trial(&mut self) -> Result<(), Fault> {
        let Cpu { start, motions, rows, trial, team, .. } = self;
        trial.set_scaled(rows);
        rows.velocity_of_bonds(&mut trial.bonded);
        team.exchange(&mut trial.scaled);
        let own = trial.set(motions, start);
        start.press(&trial.scaled);
        match self.team.first_trouble(own) {
            Some(Trouble { kind, body, .. }) => {
                let what = if kind == 0 { "velocity" } else { "pose" };
                Err(Fault::NotFinite { step: self.step(), what, body })
            }
            None => Ok(()),
        }
    }

    /// Refuses bodies that are too long, too fast or too far off for the periods.
    fn check_periods(&self) -> Result<(), Fault> {
        let (step, period) = (self.step(), self.start.periods.shortest());
        let Some(period) = period else { return Ok(()) };
        match self.team.first_trouble(self.motions.beyond_periods(&self.setup, &self.start)) {
            Some(Trouble { kind: 0, body, number }) => Err(Fault::PeriodTooShort { step, body, span: number, period }),
            Some(Trouble { body, .. }) => Err(Fault::TooFar { step, body }),
            None => Ok(()),
        }
    }

    /// The pairs that pass each other on their way to the trial.
    fn find_passed(&self) -> Option<Passed> {
        let Cpu { setup, start, trial, team, .. } = self;
        let interval_and_shear = (start.interval, setup.strain.and_then(|strain| strain.shear()));
        let (bodies, twists) = team.moving_bodies(&start.bodies, &trial.twist, interval_and_shear)?;
        let separate = |a: &Placed, b: &Placed| Self::SEPARATE(a, b, None);
        passed(&bodies, &twists, interval_and_shear, start.without_contact(), separate)
    }

    /// Makes first rows where [`First::predict`] or [`First::set_middle`] chose.
    fn append_first(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        self.check_periods()?;
        let bonds = self.first_bonds();
        let Cpu { setup, start, motions, first, pairs, stick, rows, candidates, team, phases, .. } = self;
        rows.clear(start.bodies.len(), setup.walls.len(), stick.is_some());
        rows.replace_bonds(bonds);
        let margin = |i: usize| 0.5 * setup.cutoff + motions.reach[i].either;
        let boxes = boxes(&start.bodies_at_loads().shape, |i| first.pose(i), margin);
        let candidates = team.candidates(candidates, &boxes)?;
        phases.broad_phase += begun.elapsed();
        let begun = Instant::now();
        pairs.recall();
        let stages = Stages { setup, start, motions };
        let (near, recalled) = match setup.source {
            RowSource::Surfaces => stages.of_surfaces((candidates, Self::SEPARATE, D == PLANAR), first, pairs),
            RowSource::SubSpheres { .. } => stages.of_sub_spheres(candidates, first, pairs),
        };
        first.overlap = team.max(first.overlap);
        if !start.held_bonds.is_empty() {
            first.overlap = first.overlap.max(setup.bonds.rigid_stretch(&start.bodies));
        }
        let making = Making { setup, start, motions, stick: *stick };
        let make = |(near, recalled): (&Near, &Recalled)| {
            let near = stages.at_end_lengths(*near);
            let mut contact = making.contact(&near, &first.reached, recalled.tangent);
            let bounce = start.bounce(setup, motions, &near);
            contact.normal.1 -= bounce.map_or(0.0, |bounce| bounce.apart);
            (contact, bounce)
        };
        let mut made = Vec::new();
        for (near, recalled) in near.chunks(ROWS_AT_A_TIME).zip(recalled.chunks(ROWS_AT_A_TIME)) {
            let both = near.par_iter().zip(recalled).with_min_len(LEAST_ROWS_A_TASK);
            both.map(make).collect_into_vec(&mut made);
            for ((near, recalled), (contact, bounce)) in near.iter().zip(recalled).zip(&made) {
                bounce.iter().for_each(|bounce| rows.bounces(*bounce));
                rows.append_first(near, contact, recalled.gamma);
            }
        }
        if start.middle.is_some() {
            start.make_proxies(setup)?;
        }
        phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    /// Answers all violations: the first row of a contact is tightened where it can be, others are appended, with a
    /// surplus.
    fn answer_violations(&mut self, tightens: bool, surplus: Surplus) {
        let Cpu { setup, start, motions, pairs, stick, rows, trial, phases, .. } = self;
        let making = Making { setup, start, motions, stick: *stick };
        timed(&mut phases.narrow_phase, || {
            let violations = trial.violations(setup, start);
            let make = |near: &Near| making.contact(near, &trial.twist, DVec3::ZERO);
            let contacts: Vec<Contact<D>> = violations.par_iter().with_min_len(LEAST_ROWS_A_TASK).map(make).collect();
            for (near, mut contact) in violations.into_iter().zip(contacts) {
                if !(tightens && rows.tighten(&near, pairs, &contact.normal.0, &trial.scaled)) {
                    contact.normal.1 -= surplus.asked(-near.found.separation);
                    rows.append(&near, &contact, 0.0);
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
