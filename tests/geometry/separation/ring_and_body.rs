//! A ring and an ellipsoid against a search round the ring, with the distance to the ellipsoid by halving.

use super::{check_sound, pair, size};
use crate::directions::{direction, turn};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::internals::separation::branches;
use relcp::separation::Placed;
use relcp::shape::Shape;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Poses of each kind; `RELCP_POSES=N` for more.
fn poses() -> usize {
    std::env::var("RELCP_POSES").ok().and_then(|n| n.parse().ok()).unwrap_or(400)
}

/// The signed distance of a point to an ellipsoid about the origin in its own axes: `y = a^2 p / (t + a^2)` with the
/// root `t > -a_min^2` of `sum (a p / (t + a^2))^2 = 1`, and on the focal set the rest along the least axis.
fn to_ellipsoid(radii: DVec3, p: DVec3) -> f64 {
    // Below this a component is none, so that its square is a number.
    let p = p.map(|x| if x.abs() < 1e-150 { 0.0 } else { x });
    let squares = radii * radii;
    let least = squares.min_element();
    let excess = (squares - least).map(|x| x.max(0.0));
    let sum = |tau: f64| {
        let w = radii * p;
        (0..3).map(|i| if w[i] == 0.0 { 0.0 } else { (w[i] / (tau + excess[i])).powi(2) }).sum::<f64>()
    };
    let (mut low, mut high) = (0.0, (radii * p).length() + least);
    if sum(f64::MIN_POSITIVE) <= 1.0 {
        // On the focal set.
        let flat = sum(f64::MIN_POSITIVE);
        let axis = (0..3).find(|i| excess[*i] == 0.0).unwrap();
        let mut y = DVec3::ZERO;
        for i in 0..3 {
            y[i] = if excess[i] > 0.0 { squares[i] * p[i] / excess[i] } else { 0.0 };
        }
        y[axis] = radii[axis] * (1.0 - flat).max(0.0).sqrt();
        return -(y - p).length();
    }
    for _ in 0..1100 {
        let middle = if low > 0.0 { 0.5 * (low + high) } else { high * 1e-3 };
        if middle <= low || middle >= high || high < 1e-300 {
            break;
        }
        if sum(middle) > 1.0 { low = middle } else { high = middle }
    }
    let tau = 0.5 * (low + high);
    // `|y - p|` is `|t p / (t + a^2)|`, whose sign is that of `t`; the normal is along `p / (t + a^2)`.
    let mut n = DVec3::ZERO;
    for i in 0..3 {
        n[i] = if p[i] == 0.0 { 0.0 } else { p[i] / (tau + excess[i]) };
    }
    let n = n.normalize();
    n.dot(p) - (radii * n).length()
}

/// The least of the signed distances of the ring's centreline, by samples and golden section about each of the lowest.
fn nearest_of_all(ring: &Placed, other: &Placed, samples: usize) -> f64 {
    let (Shape::Torus { major_radius, .. }, Shape::Ellipsoid { radii }) = (ring.shape, other.shape) else { panic!() };
    let to_body = |v: DVec3| other.orientation.inverse() * v;
    let centre = to_body(ring.position - other.position);
    let [first, second] = [DVec3::X, DVec3::Y].map(|v| to_body(ring.orientation * v) * major_radius);
    let distance =
        |angle: f64| to_ellipsoid(DVec3::from_array(radii), centre + first * angle.cos() + second * angle.sin());
    let step = TAU / samples as f64;
    let values: Vec<f64> = (0..samples).map(|i| distance(step * i as f64)).collect();
    let mut lowest: Vec<usize> = (0..samples)
        .filter(|i| values[*i] <= values[(i + 1) % samples] && values[*i] <= values[(i + samples - 1) % samples])
        .collect();
    lowest.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut best = values.iter().copied().fold(f64::INFINITY, f64::min);
    for i in lowest.into_iter().take(4) {
        let (mut low, mut high) = (step * (i as f64 - 1.0), step * (i as f64 + 1.0));
        for _ in 0..60 {
            let (left, right) = (low + 0.382 * (high - low), high - 0.382 * (high - low));
            let (at_left, at_right) = (distance(left), distance(right));
            best = best.min(at_left).min(at_right);
            if at_left < at_right { high = right } else { low = left }
        }
    }
    best
}

