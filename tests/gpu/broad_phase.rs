//! The search on the device against testing every pair and against the CPU's grid.

use crate::device::{device, precisions};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::gpu::{Gpu, Precision};
use relcp::internals::broad_phase::gpu::Search;
use relcp::internals::broad_phase::{Aabb, BroadPhase, BruteForce, Grid};
use relcp::internals::gpu::{Buffer, Lattice};
use std::time::Instant;

/// How far apart boxes that are listed may be, in the sizes of the two.
pub const SLACK: f64 = 1e-5;

#[derive(Clone)]
pub struct Body {
    pub at: DVec3,
    pub half: DVec3,
    pub radius: f64,
}

impl Body {
    pub fn new(at: DVec3, half: DVec3) -> Self {
        Body { at, half, radius: half.length() }
    }

    pub fn aabb(&self, planar: bool) -> Aabb {
        match planar {
            true => Aabb::from_centre(self.at.with_z(0.0), self.half.with_z(0.0)),
            false => Aabb::from_centre(self.at, self.half),
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    pub pairs: Vec<[u32; 2]>,
    start: Vec<u32>,
    adjacency: Vec<u32>,
}

pub struct Uploaded {
    pub cell: Buffer,
    pub remainder: Buffer,
    pub boxes: Buffer,
    pub bodies: u64,
}

pub fn upload(gpu: &Gpu, precision: Precision, lattice: Lattice, bodies: &[Body]) -> Uploaded {
    let mut cells: Vec<i32> = Vec::new();
    let mut remainders = Vec::new();
    for body in bodies {
        let split = body.at.to_array().map(|x| lattice.split(x).unwrap());
        // The last words are not to be used.
        cells.extend(split.iter().map(|s| s.0).chain([-77]));
        remainders.extend(split.iter().map(|s| s.1).chain([f64::NAN]));
    }
    let boxes = bodies.iter().flat_map(|b| [b.half.x, b.half.y, b.half.z, b.radius]);
    Uploaded {
        cell: Buffer::with(gpu, "cell", 16, bytemuck::cast_slice(&cells)).unwrap(),
        remainder: Buffer::reals(gpu, "remainder", precision, 4, remainders).unwrap(),
        boxes: Buffer::reals(gpu, "boxes", precision, 4, boxes).unwrap(),
        bodies: bodies.len() as u64,
    }
}

pub fn search(gpu: &Gpu, search: &mut Search, input: &Uploaded) -> Found {
    search.run(gpu, &input.cell, &input.remainder, &input.boxes, input.bodies).unwrap();
    let count = search.count();
    let ranges = [
        (search.pairs(), 0..8 * count),
        (search.adjacency_start(), 0..4 * (input.bodies + 1)),
        (search.adjacency(), 0..8 * count),
    ];
    let read = gpu.record().read(&ranges).unwrap();
    let words = |k: usize| bytemuck::pod_collect_to_vec::<u8, u32>(&read[k]);
    Found { pairs: words(0).as_chunks().0.to_vec(), start: words(1), adjacency: words(2) }
}

/// The adjacency of pairs, from its definition.
pub fn assert_connected(found: &Found, bodies: usize) {
    let mut lists = vec![Vec::new(); bodies];
    for (pair, [a, b]) in (0u32..).zip(&found.pairs) {
        lists[*a as usize].push(2 * pair);
        lists[*b as usize].push(2 * pair + 1);
    }
    assert_eq!(found.start.len(), bodies + 1);
    for (body, list) in lists.iter().enumerate() {
        let range = found.start[body] as usize..found.start[body + 1] as usize;
        assert!(list[..] == found.adjacency[range.clone()], "body {body}: {list:?}, not {:?}", &found.adjacency[range]);
    }
    assert_eq!(found.start[bodies] as usize, 2 * found.pairs.len());
}

/// All pairs that touch must be there, each once, and none that is well apart.
fn assert_complete(found: &Found, bodies: &[Body], planar: bool) {
    let boxes: Vec<Aabb> = bodies.iter().map(|b| b.aabb(planar)).collect();
    let mut touching = Vec::new();
    if bodies.len() <= 1000 {
        BruteForce.pairs(&boxes, &mut touching)
    } else {
        Grid::default().pairs(&boxes, &mut touching)
    }
    let mut listed = found.pairs.clone();
    listed.sort_unstable();
    assert!(listed.iter().all(|[a, b]| a < b && (*b as usize) < bodies.len()));
    assert!(listed.is_sorted_by(|one, other| one < other), "a pair is listed twice");
    for pair in &touching {
        assert!(listed.binary_search(pair).is_ok(), "{pair:?} is missing of {} pairs", touching.len());
    }
    for [a, b] in listed.iter().map(|pair| pair.map(|k| &bodies[k as usize])) {
        let apart = (b.at - a.at).abs() - a.half - b.half;
        let apart = if planar { apart.truncate().max_element() } else { apart.max_element() };
        assert!(apart <= SLACK * (a.half + b.half).max_element(), "listed, but {apart} apart");
    }
}

fn check_on(gpu: &Gpu, precision: Precision, planar: bool, lattice: Lattice, bodies: &[Body]) -> Found {
    let mut finder = Search::new(gpu, precision, planar, lattice).unwrap();
    let input = upload(gpu, precision, lattice, bodies);
    let found = search(gpu, &mut finder, &input);
    assert_complete(&found, bodies, planar);
    assert_connected(&found, bodies.len());
    assert!(search(gpu, &mut finder, &input) == found, "a second run differs");
    found
}

/// Checks bodies in every precision, in space or in the plane.
fn check(planar: bool, thickness: f64, bodies: &[Body]) -> usize {
    let Some(gpu) = device() else { return 0 };
    let lattice = Lattice::for_thickness(thickness).unwrap();
    let mut counts = precisions(gpu).into_iter().map(|p| check_on(gpu, p, planar, lattice, bodies).pairs.len());
    counts.next().unwrap()
}

pub fn scattered(seed: u64, count: usize, span: DVec3, half: impl Fn(&mut ChaCha8Rng) -> DVec3) -> Vec<Body> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut body = |_| {
        let at = DVec3::from_array(std::array::from_fn(|_| rng.random::<f64>() - 0.5)) * span;
        Body::new(at, half(&mut rng))
    };
    (0..count).map(&mut body).collect()
}

pub fn any_half(rng: &mut ChaCha8Rng) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| 0.1 + 0.9 * rng.random::<f64>()))
}

