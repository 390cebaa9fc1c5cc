//! Free rows, which are equations, against dense solves.

use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A chain of `links` bonds between bodies along x that turn a little from link to link, the first body fixed, with
/// offsets and compliances at random, and contacts between next ones.
fn chain(links: usize, compliance: f64, contacts: bool) -> Problem<3> {
    let mut rng = ChaCha8Rng::seed_from_u64(links as u64);
    let mut problem = Problem::<3> { bodies: links + 1, ..Problem::default() };
    for link in 0..links {
        let turn = 0.3 * (rng.random::<f64>() - 0.5);
        let (x, y) = (turn.cos(), turn.sin());
        let lever = 0.5 * (rng.random::<f64>() - 0.5);
        let first = if link == 0 { [0.0; 3] } else { [-x, -y, lever] };
        let mut push = |cone: Cone, q: f64, k: f64| {
            problem.pair.push([link as u32, link as u32 + 1]);
            problem.jacobian.push([first, [x, y, lever]]);
            problem.q.push(q);
            problem.cones.push(cone);
            problem.compliance.push(k);
        };
        push(Cone::Free, rng.random::<f64>() - 0.5, compliance * (0.5 + rng.random::<f64>()));
        if contacts {
            push(Cone::Ray, 0.2 * (rng.random::<f64>() - 0.7), 0.0);
        }
    }
    problem
}

/// `(A + k) gamma = -q` by elimination with pivots.
fn dense(problem: &Problem<3>) -> Vec<f64> {
    let n = problem.q.len();
    let columns: Vec<Vec<f64>> = (0..n)
        .map(|column| {
            let mut unit = vec![0.0; n];
            unit[column] = 1.0;
            let moved = gradient(problem, &unit);
            moved.iter().zip(&problem.q).map(|(g, q)| g - q).collect()
        })
        .collect();
    let mut m: Vec<Vec<f64>> = (0..n).map(|i| columns.iter().map(|c| c[i]).chain([-problem.q[i]]).collect()).collect();
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| m[*a][k].abs().total_cmp(&m[*b][k].abs())).unwrap();
        m.swap(k, pivot);
        for i in (0..n).filter(|i| *i != k) {
            let part = m[i][k] / m[k][k];
            let row = m[k].clone();
            m[i].iter_mut().zip(&row).for_each(|(x, y)| *x -= part * y);
        }
    }
    (0..n).map(|i| m[i][n] / m[i][i]).collect()
}

#[test]
fn bonds_alone_are_a_linear_system() {
    for (links, compliance) in [(1, 0.0), (12, 0.0), (50, 0.0), (50, 1e-3), (50, 1.0), (50, 1e3)] {
        let problem = chain(links, compliance, false);
        let exact = dense(&problem);
        for kind in KINDS {
            let gamma = solve(kind, &problem, 1e-11);
            let most = exact.iter().fold(0.0, |most: f64, g| most.max(g.abs()));
            let off = exact.iter().zip(&gamma).fold(0.0, |off: f64, (a, b)| off.max((a - b).abs()));
            assert!(off <= 1e-6 * most, "{kind:?} {links} {compliance}: {off:e} of {most:e}");
            assert!(exact.iter().any(|g| *g < 0.0), "some pull");
        }
    }
}

/// A beam: links of length 1 with a joint and a turn between next ones, the first body fixed. `twice` says each row
/// again, as rows of a loop do.
fn beam(links: usize, compliance: f64, twice: bool) -> Problem<3> {
    let mut problem = Problem::<3> { bodies: links + 1, ..Problem::default() };
    for link in 0..links {
        let (free, phase) = (if link == 0 { 0.0 } else { 1.0 }, 1.7 * link as f64);
        let rows = [
            [[-free, 0.0, 0.0], [1.0, 0.0, 0.0]],
            [[0.0, -free, -0.5 * free], [0.0, 1.0, -0.5]],
            [[0.0, 0.0, -free], [0.0, 0.0, 1.0]],
        ];
        for (i, row) in rows.into_iter().enumerate() {
            for _ in 0..if twice { 2 } else { 1 } {
                problem.pair.push([link as u32, link as u32 + 1]);
                problem.jacobian.push(row);
                problem.q.push(1e-3 * (phase + i as f64).sin());
                problem.cones.push(Cone::Linked);
                problem.compliance.push(compliance);
            }
        }
    }
    problem
}

