//! `auto`: projected nonlinear conjugate gradients with the blocks of the pairs, with a safeguard. Where these end
//! without success, or their end is not in sight (`worth`), the interior-point method goes on. Where what is left is
//! little and in few places it is solved there ([`super::local`]).

mod worth;

use super::Outcome;
use super::cpu::Cpu;
use super::drive::{Drive, Standing};
use super::engine::Task;
use super::interior_point::{InteriorPoint, MOST_ITERATIONS};
use super::local::Local;
use super::pair_block_cg::PairBlockCg;
use super::portion::Portion;
use super::team::{self, Team};
use super::verbs::Verbs;
use super::{Settings, Status};
use worth::{WINDOW, affordable};

/// With fewer rows, looking for what is left costs more than it saves.
const LEAST_ROWS: usize = 256;

/// Iterations on all rows before it looks for the first time whether what is left is little, and between looks.
const FIRST_LOOK: u64 = 20;
const LOOK_EVERY: u64 = 20;

/// Most times that a solve goes on locally without success: what is left may have no solution, and all iterations must
/// see that.
const MOST_ATTEMPTS: u32 = 3;

/// It looks while the residual is at most so many tolerances.
const NEARLY: f64 = 10.0;

/// The solver, and what it remembers from one problem to the next.
pub(super) struct Auto<const D: usize> {
    method: PairBlockCg<Vec<f64>, f64>,
    /// Threads for it, where its sums are made for that.
    team: Option<Team>,
    /// Goes on where the method gives up.
    safeguard: InteriorPoint<D>,
    /// Solves what is left where that is little.
    local: Option<Local>,
    /// The tolerance that it was made with.
    tightest: f64,
    /// Whether the method may take as long as the safeguard would, whatever its residuals make one expect.
    patient: bool,
    /// Whether the last problem was solved by the safeguard.
    guarded: bool,
    /// What the safeguard would cost, where that was asked for since the last call of [`Auto::forget`].
    forecast: Option<f64>,
    /// Whether the method has begun with the present problem.
    iterated: bool,
}

impl<const D: usize> Auto<D> {
    /// For solves to this tolerance, and looser ones.
    pub fn to(tolerance: f64) -> Self {
        Auto {
            method: PairBlockCg::new(),
            team: Some(Team::default()),
            safeguard: InteriorPoint::default(),
            local: Some(Local::default()),
            tightest: tolerance,
            patient: true,
            guarded: false,
            forecast: None,
            iterated: false,
        }
    }

    /// From now on for problems with many nearly parallel rows, which slow conjugate gradients down.
    pub fn for_parallel_rows(&mut self) {
        (self.local, self.patient, self.team) = (None, false, None);
    }

    /// Forgets the last problem: the next one is not much like it.
    pub fn forget(&mut self) {
        (self.guarded, self.forecast) = (false, None);
    }

    /// Solves a new problem.
    pub fn solve<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> Outcome {
        self.iterated = false;
        self.method.go_on(false);
        self.safeguard.forget();
        let outcome = match self.begin_locally(task) {
            Some(solved) => solved,
            None if self.guarded => self.begin_guarded(task),
            None => self.begin(task),
        };
        // A later problem with few changes is easier than the first one, if its rows are not nearly parallel.
        self.guarded = outcome.fallback && outcome.status == Status::Solved && !self.patient;
        outcome
    }

    /// Goes on with the last problem, from where the last call left it.
    pub fn go_on<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> Outcome {
        self.method.go_on(self.iterated);
        self.begin(task)
    }

    /// Solves where the start is no solution, if that is in few places.
    fn begin_locally<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> Option<Outcome> {
        let Task { cpu, drive: Drive { at, .. }, settings } = task;
        let large = cpu.all_rows() >= LEAST_ROWS;
        let local = self.local.as_mut().filter(|_| large && cpu.is_finite())?;
        let tolerance = settings.tolerance;
        cpu.clear(&mut at.g);
        cpu.gradient(&at.x, &mut at.g);
        // A start within the tolerance is iterated on, all of it.
        if cpu.residual(&at.x, &at.g) <= tolerance || !local.is_worth(cpu, at, tolerance) {
            return None;
        }
        let rounds = local.run(cpu, at, tolerance);
        cpu.count(rounds.work / cpu.all_rows().max(1) as u64);
        rounds.solved.then(|| outcome(cpu, (Status::Solved, rounds.iterations, rounds.residual), 0))
    }

