//! Pairs of bodies to compare: random near contact and deep, in a plane, and those in which something is degenerate.

use crate::directions::{direction, turn};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::internals::separation::gpu::PairFamilies;
use relcp::internals::separation::planar_separation;
use relcp::separation::{Placed, separation};
use relcp::shape::Shape;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A pair, and the old normal, zero for none.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    pub a: Placed,
    pub b: Placed,
    pub warm: DVec3,
}

impl Pose {
    pub fn new(a: Placed, b: Placed) -> Pose {
        Pose { a, b, warm: DVec3::ZERO }
    }

    /// Of these bodies, without an old normal.
    pub fn of([a, b]: [Placed; 2]) -> Pose {
        Pose::new(a, b)
    }

    pub fn delta(&self) -> DVec3 {
        self.b.position - self.a.position
    }

    /// The scale of the errors: both bounding radii and the distance.
    pub fn size(&self) -> f64 {
        self.a.shape.bounding_radius() + self.b.shape.bounding_radius() + self.delta().length()
    }

    pub fn families(&self) -> PairFamilies {
        PairFamilies::of(&self.a.shape, &self.b.shape).unwrap()
    }

    pub fn kind(&self) -> String {
        format!("{}, {}", self.a.shape.name(), self.b.shape.name())
    }

    pub fn is_convex(&self) -> bool {
        ![self.a, self.b].iter().any(|body| matches!(body.shape, Shape::Torus { .. }))
    }
}

const KINDS: [&str; 4] = ["sphere", "spherocylinder", "ellipsoid", "torus"];

/// All pairs of kinds, in both orders.
fn kinds() -> impl Iterator<Item = [&'static str; 2]> {
    KINDS.into_iter().flat_map(|a| KINDS.map(|b| [a, b]))
}

/// A random shape one thick, its sizes within a factor of `aspect`.
fn shape(kind: &str, aspect: f64, random: &mut ChaCha8Rng) -> Shape {
    let mut ratio = || aspect.powf(random.random_range(0.0..1.0));
    match kind {
        "sphere" => Shape::Sphere { radius: 0.5 * ratio() },
        "spherocylinder" => Shape::Spherocylinder { diameter: 1.0, length: ratio() },
        "ellipsoid" => Shape::Ellipsoid { radii: [0.5 * ratio(), 0.5, 0.5 * ratio()] },
        _ => Shape::Torus { major_radius: 0.5 + ratio(), minor_radius: 0.5 },
    }
}

/// Random pairs of all kinds, from a fifth of the thickness deep to half of it apart.
pub fn near_contact(count: usize, aspect: f64) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut make = |[first, second]: [&str; 2]| {
        let mut place = |kind| Placed {
            shape: shape(kind, aspect, &mut random),
            position: direction(&mut random) * random.random_range(0.0..aspect),
            orientation: turn(&mut random),
        };
        let (a, mut b) = (place(first), place(second));
        let target = random.random_range(-0.2..0.5);
        for _ in 0..4 {
            let s = separation(&a, &b, None).unwrap();
            b.position += s.normal * (target - s.separation);
        }
        Pose::new(a, b)
    };
    kinds().flat_map(|kinds| vec![kinds; count]).map(&mut make).collect()
}

/// Random pairs of all kinds whose centres are within the larger body's reach.
pub fn deep(count: usize, aspect: f64) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut make = |[first, second]: [&str; 2]| {
        let mut place = |kind| Placed {
            shape: shape(kind, aspect, &mut random),
            position: DVec3::ZERO,
            orientation: turn(&mut random),
        };
        let (a, mut b) = (place(first), place(second));
        b.position = direction(&mut random) * random.random_range(0.0..1.0) * a.shape.bounding_radius();
        Pose::new(a, b)
    };
    kinds().flat_map(|kinds| vec![kinds; count]).map(&mut make).collect()
}

