//! The LCP solvers on the device against those on the CPU.

use crate::device::{device, precisions};
use npyz::NpyFile;
use relcp::gpu::{Gpu, Precision};
use relcp::lcp::gpu::{DeviceProblem, Solver};
use relcp::lcp::{self, Outcome, Problem, Settings, Status, velocity};
use relcp::scene::SolverKind;
use std::io::Read;

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

/// What a solve on the device left.
struct Solved<const D: usize> {
    outcome: Outcome,
    gamma: Vec<f64>,
    velocity: Vec<[f64; D]>,
    seconds: f64,
    dispatches: u64,
}

fn solve<const D: usize>(
    gpu: &Gpu,
    precision: Precision,
    solver: &mut Solver,
    problem: &Problem<D>,
    start: &[f64],
) -> Solved<D> {
    let (mut device, order) = DeviceProblem::upload(gpu, precision, problem, start).unwrap();
    gpu.wait().unwrap();
    let (begun, before) = (std::time::Instant::now(), gpu.counters());
    let outcome = solver.solve(gpu, &mut device).unwrap();
    gpu.wait().unwrap();
    let seconds = begun.elapsed().as_secs_f64();
    Solved {
        outcome,
        gamma: device.download_gamma(gpu, precision, &order).unwrap(),
        velocity: device.download_velocity(gpu, precision).unwrap(),
        seconds,
        dispatches: gpu.counters().dispatches - before.dispatches,
    }
}

/// `|v - reference| / |reference|`.
fn error<const D: usize>(v: &[[f64; D]], reference: &[[f64; D]]) -> f64 {
    let (v, reference) = (v.as_flattened(), reference.as_flattened());
    let size = reference.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart = v.iter().zip(reference).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    if size > 0.0 { apart / size } else { apart }
}

const STORED: [&str; 5] =
    ["colony1024_rec0", "colony1024_rec1", "colony1024_rec5", "colony1024_seeded", "colony4096_rec1"];

#[test]
fn stored_systems_are_solved() {
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let tolerance = 1e-5;
        let settings = Settings { tolerance, max_iterations: 20_000 };
        let mut solver = Solver::new(gpu, precision, true, SolverKind::Auto, settings).unwrap();
        for name in STORED.into_iter().filter(|name| std::env::var("LCP").is_err() || std::env::var("LCP").unwrap() == *name) {
            let stored = stored(name);
            for start in [stored.start.clone(), Vec::new()] {
                let solved = solve(gpu, precision, &mut solver, &stored.problem, &start);
                let mut gamma = start.clone();
                let cpu = lcp::Solver::new(SolverKind::Auto, settings).solve(&stored.problem, &mut gamma);
                let rechecked = residual(&stored.problem, &solved.gamma);
                println!(
                    "{name} {} {}: {:?} {} its {} products (CPU {}), residual {:.2e} rechecked {rechecked:.2e}, v {:.1e} (CPU {:.1e}), {:.3} s, {:.1} us/it, {:.1} dispatches/it",
                    precision.name(),
                    if start.is_empty() { "cold" } else { "warm" },
                    solved.outcome.status,
                    solved.outcome.iterations,
                    solved.outcome.products,
                    cpu.products,
                    solved.outcome.residual,
                    error(&velocity(&stored.problem, &solved.gamma), &stored.velocity),
                    error(&velocity(&stored.problem, &gamma), &stored.velocity),
                    solved.seconds,
                    1e6 * solved.seconds / solved.outcome.iterations.max(1) as f64,
                    solved.dispatches as f64 / solved.outcome.iterations.max(1) as f64,
                );
                assert_eq!(solved.outcome.status, Status::Solved, "{name}");
                assert!(rechecked <= 1.1 * tolerance, "{name}: {rechecked:e}");
                assert!(error(&solved.velocity, &velocity(&stored.problem, &solved.gamma)) < 1e-5);
            }
        }
    }
}

/// Seconds of processor time that this process used.
fn used() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    (fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap()) / 100.0
}

#[test]
#[ignore = "a measurement"]
fn profile() {
    let Some(gpu) = device() else { return };
    let max_iterations = std::env::var("ITS").map_or(100, |n| n.parse().unwrap());
    let settings = Settings { tolerance: 1e-12, max_iterations };
    let name = std::env::var("LCP").unwrap_or("colony1024_rec1".into());
    let stored = stored(&name);
    let precision = if std::env::var("F64").is_ok() { Precision::F64 } else { Precision::F32 };
    let mut solver = Solver::new(gpu, precision, true, SolverKind::Auto, settings).unwrap();
    for timed in [false, false, true] {
        if timed && std::env::var("STAGES").is_ok() {
            gpu.start_timing();
        }
        let before = used();
        let solved = solve(gpu, precision, &mut solver, &stored.problem, &stored.start);
        let each = 1e6 / solved.outcome.iterations as f64;
        println!(
            "{:?} {:.0} us wall, {:.0} us of processors an iteration",
            solved.outcome,
            solved.seconds * each,
            (used() - before) * each
        );
    }
    for pipeline in gpu.pipelines() {
        print!("{} {:.3}; ", pipeline.name, pipeline.seconds);
    }
    println!();
    for stage in gpu.stage_times() {
        println!("{} {:.1} us each, {} passes", stage.stage, 1e6 * stage.seconds / stage.passes as f64, stage.passes);
    }
}
