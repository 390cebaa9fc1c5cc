//! Searches of periodic space against testing every pair with every image that could touch.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::internals::broad_phase::{Aabb, BroadPhase, BruteForce, Candidates, Grid, Periodic, PeriodicBruteForce};
use relcp::periodic::{Axis, Periods, Tilt};

/// Pairs found by moving each second box by every number of periods up to `most`: it knows nothing of the periods's own
/// arithmetic.
fn by_moving(boxes: &[Aabb], lengths: [Option<f64>; 3], most: i32) -> Vec<[u32; 2]> {
    let moves = |axis: usize| if lengths[axis].is_some() { -most..=most } else { 0..=0 };
    let length = DVec3::from(lengths.map(|length| length.unwrap_or(0.0)));
    let mut pairs = Vec::new();
    for (a, first) in boxes.iter().enumerate() {
        for (b, second) in boxes.iter().enumerate().skip(a + 1) {
            let touches = moves(0).any(|x| {
                moves(1).any(|y| {
                    moves(2).any(|z| {
                        let by = length * DVec3::new(x.into(), y.into(), z.into());
                        first.touches(&Aabb { min: second.min + by, max: second.max + by })
                    })
                })
            });
            if touches {
                pairs.push([a as u32, b as u32]);
            }
        }
    }
    pairs
}

fn pairs_of(mut search: impl BroadPhase, boxes: &[Aabb]) -> Vec<[u32; 2]> {
    let mut pairs = vec![[7, 7]];
    search.pairs(boxes, &mut pairs);
    pairs
}

/// Boxes on multiples of 1/64, so that moves by the periods below are exact; of a size, long along one axis, and over
/// `cells` cells each way.
fn scattered(seed: u64, count: usize, half: f64, long: f64, cells: f64) -> Vec<Aabb> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |scale: f64| (scale * 64.0 * random.random::<f64>()).round() / 64.0;
    (0..count)
        .map(|k| {
            let centre = DVec3::new(draw(16.0 * cells), draw(8.0 * cells), draw(4.0 * cells)) - 4.0 * cells;
            let mut sides = DVec3::new(draw(half), draw(half), draw(half));
            sides[k % 3] += draw(long);
            Aabb::from_centre(centre, sides)
        })
        .collect()
}

const CELLS: [[Option<f64>; 3]; 5] = [
    [Some(16.0), Some(8.0), Some(4.0)],
    [Some(16.0), None, None],
    [None, Some(8.0), Some(4.0)],
    [None, None, Some(4.0)],
    [None; 3],
];

#[test]
fn every_search_finds_the_pairs_that_some_image_makes_touch() {
    let mut through = 0;
    for (k, lengths) in CELLS.into_iter().enumerate() {
        let periods = Periods::new(lengths);
        // Small, mixed and long bodies; the last are longer than some periods.
        for (half, long, cells) in [(0.75, 0.0, 1.0), (0.5, 1.0, 1.0), (0.5, 1.0, 3.0), (0.25, 3.5, 2.0)] {
            let boxes = scattered(k as u64, 120, half, long, cells);
            let expected = by_moving(&boxes, lengths, 6);
            let what = format!("{lengths:?}, {half}, {long}, {cells}");
            assert_eq!(pairs_of(PeriodicBruteForce { periods }, &boxes), expected, "{what}");
            assert_eq!(pairs_of(Periodic::new(Grid::default(), periods), &boxes), expected, "{what}");
            assert_eq!(pairs_of(Periodic::new(BruteForce, periods), &boxes), expected, "{what}");
            assert_eq!(pairs_of(Candidates::in_space(periods), &boxes), expected, "{what}");
            through += expected.len() - pairs_of(BruteForce, &boxes).len();
        }
    }
    assert!(through > 150, "{through} pairs through a boundary");
}

