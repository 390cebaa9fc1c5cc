//! The search of periodic space on the device against testing every pair with every image.

use crate::broad_phase::{Body, Found, SLACK, any_half, assert_connected, scattered, search, upload};
use crate::device::{device, precisions};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::gpu::{Gpu, GpuError, Precision};
use relcp::internals::broad_phase::gpu::Search;
use relcp::internals::broad_phase::{Aabb, BroadPhase, Grid, Periodic, PeriodicBruteForce};
use relcp::internals::gpu::{Lattice, LatticePeriods};
use relcp::periodic::{Axis, Periods, Tilt};
use std::time::Instant;

type Lengths = [Option<f64>; 3];

/// All pairs that touch through some image, each once, none that is well apart, each body's in the order of the others.
fn assert_complete(found: &Found, bodies: &[Body], planar: bool, lengths: Lengths) -> usize {
    assert_complete_in(found, bodies, planar, Periods::new(lengths))
}

fn assert_complete_in(found: &Found, bodies: &[Body], planar: bool, periods: Periods) -> usize {
    let lengths = periods.lengths();
    let boxes: Vec<Aabb> = bodies.iter().map(|b| b.aabb(planar)).collect();
    let mut touching = Vec::new();
    if bodies.len() <= 1000 {
        PeriodicBruteForce { periods }.pairs(&boxes, &mut touching)
    } else {
        Periodic::new(Grid::default(), periods).pairs(&boxes, &mut touching)
    }
    let mut listed = found.pairs.clone();
    listed.sort_unstable();
    assert!(listed.iter().all(|[a, b]| a < b && (*b as usize) < bodies.len()));
    assert!(listed.is_sorted_by(|one, other| one < other), "{lengths:?}: a pair is listed twice");
    for pair in &touching {
        assert!(listed.binary_search(pair).is_ok(), "{lengths:?}: {pair:?} is missing of {} pairs", touching.len());
    }
    for [a, b] in listed.iter().map(|pair| pair.map(|k| &bodies[k as usize])) {
        let apart = periods.nearest(b.at - a.at).abs() - a.half - b.half;
        let apart = if planar { apart.truncate().max_element() } else { apart.max_element() };
        assert!(apart <= SLACK * (a.half + b.half).max_element(), "{lengths:?}: listed, but {apart} apart");
    }
    touching.len()
}

fn check_on(
    gpu: &Gpu,
    precision: Precision,
    planar: bool,
    (lattice, lengths): (Lattice, Lengths),
    bodies: &[Body],
) -> (Found, usize) {
    let mut finder = Search::in_space(gpu, precision, planar, lattice, (lengths, false)).unwrap();
    let input = upload(gpu, precision, lattice, bodies);
    let found = search(gpu, &mut finder, &input);
    let count = assert_complete(&found, bodies, planar, lengths);
    assert_connected(&found, bodies.len());
    assert!(search(gpu, &mut finder, &input) == found, "a second run differs");
    (found, count)
}

/// Checks bodies in every precision, and returns how many pairs touch.
fn check(planar: bool, thickness: f64, lengths: Lengths, bodies: &[Body]) -> usize {
    let Some(gpu) = device() else { return 0 };
    let lattice = Lattice::for_thickness(thickness).unwrap();
    let mut counts = precisions(gpu).into_iter().map(|p| check_on(gpu, p, planar, (lattice, lengths), bodies).1);
    counts.next().unwrap()
}

/// One, two and three periodic axes; what is along z does not count in the plane.
fn cells(length: f64) -> [Lengths; 6] {
    let [x, y, z] = [1.0, 1.3, 0.77].map(|part| Some(part * length));
    [[x, None, None], [None, y, None], [None, None, z], [x, y, None], [None, y, z], [x, y, z]]
}

