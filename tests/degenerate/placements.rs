//! Draws placements in which something vanishes that a direction could be made from: centres on axes, bodies coaxial,
//! coplanar, concentric, parallel, at right angles, tangent, with curves that meet; each at a random orientation, and
//! off by nothing, by rounding, or by a little.

use glam::{DQuat, DVec3, DVec4};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use relcp::internals::separation::Surface;
use relcp::separation::Placed;
use relcp::shape::{Shape, Superellipsoid};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// How far a placement is from the degenerate one, as a fraction of the sizes and as an angle.
const OFFSETS: [f64; 5] = [0.0, 1e-16, 1e-12, 1e-8, 1e-4];

/// The exponents of superellipsoids that are drawn.
const EXPONENTS: [[f64; 2]; 7] = [[2.0; 2], [2.5; 2], [4.0; 2], [8.0; 2], [10.0; 2], [2.0, 8.0], [10.0, 2.5]];

/// The kinds of bodies that are drawn: `thin` is an ellipsoid of aspect ratio 1000.
pub const KINDS: [&str; 5] = ["sphere", "rod", "ellipsoid", "thin", "ring"];

/// The kinds of surfaces that are drawn.
pub const SURFACES: [&str; 3] = ["plane", "sphere", "cylinder"];

/// All pairs of these kinds that have a separation, each once.
pub fn pairs_of(kinds: &'static [&'static str]) -> impl Iterator<Item = [&'static str; 2]> {
    let supported = |pair: &[&str; 2]| !(pair.contains(&"ring") && pair.iter().any(|k| is_convex_only(k)));
    let of_first = move |i: usize| kinds[i..].iter().map(move |second| [kinds[i], *second]);
    (0..kinds.len()).flat_map(of_first).filter(supported)
}

/// Whether a kind has no centreline.
fn is_convex_only(kind: &str) -> bool {
    !matches!(kind, "sphere" | "rod" | "ring")
}

/// A number between these.
fn between(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    random.random_range(low..high)
}

fn one_of<T: Copy>(all: &[T], random: &mut ChaCha8Rng) -> T {
    all[random.random_range(0..all.len())]
}

/// A random orientation.
pub fn turn(random: &mut ChaCha8Rng) -> DQuat {
    loop {
        let v = DVec4::from_array(std::array::from_fn(|_| between(random, -1.0, 1.0)));
        if (0.01..1.0).contains(&v.length_squared()) {
            return DQuat::from_vec4(v.normalize());
        }
    }
}

fn direction(random: &mut ChaCha8Rng) -> DVec3 {
    turn(random) * DVec3::Z
}

/// A random shape of a kind; `custom` are those of the kind `custom`.
pub fn shape(kind: &str, custom: &[Shape], random: &mut ChaCha8Rng) -> Shape {
    let a = between(random, 0.5, 3.0);
    let b = between(random, 0.5, 3.0);
    match kind {
        "sphere" => Shape::Sphere { radius: 0.5 * a },
        "rod" => Shape::Spherocylinder { diameter: 1.0, length: one_of(&[1.0, 1.0 + a, 1.0 + 5.0 * b], random) },
        "ellipsoid" => {
            Shape::Ellipsoid { radii: one_of(&[[a, 1.0, b], [a, a, b], [a, b, b], [b, a, b], [a, a, a]], random) }
        }
        "thin" => {
            let radii = [[0.5, 0.5, 500.0], [500.0, 500.0, 0.5], [0.5, 15.0, 500.0], [500.0, 0.5, 0.5]];
            Shape::Ellipsoid { radii: one_of(&radii, random) }
        }
        "ring" => {
            let major_radius = one_of(&[1.0, 1.0 + a, 30.0], random);
            Shape::Torus { major_radius, minor_radius: one_of(&[0.5, 0.1], random) }
        }
        "super" | "thin super" => {
            let radii = match kind {
                "super" => one_of(&[[a, 1.0, b], [a, a, b], [a, b, b], [a, a, a]], random),
                _ => one_of(&[[0.5, 0.5, 300.0], [300.0, 300.0, 0.5], [0.5, 15.0, 300.0], [300.0, 0.5, 0.5]], random),
            };
            Shape::Superellipsoid(Superellipsoid::new(radii, one_of(&EXPONENTS, random)))
        }
        _ => one_of(custom, random),
    }
}

