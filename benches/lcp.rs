//! The speed of the product compared with this machine's memory, and the cost of each solver on the stored systems.
//! Prints tables; `cargo bench --bench lcp`.
#![allow(clippy::unwrap_used)]

use relcp::internals::lcp::cpu::Cpu;
use relcp::internals::lcp::product::Product;
use relcp::internals::lcp::verbs::Verbs;
use relcp::lcp::{Problem, Settings, Solver};
use relcp::scene::SolverKind;
use std::hint::black_box;
use std::time::Instant;

fn main() {
    // `cargo test --benches` runs this file too, without `--bench`: nothing to time then.
    if std::env::args().any(|argument| argument == "--bench") {
        products();
        teams();
        iterations();
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

/// Returns the bytes per second of `a = b + s c` on arrays far larger than the caches; three numbers move per element.
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

/// A square lattice of bodies, each with the three neighbours after it: three rows per body, as in a packed colony.
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
    println!("     rows  a product, us  bytes a second / triad of one thread");
    let triad = one_thread(triad);
    for rows in [1_000, 4_000, 8_000, 16_000, 32_000, 100_000, 400_000, 1_000_000] {
        let problem = lattice(rows);
        let rows = problem.q.len();
        // Every block of J twice (for J^T x and for J v), x twice, the result once, velocities twice, pairs twice.
        let bytes = (rows * (2 * 48 + 2 * 8 + 8 + 2 * 8) + problem.bodies * 2 * 24) as f64;
        let order: Vec<u32> = (0..rows as u32).collect();
        let mut product = Product::<3>::default();
        product.rebuild(problem.bodies, &problem.pair, &problem.jacobian, &order);
        let (x, mut out) = (vec![1.0; rows], vec![0.0; rows]);
        let seconds = shortest(4_000_000 / rows + 10, || {
            product.apply(&x, &mut out);
            black_box(&out);
        });
        println!("{rows:9}  {:13.0}  {:.2}", seconds * 1e6, bytes / seconds / triad);
    }
}

fn one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(work)
}

/// Prints the cost of an iteration of `pair_block_cg` with one thread and with all threads, on copies of a stored
/// system.
fn teams() {
    println!("threads {}", rayon::current_num_threads());
    println!("     rows  an iteration of one thread, us  of all, us  ratio");
    let (small, gamma) = stored::<3>("tests/data/lcp/colony1024_rec0");
    for n in [1, 2, 4, 8, 16, 32] {
        let (problem, start) = (copies(&small, n), gamma.repeat(n));
        let iteration = || {
            // The first solve tells the solver how fast one thread is.
            let mut solver = Solver::new(SolverKind::PairBlockCg, Settings { tolerance: 0.0, max_iterations: 400 });
            shortest(6, || {
                black_box(solver.solve(&problem, &mut start.clone()));
            }) / 400.0
        };
        let (one, all) = (one_thread(iteration), iteration());
        println!("{:9}  {:30.0}  {:10.0}  {:.2}", problem.q.len(), one * 1e6, all * 1e6, all / one);
    }
}

/// Returns the bytes per second of `a = b + s c` with one thread on arrays of `bytes` bytes in total: the speed of a
/// cache if they fit into it.
fn triad_of(bytes: usize) -> f64 {
    let n = (bytes / 24).max(64);
    let (mut a, b, c) = (vec![0.0; n], vec![1.0; n], vec![2.0; n]);
    let repeats = (200_000 / n).max(1);
    let seconds = shortest(30, || {
        for _ in 0..repeats {
            let s = black_box(3.0);
            for ((a, b), c) in a.iter_mut().zip(&b).zip(&c) {
                *a = b + s * c;
            }
            black_box(&mut a);
        }
    });
    (24 * n * repeats) as f64 / seconds
}

/// Copies of a system beside each other.
fn copies<const D: usize>(problem: &Problem<D>, n: usize) -> Problem<D> {
    let mut all = Problem { bodies: n * problem.bodies, ..Problem::default() };
    for first in (0..n).map(|copy| (copy * problem.bodies) as u32) {
        all.pair.extend(problem.pair.iter().map(|[a, b]| [a + first, b + first]));
        all.jacobian.extend(&problem.jacobian);
        all.q.extend(&problem.q);
    }
    all
}

