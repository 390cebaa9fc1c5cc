//! Measures of states whose answers are known.

mod motion;
mod shear;

use super::*;
use crate::bodies::{Bodies, NO_GROUP};
use crate::record::{Snapshot, States};
use crate::separation::Placed;
use crate::shape::Shape;
use crate::warm::Warm;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;
use std::f64::consts::{E, FRAC_PI_2, PI, TAU};

const ROD: Shape = Shape::Spherocylinder { diameter: 1.0, length: 3.0 };
const BALL: Shape = Shape::Sphere { radius: 0.5 };

/// A rod's orientation at an angle in the plane.
fn lying(angle: f64) -> DQuat {
    DQuat::from_rotation_z(angle) * DQuat::from_rotation_y(FRAC_PI_2)
}

fn bodies(placed: impl IntoIterator<Item = (Shape, DVec3, DQuat)>) -> Bodies {
    let mut bodies = Bodies::default();
    for (shape, position, orientation) in placed {
        bodies.push(Placed { shape, position, orientation }, NO_GROUP);
    }
    bodies
}

fn state(bodies: Bodies, forces: Option<&[([u32; 2], f64)]>) -> Snapshot {
    let warm = |&(pair, gamma): &([u32; 2], f64)| Warm { pair, feature: 0, gamma, normal: DVec3::ZERO };
    Snapshot {
        step: 7,
        time: 0.7,
        bodies,
        warm: forces.map(|forces| forces.iter().map(warm).collect()),
        removed: Vec::new(),
    }
}

fn frame(planar: bool) -> Frame {
    Frame {
        planar,
        planar_from: "a test".into(),
        drag: Some(2.0),
        shear: None,
        fixed: Default::default(),
        removes: false,
    }
}

fn of_settings(name: &str, state: &Snapshot, planar: bool, settings: &Settings) -> Result<Found, LeftOut> {
    select(&[name.into()]).unwrap()[0].of(&View::new(state, &frame(planar), settings))
}

fn of(name: &str, state: &Snapshot, planar: bool) -> Found {
    of_settings(name, state, planar, &Settings::default()).unwrap()
}

#[track_caller]
fn value(found: &Found, measure: &str, column: &str) -> Cell {
    let measure = ALL.iter().find(|m| m.name() == measure).unwrap();
    found.values[measure.columns().iter().position(|c| c.name == column).unwrap()]
}

#[track_caller]
fn assert_near(found: Cell, expected: f64, tolerance: f64) {
    let found = found.unwrap();
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} to {tolerance}");
}

fn square(side: usize, shape: Shape, orientation: impl Fn(usize) -> DQuat) -> Bodies {
    let place = |k: usize| DVec3::new((k % side) as f64, (k / side) as f64, 0.0);
    bodies((0..side * side).map(|k| (shape, place(k), orientation(k))))
}

fn random_axes(count: usize, planar: bool, seed: u64) -> Snapshot {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || random.random::<f64>();
    let turn = |draw: &mut dyn FnMut() -> f64| {
        if planar {
            return lying(TAU * draw());
        }
        let (z, angle) = (2.0 * draw() - 1.0, TAU * draw());
        let flat = (1.0 - z * z).sqrt();
        DQuat::from_rotation_arc(DVec3::Z, DVec3::new(flat * angle.cos(), flat * angle.sin(), z))
    };
    state(bodies((0..count).map(|k| (ROD, DVec3::X * k as f64, turn(&mut draw)))), None)
}

#[test]
fn a_scene_may_name_every_measure() {
    assert_eq!(ALL.map(|measure| measure.name()), crate::scene::MEASURES);
}

#[test]
fn aligned_bodies_have_order_one() {
    for planar in [true, false] {
        let state = state(square(6, ROD, |_| lying(0.3)), None);
        let found = of("nematic", &state, planar);
        assert_near(value(&found, "nematic", "nematic_order"), 1.0, 1e-14);
        assert_near(value(&found, "nematic", "nematic_local"), 1.0, 1e-14);
        let director = value(&found, "nematic", "nematic_director_degrees");
        assert_eq!(director.is_some(), planar);
        director.into_iter().for_each(|degrees| assert!((degrees - 0.3_f64.to_degrees()).abs() < 1e-10));
        let found = of("correlation", &state, planar);
        assert!(found.rows.len() > 5 && found.rows.iter().all(|row| (row[1].unwrap() - 1.0).abs() < 1e-13));
        assert_eq!(value(&found, "correlation", "correlation_length"), None);
        assert!(found.remark.unwrap().contains("does not fall"));
    }
}

