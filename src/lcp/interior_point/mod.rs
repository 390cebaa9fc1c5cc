//! The reference solver: a primal-dual interior-point method in the unknowns of the bodies, for sparse systems of any
//! conditioning.
//!
//! The LCP's multipliers are those of the strictly convex program `min 1/2 |v|^2` subject to `J v + q >= 0`, whose
//! solution is `v = J^T gamma`. Steps are Mehrotra's (On the implementation of a primal-dual interior point method,
//! 1992). Each factorizes one matrix `I + J^T W J` with one block per body and per pair (see [`normal_matrix`]), so
//! that the size of the factor does not grow with rows of the same pair. The proximal term of Friedlander and Orban (A
//! primal-dual regularized interior-point method for convex quadratic programs, 2012) on the multipliers bounds `W`, so
//! that rows may be repeated, parallel, or opposite without room between them. Rows are first scaled to length one;
//! zero rows are left out, and only their gap is checked.
//!
//! It takes some 10 to 25 factorizations at any conditioning, a quarter less from an approximate solution
//! ([`Manner::Near`]). Factorizations, solves and loops over rows run on all threads; no bit depends on their number.

mod contradiction;
mod iterate;
mod normal_matrix;
mod rows;

use super::cone::{is_open, residual, worse};
use super::cpu::Cpu;
use super::drive::{Drive, Point, ResidualSample};
use super::portion::Portion;
use super::verbs::Verbs;
use super::{Settings, Status};
use iterate::Iterate;
use normal_matrix::{NormalMatrix, Refused};
use rows::UnitRows;

/// The largest number of entries in the factor, 256 MiB: planar systems of some 200,000 rows. A square lattice with
/// 100,833 rows has 13.9 million, a colony's system with 3,602 has 0.11 million.
const LARGEST_FACTOR: usize = 1 << 25;

/// The largest number of iterations: of some 800 systems of all kinds none took more than 27.
pub(crate) const MOST_ITERATIONS: u64 = 100;

/// The solve ends after this many iterations in which neither the residual nor the infeasibility was halved. With 8 or
/// 10, two to four of 120 contradictions are given up before they are proven; with 15 none; 30 changes nothing.
const PATIENCE: u64 = 15;

/// The part of the tolerance that a lenient solve adds to each gap: closed rows may be violated by as much. In wedges
/// that are nearly contradictory a row shorter by a millionth takes a thousandth of the velocity and of the
/// multipliers. Of 2,500 solves of a chamber of 60 cells, 207 miss the tolerance without it, and 54 with it. Of 400 of
/// these, 391 miss it without, 190, 163 and 163 with 0.5, 0.9 and 0.95.
const RELIEF: f64 = 0.9;

/// Rows are relieved as soon as a multiplier is this many times the deepest violation, both of rows of length one.
const RELIEVED_FROM: f64 = 1e4;

/// Not before this iteration: the start has large multipliers.
const SETTLED: u64 = 10;

/// The cost model of [`InteriorPoint::forecast`]: the number of steps, and the nanoseconds of a step per multiplication
/// of its factorization and per unknown. On an idle core steps of 1,536 and 12,288 unknowns, with 2.1 and 61 million
/// multiplications, take 0.63 and 8.6 ms where an iteration of conjugate gradients takes 13 nanoseconds a row (Intel
/// Xeon, November 2026); the model is for 8 nanoseconds a row, which its user counts.
const STEPS: f64 = 20.0;
const NANOSECONDS_OF_A_MULTIPLICATION: f64 = 0.05;
const NANOSECONDS_OF_AN_UNKNOWN: f64 = 185.0;

/// The part of the best residual, and of the least infeasibility, that counts as a gain.
const GAIN: f64 = 0.5;

/// Where a solve starts, and what it may leave undone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Manner {
    /// It starts from the violations.
    Exact,
    /// It starts near the present multipliers, unless these are too large for it.
    Near,
    /// It goes on after a solve of the same problem that stalled: from the violations, but farther inside, and with
    /// gaps that may use up the tolerance.
    Lenient,
}

