//! The verbs of a timestep on the CPU, in f64, generic over the number of unknowns of a body.
//!
//! Parallel loops write to places of their own or collect in order, so the bits do not depend on the number of threads.

mod again;
pub(super) mod first;
mod narrow_phase;
mod periodic;
mod rows;
mod walls;

use crate::bodies::Bodies;
use crate::broad_phase::{Aabb, Candidates};
use crate::constraint::{self, RowSource, RowSourceError, sub_sphere_separations};
use crate::dynamics::{self, Cells, ForceField, Law, Load, Motion, Overdamped, Pose, Twist, Waiting};
use crate::freedom::{PLANAR, pack, unpack};
use crate::lcp::{self, Outcome, Problem, Settings, Status, Stored};
use crate::separation::{Placed, planar_separation, separation};
use crate::shape::{ProxySphere, Shape};
use crate::step::{
    Backend, Fault, Model, Overlap, Passed, Phases, Piece, RetryBackend, Rows, State, Stepping, Time, passed,
};
use crate::walls::{Walls, surface_of};
use crate::warm::Warm;
use glam::DVec3;
use narrow_phase::{Known, Near};
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// A loop over fewer bodies than this runs on one thread: below it, handing out the work costs more than it saves
/// (a body's share of any of these loops is 20 to 100 ns, waking a thread some 5 us).
const LEAST_BODIES_A_TASK: usize = 512;

/// How bodies move that are parted: the long ones turn and move less easily. The drag cancels out.
const PARTING: Overdamped = Overdamped { drag: 1.0 };

/// Where a row is made.
#[derive(Clone, Copy)]
enum At {
    /// At the step's start, or in its middle.
    FirstRows,
    Trial,
}

/// How far a body may still move on its own from where first rows are made, lengths: its centre, its surface as it
/// turns, and both.
#[derive(Clone, Copy, Default)]
struct Reach {
    linear: DVec3,
    angular: f64,
    either: f64,
}

/// The CPU backend. `D` is [`crate::freedom::PLANAR`] or [`crate::freedom::SPATIAL`].
pub struct Cpu<const D: usize> {
    time: Time,
    growth: Option<Cells>,
    /// What slows the growth of this step's bodies, where something does.
    pressures: Vec<f64>,
    overlap_tolerance: f64,
    /// The overlap from which on a pair of the last trial is a violation.
    violating: f64,
    cutoff: f64,
    thinnest: f64,
    law: Box<dyn Law>,
    forces: Vec<Box<dyn ForceField>>,
    walls: Walls,
    source: RowSource,
    rows: Rows,
    solver: lcp::Solver<D>,
    /// Whether there was a solve in this step, and the residual that the last one left.
    solved: bool,
    /// Whether rows were made or moved since.
    changed: bool,
    residual: f64,
    /// What of the step is being taken, and the cells that wait in it; and what comes next.
    piece: Piece,
    waiting: Waiting,
    next: Option<(Piece, Waiting)>,
    /// Whether bodies are parted in no time.
    parting: bool,
    /// The deepest overlap where first rows were made.
    start_overlap: f64,
    candidates: Candidates,
    /// The last accepted state.
    state: State,
    midpoint: bool,
    /// The length of the part of the step that is being computed.
    interval: f64,
    /// `C^k` with the bodies of this step and the lengths at the end of the part, and the next free id.
    start: Bodies,
    next_id: u64,
    /// `C_h` with the lengths there, once it is made.
    middle: Option<Bodies>,
    /// Whether first rows may be made where the last velocities lead, and whether they are.
    leads_ahead: bool,
    ahead: bool,
    /// What of `dt U` leads to where first rows are made, and the poses there.
    reached: Vec<Twist>,
    first: Vec<Pose>,
    /// What the next first rows start from.
    recalled: Vec<Warm>,
    /// How many rows `append_near` made.
    first_rows: usize,
    motion: Vec<Motion>,
    reach: Vec<Reach>,
    proxies: Vec<Vec<ProxySphere>>,
    /// The trial: `U`, `C(U)`, and what overlaps there.
    twist: Vec<Twist>,
    trial: Vec<Pose>,
    overlapping: Vec<Near>,
    /// Normals found so far in this step, by pair.
    known: Vec<Known>,
    problem: Problem<D>,
    feature: Vec<u32>,
    gamma: Vec<f64>,
    /// `J^T gamma`.
    scaled: Vec<[f64; D]>,
    phases: Phases,
}

