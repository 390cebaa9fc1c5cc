//! How fast the product is against this machine's memory, and what each solver costs on the stored systems. Printed tables;
//! `cargo bench --bench lcp`.
#![allow(clippy::unwrap_used)]

use relcp::lcp::product::Product;
use relcp::lcp::{Problem, Settings, Solver};
use relcp::scene::SolverKind;
use std::hint::black_box;
use std::io::Read;
use std::time::Instant;

fn main() {
    // `cargo test --benches` runs this file too, without `--bench`: nothing to time then.
    if std::env::args().any(|argument| argument == "--bench") {
        products();
        solvers();
    }
}

/// The shortest time of some calls, in seconds.
fn shortest(calls: usize, mut call: impl FnMut()) -> f64 {
    let times = (0..calls).map(|_| {
        let now = Instant::now();
        call();
        now.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

/// Bytes a second of `a = b + s c` on arrays far larger than the caches, three numbers moved an element.
fn triad() -> f64 {
    use rayon::prelude::*;
    let n = 8_000_000;
    let (mut a, b, c) = (vec![0.0; n], vec![1.0; n], vec![2.0; n]);
    let seconds = shortest(10, || {
        let task = 65_536;
        let parts = a.par_chunks_mut(task).zip(b.par_chunks(task)).zip(c.par_chunks(task));
        parts.for_each(|((a, b), c): ((&mut [f64], &[f64]), &[f64])| {
            for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                *a = b + 3.0 * c;
            }
        });
        black_box(&a);
    });
    (3 * 8 * n) as f64 / seconds
}

/// A square lattice of bodies, each with the three neighbours after it: three rows a body, as in a packed colony.
fn lattice(rows: usize) -> Problem<3> {
    let side = ((rows as f64 / 3.0).sqrt() as usize).max(2);
    let mut problem = Problem { bodies: side * side, ..Problem::default() };
    for i in 0..side - 1 {
        for j in 0..side - 1 {
            let body = i * side + j;
            for other in [body + 1, body + side, body + side + 1] {
                problem.pair.push([body as u32, other as u32]);
                problem.jacobian.push([[0.5, 0.25, -0.5], [-0.5, -0.25, 0.75]]);
                problem.q.push(-0.1);
            }
        }
    }
    problem
}

fn products() {
    println!("threads {}", rayon::current_num_threads());
    println!("     rows  one thread, us  all threads, us  bytes a second / triad (1 thread, all)");
    for rows in [1_000, 4_000, 8_000, 16_000, 32_000, 100_000, 400_000, 1_000_000] {
        let problem = lattice(rows);
        let rows = problem.q.len();
        // Every block of J twice (for J^T x and for J v), x twice, the result once, velocities twice, pairs or entries twice.
        let bytes = (rows * (2 * 48 + 2 * 8 + 8 + 2 * 8) + problem.bodies * 2 * 24) as f64;
        let order: Vec<u32> = (0..rows as u32).collect();
        let measure = || {
            let mut product = Product::<3>::default();
            product.rebuild(problem.bodies, &problem.pair, &problem.jacobian, &order);
            let (x, mut out) = (vec![1.0; rows], vec![0.0; rows]);
            let seconds = shortest(4_000_000 / rows + 10, || {
                product.apply(&x, None, &mut out);
                black_box(&out);
            });
            (seconds, bytes / seconds / triad())
        };
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(measure);
        let all = measure();
        println!("{rows:9}  {:14.0}  {:15.0}  {:.2}, {:.2}", one.0 * 1e6, all.0 * 1e6, one.1, all.1);
    }
}

fn block<T: npyz::Deserialize>(archive: &mut zip::ZipArchive<std::fs::File>, name: &str) -> Vec<T> {
    let mut bytes = Vec::new();
    archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
    npyz::NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap()
}

fn stored(name: &str) -> (Problem<3>, Vec<f64>) {
    let path = format!("{}/tests/data/lcp/{name}.npz", env!("CARGO_MANIFEST_DIR"));
    let archive = &mut zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
    let blocks = |numbers: Vec<f64>| -> Vec<[f64; 3]> { numbers.chunks(3).map(|c| [c[0], c[1], c[2]]).collect() };
    let (a, b) = (block::<i32>(archive, "a"), block::<i32>(archive, "b"));
    let (row_a, row_b) = (blocks(block(archive, "row_a")), blocks(block(archive, "row_b")));
    let problem = Problem {
        bodies: block::<i64>(archive, "bodies")[0] as usize,
        pair: a.iter().zip(&b).map(|(a, b)| [*a as u32, *b as u32]).collect(),
        jacobian: row_a.iter().zip(&row_b).map(|(a, b)| [*a, *b]).collect(),
        q: block(archive, "q"),
    };
    (problem, block(archive, "gamma0"))
}

fn solvers() {
    println!("products (milliseconds) from the stored start; - is not solved within 20,000 iterations");
    println!("{:18} {:22} {:>16} {:>16} {:>16}", "system", "solver", "1e-3", "1e-5", "1e-6");
    let kinds = [
        SolverKind::ProjectedJacobi,
        SolverKind::ProjectedGaussSeidel,
        SolverKind::Apgd,
        SolverKind::Bbpgd,
        SolverKind::PairBlockCg,
    ];
    for name in ["colony1024_rec0", "colony1024_rec1", "colony1024_rec5", "colony1024_seeded", "colony4096_rec1"] {
        let (problem, start) = stored(name);
        for kind in kinds {
            print!("{name:18} {:22}", format!("{kind:?}"));
            for tolerance in [1e-3, 1e-5, 1e-6] {
                let mut gamma = start.clone();
                let mut solver = Solver::new(kind, Settings { tolerance, max_iterations: 20_000 });
                let now = Instant::now();
                let outcome = solver.solve(&problem, &mut gamma);
                let time = now.elapsed().as_secs_f64() * 1e3;
                let products = match outcome.status {
                    relcp::lcp::Status::Solved => outcome.products.to_string(),
                    _ => "-".to_string(),
                };
                print!(" {:>16}", format!("{products} ({time:.0})"));
            }
            println!();
        }
    }
}
