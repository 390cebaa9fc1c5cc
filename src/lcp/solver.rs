//! One door to all solvers.

use super::cpu::Cpu;
use super::drive::{Drive, ResidualSample};
use super::engine::{Engine, Task};
use super::portion::{Alone, Portion};
use super::{Outcome, Places, Problem, Settings, SolverKind};

/// A solver of LCPs on the CPU. It keeps its buffers from one problem to the next.
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
}

impl<const D: usize> Solver<D> {
    /// A solver of a kind. [`SolverKind::Auto`] is projected nonlinear conjugate gradients with the blocks of the
    /// pairs, and the interior-point method where those end with [`NoProgress`](super::Status::NoProgress) or
    /// [`MaxIterations`](super::Status::MaxIterations), or their end is not in sight.
    pub fn new(kind: SolverKind, settings: Settings) -> Self {
        Solver::with_portions(kind, settings)
    }
}

impl<const D: usize, P: Portion<D>> Solver<D, P> {
    /// A solver of a kind, of problems that processes may share.
    pub(crate) fn with_portions(kind: SolverKind, settings: Settings) -> Self {
        let engine = Engine::new(kind, &settings);
        Solver { task: Task { cpu: Cpu::default(), drive: Drive::default(), settings }, engine }
    }

    /// The same for LCPs with many nearly parallel rows, such as a recursion appends. These slow conjugate gradients
    /// down, so that `auto` goes over to the interior-point method as soon as the residuals show it.
    pub fn for_parallel_rows(mut self) -> Self {
        self.engine.for_parallel_rows();
        self.task.cpu = Cpu::for_parallel_rows();
        self
    }

    /// Sets the order of the bodies of the next problems, and what of these is here.
    pub(crate) fn place(&mut self, places: Places, portion: P) {
        self.task.cpu.place(places, portion);
    }

    /// How many rows the last problem had, with those of other processes.
    pub(crate) fn all_rows(&self) -> usize {
        self.task.cpu.all_rows()
    }

    /// When the solver stops.
    pub fn settings(&self) -> Settings {
        self.task.settings
    }

    /// Sets when the solver stops, from the next problem on.
    pub fn set_settings(&mut self, settings: Settings) {
        self.task.settings = settings;
    }

    /// Keeps the residuals that are looked at during solves from now on.
    pub fn keep_history(&mut self) {
        self.task.drive.history = Some(Vec::new());
    }

    /// The residuals that were looked at during the last solve, where they are kept. The exact solver looks at none.
    pub fn history(&self) -> &[ResidualSample] {
        self.task.drive.history.as_deref().unwrap_or_default()
    }

    /// Solves a problem. `gamma` is the start (missing numbers are taken as zero, so are negative ones and ones that
    /// are not finite) and becomes the solution, or the best iterate found, never worse than the start.
    ///
    /// The velocity `J^T gamma` of a solution is unique; `gamma` is not where rows depend on each other.
    ///
    /// # Panics
    /// If the lengths in the problem differ, or a row names a body that is not there.
    pub fn solve(&mut self, problem: &Problem<D>, gamma: &mut Vec<f64>) -> Outcome {
        self.engine.forget();
        self.solve_next(problem, gamma)
    }

    /// [`Solver::solve`] for a problem much like the last one, as that with rows added. Where that one was too much for
    /// conjugate gradients, `auto` begins with the interior-point method.
    ///
    /// # Panics
    /// As [`Solver::solve`].
    pub fn solve_next(&mut self, problem: &Problem<D>, gamma: &mut Vec<f64>) -> Outcome {
        gamma.resize(problem.q.len(), 0.0);
        let Task { cpu, drive, .. } = &mut self.task;
        drive.history.iter_mut().for_each(Vec::clear);
        cpu.rebuild(problem);
        cpu.import(gamma, &mut drive.at.x);
        self.run(gamma, false)
    }

    /// Goes on with the last problem, from where the last call left it.
    pub fn go_on(&mut self, gamma: &mut [f64]) -> Outcome {
        let Task { cpu, drive, .. } = &mut self.task;
        drive.history.iter_mut().for_each(Vec::clear);
        cpu.count_anew();
        self.run(gamma, true)
    }

    fn run(&mut self, gamma: &mut [f64], goes_on: bool) -> Outcome {
        let outcome = self.engine.solve(&mut self.task, goes_on);
        self.task.cpu.export(&self.task.drive.at.x, gamma);
        outcome
    }
}
