//! One door to all solvers.

use super::apgd::Apgd;
use super::bbpgd::Bbpgd;
use super::cluster_cg::ClusterCg;
use super::cpu::Cpu;
use super::dense::Dense;
use super::drive::{Drive, ResidualSample, Standing};
use super::interior_point::{InteriorPoint, MOST_ITERATIONS};
use super::local::Local;
use super::pair_block_cg::PairBlockCg;
use super::projected_gauss_seidel::ProjectedGaussSeidel;
use super::projected_jacobi::ProjectedJacobi;
use super::team::{self, Team};
use super::verbs::Verbs;
use super::{Outcome, Places, Problem, Settings, SolverKind, Status};

/// How many sweeps of Gauss-Seidel are made for one look at the residual, which costs a product more.
const SWEEPS: u64 = 4;

/// Iterations that `auto` takes, and those that it may still need, before it asks what the interior-point method would
/// cost: about as many as finding out costs.
const ITERATIONS_BEFORE_FORECAST: u64 = 200;

/// Iterations between two looks at how the residual falls: what is left is forecast from the last two of them.
const WINDOW: u64 = 100;

/// The least part of what the interior-point method would cost that `auto` spends on conjugate gradients first, since
/// residuals pause: 0 to 0.3 cost the same within 3 %.
const LEAST_BEFORE_SAFEGUARD: f64 = 0.1;

/// And for nearly parallel rows the part of it that conjugate gradients may still need. 200 LCPs of colonies take the
/// same time within 4 % with none to a half, and up to 8 % more with all of it.
const HOPE: f64 = 0.25;

/// With so few rows the interior-point method takes over as soon as the residuals show that conjugate gradients are
/// slow: where cells fill a chamber, nearly singular wedges make residuals fall ever more slowly.
const MOST_ROWS_WITHOUT_PATIENCE: usize = 1024;

/// What an iteration costs beside its rows, which counts where these are few: 170 rows of a chamber take 9 microseconds
/// an iteration on one core, 12 nanoseconds a row of them (November 2026).
const NANOSECONDS_OF_AN_ITERATION: f64 = 6000.0;

/// With fewer rows, looking for what is left costs more than it saves.
const LEAST_ROWS: usize = 256;

/// Iterations on all rows before `auto` looks for the first time whether what is left is little, and between looks.
const FIRST_LOOK: u64 = 20;
const LOOK_EVERY: u64 = 20;

/// Most times that a solve goes on locally without success: what is left may have no solution, and all iterations must
/// see that.
const MOST_ATTEMPTS: u32 = 3;

/// It looks while the residual is at most so many tolerances.
const NEARLY: f64 = 10.0;

/// Nanoseconds of an iteration of the conjugate gradients for each row, on one core: 11 to 16 for 3,000 to 54,000 rows
/// (November 2026), whatever the unknowns. The number of threads changes no decision, so that it changes no bits.
const NANOSECONDS_OF_A_ROW: f64 = 12.0;

/// The same for nearly parallel rows, which stand in their pairs' order: 18 to 27, and 55 to 65 beyond the cache.
const NANOSECONDS_OF_A_PARALLEL_ROW: f64 = 20.0;

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
pub struct Solver<const D: usize> {
    settings: Settings,
    pub(super) cpu: Cpu<D>,
    pub(super) drive: Drive<Vec<f64>>,
    engine: Engine<D>,
    /// The tolerance that it was made with.
    tightest: f64,
    /// Goes on where the engine of `auto` gives up.
    safeguard: Option<InteriorPoint<D>>,
    /// Whether the last problem was solved by the safeguard.
    guarded: bool,
    /// What the safeguard would cost, where that was asked for since the last call of [`Solver::solve`].
    forecast: Option<f64>,
    /// Solves what is left where that is little.
    local: Option<Local>,
    /// Whether conjugate gradients may take as long as the safeguard would, whatever their residuals make one expect.
    patient: bool,
    /// Whether conjugate gradients have begun with the present problem.
    iterated: bool,
    /// Threads for them, where their sums are made for that.
    team: Option<Team>,
}

enum Engine<const D: usize> {
    ProjectedJacobi(ProjectedJacobi<Vec<f64>>),
    ProjectedGaussSeidel(ProjectedGaussSeidel<D>),
    Apgd(Apgd<Cpu<D>>),
    Bbpgd(Bbpgd<Cpu<D>>),
    PairBlockCg(PairBlockCg<Vec<f64>, f64>),
    ClusterCg(ClusterCg<Vec<f64>, f64>),
    Dense(Dense),
    InteriorPoint(Box<InteriorPoint<D>>),
}