#[test]
fn a_fan_of_axes_has_no_order_and_random_ones_as_much_as_their_number_leaves() {
    let fan = state(square(10, ROD, |k| lying(PI * k as f64 / 100.0)), None);
    assert_near(value(&of("nematic", &fan, true), "nematic", "nematic_order"), 0.0, 1e-14);
    let three = [DQuat::IDENTITY, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_2)];
    let three = state(bodies(three.map(|q| (ROD, DVec3::ZERO, q))), None);
    assert_near(value(&of("nematic", &three, false), "nematic", "nematic_order"), 0.0, 1e-14);
    // In the plane <S^2> = 1/N: the sum is a random walk of N unit steps.
    let squares: f64 = (0..100)
        .map(|seed| {
            value(&of("nematic", &random_axes(400, true, seed), true), "nematic", "nematic_order").unwrap().powi(2)
        })
        .sum();
    assert!((squares / 100.0 * 400.0 - 1.0).abs() < 0.4, "{squares}");
    // In space it falls likewise.
    let order =
        |count| value(&of("nematic", &random_axes(count, false, 1), false), "nematic", "nematic_order").unwrap();
    assert!(order(100) < 3.0 / 10.0 && order(10_000) < 3.0 / 100.0 && order(10_000) > 0.1 / 100.0);
}

#[test]
fn local_order_is_that_of_the_stated_neighbourhood() {
    // Two rods at right angles within reach of each other, two parallel ones farther off, and a lone one.
    let x = [0.0, 1.0, 10.0, 11.0, 30.0];
    let angle = [0.0, FRAC_PI_2, 0.4, 0.4, 0.1];
    let state = state(bodies((0..5).map(|k| (ROD, DVec3::X * x[k], lying(angle[k])))), None);
    let settings = Settings { neighbourhood: Some(1.0), ..Settings::default() };
    let found = of_settings("nematic", &state, true, &settings).unwrap();
    assert_near(value(&found, "nematic", "nematic_local"), 0.5, 1e-14);
    assert_near(value(&found, "nematic", "nematic_local_neighbours"), 0.8, 1e-15);
    let settings = Settings { neighbourhood: Some(0.5), ..Settings::default() };
    let found = of_settings("nematic", &state, true, &settings).unwrap();
    assert_eq!(value(&found, "nematic", "nematic_local"), None);
    assert!(found.remark.is_some());
}

#[test]
fn a_neighbourhood_of_too_many_is_left_out() {
    let crowd = state(bodies((0..20_000).map(|k| (ROD, DVec3::X * k as f64, lying(0.0)))), None);
    let settings = Settings { neighbourhood: Some(1e9), ..Settings::default() };
    let found = of_settings("nematic", &crowd, true, &settings).unwrap();
    assert_eq!(value(&found, "nematic", "nematic_local"), None);
    assert!(found.remark.unwrap().contains("too many pairs"));
}

#[test]
fn the_correlation_of_a_twisted_row_is_that_of_its_twist() {
    let twist = 0.02;
    let row = |k: usize| (ROD, DVec3::X * k as f64, lying(twist * k as f64));
    let state = state(bodies((0..400).map(row)), None);
    for (planar, expected) in
        [(true, (1.0 / E).acos() / (2.0 * twist)), (false, ((2.0 / E + 1.0) / 3.0).sqrt().acos() / twist)]
    {
        let found = of("correlation", &state, planar);
        // No pair is in the first bin; the last holds the two largest distances.
        assert_eq!(found.rows.len(), 398);
        for row in &found.rows[..397] {
            let [r, c] = [row[0].unwrap(), row[1].unwrap()];
            let analytic = if planar { (2.0 * twist * r).cos() } else { 1.5 * (twist * r).cos().powi(2) - 0.5 };
            assert!((c - analytic).abs() < 1e-12 && (r - r.round()).abs() < 1e-12, "{r}: {c} {analytic}");
        }
        assert_near(value(&found, "correlation", "correlation_pairs"), 400.0 * 399.0 / 2.0, 0.0);
        // Straight between whole distances: the arc's rise over a chord of 1 is at most its second derivative over 8.
        assert_near(value(&found, "correlation", "correlation_length"), expected, 0.01);
        // Sampled, each distance's mean is the same; which and how many pairs is the seed's.
        let sampled = |seed| {
            let settings = Settings { correlation_pairs: 4000, seed, ..Settings::default() };
            of_settings("correlation", &state, planar, &settings).unwrap()
        };
        let (one, other) = (sampled(1), sampled(2));
        assert_eq!(value(&one, "correlation", "correlation_references"), Some(10.0));
        assert_eq!(value(&one, "correlation", "correlation_pairs"), Some(10.0 * 399.0));
        assert_near(value(&one, "correlation", "correlation_length"), expected, 0.01);
        assert!(one.remark.as_ref().unwrap().contains("10 bodies of 400, drawn by seed 1"));
        assert_eq!(one, sampled(1));
        assert_ne!(one.rows, other.rows);
    }
}