/// Searches of a sheared cell, against moves of each second box by every whole vector of the cell.
#[test]
fn every_search_of_a_sheared_cell_finds_the_pairs_that_some_image_makes_touch() {
    let lengths = [Some(16.0), Some(8.0), Some(4.0)];
    let mut through = 0;
    for (k, (direction, gradient)) in (0..).zip([(Axis::X, Axis::Y), (Axis::X, Axis::Z), (Axis::Y, Axis::Z)]) {
        for offset in [0.75, -1.25, 2.0] {
            let periods = Periods::new(lengths).tilted(Tilt { direction, gradient, offset });
            assert_eq!(periods.tilt().unwrap().offset, offset);
            for (half, long, cells) in [(0.75, 0.0, 1.0), (0.5, 1.0, 3.0), (0.25, 3.5, 2.0)] {
                let boxes = scattered(k, 60, half, long, cells);
                let mut expected = Vec::new();
                for (a, first) in boxes.iter().enumerate() {
                    for (b, second) in boxes.iter().enumerate().skip(a + 1) {
                        let touches = (-6..=6).any(|x| {
                            (-4..=4).any(|y| {
                                (-4..=4).any(|z| {
                                    let n = DVec3::new(x.into(), y.into(), z.into());
                                    let by = DVec3::new(16.0, 8.0, 4.0) * n
                                        + offset * n[gradient.index()] * direction.unit();
                                    first.touches(&Aabb { min: second.min + by, max: second.max + by })
                                })
                            })
                        });
                        if touches {
                            expected.push([a as u32, b as u32]);
                        }
                    }
                }
                let what = format!("{direction:?}, {gradient:?}, {offset}, {half}, {long}, {cells}");
                assert_eq!(pairs_of(PeriodicBruteForce { periods }, &boxes), expected, "{what}");
                assert_eq!(pairs_of(Periodic::new(Grid::default(), periods), &boxes), expected, "{what}");
                assert_eq!(pairs_of(Candidates::in_space(periods), &boxes), expected, "{what}");
                let untilted = pairs_of(PeriodicBruteForce { periods: Periods::new(lengths) }, &boxes);
                through += expected.iter().filter(|pair| !untilted.contains(pair)).count();
            }
        }
    }
    assert!(through > 30, "{through} pairs through the offset alone");
}

/// A whole vector of a sheared cell changes no image, and one period more of the offset neither.
#[test]
fn images_of_a_sheared_cell_are_nearest_and_a_flip_changes_none() {
    let lengths = [Some(7.1), Some(5.3), Some(6.2)];
    let mut random = ChaCha8Rng::seed_from_u64(8);
    for (direction, gradient) in [(Axis::X, Axis::Y), (Axis::X, Axis::Z), (Axis::Y, Axis::Z)] {
        for _ in 0..300 {
            let mut draw = || random.random::<f64>() - 0.5;
            let tilt = Tilt { direction, gradient, offset: 40.0 * draw() };
            let periods = Periods::new(lengths).tilted(tilt);
            let flipped = Periods::new(lengths)
                .tilted(Tilt { offset: tilt.offset + 3.0 * lengths[direction.index()].unwrap(), ..tilt });
            let delta = 50.0 * DVec3::new(draw(), draw(), draw());
            let near = periods.nearest(delta);
            assert!((delta + periods.shift(periods.nearest_image(delta)) - near).length() < 1e-12);
            let half = 0.5 * periods.length();
            assert!(near.abs().cmple(half + 1e-12).all(), "{near}");
            // At a side either image is nearest.
            if (near.abs() - half).abs().min_element() > 1e-9 {
                assert!((flipped.nearest(delta) - near).length() < 1e-12);
                let away = periods.shift(glam::I64Vec3::new(2, -3, 1));
                assert!((periods.nearest(delta + away) - near).length() < 1e-12);
            }
            let (place, image) = periods.wrapped(delta);
            assert!((place + periods.shift(image) - delta).length() < 1e-12 && place.abs().cmple(half + 1e-12).all());
        }
    }
}

#[test]
fn boxes_that_touch_through_a_face_an_edge_and_a_corner_only() {
    let periods = Periods::new([Some(8.0); 3]);
    let at = |x: f64, y: f64, z: f64| Aabb::from_centre(DVec3::new(x, y, z), DVec3::splat(0.5));
    for [x, y, z] in [[7.0, 0.0, 0.0], [7.0, -7.0, 0.0], [7.0, 7.0, 7.0], [-1.0, 9.0, 8007.0]] {
        let boxes = [at(0.0, 0.0, 0.0), at(x, y, z)];
        assert_eq!(pairs_of(Periodic::new(Grid::default(), periods), &boxes), [[0, 1]]);
        let apart = [boxes[0], at(x - 0.25, y, z)];
        assert_eq!(pairs_of(Periodic::new(Grid::default(), periods), &apart), [[0u32; 2]; 0], "{x} {y} {z}");
        assert_eq!(pairs_of(PeriodicBruteForce { periods }, &apart), [[0u32; 2]; 0]);
    }
}