/// Iterations over pairs would take thousands for a beam, and not converge for a long one.
#[test]
fn linked_rows_are_eliminated_together() {
    for (links, compliance, twice) in [(50, 0.0, false), (300, 0.0, false), (300, 1e-4, false), (50, 0.0, true)] {
        let problem = beam(links, compliance, twice);
        for kind in [SolverKind::Auto, SolverKind::PairBlockCg] {
            let mut gamma = Vec::new();
            let outcome = solver(kind, 1e-9).solve(&problem, &mut gamma);
            println!("{links} links, {compliance}, twice {twice}: {outcome:?}");
            assert!(outcome.status == Status::Solved && outcome.iterations <= 10, "{kind:?} {links}: {outcome:?}");
            assert!(gradient(&problem, &gamma).iter().all(|g| g.abs() <= 1e-8), "{kind:?} {links}");
        }
    }
}

#[test]
fn linked_rows_are_as_free_ones_beside_contacts() {
    let free = chain(20, 1e-2, true);
    let mut linked = free.clone();
    linked.cones.iter_mut().filter(|cone| cone.is_free()).for_each(|cone| *cone = Cone::Linked);
    for kind in KINDS {
        let [a, b] = [&free, &linked].map(|problem| velocity(problem, &solve(kind, problem, 1e-10)));
        assert!(farthest(&a, &b) < 1e-7, "{kind:?}: {:e}", farthest(&a, &b));
    }
}

#[test]
fn bonds_and_contacts_are_solved_together() {
    for compliance in [0.0, 1e-2] {
        // A contact beside a rigid bond of the same two bodies contradicts it where it asks for more room.
        let mut problem = chain(20, compliance, true);
        if compliance == 0.0 {
            (0..40).step_by(2).for_each(|row| problem.q[row + 1] = problem.q[row] + 0.1);
        }
        for kind in KINDS {
            let gamma = solve(kind, &problem, 1e-10);
            let g = gradient(&problem, &gamma);
            for row in 0..g.len() {
                match problem.cones[row] {
                    Cone::Free => assert!(g[row].abs() <= 1e-9, "{row}: {:e}", g[row]),
                    _ => assert!(gamma[row] >= 0.0 && g[row] >= -1e-9 && g[row].min(gamma[row]) < 1e-8, "{row}"),
                }
            }
        }
    }
}

#[test]
fn a_start_may_pull_and_a_solution_needs_no_iterations() {
    let problem = chain(20, 1e-2, false);
    let mut gamma = dense(&problem);
    let outcome = solver(SolverKind::Auto, 1e-9).solve(&problem, &mut gamma);
    assert!(outcome.status == Status::Solved && outcome.iterations <= 1, "{outcome:?}");
}

#[test]
fn the_residual_counts_bonds() {
    let problem = chain(3, 0.0, false);
    let mut gamma = Vec::new();
    let settings = Settings { tolerance: 1e-9, max_iterations: 0 };
    let outcome = Solver::new(SolverKind::Auto, settings).solve(&problem, &mut gamma);
    let most = problem.q.iter().fold(0.0, |most: f64, q| most.max(q.abs()));
    assert_eq!((outcome.status, outcome.residual), (Status::MaxIterations, most));
}

/// A contact that asks for more room than a rigid bond of the same bodies leaves: both are violated, neither thrown.
#[test]
fn contacts_that_contradict_bonds_are_relaxed() {
    let mut problem = chain(4, 0.0, true);
    for row in (0..8).step_by(2) {
        (problem.q[row], problem.q[row + 1]) = (0.0, if row == 2 { -2e-3 } else { 0.1 });
    }
    let mut gamma = Vec::new();
    let outcome = solver(SolverKind::Auto, 1e-8).relax(&problem, &mut gamma, 1e-5);
    assert_eq!(outcome.status, Status::Infeasible);
    assert!((outcome.residual - 1e-3).abs() < 1e-4, "{outcome:?}");
    let moved = velocity(&problem, &gamma);
    assert!(moved.as_flattened().iter().all(|v| v.abs() < 0.1), "{moved:?}");
    problem.q[3] = 0.1;
    let outcome = solver(SolverKind::Auto, 1e-8).relax(&problem, &mut gamma, 1e-5);
    assert!(matches!(outcome.status, Status::LeastOverlap | Status::HeldFriction), "{outcome:?}");
}
