//! Swapped, moved and warm pairs have the same separation; points agree with it.

use super::{check_sound, on_random_pairs, pair, size};
use crate::directions::{direction, turn};
use glam::{DQuat, DVec3};
use rand::RngExt;
use relcp::separation::{Placed, separation};
use relcp::shape::Shape;

#[test]
fn a_ring_about_an_ellipsoids_waist_is_as_far_as_their_radii_say() {
    let at = |shape| Placed { shape, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    let ring = |major_radius| at(Shape::Torus { major_radius, minor_radius: 0.1 });
    let ellipsoid = at(Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] });
    for (major_radius, expected) in [(1.0, -0.1), (2.0, 0.9), (0.5, -0.6)] {
        for found in [
            separation(&ring(major_radius), &ellipsoid, None).unwrap(),
            separation(&ellipsoid, &ring(major_radius), None).unwrap(),
        ] {
            assert!((found.separation - expected).abs() < 1e-15, "{major_radius}: {found:?}");
        }
    }
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
