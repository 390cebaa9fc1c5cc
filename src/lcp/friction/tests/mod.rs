//! Whole solves: right values of one step, the law written out, other solvers, counts of iterations.

mod bonds;
mod closed_forms;
mod counts;
mod interior;
pub mod law;
mod oracles;
mod spheres;

use super::Cone;
use crate::lcp::{Outcome, Problem, Settings, Solver, SolverKind, Status, velocity};

/// Solvers that support friction.
const KINDS: [SolverKind; 3] = [SolverKind::Auto, SolverKind::PairBlockCg, SolverKind::Apgd];

fn solver<const D: usize>(kind: SolverKind, tolerance: f64) -> Solver<D> {
    Solver::new(kind, Settings { tolerance, max_iterations: 20_000 })
}

/// Solves from nothing. Panics if it fails.
fn solve<const D: usize>(kind: SolverKind, problem: &Problem<D>, tolerance: f64) -> Vec<f64> {
    let mut gamma = Vec::new();
    let outcome = solver(kind, tolerance).solve(problem, &mut gamma);
    assert_eq!(outcome.status, Status::Solved, "{kind:?}: {outcome:?}");
    gamma
}

/// `q + (A + k) gamma`.
fn gradient<const D: usize>(problem: &Problem<D>, gamma: &[f64]) -> Vec<f64> {
    let v = velocity(problem, gamma);
    let along = |row: usize| -> f64 {
        let of = |side: usize| {
            let (block, v) = (problem.jacobian[row][side], v[problem.pair[row][side] as usize]);
            (0..D).map(|k| block[k] * v[k]).sum::<f64>()
        };
        of(0) + of(1)
    };
    let k = |row: usize| problem.compliance.get(row).copied().unwrap_or(0.0);
    (0..problem.q.len()).map(|row| problem.q[row] + along(row) + k(row) * gamma[row]).collect()
}

/// The largest difference of two velocities.
fn farthest<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).fold(0.0, |most, (a, b)| f64::max(most, (a - b).abs()))
}