#[test]
fn a_lattice_is_packed_as_its_cell() {
    let side = 60;
    let ball = Shape::Sphere { radius: 0.4 };
    let lattice = state(square(side, ball, |_| DQuat::IDENTITY), None);
    let cell = PI * 0.16;
    let found = of("packing", &lattice, true);
    let (n, long) = ((side * side) as f64, (side - 1) as f64);
    assert_near(value(&found, "packing", "body_volume"), n * cell, 1e-9);
    assert_near(value(&found, "packing", "hull_area"), long * long + 4.0 * long * 0.4 + cell, 1e-8);
    assert_near(value(&found, "packing", "packing_hull"), n * cell / (long * long + 4.0 * long * 0.4 + cell), 1e-10);
    assert_near(value(&found, "packing", "packing_core"), cell, 0.005);
    let found = of("density", &lattice, true);
    // Rings wholly inside the square and wide enough to hold many centres.
    let settings = Settings { bin: Some(5.0), ..Settings::default() };
    let wide = of_settings("density", &lattice, true, &settings).unwrap();
    for row in wide.rows[1..5].iter() {
        assert!((row[1].unwrap() - cell).abs() < 0.03 && (row[2].unwrap() - 1.0).abs() < 0.06, "{row:?}");
    }
    let [bodies, filled] = [found.rows.iter().map(|row| row[3].unwrap()).sum::<f64>(), {
        let area = |row: &Vec<Cell>| TAU * row[0].unwrap() * 0.8;
        found.rows.iter().map(|row| row[1].unwrap() * area(row)).sum::<f64>()
    }];
    assert!(bodies == n && (filled - n * cell).abs() < 1e-8, "{bodies} {filled}");
}

#[test]
fn a_cube_of_balls_is_packed_as_its_cell() {
    let place = |k: usize| DVec3::new((k % 20) as f64, (k / 20 % 20) as f64, (k / 400) as f64);
    let balls = state(bodies((0..8000).map(|k| (BALL, place(k), DQuat::IDENTITY))), None);
    let found = of("packing", &balls, false);
    assert_near(value(&found, "packing", "packing_core"), PI / 6.0, 0.01);
    assert_eq!(value(&found, "packing", "packing_hull"), None);
    // A uniform cube of side 20, its points on a lattice.
    assert_near(value(&of("radius", &balls, false), "radius", "radius_gyration"), (399.0_f64 / 4.0).sqrt(), 1e-12);
    assert_near(value(&of("radius", &balls, false), "radius", "radius_outermost"), 9.5 * 3.0_f64.sqrt() + 0.5, 1e-12);
}

#[test]
fn hulls_of_rods_are_exact() {
    for angle in [0.0, 0.3, 1.234] {
        let one = state(bodies([(ROD, DVec3::new(5.0, 2.0, 0.0), lying(angle))]), None);
        let found = of("packing", &one, true);
        assert_near(value(&found, "packing", "hull_area"), 2.0 + 0.25 * PI, 1e-8);
        // Side by side, two apart: a stadium's straight part of 2 x (2 + 1) and the arcs' disc, and two flanks of 2 x
        // 0.5.
        let beside = 2.0 * DVec3::new(-angle.sin(), angle.cos(), 0.0);
        let two = state(bodies([(ROD, DVec3::ZERO, lying(angle)), (ROD, beside, lying(angle))]), None);
        assert_near(value(&of("packing", &two, true), "packing", "hull_area"), 4.0 + 8.0 * 0.5 + 0.25 * PI, 1e-8);
    }
    let egg = state(bodies([(Shape::Ellipsoid { radii: [3.0, 1.0, 1.0] }, DVec3::ZERO, DQuat::IDENTITY)]), None);
    assert_near(value(&of("packing", &egg, true), "packing", "packing_hull"), 1.0, 1e-8);
}

