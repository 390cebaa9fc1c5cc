//! Time per body of the search for touching boxes, from a thousand to a million bodies: processor time summed over
//! threads, the mean of several searches (Linux; it hardly depends on other load of the machine), and the shortest wall
//! time.
//!
//! A second table gives the cost of a candidate list as a function of its margin.
//!
//! `cargo bench --bench broad_phase` prints a table; `cargo bench --bench broad_phase -- 1000 100000` only those sizes.

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::internals::broad_phase::{Aabb, BroadPhase, Candidates, Grid};
use std::f64::consts::TAU;
use std::time::Instant;

/// A direction uniform on the sphere.
fn direction(rng: &mut ChaCha8Rng) -> DVec3 {
    let z = 2.0 * rng.random::<f64>() - 1.0;
    let angle = TAU * rng.random::<f64>();
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * angle.cos(), across * angle.sin(), z)
}

fn point(rng: &mut ChaCha8Rng) -> DVec3 {
    DVec3::new(rng.random::<f64>(), rng.random::<f64>(), rng.random::<f64>())
}

/// A close-packed colony of rods in the plane, diameter 0.5, length between caps 1.5 to 3.5, at 85 % area fraction,
/// bodies in random order.
fn colony(count: usize, rng: &mut ChaCha8Rng) -> Vec<Aabb> {
    let area = 0.5 * 2.5 + 0.25 * 0.785;
    let edge = (count as f64 * area / 0.85).sqrt();
    (0..count)
        .map(|_| {
            let angle = TAU * rng.random::<f64>();
            let half = DVec3::new(angle.cos().abs(), angle.sin().abs(), 0.0) * (0.75 + rng.random::<f64>());
            Aabb::from_centre(point(rng) * DVec3::new(edge, edge, 0.0), half + 0.25)
        })
        .collect()
}

/// Ellipsoids of radii (1, 1, 2) in all orientations that fill `fraction` of a cube.
fn ellipsoids(count: usize, fraction: f64, rng: &mut ChaCha8Rng) -> Vec<Aabb> {
    let edge = (count as f64 * TAU * 2.0 / 3.0 * 2.0 / fraction).cbrt();
    (0..count)
        .map(|_| {
            let axis = DQuat::from_rotation_arc(DVec3::Z, direction(rng)) * DVec3::Z;
            let half = DVec3::from_array(axis.to_array().map(|n| (1.0 + 3.0 * n * n).sqrt()));
            Aabb::from_centre(point(rng) * edge, half)
        })
        .collect()
}

/// Cubes with log-uniform edges over 1000 : 1 that fill 10 % of a cube.
fn mixed(count: usize, rng: &mut ChaCha8Rng) -> Vec<Aabb> {
    let halves: Vec<f64> = (0..count).map(|_| 1e3f64.powf(-rng.random::<f64>())).collect();
    let volume: f64 = halves.iter().map(|half| 8.0 * half.powi(3)).sum();
    let edge = (volume / 0.1).cbrt();
    halves.into_iter().map(|half| Aabb::from_centre(point(rng) * edge, DVec3::splat(half))).collect()
}

/// A square lattice of rings in two perpendicular orientations, in order.
fn rings(count: usize) -> Vec<Aabb> {
    let side = (count as f64).sqrt().ceil() as usize;
    (0..count)
        .map(|k| {
            let (i, j) = (k / side, k % side);
            let half = if (i + j) % 2 == 0 { DVec3::new(1.1, 1.1, 0.1) } else { DVec3::new(1.1, 0.1, 1.1) };
            Aabb::from_centre(DVec3::new(i as f64 * 1.2, j as f64 * 1.2, 0.0), half)
        })
        .collect()
}

/// Returns the nanoseconds that the threads of this process have run, if the system provides them.
fn processor_time() -> Option<f64> {
    let mut sum = 0.0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        sum += text.split_whitespace().next()?.parse::<f64>().ok()?;
    }
    Some(sum)
}

