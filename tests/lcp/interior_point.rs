//! The reference solver: against stored solutions, against the exact solver, on systems that are hard for others.

use crate::{STORED, error, line, random, residual, stored};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::lcp::{Outcome, Problem, Settings, Solver, Status, velocity};
use relcp::scene::SolverKind;

fn solve_by<const D: usize>(kind: SolverKind, problem: &Problem<D>, gamma: &mut Vec<f64>, tolerance: f64) -> Outcome {
    Solver::new(kind, Settings { tolerance, max_iterations: 400_000 }).solve(problem, gamma)
}

fn solve<const D: usize>(problem: &Problem<D>, tolerance: f64) -> (Outcome, Vec<f64>) {
    let mut gamma = Vec::new();
    let outcome = solve_by(SolverKind::InteriorPoint, problem, &mut gamma, tolerance);
    assert_eq!(gamma.len(), problem.q.len());
    assert!(gamma.iter().all(|x| *x >= 0.0 && x.is_finite()));
    (outcome, gamma)
}

/// `|a - b| / |b|`.
fn apart<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    let length = |f: &dyn Fn(usize) -> f64| (0..b.len()).map(|i| f(i).powi(2)).sum::<f64>().sqrt();
    length(&|i| a[i] - b[i]) / length(&|i| b[i])
}

#[test]
fn stored_systems_have_the_stored_velocity() {
    for (name, _, _) in STORED {
        let stored = stored(name);
        let (outcome, gamma) = solve(&stored.problem, 1e-10);
        let error = error(&stored.problem, &gamma, &stored.velocity);
        println!("{name}: {outcome:?}, error {error:.1e}");
        assert_eq!(outcome.status, Status::Solved, "{name}: {outcome:?}");
        // The stored multipliers are good to 1e-8.
        assert!(error < 1e-7, "{name}: {outcome:?}, error {error:.1e}");
        assert!(outcome.factorizations <= 40, "{name}: {outcome:?}");
        assert!((residual(&stored.problem, &gamma) - outcome.residual).abs() < 1e-11, "{name}: {outcome:?}");
        // Rows that are open push nothing at all.
        let pushing = gamma.iter().filter(|x| **x > 0.0).count();
        assert!(pushing < gamma.len() * 9 / 10, "{name}: {pushing} of {} rows push", gamma.len());
    }
}

fn agrees_with_the_exact_one<const D: usize>(nearness: f64, seeds: std::ops::Range<u64>) {
    for seed in seeds {
        for (bodies, rows) in [(2, 1), (3, 12), (20, 30), (12, 40), (60, 200), (30, 200), (100, 120)] {
            let problem = random::<D>(seed, bodies, rows, nearness);
            let mut exact = Vec::new();
            let outcome = solve_by(SolverKind::Dense, &problem, &mut exact, 1e-12);
            assert_eq!(outcome.status, Status::Solved, "{seed}: {outcome:?}");
            let (outcome, gamma) = solve(&problem, 1e-11);
            let (v, reference) = (velocity(&problem, &gamma), velocity(&problem, &exact));
            let error = if outcome.iterations == 0 { 0.0 } else { apart(&v, &reference) };
            let what = format!("seed {seed}, D {D}, {bodies} bodies, {rows} rows: {outcome:?}, error {error:.1e}");
            assert_eq!(outcome.status, Status::Solved, "{what}");
            assert!(error < 1e-8, "{what}");
            assert!(outcome.iterations <= 60, "{what}");
        }
    }
}

#[test]
fn small_systems_agree_with_the_exact_solver() {
    agrees_with_the_exact_one::<3>(0.3, 0..20);
    agrees_with_the_exact_one::<6>(0.3, 20..40);
}

#[test]
fn nearly_parallel_rows_agree_with_the_exact_solver() {
    agrees_with_the_exact_one::<3>(1e-3, 0..20);
    agrees_with_the_exact_one::<6>(1e-3, 20..40);
}

