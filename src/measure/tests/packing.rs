//! Packing fractions, hulls, lengths and growth.

use super::*;
use crate::measure::packing::Packing;

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
fn lengths_and_their_histogram() {
    let rod = |length: f64| (Shape::Spherocylinder { diameter: 1.0, length }, DVec3::ZERO, lying(0.0));
    let found = of("length", &state(bodies([2.0, 2.1, 4.0, 3.9].map(rod)), None), true);
    assert_near(value(&found, "length", "length_mean"), 3.0, 1e-15);
    assert_near(value(&found, "length", "length_sd"), ((1.0 + 0.81) / 2.0_f64).sqrt(), 1e-14);
    let rows: Vec<[f64; 3]> = found.rows.iter().map(|row| [0, 1, 2].map(|k| row[k].unwrap())).collect();
    assert_eq!(rows, [[2.0625, 4.0, 2.0], [3.9375, 2.0, 1.0], [4.0625, 2.0, 1.0]]);
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
    // Growing rods; the outermost radius of a single one is half its length.
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

/// In a channel between two walls, one of which a load has moved, in one period; and in a ball.
#[test]
fn what_bodies_fill_inside_of_walls() {
    let disc = 0.25 * PI;
    let mut two = state(bodies([-1.0, 1.0].map(|x| (BALL, DVec3::new(x, 0.0, 0.0), DQuat::IDENTITY))), None);
    two.bodies.periods = crate::periodic::Periods::new([Some(4.0), None, None]);
    two.bodies.walls = vec![crate::walls::WallState { shift: 1.0, velocity: 0.0 }];
    let walls = |text: &str| Frame { walls: serde_json::from_str(text).unwrap(), ..frame(true) };
    let of = |state: &Snapshot, frame: &Frame| {
        let found = Packing.of(&View::new(state, frame, &Settings::default())).unwrap();
        value(&found, "packing", "packing_walls")
    };
    let piston = r#"[{"half_space": {"normal": [0, 1, 0], "offset": -2, "load": {"force": 1, "drag": 1}}},
        {"half_space": {"normal": [0, -1, 0], "offset": -3}}]"#;
    assert_near(of(&two, &walls(piston)), 2.0 * disc / 16.0, 1e-12);
    two.bodies.periods = crate::periodic::Periods::NONE;
    assert_eq!(of(&two, &walls(piston)), None, "open along x");
    assert_near(of(&two, &walls(r#"[{"sphere": {"center": [0, 0, 0], "radius": 2}}]"#)), 0.125, 1e-12);
}
