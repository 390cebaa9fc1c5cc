//! The LCP solvers: against each other, against the exact one, against stored systems of growing colonies.

#![allow(clippy::unwrap_used)]

mod interior_point;
#[path = "../common/systems.rs"]
mod systems;

use crate::systems::{line, residual, stored};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::lcp::{Outcome, Problem, Settings, Solver, Status, velocity};
use relcp::scene::SolverKind;

const ITERATIVE: [SolverKind; 6] = [
    SolverKind::ProjectedJacobi,
    SolverKind::ProjectedGaussSeidel,
    SolverKind::Apgd,
    SolverKind::Bbpgd,
    SolverKind::PairBlockCg,
    SolverKind::ClusterCg,
];

fn solve(kind: SolverKind, problem: &Problem<3>, gamma: &mut Vec<f64>, tolerance: f64) -> Outcome {
    Solver::new(kind, Settings { tolerance, max_iterations: 200_000 }).solve(problem, gamma)
}

/// `|v - reference| / |reference|`.
fn error(problem: &Problem<3>, gamma: &[f64], reference: &[[f64; 3]]) -> f64 {
    let v = velocity(problem, gamma);
    let square = |f: &dyn Fn(usize) -> f64| (0..3 * v.len()).map(|i| f(i).powi(2)).sum::<f64>().sqrt();
    let (v, reference) = (v.as_flattened(), reference.as_flattened());
    square(&|i| v[i] - reference[i]) / square(&|i| reference[i])
}

/// A solvable problem with a bit of everything: `q` is such that a random velocity keeps every row open or closed. Some
/// rows repeat another of the same pair: as it is, scaled, the pair named the other way, nearly parallel, or opposite.
/// Some are zero. Nearly parallel rows differ by `apart`.
fn random<const D: usize>(seed: u64, bodies: u32, rows: usize, apart: f64) -> Problem<D> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let uniform = |rng: &mut ChaCha8Rng| rng.random::<f64>() - 0.5;
    let motion: Vec<[f64; D]> = (0..bodies).map(|_| std::array::from_fn(|_| uniform(&mut rng))).collect();
    let mut problem = Problem { bodies: bodies as usize, ..Problem::default() };
    for row in 0..rows {
        let kind = rng.random_range(0..10);
        let (mut pair, mut blocks) = if row == 0 || kind < 5 {
            let a = rng.random_range(0..bodies - 1);
            let scale = 0.2 + rng.random::<f64>();
            let block = |rng: &mut ChaCha8Rng| std::array::from_fn(|_| scale * uniform(rng));
            ([a, rng.random_range(a + 1..bodies)], [block(&mut rng), block(&mut rng)])
        } else {
            let old = rng.random_range(0..row);
            (problem.pair[old], problem.jacobian[old])
        };
        let each = |blocks: &mut [[f64; D]; 2], f: &mut dyn FnMut(f64) -> f64| {
            blocks.as_flattened_mut().iter_mut().for_each(|x| *x = f(*x));
        };
        match kind {
            6 => each(&mut blocks, &mut |x| 0.01 * x),
            7 => each(&mut blocks, &mut |x| x + apart * uniform(&mut rng)),
            8 => each(&mut blocks, &mut |x| -x),
            9 if row % 3 == 0 => each(&mut blocks, &mut |_| 0.0),
            9 => {
                pair.reverse();
                blocks.reverse();
            }
            _ => {}
        }
        let mut moved = 0.0;
        for (body, block) in pair.iter().zip(&blocks) {
            moved += (0..D).map(|k| block[k] * motion[*body as usize][k]).sum::<f64>();
        }
        let open = if rng.random::<bool>() { 0.3 * rng.random::<f64>() } else { 0.0 };
        problem.pair.push(pair);
        problem.jacobian.push(blocks);
        problem.q.push(open - moved);
    }
    problem
}