/// A sheared cell, in which the offset changes from search to search.
#[test]
fn boxes_in_a_sheared_cell() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(0.2).unwrap();
    let lengths = [Some(12.3), Some(10.1), Some(9.7)];
    for (planar, direction, gradient) in
        [(true, Axis::X, Axis::Y), (false, Axis::X, Axis::Z), (false, Axis::Y, Axis::Z)]
    {
        let space = Periods::new(if planar { [lengths[0], lengths[1], None] } else { lengths });
        for precision in precisions(gpu) {
            let at = |offset: f64| space.tilted(Tilt { direction, gradient, offset });
            let periods = LatticePeriods::of(lattice, at(0.0).numbers()).unwrap();
            let mut finder = Search::among(gpu, precision, planar, (lattice, periods, true)).unwrap();
            for (seed, span) in (0..).zip([12.0, 300.0]) {
                let bodies = scattered(seed, 300, DVec3::splat(span), any_half);
                let input = upload(gpu, precision, lattice, &bodies);
                for offset in [0.0, 1.7, -4.4] {
                    finder.set_periods(LatticePeriods::of(lattice, at(offset).numbers()).unwrap());
                    let found = search(gpu, &mut finder, &input);
                    let count = assert_complete_in(&found, &bodies, planar, at(offset));
                    assert_connected(&found, bodies.len());
                    assert!(count > 100, "{count}");
                }
            }
        }
    }
}

#[test]
fn small_mixed_and_long_boxes_on_one_two_and_three_axes() {
    for (k, lengths) in (0..).zip(cells(37.0 / 3.0)) {
        // Within a cell, and over many.
        for span in [12.0, 300.0] {
            let bodies = scattered(k, 300, DVec3::splat(span), any_half);
            let long = |rng: &mut ChaCha8Rng| {
                let mut half = DVec3::splat(0.2);
                half[rng.random_range(0..3)] += 2.5 * rng.random::<f64>();
                half
            };
            let rods = scattered(10 + k, 300, DVec3::splat(span), long);
            for planar in [false, true].into_iter().filter(|planar| !(*planar && lengths[2].is_some())) {
                check(planar, 0.2, lengths, &bodies);
                let count = check(planar, 0.2, lengths, &rods);
                let all = lengths.iter().flatten().count() == if planar { 2 } else { 3 };
                assert!(device().is_none() || count > 100 || !all, "{count}");
            }
        }
    }
}

#[test]
fn sizes_over_a_thousand_to_one() {
    let half = |rng: &mut ChaCha8Rng| DVec3::splat(4.0 * 1000f64.powf(-rng.random::<f64>()));
    for lengths in cells(20.0) {
        check(false, 0.02, lengths, &scattered(5, 400, DVec3::splat(60.0), half));
        // The finest are smaller than the lattice's cells.
        check(false, 7.0, lengths, &scattered(6, 400, DVec3::splat(60.0), half));
    }
    check(true, 0.02, cells(20.0)[3], &scattered(7, 400, DVec3::splat(60.0), half));
}

/// A pair may touch through several images: it is listed once.
#[test]
fn boxes_of_half_a_period_and_more() {
    let lengths = [Some(10.0), Some(12.9), Some(8.1)];
    for (seed, part) in (0..).zip([0.24, 0.26, 0.49, 0.51, 0.7, 1.3]) {
        let half = |rng: &mut ChaCha8Rng| {
            let cell = DVec3::new(10.0, 12.9, 8.1);
            let wide = DVec3::from_array(std::array::from_fn(|_| if rng.random::<bool>() { part } else { 0.02 }));
            cell * wide * (0.98 + 0.02 * rng.random::<f64>())
        };
        let bodies = scattered(seed, 150, DVec3::splat(50.0), half);
        let count = check(false, 0.1, lengths, &bodies);
        check(true, 0.1, [lengths[0], None, None], &bodies);
        assert!(device().is_none() || count > 150);
    }
    // The shortest period that there may be, of 2048 pitches.
    let bodies = scattered(9, 100, DVec3::splat(9.0), |rng| DVec3::splat(0.1 + 0.5 * rng.random::<f64>()));
    check(false, 1.0, [Some(2.0), Some(2.0), None], &bodies);
    check(true, 1.0, [None, Some(2.0), None], &bodies);
}

