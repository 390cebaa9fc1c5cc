//! The solve: iterations with the corrections as they are, and corrections that follow the slips.

use super::interior::Interior;
use super::pace::{PACE_OF_PAIRS, Pace, Paced};
use super::rows::Frictional;
use crate::lcp::apgd::Apgd;
use crate::lcp::cone::worse;
use crate::lcp::drive::{Drive, Method, Progress, SolveState};
use crate::lcp::pair_block_cg::PairBlockCg;
use crate::lcp::verbs::Verbs;
use crate::lcp::{Outcome, Problem, Settings, SolverKind, Status};

/// Where so many iterations of `pair_block_cg` did not halve the residual, `auto` goes on with the interior-point
/// method, if the problem is not too large for it, and then with `apgd`.
pub(in crate::lcp) const ITERATIONS_TO_HALVE: u64 = 600;

/// And ends where so many of `apgd` did not: the law is then solved with its corrections held.
const LAST_ITERATIONS_TO_HALVE: u64 = 600;

/// The largest number of rounds with corrections held. Each round lowers the corrections that leave an overlap. The
/// last round has no corrections, and leaves no overlap.
const MOST_ROUNDS: u32 = 8;

/// A method that goes on where the gradient is moved.
trait Follows<const D: usize>: Method<Frictional<D>> {
    const PACE: Paced;
    /// Moves the gradients that it keeps.
    fn shift(&mut self, delta: &[f64]);
}

impl<const D: usize> Follows<D> for PairBlockCg<Vec<f64>, f64> {
    const PACE: Paced = PACE_OF_PAIRS;
    fn shift(&mut self, _: &[f64]) {}
}

impl<const D: usize> Follows<D> for Apgd<Frictional<D>> {
    const PACE: Paced = Paced { between: 3.0, of_change: 0.1 };
    fn shift(&mut self, delta: &[f64]) {
        Apgd::shift(self, delta);
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
    let mut pace = Pace::new(M::PACE, state.is_new(), f64::from);
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
        if !rows.held && pace.turn(rows.measured, progress.least, tolerance) > 0.0 {
            method.shift(rows.follow(&mut drive.at.g));
        }
    }
}
