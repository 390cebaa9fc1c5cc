//! The cost of an iteration by clusters, compared with one by pairs. [`SolverKind::ClusterCg`] needs fewer and longer
//! iterations than [`SolverKind::PairBlockCg`]; which of the two is faster depends on the device.

use crate::StudyError;
use crate::solvers::built_in;
use relcp::gpu::{Gpu, Precision};
use relcp::internals::freedom::PLANAR;
use relcp::internals::lcp::gpu::{DeviceProblem, Solver};
use relcp::lcp::{Problem, Settings};
use relcp::scene::SolverKind;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// The stored LCP that is copied.
const LCP: &str = "colony-last";

/// Iterations of two solves. The difference of their times does not contain the fixed cost of a solve.
const ITERATIONS: [u64; 2] = [40, 140];
const QUICK_ITERATIONS: [u64; 2] = [2, 6];

/// Number of timed solves, after one that compiles kernels. The shortest counts.
const REPEATS: usize = 3;
const QUICK_REPEATS: usize = 1;

/// The time of an iteration of each kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClusterRow {
    pub bodies: usize,
    pub constraints: usize,
    pub precision: String,
    /// Microseconds per iteration, including its share of the waits.
    pub pairs_us: f64,
    pub clusters_us: f64,
    /// Milliseconds of a solve outside its iterations, which include the construction of the clusters.
    pub pairs_set_up_ms: f64,
    pub clusters_set_up_ms: f64,
}

/// Times both kinds on copies of a stored LCP with about `bodies` bodies in total, at least one copy.
pub fn measure(gpu: &Gpu, precision: Precision, bodies: usize, quick: bool) -> Result<ClusterRow, StudyError> {
    let stored = built_in()?.into_iter().find(|named| named.name == LCP);
    let one = stored.and_then(|named| named.lcp.problem::<PLANAR>()).unwrap_or_default();
    let problem = copies(&one, (bodies / one.bodies.max(1)).max(1));
    let [pairs_us, pairs_set_up_ms] = time(gpu, precision, SolverKind::PairBlockCg, &problem, quick)?;
    let [clusters_us, clusters_set_up_ms] = time(gpu, precision, SolverKind::ClusterCg, &problem, quick)?;
    Ok(ClusterRow {
        bodies: problem.bodies,
        constraints: problem.q.len(),
        precision: precision.name().into(),
        pairs_us,
        clusters_us,
        pairs_set_up_ms,
        clusters_set_up_ms,
    })
}

/// Copies of a problem that do not touch each other.
fn copies(one: &Problem<PLANAR>, count: usize) -> Problem<PLANAR> {
    let pairs = |copy: usize| one.pair.iter().map(move |pair| pair.map(|body| body + (copy * one.bodies) as u32));
    Problem {
        bodies: count * one.bodies,
        pair: (0..count).flat_map(pairs).collect(),
        jacobian: one.jacobian.repeat(count),
        q: one.q.repeat(count),
        ..Problem::default()
    }
}

/// Microseconds per iteration, and milliseconds of a solve without iterations.
fn time(
    gpu: &Gpu,
    precision: Precision,
    kind: SolverKind,
    problem: &Problem<PLANAR>,
    quick: bool,
) -> Result<[f64; 2], StudyError> {
    let (counts, repeats) = if quick { (QUICK_ITERATIONS, QUICK_REPEATS) } else { (ITERATIONS, REPEATS) };
    // No residual is within this tolerance, so no iteration and no cluster is skipped.
    let settings = |max_iterations| Settings { tolerance: 0.0, max_iterations };
    let mut solver = Solver::new(gpu, precision, true, kind, settings(counts[0]))?;
    solver.set_largest_small(0);
    let mut shortest = [f64::MAX; 2];
    for repeat in 0..=repeats {
        for (shortest, count) in shortest.iter_mut().zip(counts) {
            solver.set_settings(settings(count));
            let (mut device, _) = DeviceProblem::upload(gpu, precision, problem, &[])?;
            gpu.wait()?;
            let begun = Instant::now();
            solver.solve(gpu, &mut device)?;
            gpu.wait()?;
            if repeat > 0 {
                *shortest = shortest.min(begun.elapsed().as_secs_f64());
            }
        }
    }
    let iteration = (shortest[1] - shortest[0]).max(0.0) / (counts[1] - counts[0]) as f64;
    let besides = (shortest[0] - counts[0] as f64 * iteration).max(0.0);
    Ok([1e6 * iteration, 1e3 * besides])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_are_apart() {
        let one = Problem::<PLANAR> {
            bodies: 3,
            pair: vec![[0, 1], [1, 2]],
            jacobian: vec![[[1.0; 3]; 2]; 2],
            q: vec![1.0, 2.0],
            ..Problem::default()
        };
        let two = copies(&one, 2);
        assert_eq!((two.bodies, two.pair), (6, vec![[0, 1], [1, 2], [3, 4], [4, 5]]));
        assert_eq!((two.q, two.jacobian.len()), (vec![1.0, 2.0, 1.0, 2.0], 4));
    }
}
