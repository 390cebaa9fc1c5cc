//! Rings against a search round their centrelines.

use super::{check_sound, pair, random_pair, size, to_centreline};
use crate::directions::{direction, turn};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::separation::Placed;
use relcp::shape::Shape;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A point of the ring's centreline.
fn on_ring(body: &Placed, angle: f64) -> DVec3 {
    let Shape::Torus { major_radius, .. } = body.shape else { panic!("not a ring") };
    body.position + body.orientation * DVec3::new(angle.cos(), angle.sin(), 0.0) * major_radius
}

/// No point of the ring's centreline is nearer than the separation says, and the points found are on both surfaces.
fn check_ring(ring: &Placed, other: &Placed) {
    let s = pair(ring, other);
    check_sound(ring, other, &s);
    let radius = 0.5 * ring.shape.thickness();
    let claimed = s.separation + radius + 0.5 * other.shape.thickness();
    let size = size(ring, other);
    let centre = ring.position + s.lever_a - s.normal * radius;
    assert!(to_centreline(ring, centre) < 1e-12 * size);
    assert!((to_centreline(other, centre) - claimed).abs() < 1e-12 * size, "{ring:?} {other:?}");
    let distance = |angle: f64| to_centreline(other, on_ring(ring, angle));
    let samples = 2000;
    let step = TAU / samples as f64;
    let nearest = (0..samples).map(|i| (distance(step * i as f64), step * i as f64));
    let (_, at) = nearest.min_by(|x, y| x.0.total_cmp(&y.0)).unwrap();
    let (mut low, mut high) = (at - step, at + step);
    while high - low > 1e-9 {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if distance(left) < distance(right) { high = right } else { low = left }
    }
    assert!(distance(low) >= claimed - 1e-9 * size, "{ring:?} {other:?} {} {claimed}", distance(low));
}

#[test]
fn rings_are_nearest_where_a_search_round_them_says() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for round in 0..300 {
        let kind = ["torus", "spherocylinder", "sphere"][round % 3];
        let (mut ring, mut other) = random_pair(["torus", kind], 10.0, &mut random);
        match (round / 3) % 4 {
            0 => other.position = ring.position + direction(&mut random) * random.random_range(0.0..3.0),
            // Nearly coaxial.
            1 => {
                let tilt = direction(&mut random) * 10f64.powf(random.random_range(-12.0..-1.0));
                other.orientation = DQuat::from_scaled_axis(tilt) * ring.orientation;
                other.position = ring.position + direction(&mut random) * 10f64.powf(random.random_range(-9.0..0.0));
            }
            // Passing near the middle, where the distance is not smooth.
            2 => {
                let off = direction(&mut random) * 10f64.powf(random.random_range(-8.0..-0.5));
                ring = Placed { position: DVec3::ZERO, orientation: DQuat::IDENTITY, ..ring };
                other.orientation = DQuat::from_scaled_axis(off) * DQuat::from_rotation_x(FRAC_PI_2);
                other.position = DVec3::X * other.shape.bounding_radius() + off;
            }
            _ => {}
        }
        check_ring(&ring, &other);
    }
}

#[test]
fn turning_a_pair_of_rings_does_not_lose_its_nearest_points() {
    let mut random = ChaCha8Rng::seed_from_u64(13);
    for round in 0..6000 {
        let radius = if round % 2 == 0 { 1.0 } else { 10f64.powf(random.random_range(-2.0..2.0)) };
        let ring = |major_radius, position, orientation| Placed {
            shape: Shape::Torus { major_radius, minor_radius: 1e-3 },
            position,
            orientation,
        };
        let reach = random.random_range(0.0..1.0 + radius);
        let (mut place, mut orientation) = (direction(&mut random) * reach, turn(&mut random));
        let tilt = direction(&mut random) * 10f64.powf(random.random_range(-12.0..0.0));
        match round % 3 {
            0 => {}
            1 => orientation = DQuat::from_scaled_axis(tilt),
            _ => {
                orientation = DQuat::from_scaled_axis(tilt) * DQuat::from_rotation_x(FRAC_PI_2);
                place = DVec3::X + direction(&mut random) * tilt.length();
            }
        }
        let (a, b) = (ring(radius, DVec3::ZERO, DQuat::IDENTITY), ring(1.0, place, orientation));
        let rotation = turn(&mut random);
        let spun = |p: &Placed| Placed {
            position: rotation * p.position,
            orientation: rotation * p.orientation * DQuat::from_rotation_z(1.234),
            ..*p
        };
        let (s, t) = (pair(&a, &b).separation, pair(&spun(&a), &spun(&b)).separation);
        assert!((s - t).abs() < 1e-10 * (1.0 + radius), "{a:?} {b:?} {s} {t}");
    }
}