impl<const D: usize> Cpu<D> {
    const SEPARATE: narrow_phase::Separate = if D == PLANAR { planar_separation } else { separation };

    /// A backend for `model` in `state`.
    pub fn new(model: &Model, mut state: State) -> Result<Self, RowSourceError> {
        let source = model.contact.method.row_source();
        source.proxies(&state.bodies.shape)?;
        let walls = model.walls.clone();
        let periods = model.periods;
        state.bodies.periods = periods;
        // What is remembered of another scene's walls is of no use.
        state.warm.retain(|w| surface_of(w.pair[1]).is_none_or(|surface| surface < walls.len()));
        Ok(Cpu {
            walls,
            time: model.time,
            growth: model.cells,
            pressures: Vec::new(),
            overlap_tolerance: model.contact.overlap_tolerance,
            violating: model.contact.overlap_tolerance,
            cutoff: model.contact.cutoff_of(state.bodies.shape.iter().copied()),
            thinnest: state.bodies.shape.iter().map(Shape::thickness).fold(f64::INFINITY, f64::min),
            law: dynamics::law(&model.dynamics),
            forces: dynamics::force_fields(&model.forces, &model.groups, &model.dynamics),
            source,
            rows: model.contact.rows_of_method(),
            solver: match model.contact.rows_of_method() {
                Rows::Auto => lcp::Solver::new(model.solver, model.lcp),
                Rows::Paper => lcp::Solver::new(model.solver, model.lcp).for_parallel_rows(),
            },
            solved: false,
            changed: true,
            residual: 0.0,
            piece: Piece::WHOLE,
            waiting: Waiting::None,
            next: None,
            parting: false,
            start_overlap: 0.0,
            candidates: Candidates::in_space(periods),
            midpoint: model.time.stepping == Stepping::Midpoint,
            interval: model.time.dt,
            start: Bodies::default(),
            next_id: state.next_id,
            state,
            middle: None,
            leads_ahead: first::leads_ahead(model),
            ahead: false,
            reached: Vec::new(),
            first: Vec::new(),
            recalled: Vec::new(),
            first_rows: 0,
            motion: Vec::new(),
            reach: Vec::new(),
            proxies: Vec::new(),
            twist: Vec::new(),
            trial: Vec::new(),
            overlapping: Vec::new(),
            known: Vec::new(),
            problem: Problem::default(),
            feature: Vec::new(),
            gamma: Vec::new(),
            scaled: Vec::new(),
            phases: Phases::default(),
        })
    }

    /// The present LCP and its multipliers, for diagnosis and tests.
    pub fn lcp(&self) -> (&Problem<D>, &[f64]) {
        (&self.problem, &self.gamma)
    }

    /// Which of its pair's contacts each row is of.
    pub fn features(&self) -> &[u32] {
        &self.feature
    }

    /// When the present piece of the step begins.
    fn piece_start(&self) -> f64 {
        self.time.after(self.state.step) + self.piece.start * self.piece.span * self.time.dt
    }

    /// How long it is.
    fn piece_length(&self) -> f64 {
        self.piece.length * self.piece.span * self.time.dt
    }

    /// Where forces, mobilities and first rows are taken: the middle where it is made, else the start.
    fn here(&self) -> &Bodies {
        self.middle.as_ref().unwrap_or(&self.start)
    }

    /// Loads, effective mobilities, free velocities, and how far each body's surface may still move on its own.
    fn set_motion(&mut self) {
        let dt = self.interval;
        let time = self.piece_start() + if self.middle.is_some() { 0.5 * dt } else { 0.0 };
        let (mut motion, mut reach) = (std::mem::take(&mut self.motion), std::mem::take(&mut self.reach));
        let here = self.here();
        let (law, forces): (&dyn Law, &[Box<dyn ForceField>]) =
            if self.parting { (&PARTING, &[]) } else { (self.law.as_ref(), &self.forces) };
        let of_body = |i: usize| {
            let mut load = Load::default();
            for force in forces {
                load += force.load(here, i, time);
            }
            let motion = match &self.middle {
                Some(middle) => law.motion_by_middle(&self.start, middle, i, load, dt),
                None => law.motion(here, i, load, dt),
            };
            let reached = self.reached_at(i, At::FirstRows);
            let linear = motion.free.linear - reached.linear;
            let angular = (motion.free.angular - reached.angular).length() * here.shape[i].bounding_radius();
            (motion, Reach { linear: dt * linear, angular: dt * angular, either: dt * (linear.length() + angular) })
        };
        (0..here.len())
            .into_par_iter()
            .with_min_len(LEAST_BODIES_A_TASK)
            .map(of_body)
            .unzip_into_vecs(&mut motion, &mut reach);
        (self.motion, self.reach) = (motion, reach);
    }