#[test]
fn the_stress_of_one_contact_is_its_virial() {
    // Parallel rods that touch along their sides, one shifted; the upper one pushed down with 4.
    let pair = bodies([(ROD, DVec3::ZERO, lying(0.0)), (ROD, DVec3::new(0.3, 1.0, 0.0), lying(0.0))]);
    let found = of("stress", &state(pair, Some(&[([0, 1], 4.0)])), true);
    let area = 2.0 * (2.0 + 0.25 * PI);
    for (column, expected) in [
        ("stress_yy", 4.0 / area),
        ("stress_xy", 0.5 * 4.0 * 0.3 / area),
        ("stress_xx", 0.0),
        ("pressure", 2.0 / area),
        ("shear", (2.0_f64.powi(2) + 0.6_f64.powi(2)).sqrt() / area),
        ("force_mean", 4.0),
    ] {
        assert_near(value(&found, "stress", column), expected, 1e-14);
    }
    assert_eq!(value(&found, "stress", "stress_zz"), None);
    // The bodies' own virials add up to the whole.
    let rings: f64 = found.rows.iter().enumerate().map(|(k, row)| row[1].unwrap() * PI * (2 * k + 1) as f64).sum();
    assert!((rings - 2.0).abs() < 1e-13, "{rings}");
    // Two balls in space, along a diagonal.
    let direction = DVec3::new(2.0, -1.0, 2.0) / 3.0;
    let balls = bodies([(BALL, DVec3::ZERO, DQuat::IDENTITY), (BALL, direction, DQuat::IDENTITY)]);
    let found = of("stress", &state(balls, Some(&[([0, 1], 3.0)])), false);
    let volume = 2.0 * PI / 6.0;
    assert_near(value(&found, "stress", "stress_xz"), 3.0 * 4.0 / 9.0 / volume, 1e-14);
    assert_near(value(&found, "stress", "stress_yy"), 3.0 / 9.0 / volume, 1e-14);
    assert_near(value(&found, "stress", "pressure"), 1.0 / volume, 1e-14);
    assert_near(value(&found, "stress", "shear"), 1.5 / volume, 1e-14);
}

#[test]
fn contacts_chains_and_their_absence() {
    let row = || bodies((0..5).map(|k| (BALL, DVec3::X * if k < 4 { k as f64 } else { 9.0 }, DQuat::IDENTITY)));
    let forces = [([0, 1], 1.0), ([1, 2], 4.0), ([2, 3], 0.0)];
    let pushed = state(row(), Some(&forces));
    let found = of("contacts", &pushed, true);
    let expected = [5e-4 * 2.0, 3.0, 1.2, 1.0, 2.0, 0.8, 2.0];
    assert_eq!(found.values, expected.map(Some));
    let histogram = [[0.0, 1.0, 2.0], [1.0, 2.0, 2.0], [2.0, 2.0, 1.0]];
    assert_eq!(found.rows, histogram.map(|row| row.map(Some).to_vec()));
    let chains = of("force_chains", &pushed, true);
    assert_eq!(chains.values, [2.5, 1.0, 0.5, 1.0, 2.0, 2.0].map(Some));
    assert_eq!(chains.rows, [[Some(2.0), Some(1.0)]]);
    // Without forces they are said to be unknown; what touches is known all the same.
    let still = state(row(), None);
    let found = of("contacts", &still, true);
    assert_eq!((found.values[1], &found.values[4..]), (Some(3.0), &[None; 3][..]));
    for name in ["stress", "force_chains"] {
        let LeftOut(reason) = of_settings(name, &still, true, &Settings::default()).unwrap_err();
        assert!(reason.contains("only a checkpoint"), "{reason}");
    }
    let mut sub_spheres = pushed;
    sub_spheres.warm.as_mut().unwrap()[1].feature = 3;
    let LeftOut(reason) = of_settings("stress", &sub_spheres, true, &Settings::default()).unwrap_err();
    assert!(reason.contains("sub-spheres"), "{reason}");
}