fn rods(seed: u64, count: usize, room: f64) -> Vec<Body> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let side = (count as f64 * room).sqrt();
    let mut body = |_| {
        let (length, turn) = (2.0 + 2.0 * rng.random::<f64>(), std::f64::consts::TAU * rng.random::<f64>());
        let at = DVec3::new(rng.random::<f64>(), rng.random::<f64>(), 0.0) * side;
        let half = DVec3::new(turn.cos().abs(), turn.sin().abs(), 0.0) * (length / 2.0 - 0.5) + DVec3::splat(0.5);
        Body { at, half, radius: length / 2.0 }
    };
    (0..count).map(&mut body).collect()
}

#[test]
fn none_one_and_two() {
    let Some(gpu) = device() else { return };
    let unit = |x: f64| Body::new(DVec3::new(x, 0.0, 0.0), DVec3::splat(0.5));
    for planar in [false, true] {
        assert_eq!(check(planar, 1.0, &[]), 0);
        assert_eq!(check(planar, 1.0, &[unit(3.0)]), 0);
        assert_eq!(check(planar, 1.0, &[unit(0.0), unit(1.0)]), 1);
        assert_eq!(check(planar, 1.0, &[unit(0.0), unit(1.001)]), 0);
        assert_eq!(check(planar, 1.0, &[unit(-0.5), unit(0.5), unit(-1.501)]), 1);
    }
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let found = check_on(gpu, Precision::F32, false, lattice, &[unit(9.0), unit(1.0), unit(1.5)]);
    assert_eq!(found, Found { pairs: vec![[1, 2]], start: vec![0, 0, 1, 2], adjacency: vec![0, 1] });
}

