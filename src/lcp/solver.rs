//! The interface to all solvers.

use super::cpu::Cpu;
use super::drive::{Drive, ResidualSample};
use super::engine::{Engine, Task};
use super::friction::Friction;
use super::islands::{Given, Islands};
use super::portion::{Alone, Portion};
use super::{Outcome, Places, Problem, Settings, SolverKind};

/// A solver of LCPs on the CPU. It reuses its buffers for the next problem.
///
/// ```
/// use relcp::lcp::{Problem, Settings, Solver, SolverKind, Status, velocity};
///
/// // Two bodies with three unknowns each, 0.1 too near along x.
/// let problem = Problem::<3> {
///     bodies: 2,
///     pair: vec![[0, 1]],
///     jacobian: vec![[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]],
///     q: vec![-0.1],
///     ..Problem::default()
/// };
/// let settings = Settings { tolerance: 1e-12, max_iterations: 1_000 };
/// let mut gamma = Vec::new();
/// let outcome = Solver::new(SolverKind::Auto, settings).solve(&problem, &mut gamma);
/// assert_eq!(outcome.status, Status::Solved);
/// assert!((gamma[0] - 0.05).abs() < 1e-12);
/// assert!((velocity(&problem, &gamma)[1][0] - 0.05).abs() < 1e-12);
/// ```
pub struct Solver<const D: usize, P: Portion<D> = Alone> {
    pub(super) task: Task<D, P>,
    pub(super) engine: Engine<D, P>,
    /// Solves problems with cones.
    friction: Friction<D>,
    /// Solves problems of several islands.
    pub(super) islands: Islands<D>,
    /// Whether the last problem had cones.
    with_cones: bool,
}

impl<const D: usize> Solver<D> {
    /// A solver of a kind. [`SolverKind::Auto`] is projected nonlinear conjugate gradients with the blocks of the
    /// pairs. It falls back to the interior-point method if these end with
    /// [`NoProgress`](super::Status::NoProgress) or [`MaxIterations`](super::Status::MaxIterations), or converge too
    /// slowly.
    pub fn new(kind: SolverKind, settings: Settings) -> Self {
        Solver::with_portions(kind, settings)
    }
}

impl<const D: usize, P: Portion<D>> Solver<D, P> {
    /// A solver of a kind, for problems that may be distributed over processes.
    pub(crate) fn with_portions(kind: SolverKind, settings: Settings) -> Self {
        let engine = Engine::new(kind, &settings);
        let task = Task { cpu: Cpu::default(), drive: Drive::default(), settings };
        Solver { task, engine, friction: Friction::new(kind), islands: Islands::default(), with_cones: false }
    }

    /// Tunes the solver for LCPs with many nearly parallel rows, such as a recursion appends. They slow conjugate
    /// gradients down; `auto` then switches to the interior-point method as soon as the residuals show it.
    pub fn for_parallel_rows(mut self) -> Self {
        self.engine.for_parallel_rows();
        self.task.cpu = Cpu::for_parallel_rows();
        self
    }

    /// Sets the body order and this process's portion for subsequent problems.
    pub(crate) fn place(&mut self, places: Places, portion: P) {
        self.task.cpu.place(places, portion);
    }

    /// The number of rows of the last problem, over all processes.
    pub(crate) fn all_rows(&self) -> usize {
        self.task.cpu.all_rows()
    }

    /// The stopping criteria.
    pub fn settings(&self) -> Settings {
        self.task.settings
    }

    /// Sets the stopping criteria for subsequent problems.
    pub fn set_settings(&mut self, settings: Settings) {
        self.task.settings = settings;
    }

    /// Solves subsequent problems with cones by the convex relaxation of the law, for comparison.
    #[cfg(test)]
    pub(super) fn relax_friction(&mut self) {
        self.friction.relax();
    }

    /// Records the residuals of subsequent solves.
    pub fn keep_history(&mut self) {
        self.task.drive.history = Some(Vec::new());
    }

