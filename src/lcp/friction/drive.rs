//! The solve: iterations with the corrections as they are, and corrections that follow the slips.

use super::interior::Interior;
use super::rows::{Frictional, Measured};
use crate::lcp::apgd::Apgd;
use crate::lcp::cone::worse;
use crate::lcp::drive::{Drive, Method, Progress, SolveState};
use crate::lcp::pair_block_cg::PairBlockCg;
use crate::lcp::verbs::Verbs;
use crate::lcp::{Outcome, Problem, Settings, SolverKind, Status};

/// The corrections follow where the residual with the present ones is at most this part of the tolerance, even before
/// it is their turn.
const OF_TOLERANCE: f64 = 0.3;

/// So many follows that do not halve the least residual double the iterations between them, up to the most, and halve
/// the part of what corrections are off, down to the least.
const FOLLOWS: u32 = 20;
const MOST_BETWEEN: u64 = 100;
const LEAST_OF_CHANGE: f64 = 0.1;

/// Where so many iterations of `pair_block_cg` did not halve the residual, `auto` goes on with the interior-point
/// method, if the problem is not too large for it, and then with `apgd`.
const ITERATIONS_TO_HALVE: u64 = 600;

/// And ends where so many of `apgd` did not: the law is then solved with its corrections held.
const LAST_ITERATIONS_TO_HALVE: u64 = 600;

/// The largest number of rounds with corrections held. Each round lowers the corrections that leave an overlap. The
/// last round has no corrections, and leaves no overlap.
const MOST_ROUNDS: u32 = 8;

/// A method that goes on where the gradient is moved.
trait Follows<const D: usize>: Method<Frictional<D>> {
    /// Iterations between two follows, at first.
    const BETWEEN: u64;
    /// And they follow where the residual with the present corrections is at most this part of what the farthest of
    /// them is off.
    const OF_CHANGE: f64;
    /// Moves the gradients that it keeps.
    fn shift(&mut self, delta: &[f64]);
}

impl<const D: usize> Follows<D> for PairBlockCg<Vec<f64>, f64> {
    const BETWEEN: u64 = 20;
    const OF_CHANGE: f64 = 1.0;
    fn shift(&mut self, _: &[f64]) {}
}

impl<const D: usize> Follows<D> for Apgd<Frictional<D>> {
    const BETWEEN: u64 = 3;
    const OF_CHANGE: f64 = 0.1;
    fn shift(&mut self, delta: &[f64]) {
        Apgd::shift(self, delta);
    }
}

/// When the corrections follow.
struct Pace {
    between: u64,
    of_change: f64,
    last: u64,
    /// Follows since the least residual was halved, and what it was then.
    follows: u32,
    least: f64,
}

impl Pace {
    fn of<const D: usize, M: Follows<D>>(last: u64) -> Self {
        Pace { between: M::BETWEEN, of_change: M::OF_CHANGE, last, follows: 0, least: f64::INFINITY }
    }

    fn is_due(&self, iterations: u64, measured: Measured, tolerance: f64) -> bool {
        let solved = measured.cones <= (OF_TOLERANCE * tolerance).max(self.of_change * measured.change);
        iterations == 0 || solved || iterations - self.last >= self.between
    }

    fn followed(&mut self, progress: Progress) {
        self.last = progress.iterations;
        self.follows += 1;
        if progress.least <= 0.5 * self.least {
            (self.follows, self.least) = (0, progress.least);
        } else if self.follows >= FOLLOWS {
            (self.follows, self.between) = (0, (2 * self.between).min(MOST_BETWEEN));
            self.of_change = (0.5 * self.of_change).max(LEAST_OF_CHANGE);
        }
    }
}

/// The solver of problems with cones, with its state between solves.
pub(crate) struct Friction<const D: usize> {
    kind: SolverKind,
    rows: Frictional<D>,
    cg: PairBlockCg<Vec<f64>, f64>,
    apgd: Apgd<Frictional<D>>,
    interior: Interior<D>,
    /// Whether `apgd` has the present problem.
    accelerated: bool,
}

impl<const D: usize> Friction<D> {
    pub fn new(kind: SolverKind) -> Self {
        let (rows, cg, apgd) = (Frictional::default(), PairBlockCg::new(), Apgd::new());
        Friction { kind, rows, cg, apgd, interior: Interior::default(), accelerated: false }
    }

    /// Leaves the corrections out.
    #[cfg(test)]
    pub fn relax(&mut self) {
        self.rows.relaxed = true;
    }

    /// Solves a problem from these multipliers, which become the best ones found.
    pub fn solve(
        &mut self,
        problem: &Problem<D>,
        gamma: &mut [f64],
        drive: &mut Drive<Vec<f64>>,
        settings: &Settings,
    ) -> Outcome {
        assert!(self.kind.supports_friction(), "{:?} does not solve problems with cones", self.kind);
        problem.check();
        self.load(problem, gamma, drive);
        self.run(gamma, drive, settings)
    }