#[test]
fn random_boxes_dense_and_sparse() {
    for (seed, span) in (1..).zip([2.0, 8.0, 20.0, 1000.0]) {
        for planar in [false, true] {
            let bodies = scattered(seed, 700, DVec3::splat(span), any_half);
            let count = check(planar, 0.2, &bodies);
            assert!(device().is_none() || count > 100 || span > 10.0, "{count} pairs");
        }
    }
    check(false, 0.2, &scattered(9, 6000, DVec3::splat(30.0), any_half));
    check(true, 0.2, &scattered(9, 6000, DVec3::splat(100.0), any_half));
}

#[test]
fn lattices_that_touch_exactly() {
    for origin in [0.0, -7.0, 293.0, 1e6] {
        let cell = |k: i32| {
            let index = DVec3::new(f64::from(k % 7), f64::from(k / 7 % 7), f64::from(k / 49));
            Body::new(index + origin, DVec3::splat(0.5))
        };
        let bodies: Vec<Body> = (0..343).map(cell).collect();
        // Of 7 cells in a row, 19 ordered pairs (a cell with itself counted) share a point.
        let count = check(false, 1.0, &bodies);
        assert!(device().is_none() || count == (19 * 19 * 19 - 343) / 2, "{count}");
    }
}

#[test]
fn extents_that_floats_do_not_hold_touch_where_they_do() {
    // Half extents, their sums and distances are all rounded: without slack many of these pairs would be lost.
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(0.2).unwrap();
    for offset in [0.0, 3e4] {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut x, mut bodies) = (offset, Vec::new());
        for _ in 0..500 {
            let half = 0.1 + 0.9 * rng.random::<f64>();
            bodies.push(Body::new(DVec3::new(x + half, 0.0, 0.0), DVec3::splat(half)));
            x += 2.0 * half;
        }
        assert_eq!(check_on(gpu, Precision::F32, false, lattice, &bodies).pairs.len(), 499);
        assert_eq!(check_on(gpu, Precision::F32, true, lattice, &bodies).pairs.len(), 499);
    }
}

#[test]
fn all_in_one_cell_and_all_alike() {
    let bodies = scattered(3, 300, DVec3::splat(0.01), |_| DVec3::splat(0.5));
    let count = check(false, 1.0, &bodies);
    assert!(device().is_none() || count == 300 * 299 / 2);
    check(true, 1.0, &vec![Body::new(DVec3::new(4.0, -3.0, 2.0), DVec3::splat(0.5)); 100]);
    // Points.
    check(false, 1.0, &vec![Body::new(DVec3::splat(1.0), DVec3::ZERO); 60]);
    check(false, 1.0, &scattered(4, 500, DVec3::splat(0.01), |_| DVec3::splat(1e-5)));
}

#[test]
fn lines_along_every_direction() {
    let one = DVec3::ONE;
    for direction in [DVec3::X, DVec3::Y, DVec3::Z, one.with_z(0.0), one, DVec3::new(-1.0, 1e-3, 2.0)] {
        let line = |k: i32| Body::new(direction * f64::from(k - 250), DVec3::splat(0.6));
        check(false, 1.0, &(0..500).map(line).collect::<Vec<_>>());
    }
}

#[test]
fn sizes_over_a_thousand_to_one() {
    let half = |rng: &mut ChaCha8Rng| DVec3::splat(10.0 * 1000f64.powf(-rng.random::<f64>()));
    check(false, 0.02, &scattered(5, 900, DVec3::splat(60.0), half));
    check(true, 0.02, &scattered(6, 900, DVec3::splat(300.0), half));
    // The finest are smaller than the lattice's cells.
    check(false, 20.0, &scattered(5, 900, DVec3::splat(60.0), half));
}

