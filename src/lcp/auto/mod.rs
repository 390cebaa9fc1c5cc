//! `auto`: projected nonlinear conjugate gradients with the blocks of the pairs, with a safeguard. If these fail or
//! converge too slowly (`worth`), the interior-point method takes over. If few rows remain unsolved, only these are
//! solved ([`super::local`]).

mod worth;

use super::Outcome;
use super::cpu::Cpu;
use super::drive::{Drive, Progress};
use super::engine::Task;
use super::interior_point::{InteriorPoint, MOST_ITERATIONS, Manner};
use super::local::Local;
use super::pair_block_cg::PairBlockCg;
use super::portion::Portion;
use super::team::{self, Team};
use super::verbs::Verbs;
use super::{Settings, Status};
use worth::{WINDOW, affordable};

/// With fewer rows, local solves cost more than they save.
const LEAST_ROWS: usize = 256;

/// Iterations on all rows before the first check whether few rows remain unsolved, and between checks.
const FIRST_CHECK: u64 = 20;
const CHECK_EVERY: u64 = 20;

/// The largest number of failed local attempts: the remaining rows may have no solution, which only iterations on all
/// rows can show.
const MOST_ATTEMPTS: u32 = 3;

/// It checks only while the residual is at most this many tolerances.
const NEARLY: f64 = 10.0;

/// The solver and its state between problems.
pub(super) struct Auto<const D: usize> {
    method: PairBlockCg<Vec<f64>, f64>,
    /// Its threads, if its sums support them.
    team: Option<Team>,
    /// Takes over if the method fails.
    safeguard: InteriorPoint<D>,
    /// Solves the remaining rows if they are few.
    local: Option<Local>,
    /// The tolerance that it was created with.
    tightest: f64,
    /// Whether problems have many nearly parallel rows, which slow conjugate gradients down.
    parallel_rows: bool,
    /// Whether the last problem was solved by the safeguard.
    guarded: bool,
    /// The predicted cost of the safeguard, if computed since the last call of [`Auto::forget`].
    forecast: Option<f64>,
    /// Whether the method has started on the present problem.
    iterated: bool,
}

impl<const D: usize> Auto<D> {
    /// A solver for this tolerance and looser ones.
    pub fn to(tolerance: f64) -> Self {
        Auto {
            method: PairBlockCg::new(),
            team: Some(Team::default()),
            safeguard: InteriorPoint::default(),
            local: Some(Local::default()),
            tightest: tolerance,
            parallel_rows: false,
            guarded: false,
            forecast: None,
            iterated: false,
        }
    }

    /// Tunes it for problems with many nearly parallel rows, which slow conjugate gradients down.
    pub fn for_parallel_rows(&mut self) {
        (self.local, self.parallel_rows, self.team) = (None, true, None);
    }

    /// The tolerance that it was created with, if it may solve islands one by one: not with many nearly parallel rows.
    pub fn for_islands(&self) -> Option<f64> {
        (!self.parallel_rows).then_some(self.tightest)
    }

    /// Drops the state from the last problem, because the next one differs much.
    pub fn forget(&mut self) {
        (self.guarded, self.forecast) = (false, None);
    }

    /// Solves a new problem.
    pub fn solve<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> Outcome {
        self.iterated = false;
        self.method.keep_displacements(false);
        self.safeguard.forget();
        let outcome = match self.begin_locally(task) {
            Some(solved) => solved,
            None if self.guarded => self.begin_guarded(task),
            None => self.begin(task),
        };
        // A later problem with few changes is easier than the first one, if its rows are not nearly parallel.
        self.guarded = outcome.fallback && outcome.status == Status::Solved && self.parallel_rows;
        outcome
    }

    /// Continues with the last problem from the last iterate.
    pub fn resume<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> Outcome {
        self.method.keep_displacements(self.iterated);
        self.begin(task)
    }

    /// Solves the rows that the start does not solve, if they are few.
    fn begin_locally<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> Option<Outcome> {
        let Task { cpu, drive: Drive { at, .. }, settings } = task;
        let large = cpu.all_rows() >= LEAST_ROWS;
        let local = self.local.as_mut().filter(|_| large && cpu.is_finite())?;
        let tolerance = settings.tolerance;
        cpu.clear(&mut at.g);
        cpu.gradient(&at.x, &mut at.g);
        // A start within the tolerance is iterated as a whole.
        if cpu.residual(&at.x, &at.g) <= tolerance || !local.is_worth(cpu, at, tolerance) {
            return None;
        }
        let rounds = local.run(cpu, at, tolerance);
        cpu.count(rounds.work / cpu.all_rows().max(1) as u64);
        rounds.solved.then(|| outcome(cpu, (Status::Solved, rounds.iterations, rounds.residual), 0))
    }