/// Solves a random problem exactly, and by other solvers from nothing and from a poor start: same velocity, honest
/// residual.
fn agree<const D: usize>(kinds: &[SolverKind], seed: u64, bodies: u32, rows: usize, apart: f64) {
    // Nearly parallel rows have large multipliers, whose rounding the residual shows.
    let tolerance = if apart < 0.1 { 1e-9 } else { 1e-10 };
    let problem = random::<D>(seed, bodies, rows, apart);
    let mut exact = Vec::new();
    let settings = Settings { tolerance: 1e-12, max_iterations: 10_000 };
    let outcome = Solver::new(SolverKind::Dense, settings).solve(&problem, &mut exact);
    assert_eq!(outcome.status, Status::Solved, "{seed}: {outcome:?}");
    let reference = velocity(&problem, &exact);
    let size = reference.as_flattened().iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    for kind in kinds {
        let settings = Settings { tolerance, max_iterations: 400_000 };
        let mut solver = Solver::new(*kind, settings);
        let poor: Vec<f64> =
            exact.iter().enumerate().map(|(row, x)| if row % 3 == 0 { 0.7 * x } else { 0.01 }).collect();
        for start in [Vec::new(), poor, exact.clone()] {
            let solved_at_start = start == exact;
            let mut gamma = start;
            let outcome = solver.solve(&problem, &mut gamma);
            let v = velocity(&problem, &gamma);
            let pairs = v.as_flattened().iter().zip(reference.as_flattened());
            let error = pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs())) / size;
            let what = format!("seed {seed}, D {D}, {kind:?}: {outcome:?}, error {error:.1e}");
            assert_eq!(outcome.status, Status::Solved, "{what}");
            assert!(error < 1e-7, "{what}");
            assert!(gamma.iter().all(|x| *x >= 0.0), "{what}");
            assert!((residual(&problem, &gamma) - outcome.residual).abs() < 1e-10, "{what}");
            // A start is looked at after one iteration; four sweeps of Gauss-Seidel are made before a look.
            assert!(!solved_at_start || outcome.iterations <= 4, "{what}");
        }
    }
}

#[test]
fn all_solvers_agree_on_moderate_problems() {
    for seed in 0..4 {
        agree::<3>(&ITERATIVE, seed, 20, 30, 0.3);
        agree::<6>(&ITERATIVE, seed, 12, 40, 0.3);
        agree::<3>(&ITERATIVE, seed, 100, 120, 0.3);
        agree::<6>(&ITERATIVE, seed, 60, 200, 0.3);
    }
}

#[test]
fn pair_blocks_solve_nearly_parallel_rows() {
    for seed in 0..6 {
        agree::<3>(&[SolverKind::PairBlockCg], seed, 12, 30, 1e-3);
        agree::<3>(&[SolverKind::PairBlockCg], seed, 60, 200, 1e-3);
        agree::<6>(&[SolverKind::PairBlockCg], seed, 30, 200, 1e-3);
    }
}

/// The colony's systems with the products that the default solver may take to 1e-5 from the stored start, and from
/// nothing.
const STORED: [(&str, u64, u64); 5] = [
    ("colony1024_rec0", 85, 85),
    ("colony1024_rec1", 330, 400),
    ("colony1024_rec5", 70, 900),
    ("colony1024_seeded", 540, 580),
    ("colony4096_rec1", 900, 1_000),
];

#[test]
fn stored_systems_are_solved_within_their_products() {
    for (name, warm, cold) in STORED {
        let stored = stored(name);
        for (start, products) in [(stored.start, warm), (Vec::new(), cold)] {
            let mut gamma = start;
            let outcome = solve(SolverKind::Auto, &stored.problem, &mut gamma, 1e-5);
            assert_eq!(outcome.status, Status::Solved, "{name}: {outcome:?}");
            assert!(outcome.products <= products, "{name}: {outcome:?}");
            assert!((residual(&stored.problem, &gamma) - outcome.residual).abs() < 1e-11, "{name}: {outcome:?}");
        }
    }
}

#[test]
fn stored_systems_have_the_stored_velocity() {
    for (name, _, _) in STORED {
        let stored = stored(name);
        let mut gamma = stored.start.clone();
        let outcome = solve(SolverKind::Auto, &stored.problem, &mut gamma, 1e-9);
        assert_eq!(outcome.status, Status::Solved, "{name}: {outcome:?}");
        let error = error(&stored.problem, &gamma, &stored.velocity);
        assert!(error < 1e-6, "{name}: {outcome:?}, error {error:.1e}");
    }
}