#[test]
fn searches_agree_where_periods_are_not_round_and_the_cell_is_anywhere() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for period in [3.1, 7.0 / 3.0, 1e3 / 7.0] {
        let periods = Periods::new([Some(period), Some(1.7 * period), Some(0.9 * period)]);
        for origin in [0.0, -0.37, 1e3, -1e6] {
            let mut boxes = Vec::new();
            for _ in 0..300 {
                let mut draw = || DVec3::from(random.random::<[f64; 3]>());
                let centre = DVec3::splat(origin) + 3.0 * period * draw();
                boxes.push(Aabb::from_centre(centre, 0.12 * period * draw()));
            }
            let expected = pairs_of(PeriodicBruteForce { periods }, &boxes);
            assert!(expected.len() > 300);
            assert_eq!(pairs_of(Periodic::new(Grid::default(), periods), &boxes), expected, "{period} {origin}");
        }
    }
}

#[test]
fn many_boxes_are_searched_in_parallel_to_the_same_pairs() {
    let periods = Periods::new([Some(40.0), Some(40.0), None]);
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let mut draw = || DVec3::from(random.random::<[f64; 3]>());
    let boxes: Vec<Aabb> =
        (0..4200).map(|_| Aabb::from_centre(40.0 * draw() * DVec3::new(1.0, 1.0, 0.5), 0.4 + draw())).collect();
    let found = pairs_of(Periodic::new(Grid::default(), periods), &boxes);
    assert!(found.len() > 4_000 && found.is_sorted_by(|one, other| one < other));
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one_thread.install(|| pairs_of(Periodic::new(Grid::default(), periods), &boxes)), found);
    assert_eq!(pairs_of(PeriodicBruteForce { periods }, &boxes), found);
}

#[test]
fn a_kept_list_holds_all_pairs_while_bodies_drift_through_cells_and_jump() {
    let periods = Periods::new([Some(6.3), None, Some(4.9)]);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut draw = || DVec3::from(random.random::<[f64; 3]>());
    let mut centres: Vec<DVec3> = (0..80).map(|_| DVec3::new(6.3, 5.0, 4.9) * draw()).collect();
    let drift: Vec<DVec3> = centres.iter().map(|_| 0.02 * (draw() - 0.3)).collect();
    let half: Vec<DVec3> = centres.iter().map(|_| 0.1 + 0.5 * draw()).collect();
    let mut kept = Candidates::in_space(periods);
    for call in 0..400 {
        if call == 200 {
            // Some go on from a thousand cells away.
            centres.iter_mut().step_by(3).for_each(|x| *x += DVec3::new(6.3e3, 0.0, -4.9e3));
        }
        let boxes: Vec<Aabb> = centres.iter().zip(&half).map(|(x, half)| Aabb::from_centre(*x, *half)).collect();
        let expected = pairs_of(PeriodicBruteForce { periods }, &boxes);
        let listed = kept.ensure(&boxes);
        assert!(expected.iter().all(|pair| listed.binary_search(pair).is_ok()), "call {call}");
        let mut exactly = Vec::new();
        kept.pairs(&boxes, &mut exactly);
        assert_eq!(exactly, expected, "call {call}");
        centres.iter_mut().zip(&drift).for_each(|(x, by)| *x += *by);
    }
    assert!(kept.reuses() > 4 * kept.searches(), "{} reuses of {} searches", kept.reuses(), kept.searches());
}

#[test]
fn improper_boxes_touch_nothing() {
    let periods = Periods::new([Some(2.0); 3]);
    let good = Aabb::from_centre(DVec3::ZERO, DVec3::splat(0.5));
    let bad = [
        Aabb { min: DVec3::NAN, max: DVec3::NAN },
        Aabb { min: DVec3::ONE, max: DVec3::ZERO },
        Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY },
    ];
    let boxes = [good, bad[0], good, bad[1], bad[2]];
    assert_eq!(pairs_of(Periodic::new(Grid::default(), periods), &boxes), [[0, 2]]);
    assert_eq!(pairs_of(PeriodicBruteForce { periods }, &boxes), [[0, 2]]);
    assert_eq!(pairs_of(Candidates::in_space(periods), &boxes), [[0, 2]]);
}
