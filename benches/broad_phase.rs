//! Time a body of the search for touching boxes, from a thousand to a million bodies: the median and the least of several searches.
//!
//! `cargo bench --bench broad_phase` prints a table; `cargo bench --bench broad_phase -- 1000 100000` only those sizes.

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::broad_phase::{Aabb, BroadPhase, Grid};
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

/// A close-packed colony of rods in the plane, diameter 0.5, length between caps 1.5 to 3.5, at 85 % area fraction, bodies in random order.
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

/// Median and least time of a search in nanoseconds a body, and pairs a body.
fn measure(boxes: &[Aabb]) -> [f64; 3] {
    let mut grid = Grid::default();
    let mut pairs = Vec::new();
    let repeats = (3_000_000 / boxes.len()).clamp(7, 400);
    let mut times: Vec<f64> = (0..repeats)
        .map(|_| {
            let start = Instant::now();
            grid.pairs(boxes, &mut pairs);
            start.elapsed().as_secs_f64() * 1e9 / boxes.len() as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    [times[repeats / 2], times[0], pairs.len() as f64 / boxes.len() as f64]
}

type Scene = (&'static str, fn(usize, &mut ChaCha8Rng) -> Vec<Aabb>);

const SCENES: [Scene; 5] = [
    ("planar colony", colony),
    ("compact 3-D", |count, rng| ellipsoids(count, 0.6, rng)),
    ("dilute 3-D", |count, rng| ellipsoids(count, 0.0025, rng)),
    ("ring lattice", |count, _| rings(count)),
    ("mixed 1000:1", mixed),
];

fn main() {
    let mut sizes: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    if sizes.is_empty() {
        sizes = vec![1_000, 10_000, 100_000, 1_000_000];
    }
    println!("{} threads; nanoseconds a body", rayon::current_num_threads());
    println!("{:<14} {:>8} {:>8} {:>8} {:>11}", "scene", "bodies", "median", "least", "pairs/body");
    for (name, scene) in SCENES {
        let mut least = Vec::new();
        for &count in &sizes {
            let [median, lowest, pairs] = measure(&scene(count, &mut ChaCha8Rng::seed_from_u64(1)));
            println!("{name:<14} {count:>8} {median:>8.1} {lowest:>8.1} {pairs:>11.2}");
            least.push(lowest);
        }
        let ratio = least.iter().copied().fold(0.0, f64::max) / least.iter().copied().fold(f64::INFINITY, f64::min);
        println!("{name:<14} largest over smallest of the least times: {ratio:.2}");
    }
}