/// Bodies in the plane z = 0, half of them near contact and half deep.
pub fn planar(count: usize, aspect: f64) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let mut make = |(i, [first, second]): (usize, [&str; 2])| {
        let mut place = |kind| {
            let stood = [DQuat::IDENTITY, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_2)];
            let stood = stood[random.random_range(0..3)];
            Placed {
                shape: shape(kind, aspect, &mut random),
                position: DVec3::ZERO,
                orientation: DQuat::from_rotation_z(random.random_range(0.0..TAU)) * stood,
            }
        };
        let (a, mut b) = (place(first), place(second));
        let angle: f64 = random.random_range(0.0..TAU);
        let reach = random.random_range(0.0..1.0) * a.shape.bounding_radius();
        b.position = DVec3::new(angle.cos(), angle.sin(), 0.0) * reach;
        if i.is_multiple_of(2) {
            let target = random.random_range(-0.2..0.5);
            for _ in 0..4 {
                let s = planar_separation(&a, &b, None).unwrap();
                b.position += (s.normal * (target - s.separation)).with_z(0.0);
            }
        }
        Pose::new(a, b)
    };
    kinds().flat_map(|kinds| vec![kinds; count]).enumerate().map(&mut make).collect()
}

/// Rings where their distances are hardest: nearly coaxial, passing near the other's middle, and of very different
/// radii.
pub fn rings(count: usize) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut make = |round: usize| {
        let tilt = direction(&mut random) * 10f64.powf(random.random_range(-12.0..0.0));
        let major_radius = if round.is_multiple_of(2) { 1.0 } else { 10f64.powf(random.random_range(-2.0..2.0)) };
        let ring = |major_radius, position, orientation| Placed {
            shape: Shape::Torus { major_radius, minor_radius: 1e-3 },
            position,
            orientation,
        };
        let (position, orientation) = match round % 3 {
            0 => (direction(&mut random) * random.random_range(0.0..1.0 + major_radius), turn(&mut random)),
            1 => (direction(&mut random) * 10f64.powf(random.random_range(-9.0..0.0)), DQuat::from_scaled_axis(tilt)),
            _ => (
                DVec3::X + direction(&mut random) * tilt.length(),
                DQuat::from_scaled_axis(tilt) * DQuat::from_rotation_x(FRAC_PI_2),
            ),
        };
        let rotation = turn(&mut random);
        let mut other = ring(1.0, rotation * position, rotation * orientation);
        if round.is_multiple_of(5) {
            other.shape = Shape::Spherocylinder { diameter: 1e-3, length: 2.0 };
        }
        Pose::new(ring(major_radius, DVec3::ZERO, rotation), other)
    };
    (0..count).map(&mut make).collect()
}

/// Every shape that is round, slender, flat, small or large, at the same place, on an axis or far, and parallel or at
/// right angles.
pub fn degenerate() -> Vec<Pose> {
    let shapes = [
        Shape::Sphere { radius: 1.0 },
        Shape::Sphere { radius: 1000.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 1.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 5.0 },
        Shape::Spherocylinder { diameter: 1.0, length: 1000.0 },
        Shape::Ellipsoid { radii: [1.0; 3] },
        Shape::Ellipsoid { radii: [1.0, 1.0, 100.0] },
        Shape::Ellipsoid { radii: [100.0, 100.0, 1.0] },
        Shape::Ellipsoid { radii: [1.0, 30.0, 1000.0] },
        Shape::Ellipsoid { radii: [1e-3; 3] },
        Shape::Torus { major_radius: 1.0, minor_radius: 0.1 },
        Shape::Torus { major_radius: 100.0, minor_radius: 0.1 },
    ];
    // Concentric, coaxial or on one line, side by side, interlocked, far, and as good as concentric.
    let places = [
        DVec3::ZERO,
        DVec3::Z,
        DVec3::Z * 2.0,
        DVec3::X,
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(1.5, 0.0, 3.0),
        DVec3::Z * 2e3,
        DVec3::X * 1e-300,
    ];
    let tilt = DQuat::from_scaled_axis(DVec3::new(0.3, -0.2, 0.9));
    let turns = [DQuat::IDENTITY, tilt, DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_y(FRAC_PI_2)];
    let mut poses = Vec::new();
    for (first, second) in shapes.iter().flat_map(|a| shapes.iter().map(move |b| (*a, *b))) {
        for (place, turn_a, turn_b) in
            places.iter().flat_map(|p| turns.iter().flat_map(move |a| turns.map(|b| (*p, *a, b))))
        {
            let a = Placed { shape: first, position: DVec3::ZERO, orientation: turn_a };
            poses.push(Pose::new(a, Placed { shape: second, position: place, orientation: turn_b }));
        }
    }
    poses
}