/// How far the separation is above the least distance that the search finds, and the point found from the ring and the
/// ellipsoid, as parts of the size. Of a point that is on both no search can say that it is too near.
fn errors(ring: &Placed, other: &Placed, samples: usize) -> [f64; 2] {
    let s = pair(ring, other);
    check_sound(ring, other, &s);
    let flipped = pair(other, ring);
    assert_eq!((flipped.separation, flipped.normal, flipped.lever_b), (s.separation, -s.normal, s.lever_a));
    let (Shape::Torus { major_radius, minor_radius }, Shape::Ellipsoid { radii }) = (ring.shape, other.shape) else {
        panic!()
    };
    let size = size(ring, other);
    let found = s.separation + minor_radius;
    let centre = ring.orientation.inverse() * (s.lever_a - s.normal * minor_radius);
    let off_ring = (centre.truncate().length() - major_radius).hypot(centre.z);
    let on_body = other.orientation.inverse() * (ring.position - other.position + s.lever_a - s.normal * minor_radius);
    let there = to_ellipsoid(DVec3::from_array(radii), on_body);
    let best = nearest_of_all(ring, other, samples);
    [(found - best).max(0.0) / size, off_ring.max((there - found).abs()) / size]
}

fn random_radii(aspect: f64, random: &mut ChaCha8Rng) -> [f64; 3] {
    std::array::from_fn(|_| aspect.powf(random.random_range(-0.5..0.5)))
}

fn ring_of(major_radius: f64, position: DVec3, orientation: DQuat) -> Placed {
    Placed { shape: Shape::Torus { major_radius, minor_radius: 0.1 * major_radius }, position, orientation }
}

fn worst(what: &str, poses: impl Iterator<Item = (Placed, Placed)>, samples: usize, most: f64) {
    let mut worst = [0.0_f64; 2];
    for (ring, other) in poses {
        let found = errors(&ring, &other, samples);
        assert!(found[0] < most && found[1] < 1e-12, "{found:?} {ring:?} {other:?}");
        worst = [0, 1].map(|k| worst[k].max(found[k]));
    }
    eprintln!("{what}: separations to {:.1e}, points to {:.1e} of the size", worst[0], worst[1]);
}

#[test]
fn a_ring_is_nearest_to_an_ellipsoid_where_a_search_round_it_says() {
    let mut random = ChaCha8Rng::seed_from_u64(48);
    let random = &mut random;
    for aspect in [1.5, 10.0, 100.0] {
        let poses = (0..poses() / 3).map(|_| {
            let other = Shape::Ellipsoid { radii: random_radii(aspect, random) };
            let radius = aspect.sqrt().powf(random.random_range(-1.0..1.0));
            let ring = ring_of(radius, DVec3::ZERO, turn(random));
            let reach = radius + other.bounding_radius();
            let position = direction(random) * random.random_range(0.0..reach);
            (ring, Placed { shape: other, position, orientation: turn(random) })
        });
        worst(&format!("random, aspect {aspect}"), poses.collect::<Vec<_>>().into_iter(), 2000, 1e-12);
    }
}

