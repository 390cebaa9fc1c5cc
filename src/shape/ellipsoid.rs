//! The ellipsoid with semi-axes along the body's x, y and z. Volume `4/3 pi a b c`; inertia `m (b^2 + c^2) / 5` and so
//! on.

use super::{PLANAR_TOLERANCE, ProxyError, ProxySphere, ShapeError, check_aspect, check_axis_count, check_size};
use glam::{DMat3, DQuat, DVec3, Vec3Swizzles};
use std::f64::consts::PI;

/// Radii this close, relative to the larger, are one radius: whether an axis is *the* major axis is then rounding.
const EQUAL_RADII: f64 = 1e-9;

/// Rounds at most of the spacing iteration of [`centres`]; it stopped at rounding before that for counts of 3, 5, 27
/// and 99 at aspect ratios from 1.0001 to 1000.
const SPACING_ROUNDS: usize = 100;

pub(super) fn validate(radii: [f64; 3]) -> Result<(), ShapeError> {
    for (name, value) in ["radii.0", "radii.1", "radii.2"].into_iter().zip(radii) {
        check_size(name, value)?;
    }
    let radii = DVec3::from_array(radii);
    check_aspect("radii", radii.max_element(), radii.min_element())
}

pub(super) fn volume(radii: [f64; 3]) -> f64 {
    4.0 / 3.0 * PI * radii[0] * radii[1] * radii[2]
}

pub(super) fn unit_inertia(radii: [f64; 3]) -> DVec3 {
    let square = DVec3::from_array(radii).powf(2.0);
    (square.yzx() + square.zxy()) * (0.2 * volume(radii))
}

/// Along axis `i` of space an ellipsoid reaches `|diag(radii) R^T e_i|`.
#[inline]
pub(super) fn half_extents(radii: [f64; 3], orientation: DQuat) -> DVec3 {
    let axes = DMat3::from_quat(orientation);
    let [a, b, c] = radii;
    let (x, y, z) = (axes.x_axis * a, axes.y_axis * b, axes.z_axis * c);
    (x * x + y * y + z * z).map(f64::sqrt)
}

/// The plane is a mirror plane exactly where its normal is an eigenvector of `R diag(radii^2) R^T`.
pub(super) fn is_planar_symmetric(radii: [f64; 3], orientation: DQuat) -> bool {
    let axes = DMat3::from_quat(orientation);
    let scale = DVec3::from_array(radii).max_element();
    let square = (DVec3::from_array(radii) / scale).powf(2.0);
    let image = axes * (square * (axes.transpose() * DVec3::Z));
    image.x.abs().max(image.y.abs()) <= PLANAR_TOLERANCE
}

/// The axes in the order of their radii, and whether the radii are equal: the middle one to the largest, and all.
fn axes(radii: [f64; 3]) -> ([usize; 3], bool, bool) {
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| radii[i].total_cmp(&radii[j]));
    let [least, middle, major] = order.map(|i| radii[i]);
    let equal = |small: f64, large: f64| large - small <= EQUAL_RADII * large;
    (order, equal(middle, major), equal(least, major))
}

pub(super) fn check_proxy(radii: [f64; 3], count: usize) -> Result<(), ProxyError> {
    match axes(radii) {
        (_, _, true) => super::sphere::check_proxy(count),
        (_, true, false) => Err(ProxyError::NoMajorAxis),
        (_, false, false) => check_axis_count(count),
    }
}

/// Spheres on the major axis `A`, each the largest that fits about its centre. With `s` the least radius and `E = A^2 -
/// s^2` that is `r(c) = s sqrt(1 - c^2 / E)` for `|c| <= E / A`; the outermost sphere sits at `E / A`, has the tip's
/// radius of curvature `s^2 / A`, and touches the tip.
///
/// A triaxial ellipsoid's spheres touch it on the sides of its least radius only and leave the middle radius bare. An
/// oblate one has no major axis and is refused; three equal radii make a sphere, its own proxy.
pub(super) fn proxy(radii: [f64; 3], count: usize) -> Result<Vec<ProxySphere>, ProxyError> {
    check_proxy(radii, count)?;
    let (order, _, ball) = axes(radii);
    let [least, _, major] = order.map(|i| radii[i]);
    if ball {
        return super::sphere::proxy(least, count);
    }
    let axis = DVec3::AXES[order[2]];
    let square = (major - least) * (major + least);
    let outward = centres(least, major, count / 2);
    let inward = outward.iter().rev().map(|c| -c);
    let sphere = |c: f64| ProxySphere { centre: axis * c, radius: least * (1.0 - c * c / square).max(0.0).sqrt() };
    Ok(inward.chain([0.0]).chain(outward.iter().copied()).map(sphere).collect())
}