/// A point on a body's centreline, from its centre and in its own axes; the centre of one that has none.
fn centreline_point(shape: &Shape, random: &mut ChaCha8Rng) -> DVec3 {
    match *shape {
        Shape::Spherocylinder { diameter, length } => {
            let half = 0.5 * (length - diameter);
            let inside = between(random, -half - 1e-300, half + 1e-300);
            DVec3::Z * one_of(&[-half, half, 0.0, inside], random)
        }
        Shape::Torus { major_radius, .. } => {
            let angle = between(random, 0.0, TAU);
            DQuat::from_rotation_z(one_of(&[0.0, FRAC_PI_2, angle], random)) * DVec3::X * major_radius
        }
        _ => DVec3::ZERO,
    }
}

/// A turn that takes z to one of the axes, then one about z.
fn upright(random: &mut ChaCha8Rng) -> DQuat {
    let spin = between(random, 0.0, TAU);
    let quarter = [DQuat::IDENTITY, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_2)];
    DQuat::from_rotation_z(one_of(&[0.0, FRAC_PI_2, spin], random)) * one_of(&quarter, random)
}

/// How a second body is turned beside one whose axis is z.
fn beside(random: &mut ChaCha8Rng) -> DQuat {
    let spin = DQuat::from_rotation_z(between(random, 0.0, TAU));
    let any = turn(random);
    let across = DQuat::from_rotation_x(FRAC_PI_2);
    let all = [DQuat::IDENTITY, spin, DQuat::from_rotation_x(PI) * spin, spin * across, across, across * spin, any];
    one_of(&all, random)
}

/// Off by one of the offsets: a vector of that part of `size`, and a turn by that angle.
fn off(random: &mut ChaCha8Rng, size: f64) -> (DVec3, DQuat) {
    let (shift, tilt) = (one_of(&OFFSETS, random), one_of(&OFFSETS, random));
    (direction(random) * (shift * size), DQuat::from_scaled_axis(direction(random) * tilt))
}

/// A pair of bodies of these kinds, in a degenerate place.
pub fn pair([first, second]: [&str; 2], custom: &[Shape], random: &mut ChaCha8Rng) -> [Placed; 2] {
    let shapes = [shape(first, custom, random), shape(second, custom, random)];
    let [reach_a, reach_b] = shapes.map(|s| s.bounding_radius());
    let (turn_a, mut turn_b) = (upright(random), beside(random));
    turn_b *= if first == "ring" || first == "rod" { DQuat::IDENTITY } else { upright(random) };
    let turn_a = if first == "ring" || first == "rod" { DQuat::IDENTITY } else { turn_a };
    let axis_b = turn_b * DVec3::Z;
    let height = between(random, 0.0, 1.2) * one_of(&[reach_a, reach_b, reach_a + reach_b], random);
    let touching = |along: DVec3| shapes[0].half_extents(turn_a).dot(along) + shapes[1].half_extents(turn_b).dot(along);
    let points = [turn_a * centreline_point(&shapes[0], random), turn_b * centreline_point(&shapes[1], random)];
    let mut place = match random.random_range(0..9) {
        0 => DVec3::ZERO,
        1 => DVec3::Z * height,
        2 => DVec3::X * height,
        3 => axis_b * height,
        // A point of b on the axis of a, and a point of a on the axis of b.
        4 => DVec3::Z * height - points[1],
        5 => points[0] - axis_b * height,
        // Centrelines that meet.
        6 => points[0] - points[1],
        7 => DVec3::Z * touching(DVec3::Z),
        _ => DVec3::X * touching(DVec3::X) + DVec3::Z * one_of(&[0.0, height], random),
    };
    let (shift, tilt) = off(random, reach_a + reach_b);
    place += shift;
    let (all, from) = everything(random);
    let a = Placed { shape: shapes[0], position: from, orientation: (all * turn_a).normalize() };
    let b = Placed { shape: shapes[1], position: from + all * place, orientation: (all * tilt * turn_b).normalize() };
    if random.random_bool(0.5) { [a, b] } else { [b, a] }
}