#[test]
fn faces_that_touch_through_boundaries() {
    let Some(gpu) = device() else { return };
    // Unit boxes that fill a cell: each touches 26 others, through faces, edges and corners.
    for origin in [0.0, -3.0, 1e5, 0.25] {
        let lengths = [Some(6.0), Some(5.0), Some(4.0)];
        let place = |k: i32| {
            let index = DVec3::new(f64::from(k % 6), f64::from(k / 6 % 5), f64::from(k / 30));
            let cells = DVec3::new(f64::from(k % 3), f64::from(k % 5), f64::from(-(k % 2)));
            Body::new(index + origin + DVec3::new(6.0, 5.0, 4.0) * cells, DVec3::splat(0.5))
        };
        let bodies: Vec<Body> = (0..120).map(place).collect();
        let lattice = Lattice::for_thickness(1.0).unwrap();
        for precision in precisions(gpu) {
            let (found, _) = check_on(gpu, precision, false, (lattice, lengths), &bodies);
            assert_eq!(found.pairs.len(), 120 * 26 / 2, "{origin}");
        }
    }
    // At the boundary to rounding, on either side of it.
    let period = 7.0 / 3.0;
    let at = |x: f64| Body::new(DVec3::new(x, 0.0, 0.0), DVec3::splat(0.3));
    let edges =
        [0.0, 1e-17, -1e-17, period, -period, period - 1e-12, 3.0 * period, 2.0 * period - 1e-9, 1e6 * period / 3.0];
    let bodies: Vec<Body> = edges.into_iter().map(at).collect();
    assert_eq!(check(true, 1.0, [Some(period), None, None], &bodies), 28);
}

/// Boxes of a few lattice cells and less, about the boundary: the first and the last cells of the grid share columns of
/// a table so small, and wrapped cells are lattice cells off.
#[test]
fn boxes_as_small_as_lattice_cells() {
    let pitch = Lattice::for_thickness(1.0).unwrap().pitch();
    for (seed, cells) in (20..).zip([2048.3, 2049.9, 2111.6, 4096.5]) {
        let period = cells * pitch;
        for size in [0.5, 4.0] {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut draw = || random.random::<f64>();
            let body = |_| {
                let at = DVec3::new(draw(), draw(), draw()) - 0.5;
                let turns = DVec3::new(draw(), draw(), draw()) * 40.0 - 20.0;
                let half = DVec3::splat(size * draw() * pitch);
                Body::new(turns.round() * period + at * 8.0 * pitch, half)
            };
            let bodies: Vec<Body> = (0..60).map(body).collect();
            let count = check(false, 1.0, [Some(period); 3], &bodies);
            assert!(device().is_none() || count > 20 || size < 1.0, "{size}: {count}");
            check(true, 1.0, [Some(period), None, None], &bodies);
        }
    }
}

/// Points at images of one place: they touch, though wrapping leaves their lattice cells up to two apart and rounds
/// their remainders.
#[test]
fn points_at_images_of_one_place() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(31);
    let mut draw = || DVec3::from(random.random::<[f64; 3]>());
    for period in [10.0 / 3.0, 2.0006, 7.7] {
        let place = period * draw();
        let point = |_| Body::new(place + ((draw() - 0.5) * 1e5).round() * period, DVec3::ZERO);
        let bodies: Vec<Body> = (0..60).map(point).collect();
        let mut finder = Search::in_space(gpu, Precision::F32, false, lattice, ([Some(period); 3], false)).unwrap();
        let found = search(gpu, &mut finder, &upload(gpu, Precision::F32, lattice, &bodies));
        assert_eq!(found.pairs.len(), 60 * 59 / 2);
    }
}

#[test]
fn far_outside_of_the_cell() {
    for lengths in cells(9.7) {
        for (seed, span) in (0..).zip([1e4, 2e6]) {
            check(false, 1.0, lengths, &scattered(seed, 250, DVec3::splat(span), any_half));
        }
    }
}

/// A body's pairs stand in the order of the other bodies, so that it does not matter where the cell begins.
#[test]
fn the_list_does_not_depend_on_where_the_cell_is() {
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(0.2).unwrap();
    let lengths = [Some(10.0 / 3.0 * 4.0), Some(14.3), None];
    let half = |rng: &mut ChaCha8Rng| any_half(rng) * if rng.random::<f64>() < 0.1 { 3.0 } else { 1.0 };
    let bodies = scattered(3, 600, DVec3::splat(30.0), half);
    for precision in precisions(gpu) {
        let (here, _) = check_on(gpu, precision, false, (lattice, lengths), &bodies);
        for cells in [DVec3::new(1.0, 77.0, -5.0), DVec3::new(123_456.0, -9_876_543.0, 54_321.0)] {
            let mut moved = bodies.clone();
            moved.iter_mut().for_each(|body| body.at += cells * lattice.pitch());
            let (there, _) = check_on(gpu, precision, false, (lattice, lengths), &moved);
            assert!(there == here, "{precision:?} {cells}");
        }
    }
}

