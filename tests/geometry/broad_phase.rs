//! The grid against testing every pair, and the candidate list against the grid.

use glam::DVec3;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::internals::broad_phase::{Aabb, BroadPhase, BruteForce, Candidates, Grid};

fn pairs_of(mut search: impl BroadPhase, boxes: &[Aabb]) -> Vec<[u32; 2]> {
    let mut pairs = vec![[7, 7]];
    search.pairs(boxes, &mut pairs);
    pairs
}

fn assert_agrees(boxes: &[Aabb]) {
    let expected = pairs_of(BruteForce, boxes);
    assert!(expected.is_sorted_by(|one, other| one < other));
    assert_eq!(pairs_of(Grid::default(), boxes), expected, "{} boxes", boxes.len());
}

fn at(x: f64, y: f64, z: f64, half: f64) -> Aabb {
    Aabb::from_centre(DVec3::new(x, y, z), DVec3::splat(half))
}

/// `count` boxes with centres uniform in a box of edges `span`, half edges from `half`.
fn scattered(seed: u64, count: usize, span: DVec3, half: impl Fn(&mut ChaCha8Rng) -> DVec3) -> Vec<Aabb> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|_| {
            let centre = DVec3::new(rng.random::<f64>(), rng.random::<f64>(), rng.random::<f64>()) * span;
            Aabb::from_centre(centre, half(&mut rng))
        })
        .collect()
}

/// Half edges log-uniform over a ratio of `ratio`, the largest `top`.
fn log_uniform(rng: &mut ChaCha8Rng, top: f64, ratio: f64) -> DVec3 {
    DVec3::splat(top * ratio.powf(-rng.random::<f64>()))
}

#[test]
fn nothing_one_and_two_boxes() {
    assert_agrees(&[]);
    assert_agrees(&[at(1.0, 2.0, 3.0, 0.5)]);
    assert_eq!(pairs_of(Grid::default(), &[at(0.0, 0.0, 0.0, 0.5), at(1.0, 1.0, 1.0, 0.5)]), [[0, 1]]);
    assert_eq!(
        pairs_of(Grid::default(), &[at(0.0, 0.0, 0.0, 0.5), at(1.0f64.next_up(), 1.0, 1.0, 0.5)]),
        [[0u32; 2]; 0]
    );
}

#[test]
fn identical_boxes_and_points() {
    assert_agrees(&[at(1e6, -3.0, 2.0, 0.5); 60]);
    assert_agrees(&[at(1e6, -3.0, 2.0, 0.0); 60]);
    assert_agrees(&[at(0.0, 0.0, 0.0, 0.0); 60]);
    let mut points = scattered(1, 400, DVec3::splat(5.0), |_| DVec3::ZERO);
    for point in &mut points {
        *point = Aabb { min: point.min.floor(), max: point.min.floor() };
    }
    assert!(pairs_of(BruteForce, &points).len() > 100);
    assert_agrees(&points);
    points.push(at(2.0, 2.0, 2.0, 1.0));
    assert_agrees(&points);
}

#[test]
fn lines_along_every_axis_and_diagonal() {
    for direction in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE, DVec3::new(-1.0, 1e-3, 2.0)]
    {
        let line = |k: i32| Aabb::from_centre(direction * f64::from(k), DVec3::splat(0.5));
        assert_agrees(&(0..500).map(line).collect::<Vec<_>>());
    }
}

#[test]
fn lattices_that_touch_exactly() {
    for origin in [0.0, -7.0, 1e6, 1099511627776.0] {
        let cell = |k: i32| {
            let index = DVec3::new(f64::from(k % 9), f64::from(k / 9 % 9), f64::from(k / 81));
            Aabb { min: index + origin, max: index + origin + 1.0 }
        };
        let boxes: Vec<Aabb> = (0..729).map(cell).collect();
        assert_agrees(&boxes);
        // Of 9 cells in a row, 25 ordered pairs (a cell with itself counted) share a point.
        assert_eq!(pairs_of(Grid::default(), &boxes).len(), (25 * 25 * 25 - 729) / 2);
    }
}

#[test]
fn one_giant_over_many() {
    let mut boxes = scattered(2, 2000, DVec3::splat(40.0), |_| DVec3::splat(0.7));
    boxes.insert(1000, at(20.0, 20.0, 20.0, 500.0));
    assert_agrees(&boxes);
    boxes.push(at(-480.0, 0.0, 0.0, 480.0));
    boxes.push(at(1e5, 0.0, 0.0, 1e5));
    assert_agrees(&boxes);
}

