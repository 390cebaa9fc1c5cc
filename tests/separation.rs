//! Separations against reference pairs, brute force and finite differences, and proxies against the surfaces.

#![allow(clippy::unwrap_used)]

use glam::{DMat3, DQuat, DVec3, DVec4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::separation::{Placed, Separation, bound, separation, supports};
use relcp::shape::{MAX_ASPECT, ProxyError, Shape, ShapeError};
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A reference pair, computed in extended precision.
#[derive(Deserialize)]
struct Pair {
    kind: String,
    a: Body,
    b: Body,
    normal: [f64; 3],
    separation: f64,
    point_a: Option<[f64; 3]>,
    point_b: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct Body {
    shape: Shape,
    position: [f64; 3],
    orientation: [f64; 4],
}

impl Body {
    fn placed(&self) -> Placed {
        let [w, x, y, z] = self.orientation;
        Placed {
            shape: self.shape,
            position: DVec3::from_array(self.position),
            orientation: DQuat::from_xyzw(x, y, z, w).normalize(),
        }
    }
}

fn reference_pairs() -> Vec<Pair> {
    let pairs: Vec<Pair> = serde_json::from_str(include_str!("data/pairs.json")).unwrap();
    assert_eq!(pairs.len(), 868);
    pairs
}

fn pair(a: &Placed, b: &Placed) -> Separation {
    separation(a, b, None).unwrap()
}

#[test]
fn reference_pairs_agree() {
    let (mut worst, mut worst_normal, mut worst_point) = (0.0_f64, 0.0_f64, 0.0_f64);
    for p in reference_pairs() {
        let (a, b) = (p.a.placed(), p.b.placed());
        let size = a.shape.bounding_radius().max(b.shape.bounding_radius());
        for warm in [None, Some(DVec3::from_array(p.normal))] {
            let s = separation(&a, &b, warm).unwrap();
            let error = (s.separation - p.separation).abs() / (1.0 + size);
            let turned = (s.normal - DVec3::from_array(p.normal)).length();
            worst = worst.max(error);
            worst_normal = worst_normal.max(turned);
            assert!(error < 1e-9, "{}: {} against {}", p.kind, s.separation, p.separation);
            assert!(turned < 1e-6, "{}: normal off by {turned:e}", p.kind);
            if let (Some(point_a), Some(point_b)) = (p.point_a, p.point_b) {
                let off = (a.position + s.lever_a - DVec3::from_array(point_a)).length();
                let off = off.max((b.position + s.lever_b - DVec3::from_array(point_b)).length());
                worst_point = worst_point.max(off);
                assert!(off < 1e-6 * (1.0 + size), "{}: point off by {off:e}", p.kind);
            }
        }
    }
    println!("worst error {worst:e}, normal {worst_normal:e}, point {worst_point:e}");
}

const KINDS: [&str; 4] = ["sphere", "spherocylinder", "ellipsoid", "torus"];

fn turn(random: &mut ChaCha8Rng) -> DQuat {
    loop {
        let v = DVec4::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        if (0.01..1.0).contains(&v.length_squared()) {
            return DQuat::from_vec4(v.normalize());
        }
    }
}

fn direction(random: &mut ChaCha8Rng) -> DVec3 {
    turn(random) * DVec3::Z
}

/// A random shape of a kind, its sizes within a factor of `aspect`.
fn shape(kind: &str, aspect: f64, random: &mut ChaCha8Rng) -> Shape {
    let mut ratio = || aspect.powf(random.random_range(0.0..1.0));
    match kind {
        "sphere" => Shape::Sphere { radius: ratio() },
        "spherocylinder" => Shape::Spherocylinder { diameter: 1.0, length: ratio() },
        "ellipsoid" => Shape::Ellipsoid { radii: [ratio(), 1.0, ratio()] },
        _ => Shape::Torus { major_radius: 1.0 + ratio(), minor_radius: 0.5 },
    }
}

/// A pair of these kinds in random poses, brought to a random separation, small beside the sizes.
fn random_pair(kinds: [&str; 2], aspect: f64, random: &mut ChaCha8Rng) -> (Placed, Placed) {
    let mut place = |kind| Placed {
        shape: shape(kind, aspect, random),
        position: direction(random) * random.random_range(0.0..aspect),
        orientation: turn(random),
    };
    let (a, mut b) = (place(kinds[0]), place(kinds[1]));
    let target = random.random_range(-0.2..0.5);
    for _ in 0..4 {
        let s = pair(&a, &b);
        b.position += s.normal * (target - s.separation);
    }
    (a, b)
}

/// Runs a check on random pairs of all supported kinds, near and far from round.
fn on_random_pairs(count: usize, aspects: &[f64], mut check: impl FnMut(&Placed, &Placed, &mut ChaCha8Rng)) {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for first in KINDS {
        for second in KINDS {
            let example = |kind| shape(kind, 2.0, &mut ChaCha8Rng::seed_from_u64(0));
            let supported = supports(&example(first), &example(second));
            assert_eq!(supported, !matches!((first, second), ("torus", "ellipsoid") | ("ellipsoid", "torus")));
            for &aspect in aspects.iter().filter(|_| supported) {
                for _ in 0..count {
                    let (a, b) = random_pair([first, second], aspect, &mut random);
                    check(&a, &b, &mut random);
                }
            }
        }
    }
}

fn size(a: &Placed, b: &Placed) -> f64 {
    a.shape.bounding_radius() + b.shape.bounding_radius() + (b.position - a.position).length()
}

fn is_convex(body: &Placed) -> bool {
    !matches!(body.shape, Shape::Torus { .. })
}

/// Finite, a unit normal, points that agree with the separation along it.
fn check_sound(a: &Placed, b: &Placed, s: &Separation) {
    let gap = b.position - a.position + s.lever_b - s.lever_a;
    assert!(s.separation.is_finite() && gap.is_finite(), "{a:?} {b:?} {s:?}");
    assert!((s.normal.length() - 1.0).abs() < 1e-14, "{a:?} {b:?} {s:?}");
    let off = (s.normal.dot(gap) - s.separation).abs();
    assert!(off < 1e-9 * (1.0 + size(a, b)), "{a:?} {b:?} {s:?} {off:e}");
}

#[test]
fn a_ring_with_an_ellipsoid_is_refused() {
    let at = |shape| Placed { shape, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    let ring = at(Shape::Torus { major_radius: 1.0, minor_radius: 0.1 });
    let ellipsoid = at(Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] });
    assert_eq!(separation(&ring, &ellipsoid, None), None);
    assert_eq!(separation(&ellipsoid, &ring, None), None);
}

#[test]
fn swapping_the_bodies_flips_the_normal_and_no_other_bit() {
    on_random_pairs(20, &[3.0, 100.0], |a, b, _| {
        let (s, t) = (pair(a, b), pair(b, a));
        assert_eq!((s.separation, s.normal, s.lever_a, s.lever_b), (t.separation, -t.normal, t.lever_b, t.lever_a));
    });
}

#[test]
fn a_rigid_motion_of_both_changes_nothing() {
    on_random_pairs(20, &[3.0, 100.0], |a, b, random| {
        let (rotation, shift) = (turn(random), direction(random) * random.random_range(0.0..300.0));
        let moved = |p: &Placed| Placed {
            position: rotation * p.position + shift,
            orientation: rotation * p.orientation,
            ..*p
        };
        let (s, t) = (pair(a, b), pair(&moved(a), &moved(b)));
        let error = (s.separation - t.separation).abs();
        assert!(error < 1e-12 * (300.0 + size(a, b)), "{a:?} {b:?} {error:e}");
    });
}

#[test]
fn points_agree_with_the_separation_and_lie_one_normal_apart() {
    on_random_pairs(50, &[1.5, 20.0, 100.0, 1000.0], |a, b, _| {
        let s = pair(a, b);
        check_sound(a, b, &s);
        let gap = b.position - a.position + s.lever_b - s.lever_a;
        let off = (gap - s.normal * s.separation).length() / size(a, b);
        assert!(off < 1e-11, "{a:?} {b:?} {off:e}");
    });
}

#[test]
fn a_warm_normal_changes_no_more_than_rounding() {
    on_random_pairs(20, &[3.0, 100.0], |a, b, random| {
        let s = pair(a, b);
        for warm in [s.normal, (s.normal + direction(random) * 0.1).normalize(), direction(random), DVec3::ZERO] {
            let t = separation(a, b, Some(warm)).unwrap();
            assert!((s.separation - t.separation).abs() < 1e-13 * size(a, b), "{a:?} {b:?} {warm} {s:?} {t:?}");
        }
    });
}

/// The largest bound over the sphere of normals, by random search from the best of many.
fn largest_bound(a: &Placed, b: &Placed, random: &mut ChaCha8Rng) -> f64 {
    let axes = [a, b].map(|p| DMat3::from_quat(p.orientation)).map(|m| [m.x_axis, m.y_axis, m.z_axis]);
    let mut starts: Vec<(f64, DVec3)> = (0..80)
        .map(|_| direction(random))
        .chain(axes.into_iter().flatten().flat_map(|u| [u, -u]))
        .map(|n| (bound(a, b, n), n))
        .collect();
    starts.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut best = f64::NEG_INFINITY;
    for &(mut value, mut normal) in &starts[..4] {
        let mut reach = 0.3;
        for _ in 0..60 {
            let tries = (0..8).map(|_| (normal + direction(random) * reach).normalize());
            let found = tries.map(|n| (bound(a, b, n), n)).max_by(|x, y| x.0.total_cmp(&y.0)).unwrap();
            if found.0 > value {
                (value, normal) = found;
            } else {
                reach *= 0.6;
            }
        }
        best = best.max(value);
    }
    best
}

#[test]
fn the_separation_is_the_largest_bound_of_convex_pairs() {
    on_random_pairs(6, &[2.0, 20.0, 1000.0], |a, b, random| {
        let s = pair(a, b);
        let size = size(a, b);
        let searched = largest_bound(a, b, random);
        assert!(searched <= s.separation + 1e-12 * size, "{a:?} {b:?} {} {searched}", s.separation);
        if is_convex(a) && is_convex(b) {
            assert!((bound(a, b, s.normal) - s.separation).abs() < 1e-12 * size, "{a:?} {b:?}");
        }
    });
}

#[test]
fn deep_and_concentric_bodies_have_the_largest_bound_too() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    for round in 0..200 {
        let kinds = [["ellipsoid", "ellipsoid"], ["ellipsoid", "spherocylinder"], ["sphere", "ellipsoid"]][round % 3];
        let (mut a, mut b) = random_pair(kinds, 10.0, &mut random);
        b.position = a.position + direction(&mut random) * random.random_range(0.0..1.0);
        if round % 5 == 0 {
            a.position = b.position;
        }
        let s = pair(&a, &b);
        check_sound(&a, &b, &s);
        assert!(largest_bound(&a, &b, &mut random) <= s.separation + 1e-12 * size(&a, &b), "{a:?} {b:?}");
    }
}