/// The solver. Its buffers are reused for the next problem.
pub(crate) struct InteriorPoint<const D: usize> {
    rows: UnitRows<D>,
    matrix: NormalMatrix<D>,
    iterate: Iterate<D>,
    /// The best multipliers so far, and the residual of the nonzero rows there.
    best: Vec<f64>,
    residual: f64,
    largest_factor: usize,
    /// The result of the pattern analysis of the present problem, if it was made.
    analysed: Option<Result<(), Refused>>,
}

impl<const D: usize> Default for InteriorPoint<D> {
    fn default() -> Self {
        InteriorPoint {
            rows: UnitRows::default(),
            matrix: NormalMatrix::default(),
            iterate: Iterate::default(),
            best: Vec::new(),
            residual: 0.0,
            largest_factor: LARGEST_FACTOR,
            analysed: None,
        }
    }
}

impl<const D: usize> InteriorPoint<D> {
    /// A solver that refuses factors with more entries than this.
    #[cfg(test)]
    pub fn with_largest_factor(largest_factor: usize) -> Self {
        InteriorPoint { largest_factor, ..InteriorPoint::default() }
    }

    /// Drops the analysis of a forecast: the next problem is a different one.
    pub fn forget(&mut self) {
        self.analysed = None;
    }

    /// The estimated time of a solve in nanoseconds; none if the factor would be too large. The next solve must be of
    /// the same problem.
    pub fn forecast<P: Portion<D>>(&mut self, cpu: &Cpu<D, P>) -> Option<f64> {
        self.rows.rebuild(&cpu.rows());
        let ready = self.matrix.analyse(&mut self.rows, self.largest_factor);
        self.analysed = Some(ready);
        let unknowns = (D * self.rows.bodies) as f64;
        let step = NANOSECONDS_OF_A_MULTIPLICATION * self.matrix.work() + NANOSECONDS_OF_AN_UNKNOWN * unknowns;
        ready.is_ok().then_some(STEPS * step)
    }

    /// Solves the problem. `drive.at.x` becomes the solution or the best iterate, never worse than it was. Iterations
    /// are steps. A start whose residual is at most `start_tolerance` counts as the solution.
    pub fn run<P: Portion<D>>(
        &mut self,
        cpu: &mut Cpu<D, P>,
        drive: &mut Drive<Vec<f64>>,
        settings: &Settings,
        start_tolerance: f64,
        manner: Manner,
    ) -> (Status, u64, f64) {
        let Drive { at, history, .. } = drive;
        self.iterate.reset(cpu.compliance());
        if manner == Manner::Lenient {
            self.analysed = self.matrix.is_analysed().then_some(Ok(()));
        } else {
            self.matrix.factorizations = 0;
        }
        cpu.clear(&mut at.g);
        cpu.gradient(&at.x, &mut at.g);
        let start = cpu.residual(&at.x, &at.g);
        if start <= start_tolerance {
            return (Status::Solved, 0, start);
        }
        if self.analysed.is_none() {
            self.rows.rebuild(&cpu.rows());
        }
        self.best.clone_from(&at.x);
        self.residual = self.live_residual(cpu, at);
        let (end, iterations) = if self.residual <= start_tolerance {
            (Status::Solved, 0)
        } else {
            self.search(cpu, at, history, settings, manner)
        };
        self.settle(cpu, at, settings.tolerance);
        cpu.count(self.iterate.halves.div_ceil(2));
        let residual = cpu.residual(&at.x, &at.g);
        let status = match end {
            _ if residual <= settings.tolerance => Status::Solved,
            // All nonzero rows are solved; the remaining residual is of a zero row with a negative gap.
            Status::Solved => Status::Infeasible,
            end => end,
        };
        (status, iterations, residual)
    }

    /// Factorizations of the last solve.
    pub fn factorizations(&self) -> u64 {
        self.matrix.factorizations
    }