#[test]
fn other_solvers_agree_on_systems_too_large_for_the_exact_one() {
    // Not Barzilai-Borwein steps, which make no headway on some of them and say so.
    let kinds = [SolverKind::PairBlockCg, SolverKind::Apgd, SolverKind::ProjectedGaussSeidel];
    for seed in 0..3 {
        let problem = random::<3>(seed, 1_000, 2_000, 0.3);
        let (outcome, gamma) = solve(&problem, 1e-11);
        assert_eq!(outcome.status, Status::Solved, "{seed}: {outcome:?}");
        for kind in kinds {
            let mut other = Vec::new();
            let outcome = solve_by(kind, &problem, &mut other, 1e-10);
            let error = apart(&velocity(&problem, &other), &velocity(&problem, &gamma));
            assert_eq!(outcome.status, Status::Solved, "{seed} {kind:?}: {outcome:?}");
            assert!(error < 1e-7, "{seed} {kind:?}: {outcome:?}, error {error:.1e}");
        }
    }
}

#[test]
fn rows_said_again_change_nothing() {
    for seed in 0..8 {
        let problem = random::<6>(seed, 30, 100, 0.3);
        let mut again = problem.clone();
        for (copy, scale) in [1.0, 1e-3, 40.0].into_iter().enumerate() {
            for row in (0..problem.q.len()).filter(|row| (row + copy) % 3 != 0) {
                let ([a, b], [ja, jb]) = (problem.pair[row], problem.jacobian[row]);
                again.pair.push([b, a]);
                again.jacobian.push([jb.map(|x| scale * x), ja.map(|x| scale * x)]);
                again.q.push(scale * problem.q[row]);
            }
        }
        let ((outcome, gamma), (outcome_again, gamma_again)) = (solve(&problem, 1e-12), solve(&again, 1e-12));
        assert_eq!(
            (outcome.status, outcome_again.status),
            (Status::Solved, Status::Solved),
            "{seed}: {outcome_again:?}"
        );
        let error = apart(&velocity(&again, &gamma_again), &velocity(&problem, &gamma));
        assert!(error < 1e-8, "{seed}: {outcome:?}, {outcome_again:?}, {error:.1e}");
    }
}

/// Adds a ring of `length` rows that leave each other no room by `gap`: their blocks cancel, their gaps sum to `-gap`.
fn jam<const D: usize>(problem: &mut Problem<D>, rng: &mut ChaCha8Rng, length: u32, gap: f64) {
    let direction: [f64; D] = std::array::from_fn(|_| rng.random::<f64>() - 0.5);
    let first = rng.random_range(0..problem.bodies as u32 - length);
    for k in 0..length {
        let scale = 0.1 + rng.random::<f64>();
        problem.pair.push([first + k, first + (k + 1) % length]);
        problem.jacobian.push([direction.map(|x| scale * x), direction.map(|x| -scale * x)]);
        problem.q.push(-gap * scale / f64::from(length));
    }
}

fn jammed_systems_are_told<const D: usize>() {
    for seed in 0..12 {
        for (length, gap) in [(2, 0.3), (2, 1e-4), (3, 0.3), (5, 1e-2), (12, 0.3)] {
            let mut problem = random::<D>(seed, 40, 90, 0.3);
            jam(&mut problem, &mut ChaCha8Rng::seed_from_u64(seed), length, gap);
            let (outcome, gamma) = solve(&problem, 1e-10);
            let what = format!("seed {seed}, D {D}, ring of {length}, gap {gap}: {outcome:?}");
            assert_eq!(outcome.status, Status::Infeasible, "{what}");
            assert!(outcome.iterations <= 60, "{what}");
            // Some row of the ring stays closed by its share.
            assert!(outcome.residual >= 0.09 * gap / f64::from(length), "{what}");
            assert!(outcome.residual <= residual(&problem, &vec![0.0; gamma.len()]), "{what}");
            let rounding = 1e-12 * gamma.iter().fold(1.0, |a: f64, b| a.max(*b));
            assert!((residual(&problem, &gamma) - outcome.residual).abs() < rounding, "{what}");
        }
    }
}

#[test]
fn jammed_systems_are_infeasible() {
    jammed_systems_are_told::<3>();
    jammed_systems_are_told::<6>();
}