/// Distance from a point to the centreline of a ring or a segment, in closed form.
fn to_centreline(body: &Placed, point: DVec3) -> f64 {
    let p = body.orientation.inverse() * (point - body.position);
    match body.shape {
        Shape::Torus { major_radius, .. } => (p.x.hypot(p.y) - major_radius).hypot(p.z),
        Shape::Spherocylinder { diameter, length } => {
            let half = 0.5 * (length - diameter);
            (p - DVec3::Z * p.z.clamp(-half, half)).length()
        }
        _ => p.length(),
    }
}

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

/// A configuration moved by velocities for a time, by the quaternion rule of the method.
fn moved(body: &Placed, velocity: DVec3, spin: DVec3, time: f64) -> Placed {
    let rate = DQuat::from_xyzw(spin.x, spin.y, spin.z, 0.0) * body.orientation;
    Placed {
        position: body.position + velocity * time,
        orientation: (body.orientation + rate * (0.5 * time)).normalize(),
        ..*body
    }
}

#[test]
fn normal_and_torques_are_the_gradient() {
    let (mut checked, mut corners) = (0, 0);
    on_random_pairs(30, &[2.0, 10.0], |a, b, random| {
        let s = pair(a, b);
        let [va, wa, vb, wb] = std::array::from_fn(|_| direction(random));
        let slope = s.normal.dot(vb - va) + s.lever_b.cross(s.normal).dot(wb) - s.lever_a.cross(s.normal).dot(wa);
        let step = 1e-5;
        let pair_at = |time: f64| pair(&moved(a, va, wa, time), &moved(b, vb, wb, time));
        // Where two places tie, the separation has a corner and the normal jumps: no derivative to compare with.
        if [-2.0, -1.0, 1.0, 2.0].iter().any(|k| (pair_at(k * step).normal - s.normal).length() > 0.01) {
            corners += 1;
            return;
        }
        checked += 1;
        let at = |time: f64| pair_at(time).separation;
        let difference = (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
        assert!((slope - difference).abs() < 1e-6 * size(a, b), "{a:?} {b:?} {slope} {difference}");
    });
    println!("{checked} checked, {corners} corners");
    assert!(checked > 700 && corners < 20, "{checked} checked, {corners} corners");
}

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
        if !supports(&first, &second) {
            continue;
        }
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

#[test]
fn proxies_are_inside_tangent_and_reach_the_tips() {
    for (radii, count) in [([1.0, 1.0, 2.0], 3), ([1.0, 2.35, 1.0], 13), ([20.0, 1.0, 1.0], 27), ([1.0, 1.5, 3.0], 7)] {
        let shape = Shape::Ellipsoid { radii };
        let proxy = shape.proxy(count).unwrap();
        assert_eq!(proxy.len(), count);
        let largest = DVec3::from_array(radii);
        let major = largest.max_element();
        let mirrored = |i: usize| (proxy[i].centre + proxy[count - 1 - i].centre).length();
        assert!((0..count).all(|i| mirrored(i) < 1e-14 && proxy[i].radius == proxy[count - 1 - i].radius));
        assert!((proxy[count - 1].centre.length() + proxy[count - 1].radius - major).abs() < 1e-14 * major);
        assert!((proxy[count / 2].radius - largest.min_element()).abs() < 1e-15);
        let body = Placed { shape, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
        for sphere in &proxy {
            let centre = Shape::Sphere { radius: 1e-3 };
            let at = Placed { shape: centre, position: sphere.centre, orientation: DQuat::IDENTITY };
            let depth = -(pair(&body, &at).separation + 1e-3);
            assert!((depth - sphere.radius).abs() < 1e-13 * major, "{radii:?} {depth} {sphere:?}");
        }
        let grooves: Vec<f64> = proxy
            .windows(2)
            .map(|w| {
                let halfway = 0.5 * (w[0].centre + w[1].centre);
                let at = Placed { shape: Shape::Sphere { radius: 1e-3 }, position: halfway, ..body };
                (w[1].centre - w[0].centre).length_squared() / -(pair(&body, &at).separation + 1e-3)
            })
            .collect();
        assert!(grooves.iter().all(|g| (g / grooves[0] - 1.0).abs() < 1e-9), "{grooves:?}");
    }
    let oblate = Shape::Ellipsoid { radii: [2.0, 1.0, 2.0] };
    assert_eq!(oblate.proxy(7), Err(ProxyError::NoMajorAxis));
    assert_eq!(Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }.proxy(4), Err(ProxyError::Even { count: 4 }));
    assert_eq!(Shape::Ellipsoid { radii: [1.0; 3] }.proxy(5).unwrap().len(), 1);
    let cell = Shape::Spherocylinder { diameter: 0.5, length: 4.0 };
    let proxy = cell.proxy(5).unwrap();
    let heights: Vec<f64> = proxy.iter().map(|s| s.centre.z).collect();
    assert_eq!(heights, [-1.75, -0.875, 0.0, 0.875, 1.75]);
    assert!(proxy.iter().all(|s| s.radius == 0.25));
    assert_eq!(cell.proxy(1), Err(ProxyError::TooFew { count: 1, least: 3 }));
    let ring = Shape::Torus { major_radius: 1.0, minor_radius: 0.1 };
    assert_eq!(ring.proxy(31), Err(ProxyError::TooFew { count: 31, least: 32 }));
    let proxy = ring.proxy(32).unwrap();
    assert!((0..32).all(|i| (proxy[i].centre - proxy[(i + 1) % 32].centre).length() <= 0.2));
    assert_eq!(Shape::Sphere { radius: 1.0 }.proxy(1).unwrap().len(), 1);
}

/// Volume and moments of the points of a grid that are inside the shape.
fn by_grid(shape: Shape, cells: i32) -> (f64, DVec3) {
    let body = Placed { shape, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    let step = 2.0 * shape.half_extents(DQuat::IDENTITY) / f64::from(cells);
    let inside = |p: DVec3| match shape {
        Shape::Ellipsoid { radii } => (p / DVec3::from_array(radii)).length() <= 1.0,
        _ => to_centreline(&body, p) <= 0.5 * shape.thickness(),
    };
    let (mut volume, mut moments) = (0.0, DVec3::ZERO);
    for (i, j, k) in (0..cells * cells * cells).map(|n| (n % cells, n / cells % cells, n / cells / cells)) {
        let p = step * (DVec3::new(f64::from(i), f64::from(j), f64::from(k)) + 0.5 - 0.5 * f64::from(cells));
        if inside(p) {
            let square = p * p;
            volume += 1.0;
            moments += DVec3::splat(square.element_sum()) - square;
        }
    }
    let cell = step.element_product();
    (volume * cell, moments * cell)
}

#[test]
fn volume_and_inertia_are_those_of_the_solid() {
    for shape in [
        Shape::Sphere { radius: 1.5 },
        Shape::Spherocylinder { diameter: 1.0, length: 3.0 },
        Shape::Ellipsoid { radii: [1.0, 2.0, 3.0] },
        Shape::Torus { major_radius: 2.0, minor_radius: 0.7 },
    ] {
        let (volume, moments) = by_grid(shape, 120);
        assert!((volume / shape.volume() - 1.0).abs() < 2e-3, "{shape:?} {volume}");
        assert!((moments / shape.unit_inertia() - 1.0).abs().max_element() < 4e-3, "{shape:?} {moments}");
    }
}

#[test]
fn boxes_are_tight_and_in_the_bounding_sphere() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for round in 0..200 {
        let shape = shape(KINDS[round % 4], 30.0, &mut random);
        let body = Placed { shape, position: DVec3::ZERO, orientation: turn(&mut random) };
        let point = Shape::Sphere { radius: 1.0 };
        let extents = shape.half_extents(body.orientation);
        for (axis, extent) in DVec3::AXES.into_iter().zip(extents.to_array()) {
            // The bound of a unit ball far along an axis is its distance less the box.
            let ball = Placed { shape: point, position: axis * 100.0, orientation: DQuat::IDENTITY };
            let reach = 99.0 - bound(&body, &ball, axis);
            assert!((reach - extent).abs() < 1e-12 * shape.bounding_radius(), "{shape:?} {reach} {extent}");
        }
        assert!(extents.max_element() <= shape.bounding_radius() * (1.0 + 1e-15));
        assert_eq!(shape.major_axis(), 2.0 * shape.bounding_radius());
        assert!(shape.thickness() <= shape.major_axis());
    }
}

#[test]
fn impossible_shapes_are_refused_by_name() {
    let rod = |diameter, length| Shape::Spherocylinder { diameter, length };
    let nan = rod(1.0, f64::NAN).validate();
    assert!(matches!(nan, Err(ShapeError::NotFinite { name: "length", .. })));
    let negative = Shape::Ellipsoid { radii: [1.0, -1.0, 1.0] }.validate();
    assert_eq!(negative, Err(ShapeError::NotPositive { name: "radii.1", value: -1.0 }));
    assert!(matches!(Shape::Sphere { radius: 0.0 }.validate(), Err(ShapeError::NotPositive { .. })));
    assert!(matches!(rod(1.0, 0.9).validate(), Err(ShapeError::ShorterThanDiameter { .. })));
    assert!(rod(1.0, 1.0).validate().is_ok());
    let disc = Shape::Torus { major_radius: 1.0, minor_radius: 1.0 }.validate();
    assert!(matches!(disc, Err(ShapeError::NoHole { .. })));
    let thread = Shape::Ellipsoid { radii: [1.0, 1.0, 1.001 * MAX_ASPECT] }.validate();
    assert!(matches!(thread, Err(ShapeError::Aspect { .. })));
    assert!(Shape::Ellipsoid { radii: [1.0, 1.0, MAX_ASPECT] }.validate().is_ok());
}

#[test]
fn planar_bodies_have_their_plane_as_a_mirror() {
    let upright = DQuat::from_rotation_z(0.7);
    let lying = upright * DQuat::from_rotation_y(FRAC_PI_2);
    let leaning = upright * DQuat::from_rotation_y(1e-6);
    for kind in KINDS {
        let shape = shape(kind, 5.0, &mut ChaCha8Rng::seed_from_u64(3));
        assert!(shape.is_planar_symmetric(upright) && shape.is_planar_symmetric(lying), "{shape:?}");
        assert_eq!(shape.is_planar_symmetric(leaning), kind == "sphere", "{shape:?}");
    }
    assert!(Shape::Ellipsoid { radii: [2.0, 1.0, 2.0] }.is_planar_symmetric(DQuat::from_rotation_y(0.3)));
}
