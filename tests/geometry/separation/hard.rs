//! Pairs whose nearest points are not unique: fixed, finite and repeatable.

use super::{check_sound, pair, size};
use glam::{DQuat, DVec3};
use relcp::separation::{Placed, bound};
use relcp::shape::Shape;
use std::f64::consts::FRAC_PI_2;

fn rod(length: f64, position: DVec3, orientation: DQuat) -> Placed {
    Placed { shape: Shape::Spherocylinder { diameter: 1.0, length }, position, orientation }
}

#[test]
fn parallel_rods_touch_in_the_middle_of_the_interval_they_share() {
    let a = rod(5.0, DVec3::ZERO, DQuat::IDENTITY);
    let centre = DVec3::new(1.5, 0.0, 3.0);
    let exact = pair(&a, &rod(5.0, centre, DQuat::IDENTITY));
    assert_eq!(exact.lever_a, DVec3::new(0.5, 0.0, 1.5));
    assert_eq!(exact.lever_b, DVec3::new(-0.5, 0.0, -1.5));
    // A rounding of the angle, either way, does not move the contact point; a real angle moves it to an end, and
    // between them it goes continuously.
    for angle in [1e-16, -1e-16, 1e-15, -1e-15, 1e-14, -1e-14] {
        let s = pair(&a, &rod(5.0, centre, DQuat::from_scaled_axis(DVec3::Y * angle)));
        assert!((s.lever_a - exact.lever_a).length() < 1e-6, "{angle} {s:?}");
    }
    for (angle, end) in [(1e-9, 1.0), (-1e-9, 2.0)] {
        let s = pair(&a, &rod(5.0, centre, DQuat::from_scaled_axis(DVec3::Y * angle)));
        assert!((s.lever_a.z - end).abs() < 1e-6, "{angle} {s:?}");
    }
    let mut before = exact;
    for i in 0..4000 {
        let angle = 1e-15 * 1.0035f64.powi(i);
        let b = rod(5.0, centre, DQuat::from_scaled_axis(DVec3::Y * angle));
        let s = pair(&a, &b);
        check_sound(&a, &b, &s);
        assert!((s.lever_a - before.lever_a).length() < 1e-2 && (s.separation - 0.5).abs() < 1e-8);
        before = s;
    }
}

#[test]
fn rods_that_cross_or_share_a_line_have_a_fixed_normal() {
    let z = rod(5.0, DVec3::ZERO, DQuat::IDENTITY);
    let along_x = DQuat::from_rotation_y(FRAC_PI_2);
    let crossing = pair(&z, &rod(5.0, DVec3::ZERO, along_x));
    assert!((crossing.separation + 1.0).abs() < 1e-15 && (crossing.normal.y.abs() - 1.0).abs() < 1e-15);
    let lifted = pair(&z, &rod(5.0, DVec3::new(0.5, -1e-13, 0.3), along_x));
    assert!((lifted.normal + DVec3::Y).length() < 1e-12 && (lifted.separation + 1.0).abs() < 1e-12);
    let collinear = pair(&z, &rod(5.0, DVec3::Z * 2.0, DQuat::IDENTITY));
    assert!((collinear.separation + 1.0).abs() < 1e-15 && collinear.normal.z == 0.0);
    let in_line = pair(&z, &rod(5.0, DVec3::Z * 6.0, DQuat::IDENTITY));
    assert!((in_line.separation - 1.0).abs() < 1e-15 && in_line.normal == DVec3::Z);
    for (a, b) in [(z, z), (z, rod(1.0, DVec3::ZERO, along_x)), (rod(1.0, DVec3::ZERO, along_x), z)] {
        let s = pair(&a, &b);
        check_sound(&a, &b, &s);
        assert!((s.separation + 1.0).abs() < 1e-15);
    }
}

#[test]
fn hard_pairs_are_finite_and_repeatable() {
    let tilt = DQuat::from_scaled_axis(DVec3::new(0.3, -0.2, 0.9));
    let shapes = [
        Shape::Sphere { radius: 1.0 },
        Shape::Sphere { radius: 1000.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 1.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 100.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 1000.0 },
        Shape::Ellipsoid { radii: [1.0; 3] },
        Shape::Ellipsoid { radii: [1.0, 1.0, 100.0] },
        Shape::Ellipsoid { radii: [100.0, 100.0, 1.0] },
        Shape::Ellipsoid { radii: [1.0, 30.0, 1000.0] },
        Shape::Ellipsoid { radii: [1e-3; 3] },
        Shape::Torus { major_radius: 1.0, minor_radius: 0.1 },
        Shape::Torus { major_radius: 100.0, minor_radius: 0.1 },
    ];
    let places = [DVec3::ZERO, DVec3::Z, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Z * 2e3, DVec3::X * 1e-300];
    let turns = [DQuat::IDENTITY, tilt, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_2)];
    for (first, second) in shapes.iter().flat_map(|a| shapes.iter().map(move |b| (*a, *b))) {
        for (origin, place) in [0.0, 300.0, 1e6].iter().flat_map(|o| places.map(|p| (*o, p))) {
            for (turn_a, turn_b) in turns.iter().flat_map(|a| turns.map(|b| (*a, b))) {
                let origin = DVec3::splat(origin);
                let a = Placed { shape: first, position: origin, orientation: turn_a };
                let b = Placed { shape: second, position: origin + place, orientation: turn_b };
                let s = pair(&a, &b);
                check_sound(&a, &b, &s);
                assert_eq!(s, pair(&a, &b));
                assert!(bound(&a, &b, s.normal) <= s.separation + 1e-12 * size(&a, &b), "{a:?} {b:?} {s:?}");
            }
        }
    }
}