    /// Begins with the method, and calls the safeguard where it is needed. Where that is of no help, the method goes on
    /// as long as it may.
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

    /// Goes on from the present iterate with the safeguard, to the tolerance that this solver was made with if that is
    /// tighter: a few factorizations more now save all of another solve.
    fn guard<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> (Status, u64, f64) {
        let Task { cpu, drive, settings } = task;
        let tolerance = settings.tolerance.min(self.tightest);
        let settings = Settings { tolerance, max_iterations: MOST_ITERATIONS };
        P::solve_whole(cpu, drive, |cpu, drive| self.safeguard.run(cpu, drive, &settings, tolerance))
    }

    /// Iterates until what is left is little and in few places, and then there, as long as that happens.
    fn iterate_and_finish_locally<P: Portion<D>>(&mut self, task: &mut Task<D, P>) -> (Status, u64, f64) {
        let most = task.settings.max_iterations;
        let Some(local) = &mut self.local else { return self.iterate(task, most, true) };
        let Task { cpu, drive, settings } = task;
        if !cpu.is_finite() {
            return (Status::NotFinite, 0, f64::INFINITY);
        }
        self.iterated = true;
        let (mut iterations, mut next, mut attempts) = (0, FIRST_LOOK, MOST_ATTEMPTS);
        loop {
            let left = most.saturating_sub(iterations);
            let settings = &Settings { max_iterations: left, ..*settings };
            let mut goes_on = affordable(&mut self.safeguard, &mut self.forecast, settings.tolerance, self.patient);
            let looks = |standing: Standing| {
                let due = standing.iterations >= next && standing.iterations.is_multiple_of(LOOK_EVERY);
                attempts > 0 && due && standing.residual <= NEARLY * settings.tolerance
            };
            let mut few = false;
            let pauses = |standing: Standing| looks(standing) || standing.iterations.is_multiple_of(WINDOW);
            let (team, method) = (&mut self.team, &mut self.method);
            let (status, more, found) = team::run(team, cpu, drive, method, settings, &pauses, |cpu, at, standing| {
                few = looks(standing) && local.is_worth(cpu, at, settings.tolerance);
                !few && goes_on(cpu, standing)
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
            next = FIRST_LOOK.max(more);
            attempts -= 1;
        }
    }

    /// Goes on from the present iterate with the method; where it is `guarded`, until the safeguard's turn has come.
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
        let pauses = |standing: Standing| standing.iterations.is_multiple_of(WINDOW);
        let mut worth = affordable(&mut self.safeguard, &mut self.forecast, settings.tolerance, self.patient);
        team::run(&mut self.team, cpu, drive, &mut self.method, settings, &pauses, |cpu, _, standing| {
            !guarded || worth(cpu, standing)
        })
    }
}

/// How a solve ended, which took so many factorizations.
fn outcome<const D: usize, P: Portion<D>>(
    cpu: &Cpu<D, P>,
    (status, iterations, residual): (Status, u64, f64),
    factorizations: u64,
) -> Outcome {
    let (products, fallback) = (cpu.products_made(), factorizations > 0);
    Outcome { status, iterations, products, factorizations, fallback, residual }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lcp::engine::Engine;
    use crate::lcp::{Problem, Solver, SolverKind};

    /// Spheres in a line, each too near the next by one to two lengths: an iteration carries news by one body.
    pub(super) fn chain(links: u32) -> Problem<3> {
        let along = |x: f64| [x, 0.0, 0.0];
        Problem {
            bodies: links as usize + 1,
            pair: (0..links).map(|i| [i, i + 1]).collect(),
            jacobian: vec![[along(-1.0), along(1.0)]; links as usize],
            q: (0..links).map(|i| -1.0 - f64::from(i * 7_919 % links) / f64::from(links)).collect(),
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
        // One that is solved at its start needs nobody.
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