#[test]
fn microdomains_end_where_the_angle_is_too_large() {
    // Rods tip to tip around a bend: turned by 2, 2, 5 and 2 degrees from one to the next, each end at the last one's.
    let mut angle = 0.0_f64;
    let mut tip = DVec3::ZERO;
    let mut placed = Vec::new();
    for turn in [0.0, 2.0, 2.0, 5.0, 2.0] {
        angle += f64::to_radians(turn);
        let direction = DVec3::new(angle.cos(), angle.sin(), 0.0);
        placed.push((ROD, tip + 1.0 * direction, lying(angle)));
        // The next cap's centre is one diameter on.
        tip += 3.0 * direction;
    }
    placed.push((BALL, DVec3::Y * 50.0, DQuat::IDENTITY));
    let chain = state(bodies(placed), None);
    let domains = |degrees: f64| {
        let settings = Settings { domain_angle_degrees: degrees, cutoff: Some(0.01), ..Settings::default() };
        of_settings("microdomains", &chain, true, &settings).unwrap()
    };
    let found = domains(3.0);
    let rod = 2.0 + 0.25 * PI;
    for (column, expected) in [
        ("domains", 2.0),
        ("domain_mean", 2.5),
        ("domain_largest", 3.0),
        ("domain_volume", 2.5 * rod),
        ("domain_volume_weighted", (9.0 + 4.0) / 5.0 * rod),
    ] {
        assert_near(value(&found, "microdomains", column), expected, 1e-12);
    }
    assert_eq!(found.rows, [[Some(2.0), Some(1.0)], [Some(3.0), Some(1.0)]]);
    assert_eq!(value(&domains(1.0), "microdomains", "domains"), Some(5.0));
    assert_eq!(value(&domains(6.0), "microdomains", "domains"), Some(1.0));
}

#[test]
fn bodies_without_an_axis_have_no_order() {
    let balls = state(square(3, BALL, |_| DQuat::IDENTITY), None);
    for name in ["nematic", "correlation", "microdomains"] {
        assert!(of_settings(name, &balls, true, &Settings::default()).is_err(), "{name}");
    }
    // A rod among them has; it has no one to be compared with.
    let mut mixed = square(3, BALL, |_| DQuat::IDENTITY);
    mixed.push(Placed { shape: ROD, position: DVec3::X * 20.0, orientation: lying(0.0) }, NO_GROUP);
    let mixed = state(mixed, None);
    assert_eq!(value(&of("nematic", &mixed, true), "nematic", "nematic_axes"), Some(1.0));
    assert!(of_settings("correlation", &mixed, true, &Settings::default()).is_err());
    assert_eq!(of("length", &mixed, true).values, [1.0, 3.0, 0.0, 3.0, 3.0].map(Some));
}

#[test]
fn lengths_and_their_histogram() {
    let rod = |length: f64| (Shape::Spherocylinder { diameter: 1.0, length }, DVec3::ZERO, lying(0.0));
    let found = of("length", &state(bodies([2.0, 2.1, 4.0, 3.9].map(rod)), None), true);
    assert_near(value(&found, "length", "length_mean"), 3.0, 1e-15);
    assert_near(value(&found, "length", "length_sd"), ((1.0 + 0.81) / 2.0_f64).sqrt(), 1e-14);
    let rows: Vec<[f64; 3]> = found.rows.iter().map(|row| [0, 1, 2].map(|k| row[k].unwrap())).collect();
    assert_eq!(rows, [[2.0625, 4.0, 2.0], [3.9375, 2.0, 1.0], [4.0625, 2.0, 1.0]]);
}

#[test]
fn dissipation_is_the_power_of_the_drag() {
    let mut one = bodies([(ROD, DVec3::ZERO, lying(0.0))]);
    one.velocity[0] = DVec3::new(3.0, 4.0, 0.0);
    one.angular_velocity[0] = DVec3::Z * 2.0;
    let mut state = state(one, None);
    assert_near(of("dissipation", &state, true).values[0], 2.0 * (3.0 * 25.0 + 27.0 * 4.0 / 12.0), 1e-12);
    state.step = 0;
    assert!(of_settings("dissipation", &state, true, &Settings::default()).is_err());
}

