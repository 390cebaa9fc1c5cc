//! What is measured of a support function.

use crate::bodies::{EGG_CENTRE, die, egg, egg_point, ellipsoid, random};
use crate::directions::{direction, turn};
use glam::{DQuat, DVec3};
use rand::RngExt;
use relcp::shape::{Convex, ConvexError, Shape, SupportFunction};
use std::f64::consts::FRAC_PI_2;

#[test]
fn an_ellipsoid_by_its_support_function_measures_as_one() {
    for radii in [[1.0; 3], [1.0, 1.2, 1.5], [1.0, 1.0, 20.0], [1.0, 0.01, 0.5], [1000.0, 1.0, 30.0]] {
        let (custom, own) = (ellipsoid(radii), Shape::Ellipsoid { radii });
        assert!((custom.volume() / own.volume() - 1.0).abs() < 4e-6, "{radii:?}");
        assert!((custom.unit_inertia() / own.unit_inertia() - 1.0).abs().max_element() < 4e-6, "{radii:?}");
        assert!((custom.thickness() / own.thickness() - 1.0).abs() < 1e-14, "{radii:?}");
        assert!((custom.bounding_radius() / own.bounding_radius() - 1.0).abs() < 1e-14, "{radii:?}");
        let random = &mut random(1);
        for _ in 0..100 {
            let turn = turn(random);
            let off = Shape::Convex(custom).half_extents(turn) - own.half_extents(turn);
            assert!(off.abs().max_element() < 1e-13 * own.bounding_radius(), "{radii:?} {off}");
        }
    }
}

/// References by Gauss's quadrature of `h det H` over the normals, with nodes gathered at the edges.
#[test]
fn a_rounded_die_has_its_volume_and_inertia() {
    for (s, volume, moment, part) in [
        (0.3, 33.350704015245, 53.606975732634, 7e-6),
        (0.1, 18.539539788237, 20.694645243972, 5e-5),
        (0.05, 15.912058298558, 16.281875972126, 4e-4),
    ] {
        let die = die(s);
        assert!((die.volume() / volume - 1.0).abs() < part, "{s}: {}", die.volume() / volume - 1.0);
        assert!((die.unit_inertia() / moment - 1.0).abs().max_element() < part, "{s}: {}", die.unit_inertia() / moment);
        // Opposite faces are 2 (0.2 + sqrt(1 + s^2) + 2 s) apart, corners (the point for the diagonal) farther.
        assert!((die.thickness() - 2.0 * (0.2 + 1_f64.hypot(s) + 2.0 * s)).abs() < 1e-14);
        let corner = die.point(DVec3::ONE.normalize());
        assert!((die.bounding_radius() - corner.length()).abs() < 1e-14);
    }
}

#[test]
fn sizes_hold_all_points_of_an_asymmetric_body() {
    let egg = egg();
    let shape = Shape::Convex(egg);
    let random = &mut random(2);
    for _ in 0..1000 {
        let (turn, n) = (turn(random), direction(random));
        let point = egg.point(n);
        assert!(point.length() <= egg.bounding_radius() * (1.0 + 1e-14));
        assert!(egg.reach(n) + egg.reach(-n) >= egg.thickness() * (1.0 - 1e-3));
        assert!((shape.half_extents(turn) - (turn * point).abs()).min_element() >= 0.0);
    }
    assert!(egg.reach(DVec3::Z) > egg.reach(DVec3::NEG_Z) + 0.05);
    assert_eq!(shape.half_extents(DQuat::IDENTITY).z, egg.reach(DVec3::Z));
    assert_eq!(shape.half_extents(DQuat::from_rotation_x(std::f64::consts::PI)).z, egg.reach(DVec3::Z));
}

#[test]
fn the_centre_of_mass_is_named_and_can_be_taken_off() {
    let displaced = Convex::new(|n: DVec3| egg_point(n) + DVec3::new(0.1, -0.2, 0.3));
    let Err(ConvexError::OffCentre { centre }) = displaced else { panic!("{displaced:?}") };
    let centre = DVec3::from_array(centre);
    assert!(centre.abs_diff_eq(DVec3::new(0.1, -0.2, 0.3), 1e-6), "{centre}");
    let back = Convex::new(move |n: DVec3| egg_point(n) + DVec3::new(0.1, -0.2, 0.3) - centre).unwrap();
    assert!((back.volume() - egg().volume()).abs() < 1e-12 && EGG_CENTRE > 0.0);
}

struct Ball {
    volume: Option<f64>,
    inertia: Option<DVec3>,
}

impl SupportFunction for Ball {
    fn point(&self, n: DVec3) -> DVec3 {
        2.0 * n
    }

    fn volume(&self) -> Option<f64> {
        self.volume
    }

    fn unit_inertia(&self) -> Option<DVec3> {
        self.inertia
    }
}

#[test]
fn what_the_function_knows_better_is_taken_unless_it_is_far_off() {
    let own = Shape::Sphere { radius: 2.0 };
    let (volume, inertia) = (own.volume(), own.unit_inertia());
    let ball = Convex::new(Ball { volume: Some(volume), inertia: Some(inertia) }).unwrap();
    assert_eq!((ball.volume(), ball.unit_inertia()), (volume, inertia));
    assert_ne!(Convex::new(Ball { volume: None, inertia: None }).unwrap().volume(), volume);
    for wrong in [
        Ball { volume: Some(1.1 * volume), inertia: None },
        Ball { volume: Some(f64::NAN), inertia: None },
        Ball { volume: None, inertia: Some(inertia * DVec3::new(1.0, 1.0, 0.9)) },
    ] {
        let refused = Convex::new(wrong);
        assert!(matches!(refused, Err(ConvexError::Wrong { .. })), "{refused:?}");
    }
}

#[test]
fn a_shape_is_a_small_plain_value_equal_to_itself_alone() {
    let (one, other) = (die(0.1), die(0.1));
    assert!(one == one && one != other && other.id() > one.id());
    assert!(Shape::Convex(one) == Shape::Convex(one) && Shape::Convex(one) != Shape::Convex(other));
    assert_eq!(size_of::<Shape>(), 32);
    assert!(format!("{one:?}").contains("bounding_radius"));
}

#[test]
fn mirror_planes_are_seen() {
    let upright = |turn: DQuat| Shape::Convex(egg()).is_planar_symmetric(turn);
    assert!(!upright(DQuat::IDENTITY));
    assert!(!upright(DQuat::from_rotation_x(1.0)));
    assert!(upright(DQuat::from_rotation_x(FRAC_PI_2)) && upright(DQuat::from_rotation_y(-FRAC_PI_2)));
    let random = &mut random(3);
    for _ in 0..20 {
        let about_z = DQuat::from_rotation_z(random.random_range(0.0..6.0));
        assert!(upright(about_z * DQuat::from_rotation_x(FRAC_PI_2)));
    }
}