/// Centres of the spheres on one side, from the middle outwards, the last at `E / A`.
///
/// Between neighbours a distance `d` apart the squared distance from the axis falls short of the ellipsoid's by
/// `A^2 d^2 / 4 E`, wherever they are; measured along the normal, the groove is `A^2 d^2 / (8 E r)` deep, with `r` the
/// radius half-way. The distances are chosen in proportion to `sqrt(r)`, which makes all grooves equally deep: equal
/// distances would make those at the tips deeper than those in the middle by the aspect ratio.
fn centres(least: f64, major: f64, count: usize) -> Vec<f64> {
    let square = (major - least) * (major + least);
    let last = square / major;
    let mut at: Vec<f64> = (1..=count).map(|i| last * i as f64 / count as f64).collect();
    for _ in 0..SPACING_ROUNDS {
        let mut inner = 0.0;
        let weights: Vec<f64> = at
            .iter()
            .map(|&c| {
                let halfway = 0.5 * (inner + c);
                inner = c;
                (1.0 - halfway * halfway / square).powf(0.25)
            })
            .collect();
        let scale = last / weights.iter().sum::<f64>();
        let (mut total, mut change) = (0.0, 0.0_f64);
        for (c, weight) in at.iter_mut().zip(weights) {
            total += weight * scale;
            change = change.max((total - *c).abs());
            *c = total;
        }
        if change <= f64::EPSILON * major {
            break;
        }
    }
    if let Some(c) = at.last_mut() {
        *c = last;
    }
    at
}

/// Bits of a tip's radius of curvature that are dropped. What is left does not depend on at which length the radius is
/// computed, which changes its last three bits: however a body grew, it has the same bits at the same length.
const DROPPED_BITS: u32 = 6;

/// How much flatter than a ball an ellipsoid may be that grows, relative to its length: for rounding.
const FLATTER: f64 = 1e-9;

/// The radii of curvature of the tips on z, along x and y.
pub(super) fn tips([x, y, z]: [f64; 3]) -> [f64; 2] {
    [x, y].map(|radius| {
        let bits = (radius * radius / z).to_bits();
        f64::from_bits((bits + (1 << (DROPPED_BITS - 1))) >> DROPPED_BITS << DROPPED_BITS)
    })
}

/// The ellipsoid with the same tips and another semi-axis along z, if it is not flatter than a ball. A tip at the
/// origin has the half width `sqrt(r (2 h - h^2 / z))` at the height `h`, with its radius of curvature `r`: it rises
/// with the semi-axis `z`, so that a shorter ellipsoid with the same tips lies in a longer one that it touches at a
/// tip.
pub(super) fn grown(radii: [f64; 3], z: f64) -> Option<[f64; 3]> {
    let tips = tips(radii);
    let [x, y] = tips.map(|tip| (tip * z).sqrt());
    (z * (1.0 + FLATTER) >= tips[0].max(tips[1])).then_some([x, y, z])
}

/// The axis about which two radii are equal, where one is not.
pub(super) fn axis_of_revolution([a, b, c]: [f64; 3]) -> Option<DVec3> {
    match (a == b, b == c, c == a) {
        (true, false, _) => Some(DVec3::Z),
        (_, true, false) => Some(DVec3::X),
        (false, _, true) => Some(DVec3::Y),
        _ => None,
    }
}

/// `(b^2 - c^2) / (b^2 + c^2)` about x, and cyclically.
pub(super) fn bretherton([a, b, c]: [f64; 3]) -> DVec3 {
    let of = |b: f64, c: f64| (b - c) * (b + c) / (b * b + c * c);
    DVec3::new(of(b, c), of(c, a), of(a, b))
}