#[test]
fn the_expansion_rate_of_a_parabola_is_exact_inside() {
    let times = [0.0, 1.0, 3.0, 4.0];
    let radius = |t: f64| 1.0 + 2.0 * t + 0.5 * t * t;
    let mut found: Vec<_> =
        times.iter().map(|t| Ok(Found { values: vec![None, Some(radius(*t)), None], ..Found::default() })).collect();
    radius::Radius.over_time(&times, &mut found);
    let rates: Vec<f64> = found.iter().map(|found| found.as_ref().unwrap().values[2].unwrap()).collect();
    for (rate, expected) in rates.iter().zip([2.5, 3.0, 5.0, 5.5]) {
        assert!((rate - expected).abs() < 1e-14, "{rates:?}");
    }
    let mut alone = vec![Ok(Found { values: vec![None, Some(1.0), None], ..Found::default() })];
    radius::Radius.over_time(&[0.0], &mut alone);
    assert_eq!(alone[0].as_ref().unwrap().values[2], None);
}

#[test]
fn the_expansion_rate_of_exponential_growth_is_that_of_its_chords() {
    let (growth, step) = (0.7_f64, 0.1);
    let times: Vec<f64> = (0..20).map(|k| step * k as f64).collect();
    // Rods that grow; one alone is half as long as it is from its centre.
    let rod = |t: &f64| Shape::Spherocylinder { diameter: 1.0, length: 2.0 * (growth * t).exp() };
    let mut found: Vec<_> =
        times.iter().map(|t| Ok(of("radius", &state(bodies([(rod(t), DVec3::Y, lying(0.2))]), None), true))).collect();
    radius::Radius.over_time(&times, &mut found);
    for (t, found) in times.iter().zip(&found).skip(1).take(18) {
        let [radius, rate] = [1, 2].map(|column| found.as_ref().unwrap().values[column].unwrap());
        assert!((radius - (growth * t).exp()).abs() < 1e-14 * radius);
        // A central difference of the exponential: its own rate by sinh(x) / x.
        let expected = radius * (growth * step).sinh() / step;
        assert!((rate - expected).abs() < 1e-12 && (rate / radius / growth - 1.0).abs() < 1e-3, "{rate} {expected}");
    }
}

#[test]
fn a_lattice_of_equal_forces_has_the_pressure_of_its_cell_and_columns_are_chains() {
    let side = 11_u32;
    let right = (0..side * side).filter(|k| k % side + 1 < side).map(|k| [k, k + 1]);
    let up = (0..side * (side - 1)).map(|k| [k, k + side]);
    let lattice = |beside: f64, above: f64| {
        let mut forces: Vec<_> = right.clone().map(|pair| (pair, beside)).collect();
        forces.extend(up.clone().map(|pair| (pair, above)));
        state(square(side as usize, BALL, |_| DQuat::IDENTITY), Some(&forces))
    };
    // Of a cell of side 1 with a force of 3 across each of its sides.
    let settings = Settings { bin: Some(1.0), ..Settings::default() };
    let even = of_settings("stress", &lattice(3.0, 3.0), true, &settings).unwrap();
    for row in &even.rows[..5] {
        assert!((row[2].unwrap() - 3.0 / (0.25 * PI)).abs() < 1e-12, "{row:?}");
    }
    let contacts = f64::from(2 * side * (side - 1));
    let area = f64::from(side * side) * 0.25 * PI;
    assert_near(value(&even, "stress", "pressure"), 3.0 * contacts / (2.0 * area), 1e-12);
    assert_near(value(&even, "stress", "shear"), 0.0, 1e-12);
    // No contact is over the mean of equal ones; strong columns that weak rows connect are a chain each.
    assert_eq!(value(&of("force_chains", &lattice(3.0, 3.0), true), "force_chains", "chains"), Some(0.0));
    let columns = of("force_chains", &lattice(1.0, 5.0), true);
    assert_eq!(columns.values, [3.0, contacts / 2.0, 0.5, 11.0, 11.0, 11.0].map(Some));
    assert_eq!(columns.rows, [[Some(11.0), Some(11.0)]]);
}