/// Returns processor time (NaN if unknown) and shortest wall time of a search in nanoseconds per body, and pairs per
/// body.
fn measure(boxes: &[Aabb]) -> [f64; 3] {
    let mut grid = Grid::default();
    let mut pairs = Vec::new();
    grid.pairs(boxes, &mut pairs);
    let repeats = (5_000_000 / boxes.len()).clamp(5, 1000);
    let before = processor_time();
    let mut least = f64::INFINITY;
    for _ in 0..repeats {
        let start = Instant::now();
        grid.pairs(boxes, &mut pairs);
        least = least.min(start.elapsed().as_secs_f64());
    }
    let spent = processor_time().zip(before).map_or(f64::NAN, |(after, before)| after - before);
    let bodies = boxes.len() as f64;
    [spent / (repeats as f64 * bodies), least * 1e9 / bodies, pairs.len() as f64 / bodies]
}

type Scene = (&'static str, fn(usize, &mut ChaCha8Rng) -> Vec<Aabb>);

const SCENES: [Scene; 5] = [
    ("planar colony", colony),
    ("compact 3-D", |count, rng| ellipsoids(count, 0.6, rng)),
    ("dilute 3-D", |count, rng| ellipsoids(count, 0.0025, rng)),
    ("ring lattice", |count, _| rings(count)),
    ("mixed 1000:1", mixed),
];

/// Returns processor nanoseconds per body and call of a candidate list while bodies drift by up to `pace` per call, the
/// fraction of calls that searched, and the ratio of the length of the last list to the number of touching pairs.
fn measure_candidates(mut candidates: Candidates, mut boxes: Vec<Aabb>, pace: f64) -> [f64; 3] {
    const CALLS: usize = 400;
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let drift: Vec<DVec3> = boxes.iter().map(|_| direction(&mut rng) * (pace * rng.random::<f64>())).collect();
    let (mut touching, mut spent) = (Vec::new(), 0.0);
    for _ in 0..CALLS {
        for (aabb, step) in boxes.iter_mut().zip(&drift) {
            *aabb = Aabb { min: aabb.min + *step, max: aabb.max + *step };
        }
        let before = processor_time();
        candidates.pairs(&boxes, &mut touching);
        spent += processor_time().zip(before).map_or(f64::NAN, |(after, before)| after - before);
    }
    let share = candidates.searches() as f64 / CALLS as f64;
    [spent / (CALLS * boxes.len()) as f64, share, candidates.ensure(&boxes).len() as f64 / touching.len() as f64]
}

/// Prints the cost and the benefit of the margin, for fixed fractions of a body's length (4) and for the margin that
/// the list chooses.
fn candidates_table() {
    const LENGTH: f64 = 4.0;
    println!("{:<14} {:>8} {:>9} {:>10} {:>9} {:>8}", "candidates", "pace", "margin", "processor", "searches", "list");
    for (name, scene) in &SCENES[..2] {
        for pace in [1e-4, 1e-3, 1e-2, 1e-1] {
            for fraction in [Some(0.0), Some(0.005), Some(0.02), Some(0.05), Some(0.1), Some(0.2), None] {
                let search = Box::<Grid>::default();
                let candidates = match fraction {
                    Some(fraction) => Candidates::with_margin(search, fraction * LENGTH),
                    None => Candidates::new(search),
                };
                let boxes = scene(8_000, &mut ChaCha8Rng::seed_from_u64(1));
                let [processor, searches, list] = measure_candidates(candidates, boxes, pace * LENGTH);
                let margin = fraction.map_or("chosen".to_owned(), |fraction| fraction.to_string());
                println!("{name:<14} {pace:>8} {margin:>9} {processor:>10.1} {searches:>9.3} {list:>8.2}");
            }
        }
    }
}

fn main() {
    let mut sizes: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    if sizes.is_empty() {
        sizes = vec![1_000, 10_000, 100_000, 1_000_000];
    }
    println!("{} threads; nanoseconds a body", rayon::current_num_threads());
    println!("{:<14} {:>8} {:>10} {:>8} {:>11}", "scene", "bodies", "processor", "clock", "pairs/body");
    for (name, scene) in SCENES {
        let mut times = Vec::new();
        for &count in &sizes {
            let [processor, clock, pairs] = measure(&scene(count, &mut ChaCha8Rng::seed_from_u64(1)));
            println!("{name:<14} {count:>8} {processor:>10.1} {clock:>8.1} {pairs:>11.2}");
            times.push(processor);
        }
        let ratio = times.iter().copied().fold(0.0, f64::max) / times.iter().copied().fold(f64::INFINITY, f64::min);
        println!("{name:<14} largest over smallest processor time: {ratio:.2}");
    }
    candidates_table();
}