/// Prints the cost of the parts of an iteration of `pair_block_cg` with one thread.
fn iterations() {
    println!(
        "one thread; a product against the triad on arrays of the same size; the small problems against a product"
    );
    println!(
        "system                  rows  D  product, us  of the triad's time  proximal, us  project, us  of a product"
    );
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    one.install(|| {
        for (name, n) in
            [("colony1024_rec5", 1), ("colony1024_rec5", 4), ("colony4096_rec1", 1), ("colony1024_rec5", 40)]
        {
            iteration(name, &copies(&stored::<3>(&format!("tests/data/lcp/{name}")).0, n));
        }
        for (name, n) in [("compaction-last", 8), ("packing-last", 8), ("chainmail-last", 10), ("packing-last", 100)] {
            iteration(name, &copies(&stored::<6>(&format!("assets/lcps/{name}")).0, n));
        }
    });
}

fn iteration<const D: usize>(name: &str, problem: &Problem<D>) {
    let rows = problem.q.len();
    let mut cpu = Cpu::<D>::default();
    cpu.rebuild(problem);
    // Iterates, their gradients, and points beyond their projected steps, as the solver projects them.
    let mut gamma = vec![0.0; rows];
    let mut points = Vec::new();
    for _ in 0..6 {
        let mut solver = Solver::new(SolverKind::PairBlockCg, Settings { tolerance: 1e-12, max_iterations: 8 });
        solver.solve(problem, &mut gamma);
        let [mut x, mut g, mut next, mut beyond] = std::array::from_fn(|_| Vec::new());
        cpu.import(&gamma, &mut x);
        for vector in [&mut g, &mut next, &mut beyond] {
            cpu.clear(vector);
        }
        cpu.gradient(&x, &mut g);
        cpu.descend(&x, &g, &mut next);
        cpu.combine(1.2, &next, 0.0, &x, &mut beyond);
        points.push((x, g, beyond));
    }
    let (mut out, mut room) = (vec![0.0; rows], vec![0.0; rows]);
    let mut least = [0.0; 3];
    for (x, g, beyond) in &points {
        let calls = 200_000 / rows + 5;
        let mut other = vec![0.0; rows];
        least[0] += shortest(calls, || cpu.product(black_box(x), &mut out));
        // The step of the first iterate before each call: the blocks of this one are not those of the last call.
        let mut times = [f64::INFINITY; 2];
        for _ in 0..calls {
            cpu.descend(&points[0].0, &points[0].1, &mut other);
            times[0] = times[0].min(shortest(1, || cpu.descend(black_box(x), g, &mut out)));
            let terms = [(1.0, black_box(beyond)), (0.0, x), (0.0, x)];
            times[1] = times[1].min(shortest(1, || cpu.displace(x, terms, &mut out, &mut room)));
        }
        (least[1], least[2]) = (least[1] + times[0], least[2] + times[1]);
    }
    let [product, proximal, project] = least.map(|seconds| seconds / points.len() as f64);
    // Every block of J twice, x twice, the result once, the numbers of bodies twice, velocities twice.
    let bytes = rows * (2 * 2 * D * 8 + 2 * 8 + 8 + 2 * 8) + problem.bodies * 2 * D * 8;
    let limit = bytes as f64 / triad_of(bytes);
    println!(
        "{name:18} {rows:9}  {D}  {:11.0}  {:19.2}  {:12.0}  {:11.0}  {:12.2}",
        product * 1e6,
        product / limit,
        proximal * 1e6,
        project * 1e6,
        (proximal + project) / product
    );
}

/// A stored system and its start.
fn stored<const D: usize>(name: &str) -> (Problem<D>, Vec<f64>) {
    let path = format!("{}/{name}.npz", env!("CARGO_MANIFEST_DIR"));
    let (stored, _) = relcp::record::read_lcp(path.as_ref()).unwrap();
    (stored.problem().unwrap(), stored.start)
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
        let (problem, start) = stored::<3>(&format!("tests/data/lcp/{name}"));
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