    /// The recorded residuals of the last solve. The exact solver has none.
    pub fn history(&self) -> &[ResidualSample] {
        self.task.drive.history.as_deref().unwrap_or_default()
    }

    /// Solves a problem. `gamma` is the start: missing, negative and non-finite entries count as zero. It becomes the
    /// solution or the best iterate found, never worse than the start.
    ///
    /// The velocity `J^T gamma` of a solution is unique; `gamma` is not unique if rows are linearly dependent.
    ///
    /// A problem with [cones](Problem::cones) is solved for the exact law of friction, to a residual of that law. Its
    /// start is put into the cones. Neither its `gamma` nor its velocity need be unique.
    ///
    /// # Panics
    /// If the lengths in the problem differ, or a row refers to a body out of range. If the problem has cones: as
    /// [`Problem::check`], and if the solver does not [support friction](SolverKind::supports_friction).
    pub fn solve(&mut self, problem: &Problem<D>, gamma: &mut Vec<f64>) -> Outcome {
        self.engine.forget();
        self.islands.forget();
        self.solve_next(problem, gamma)
    }

    /// [`Solver::solve`] for a problem similar to the last one, such as the same with rows added. If the last one
    /// needed the interior-point method, `auto` begins with it.
    ///
    /// # Panics
    /// As [`Solver::solve`].
    pub fn solve_next(&mut self, problem: &Problem<D>, gamma: &mut Vec<f64>) -> Outcome {
        gamma.resize(problem.q.len(), 0.0);
        let Task { drive, settings, .. } = &mut self.task;
        drive.history.iter_mut().for_each(Vec::clear);
        self.with_cones = !problem.cones.is_empty();
        if self.with_cones {
            return self.friction.solve(problem, gamma, drive, settings);
        }
        if let Some(outcome) = self.solve_islands(problem, gamma) {
            return outcome;
        }
        self.task.cpu.rebuild(problem);
        if let Some(outcome) = P::solve_islands(self, gamma) {
            return outcome;
        }
        let Task { cpu, drive, .. } = &mut self.task;
        cpu.import(gamma, &mut drive.at.x);
        self.run(gamma, false)
    }

    /// Solves a problem with cones with corrections held: see `friction`.
    pub(super) fn solve_held(&mut self, problem: &Problem<D>, gamma: &mut [f64]) -> Outcome {
        let Task { drive, settings, .. } = &mut self.task;
        self.with_cones = true;
        self.friction.solve_held(problem, gamma, drive, settings)
    }

    /// Continues with the last problem from the last iterate.
    pub fn resume(&mut self, gamma: &mut [f64]) -> Outcome {
        let Task { cpu, drive, settings } = &mut self.task;
        drive.history.iter_mut().for_each(Vec::clear);
        if self.with_cones {
            return self.friction.resume(gamma, drive, settings);
        }
        if self.islands.are_used() {
            return P::resume_islands(self, gamma);
        }
        cpu.restart_count();
        self.run(gamma, true)
    }

    /// Solves a problem by its islands, in a step with `auto`, if it has several.
    fn solve_islands(&mut self, problem: &Problem<D>, gamma: &mut [f64]) -> Option<Outcome> {
        self.islands.leave();
        let (tightest, place) = (self.for_islands()?, self.task.cpu.positions(problem.bodies)?);
        let given = Given { place, tightest, settings: self.task.settings };
        self.islands.solve(problem, gamma, given, &self.task.cpu.portion)
    }

    /// The tolerance that `auto` was created with, if it may solve islands.
    pub(super) fn for_islands(&self) -> Option<f64> {
        match &self.engine {
            Engine::Auto(auto) if self.task.drive.history.is_none() => auto.for_islands(),
            _ => None,
        }
    }

    fn run(&mut self, gamma: &mut [f64], goes_on: bool) -> Outcome {
        let outcome = self.engine.solve(&mut self.task, goes_on);
        self.task.cpu.export(&self.task.drive.at.x, gamma);
        outcome
    }
}
