//! Separations of custom shapes.

use crate::bodies::{die, egg, ellipsoid, placed, random, superball};
use crate::directions::{direction, turn};
use glam::{DQuat, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use relcp::internals::separation::{branches, planar_separation};
use relcp::separation::{Placed, Separation, bound, separation};
use relcp::shape::Shape;
use std::f64::consts::{FRAC_PI_2, TAU};

fn pair(a: &Placed, b: &Placed) -> Separation {
    separation(a, b, None).unwrap()
}

/// Two bodies brought to a separation drawn from a range, in parts of the smaller thickness.
fn brought(shapes: [Shape; 2], depths: [f64; 2], random: &mut ChaCha8Rng) -> [Placed; 2] {
    let a = placed(shapes[0], direction(random) * random.random_range(0.0..3.0), turn(random));
    let far = shapes[0].bounding_radius() + shapes[1].bounding_radius();
    let mut b = placed(shapes[1], a.position + direction(random) * far, turn(random));
    let least = shapes[0].thickness().min(shapes[1].thickness());
    let target = random.random_range(depths[0]..depths[1]) * least;
    for _ in 0..3 {
        let found = pair(&a, &b);
        b.position += found.normal * (target - found.separation);
    }
    [a, b]
}

fn near(custom: &Separation, own: &Separation, size: f64) -> bool {
    (custom.separation - own.separation).abs() < 1e-12 * size
        && custom.normal.abs_diff_eq(own.normal, 1e-6)
        && custom.lever_a.abs_diff_eq(own.lever_a, 1e-6 * size)
        && custom.lever_b.abs_diff_eq(own.lever_b, 1e-6 * size)
}

/// Ellipsoids up to an aspect ratio, each with its custom twin.
fn twins(aspect: f64, count: usize, random: &mut ChaCha8Rng) -> Vec<[Shape; 2]> {
    let mut twin = || {
        let radii = [1.0; 3].map(|_: f64| f64::powf(aspect, random.random_range(0.0..1.0)));
        [Shape::Ellipsoid { radii }, Shape::Convex(ellipsoid(radii))]
    };
    (0..count).map(|_| twin()).collect()
}

/// The worst of these separations are 5e-16 of the sizes off.
#[test]
fn ellipsoids_by_their_support_functions_are_as_far_apart_as_ellipsoids() {
    let random = &mut random(11);
    for (aspect, depths) in [(2.0, [-0.5, 0.5]), (5.0, [-0.3, 0.5]), (100.0, [-0.05, 0.5]), (1000.0, [-0.01, 0.5])] {
        let twins = twins(aspect, 6, random);
        let mut worst = 0_f64;
        for _ in 0..300 {
            let [first, second] = [0; 2].map(|_| twins[random.random_range(0..twins.len())]);
            let [a, b] = brought([first[0], second[0]], depths, random);
            let [custom_a, custom_b] = [Placed { shape: first[1], ..a }, Placed { shape: second[1], ..b }];
            let size = a.shape.bounding_radius() + b.shape.bounding_radius();
            let expected = pair(&a, &b);
            for (a, b) in [(custom_a, custom_b), (a, custom_b), (custom_a, b)] {
                let found = pair(&a, &b);
                worst = worst.max((found.separation - expected.separation).abs() / size);
                assert!(near(&found, &expected, size), "{a:?} {b:?} {found:?} {expected:?}");
            }
        }
        println!("{aspect}: {worst:e}");
    }
}

#[test]
fn rods_and_balls_are_as_far_from_a_custom_ellipsoid_as_from_an_ellipsoid() {
    let random = &mut random(12);
    for (aspect, depths) in [(2.0, [-1.0, 0.5]), (5.0, [-0.8, 0.5]), (50.0, [-0.05, 0.5]), (1000.0, [-0.01, 0.5])] {
        let twins = twins(aspect, 6, random);
        let mut worst = 0_f64;
        for k in 0..400 {
            let twin = twins[random.random_range(0..twins.len())];
            let length = random.random_range(1.0..2.0 * aspect);
            let other = match k % 2 {
                0 => Shape::Sphere { radius: 0.5 * length },
                _ => Shape::Spherocylinder { diameter: random.random_range(0.1..1.0), length },
            };
            let [a, b] = brought([twin[0], other], depths, random);
            let custom = Placed { shape: twin[1], ..a };
            let size = a.shape.bounding_radius() + b.shape.bounding_radius();
            let (found, expected) = (pair(&custom, &b), pair(&a, &b));
            worst = worst.max((found.separation - expected.separation).abs() / size);
            assert!(near(&found, &expected, size), "{custom:?} {b:?} {found:?} {expected:?}");
            let swapped = pair(&b, &custom);
            assert!((swapped.separation, swapped.normal) == (found.separation, -found.normal));
        }
        println!("{aspect}: {worst:e}");
    }
}

fn several() -> [Shape; 6] {
    [
        Shape::Convex(egg()),
        Shape::Convex(die(0.1)),
        Shape::Convex(die(0.3)),
        Shape::Ellipsoid { radii: [0.6, 0.8, 1.1] },
        Shape::Sphere { radius: 0.7 },
        Shape::Spherocylinder { diameter: 0.5, length: 2.5 },
    ]
}

/// The paper's definition on many normals: none has a larger bound, and the bound at the separation's own normal is the
/// separation.
#[test]
fn no_normal_has_a_larger_bound_and_points_are_on_the_surfaces() {
    let random = &mut random(13);
    let mut shapes = several().to_vec();
    shapes.insert(0, Shape::Convex(superball()));
    for _ in 0..400 {
        let chosen = [random.random_range(0..4), random.random_range(0..shapes.len())];
        let [a, b] = brought(chosen.map(|k| shapes[k]), [-0.4, 0.4], random);
        let found = pair(&a, &b);
        assert!((bound(&a, &b, found.normal) - found.separation).abs() < 1e-12, "{a:?} {b:?} {found:?}");
        for spread in [1.0, 0.1, 1e-3] {
            for _ in 0..100 {
                let n = (found.normal + spread * direction(random)).normalize();
                assert!(bound(&a, &b, n) <= found.separation + 1e-12, "{a:?} {b:?} {found:?} {n}");
            }
        }
        let between = b.position + found.lever_b - a.position - found.lever_a;
        // Without curvature a point is known to the cube root of rounding.
        let known = if chosen.contains(&0) { 1e-4 } else { 1e-6 };
        assert!(between.abs_diff_eq(found.separation * found.normal, known), "{a:?} {b:?} {found:?} {between}");
    }
}

#[test]
fn swapping_flips_the_normal_to_the_bit_and_a_warm_normal_changes_nothing_but_rounding() {
    let random = &mut random(14);
    let shapes = several();
    for k in 0..600 {
        let chosen = [random.random_range(0..3), random.random_range(0..shapes.len())];
        let depths = if k % 2 == 0 { [-0.9, -0.1] } else { [-0.1, 0.4] };
        let [a, b] = brought(chosen.map(|k| shapes[k]), depths, random);
        let found = pair(&a, &b);
        let swapped = pair(&b, &a);
        assert_eq!(
            swapped,
            Separation { normal: -found.normal, lever_a: found.lever_b, lever_b: found.lever_a, ..found }
        );
        for warm in [direction(random), -found.normal, (found.normal + 0.01 * direction(random)).normalize()] {
            let warmed = separation(&a, &b, Some(warm)).unwrap();
            assert!(near(&warmed, &found, 3.0), "{a:?} {b:?} {warm} {warmed:?} {found:?}");
        }
    }
}

/// The rate at which the separation changes as b is moved is the normal, and as it is turned `lever_b x n`.
#[test]
fn the_normal_and_the_levers_are_the_derivatives() {
    const STEP: f64 = 1e-5;
    let random = &mut random(15);
    let shapes = several();
    for _ in 0..100 {
        let chosen = [random.random_range(0..3), random.random_range(0..shapes.len())];
        let [a, b] = brought(chosen.map(|k| shapes[k]), [-0.05, 0.3], random);
        let found = pair(&a, &b);
        let along = direction(random);
        let moved = |way: f64| pair(&a, &Placed { position: b.position + way * along, ..b }).separation;
        let turned = |way: f64| {
            let orientation = DQuat::from_scaled_axis(way * along) * b.orientation;
            pair(&a, &Placed { orientation, ..b }).separation
        };
        let rate = |of: &dyn Fn(f64) -> f64| (of(STEP) - of(-STEP)) / (2.0 * STEP);
        assert!((rate(&moved) - found.normal.dot(along)).abs() < 1e-6, "{a:?} {b:?} {found:?}");
        let torque = found.lever_b.cross(found.normal);
        assert!((rate(&turned) - torque.dot(along)).abs() < 1e-6, "{a:?} {b:?} {found:?}");
    }
}

#[test]
fn hard_places_give_numbers() {
    let bodies = several();
    for a in &bodies[..3] {
        for b in &bodies {
            for turn in [DQuat::IDENTITY, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(0.3)] {
                for at in [DVec3::ZERO, DVec3::Z * 1e-9, DVec3::X * 1e-300, DVec3::new(0.1, 0.1, 0.1), DVec3::Z * 1e12]
                {
                    let (a, b) = (placed(*a, DVec3::ZERO, DQuat::IDENTITY), placed(*b, at, turn));
                    let found = pair(&a, &b);
                    let finite = found.normal.is_normalized() && found.lever_a.is_finite() && found.lever_b.is_finite();
                    assert!(finite && found.separation.is_finite(), "{a:?} {b:?} {found:?}");
                    let warmed = separation(&a, &b, Some(DVec3::Y)).unwrap();
                    let size = 1.0 + at.length();
                    assert!((warmed.separation - found.separation).abs() < 1e-12 * size, "{warmed:?} {found:?}");
                }
            }
        }
    }
}

/// A custom ellipsoid is as far from a ring as an ellipsoid, whose distance has a closed form, at each minimum.
#[test]
fn rings_are_as_far_from_custom_ellipsoids_as_from_ellipsoids() {
    let random = &mut random(19);
    let twins = twins(5.0, 6, random);
    let (mut worst, mut several) = (0_f64, 0);
    for k in 0..400 {
        let [own, custom] = twins[random.random_range(0..twins.len())];
        let major_radius = random.random_range(0.3..5.0);
        let shape = Shape::Torus { major_radius, minor_radius: 0.1 * major_radius };
        let ring = placed(shape, DVec3::ZERO, turn(random));
        let reach = if k % 4 == 0 { 1e-3 } else { major_radius + own.bounding_radius() };
        let place = direction(random) * random.random_range(0.0..reach);
        let (own, custom) = (placed(own, place, turn(random)), custom);
        let custom = Placed { shape: custom, ..own };
        let size = reach + major_radius;
        let (expected, found) = (pair(&ring, &own), pair(&ring, &custom));
        worst = worst.max((found.separation - expected.separation).abs() / size);
        let of = |other: &Placed, nearest: &Separation| {
            let mut all = Vec::new();
            branches(&ring, other, nearest, 0.2, |number, at| all.push((number, at)));
            all
        };
        let (expected, found) = (of(&own, &expected), of(&custom, &found));
        several += usize::from(found.len() > 1);
        // Deep inside, where a custom shape's least curvature is known less well, only the separation is compared.
        if expected.iter().all(|(_, at)| at.separation > -0.1 * major_radius) {
            assert_eq!(expected.len(), found.len(), "{ring:?} {own:?} {expected:?} {found:?}");
            for ((_, one), (_, other)) in expected.iter().zip(&found) {
                assert!((one.separation - other.separation).abs() < 1e-9 * size, "{one:?} {other:?}");
            }
        }
    }
    assert!(worst < 1e-12 && several > 40, "{worst:e} {several}");
}

/// No point of the ring is nearer to the die or the egg than the separation says; by samples of the ring, and of the
/// distance by the largest of the heights over planes that touch the body.
#[test]
fn rings_are_nearest_to_custom_shapes_where_a_search_says() {
    let random = &mut random(20);
    for k in 0..60 {
        let shape = Shape::Convex([die(0.1), egg(), superball()][k % 3]);
        let major_radius = random.random_range(0.3..3.0);
        let torus = Shape::Torus { major_radius, minor_radius: 0.1 };
        let ring = placed(torus, direction(random) * random.random_range(0.0..major_radius + 1.0), turn(random));
        let body = placed(shape, DVec3::ZERO, turn(random));
        let found = pair(&ring, &body);
        let ball = |angle: f64| {
            let at = ring.position + ring.orientation * DVec3::new(angle.cos(), angle.sin(), 0.0) * major_radius;
            pair(&placed(Shape::Sphere { radius: 0.1 }, at, DQuat::IDENTITY), &body).separation
        };
        let least = (0..2000).map(|i| ball(f64::from(i) * TAU / 2000.0)).fold(f64::INFINITY, f64::min);
        assert!(found.separation <= least + 1e-12, "{found:?} {least} {ring:?}");
        // The point found is the ring's, and as far from the body as a ball there.
        let centre = found.lever_a - found.normal * 0.1;
        let there = placed(Shape::Sphere { radius: 0.1 }, ring.position + centre, DQuat::IDENTITY);
        assert!((pair(&there, &body).separation - found.separation).abs() < 1e-12, "{found:?} {ring:?}");
        let centre = ring.orientation.inverse() * centre;
        assert!((centre.truncate().length() - major_radius).hypot(centre.z) < 1e-12, "{found:?} {ring:?}");
        let gap = body.position - ring.position + found.lever_b - found.lever_a;
        assert!((gap - found.normal * found.separation).length() < 1e-4, "{found:?}");
    }
}

/// An egg that lies in the plane, crossed deeply by a rod or another: its bound there must be the larger of its two
/// sides.
#[test]
fn in_the_plane_the_normal_stays_there() {
    let random = &mut random(16);
    let lying = |angle: f64| DQuat::from_rotation_z(angle) * DQuat::from_rotation_x(FRAC_PI_2);
    let rod = Shape::Spherocylinder { diameter: 0.5, length: 4.0 };
    for k in 0..60 {
        let mut angle = || random.random_range(0.0..6.0);
        let a = placed(Shape::Convex(egg()), DVec3::ZERO, lying(angle()));
        let (turned, other) = if k % 2 == 0 { (FRAC_PI_2, rod) } else { (0.0, a.shape) };
        let at = DVec3::new(0.1 * angle(), 0.05 * angle(), 0.0);
        let b = placed(other, at, lying(angle()) * DQuat::from_rotation_y(turned));
        let found = planar_separation(&a, &b, None).unwrap();
        assert!(found.normal.z.abs() < 1e-9, "{found:?}");
        for j in 0..360 {
            let angle = f64::from(j).to_radians();
            let n = DVec3::new(angle.cos(), angle.sin(), 0.0);
            assert!(bound(&a, &b, n) <= found.separation + 1e-9, "{a:?} {b:?} {found:?} {n}");
        }
        assert!((bound(&a, &b, found.normal) - found.separation).abs() < 1e-9, "{found:?}");
    }
}
