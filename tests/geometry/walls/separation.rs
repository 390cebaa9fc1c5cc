//! Separations of bodies from surfaces.

use crate::directions::turn;
use crate::{KINDS, random_shape};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::internals::separation::Surface;
use relcp::separation::Placed;
use relcp::shape::Shape;
use std::f64::consts::{PI, TAU};

const POSES: usize = 30;

/// A point of the surface by two parameters in the unit square.
fn surface_point(body: &Placed, u: f64, v: f64) -> DVec3 {
    let ball = |u: f64, v: f64| {
        let (polar, azimuth) = (PI * u, TAU * v);
        DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
    };
    let local = match body.shape {
        Shape::Sphere { radius } => radius * ball(u, v),
        Shape::Spherocylinder { diameter, length } => {
            let n = ball(u, v);
            0.5 * diameter * n + DVec3::Z * (0.5 * (length - diameter)).copysign(n.z)
        }
        Shape::Ellipsoid { radii } => DVec3::from_array(radii) * ball(u, v),
        Shape::Torus { major_radius, minor_radius } => {
            let ((s, c), (t, d)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
            DVec3::new((major_radius + minor_radius * d) * c, (major_radius + minor_radius * d) * s, minor_radius * t)
        }
        Shape::Convex(shape) => shape.point(ball(u, v)),
        other => panic!("{other:?}"),
    };
    body.position + body.orientation * local
}

/// How far a point is inside, by definition.
fn inside(surface: &Surface, p: DVec3) -> f64 {
    match *surface {
        Surface::Plane { point, normal } => (p - point).dot(normal),
        Surface::Sphere { centre, radius } => radius - p.distance(centre),
        Surface::Cylinder { centre, axis, radius } => radius - (p - centre).cross(axis).length(),
    }
}

/// The least of `inside` over the body: a grid, then ever finer grids about the best few places.
fn brute_force(surface: &Surface, body: &Placed) -> f64 {
    const SIDE: usize = 60;
    let at = |u: f64, v: f64| inside(surface, surface_point(body, u, v));
    let mut grid: Vec<(f64, f64, f64)> = (0..=SIDE)
        .flat_map(|i| (0..=SIDE).map(move |j| (i as f64 / SIDE as f64, j as f64 / SIDE as f64)))
        .map(|(u, v)| (at(u, v), u, v))
        .collect();
    grid.sort_by(|a, b| a.0.total_cmp(&b.0));
    let refine = |&(value, u, v): &(f64, f64, f64)| {
        let (mut best, mut width) = ((value, u, v), 1.0 / SIDE as f64);
        while width > 1e-9 {
            let (_, u, v) = best;
            for i in -3..=3 {
                for j in -3..=3 {
                    let (u, v) = (u + width * f64::from(i) / 3.0, v + width * f64::from(j) / 3.0);
                    let value = at(u, v);
                    if value < best.0 {
                        best = (value, u, v);
                    }
                }
            }
            width *= 0.6;
        }
        best.0
    };
    grid.iter().take(8).map(refine).fold(f64::INFINITY, f64::min)
}

fn surfaces(random: &mut ChaCha8Rng, size: f64) -> [Surface; 3] {
    let unit = |random: &mut ChaCha8Rng| turn(random) * DVec3::Z;
    let centre = size * unit(random) * random.random_range(0.0..1.0);
    let radius = size * random.random_range(0.5..4.0);
    [
        Surface::Plane { point: centre, normal: unit(random) },
        Surface::Sphere { centre, radius },
        Surface::Cylinder { centre, axis: unit(random), radius },
    ]
}

fn check(surface: &Surface, body: &Placed) -> f64 {
    let found = surface.separation(body);
    let size = body.shape.bounding_radius() + 1.0;
    assert!(found.normal.is_normalized() && found.lever_b == DVec3::ZERO, "{found:?}");
    // The touching point lies on the surface of the body and has the gap that is told, along the normal that is told.
    let point = body.position + found.lever_a;
    assert!((inside(surface, point) - found.separation).abs() < 1e-9 * size, "{surface:?} {body:?}: {found:?}");
    assert!(inside(surface, point + found.separation * found.normal).abs() < 1e-9 * size);
    assert!(surface.bound(body) <= found.separation + 1e-12 * size);
    (found.separation - brute_force(surface, body)).abs() / size
}

#[test]
fn separations_are_the_least_over_the_surface_of_the_body() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for kind in KINDS {
        let mut worst = [0.0_f64; 3];
        for pose in 0..POSES {
            let aspect = [2.0, 5.0][pose % 2];
            let shape = random_shape(kind, aspect, &mut random);
            for (k, surface) in surfaces(&mut random, aspect).iter().enumerate() {
                let position = (turn(&mut random) * DVec3::X) * aspect * random.random_range(0.0..1.0);
                let body = Placed { shape, position, orientation: turn(&mut random) };
                worst[k] = worst[k].max(check(surface, &body));
            }
        }
        println!("{kind}: plane {:.1e}, sphere {:.1e}, cylinder {:.1e}", worst[0], worst[1], worst[2]);
        assert!(worst.iter().all(|w| *w < 1e-8), "{kind}: {worst:?}");
    }
}