    /// Begins with the method and falls back to the safeguard. If that fails too, the method continues to the iteration
    /// limit.
    fn begin<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> Outcome {
        let (mut status, mut iterations, mut residual) = self.iterate_and_finish_locally(task);
        if !matches!(status, Status::NoProgress | Status::RoundingFloor | Status::MaxIterations) {
            return outcome(&task.cpu, (status, iterations, residual), 0);
        }
        let (ended, more, found) = self.guard(task);
        iterations += more;
        residual = found;
        let left = task.settings.max_iterations.saturating_sub(iterations);
        if matches!(ended, Status::Solved | Status::Infeasible) {
            status = ended;
        } else if status == Status::MaxIterations && left > 0 {
            let (ended, more, found) = self.iterate(task, left, false);
            (status, residual) = (ended, found);
            iterations += more;
        }
        outcome(&task.cpu, (status, iterations, residual), self.safeguard.factorizations())
    }

    /// Begins with the safeguard.
    fn begin_guarded<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> Outcome {
        if !task.cpu.is_finite() {
            return outcome(&task.cpu, (Status::NotFinite, 0, f64::INFINITY), 0);
        }
        let (mut status, mut iterations, mut residual) = self.guard(task);
        if !matches!(status, Status::Solved | Status::Infeasible) {
            let most = task.settings.max_iterations;
            let (ended, more, found) = self.iterate(task, most, false);
            (status, residual) = (ended, found);
            iterations += more;
        }
        outcome(&task.cpu, (status, iterations, residual), self.safeguard.factorizations())
    }

    /// Continues from the present iterate with the safeguard, to this solver's own tolerance if that is tighter: a few
    /// more factorizations now save another solve. Where that stalls, it tries once more with gaps that use up the
    /// tolerance.
    fn guard<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> (Status, u64, f64) {
        let Task { cpu, drive, settings } = task;
        let (allowed, tolerance) = (settings.tolerance, settings.tolerance.min(self.tightest));
        let settings = Settings { tolerance, max_iterations: MOST_ITERATIONS };
        let manner = if self.iterated { Manner::Near } else { Manner::Exact };
        let lenient = Settings { tolerance: allowed, ..settings };
        P::solve_whole(cpu, drive, |cpu, drive| {
            let (status, iterations, residual) = self.safeguard.run(cpu, drive, &settings, tolerance, manner);
            if !matches!(status, Status::NoProgress | Status::MaxIterations) {
                return (status, iterations, residual);
            }
            let (status, more, residual) = self.safeguard.run(cpu, drive, &lenient, lenient.tolerance, Manner::Lenient);
            (status, iterations + more, residual)
        })
    }

    /// Iterates until few rows remain unsolved, then solves only these; repeats if needed.
    fn iterate_and_finish_locally<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> (Status, u64, f64) {
        let most = task.settings.max_iterations;
        let Some(local) = &mut self.local else { return self.iterate(task, most, true) };
        let Task { cpu, drive, settings } = task;
        if !cpu.is_finite() {
            return (Status::NotFinite, 0, f64::INFINITY);
        }
        self.iterated = true;
        let (mut iterations, mut next, mut attempts) = (0, FIRST_CHECK, MOST_ATTEMPTS);
        loop {
            let left = most.saturating_sub(iterations);
            let settings = &Settings { max_iterations: left, ..*settings };
            let mut goes_on =
                affordable(&mut self.safeguard, &mut self.forecast, settings.tolerance, self.parallel_rows);
            let is_due = |progress: Progress| {
                let due = progress.iterations >= next && progress.iterations.is_multiple_of(CHECK_EVERY);
                attempts > 0 && due && progress.residual <= NEARLY * settings.tolerance
            };
            let mut few = false;
            let pauses = |progress: Progress| is_due(progress) || progress.iterations.is_multiple_of(WINDOW);
            let (team, method) = (&mut self.team, &mut self.method);
            let (status, more, found) = team::run(team, cpu, drive, method, settings, &pauses, |cpu, at, progress| {
                few = is_due(progress) && local.is_worth(cpu, at, settings.tolerance);
                !few && goes_on(cpu, progress)
            });
            iterations += more;
            if !few {
                return (status, iterations, found);
            }
            let rounds = local.run(cpu, &mut drive.at, settings.tolerance);
            cpu.count(rounds.work / cpu.all_rows().max(1) as u64);
            iterations += rounds.iterations;
            if rounds.solved {
                return (Status::Solved, iterations, rounds.residual);
            }
            next = FIRST_CHECK.max(more);
            attempts -= 1;
        }
    }