#[test]
fn crowds_giants_and_boxes_that_are_none() {
    let lengths = [Some(12.0), Some(12.0), Some(12.0)];
    let crowd = scattered(3, 300, DVec3::splat(0.01), |_| DVec3::splat(0.5));
    assert_eq!(check(false, 1.0, lengths, &crowd), if device().is_some() { 300 * 299 / 2 } else { 0 });
    let mut bodies = scattered(2, 3000, DVec3::splat(12.0), |_| DVec3::splat(0.25));
    bodies.insert(1000, Body::new(DVec3::splat(5.0), DVec3::splat(500.0)));
    bodies.push(Body::new(DVec3::splat(-6.0), DVec3::splat(2.9)));
    check(false, 0.5, lengths, &bodies);
    let Some(gpu) = device() else { return };
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let mut finder = Search::in_space(gpu, Precision::F32, false, lattice, (lengths, false)).unwrap();
    let mut bodies = vec![Body::new(DVec3::ZERO, DVec3::splat(0.5)); 6];
    for (k, bad) in [f64::NAN, f64::INFINITY, -0.1].into_iter().enumerate() {
        bodies[2 * k].half.y = bad;
        bodies[2 * k + 1].at.x = 12.0 * k as f64;
    }
    let found = search(gpu, &mut finder, &upload(gpu, Precision::F32, lattice, &bodies));
    assert_eq!(found.pairs, [[1, 3], [1, 5], [3, 5]]);
    // One too far out is refused, as in open space.
    let far = upload(gpu, Precision::F32, lattice, &bodies);
    far.cell.write(gpu, 20, bytemuck::cast_slice(&[-(1i32 << 30)]));
    let refused = finder.run(gpu, &far.cell, &far.remainder, &far.boxes, 6).unwrap_err();
    assert!(refused.to_string().contains("far from the origin"), "{refused}");
    let short = Search::in_space(gpu, Precision::F32, false, lattice, ([Some(1.9), None, None], false)).err();
    assert!(matches!(short, Some(GpuError::Unsupported { .. })));
}

#[test]
fn many_bodies() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let side = 245.0;
    let mut rod = |_| {
        let (length, turn) = (2.0 + 2.0 * random.random::<f64>(), std::f64::consts::TAU * random.random::<f64>());
        let at = DVec3::new(random.random::<f64>(), random.random::<f64>(), 0.0) * 3.0 * side;
        let half = DVec3::new(turn.cos().abs(), turn.sin().abs(), 0.0) * (length / 2.0 - 0.5) + DVec3::splat(0.5);
        Body { at, half, radius: length / 2.0 }
    };
    let bodies: Vec<Body> = (0..20_000).map(&mut rod).collect();
    let count = check(true, 1.0, [Some(side), Some(side), None], &bodies);
    println!("{count} pairs of 20000 rods");
    let Some(gpu) = device() else { return };
    assert!(count > 50_000);
    let lattice = Lattice::for_thickness(1.0).unwrap();
    let wrapped: Vec<Body> = bodies
        .iter()
        .map(|body| Body { at: Periods::new([Some(side); 3]).wrapped(body.at).0, ..body.clone() })
        .collect();
    for lengths in [[None; 3], [Some(side), Some(side), None]] {
        let mut finder = Search::in_space(gpu, Precision::F32, true, lattice, (lengths, false)).unwrap();
        let input = upload(gpu, Precision::F32, lattice, &wrapped);
        let mut best = f64::INFINITY;
        for _ in 0..4 {
            let begun = Instant::now();
            finder.run(gpu, &input.cell, &input.remainder, &input.boxes, input.bodies).unwrap();
            gpu.wait().unwrap();
            best = best.min(begun.elapsed().as_secs_f64());
        }
        println!("{lengths:?}: {} pairs in {:.1} ms", finder.count(), 1e3 * best);
    }
}
