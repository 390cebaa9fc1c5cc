//! Superellipsoids on the device against the CPU: near contact, deep, with faces on faces, nested and slender, of
//! exponents 2 to 10, with each other and with ellipsoids, spheres and rods.
//!
//! Errors are fractions of the size of a pair. A normal moves the points of flat places by its root of up to the ninth
//! degree, so that points are held to meet along and across the normal, not to those of the CPU.

#![allow(clippy::unwrap_used)]

use super::harness::{Answer, Errors, Worst, answers};
use super::poses::Pose;
use crate::device::{device, precisions};
use crate::directions::{direction, turn};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::gpu::Precision;
use relcp::separation::{Placed, Separation, separation};
use relcp::shape::{Shape, Superellipsoid};
use std::f64::consts::FRAC_PI_2;

const EXPONENTS: [[f64; 2]; 8] =
    [[2.0; 2], [2.5; 2], [4.0; 2], [8.0; 2], [10.0; 2], [2.0, 8.0], [10.0, 2.5], [6.0, 3.0]];

/// Poses of each kind; `RELCP_POSES=N` for more or fewer.
fn poses(otherwise: usize) -> usize {
    std::env::var("RELCP_POSES").ok().and_then(|n| n.parse().ok()).unwrap_or(otherwise)
}

/// A superellipsoid one thick, its sizes within a factor of `aspect`.
fn superellipsoid(random: &mut ChaCha8Rng, aspect: f64) -> Shape {
    let mut size = || 0.5 * random.random_range(0.0..=aspect.ln()).exp();
    let radii = [0.5, size(), size()];
    let first = random.random_range(0..3);
    let radii = std::array::from_fn(|k| radii[(k + first) % 3]);
    Shape::Superellipsoid(Superellipsoid::new(radii, EXPONENTS[random.random_range(0..EXPONENTS.len())]))
}

/// The partner of a superellipsoid: in turn one of its kind, an ellipsoid, a rod and a sphere.
fn partner(random: &mut ChaCha8Rng, kind: usize, aspect: f64) -> Shape {
    let size = random.random_range(0.0..=aspect.ln()).exp();
    match kind % 4 {
        0 => superellipsoid(random, aspect),
        1 => Shape::Ellipsoid { radii: [0.5, 0.5 * size.sqrt(), 0.5 * size] },
        2 => Shape::Spherocylinder { diameter: 1.0, length: size },
        _ => Shape::Sphere { radius: 0.5 * size },
    }
}

fn placed(shape: Shape, position: DVec3, orientation: DQuat) -> Placed {
    Placed { shape, position, orientation }
}

/// Moves b along the normal to a separation.
fn moved_to(a: &Placed, b: &mut Placed, target: f64) {
    for _ in 0..6 {
        let found = separation(a, b, None).unwrap();
        b.position += found.normal * (target - found.separation);
    }
}

pub fn near_contact(count: usize, aspect: f64) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut make = |i: usize| {
        let a = placed(superellipsoid(&mut random, aspect), DVec3::ZERO, turn(&mut random));
        let shape = partner(&mut random, i, aspect);
        let reach = a.shape.bounding_radius() + shape.bounding_radius();
        let mut b = placed(shape, direction(&mut random) * reach, turn(&mut random));
        moved_to(&a, &mut b, random.random_range(-0.02..0.05));
        if i.is_multiple_of(2) { Pose::new(a, b) } else { Pose::new(b, a) }
    };
    (0..count).map(&mut make).collect()
}

fn deep(count: usize, aspect: f64) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let mut make = |i: usize| {
        let a = placed(superellipsoid(&mut random, aspect), DVec3::ZERO, turn(&mut random));
        let at = direction(&mut random) * random.random_range(0.0..0.8);
        Pose::new(a, placed(partner(&mut random, i, aspect), at, turn(&mut random)))
    };
    (0..count).map(&mut make).collect()
}

/// Faces on faces, edges on faces and corners on faces, aligned up to a tilt of 1e-14 to 0.1, and shifted along the
/// face by up to half its size.
fn aligned(count: usize) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut make = |i: usize| {
        let whole = turn(&mut random);
        let [a, other] = [0, 1].map(|_| superellipsoid(&mut random, 3.0));
        let shape = if i.is_multiple_of(3) { partner(&mut random, i / 3, 3.0) } else { other };
        let quarters = [0, 1].map(|_| f64::from(random.random_range(0..4)) * [FRAC_PI_2, 0.5 * FRAC_PI_2][i % 2]);
        let stood = DQuat::from_rotation_x(quarters[0]) * DQuat::from_rotation_y(quarters[1]);
        let tilt = direction(&mut random) * 10f64.powf(random.random_range(-14.0..-1.0));
        let tilt = if i.is_multiple_of(5) { DVec3::ZERO } else { tilt };
        let shift = DVec3::new(random.random_range(-0.5..0.5), random.random_range(-0.5..0.5), 3.0);
        let shift = if i.is_multiple_of(7) { DVec3::Z * 3.0 } else { shift };
        let a = placed(a, DVec3::ZERO, whole);
        let mut b = placed(shape, whole * shift, whole * DQuat::from_scaled_axis(tilt) * stood);
        let target = random.random_range(-1e-3..1e-2);
        for _ in 0..6 {
            b.position += whole * DVec3::Z * (target - separation(&a, &b, None).unwrap().separation);
        }
        Pose::new(a, b)
    };
    (0..count).map(&mut make).collect()
}