/// Concentric, coaxial, in the ring's plane, through its hole, touching, deep, of nearly or exactly equal radii, all
/// with tilts and displacements from nothing to a tenth.
#[test]
fn degenerate_places_of_a_ring_and_an_ellipsoid_are_as_a_search_says() {
    let mut random = ChaCha8Rng::seed_from_u64(49);
    let random = &mut random;
    let poses: Vec<(Placed, Placed)> = (0..poses())
        .map(|k| {
            let radii = match k % 6 {
                0 => [1.0; 3],
                1 => [1.0, 1.0, random.random_range(0.02..50.0)],
                2 => [0.2, 0.2, 20.0],
                3 => [1.0, 0.5, 0.5],
                4 => [1.0, 1.0 + 1e-9, 1.0 - 1e-7],
                _ => random_radii(20.0, random),
            };
            let radius = *[1.0, 1.0 + 1e-10, 0.5, 2.0, radii[0].hypot(radii[1])].get(k / 6 % 5).unwrap();
            let little = |random: &mut ChaCha8Rng| match random.random_range(0..4) {
                0 => DVec3::ZERO,
                1 => direction(random) * 1e-300,
                _ => direction(random) * 10f64.powf(random.random_range(-16.0..-1.0)),
            };
            let tilt = DQuat::from_scaled_axis(little(random));
            let quarter = [DQuat::IDENTITY, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_2)];
            let along = [DVec3::ZERO, DVec3::Z, DVec3::X * radius, DVec3::Y * (radius + radii[1])];
            let place = along[k / 30 % 4] * [1.0, 0.3, radii[2]][k / 120 % 3];
            let ring = ring_of(radius, DVec3::ZERO, DQuat::IDENTITY);
            let shape = Shape::Ellipsoid { radii };
            let orientation = tilt * quarter[k / 7 % 3];
            let mut other = Placed { shape, position: place + little(random), orientation };
            if k % 4 == 0 {
                // Touching, up to rounding.
                for _ in 0..3 {
                    let s = pair(&ring, &other);
                    other.position -= s.normal * s.separation;
                }
            }
            (ring, other)
        })
        .collect();
    worst("degenerate", poses.into_iter(), 720, 1e-12);
}

/// A thin egg in a ring that it just fills touches at both tips; a ring round its middle at both sides of its broader
/// axis; the branches are the minima, and the least is the separation.
#[test]
fn a_ring_has_a_branch_for_each_minimum_towards_an_ellipsoid() {
    let mut random = ChaCha8Rng::seed_from_u64(50);
    let mut counted = [0; 6];
    for k in 0..300 {
        let radii = random_radii(10.0, &mut random);
        let radius = random.random_range(0.5..2.0);
        let ring = ring_of(radius, DVec3::ZERO, turn(&mut random));
        let spread = if k % 3 == 0 { 0.02 } else { 1.0 };
        let position = direction(&mut random) * random.random_range(0.0..spread);
        let other = Placed { shape: Shape::Ellipsoid { radii }, position, orientation: turn(&mut random) };
        let nearest = pair(&ring, &other);
        let mut all = Vec::new();
        branches(&ring, &other, &nearest, 0.1, |number, found| all.push((number, found)));
        let least = all.iter().map(|(_, found)| found.separation).fold(f64::INFINITY, f64::min);
        assert!((least - nearest.separation).abs() < 1e-12 * size(&ring, &other), "{all:?} {nearest:?}");
        let turned = pair(&other, &ring);
        branches(&other, &ring, &turned, 0.1, |number, found| {
            let same = all.iter().any(|(of, there)| *of == number && there.lever_a == found.lever_b);
            assert!(same, "{number} {found:?} {all:?}");
        });
        counted[all.len()] += 1;
    }
    assert!(counted[2] > 20, "{counted:?}");
    let tips = Placed {
        shape: Shape::Ellipsoid { radii: [0.4, 0.4, 0.95] },
        position: DVec3::new(1e-3, 0.0, 0.0),
        orientation: DQuat::from_rotation_y(FRAC_PI_2),
    };
    let ring = Placed {
        shape: Shape::Torus { major_radius: 1.0, minor_radius: 0.05 },
        position: DVec3::ZERO,
        orientation: DQuat::IDENTITY,
    };
    let nearest = pair(&ring, &tips);
    let mut found = Vec::new();
    branches(&ring, &tips, &nearest, 0.01, |_, at| found.push(at.separation));
    found.sort_by(f64::total_cmp);
    assert!(found.len() == 2 && (found[0] + 1e-3).abs() < 1e-12 && (found[1] - 1e-3).abs() < 1e-12, "{found:?}");
}