    /// Continues from the present iterate with the method; if `guarded`, until the safeguard would be faster.
    fn iterate<P: Portion<D>>(
        &mut self,
        task: &mut Task<D, P>,
        max_iterations: u64,
        guarded: bool,
    ) -> (Status, u64, f64) {
        let Task { cpu, drive, settings } = task;
        let settings = &Settings { max_iterations, ..*settings };
        if !cpu.is_finite() {
            return (Status::NotFinite, 0, f64::INFINITY);
        }
        let pauses = |progress: Progress| progress.iterations.is_multiple_of(WINDOW);
        let mut worth = affordable(&mut self.safeguard, &mut self.forecast, settings.tolerance, self.parallel_rows);
        team::run(&mut self.team, cpu, drive, &mut self.method, settings, &pauses, |cpu, _, progress| {
            !guarded || worth(cpu, progress)
        })
    }
}

/// The outcome of a solve with this many factorizations.
fn outcome<const D: usize, P: Portion<D>>(
    cpu: &Cpu<D, P>,
    (status, iterations, residual): (Status, u64, f64),
    factorizations: u64,
) -> Outcome {
    let (products, fallback) = (cpu.products_made(), factorizations > 0);
    Outcome { status, iterations, products, factorizations, fallback, residual }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::lcp::engine::Engine;
    use crate::lcp::{Problem, Solver, SolverKind};

    /// Spheres in a line, each too near the next by one to two lengths: an iteration passes information on by one body.
    pub(in crate::lcp) fn chain(links: u32) -> Problem<3> {
        let along = |x: f64| [x, 0.0, 0.0];
        Problem {
            bodies: links as usize + 1,
            pair: (0..links).map(|i| [i, i + 1]).collect(),
            jacobian: vec![[along(-1.0), along(1.0)]; links as usize],
            q: (0..links).map(|i| -1.0 - f64::from(i * 7_919 % links) / f64::from(links)).collect(),
            ..Problem::default()
        }
    }

    fn auto(solver: &mut Solver<3>) -> &mut Auto<3> {
        match &mut solver.engine {
            Engine::Auto(auto) => auto,
            _ => panic!("another engine"),
        }
    }

    #[test]
    fn a_slow_solve_goes_on_with_the_safeguard_and_without_its_help_alone() {
        let problem = chain(3_000);
        let settings = Settings { tolerance: 1e-6, max_iterations: 100_000 };
        let mut solver = Solver::new(SolverKind::Auto, settings).for_parallel_rows();
        let mut gamma = Vec::new();
        let rescued = solver.solve(&problem, &mut gamma);
        assert_eq!((rescued.status, rescued.fallback), (Status::Solved, true), "{rescued:?}");
        assert!(rescued.iterations < 1_000, "{rescued:?}");

        auto(&mut solver).safeguard = InteriorPoint::with_largest_factor(10);
        let mut other = Vec::new();
        let alone = solver.solve(&problem, &mut other);
        assert_eq!((alone.status, alone.fallback), (Status::Solved, false), "{alone:?}");
        assert!(alone.iterations > 1_000 && alone.residual <= 1e-6, "{alone:?}");
        let (v, w) = (crate::lcp::velocity(&problem, &gamma), crate::lcp::velocity(&problem, &other));
        let apart = v.iter().zip(&w).map(|(v, w)| (v[0] - w[0]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-2, "{apart:e}");
    }

    #[test]
    fn a_problem_after_a_hard_one_begins_with_the_safeguard() {
        let problem = chain(3_000);
        let settings = Settings { tolerance: 1e-6, max_iterations: 100_000 };
        let mut solver = Solver::new(SolverKind::Auto, settings).for_parallel_rows();
        let hard = solver.solve(&problem, &mut Vec::new());
        let mut gamma = Vec::new();
        let next = solver.solve_next(&problem, &mut gamma);
        assert!(hard.fallback && next.fallback, "{hard:?} {next:?}");
        assert_eq!((next.status, next.iterations + 1), (Status::Solved, next.factorizations));
        let mut fresh = Solver::new(SolverKind::Auto, settings).for_parallel_rows();
        let alone = fresh.solve_next(&problem, &mut Vec::new());
        assert_eq!(alone, hard);
        assert_eq!(solver.solve(&problem, &mut Vec::new()), hard);
        // A problem that is solved at its start needs no iteration.
        let again = solver.solve_next(&problem, &mut gamma);
        assert_eq!((again.iterations, again.fallback, auto(&mut solver).guarded), (0, false, false));
    }

    #[test]
    fn the_last_iteration_allowed_is_not_exceeded_where_nothing_helps() {
        let settings = Settings { tolerance: 1e-12, max_iterations: worth::ITERATIONS_BEFORE_FORECAST + 20 };
        let mut solver = Solver::new(SolverKind::Auto, settings).for_parallel_rows();
        auto(&mut solver).safeguard = InteriorPoint::with_largest_factor(10);
        let outcome = solver.solve(&chain(6_000), &mut Vec::new());
        assert_eq!((outcome.status, outcome.iterations), (Status::MaxIterations, settings.max_iterations));
    }
}