impl<const D: usize> Solver<D> {
    /// A solver of a kind. [`SolverKind::Auto`] is projected nonlinear conjugate gradients with the blocks of the
    /// pairs, and the interior-point method where those end with [`Status::NoProgress`] or [`Status::MaxIterations`],
    /// or their end is not in sight.
    pub fn new(kind: SolverKind, settings: Settings) -> Self {
        let engine = match kind {
            SolverKind::ProjectedJacobi => Engine::ProjectedJacobi(ProjectedJacobi::default()),
            SolverKind::ProjectedGaussSeidel => Engine::ProjectedGaussSeidel(ProjectedGaussSeidel::default()),
            SolverKind::Apgd => Engine::Apgd(Apgd::new()),
            SolverKind::Bbpgd => Engine::Bbpgd(Bbpgd::new()),
            SolverKind::Auto | SolverKind::PairBlockCg => Engine::PairBlockCg(PairBlockCg::new()),
            SolverKind::ClusterCg => Engine::ClusterCg(ClusterCg::to(settings.tolerance)),
            SolverKind::Dense => Engine::Dense(Dense::default()),
            SolverKind::InteriorPoint => Engine::InteriorPoint(Box::default()),
        };
        let safeguard = (kind == SolverKind::Auto).then(InteriorPoint::default);
        let tightest = settings.tolerance;
        Solver {
            settings,
            tightest,
            cpu: Cpu::default(),
            drive: Drive::default(),
            engine,
            safeguard,
            guarded: false,
            forecast: None,
            local: (kind == SolverKind::Auto).then(Local::default),
            patient: true,
            iterated: false,
            team: Some(Team::default()),
        }
    }

    /// The same for LCPs with many nearly parallel rows, such as a recursion appends. These slow conjugate gradients
    /// down, so that `auto` goes over to the interior-point method as soon as the residuals show it.
    pub fn for_parallel_rows(mut self) -> Self {
        (self.local, self.patient, self.team) = (None, false, None);
        self.cpu = Cpu::for_parallel_rows();
        self
    }

    /// Sets the order of the bodies of the next problems. Where they are a process's domain, all processes
    /// solve together, and the problem is the rows of this one.
    pub(crate) fn place(&mut self, places: Option<Places>) {
        self.cpu.place(places);
    }

    /// How many rows the last problem had, with those of other processes.
    pub(crate) fn all_rows(&self) -> usize {
        self.cpu.all_rows()
    }

