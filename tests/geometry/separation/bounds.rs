//! The separation of convex pairs is the largest bound, and its derivatives are those of finite differences.

use super::{check_sound, is_convex, on_random_pairs, pair, random_pair, size};
use crate::directions::direction;
use glam::{DMat3, DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::separation::{Placed, bound};

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