#[test]
fn sizes_a_thousand_to_one() {
    for seed in 0..8 {
        assert_agrees(&scattered(seed, 2500, DVec3::splat(60.0), |rng| log_uniform(rng, 10.0, 1e3)));
        assert_agrees(&scattered(seed, 1500, DVec3::splat(60.0), |rng| log_uniform(rng, 10.0, 1e14)));
    }
}

#[test]
fn long_and_flat_boxes_in_mixed_directions() {
    for seed in 0..8 {
        let one_long = |rng: &mut ChaCha8Rng| {
            let mut half = [0.1; 3];
            half[rng.random_range(0..3)] = 10.0;
            DVec3::from_array(half)
        };
        assert_agrees(&scattered(seed, 1500, DVec3::splat(60.0), one_long));
        let one_flat = |rng: &mut ChaCha8Rng| {
            let mut half = [5.0, 5.0, 5.0].map(|half| half * rng.random::<f64>());
            half[rng.random_range(0..3)] = 0.0;
            DVec3::from_array(half)
        };
        assert_agrees(&scattered(seed, 1500, DVec3::splat(60.0), one_flat));
        // Large plates thinner than the small boxes between them.
        let plates = |rng: &mut ChaCha8Rng| {
            if rng.random_bool(0.1) { DVec3::new(20.0, 1e-3, 20.0) } else { DVec3::splat(0.5) }
        };
        assert_agrees(&scattered(seed, 1500, DVec3::new(60.0, 30.0, 60.0), plates));
    }
}

#[test]
fn clusters_very_far_apart() {
    let mut boxes = Vec::new();
    for (k, origin) in [DVec3::ZERO, DVec3::splat(1e6), DVec3::new(-1e12, 1e9, 3.0), DVec3::new(0.0, 1e18, 1e18)]
        .into_iter()
        .enumerate()
    {
        let cluster = scattered(k as u64, 300, DVec3::splat(8.0), |_| DVec3::splat(0.5));
        boxes.extend(cluster.iter().map(|aabb| Aabb { min: aabb.min + origin, max: aabb.max + origin }));
    }
    assert_agrees(&boxes);
}

#[test]
fn extreme_coordinates() {
    let mut boxes = scattered(3, 100, DVec3::splat(f64::MAX), |rng| DVec3::splat(f64::MAX * rng.random::<f64>() / 4.0));
    boxes.retain(Aabb::is_proper);
    boxes.push(Aabb { min: DVec3::splat(f64::MIN), max: DVec3::splat(f64::MAX) });
    boxes.extend((0..50).map(|k| at(f64::from(k) * 5e-324, 0.0, 0.0, 5e-324)));
    assert!(boxes.len() > 60);
    assert_agrees(&boxes);
    assert_agrees(&boxes[boxes.len() - 50..]);
    assert_agrees(
        &(0..50).map(|k| at(f64::from(k) * 1e-310, f64::from(k % 3) * 1e-311, 0.0, 1e-310)).collect::<Vec<_>>(),
    );
}

#[test]
fn improper_boxes_touch_nothing() {
    let mut boxes = scattered(4, 300, DVec3::splat(8.0), |_| DVec3::splat(0.5));
    let clean = boxes.clone();
    boxes[3].min.x = f64::NAN;
    boxes[50].max.z = f64::INFINITY;
    boxes[51] = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
    boxes[80] = Aabb { min: boxes[80].max, max: boxes[80].min };
    boxes[299].max = DVec3::NAN;
    let improper = [3, 50, 51, 80, 299];
    assert_agrees(&boxes);
    let mut expected = pairs_of(BruteForce, &clean);
    expected.retain(|pair| !pair.iter().any(|body| improper.contains(body)));
    assert_eq!(pairs_of(Grid::default(), &boxes), expected);
    assert_agrees(&[Aabb { min: DVec3::NAN, max: DVec3::NAN }; 20]);
}

