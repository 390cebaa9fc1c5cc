//! Against problems that other solvers solve.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Discs of radius 1 that nearly touch in a plane, in a loose square, with offsets at random.
pub fn discs(seed: u64, side: u32, mu: f64) -> Problem<3> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut problem = Problem { bodies: (side * side) as usize, ..Problem::default() };
    let mut add = |a: u32, b: u32, [x, y]: [f64; 2]| {
        // Both move the point between them; a turn moves it along the tangent `(-y, x)`.
        let rows = [[x, y, 0.0], [-y, x, 1.0]];
        let q = [-0.02 * rng.random::<f64>(), 0.04 * (rng.random::<f64>() - 0.5)];
        for (row, q) in rows.into_iter().zip(q) {
            problem.pair.push([a, b]);
            problem.jacobian.push([[-row[0], -row[1], row[2]], row]);
            problem.q.push(q);
        }
        problem.cones.extend([Cone::Friction(mu), Cone::Tangent]);
    };
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let body = y * side + x;
        if x + 1 < side {
            add(body, body + 1, [1.0, 0.0]);
        }
        if y + 1 < side {
            add(body, body + side, [0.6, 0.8]);
        }
        // A second contact of the same pair, off the line of centres.
        if x + 1 < side && (x + y) % 3 == 0 {
            add(body, body + 1, [0.98, 0.199]);
        }
    }
    problem
}

/// The planar cone is polyhedral: the rows `n + mu t` and `n - mu t`, with multipliers at least zero.
#[test]
fn planar_cones_without_correction_are_two_rows() {
    for (seed, mu) in [(1, 0.3), (2, 1.0), (3, 0.05)] {
        let cones = discs(seed, 6, mu);
        let mut rows = Problem::<3> { bodies: cones.bodies, ..Problem::default() };
        for (n, sign) in (0..cones.q.len()).step_by(2).flat_map(|n| [(n, mu), (n, -mu)]) {
            let both = |side: usize| {
                std::array::from_fn(|k| cones.jacobian[n][side][k] + sign * cones.jacobian[n + 1][side][k])
            };
            rows.pair.push(cones.pair[n]);
            rows.jacobian.push([both(0), both(1)]);
            rows.q.push(cones.q[n] + sign * cones.q[n + 1]);
        }
        let expected = velocity(&rows, &solve(SolverKind::PairBlockCg, &rows, 1e-12));
        for kind in KINDS {
            let mut solver = solver(kind, 1e-12);
            solver.relax_friction();
            let mut gamma = Vec::new();
            let outcome = solver.solve(&cones, &mut gamma);
            assert_eq!(outcome.status, Status::Solved, "{outcome:?}");
            let found = farthest(&expected, &velocity(&cones, &gamma));
            assert!(found < 1e-8, "{kind:?} {mu}: {found:e}");
        }
    }
}

/// Without a slip both laws are one; where bodies slide the exact one leaves no gap.
#[test]
fn the_relaxed_law_opens_gaps_and_the_exact_one_does_not() {
    let problem = discs(4, 4, 0.3);
    let exact = solve(SolverKind::Auto, &problem, 1e-11);
    let mut solver = solver(SolverKind::Auto, 1e-11);
    solver.relax_friction();
    let mut relaxed = Vec::new();
    assert_eq!(solver.solve(&problem, &mut relaxed).status, Status::Solved);
    let gap = |gamma: &[f64]| {
        let g = gradient(&problem, gamma);
        let pushes = (0..g.len()).step_by(2).filter(|row| gamma[*row] > 1e-4);
        pushes.map(|row| g[row]).fold(0.0, f64::max)
    };
    assert!(gap(&exact) < 1e-9 && gap(&relaxed) > 1e-3, "{:e} {:e}", gap(&exact), gap(&relaxed));
}

/// Many cones of one pair, and rows alone beside them.
#[test]
fn several_units_of_a_pair_are_solved() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut problem = Problem::<6> { bodies: 4, ..Problem::default() };
    for contact in 0..14_u32 {
        let pair = [[0, 1], [1, 2], [2, 0], [0, 3]][(contact % 4) as usize];
        let rows = if contact % 5 == 4 { 1 } else { 3 };
        for row in 0..rows {
            problem.pair.push(pair);
            let mut block = || std::array::from_fn(|_| rng.random::<f64>() - 0.5);
            problem.jacobian.push([block(), if pair[1] == 3 { [0.0; 6] } else { block() }]);
            problem.q.push(if row == 0 { -0.02 * rng.random::<f64>() } else { 0.05 * (rng.random::<f64>() - 0.5) });
            problem.cones.push(match (rows, row) {
                (1, _) => Cone::Ray,
                (_, 0) => Cone::Friction(0.4),
                _ => Cone::Tangent,
            });
        }
    }
    let mut velocities = Vec::new();
    for kind in KINDS {
        let gamma = solve(kind, &problem, 1e-10);
        let g = gradient(&problem, &gamma);
        for row in (0..g.len()).filter(|row| problem.cones[*row] != Cone::Tangent) {
            assert!(g[row] > -1e-9 && g[row].min(gamma[row]) < 1e-8, "{row}: {} {}", g[row], gamma[row]);
        }
        velocities.push(velocity(&problem, &gamma));
    }
    assert!(velocities.iter().all(|v| farthest(v, &velocities[0]) < 1e-6));
}