    /// Takes a problem and its start.
    fn load(&mut self, problem: &Problem<D>, gamma: &[f64], drive: &mut Drive<Vec<f64>>) {
        self.rows.rebuild(problem);
        self.rows.import(gamma, &mut drive.at.x);
        self.rows.eliminate(&mut drive.at.x);
        self.cg.keep_displacements(false);
        self.accelerated = self.kind == SolverKind::Apgd;
    }

    /// Solves a problem with the corrections that belong to the multipliers `gamma`, which are near a solution of the
    /// exact law. It is convex, and has a solution wherever the normal rows have one: the law but for gaps of what
    /// slides, which are off by what the corrections are. Some rounds lower the corrections that leave an overlap. The
    /// residual is that of the convex problem, or the overlap that is left.
    pub fn solve_held(
        &mut self,
        problem: &Problem<D>,
        gamma: &mut [f64],
        drive: &mut Drive<Vec<f64>>,
        settings: &Settings,
    ) -> Outcome {
        self.load(problem, gamma, drive);
        self.rows.hold(&drive.at.x);
        let (mut iterations, mut products) = (0, 0);
        let mut round = 0;
        loop {
            round += 1;
            self.cg.keep_displacements(false);
            self.rows.restart_count();
            let mut outcome = self.run(gamma, drive, settings);
            iterations += outcome.iterations;
            products += outcome.products;
            (outcome.iterations, outcome.products) = (iterations, products);
            let overlap = self.rows.lower(&drive.at.x, round + 1 == MOST_ROUNDS);
            if outcome.residual > settings.tolerance || overlap <= settings.tolerance || round == MOST_ROUNDS {
                outcome.residual = worse(outcome.residual, overlap);
                return outcome;
            }
        }
    }

    /// Continues with the last problem from the last iterate.
    pub fn resume(&mut self, gamma: &mut [f64], drive: &mut Drive<Vec<f64>>, settings: &Settings) -> Outcome {
        self.rows.restart_count();
        self.cg.keep_displacements(true);
        self.run(gamma, drive, settings)
    }

    fn run(&mut self, gamma: &mut [f64], drive: &mut Drive<Vec<f64>>, settings: &Settings) -> Outcome {
        self.interior.factorizations = 0;
        let (status, iterations, residual) = match self.rows.is_finite() {
            true => self.iterate(drive, settings),
            false => (Status::NotFinite, 0, f64::INFINITY),
        };
        self.rows.export(&drive.at.x, gamma);
        let products = self.rows.products();
        let factorizations = self.interior.factorizations;
        Outcome { status, iterations, products, factorizations, fallback: factorizations > 0, residual }
    }

    fn iterate(&mut self, drive: &mut Drive<Vec<f64>>, settings: &Settings) -> (Status, u64, f64) {
        let Friction { rows, cg, apgd, interior, .. } = self;
        let mut state;
        if self.accelerated {
            state = drive.begin(rows, apgd, settings);
        } else {
            state = drive.begin(rows, cg, settings);
            let patience = if self.kind == SolverKind::Auto { ITERATIONS_TO_HALVE } else { u64::MAX };
            let ended = go(rows, drive, cg, &mut state, settings.tolerance, patience);
            let may = self.kind == SolverKind::Auto && interior.suits(rows);
            if may && ended != Some(Status::Solved) {
                let Progress { iterations, least, .. } = state.progress();
                let residual = interior.run(rows, &mut drive.at.x, settings, least);
                if residual <= settings.tolerance {
                    return (Status::Solved, iterations + interior.factorizations, residual);
                }
            }
            if let Some(status) = ended {
                return drive.end(rows, &state, status);
            }
            self.accelerated = true;
            rows.gradient(&drive.at.x, &mut drive.at.g);
            apgd.begin(rows, &drive.at);
        }
        let patience = if self.kind == SolverKind::Auto { LAST_ITERATIONS_TO_HALVE } else { u64::MAX };
        let ended = go(rows, drive, apgd, &mut state, settings.tolerance, patience);
        drive.end(rows, &state, ended.unwrap_or(Status::NoProgress))
    }
}

/// Iterates until the solve ends, or so many iterations did not halve the residual.
fn go<const D: usize, M: Follows<D>>(
    rows: &mut Frictional<D>,
    drive: &mut Drive<Vec<f64>>,
    method: &mut M,
    state: &mut SolveState<f64>,
    tolerance: f64,
    patience: u64,
) -> Option<Status> {
    let begun = if state.is_new() { 0 } else { state.progress().iterations };
    let mut pace = Pace::of::<D, M>(begun);
    let mut halved = (begun, f64::INFINITY);
    loop {
        if let Some(status) = drive.go(rows, method, state, 1, &|_| true) {
            return Some(status);
        }
        let progress = state.progress();
        if progress.least <= 0.5 * halved.1 {
            halved = (progress.iterations, progress.least);
        } else if progress.iterations - halved.0 >= patience {
            return None;
        }
        if !rows.held && pace.is_due(progress.iterations, rows.measured, tolerance) {
            method.shift(rows.follow(&mut drive.at.g));
            pace.followed(progress);
        }
    }
}