/// Centres on each other or near each other, with axes that agree or not.
fn nested(count: usize) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut make = |i: usize| {
        let a = placed(superellipsoid(&mut random, 3.0), DVec3::ZERO, turn(&mut random));
        let shape = partner(&mut random, i / 2, 3.0);
        let at = direction(&mut random) * 10f64.powf(random.random_range(-12.0..-1.0));
        let turned = if i.is_multiple_of(2) { a.orientation } else { turn(&mut random) };
        Pose::new(a, placed(shape, if i.is_multiple_of(3) { DVec3::ZERO } else { at }, turned))
    };
    (0..count).map(&mut make).collect()
}

/// What a device's answers may be off by, in 32 and 64 bits; the fraction of the poses in which it may find another
/// maximum than the CPU, where there are several, and that in which points may not meet across the normal.
struct Limits {
    separation: [f64; 2],
    across: [f64; 2],
    other: f64,
    apart: [f64; 2],
}

fn holds(what: &str, limits: &Limits, poses: &[Pose]) {
    let Some(gpu) = device() else { return };
    let expected: Vec<Separation> = poses.iter().map(|p| separation(&p.a, &p.b, None).unwrap()).collect();
    for precision in precisions(gpu) {
        let k = usize::from(precision == Precision::F64);
        let (mut worst, mut lower, mut higher) = (Worst::default(), 0, 0);
        let mut aside = 0;
        for ((pose, answer), expected) in poses.iter().zip(answers(gpu, precision, false, poses)).zip(&expected) {
            is_sound(what, precision, pose, &answer);
            let mut errors = Errors::of(pose, &answer.found, expected);
            let apart = (answer.found.separation - expected.separation) / pose.size();
            if apart.abs() > limits.separation[k] {
                lower += usize::from(apart < 0.0);
                higher += usize::from(apart > 0.0);
                errors.separation = 0.0;
            }
            if errors.across > limits.across[k] {
                aside += 1;
                errors.across = 0.0;
            }
            worst.add(pose.kind(), errors);
        }
        worst.print(what, precision);
        println!("{what}, {}: {lower} lower, {higher} higher of {}", precision.name(), poses.len());
        println!("{what}, {}: points of {aside} apart across the normal", precision.name());
        assert!(f64::from(aside) <= limits.apart[k] * poses.len() as f64, "{what} {precision:?}");
        assert!((lower + higher) as f64 <= limits.other * poses.len() as f64, "{what} {precision:?}");
    }
}

/// A unit normal, points that agree with the separation along it, a lower bound, a radius and a box.
fn is_sound(what: &str, precision: Precision, pose: &Pose, answer: &Answer) {
    let (found, rounding) = (answer.found, precision.epsilon());
    let errors = Errors::of(pose, &found, &found);
    assert!((found.normal.length() - 1.0).abs() <= 8.0 * rounding, "{what} {precision:?} {pose:?} {answer:?}");
    assert!(errors.along <= 1e-4, "{what} {precision:?} {pose:?} {answer:?} {:e}", errors.along);
    let off = (answer.bound - relcp::separation::bound(&pose.a, &pose.b, found.normal)).abs();
    assert!(off <= 16.0 * rounding * pose.size(), "{what} {precision:?} {pose:?} {answer:?} {off:e}");
    let a = &pose.a;
    let radius = a.shape.bounding_radius();
    assert!((answer.bounding_radius - radius).abs() <= 8.0 * rounding * radius, "{pose:?} {answer:?}");
    let off = (answer.half_extents - a.shape.half_extents(a.orientation)).abs().max_element();
    assert!(off <= 16.0 * rounding * radius, "{precision:?} {a:?} {:?}", answer.half_extents);
}

#[test]
fn superellipsoids_near_contact_agree_with_the_cpu() {
    let limits = Limits { separation: [2e-6, 1e-11], across: [1e-5, 1e-9], other: 0.0, apart: [1e-3, 0.0] };
    for aspect in [3.0, 20.0] {
        holds(&format!("near contact, aspect {aspect}"), &limits, &near_contact(poses(2000), aspect));
    }
}

#[test]
fn aligned_superellipsoids_agree_with_the_cpu() {
    let limits = Limits { separation: [2e-6, 1e-11], across: [1e-5, 1e-9], other: 0.0, apart: [0.01, 0.0] };
    holds("aligned", &limits, &aligned(poses(2000)));
}

#[test]
fn deep_and_nested_superellipsoids_agree_with_the_cpu() {
    let limits = Limits { separation: [2e-6, 1e-11], across: [1e-5, 1e-9], other: 0.01, apart: [0.01, 0.0] };
    holds("deep", &limits, &deep(poses(400), 3.0));
    holds("nested", &limits, &nested(poses(400)));
}