/// Pairs whose normal or points geometry leaves open, with what a fixed rule says of them.
pub fn ruled() -> Vec<(&'static str, Pose)> {
    let rod = Shape::Spherocylinder { diameter: 1.0, length: 5.0 };
    let ball = Shape::Sphere { radius: 1.0 };
    let disc = Shape::Ellipsoid { radii: [4.0, 3.0, 1.0] };
    let ring = Shape::Torus { major_radius: 2.0, minor_radius: 0.25 };
    let narrow = Shape::Torus { major_radius: 1.0, minor_radius: 0.25 };
    let tilt = DQuat::from_scaled_axis(DVec3::new(0.3, -0.2, 0.9));
    let lying = DQuat::from_rotation_y(FRAC_PI_2);
    let leaning = |angle: f64| DQuat::from_scaled_axis(DVec3::Y * angle);
    let at = |shape, place, orientation| Placed { shape, position: place, orientation };
    let same = DQuat::IDENTITY;
    let pose = |a: Shape, turn_a: DQuat, b: Shape, place: DVec3, turn_b: DQuat| {
        Pose::new(at(a, DVec3::ZERO, turn_a), at(b, place, turn_b))
    };
    let side = DVec3::new(1.5, 0.0, 3.0);
    vec![
        ("parallel rods", pose(rod, same, rod, side, same)),
        ("parallel rods, tilted", pose(rod, tilt, rod, tilt * side, tilt)),
        ("rods a rounding from parallel", pose(rod, same, rod, side, leaning(1e-16))),
        ("rods not parallel", pose(rod, same, rod, side, leaning(1e-3))),
        ("rods not parallel the other way", pose(rod, same, rod, side, leaning(-1e-3))),
        ("crossing rods", pose(rod, same, rod, DVec3::ZERO, lying)),
        ("crossing rods, lifted", pose(rod, same, rod, DVec3::new(0.5, -1e-13, 0.3), lying)),
        ("crossing rods, tilted", pose(rod, tilt, rod, DVec3::new(0.0, 0.0, 0.3), tilt * lying)),
        ("rods in line, overlapping", pose(rod, same, rod, DVec3::Z * 2.0, same)),
        ("rods in line, apart", pose(rod, same, rod, DVec3::Z * 6.0, same)),
        ("the same rod", pose(rod, tilt, rod, DVec3::ZERO, tilt)),
        ("a ball in a rod", pose(ball, same, rod, DVec3::ZERO, lying)),
        ("a ball at a rod's tip", pose(rod, same, ball, DVec3::Z * 2.0, same)),
        ("the same ball", pose(ball, same, ball, DVec3::ZERO, same)),
        ("a ball at a ring's middle", pose(ring, same, ball, DVec3::ZERO, same)),
        ("a ball over a ring's middle", pose(ring, same, ball, DVec3::Z * 0.5, same)),
        ("a ball on a ring", pose(ring, same, ball, DVec3::X * 2.0, same)),
        ("an ellipsoid on a ring", pose(ring, same, disc, DVec3::X * 2.5, lying)),
        (
            "a round body on a ring's axis",
            pose(ring, same, Shape::Ellipsoid { radii: [1.0, 1.0, 3.0] }, DVec3::Z, same),
        ),
        ("a rod on a ring's axis", pose(ring, same, rod, DVec3::ZERO, same)),
        ("a rod on a ring's axis, beyond", pose(ring, same, rod, DVec3::Z * 5.0, same)),
        ("a rod through a ring's tube", pose(ring, same, rod, DVec3::new(2.0, 0.0, 0.5), same)),
        ("the same ring", pose(ring, same, ring, DVec3::ZERO, same)),
        ("coaxial rings", pose(ring, same, ring, DVec3::Z, same)),
        ("concentric rings in a plane", pose(ring, same, narrow, DVec3::ZERO, same)),
        ("coaxial rings of two radii", pose(narrow, same, ring, DVec3::Z, same)),
        ("linked rings", pose(ring, same, ring, DVec3::new(2.0, 0.0, 0.0), DQuat::from_rotation_x(FRAC_PI_2))),
        ("the same ellipsoid", pose(disc, same, disc, DVec3::ZERO, same)),
        ("concentric ellipsoids", pose(disc, same, Shape::Ellipsoid { radii: [1.0, 2.0, 3.0] }, DVec3::ZERO, same)),
        ("a ball in an ellipsoid's middle", pose(disc, same, ball, DVec3::ZERO, same)),
        ("a rod through an ellipsoid's middle", pose(disc, same, rod, DVec3::ZERO, same)),
        ("a rod across an ellipsoid's middle", pose(disc, same, rod, DVec3::ZERO, lying)),
    ]
}
