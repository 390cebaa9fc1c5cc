//! The interior-point method alone, from nothing.

use super::law::{check_law, cloud};
use super::oracles::discs;
use super::*;
use crate::lcp::friction::interior::Interior;
use crate::lcp::friction::rows::Frictional;

/// Solves from nothing; the multipliers and the residual.
fn alone<const D: usize>(problem: &Problem<D>, tolerance: f64) -> (Vec<f64>, f64) {
    let mut rows = Frictional::default();
    problem.check();
    rows.rebuild(problem);
    let mut x = vec![0.0; problem.q.len()];
    let settings = Settings { tolerance, max_iterations: 1_000 };
    let residual = Interior::default().run(&mut rows, &mut x, &settings, f64::INFINITY);
    let mut gamma = vec![0.0; problem.q.len()];
    rows.export(&x, &mut gamma);
    (gamma, residual)
}

#[test]
fn it_obeys_the_exact_law_in_space() {
    for (seed, most, compliance) in [(1, 0.5, 0.0), (2, 1.0, 1e-3), (3, 2.0, 1e-4), (4, 0.01, 0.0)] {
        let problem = cloud(seed, 40, |rng| rand::RngExt::random_range(rng, 0.5 * most..most), compliance);
        let (gamma, residual) = alone(&problem, 1e-9);
        assert!(residual <= 1e-9, "{seed}: {residual:e}");
        check_law(&problem, &gamma, 1e-9);
    }
}

#[test]
fn it_agrees_with_iterations_over_cones_in_the_plane() {
    for (seed, mu) in [(1, 0.3), (2, 0.6), (3, 0.05)] {
        let problem = discs(seed, 6, mu);
        let (gamma, residual) = alone(&problem, 1e-10);
        assert!(residual <= 1e-10, "{seed}: {residual:e}");
        check_law(&problem, &gamma, 1e-10);
        let other = solve(SolverKind::PairBlockCg, &problem, 1e-10);
        let apart = farthest(&velocity(&problem, &gamma), &velocity(&problem, &other));
        assert!(apart < 1e-7, "{seed}: {apart:e}");
    }
}

#[test]
fn rays_and_free_rows_are_solved_beside_cones() {
    let mut problem = discs(4, 5, 0.5);
    // A row alone, and a bond, between bodies that are neighbours.
    for (pair, row, cone, q) in
        [([0, 6], [0.6, 0.8, 0.0], Cone::Ray, -0.03), ([7, 13], [0.8, 0.6, 0.0], Cone::Free, 0.02)]
    {
        problem.pair.push(pair);
        problem.jacobian.push([row.map(|j: f64| -j), row]);
        problem.q.push(q);
        problem.cones.push(cone);
    }
    let (gamma, residual) = alone(&problem, 1e-10);
    assert!(residual <= 1e-10, "{residual:e}");
    check_law(&problem, &gamma, 1e-10);
    let (g, n) = (gradient(&problem, &gamma), problem.q.len());
    assert!(
        g[n - 1].abs() < 1e-10 && g[n - 2].min(gamma[n - 2]).abs() < 1e-10,
        "{:?} {:?}",
        &g[n - 2..],
        &gamma[n - 2..]
    );
    assert!(gamma[n - 1] != 0.0);
}

#[test]
fn it_does_not_better_what_has_no_solution_and_keeps_the_start() {
    // Two walls push one body towards each other by more than there is room.
    let row = [[0.0; 3], [1.0, 0.0, 0.0]];
    let problem = Problem::<3> {
        bodies: 2,
        pair: vec![[1, 0]; 2],
        jacobian: vec![row, row.map(|block| block.map(|j| -j))],
        q: vec![-0.1, -0.1],
        cones: vec![Cone::Ray; 2],
        compliance: vec![0.0; 2],
    };
    let (gamma, residual) = alone(&problem, 1e-9);
    assert!(residual > 0.05 && gamma.iter().all(|gamma| gamma.is_finite()), "{residual:e} {gamma:?}");
}

/// Cells between two walls that stand across them: the law has a solution, but corrections that are substituted do not
/// find it.
#[test]
fn a_wedge_of_cells_is_solved_that_iterations_leave() {
    let text = include_str!("../../../../tests/data/friction/wedge.json");
    let stored: serde_json::Value = serde_json::from_str(text).unwrap();
    let numbers = |key: &str| -> Vec<f64> { serde_json::from_value(stored[key].clone()).unwrap() };
    let cone = |mu: f64| match mu {
        mu if mu < 0.0 => Cone::Tangent,
        0.0 => Cone::Ray,
        mu => Cone::Friction(mu),
    };
    let problem = Problem::<3> {
        bodies: stored["bodies"].as_u64().unwrap() as usize,
        pair: serde_json::from_value(stored["pair"].clone()).unwrap(),
        jacobian: serde_json::from_value(stored["jacobian"].clone()).unwrap(),
        q: numbers("q"),
        cones: numbers("mu").into_iter().map(cone).collect(),
        compliance: numbers("compliance"),
    };
    let settings = Settings { tolerance: 1e-6, max_iterations: 5_000 };
    let left = Solver::new(SolverKind::Apgd, settings).solve(&problem, &mut Vec::new());
    assert!(left.residual > 1e-5, "{left:?}");
    let mut gamma = Vec::new();
    let outcome = Solver::new(SolverKind::Auto, settings).solve(&problem, &mut gamma);
    assert!(outcome.status == Status::Solved && outcome.fallback, "{outcome:?}");
    check_law(&problem, &gamma, 1e-6);
}