/// Rows by branches of 1,024 crowded cells just after a division: clusters take 39 iterations to 1e-6, pairs 156.
#[test]
fn clusters_take_few_iterations_whatever_the_threads() {
    let stored = stored("colony1024_branches");
    let solve_by = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut gamma = stored.start.clone();
        let outcome = pool.install(|| solve(SolverKind::ClusterCg, &stored.problem, &mut gamma, 1e-6));
        (outcome, gamma)
    };
    let alone = solve_by(1);
    assert_eq!(alone.0.status, Status::Solved, "{:?}", alone.0);
    assert!(alone.0.iterations <= 60, "{:?}", alone.0);
    assert!((residual(&stored.problem, &alone.1) - alone.0.residual).abs() < 1e-11);
    assert!(solve_by(3) == alone);
    let mut gamma = stored.start.clone();
    let by_pairs = solve(SolverKind::PairBlockCg, &stored.problem, &mut gamma, 1e-6);
    assert!(by_pairs.iterations > 2 * alone.0.iterations, "{by_pairs:?}");
    let error = error(&stored.problem, &alone.1, &velocity(&stored.problem, &gamma));
    assert!(error < 1e-2, "{error:.1e}");
}

#[test]
fn other_solvers_reach_the_first_stored_system() {
    let stored = stored("colony1024_rec0");
    for kind in ITERATIVE {
        let mut gamma = stored.start.clone();
        let outcome = solve(kind, &stored.problem, &mut gamma, 1e-8);
        assert_eq!(outcome.status, Status::Solved, "{kind:?}: {outcome:?}");
        assert!(error(&stored.problem, &gamma, &stored.velocity) < 1e-6, "{kind:?}: {outcome:?}");
    }
}

const ALL: [SolverKind; 9] = [
    SolverKind::Auto,
    SolverKind::ProjectedJacobi,
    SolverKind::ProjectedGaussSeidel,
    SolverKind::Apgd,
    SolverKind::Bbpgd,
    SolverKind::PairBlockCg,
    SolverKind::ClusterCg,
    SolverKind::Dense,
    SolverKind::InteriorPoint,
];

/// How a solver ends where the rows contradict each other: the interior-point method proves it, the others see no
/// progress.
fn contradicted(kind: SolverKind) -> Status {
    if matches!(kind, SolverKind::Auto | SolverKind::InteriorPoint) { Status::Infeasible } else { Status::NoProgress }
}

#[test]
fn no_rows_are_solved_at_once() {
    for kind in ALL {
        let mut gamma = vec![1.0, 2.0];
        let outcome = solve(kind, &Problem { bodies: 3, ..Problem::default() }, &mut gamma, 1e-12);
        assert_eq!((outcome.status, outcome.iterations, outcome.residual), (Status::Solved, 0, 0.0), "{kind:?}");
        assert!(gamma.is_empty());
    }
}

#[test]
fn opposite_rows_without_room_are_not_solved() {
    for kind in ALL {
        let problem = line(&[(1.0, -0.1), (-1.0, -0.1)]);
        let mut gamma = Vec::new();
        let outcome = solve(kind, &problem, &mut gamma, 1e-8);
        assert_eq!(outcome.status, contradicted(kind), "{kind:?}: {outcome:?}");
        assert!(outcome.iterations <= 50_000, "{kind:?}: {outcome:?}");
        assert!(gamma.iter().all(|x| x.is_finite()), "{kind:?}");
        assert!(outcome.residual > 0.05 && outcome.residual <= 0.1, "{kind:?}: {outcome:?}");
        assert_eq!(residual(&problem, &gamma), outcome.residual, "{kind:?}");
    }
}

#[test]
fn zero_rows_are_judged_by_their_gap() {
    for kind in ALL {
        let mut gamma = vec![0.0, 3.0];
        let outcome = solve(kind, &line(&[(1.0, -0.1), (0.0, 0.0)]), &mut gamma, 1e-12);
        assert_eq!(outcome.status, Status::Solved, "{kind:?}: {outcome:?}");
        assert!((gamma[0] - 0.05).abs() < 1e-11, "{kind:?}: {gamma:?}");
        let outcome = solve(kind, &line(&[(1.0, -0.1), (0.0, -0.25)]), &mut gamma, 1e-12);
        assert_eq!(outcome.status, contradicted(kind), "{kind:?}: {outcome:?}");
        assert_eq!(outcome.residual, 0.25, "{kind:?}");
    }
}

