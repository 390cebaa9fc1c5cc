//! Custom shapes and walls.

use crate::bodies::{die, egg, ellipsoid, placed, random};
use crate::directions::{direction, turn};
use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use relcp::internals::separation::Surface;
use relcp::separation::Placed;
use relcp::shape::Shape;

fn surfaces(random: &mut ChaCha8Rng) -> [Surface; 3] {
    let centre = 3.0 * direction(random);
    [
        Surface::Plane { point: centre, normal: direction(random) },
        Surface::Sphere { centre, radius: 5.0 },
        Surface::Cylinder { centre, axis: direction(random), radius: 5.0 },
    ]
}

fn anywhere(shape: Shape, random: &mut ChaCha8Rng) -> Placed {
    placed(shape, direction(random) * random.random_range(0.0..6.0), turn(random))
}

#[test]
fn a_custom_ellipsoid_is_as_far_from_a_wall_as_an_ellipsoid() {
    let random = &mut random(21);
    for radii in [[1.0, 1.0, 1.0], [0.5, 1.0, 2.0], [3.0, 0.2, 1.0], [0.3, 0.3, 4.0]] {
        let custom = Shape::Convex(ellipsoid(radii));
        for _ in 0..60 {
            let own = anywhere(Shape::Ellipsoid { radii }, random);
            for surface in surfaces(random) {
                let (found, expected) =
                    (surface.separation(&Placed { shape: custom, ..own }), surface.separation(&own));
                assert!(
                    (found.separation - expected.separation).abs() < 1e-12,
                    "{own:?} {surface:?} {found:?} {expected:?}"
                );
            }
        }
    }
}

/// The gap is the least over all points of the body, and it is attained at the lever's.
#[test]
fn no_point_of_the_body_is_nearer_to_the_wall() {
    let random = &mut random(22);
    for shape in [egg(), die(0.1), die(0.3)] {
        for _ in 0..60 {
            let body = anywhere(Shape::Convex(shape), random);
            for surface in surfaces(random) {
                let found = surface.separation(&body);
                let gap = |arm: DVec3| {
                    let ball = placed(Shape::Sphere { radius: 1e-9 }, body.position + arm, body.orientation);
                    surface.separation(&ball).separation + 1e-9
                };
                assert!((gap(found.lever_a) - found.separation).abs() < 1e-12, "{body:?} {surface:?} {found:?}");
                assert!(surface.bound(&body) <= found.separation + 1e-12);
                for spread in [3.0, 0.3, 0.03] {
                    for _ in 0..60 {
                        let n = body.orientation.inverse() * (found.normal + spread * direction(random)).normalize();
                        let arm = body.orientation * shape.point(n);
                        assert!(gap(arm) >= found.separation - 1e-9, "{body:?} {surface:?} {found:?} {arm}");
                    }
                }
            }
        }
    }
}

/// A body at the centre of a sphere, or on a tube's axis, is as far from it all round as it is thick there.
#[test]
fn a_body_in_the_middle_has_a_gap_too() {
    let body = placed(Shape::Convex(egg()), DVec3::ZERO, glam::DQuat::IDENTITY);
    let around = Surface::Sphere { centre: DVec3::ZERO, radius: 2.0 }.separation(&body);
    assert!((around.separation - (2.0 - egg().bounding_radius())).abs() < 1e-12, "{around:?}");
    let tube = Surface::Cylinder { centre: DVec3::ZERO, axis: DVec3::Z, radius: 2.0 }.separation(&body);
    let widest = egg().point(DVec3::X).x;
    assert!((tube.separation - (2.0 - widest)).abs() < 1e-12 && tube.normal.z.abs() < 1e-12, "{tube:?}");
}