    /// Searches for multipliers with a residual of at most the tolerance on the nonzero rows.
    fn search<P: Portion<D>>(
        &mut self,
        cpu: &mut Cpu<D, P>,
        at: &mut Point<Vec<f64>>,
        history: &mut Option<Vec<ResidualSample>>,
        settings: &Settings,
        manner: Manner,
    ) -> (Status, u64) {
        if self.rows.deepest == 0.0 {
            // Without multipliers no row is violated.
            at.x.fill(0.0);
            self.best.fill(0.0);
            self.residual = 0.0;
            return (Status::Solved, 0);
        }
        let most = settings.max_iterations.min(MOST_ITERATIONS);
        if most == 0 {
            return (Status::MaxIterations, 0);
        }
        let ready = self.analysed.take().unwrap_or_else(|| self.matrix.analyse(&mut self.rows, self.largest_factor));
        if let Err(refused) = ready.and_then(|()| self.begin(at, manner)) {
            return (refused.status(), 0);
        }
        let (mut residual, mut infeasibility, mut gained_at) = (f64::INFINITY, f64::INFINITY, 0);
        for iteration in 0.. {
            self.iterate.export(&self.rows, &mut at.x);
            cpu.gradient(&at.x, &mut at.g);
            self.relieve_if_tight(cpu, settings, manner, iteration);
            self.iterate.set_gradient(&self.rows, &at.g);
            let now = self.live_residual(cpu, at);
            if !now.is_finite() {
                return (Status::NotFinite, iteration);
            }
            if let Some(history) = history {
                let products = cpu.products() + self.iterate.halves.div_ceil(2);
                history.push(ResidualSample { iterations: iteration, products, residual: now });
            }
            if now < self.residual {
                self.residual = now;
                self.best.clone_from(&at.x);
            }
            if now <= settings.tolerance {
                return (Status::Solved, iteration);
            }
            if self.iterate.contradicts(&self.rows) {
                return (Status::Infeasible, iteration);
            }
            for (least, now) in [(&mut residual, now), (&mut infeasibility, self.iterate.infeasibility())] {
                if now <= GAIN * *least {
                    (*least, gained_at) = (now, iteration);
                }
            }
            if iteration >= most {
                return (Status::MaxIterations, iteration);
            }
            if iteration - gained_at >= PATIENCE {
                return (Status::NoProgress, iteration);
            }
            if let Err(refused) = self.iterate.advance(&self.rows, &mut self.matrix) {
                return (refused.status(), iteration);
            }
        }
        (Status::MaxIterations, most)
    }

    fn begin(&mut self, at: &Point<Vec<f64>>, manner: Manner) -> Result<(), Refused> {
        if manner == Manner::Near && self.iterate.begin_near(&self.rows, &at.x, &at.g) {
            return Ok(());
        }
        self.iterate.begin(&self.rows, &mut self.matrix, manner == Manner::Lenient)
    }

    /// Relieves the rows of a lenient solve once, if they turn out to be tight.
    fn relieve_if_tight<P: Portion<D>>(
        &mut self,
        cpu: &Cpu<D, P>,
        settings: &Settings,
        manner: Manner,
        iteration: u64,
    ) {
        // A compliance gives way by itself.
        let may = manner == Manner::Lenient && self.rows.relief == 0.0 && cpu.compliance() == 0.0;
        if may && iteration >= SETTLED && self.iterate.largest_multiplier() > RELIEVED_FROM * self.rows.deepest {
            self.rows.relieve(RELIEF * settings.tolerance);
        }
    }

    /// The natural residual of the nonzero rows.
    fn live_residual<P: Portion<D>>(&self, cpu: &Cpu<D, P>, at: &Point<Vec<f64>>) -> f64 {
        let diagonal = cpu.rows().diagonal;
        rows::fold(self.rows.len(), 0.0, worse, |i| {
            let row = self.rows.row[i] as usize;
            residual(at.g[row], diagonal[row], at.x[row])
        })
    }

    /// Restores the best multipliers, and sets those of open rows to zero if the residual does not grow or stays within
    /// the tolerance.
    fn settle<P: Portion<D>>(&mut self, cpu: &mut Cpu<D, P>, at: &mut Point<Vec<f64>>, tolerance: f64) {
        at.x.clone_from(&self.best);
        cpu.gradient(&at.x, &mut at.g);
        let diagonal = cpu.rows().diagonal;
        let open = at.x.iter().zip(&at.g).zip(diagonal).map(|((x, g), s)| is_open(*g, *s, *x));
        let open: Vec<bool> = open.collect();
        for (x, _) in at.x.iter_mut().zip(open).filter(|(_, open)| *open) {
            *x = 0.0;
        }
        cpu.gradient(&at.x, &mut at.g);
        if self.live_residual(cpu, at) > self.residual.max(tolerance) {
            at.x.clone_from(&self.best);
            cpu.gradient(&at.x, &mut at.g);
        }
    }
}