#[test]
fn few_iterations_say_so_and_never_make_it_worse() {
    let stored = stored("colony1024_rec1");
    for kind in ITERATIVE {
        let mut last = f64::INFINITY;
        for max_iterations in [0, 1, 2, 3, 5, 8, 13, 40] {
            let mut gamma = stored.start.clone();
            let settings = Settings { tolerance: 1e-9, max_iterations };
            let outcome = Solver::new(kind, settings).solve(&stored.problem, &mut gamma);
            assert_eq!(outcome.status, Status::MaxIterations, "{kind:?}");
            assert_eq!(outcome.iterations, max_iterations, "{kind:?}");
            assert!((residual(&stored.problem, &gamma) - outcome.residual).abs() < 1e-11, "{kind:?}: {outcome:?}");
            // Gauss-Seidel looks at every fourth iterate and at the last one, which a shorter run alone may see.
            assert!(
                outcome.residual <= last * (1.0 + 1e-9) || kind == SolverKind::ProjectedGaussSeidel,
                "{kind:?}: {outcome:?}"
            );
            assert!(outcome.residual <= residual(&stored.problem, &stored.start) * (1.0 + 1e-9), "{kind:?}");
            last = outcome.residual;
        }
    }
}

#[test]
fn numbers_that_are_not_finite_are_told() {
    for kind in ALL {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for problem in [line(&[(1.0, -0.1), (1.0, bad)]), line(&[(1.0, -0.1), (bad, 0.1)])] {
                let mut gamma = vec![0.5, f64::NAN];
                let outcome = solve(kind, &problem, &mut gamma, 1e-8);
                assert_eq!(outcome.status, Status::NotFinite, "{kind:?} {bad}: {outcome:?}");
                assert_eq!(gamma, [0.5, 0.0], "{kind:?} {bad}");
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    // Four copies of the larger system side by side: enough rows for the parallel loops.
    let part = stored("colony4096_rec1").problem;
    let mut whole = Problem { bodies: 4 * part.bodies, ..Problem::default() };
    for copy in 0..4 {
        let shift = |pair: &[u32; 2]| pair.map(|body| body + (copy * part.bodies) as u32);
        whole.pair.extend(part.pair.iter().map(shift));
        whole.jacobian.extend(&part.jacobian);
        whole.q.extend(part.q.iter().map(|q| q * (1.0 + 0.1 * copy as f64)));
    }
    for kind in ITERATIVE {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut gamma = Vec::new();
                let settings = Settings { tolerance: 1e-9, max_iterations: 25 };
                let outcome = Solver::new(kind, settings).solve(&whole, &mut gamma);
                (outcome, gamma)
            })
        };
        let one = run(1);
        assert!(run(2) == one && run(3) == one, "{kind:?}");
    }
}

#[test]
fn rows_may_stand_in_any_order() {
    let stored = stored("colony1024_rec1");
    let rows = stored.problem.q.len();
    // Rows of a pair far apart, and half of the pairs named the other way round.
    let order: Vec<usize> = (0..rows).map(|row| (row * 1_009) % rows).collect();
    let turn = |row: usize, k: usize| if row.is_multiple_of(2) { k } else { 1 - k };
    let (pair, jacobian) = (&stored.problem.pair, &stored.problem.jacobian);
    let shuffled = Problem {
        bodies: stored.problem.bodies,
        pair: order.iter().map(|row| [0, 1].map(|k| pair[*row][turn(*row, k)])).collect(),
        jacobian: order.iter().map(|row| [0, 1].map(|k| jacobian[*row][turn(*row, k)])).collect(),
        q: order.iter().map(|row| stored.problem.q[*row]).collect(),
        ..Problem::default()
    };
    let mut gamma = Vec::new();
    let outcome = solve(SolverKind::Auto, &shuffled, &mut gamma, 1e-5);
    assert_eq!(outcome.status, Status::Solved);
    assert!(outcome.products < 500, "{outcome:?}");
    assert!((residual(&shuffled, &gamma) - outcome.residual).abs() < 1e-11);
}

#[test]
fn a_solver_keeps_nothing_of_an_earlier_problem() {
    let stored = stored("colony1024_rec0");
    for kind in ITERATIVE {
        let settings = Settings { tolerance: 1e-4, max_iterations: 1_000 };
        let mut used = Solver::new(kind, settings);
        used.solve(&random::<3>(1, 60, 5_000, 0.3), &mut Vec::new());
        let (mut a, mut b) = (stored.start.clone(), stored.start.clone());
        let first = used.solve(&stored.problem, &mut a);
        let second = Solver::new(kind, settings).solve(&stored.problem, &mut b);
        assert!(first == second && a == b, "{kind:?}: {first:?}, {second:?}");
    }
}
