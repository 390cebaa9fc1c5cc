//! Superellipsoids at walls against the highest of their points over all normals, by a support function of its own.

use super::{poses, reach, superellipsoid};
use crate::bodies::{placed, random};
use crate::directions::{direction, turn};
use glam::DVec3;
use rand::RngExt;
use relcp::internals::separation::Surface;
use relcp::separation::Placed;

/// How far the body reaches along a unit vector from a point.
fn reach_from(body: &Placed, from: DVec3, n: DVec3) -> f64 {
    n.dot(body.position - from) + reach(&body.shape, body.orientation.inverse() * n)
}

/// The largest value over unit vectors of the span of these, which are at right angles: the best of many, each improved
/// by steps that become shorter.
fn largest(basis: &[DVec3], value: impl Fn(DVec3) -> f64) -> f64 {
    const ACROSS: i32 = 12;
    let side = |k: i32| f64::from(k) / f64::from(ACROSS);
    let mut starts: Vec<(f64, DVec3)> = Vec::new();
    let mut add = |n: DVec3| starts.push((value(n.normalize()), n.normalize()));
    for (i, j) in (-ACROSS..=ACROSS).flat_map(|i| (-ACROSS..=ACROSS).map(move |j| (side(i), side(j)))) {
        match *basis {
            [a, b, c] => {
                for (u, v, w) in [(a, b, c), (b, c, a), (c, a, b)] {
                    add(u + v * i + w * j);
                    add(-u + v * i + w * j);
                }
            }
            _ => {
                let [a, b] = [basis[0], basis[1]];
                [a + b * i, -a + b * i, b + a * j, -b + a * j].into_iter().for_each(&mut add);
            }
        }
    }
    starts.sort_by(|x, y| y.0.total_cmp(&x.0));
    starts.dedup_by(|x, y| x.1.distance(y.1) < 1e-9);
    let climbed = starts.into_iter().take(6).map(|(mut best, mut at)| {
        let mut step = 0.2;
        while step > 1e-13 {
            let ways = basis.iter().flat_map(|axis| [*axis, -*axis]);
            let pairs = ways.clone().flat_map(|a| ways.clone().map(move |b| a + b));
            let tried = pairs.map(|way| (at + way * step).normalize()).map(|n| (value(n), n));
            let next = tried.reduce(|x, y| if y.0 > x.0 { y } else { x }).unwrap();
            if next.0 > best {
                (best, at) = next;
            } else {
                step *= 0.5;
            }
        }
        best
    });
    climbed.fold(f64::NEG_INFINITY, f64::max)
}

fn expected(surface: &Surface, body: &Placed) -> f64 {
    match *surface {
        Surface::Plane { point, normal } => -reach_from(body, point, -normal),
        Surface::Sphere { centre, radius } => radius - largest(&DVec3::AXES, |n| reach_from(body, centre, n)),
        Surface::Cylinder { centre, axis, radius } => {
            let (a, b) = axis.any_orthonormal_pair();
            radius - largest(&[a, b], |n| reach_from(body, centre, n))
        }
    }
}

/// A pose in three at each kind of wall, half of them with a face parallel to it or a corner towards it.
#[test]
fn they_are_as_far_from_walls_as_their_farthest_points() {
    let random = &mut random(65);
    for exponents in [[2.0; 2], [2.5; 2], [4.0; 2], [8.0; 2], [10.0; 2], [2.0, 8.0], [10.0, 2.5]] {
        let mut worst = [0.0_f64; 2];
        for k in 0..poses() {
            let mut ratio = || 2f64.powf(random.random_range(-1.0..1.0));
            let shape = superellipsoid([ratio(), ratio(), ratio()], exponents);
            let (centre, axis) = (3.0 * direction(random), direction(random));
            let surface = match k % 3 {
                0 => Surface::Plane { point: centre, normal: axis },
                1 => Surface::Sphere { centre, radius: 6.0 },
                _ => Surface::Cylinder { centre, axis, radius: 6.0 },
            };
            let along = glam::DQuat::from_rotation_arc([DVec3::Z, DVec3::X, DVec3::ONE.normalize()][k / 6 % 3], axis);
            let tilt = glam::DQuat::from_scaled_axis(direction(random) * [0.0, 1e-9, 1e-3][k / 18 % 3]);
            let orientation = if k / 3 % 2 == 0 { turn(random) } else { (tilt * along).normalize() };
            let mut body = placed(shape, centre + direction(random) * random.random_range(0.0..5.0), orientation);
            let target = random.random_range(-0.3..0.5) * shape.thickness();
            for _ in 0..4 {
                let found = surface.separation(&body);
                body.position += found.normal * (found.separation - target);
            }
            let found = surface.separation(&body);
            let size = shape.bounding_radius() + 6.0;
            // The point found is the body's, and as far from the wall as the separation says.
            let point =
                placed(relcp::shape::Shape::Sphere { radius: 1e-9 }, body.position + found.lever_a, body.orientation);
            let own = (surface.separation(&point).separation + 1e-9 - found.separation).abs() / size;
            let off = (found.separation - expected(&surface, &body)).abs() / size;
            assert!(off < 1e-12 && own < 1e-12, "{off:e} {own:e} {surface:?} {body:?} {found:?}");
            worst = [worst[0].max(off), worst[1].max(own)];
        }
        eprintln!("at walls, exponents {exponents:?}: {worst:?}");
    }
}