#[test]
fn the_table_is_sound_and_documented() {
    let page = include_str!("../../docs/measures.md");
    let mut names = BTreeSet::new();
    for measure in ALL {
        assert!(page.contains(&format!("## `{}`", measure.name())), "{}", measure.name());
        for column in measure.columns() {
            assert!(names.insert(column.name), "{}", column.name);
            assert!(page.contains(&format!("`{}`", column.name)), "{}", column.name);
        }
        for column in measure.profile().map_or(&[][..], |profile| profile.columns) {
            assert!(page.contains(&format!("`{}`", column.name)), "{}", column.name);
        }
        let columns: Vec<_> = measure.columns().iter().map(|column| column.name).collect();
        assert!(measure.plots().iter().flat_map(|plot| plot.iter()).all(|name| columns.contains(name)));
        assert!(measure.profile().is_none_or(|profile| profile.drawn < profile.columns.len()));
    }
    assert!(matches!(select(&["nothing".into()]), Err(MeasureError::Unknown { .. })));
}

#[test]
fn every_state_gives_a_number_or_none_for_every_column() {
    let mut all_shapes = bodies([
        (ROD, DVec3::ZERO, lying(0.1)),
        (BALL, DVec3::X * 1.5, DQuat::IDENTITY),
        (Shape::Ellipsoid { radii: [1.0, 2.0, 0.5] }, DVec3::Y * 3.0, DQuat::IDENTITY),
        (Shape::Torus { major_radius: 2.0, minor_radius: 0.2 }, DVec3::X * 9.0, DQuat::IDENTITY),
    ]);
    all_shapes.velocity[0] = DVec3::X;
    for (bodies, forces) in [(Bodies::default(), None), (Bodies::default(), Some(&[][..])), (all_shapes, Some(&[][..]))]
    {
        let state = state(bodies, forces);
        for planar in [true, false] {
            let (frame, settings) = (frame(planar), Settings::default());
            let view = View::new(&state, &frame, &settings);
            for measure in ALL {
                let Ok(found) = measure.of(&view) else { continue };
                let width = measure.profile().map_or(0, |profile| profile.columns.len());
                assert_eq!(found.values.len(), measure.columns().len(), "{}", measure.name());
                assert!(found.rows.iter().all(|row| row.len() == width), "{}", measure.name());
                let finite = |cell: &Cell| cell.is_none_or(f64::is_finite);
                assert!(found.values.iter().chain(found.rows.iter().flatten()).all(finite), "{}", measure.name());
            }
        }
    }
}

#[test]
fn numbers_that_are_not_are_refused_with_their_place() {
    let mut bad = bodies([(BALL, DVec3::ZERO, DQuat::IDENTITY), (BALL, DVec3::X * f64::NAN, DQuat::IDENTITY)]);
    let states = States::single("mine", state(bad.clone(), None));
    let refused = |states: &States| {
        collect::measure_in(frame(true), states, 0, &ALL, &Settings::default(), &mut |_, _| true).err().unwrap()
    };
    assert_eq!(refused(&states).to_string(), "mine: body 1: its position is not finite");
    bad.position[1] = DVec3::X;
    bad.orientation[0] = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    assert!(refused(&States::single("mine", state(bad.clone(), None))).to_string().contains("body 0: its orientation"));
    bad.shape[0] = Shape::Spherocylinder { diameter: 1.0, length: 0.5 };
    bad.orientation[0] = DQuat::IDENTITY;
    assert!(refused(&States::single("mine", state(bad, None))).to_string().contains("body 0: its shape cannot be"));
    let good = States::single("mine", state(square(2, BALL, |_| DQuat::IDENTITY), None));
    let stopped = collect::measure_in(frame(true), &good, 0, &ALL, &Settings::default(), &mut |_, _| false);
    assert!(matches!(stopped, Err(MeasureError::Stopped { done: 0, all: 1 })));
}

/// A square of touching balls whose groups are given by their places.
fn coloured(side: usize, group: impl Fn(usize, usize) -> u32) -> Snapshot {
    let mut bodies = square(side, BALL, |_| DQuat::IDENTITY);
    (0..side * side).for_each(|k| bodies.group[k] = group(k % side, k / side));
    state(bodies, None)
}