#[test]
fn one_giant_over_many() {
    let mut bodies = scattered(2, 5000, DVec3::splat(40.0), |_| DVec3::splat(0.7));
    bodies.insert(1000, Body::new(DVec3::splat(20.0), DVec3::splat(500.0)));
    bodies.push(Body::new(DVec3::new(-480.0, 0.0, 0.0), DVec3::splat(480.0)));
    bodies.push(Body::new(DVec3::new(1e5, 0.0, 0.0), DVec3::splat(1e5)));
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let found = check_on(gpu, Precision::F32, false, lattice, &bodies);
    assert!(found.start[1001] - found.start[1000] == 5002);
    check(true, 1.0, &bodies);
}

#[test]
fn far_from_the_origin() {
    // A pitch is 2^-10: 3e5 and 1e9 pitches off.
    for offset in [3e5 / 1024.0, 1e9 / 1024.0] {
        for sign in [DVec3::ONE, DVec3::new(-1.0, 1.0, -0.7)] {
            let mut bodies = scattered(7, 700, DVec3::splat(12.0), any_half);
            bodies.iter_mut().for_each(|b| b.at += sign * offset);
            // And some at the other end: their distance is as far as integers go.
            bodies.extend(
                scattered(8, 50, DVec3::splat(3.0), any_half)
                    .into_iter()
                    .map(|b| Body { at: b.at - sign * offset, ..b }),
            );
            check(false, 1.0, &bodies);
            check(true, 1.0, &bodies);
        }
    }
    let at = |x: f64, half: f64| Body::new(DVec3::new(x, 0.0, 0.0), DVec3::splat(half));
    assert!(check(false, 1.0, &[at(-1e6, 1e6), at(1e6, 1e6), at(1e6, 0.1)]) == 2 || device().is_none());
}

#[test]
fn boxes_that_are_no_boxes_touch_nothing() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    for precision in precisions(gpu) {
        let mut bodies = vec![Body::new(DVec3::ZERO, DVec3::splat(0.5)); 12];
        for (k, bad) in [f64::NAN, f64::INFINITY, -0.1, f64::NEG_INFINITY].into_iter().enumerate() {
            bodies[2 * k].half.y = bad;
        }
        // A radius that is none does not hide a box.
        bodies[9].radius = f64::NAN;
        bodies[10].radius = 0.0;
        let input = upload(gpu, precision, lattice, &bodies);
        let found = search(gpu, &mut Search::new(gpu, precision, false, lattice).unwrap(), &input);
        let mut listed = found.pairs.clone();
        listed.sort_unstable();
        let good = [1, 3, 5, 7, 8, 9, 10, 11];
        let expected: Vec<[u32; 2]> =
            good.iter().flat_map(|a| good.iter().filter(move |b| a < *b).map(move |b| [*a, *b])).collect();
        assert_eq!(listed, expected);
        assert_connected(&found, bodies.len());
    }
}

#[test]
fn says_what_it_cannot_do() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let mut finder = Search::new(gpu, Precision::F32, false, lattice).unwrap();
    let bodies = vec![Body::new(DVec3::ZERO, DVec3::splat(0.5)); 3];
    let far = upload(gpu, Precision::F32, lattice, &bodies);
    far.cell.write(gpu, 20, bytemuck::cast_slice(&[-(1i32 << 30)]));
    let refused = finder.run(gpu, &far.cell, &far.remainder, &far.boxes, 3).unwrap_err();
    assert!(refused.to_string().contains("far from the origin"), "{refused}");
    assert_eq!(finder.count(), 0);
    // It is none the worse for it.
    let found = search(gpu, &mut finder, &upload(gpu, Precision::F32, lattice, &bodies));
    assert_eq!(found.pairs.len(), 3);
    // More about one body than a loop can count. They touch nothing, so that this is quick.
    let mut bodies = vec![Body::new(DVec3::ZERO, DVec3::new(1e-4, 0.5, 0.5)); 62_000];
    for (k, body) in bodies.iter_mut().enumerate() {
        body.at.x = 0.9 * k as f64 / 62_000.0;
    }
    let crowd = upload(gpu, Precision::F32, lattice, &bodies);
    let refused = finder.run(gpu, &crowd.cell, &crowd.remainder, &crowd.boxes, 62_000).unwrap_err();
    assert!(refused.to_string().contains("60,000 boxes"), "{refused}");
}