/// Scenes large enough to be shared out to threads: a planar one, a spatial one of mixed sizes, a line.
fn large_scenes() -> [Vec<Aabb>; 3] {
    let rod = |rng: &mut ChaCha8Rng| {
        let angle = rng.random::<f64>() * std::f64::consts::TAU;
        DVec3::new(angle.cos().abs() + 0.25, angle.sin().abs() + 0.25, 0.25)
    };
    [
        scattered(5, 20_000, DVec3::new(150.0, 150.0, 0.0), rod),
        scattered(6, 9_000, DVec3::splat(60.0), |rng| log_uniform(rng, 3.0, 100.0)),
        scattered(7, 9_000, DVec3::new(0.0, 5000.0, 0.0), |_| DVec3::splat(0.5)),
    ]
}

#[test]
fn any_number_of_threads_gives_the_same() {
    for boxes in large_scenes() {
        let expected = pairs_of(BruteForce, &boxes);
        assert!(expected.len() > boxes.len());
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| pairs_of(Grid::default(), &boxes)), expected, "{threads} threads");
        }
    }
}

#[test]
fn a_used_grid_finds_what_a_new_one_does() {
    let mut grid = Grid::default();
    let mut pairs = Vec::new();
    let [plane, mixed, line] = large_scenes();
    for boxes in [&plane[..], &[], &mixed, &line[..10], &line, &plane[..5000], &mixed[..1]] {
        grid.pairs(boxes, &mut pairs);
        assert_eq!(pairs, pairs_of(Grid::default(), boxes));
    }
}

/// Walks boxes at random, each to its own pace, and compares every configuration with a search of its own. Every third
/// call goes back, as a trial that is not accepted does.
fn walk(mut candidates: Candidates, boxes: &mut [Aabb], pace: f64, calls: u32) -> Candidates {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut pairs = Vec::new();
    for call in 0..calls {
        let before = boxes.to_vec();
        for aabb in boxes.iter_mut() {
            let mut step = || DVec3::from_array([0; 3].map(|_| pace * (rng.random::<f64>() - 0.5)));
            let (shift, growth) = (step(), step().abs() * 0.2);
            *aabb = Aabb { min: aabb.min + shift - growth, max: aabb.max + shift + growth };
        }
        let listed = candidates.ensure(boxes).to_vec();
        assert!(listed.is_sorted_by(|one, other| one < other));
        let expected = pairs_of(BruteForce, boxes);
        assert!(expected.iter().all(|pair| listed.binary_search(pair).is_ok()), "call {call}");
        candidates.pairs(boxes, &mut pairs);
        assert_eq!(pairs, expected, "call {call}");
        if call % 3 == 2 {
            boxes.copy_from_slice(&before);
        }
    }
    candidates
}

#[test]
fn candidates_miss_nothing_on_random_walks() {
    for pace in [0.0, 1e-3, 1e-2, 0.1, 1.0, 10.0] {
        let mut boxes = scattered(8, 300, DVec3::splat(9.0), |rng| log_uniform(rng, 1.0, 4.0));
        let candidates = walk(Candidates::new(Box::<Grid>::default()), &mut boxes, pace, 60);
        assert_eq!(candidates.searches() + candidates.reuses(), 120);
        walk(Candidates::with_margin(Box::<Grid>::default(), 0.3), &mut boxes, pace, 60);
    }
}

#[test]
fn candidates_are_reused_while_little_moves() {
    let mut boxes = scattered(8, 300, DVec3::splat(9.0), |_| DVec3::splat(0.5));
    assert_eq!(walk(Candidates::new(Box::<Grid>::default()), &mut boxes.clone(), 0.0, 30).searches(), 1);
    let slow = walk(Candidates::new(Box::<Grid>::default()), &mut boxes, 1e-3, 300);
    assert!(slow.searches() <= 30, "{} searches in 600 calls", slow.searches());
    assert!(slow.searches() >= 2);
}

#[test]
fn candidates_notice_new_and_exchanged_bodies() {
    let mut candidates = Candidates::with_margin(Box::<Grid>::default(), 0.1);
    let mut boxes = vec![at(0.0, 0.0, 0.0, 0.5), at(3.0, 0.0, 0.0, 0.5)];
    assert!(candidates.ensure(&boxes).is_empty());
    boxes.push(at(0.9, 0.0, 0.0, 0.5));
    assert_eq!(candidates.ensure(&boxes), [[0, 2]]);
    boxes.swap(0, 1);
    assert_eq!(candidates.ensure(&boxes), [[1, 2]]);
    assert_eq!((candidates.searches(), candidates.reuses()), (3, 0));
    candidates.ensure(&boxes);
    candidates.invalidate();
    candidates.ensure(&boxes);
    assert_eq!((candidates.searches(), candidates.reuses()), (4, 1));
    boxes.clear();
    assert!(candidates.ensure(&boxes).is_empty());
}