/// How all of a placement is turned and moved: not at all for one in ten.
fn everything(random: &mut ChaCha8Rng) -> (DQuat, DVec3) {
    let (all, from) = (turn(random), direction(random) * between(random, 0.0, 4.0));
    if random.random_bool(0.1) { (DQuat::IDENTITY, DVec3::ZERO) } else { (all, one_of(&[DVec3::ZERO, from], random)) }
}

/// A pair of bodies in the plane, in a degenerate place.
pub fn planar_pair([first, second]: [&str; 2], random: &mut ChaCha8Rng) -> [Placed; 2] {
    let stood = [DQuat::IDENTITY, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_2)];
    let shapes = [shape(first, &[], random), shape(second, &[], random)];
    let stood = [one_of(&stood, random), one_of(&stood, random)];
    let [reach_a, reach_b] = shapes.map(|s| s.bounding_radius());
    let height = between(random, 0.0, 1.2) * one_of(&[reach_a, reach_b, reach_a + reach_b], random);
    let any = between(random, 0.0, TAU);
    let leaning = DQuat::from_rotation_z(one_of(&[0.0, FRAC_PI_2, PI, any], random));
    let points =
        [stood[0] * centreline_point(&shapes[0], random), leaning * stood[1] * centreline_point(&shapes[1], random)];
    let place = [DVec3::ZERO, DVec3::X * height, DVec3::Y * height, leaning * DVec3::X * height, points[0] - points[1]];
    let place = one_of(&place, random) + off(random, reach_a + reach_b).0;
    let all = DQuat::from_rotation_z(between(random, 0.0, TAU));
    let all = one_of(&[DQuat::IDENTITY, all, all], random);
    let tilt = DQuat::from_rotation_z(one_of(&OFFSETS, random));
    let flat = |v: DVec3| DVec3::new(v.x, v.y, 0.0);
    let a = Placed { shape: shapes[0], position: DVec3::ZERO, orientation: all * stood[0] };
    let b = Placed {
        shape: shapes[1],
        position: flat(all * place),
        orientation: (all * tilt * leaning * stood[1]).normalize(),
    };
    [a, b]
}

/// A body of this kind and a surface of that one, in a degenerate place: on an axis, at a centre, parallel or at right
/// angles, in a tube or a ball that it hardly fits into.
pub fn at_wall(kind: &str, surface: &str, custom: &[Shape], random: &mut ChaCha8Rng) -> (Placed, Surface) {
    let shape = shape(kind, custom, random);
    let reach = shape.bounding_radius();
    let orientation = one_of(&[beside(random), upright(random), beside(random) * upright(random)], random);
    let point = orientation * centreline_point(&shape, random);
    let along = DVec3::Z * one_of(&[0.0, between(random, -10.0, 10.0) * reach], random);
    // Across the axis: within the tube, in the directions of the body's axes or in any.
    let radius = one_of(&[1.005, 1.2, 2.0, 4.0, 1000.0], random) * reach;
    let room = (radius - reach).min(4.0 * reach);
    let out = one_of(&[0.0, between(random, 0.0, 1.0) * room, room], random);
    let axes = [orientation * DVec3::X, orientation * DVec3::Y, orientation * DVec3::Z, DVec3::X, direction(random)];
    let aside = one_of(&axes, random) * out;
    let (shift, tilt) = off(random, reach);
    let (all, from) = everything(random);
    let unit = (all * DVec3::Z).normalize();
    let (surface, place) = match surface {
        "plane" => {
            let height = one_of(&[shape.half_extents(orientation).z, reach * between(random, -1.0, 2.0)], random);
            let point = from + all * (DVec3::new(3.0, -1.0, 0.0) * reach);
            (Surface::Plane { point, normal: unit }, DVec3::Z * height)
        }
        "sphere" => (Surface::Sphere { centre: from, radius }, one_of(&[aside, aside - point], random)),
        _ => {
            let aside = DVec3::new(aside.x, aside.y, 0.0);
            (Surface::Cylinder { centre: from, axis: unit, radius }, along + one_of(&[aside, aside - point], random))
        }
    };
    let position = from + all * (place + shift);
    (Placed { shape, position, orientation: (all * tilt * orientation).normalize() }, surface)
}
