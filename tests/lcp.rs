//! The LCP solvers: against each other, against the exact one, against stored systems of growing colonies.

#![allow(clippy::unwrap_used)]

use npyz::NpyFile;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::lcp::{Outcome, Problem, Settings, Solver, Status, velocity};
use relcp::scene::SolverKind;
use std::io::Read;

const ITERATIVE: [SolverKind; 5] = [
    SolverKind::ProjectedJacobi,
    SolverKind::ProjectedGaussSeidel,
    SolverKind::Apgd,
    SolverKind::Bbpgd,
    SolverKind::PairBlockCg,
];

/// A stored system, a start, a reference solution's velocity.
struct Stored {
    problem: Problem<3>,
    start: Vec<f64>,
    velocity: Vec<[f64; 3]>,
}

fn block<T: npyz::Deserialize>(archive: &mut zip::ZipArchive<std::fs::File>, name: &str) -> Vec<T> {
    let mut bytes = Vec::new();
    archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
    NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap()
}

fn stored(name: &str) -> Stored {
    let path = format!("{}/tests/data/lcp/{name}.npz", env!("CARGO_MANIFEST_DIR"));
    let archive = &mut zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
    let blocks = |numbers: Vec<f64>| -> Vec<[f64; 3]> { numbers.chunks(3).map(|c| [c[0], c[1], c[2]]).collect() };
    let (a, b) = (block::<i32>(archive, "a"), block::<i32>(archive, "b"));
    let (row_a, row_b) = (blocks(block(archive, "row_a")), blocks(block(archive, "row_b")));
    Stored {
        problem: Problem {
            bodies: block::<i64>(archive, "bodies")[0] as usize,
            pair: a.iter().zip(&b).map(|(a, b)| [*a as u32, *b as u32]).collect(),
            jacobian: row_a.iter().zip(&row_b).map(|(a, b)| [*a, *b]).collect(),
            q: block(archive, "q"),
        },
        start: block(archive, "gamma0"),
        velocity: blocks(block(archive, "v")),
    }
}

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

/// The natural residual, written out.
fn residual<const D: usize>(problem: &Problem<D>, gamma: &[f64]) -> f64 {
    let v = velocity(problem, gamma);
    let mut worst: f64 = 0.0;
    for (row, [a, b]) in problem.pair.iter().enumerate() {
        let (mut g, mut s) = (problem.q[row], 0.0);
        for (body, block) in [a, b].into_iter().zip(&problem.jacobian[row]) {
            for k in 0..D {
                g += block[k] * v[*body as usize][k];
                s += block[k] * block[k];
            }
        }
        worst = worst.max(g.min(s * gamma[row]).abs());
    }
    worst
}

/// A solvable problem with a bit of everything: `q` is such that a random velocity keeps every row open or closed.
/// Some rows repeat another of the same pair: as it is, scaled, the pair named the other way, nearly parallel, or opposite.
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

/// Solves a random problem exactly, and by other solvers from nothing and from a poor start: same velocity, honest residual.
fn agree<const D: usize>(kinds: &[SolverKind], seed: u64, bodies: u32, rows: usize, apart: f64) {
    let problem = random::<D>(seed, bodies, rows, apart);
    let mut exact = Vec::new();
    let settings = Settings { tolerance: 1e-12, max_iterations: 10_000 };
    let outcome = Solver::new(SolverKind::Dense, settings).solve(&problem, &mut exact);
    assert_eq!(outcome.status, Status::Solved, "{seed}: {outcome:?}");
    let reference = velocity(&problem, &exact);
    let size = reference.as_flattened().iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    for kind in kinds {
        let settings = Settings { tolerance: 1e-10, max_iterations: 400_000 };
        let mut solver = Solver::new(*kind, settings);
        let poor: Vec<f64> =
            exact.iter().enumerate().map(|(row, x)| if row % 3 == 0 { 0.7 * x } else { 0.01 }).collect();
        for start in [Vec::new(), poor, exact.clone()] {
            let mut gamma = start;
            let outcome = solver.solve(&problem, &mut gamma);
            let v = velocity(&problem, &gamma);
            let pairs = v.as_flattened().iter().zip(reference.as_flattened());
            let error = pairs.fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs())) / size;
            let what = format!("seed {seed}, D {D}, {kind:?}: {outcome:?}, error {error:.1e}");
            assert_eq!(outcome.status, Status::Solved, "{what}");
            assert!(error < 1e-7, "{what}");
            assert!(gamma.iter().all(|x| *x >= 0.0), "{what}");
            assert!((residual(&problem, &gamma) - outcome.residual).abs() < 1e-13, "{what}");
            assert!(gamma != exact || outcome.iterations == 0, "{what}");
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
    for seed in 0..2 {
        agree::<3>(&[SolverKind::PairBlockCg], seed, 12, 30, 1e-3);
        agree::<3>(&[SolverKind::PairBlockCg], seed, 60, 200, 1e-3);
        agree::<6>(&[SolverKind::PairBlockCg], seed, 30, 200, 1e-3);
    }
}

#[test]
fn stored_systems_are_solved_within_their_products() {
    for (name, products) in [("colony1024_rec0", 95), ("colony1024_rec1", 400), ("colony1024_seeded", 450)] {
        let stored = stored(name);
        let mut gamma = stored.start.clone();
        let outcome = solve(SolverKind::Auto, &stored.problem, &mut gamma, 1e-5);
        assert_eq!(outcome.status, Status::Solved, "{name}: {outcome:?}");
        assert!(outcome.products <= products, "{name}: {outcome:?}");
    }
    let stored = stored("colony1024_rec0");
    let mut gamma = stored.start.clone();
    solve(SolverKind::Auto, &stored.problem, &mut gamma, 1e-9);
    assert!(error(&stored.problem, &gamma, &stored.velocity) < 1e-6);
}