    /// When the solver stops.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Sets when the solver stops, from the next problem on.
    pub fn set_settings(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Keeps the residuals that are looked at during solves from now on.
    pub fn keep_history(&mut self) {
        self.drive.history = Some(Vec::new());
    }

    /// The residuals that were looked at during the last solve, where they are kept. The exact solver looks at none.
    pub fn history(&self) -> &[ResidualSample] {
        self.drive.history.as_deref().unwrap_or_default()
    }

    /// Solves a problem. `gamma` is the start (missing numbers are taken as zero, so are negative ones and ones that
    /// are not finite) and becomes the solution, or the best iterate found, never worse than the start.
    ///
    /// The velocity `J^T gamma` of a solution is unique; `gamma` is not where rows depend on each other.
    ///
    /// # Panics
    /// If the lengths in the problem differ, or a row names a body that is not there.
    pub fn solve(&mut self, problem: &Problem<D>, gamma: &mut Vec<f64>) -> Outcome {
        self.guarded = false;
        self.forecast = None;
        self.solve_next(problem, gamma)
    }

    /// [`Solver::solve`] for a problem much like the last one, as that with rows added. Where that one was too much for
    /// conjugate gradients, `auto` begins with the interior-point method.
    ///
    /// # Panics
    /// As [`Solver::solve`].
    pub fn solve_next(&mut self, problem: &Problem<D>, gamma: &mut Vec<f64>) -> Outcome {
        gamma.resize(problem.q.len(), 0.0);
        self.drive.history.iter_mut().for_each(Vec::clear);
        self.cpu.rebuild(problem);
        self.iterated = false;
        if let Engine::PairBlockCg(method) = &mut self.engine {
            method.go_on(false);
        }
        self.cpu.import(gamma, &mut self.drive.at.x);
        if let Some(safeguard) = &mut self.safeguard {
            safeguard.forget();
        }
        let outcome = match self.begin_locally() {
            Some(solved) => solved,
            None if self.guarded => self.begin_guarded(),
            None => self.begin(),
        };
        // A later problem with few changes is easier than the first one, if its rows are not nearly parallel.
        self.guarded = outcome.fallback && outcome.status == Status::Solved && !self.patient;
        self.cpu.export(&self.drive.at.x, gamma);
        outcome
    }

    /// Goes on with the last problem, from where the last call left it.
    pub fn go_on(&mut self, gamma: &mut [f64]) -> Outcome {
        self.drive.history.iter_mut().for_each(Vec::clear);
        self.cpu.count_anew();
        if let Engine::PairBlockCg(method) = &mut self.engine {
            method.go_on(self.iterated);
        }
        let outcome = self.begin();
        self.cpu.export(&self.drive.at.x, gamma);
        outcome
    }

    /// Solves where the start is no solution, if that is in few places.
    fn begin_locally(&mut self) -> Option<Outcome> {
        let (cpu, Drive { at, .. }) = (&mut self.cpu, &mut self.drive);
        let large = cpu.all_rows() >= LEAST_ROWS;
        let local = self.local.as_mut().filter(|_| large && cpu.is_finite())?;
        let tolerance = self.settings.tolerance;
        cpu.clear(&mut at.g);
        cpu.gradient(&at.x, &mut at.g);
        // A start within the tolerance is iterated on, all of it.
        if cpu.residual(&at.x, &at.g) <= tolerance || !local.is_worth(cpu, at, tolerance) {
            return None;
        }
        let rounds = local.run(cpu, at, tolerance);
        cpu.count(rounds.work / cpu.all_rows().max(1) as u64);
        rounds.solved.then(|| self.outcome(Status::Solved, rounds.iterations, rounds.residual, 0))
    }

    /// Begins with the solver's own method, and calls the safeguard where it is needed. Where that is of no help, the
    /// method goes on as long as it may.
    fn begin(&mut self) -> Outcome {
        let (mut status, mut iterations, mut residual) = self.iterate_and_finish_locally();
        let unsolved = matches!(status, Status::NoProgress | Status::RoundingFloor | Status::MaxIterations);
        if self.safeguard.is_none() || !unsolved {
            let factorizations = match &self.engine {
                Engine::InteriorPoint(method) => method.factorizations(),
                _ => 0,
            };
            return self.outcome(status, iterations, residual, factorizations);
        }
        let (ended, more, found, factorizations) = self.guard();
        iterations += more;
        residual = found;
        let left = self.settings.max_iterations.saturating_sub(iterations);
        if matches!(ended, Status::Solved | Status::Infeasible) {
            status = ended;
        } else if status == Status::MaxIterations && left > 0 {
            let (ended, more, found) = self.iterate(left, false);
            (status, residual) = (ended, found);
            iterations += more;
        }
        self.outcome(status, iterations, residual, factorizations)
    }

    /// Begins with the safeguard.
    fn begin_guarded(&mut self) -> Outcome {
        if !self.cpu.is_finite() {
            return self.outcome(Status::NotFinite, 0, f64::INFINITY, 0);
        }
        let (mut status, mut iterations, mut residual, factorizations) = self.guard();
        if !matches!(status, Status::Solved | Status::Infeasible) {
            let (ended, more, found) = self.iterate(self.settings.max_iterations, false);
            (status, residual) = (ended, found);
            iterations += more;
        }
        self.outcome(status, iterations, residual, factorizations)
    }

    /// Conjugate gradients from the present iterate, whichever the solver's own method is.
    pub(super) fn conjugate_gradients(&mut self, max_iterations: u64) -> (Status, u64, f64) {
        let settings = Settings { max_iterations, ..self.settings };
        self.drive.run(&mut self.cpu, &mut PairBlockCg::new(), &settings, 1)
    }

    fn outcome(&self, status: Status, iterations: u64, residual: f64, factorizations: u64) -> Outcome {
        let fallback = factorizations > 0 && self.safeguard.is_some();
        Outcome { status, iterations, products: self.cpu.products(), factorizations, fallback, residual }
    }

    /// Goes on from the present iterate with the safeguard, to the tolerance that this solver was made with if that is
    /// tighter: a few factorizations more now save all of another solve. The last number is how many factorizations
    /// that took.
    fn guard(&mut self) -> (Status, u64, f64, u64) {
        let Some(safeguard) = &mut self.safeguard else { return (Status::NoProgress, 0, f64::INFINITY, 0) };
        let tolerance = self.settings.tolerance.min(self.tightest);
        let settings = Settings { tolerance, max_iterations: MOST_ITERATIONS };
        let (ended, more, found) = if self.cpu.is_domain() {
            let mut whole = Whole::of(&mut self.cpu, &mut self.drive);
            let run = safeguard.run(&mut whole.cpu, &mut whole.drive, &settings, tolerance);
            whole.give_back(&mut self.cpu, &mut self.drive);
            run
        } else {
            safeguard.run(&mut self.cpu, &mut self.drive, &settings, tolerance)
        };
        (ended, more, found, safeguard.factorizations())
    }

    /// Iterates until what is left is little and in few places, and then there, as long as that happens.
    fn iterate_and_finish_locally(&mut self) -> (Status, u64, f64) {
        let (mut iterations, mut next, mut attempts) = (0, FIRST_LOOK, MOST_ATTEMPTS);
        loop {
            let left = self.settings.max_iterations.saturating_sub(iterations);
            let (cpu, drive) = (&mut self.cpu, &mut self.drive);
            let (Some(local), Some(safeguard), Engine::PairBlockCg(method)) =
                (&mut self.local, &mut self.safeguard, &mut self.engine)
            else {
                return self.iterate(left, true);
            };
            if !cpu.is_finite() {
                return (Status::NotFinite, 0, f64::INFINITY);
            }
            self.iterated = true;
            let settings = &Settings { max_iterations: left, ..self.settings };
            let mut goes_on = affordable(safeguard, &mut self.forecast, settings.tolerance, self.patient);
            let looks = |standing: Standing| {
                let due = standing.iterations >= next && standing.iterations.is_multiple_of(LOOK_EVERY);
                attempts > 0 && due && standing.residual <= NEARLY * settings.tolerance
            };
            let mut few = false;
            let pauses = |standing: Standing| looks(standing) || standing.iterations.is_multiple_of(WINDOW);
            let (status, more, found) =
                team::run(&mut self.team, cpu, drive, method, settings, &pauses, |cpu, at, standing| {
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

    /// Goes on from the present iterate with the solver's own method; if there is a safeguard and it is wanted, until
    /// its turn has come.
    fn iterate(&mut self, max_iterations: u64, guarded: bool) -> (Status, u64, f64) {
        let (cpu, drive) = (&mut self.cpu, &mut self.drive);
        let settings = &Settings { max_iterations, ..self.settings };
        if !cpu.is_finite() {
            return (Status::NotFinite, 0, f64::INFINITY);
        }
        match &mut self.engine {
            Engine::ProjectedJacobi(method) => drive.run(cpu, method, settings, 1),
            Engine::ProjectedGaussSeidel(method) => drive.run(cpu, method, settings, SWEEPS),
            Engine::Apgd(method) => drive.run(cpu, method, settings, 1),
            Engine::Bbpgd(method) => drive.run(cpu, method, settings, 1),
            Engine::ClusterCg(method) => {
                method.aim_at(settings.tolerance);
                drive.run(cpu, method, settings, 1)
            }
            Engine::PairBlockCg(method) => {
                let pauses = |standing: Standing| standing.iterations.is_multiple_of(WINDOW);
                let safeguard = self.safeguard.as_mut().filter(|_| guarded);
                let (forecast, tolerance, patient) = (&mut self.forecast, settings.tolerance, self.patient);
                let mut worth = safeguard.map(|safeguard| affordable(safeguard, forecast, tolerance, patient));
                team::run(&mut self.team, cpu, drive, method, settings, &pauses, |cpu, _, standing| {
                    worth.as_mut().is_none_or(|worth| worth(cpu, standing))
                })
            }
            Engine::Dense(method) => method.run(cpu, &mut drive.at, settings),
            // As in the drive: a start is no solution because multipliers of the last step are small.
            Engine::InteriorPoint(method) => method.run(cpu, drive, settings, 0.0),
        }
    }
}

/// All of a problem that processes share, for a method that each of them takes alone.
struct Whole<const D: usize> {
    cpu: Cpu<D>,
    drive: Drive<Vec<f64>>,
}

impl<const D: usize> Whole<D> {
    fn of(cpu: &mut Cpu<D>, drive: &mut Drive<Vec<f64>>) -> Self {
        let mut whole = Whole { cpu: cpu.gathered().clone(), drive: Drive::default() };
        whole.cpu.count_anew();
        whole.drive.at.x = cpu.gather_numbers(&drive.at.x);
        whole.drive.history = drive.history.take();
        whole
    }

    /// Goes on with what of it is here.
    fn give_back(self, cpu: &mut Cpu<D>, drive: &mut Drive<Vec<f64>>) {
        cpu.count(self.cpu.products_made());
        drive.at.x = cpu.numbers_here(&self.drive.at.x);
        drive.history = self.drive.history;
    }
}

/// Says where a solve stands whether one more iteration is worth it: while all of them have not cost as much as the
/// safeguard would, and if `patient` is false while what is left, as the last iterations make one expect, costs less
/// than a part of it. Later problems of a step keep its first forecast: they have the same pairs and few more.
fn affordable<const D: usize>(
    safeguard: &mut InteriorPoint<D>,
    forecast: &mut Option<f64>,
    tolerance: f64,
    patient: bool,
) -> impl FnMut(&Cpu<D>, Standing) -> bool {
    let mut marks = [f64::INFINITY; 2];
    move |cpu, Standing { iterations, least, .. }| {
        if !iterations.is_multiple_of(WINDOW) {
            return true;
        }
        let gain = (marks[0] / least).ln() / (2 * WINDOW) as f64;
        marks = [marks[1], least];
        let left = (least / tolerance).ln() / gain;
        if iterations < ITERATIONS_BEFORE_FORECAST || left <= ITERATIONS_BEFORE_FORECAST as f64 {
            return true;
        }
        let cost = *forecast.get_or_insert_with(|| safeguard.forecast(cpu.gathered()).unwrap_or(f64::INFINITY));
        let of_a_row = if patient { NANOSECONDS_OF_A_ROW } else { NANOSECONDS_OF_A_PARALLEL_ROW };
        let few = patient && cpu.all_rows() <= MOST_ROWS_WITHOUT_PATIENCE;
        let besides = if few { NANOSECONDS_OF_AN_ITERATION } else { 0.0 };
        let instead = cost / (of_a_row * cpu.all_rows() as f64 + besides);
        let taken = iterations as f64;
        let patient = patient && !few;
        taken < LEAST_BEFORE_SAFEGUARD * instead || (taken < instead && (patient || left < HOPE * instead))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spheres in a line, each too near the next by one to two lengths: an iteration carries news by one body.
    fn chain(links: u32) -> Problem<3> {
        let along = |x: f64| [x, 0.0, 0.0];
        Problem {
            bodies: links as usize + 1,
            pair: (0..links).map(|i| [i, i + 1]).collect(),
            jacobian: vec![[along(-1.0), along(1.0)]; links as usize],
            q: (0..links).map(|i| -1.0 - f64::from(i * 7_919 % links) / f64::from(links)).collect(),
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

        solver.safeguard = Some(InteriorPoint::with_largest_factor(10));
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
        assert_eq!((again.iterations, again.fallback, solver.guarded), (0, false, false));
    }

    /// The iteration at which a residual that falls by a factor every hundred iterations is given up, where the
    /// safeguard costs as much as 2,000.
    fn given_up(factor: f64) -> u64 {
        let mut cpu = Cpu::default();
        cpu.rebuild(&chain(1_000));
        let mut forecast = Some(2_000.0 * NANOSECONDS_OF_A_PARALLEL_ROW * 1_000.0);
        let mut safeguard = InteriorPoint::default();
        let mut goes_on = affordable(&mut safeguard, &mut forecast, 1e-6, false);
        let goes_on = |iteration: &u64| {
            let residual = factor.powf(*iteration as f64 / -100.0);
            goes_on(&cpu, Standing { iterations: *iteration, residual, least: residual })
        };
        (0..5_000).take_while(goes_on).count() as u64
    }

    #[test]
    fn a_solve_is_handed_over_where_what_is_left_costs_more_than_it_may() {
        assert_eq!(given_up(1.0), ITERATIONS_BEFORE_FORECAST);
        assert_eq!(given_up(1.5), ITERATIONS_BEFORE_FORECAST);
        // Four decades are left after 200 iterations, at one for every hundred.
        assert_eq!(given_up(10.0), 5_000);
    }

    #[test]
    fn the_last_iteration_allowed_is_not_exceeded_where_nothing_helps() {
        let settings = Settings { tolerance: 1e-12, max_iterations: ITERATIONS_BEFORE_FORECAST + 20 };
        let mut solver = Solver::new(SolverKind::Auto, settings).for_parallel_rows();
        solver.safeguard = Some(InteriorPoint::with_largest_factor(10));
        let outcome = solver.solve(&chain(6_000), &mut Vec::new());
        assert_eq!((outcome.status, outcome.iterations), (Status::MaxIterations, settings.max_iterations));
    }
}