#[test]
fn candidates_recover_from_improper_boxes() {
    let good = scattered(8, 50, DVec3::splat(4.0), |_| DVec3::splat(0.5));
    let bad_boxes = [
        Aabb { min: DVec3::NAN, max: DVec3::NAN },
        Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY },
        Aabb { min: good[7].max, max: good[7].min },
        Aabb { min: good[7].min + 0.51, max: good[7].max - 0.51 },
        Aabb { min: DVec3::splat(f64::MIN), max: DVec3::splat(f64::MAX) },
    ];
    for bad in bad_boxes {
        let mut candidates = Candidates::with_margin(Box::<Grid>::default(), 1.0);
        let mut spoilt = good.clone();
        spoilt[7] = bad;
        for boxes in [&spoilt, &good, &spoilt, &spoilt, &good, &good] {
            let mut pairs = Vec::new();
            candidates.pairs(boxes, &mut pairs);
            assert_eq!(pairs, pairs_of(BruteForce, boxes));
        }
    }
}

#[test]
fn candidates_are_the_same_for_any_number_of_threads() {
    let [plane, ..] = large_scenes();
    let moved: Vec<Aabb> = plane.iter().map(|aabb| Aabb { min: aabb.min + 0.01, max: aabb.max + 0.01 }).collect();
    let expected = pairs_of(Grid::default(), &moved);
    let mut lists = Vec::new();
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut candidates = Candidates::new(Box::<Grid>::default());
            lists.push(candidates.ensure(&plane).to_vec());
            let mut pairs = Vec::new();
            candidates.pairs(&moved, &mut pairs);
            assert_eq!((candidates.searches(), candidates.reuses()), (1, 1));
            assert_eq!(pairs, expected);
        });
    }
    assert!(lists.iter().all(|list| *list == lists[0] && list.len() > expected.len()));
}

/// Scenes of one kind each: how centres and sizes are drawn, and where the scene is.
fn scene() -> impl Strategy<Value = Vec<Aabb>> {
    let centres = prop_oneof![
        Just(DVec3::new(10.0, 10.0, 10.0)),
        Just(DVec3::new(20.0, 20.0, 0.0)),
        Just(DVec3::new(0.0, 30.0, 0.0)),
        Just(DVec3::new(0.0, 20.0, 1e-9)),
        Just(DVec3::new(1e5, 1e-3, 1e5)),
        Just(DVec3::ZERO),
    ];
    let sizes = prop_oneof![Just(1.0), Just(1.5), Just(30.0), Just(1e3), Just(1e9)];
    let origin = prop_oneof![Just(0.0), Just(1e6), Just(-1e6), Just(1e15)];
    // Rounding to a grid makes boxes that touch exactly, coincide, or have no extent.
    let rounding = prop_oneof![Just(0.0), Just(0.25), Just(1.0)];
    (0usize..250, any::<u64>(), centres, sizes, any::<bool>(), origin, rounding, 0.0f64..1.0).prop_map(
        |(count, seed, span, ratio, cubes, origin, rounding, clustered)| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 1);
            let half = |rng: &mut ChaCha8Rng| {
                let shape = if cubes { DVec3::ONE } else { DVec3::from_array([0; 3].map(|_| rng.random::<f64>())) };
                log_uniform(rng, 1.0, ratio) * shape
            };
            let mut boxes = scattered(seed, count, span, half);
            for aabb in &mut boxes {
                let shift = if rng.random_bool(clustered) { span * 0.3 - aabb.min * 0.9 } else { DVec3::ZERO };
                for corner in [&mut aabb.min, &mut aabb.max] {
                    *corner += shift + origin;
                    if rounding > 0.0 {
                        *corner = (*corner / rounding).floor() * rounding;
                    }
                }
            }
            boxes
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn grid_finds_what_testing_every_pair_finds(boxes in scene()) {
        prop_assert_eq!(pairs_of(Grid::default(), &boxes), pairs_of(BruteForce, &boxes));
    }
}