impl Refused {
    fn status(self) -> Status {
        match self {
            Refused::TooLarge => Status::TooLarge,
            Refused::NotPositive => Status::NoProgress,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lcp::Problem;
    use crate::lcp::auto::tests::chain;

    #[test]
    fn a_factor_over_the_bound_is_refused_and_the_start_kept() {
        let problem = Problem::<3> {
            bodies: 3,
            pair: vec![[0, 1], [1, 2]],
            jacobian: vec![[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]; 2],
            q: vec![-0.1, -0.2],
            ..Problem::default()
        };
        let (mut cpu, mut drive) = (Cpu::<3>::for_parallel_rows(), Drive::default());
        cpu.rebuild(&problem);
        cpu.import(&[0.05, 0.0], &mut drive.at.x);
        let mut solver = InteriorPoint::with_largest_factor(10);
        let settings = Settings { tolerance: 1e-9, max_iterations: 100 };
        let (status, iterations, residual) =
            solver.run(&mut cpu, &mut drive, &settings, settings.tolerance, Manner::Exact);
        assert_eq!((status, iterations, solver.factorizations()), (Status::TooLarge, 0, 0));
        assert_eq!((drive.at.x.as_slice(), residual), ([0.05, 0.0].as_slice(), 0.25));
        solver.largest_factor = LARGEST_FACTOR;
        assert_eq!(solver.run(&mut cpu, &mut drive, &settings, settings.tolerance, Manner::Exact).0, Status::Solved);
    }

    /// The outcome and the factorizations of a solve from this start.
    fn solve(problem: &Problem<3>, start: &[f64], manner: Manner) -> (Status, u64, f64) {
        let (mut cpu, mut drive) = (Cpu::<3>::for_parallel_rows(), Drive::default());
        cpu.rebuild(problem);
        cpu.import(start, &mut drive.at.x);
        let mut solver = InteriorPoint::default();
        let settings = Settings { tolerance: 1e-9, max_iterations: 100 };
        let (status, _, residual) = solver.run(&mut cpu, &mut drive, &settings, settings.tolerance, manner);
        (status, solver.factorizations(), residual)
    }

    #[test]
    fn a_start_near_the_solution_saves_factorizations() {
        let problem = chain(50);
        let (mut cpu, mut drive) = (Cpu::<3>::for_parallel_rows(), Drive::default());
        cpu.rebuild(&problem);
        cpu.import(&[0.0; 50], &mut drive.at.x);
        let settings = Settings { tolerance: 1e-12, max_iterations: 100 };
        InteriorPoint::default().run(&mut cpu, &mut drive, &settings, 0.0, Manner::Exact);
        let mut start = vec![0.0; 50];
        cpu.export(&drive.at.x, &mut start);
        start.iter_mut().enumerate().for_each(|(i, x)| *x += 1e-6 * (i % 3) as f64);
        let (far, near) = (solve(&problem, &start, Manner::Exact), solve(&problem, &start, Manner::Near));
        assert_eq!((far.0, near.0), (Status::Solved, Status::Solved));
        assert!(near.1 < far.1, "{near:?} {far:?}");
    }

    #[test]
    fn a_start_with_multipliers_of_a_tight_wedge_is_as_one_from_the_violations() {
        let problem = chain(50);
        let start = vec![1e4; 50];
        assert_eq!(solve(&problem, &start, Manner::Near), solve(&problem, &start, Manner::Exact));
    }

    #[test]
    fn a_lenient_solve_uses_up_the_tolerance_where_rows_contradict_each_other_by_less() {
        let problem = Problem::<3> {
            bodies: 2,
            pair: vec![[0, 1]; 2],
            jacobian: vec![[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]],
            q: vec![-0.1, 0.1 - 1.5e-9],
            ..Problem::default()
        };
        let (status, _, residual) = solve(&problem, &[0.0; 2], Manner::Lenient);
        assert!(status == Status::Solved && residual <= 1e-9, "{status:?} {residual:e}");
        // With more than twice the tolerance nothing helps.
        let worse = Problem { q: vec![-0.1, 0.1 - 2.5e-9], ..problem };
        assert_ne!(solve(&worse, &[0.0; 2], Manner::Lenient).0, Status::Solved);
    }
}