#[test]
fn rows_with_just_enough_room_are_not_infeasible() {
    // Opposite rows without room but without contradiction: no velocity is strictly inside.
    for scale in [1.0, 1e-3, 1e-6] {
        let (outcome, gamma) = solve(&line(&[(scale, -0.1), (-scale, 0.1)]), 1e-11);
        assert_eq!(outcome.status, Status::Solved, "{outcome:?}");
        assert!((scale * (gamma[0] - gamma[1]) - 0.05 / scale).abs() < 1e-8 / scale, "{gamma:?}");
    }
    // A row of bodies that push each other apart: the ends move by a thousand violations.
    let bodies = 2_001;
    let chain = Problem::<3> {
        bodies,
        pair: (1..bodies as u32).map(|i| [i - 1, i]).collect(),
        jacobian: vec![[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]; bodies - 1],
        q: vec![-0.1; bodies - 1],
        ..Problem::default()
    };
    let (outcome, gamma) = solve(&chain, 1e-10);
    assert_eq!(outcome.status, Status::Solved, "{outcome:?}");
    let v = velocity(&chain, &gamma);
    assert!((v[0][0] + 100.0).abs() < 1e-6 && (v[2_000][0] - 100.0).abs() < 1e-6, "{:?}", v[0]);
}

#[test]
fn the_best_of_start_and_iterates_is_returned() {
    let stored = stored("colony1024_rec1");
    let mut good = stored.start.clone();
    solve_by(SolverKind::PairBlockCg, &stored.problem, &mut good, 1e-6);
    let at_start = residual(&stored.problem, &good);
    for max_iterations in [0, 1, 4, 10] {
        let mut gamma = good.clone();
        let settings = Settings { tolerance: 1e-9, max_iterations };
        let outcome = Solver::new(SolverKind::InteriorPoint, settings).solve(&stored.problem, &mut gamma);
        assert_eq!((outcome.status, outcome.iterations), (Status::MaxIterations, max_iterations));
        assert!(outcome.residual <= at_start * (1.0 + 1e-9), "{outcome:?}, {at_start:e}");
        assert!((residual(&stored.problem, &gamma) - outcome.residual).abs() < 1e-11, "{outcome:?}");
    }
}

#[test]
fn a_tolerance_below_rounding_ends() {
    let stored = stored("colony1024_seeded");
    let (outcome, _) = solve(&stored.problem, 0.0);
    assert_eq!(outcome.status, Status::NoProgress, "{outcome:?}");
    assert!(outcome.iterations < 100 && outcome.residual < 1e-10, "{outcome:?}");
}

/// A rectangle of bodies, each with a row to its right, upper, and diagonal neighbours.
fn lattice(width: u32, height: u32, seed: u64) -> Problem<3> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut problem = Problem { bodies: (width * height) as usize, ..Problem::default() };
    for i in 0..width * height {
        for (dx, dy) in [(1, 0), (0, 1), (1, 1)] {
            if i % width + dx < width && i / width + dy < height {
                let angle = f64::from(dy).atan2(f64::from(dx)) + 0.3 * (rng.random::<f64>() - 0.5);
                let mut lever = || rng.random::<f64>() - 0.5;
                let (s, c) = angle.sin_cos();
                problem.pair.push([i, i + dx + dy * width]);
                problem.jacobian.push([[-c, -s, lever()], [c, s, lever()]]);
                problem.q.push(0.1 * (rng.random::<f64>() - 0.7));
            }
        }
    }
    problem
}

fn agrees_with_the_default_one(problem: &Problem<3>) {
    let (outcome, gamma) = solve(problem, 1e-9);
    assert_eq!(outcome.status, Status::Solved, "{outcome:?}");
    let mut other = Vec::new();
    let by_cg = solve_by(SolverKind::PairBlockCg, problem, &mut other, 1e-8);
    assert_eq!(by_cg.status, Status::Solved, "{by_cg:?}");
    let error = apart(&velocity(problem, &other), &velocity(problem, &gamma));
    println!("{} rows: {outcome:?}, {by_cg:?}, error {error:.1e}", problem.q.len());
    assert!(error < 1e-5, "{outcome:?}, {by_cg:?}, {error:.1e}");
}

#[test]
fn thousands_of_rows() {
    agrees_with_the_default_one(&lattice(8, 400, 1));
}