/// Poses where the farthest point is not unique, or a direction vanishes.
#[test]
fn symmetric_poses_have_a_separation_too() {
    let orientations = [DQuat::IDENTITY, DQuat::from_rotation_x(0.5 * PI), DQuat::from_rotation_y(0.5 * PI)];
    let shapes = [
        Shape::Sphere { radius: 1.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 1.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 3.0 },
        Shape::Ellipsoid { radii: [1.0, 1.0, 1.0] },
        Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] },
        Shape::Ellipsoid { radii: [2.0, 2.0, 1.0] },
        Shape::Ellipsoid { radii: [1.0, 1.5, 2.0] },
        Shape::Torus { major_radius: 1.0, minor_radius: 0.2 },
    ];
    let walls = [
        Surface::Plane { point: DVec3::ZERO, normal: DVec3::Z },
        Surface::Sphere { centre: DVec3::ZERO, radius: 3.0 },
        Surface::Cylinder { centre: DVec3::ZERO, axis: DVec3::Z, radius: 3.0 },
    ];
    let mut worst = 0.0_f64;
    for shape in shapes {
        for orientation in orientations {
            for position in [DVec3::ZERO, DVec3::X * 0.1, DVec3::Y * 0.3, DVec3::Z * 0.2, DVec3::new(0.2, 0.0, 0.4)] {
                for surface in &walls {
                    worst = worst.max(check(surface, &Placed { shape, position, orientation }));
                }
            }
        }
    }
    println!("worst {worst:.1e}");
    assert!(worst < 1e-8);
}

#[test]
fn thin_and_flat_bodies_keep_their_digits() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut worst = 0.0_f64;
    for _ in 0..200 {
        for radii in [[1.0, 1.0, 1000.0], [1000.0, 1000.0, 1.0], [1.0, 30.0, 1000.0]] {
            let body = Placed {
                shape: Shape::Ellipsoid { radii },
                position: 500.0 * (turn(&mut random) * DVec3::X),
                orientation: turn(&mut random),
            };
            for surface in surfaces(&mut random, 1000.0) {
                let found = surface.separation(&body);
                let (point, size) = (body.position + found.lever_a, 2000.0);
                // On the ellipsoid, and its normal there is the surface's.
                let on = (body.orientation.inverse() * found.lever_a) / DVec3::from_array(radii);
                assert!((on.length() - 1.0).abs() < 1e-9, "{on}");
                assert!((inside(&surface, point) - found.separation).abs() < 1e-12 * size);
                let normal = body.orientation * (on / DVec3::from_array(radii));
                // By definition nothing of the body is beyond its tangent plane; the separation is then not less than
                // this bound.
                let reach = (DVec3::from_array(radii) * (body.orientation.inverse() * found.normal)).length();
                worst = worst.max((reach - found.lever_a.dot(found.normal)).abs() / size);
                assert!(normal.dot(found.normal) > 0.0);
            }
        }
    }
    println!("worst {worst:.1e}");
    assert!(worst < 1e-12, "{worst:e}");
}
