//! Separations of custom shapes.

use crate::bodies::{die, direction, egg, ellipsoid, placed, random, turn};
use glam::{DQuat, DVec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use relcp::separation::{Placed, Separation, bound, separation, supports};
use relcp::shape::Shape;

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
    (custom.separation - own.separation).abs() < 1e-10 * size
        && custom.normal.abs_diff_eq(own.normal, 1e-5)
        && custom.lever_a.abs_diff_eq(own.lever_a, 1e-5 * size)
        && custom.lever_b.abs_diff_eq(own.lever_b, 1e-5 * size)
}

#[test]
fn ellipsoids_by_their_support_functions_are_as_far_apart_as_ellipsoids() {
    let random = &mut random(11);
    let mut worst = 0_f64;
    for (aspect, depths, count) in [(2.0, [-0.5, 0.5], 400), (5.0, [-0.3, 0.5], 400), (100.0, [-0.05, 0.5], 100)] {
        for k in 0..count {
            if k % 20 == 0 {
                println!("{aspect} {k} {worst:e}");
            }
            let mut radii = || [1.0, 0.0, 0.0].map(|_: f64| f64::powf(aspect, random.random_range(0.0..1.0)));
            let own = [Shape::Ellipsoid { radii: radii() }, Shape::Ellipsoid { radii: radii() }];
            let [a, b] = brought(own, depths, random);
            let custom = |body: &Placed| match body.shape {
                Shape::Ellipsoid { radii } => Placed { shape: Shape::Convex(ellipsoid(radii)), ..*body },
                _ => *body,
            };
            let size = a.shape.bounding_radius() + b.shape.bounding_radius();
            let expected = pair(&a, &b);
            for (a, b) in [(custom(&a), custom(&b)), (a, custom(&b)), (custom(&a), b)] {
                let found = pair(&a, &b);
                worst = worst.max((found.separation - expected.separation).abs() / size);
                assert!(near(&found, &expected, size), "{a:?} {b:?} {found:?} {expected:?}");
            }
        }
    }
    println!("worst {worst:e}");
}