#[test]
#[ignore = "takes minutes where the crate is not optimized"]
fn a_hundred_thousand_rows() {
    let problem = lattice(184, 184, 1);
    assert!(problem.q.len() > 100_000);
    agrees_with_the_default_one(&problem);
}

#[test]
fn threads_do_not_change_a_bit() {
    let problem = lattice(6, 2_300, 2);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut gamma = Vec::new();
            let settings = Settings { tolerance: 1e-9, max_iterations: 4 };
            (Solver::new(SolverKind::InteriorPoint, settings).solve(&problem, &mut gamma), gamma)
        })
    };
    assert!(problem.q.len() > 32_768, "the products are not parallel");
    let one = run(1);
    assert!(one.0.factorizations == 5 && run(2) == one && run(3) == one);
}

#[test]
fn it_keeps_nothing_of_an_earlier_problem() {
    let (other, problem) = (random::<3>(1, 60, 500, 0.3), stored("colony1024_rec0").problem);
    let settings = Settings { tolerance: 1e-9, max_iterations: 1_000 };
    let mut used = Solver::new(SolverKind::InteriorPoint, settings);
    used.solve(&other, &mut Vec::new());
    used.solve(&line(&[(1.0, -0.1), (-1.0, -0.1)]), &mut Vec::new());
    let (mut a, mut b) = (Vec::new(), Vec::new());
    let first = used.solve(&problem, &mut a);
    let second = Solver::new(SolverKind::InteriorPoint, settings).solve(&problem, &mut b);
    assert!(first == second && a == b, "{first:?}, {second:?}");
}

#[test]
fn auto_is_rescued_where_its_engine_gives_up() {
    let stored = stored("colony1024_rec1");
    let settings = Settings { tolerance: 1e-9, max_iterations: 30 };
    let mut alone = Vec::new();
    let given_up = Solver::new(SolverKind::PairBlockCg, settings).solve(&stored.problem, &mut alone);
    assert_eq!((given_up.status, given_up.fallback), (Status::MaxIterations, false), "{given_up:?}");
    let mut gamma = Vec::new();
    let mut solver = Solver::new(SolverKind::Auto, settings).for_parallel_rows();
    let rescued = solver.solve(&stored.problem, &mut gamma);
    assert_eq!((rescued.status, rescued.fallback), (Status::Solved, true), "{rescued:?}");
    assert!(rescued.residual <= 1e-9 && rescued.factorizations > 0 && rescued.iterations > 30, "{rescued:?}");
    assert!(error(&stored.problem, &gamma, &stored.velocity) < 1e-7);
    // Only where it is needed.
    solver.set_settings(Settings { tolerance: 1e-5, max_iterations: 100_000 });
    let plain = solver.solve(&self::stored("colony1024_rec0").problem, &mut Vec::new());
    assert_eq!((plain.status, plain.fallback, plain.factorizations), (Status::Solved, false, 0), "{plain:?}");
    // Where conjugate gradients take over a thousand products, both together take two thirds.
    let settings = Settings { tolerance: 1e-6, max_iterations: 100_000 };
    let alone = Solver::new(SolverKind::PairBlockCg, settings).solve(&stored.problem, &mut Vec::new());
    solver.set_settings(settings);
    let both = solver.solve(&stored.problem, &mut Vec::new());
    assert!(
        both.status == Status::Solved && both.fallback && 3 * both.products < 2 * alone.products,
        "{both:?}, {alone:?}"
    );
}

#[test]
fn auto_tells_a_contradiction_from_no_progress() {
    let mut problem = random::<3>(3, 40, 90, 0.3);
    jam(&mut problem, &mut ChaCha8Rng::seed_from_u64(3), 5, 0.1);
    let mut gamma = Vec::new();
    let alone = solve_by(SolverKind::PairBlockCg, &problem, &mut gamma, 1e-9);
    assert_eq!(alone.status, Status::NoProgress, "{alone:?}");
    let mut gamma = Vec::new();
    let outcome = solve_by(SolverKind::Auto, &problem, &mut gamma, 1e-9);
    assert_eq!((outcome.status, outcome.fallback), (Status::Infeasible, true), "{outcome:?}");
    assert!(outcome.residual <= alone.residual * (1.0 + 1e-9), "{outcome:?}, {alone:?}");
}