#[test]
fn a_chessboard_has_no_contact_within_a_group_and_two_halves_have_few_between() {
    let side = 20_usize;
    let (all, half) = ((side * side) as f64, (side * side / 2) as f64);
    let alike = (half - 1.0) / (all - 1.0);
    let pairs = 2.0 * (side * (side - 1)) as f64;
    let board = of("segregation", &coloured(side, |x, y| ((x + y) % 2) as u32), true);
    assert_near(value(&board, "segregation", "segregation_pairs"), pairs, 0.0);
    assert_near(value(&board, "segregation", "segregation"), 0.0, 0.0);
    assert_near(value(&board, "segregation", "assortativity"), -1.0, 1e-12);
    let halves = of("segregation", &coloured(side, |x, _| u32::from(x >= side / 2)), true);
    let own = 1.0 - side as f64 / pairs;
    assert_near(value(&halves, "segregation", "segregation_own"), own, 1e-15);
    assert_near(value(&halves, "segregation", "segregation_random"), alike, 1e-15);
    assert_near(value(&halves, "segregation", "segregation"), own / alike, 1e-14);
    assert_near(value(&halves, "segregation", "assortativity"), 2.0 * own - 1.0, 1e-14);
    let one = of_settings("segregation", &coloured(side, |_, _| NO_GROUP), true, &Settings::default());
    assert_eq!(one.unwrap_err(), LeftOut("all bodies are of one group".into()));
}

#[test]
fn a_random_mixture_is_not_segregated() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let (side, draws) = (60_usize, (0..3600).map(|_| u32::from(random.random::<f64>() < 0.3)).collect::<Vec<_>>());
    let mixed = of("segregation", &coloured(side, |x, y| draws[y * side + x]), true);
    let random = value(&mixed, "segregation", "segregation_random").unwrap();
    let pairs = value(&mixed, "segregation", "segregation_pairs").unwrap();
    // Pairs that share a body are nearly independent.
    let error = ((1.0 - random) / random / pairs).sqrt();
    assert_near(value(&mixed, "segregation", "segregation"), 1.0, 3.0 * error);
    assert_near(value(&mixed, "segregation", "assortativity"), 0.0, 4.0 / pairs.sqrt());
}

#[test]
fn groups_are_counted_with_their_lengths() {
    let mut rods = bodies((0..5).map(|k| (ROD, DVec3::X * 9.0 * k as f64, lying(0.0))));
    rods.push(Placed { shape: BALL, position: DVec3::Y * 9.0, orientation: DQuat::IDENTITY }, NO_GROUP);
    rods.group = vec![0, 0, 2, 0, NO_GROUP, 2];
    let found = of("groups", &state(rods, None), false);
    let numbers = [3.0, 3.0, 1.0, 0.5, 1.0 - (6.0 + 2.0) / 30.0];
    found.values.iter().zip(numbers).for_each(|(found, expected)| assert_near(*found, expected, 1e-15));
    let row = |group: f64, bodies: f64, length: f64| {
        vec![group, bodies, bodies / 6.0, length, 3.0].into_iter().map(Some).collect::<Vec<_>>()
    };
    assert_eq!(found.rows, [row(0.0, 1.0, 3.0), row(1.0, 3.0, 9.0), row(3.0, 2.0, 3.0)]);
}

#[test]
fn bodies_that_left_are_counted_by_rule_and_per_time() {
    let left = |removed: Vec<u64>, there: usize| {
        let mut state = state(square(10, BALL, |_| DQuat::IDENTITY), None);
        state.bodies.retain(&(0..100).map(|k| k < there).collect::<Vec<_>>());
        state.removed = removed;
        let removes = Frame { removes: true, ..frame(true) };
        select(&["removal".into()]).unwrap()[0].of(&View::new(&state, &removes, &Settings::default()))
    };
    let mut found = [left(Vec::new(), 100), left(vec![10, 0], 90), left(vec![12, 8], 80)];
    removal::Removed.over_time(&[0.0, 0.5, 1.5], &mut found);
    let numbers = found.map(|found| found.unwrap().values);
    assert_eq!(numbers[0], [Some(0.0), Some(0.0), None]);
    assert_eq!(numbers[1], [Some(10.0), Some(0.1), Some(20.0)]);
    assert_eq!(numbers[2], [Some(20.0), Some(0.2), Some(10.0)]);
    let none = of_settings("removal", &coloured(2, |_, _| 0), true, &Settings::default());
    assert_eq!(none.unwrap_err(), LeftOut("the scene removes no bodies".into()));
}