#[test]
fn growth_changes_nothing() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(0.2).unwrap();
    let small = upload(gpu, Precision::F32, lattice, &scattered(1, 20, DVec3::splat(3.0), any_half));
    let large = upload(gpu, Precision::F32, lattice, &scattered(2, 3000, DVec3::splat(12.0), any_half));
    let run = |capacity: u64, inputs: &[&Uploaded]| {
        gpu.set_least_capacity(capacity);
        let mut finder = Search::new(gpu, Precision::F32, false, lattice).unwrap();
        let found: Vec<Found> = inputs.iter().map(|input| search(gpu, &mut finder, input)).collect();
        gpu.set_least_capacity(1024);
        found
    };
    let ample = run(1 << 20, &[&large, &small]);
    let grown = run(16, &[&small, &large, &small]);
    assert!(ample[0].pairs.len() > 10_000 && !ample[1].pairs.is_empty());
    assert!(ample[0] == grown[1] && ample[1] == grown[0] && ample[1] == grown[2]);
    // A table of another size must not show in the order of the pairs, either.
    let mut more = scattered(2, 3000, DVec3::splat(12.0), any_half);
    more.extend((0..2000).map(|k| Body::new(DVec3::new(100.0 + 3.0 * f64::from(k), 0.0, 0.0), DVec3::splat(0.5))));
    let more = run(16, &[&upload(gpu, Precision::F32, lattice, &more)]);
    assert!(more[0].pairs == ample[0].pairs);
}

/// Loose spheres in space.
fn spheres(seed: u64, count: usize, room: f64) -> Vec<Body> {
    let span = DVec3::splat((count as f64 * room).cbrt());
    let bodies = scattered(seed, count, span, |rng| DVec3::splat(0.5 + 0.1 * rng.random::<f64>()));
    bodies.into_iter().map(|body| Body { radius: body.half.x, ..body }).collect()
}

#[test]
fn many_bodies() {
    let Some(gpu) = device() else { return };
    let scenes = [
        ("rods", true, rods(11, 10_000, 3.0)),
        ("rods", true, rods(11, 100_000, 3.0)),
        ("spheres", false, spheres(12, 100_000, 1.5)),
    ];
    for (name, planar, bodies) in scenes {
        let (lattice, count) = (Lattice::for_thickness(1.0).unwrap(), bodies.len());
        let mut finder = Search::new(gpu, Precision::F32, planar, lattice).unwrap();
        let input = upload(gpu, Precision::F32, lattice, &bodies);
        let begun = Instant::now();
        let found = search(gpu, &mut finder, &input);
        let first = begun.elapsed().as_secs_f64();
        assert_complete(&found, &bodies, planar);
        assert_connected(&found, count);
        let before = gpu.counters();
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let begun = Instant::now();
            finder.run(gpu, &input.cell, &input.remainder, &input.boxes, count as u64).unwrap();
            gpu.wait().unwrap();
            best = best.min(begun.elapsed().as_secs_f64());
        }
        let dispatches = (gpu.counters().dispatches - before.dispatches) / 3;
        let (first, best) = (1e3 * first, 1e3 * best);
        let pairs = found.pairs.len();
        println!("{count} {name}, {pairs} pairs: {best:.1} ms ({first:.1} the first time), {dispatches} dispatches");
    }
}