    /// The velocity that leads body `i` from the start to where a row is made, in the length of the present part.
    fn reached_at(&self, i: usize, at: At) -> Twist {
        match at {
            At::Trial => self.twist[i],
            At::FirstRows => self.reached[i],
        }
    }

    /// The boxes of all bodies in the poses `pose(i)`, each widened by `margin(i)`.
    fn boxes(
        &self,
        shapes: &[Shape],
        pose: impl Fn(usize) -> Pose + Sync,
        margin: impl Fn(usize) -> f64 + Sync,
    ) -> Vec<Aabb> {
        let of_body = |i: usize| {
            let pose = pose(i);
            let half = shapes[i].half_extents(pose.orientation) + DVec3::splat(margin(i));
            Aabb { min: pose.position - half, max: pose.position + half }
        };
        (0..shapes.len()).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).map(of_body).collect()
    }

    fn pose_in(bodies: &Bodies, i: usize) -> Pose {
        Pose { position: bodies.position[i], orientation: bodies.orientation[i] }
    }

    /// The trial's twists and poses, or the first body that has none.
    fn set_trial(&mut self) -> Result<(), Fault> {
        lcp::velocity_into(&self.problem, &self.gamma, &mut self.scaled);
        let (mut twist, mut trial) = (std::mem::take(&mut self.twist), std::mem::take(&mut self.trial));
        let (dt, scaled) = (self.interval, &self.scaled);
        let of_body = |i: usize| {
            let twist = constraint::velocity(&self.motion[i], &scaled[i], dt);
            (twist, dynamics::advance(Self::pose_in(&self.start, i), twist, dt))
        };
        (0..self.start.len())
            .into_par_iter()
            .with_min_len(LEAST_BODIES_A_TASK)
            .map(of_body)
            .unzip_into_vecs(&mut twist, &mut trial);
        (self.twist, self.trial) = (twist, trial);
        let finite = |t: &Twist| t.linear.is_finite() && t.angular.is_finite();
        let step = self.state.step + 1;
        if let Some(body) = self.twist.iter().position(|t| !finite(t)) {
            return Err(Fault::NotFinite { step, what: "velocity", body });
        }
        // A finite velocity can still be too large to arrive anywhere: the square of a quaternion's length overflows.
        match self.trial.iter().position(|p| !p.position.is_finite() || !p.orientation.is_normalized()) {
            Some(body) => Err(Fault::NotFinite { step, what: "pose", body }),
            None => Ok(()),
        }
    }

    /// The velocities that the present part ends with at the trial.
    fn arrived(&self) -> Vec<Twist> {
        let (here, law) = (self.here(), &self.law);
        let of_body = |i: usize| {
            if self.parting {
                return self.start.twist(i);
            }
            let twist = law.arrived(here, i, &self.motion[i], self.twist[i], self.trial[i].orientation);
            // What the scene does not carry is exactly zero.
            let (linear, angular) = unpack::<D>(&pack(twist.linear, twist.angular));
            Twist { linear, angular }
        };
        (0..self.start.len()).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).map(of_body).collect()
    }

    /// Takes bodies to the trial.
    fn arrive(&self, bodies: &mut Bodies, arrived: &[Twist]) {
        for (i, (pose, twist)) in self.trial.iter().zip(arrived).enumerate() {
            bodies.position[i] = pose.position;
            bodies.orientation[i] = pose.orientation;
            bodies.velocity[i] = twist.linear;
            bodies.angular_velocity[i] = twist.angular;
        }
    }

    fn placed_at_trial(&self, i: usize) -> Placed {
        let Pose { position, orientation } = self.trial[i];
        Placed { shape: self.start.shape[i], position, orientation }
    }

    fn pair_at_trial(&self, a: usize, b: usize) -> [Placed; 2] {
        self.start.periods.pair(self.placed_at_trial(a), self.placed_at_trial(b))
    }

    fn worst_proxy_overlap(&self) -> Option<f64> {
        if self.proxies.is_empty() {
            return None;
        }
        // Sub-spheres lie inside their surfaces, so only pairs whose surfaces overlap can have sub-spheres that do.
        let mut worst = 0.0f64;
        for near in &self.overlapping {
            if surface_of(near.pair[1]).is_some() {
                worst = worst.max(self.proxy_past_wall(near));
                continue;
            }
            let [a, b] = near.pair.map(|i| i as usize);
            let [of_a, of_b] = self.pair_at_trial(a, b);
            let proxies = [self.proxies[a].as_slice(), self.proxies[b].as_slice()];
            sub_sphere_separations([&of_a, &of_b], proxies, 0.0, |_, found| worst = worst.max(-found.separation));
        }
        Some(worst)
    }
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
        // A step that is taken again was led astray once: its pieces are linearised at their starts.
        let whole = self.next.is_none() && !self.parting;
        let ahead = D == PLANAR && self.leads_ahead && whole;
        (self.piece, self.waiting) = self.next.take().unwrap_or((Piece::WHOLE, Waiting::None));
        self.start.clone_from(&self.state.bodies);
        self.next_id = self.state.next_id;
        self.solved = false;
        self.middle = None;
        self.interval = if self.midpoint { 0.5 * self.piece_length() } else { self.piece_length() };
        self.recalled.clone_from(&self.state.warm);
        if let Some(growth) = self.growth.filter(|_| !self.parting) {
            let span = (self.piece_start(), self.interval);
            self.pressures = growth.pressures(&self.state.bodies, &self.state.warm);
            growth.grow(&mut self.start, span, &mut self.next_id, &mut self.pressures, &self.waiting);
        }
        self.proxies = self.source.proxies(&self.start.shape).map_err(Fault::NoProxy)?;
        self.phases.growth += begun.elapsed();
        let begun = Instant::now();
        self.predict(ahead);
        self.set_motion();
        self.phases.integrate += begun.elapsed();
        Ok(())
    }

    fn middle(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        self.set_trial()?;
        self.recalled = self.remember();
        let arrived = self.arrived();
        let mut middle = self.start.clone();
        self.arrive(&mut middle, &arrived);
        self.middle = Some(middle);
        self.interval = self.piece_length();
        // `dt/2 U_h` is `dt` times half of it.
        let half = |t: &Twist| Twist { linear: 0.5 * t.linear, angular: 0.5 * t.angular };
        self.reached.clear();
        self.reached.extend(self.twist.iter().map(half));
        self.first.clone_from(&self.trial);
        if let Some(growth) = self.growth {
            growth.lengthen(&mut self.start, 0.5 * self.interval, &self.pressures, &self.waiting);
        }
        self.set_motion();
        self.phases.integrate += begun.elapsed();
        Ok(())
    }

    fn append_near(&mut self) -> Result<(), Fault> {
        self.append_near_where_chosen()?;
        if self.ahead && self.start_overlap > first::DEEPEST_AHEAD * self.thinnest {
            self.predict(false);
            self.set_motion();
            self.append_near_where_chosen()?;
        }
        Ok(())
    }

    fn solve(&mut self, tolerance: f64) -> Result<Outcome, Fault> {
        self.solver.set_settings(Settings { tolerance, ..self.solver.settings() });
        let Cpu { phases, solver, problem, gamma, solved, changed, rows, .. } = self;
        let first = !std::mem::replace(solved, true);
        let same = !std::mem::replace(changed, false) && *rows == Rows::Auto;
        let outcome = timed(&mut phases.solve, || match (first, same) {
            (true, _) => solver.solve(problem, gamma),
            (false, true) => solver.go_on(gamma),
            (false, false) => solver.solve_next(problem, gamma),
        });
        self.residual = outcome.residual;
        if outcome.status == Status::TooLarge {
            return Err(Fault::TooLarge { step: self.steps() + 1, rows: self.constraints() });
        }
        Ok(outcome)
    }

    fn relax(&mut self, allowed: f64) -> Result<Option<Outcome>, Fault> {
        let Cpu { phases, solver, problem, gamma, residual, changed, .. } = self;
        *changed = true;
        let mut relaxed = gamma.clone();
        let outcome = timed(&mut phases.solve, || solver.relax(problem, &mut relaxed, allowed));
        // What no method improved on stays.
        if residual.is_finite() && outcome.residual >= *residual {
            return Ok(None);
        }
        *gamma = relaxed;
        Ok(Some(outcome))
    }

    fn trial(&mut self, violating: f64) -> Result<Overlap, Fault> {
        self.violating = violating;
        let begun = Instant::now();
        self.set_trial()?;
        self.phases.integrate += begun.elapsed();
        let begun = Instant::now();
        let boxes = self.boxes(&self.start.shape, |i| self.trial[i], |_| 0.0);
        let mut candidates = std::mem::take(&mut self.candidates);
        let pairs = candidates.ensure(&boxes);
        self.phases.broad_phase += begun.elapsed();
        let begun = Instant::now();
        let mut overlapping =
            narrow_phase::within(pairs, &self.known, Self::SEPARATE, |a, b| self.pair_at_trial(a, b), |_, _| 0.0);
        self.candidates = candidates;
        narrow_phase::renew(&mut self.known, &overlapping);
        rows::join(&mut overlapping, self.near_walls(|i| self.placed_at_trial(i), |_| 0.0));
        self.overlapping = overlapping;
        let worst = self.overlapping.iter().min_by(|p, q| p.found.separation.total_cmp(&q.found.separation));
        let overlap = Overlap {
            worst: worst.map_or(0.0, |near| (-near.found.separation).max(0.0)),
            pair: worst.filter(|near| surface_of(near.pair[1]).is_none()).map(|near| near.pair.map(|i| i as usize)),
            wall: worst.and_then(|near| Some([near.pair[0] as usize, self.walls.wall_of(surface_of(near.pair[1])?)])),
            violations: self.overlapping.iter().filter(|near| near.found.separation < -violating).count(),
            proxy: self.worst_proxy_overlap(),
        };
        self.phases.narrow_phase += begun.elapsed();
        Ok(overlap)
    }

    fn append_violations(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let overlapping = std::mem::take(&mut self.overlapping);
        for near in self.violated(&overlapping) {
            self.append(&near, 0.0, At::Trial);
        }
        self.overlapping = overlapping;
        self.phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    fn tighten_violations(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let overlapping = std::mem::take(&mut self.overlapping);
        for near in self.violated(&overlapping) {
            if !self.tighten(&near) {
                self.append(&near, 0.0, At::Trial);
            }
        }
        self.overlapping = overlapping;
        self.phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    fn passed(&mut self) -> Result<Option<Passed>, Fault> {
        let Cpu { phases, start, twist, interval, .. } = self;
        Ok(timed(&mut phases.narrow_phase, || passed(start, twist, *interval, |a, b| Self::SEPARATE(a, b, None))))
    }

    fn accept(&mut self) -> Result<Phases, Fault> {
        let begun = Instant::now();
        // What parts bodies in no time is no force, and no motion.
        self.state.warm = if self.parting { Vec::new() } else { self.remember() };
        let arrived = self.arrived();
        let mut end = std::mem::take(&mut self.start);
        self.arrive(&mut end, &arrived);
        self.start = std::mem::replace(&mut self.state.bodies, end);
        self.state.next_id = self.next_id;
        self.state.step += u64::from(self.piece.ends_step() && !self.parting);
        self.phases.integrate += begun.elapsed();
        Ok(std::mem::take(&mut self.phases))
    }

    fn take_again(&mut self, take: &mut dyn FnMut(&mut dyn RetryBackend) -> Result<(), Fault>) -> Result<(), Fault> {
        take(self)
    }

    fn multipliers(&self) -> Result<Vec<f64>, Fault> {
        let mut start = self.gamma.clone();
        start.resize(self.problem.q.len(), 0.0);
        Ok(start)
    }

    fn stored_lcp(&self, start: Vec<f64>) -> Result<Stored, Fault> {
        Ok(Stored::new(&self.problem, start, &self.gamma))
    }

    fn constraints(&self) -> usize {
        self.gamma.len()
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
        self.forces.push(force);
    }
}
