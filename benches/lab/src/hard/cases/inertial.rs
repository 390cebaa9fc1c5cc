//! Bodies with inertia: free spins, drops, fast spins that meet, rings, heavy on light.

use super::Case;
use crate::hard::laws::Law;
use crate::hard::start::{Random, Start, body, ellipsoid, moving, ring, rod, sphere, upright};
use glam::{DQuat, DVec3};
use relcp::scene::{Body, Force, Stepping, Wall};
use relcp::shape::Shape;
use std::f64::consts::FRAC_PI_2;

pub(super) fn cases() -> Vec<Case> {
    [spins(), drops(), coarse(), whirls(), rings(), single()].concat()
}

fn case(name: impl Into<String>, steps: u64, start: Start, law: Law) -> Case {
    let mut case = Case::contact("inertial", name, steps, start).of(law);
    // Half a step before its last one's end: as many steps, whatever is rounded.
    case.start.scene.time.end = (steps as f64 - 0.5) * case.start.scene.time.dt;
    case
}

fn midpoint(mut start: Start) -> Start {
    start.scene.time.stepping = Stepping::Midpoint;
    start
}

fn within(mut start: Start, walls: Vec<Wall>) -> Start {
    start.scene.walls = walls;
    start
}

fn falling(mut start: Start, acceleration: f64) -> Start {
    start.scene.forces.push(Force::Gravity { acceleration: [0.0, 0.0, -acceleration], group: None, window: None });
    start
}

fn floor() -> Wall {
    Wall::HalfSpace { normal: [0.0, 0.0, 1.0], offset: 0.0, motion: None, friction: None, load: None }
}

/// A box on the floor, open or closed above.
fn bin(half: f64, height: f64) -> Wall {
    Wall::Box { minimum: [-half, -half, 0.0], maximum: [half, half, height], motion: None, friction: None }
}

/// Bodies that spin alone.
fn spins() -> Vec<Case> {
    let one = |shape: Shape, spin: [f64; 3], dt: f64| {
        Start::inertial(dt, vec![moving(upright(shape, [0.0; 3]), [0.0; 3], spin)])
    };
    let both = |name: &str, shape: Shape, spin: [f64; 3]| {
        let start = one(shape, spin, 0.01);
        let name = format!("{name} spins alone");
        [
            case(name.clone(), 800, start.clone(), Law::Spin),
            case(format!("{name}, midpoint"), 800, midpoint(start), Law::Spin),
        ]
    };
    let tumbling = both("an ellipsoid about its middle axis", ellipsoid([0.15, 0.35, 0.6]), [0.1, 20.0, 0.1]);
    let long = both("a long ellipsoid", ellipsoid([0.35, 0.35, 0.6]), [3.0, 15.0, 10.0]);
    let flat = both("a flat ellipsoid", ellipsoid([0.5, 0.5, 0.2]), [5.0, 9.0, 14.0]);
    let wheel = both("a ring", ring(0.5, 0.05), [4.0, 30.0, 8.0]);
    let mut cases = [tumbling, long, flat, wheel].concat();
    let fast = one(ellipsoid([0.2, 0.4, 0.7]), [40.0, 70.0, 60.0], 0.01);
    cases.push(case("an ellipsoid that turns by one radian a step spins alone", 800, fast, Law::Spin));
    cases
}

/// Bodies on a lattice above the floor, turned anyhow, apart: a body's length and a tenth from each other.
fn above(seed: u64, shape: Shape, count: u32, side: u32) -> Vec<Body> {
    let mut random = Random::new(seed);
    let pitch = 1.1 * shape.major_axis();
    let at = |i: u32| {
        let place = DVec3::from([i % side, i / side % side, i / (side * side)].map(f64::from));
        let middle = 0.5 * f64::from(side - 1);
        let position = pitch * (place - DVec3::new(middle, middle, -0.6));
        body(shape, position.to_array(), random.orientation())
    };
    (0..count).map(at).collect()
}

/// Half a bin in which such a lattice stands.
fn room(shape: &Shape, side: u32) -> f64 {
    0.5 * f64::from(side) * 1.1 * shape.major_axis() + 0.1
}

const SHAPES: [(&str, Shape); 4] = [
    ("spheres", Shape::Sphere { radius: 0.4 }),
    ("rods", Shape::Spherocylinder { diameter: 0.3, length: 1.2 }),
    ("ellipsoids", Shape::Ellipsoid { radii: [0.2, 0.35, 0.6] }),
    ("rings", Shape::Torus { major_radius: 0.5, minor_radius: 0.1 }),
];

/// Heaps that fall into a bin.
fn drops() -> Vec<Case> {
    let of = |(name, shape): (&str, Shape)| {
        let start = falling(Start::inertial(0.01, above(31, shape, 60, 4)), 10.0);
        let start = within(start, vec![bin(room(&shape, 4), 20.0)]);
        case(format!("60 {name} fall into a bin, dt 0.01"), 250, start, Law::NoGain)
    };
    let mut cases: Vec<Case> = SHAPES.into_iter().map(of).collect();
    let shape = ellipsoid([0.2, 0.35, 0.6]);
    let start = midpoint(falling(Start::inertial(0.01, above(32, shape, 27, 3)), 10.0));
    let cup = [[1.0, 0.0, 0.5], [-1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, -1.0, 0.5]];
    let walls = cup.map(|normal| Wall::HalfSpace { normal, offset: -1.6, motion: None, friction: None, load: None });
    cases.push(case("27 ellipsoids fall into a funnel, midpoint", 200, within(start, walls.to_vec()), Law::NoGain));
    cases
}

/// Gravity and a step that is far too long: bodies fall by a sixth of their length in the first.
fn coarse() -> Vec<Case> {
    let of = |(name, shape): (&str, Shape)| {
        let start = falling(Start::inertial(0.1, above(33, shape, 18, 3)), 10.0);
        case(format!("18 {name} fall onto a floor, dt 0.1"), 60, within(start, vec![floor()]), Law::NoGain)
    };
    let mut cases: Vec<Case> = SHAPES.into_iter().map(of).collect();
    let half = midpoint(falling(Start::inertial(0.1, above(33, ellipsoid([0.2, 0.35, 0.6]), 18, 3)), 10.0));
    let half = within(half, vec![floor()]);
    cases.push(case("18 ellipsoids fall onto a floor, dt 0.1, midpoint", 60, half, Law::NoGain));
    cases
}

/// Bodies that spin fast and meet.
fn whirls() -> Vec<Case> {
    let start = |shape: Shape, turn: f64, speed: f64| {
        let (mut random, dt) = (Random::new(34), 0.01);
        let spun = |resting: Body| {
            let (spin, velocity) = (turn / dt * random.direction(), speed * random.vector());
            moving(resting, velocity.to_array(), spin.to_array())
        };
        let bodies: Vec<Body> = above(35, shape, 27, 3).into_iter().map(spun).collect();
        let half = room(&shape, 3);
        within(Start::inertial(dt, bodies), vec![bin(half, 2.0 * half + shape.major_axis())])
    };
    let of = |(name, shape): (&str, Shape)| {
        let name = format!("27 {name} spin by half a radian a step in a box");
        case(name, 100, start(shape, 0.5, 1.0), Law::NoGain)
    };
    let mut cases: Vec<Case> = SHAPES[1..].iter().copied().map(of).collect();
    let gas = start(sphere(0.4), 0.01, 20.0);
    cases.push(case("27 spheres at a fifth of their size a step in a box", 150, gas, Law::NoGain));
    cases
}

/// Linked rings that are thrown apart.
fn rings() -> Vec<Case> {
    let chain = |count: usize, speed: f64| {
        let at = |i: usize| {
            let turned = if i.is_multiple_of(2) { DQuat::IDENTITY } else { DQuat::from_rotation_x(FRAC_PI_2) };
            let side = (2.0 * i as f64 / (count - 1) as f64) - 1.0;
            moving(body(ring(1.0, 0.1), [1.5 * i as f64, 0.0, 0.0], turned), [speed * side, 0.0, 0.0], [0.0; 3])
        };
        Start::inertial(0.01, (0..count).map(at).collect())
    };
    vec![
        case("two linked rings thrown apart", 100, chain(2, 5.0), Law::Linked),
        case("chain of eight linked rings thrown apart", 150, chain(8, 20.0), Law::Linked),
    ]
}

/// Few bodies: a coin, a wheel, a stack, heavy on light.
fn single() -> Vec<Case> {
    let on_floor = |dt: f64, bodies: Vec<Body>| within(falling(Start::inertial(dt, bodies), 10.0), vec![floor()]);
    let coin = ellipsoid([0.5, 0.5, 0.02]);
    let tilted = DQuat::from_rotation_x(1.3);
    let coin = moving(body(coin, [0.0, 0.0, 0.6], tilted), [0.0; 3], [0.0, 0.0, 25.0]);
    let wheel =
        moving(body(ring(0.5, 0.1), [0.0, 0.0, 0.65], DQuat::from_rotation_x(1.5)), [2.0, 0.0, 0.0], [0.0, 40.0, 0.0]);
    let disc = ellipsoid([0.6, 0.6, 0.1]);
    let stack = (0..10).map(|i| upright(disc, [0.01 * f64::from(i % 3), 0.0, 0.1 + 0.2 * f64::from(i)])).collect();
    let mut heavy = above(36, sphere(0.05), 48, 4);
    heavy.push(moving(upright(sphere(1.5), [0.0, 0.0, 3.0]), [0.0, 0.0, -5.0], [0.0; 3]));
    let heavy = within(falling(Start::inertial(0.005, heavy), 10.0), vec![bin(1.6, 10.0)]);
    let lance = rod(0.1, 2.0);
    let mut shot = above(37, ellipsoid([0.2, 0.3, 0.4]), 18, 3);
    let along = DQuat::from_rotation_y(FRAC_PI_2);
    shot.push(moving(body(lance, [-4.0, 0.1, 1.3], along), [20.0, 0.0, 0.0], [0.0, 0.0, 3.0]));
    vec![
        case("a coin 1:25 spins down on a floor", 300, on_floor(0.01, vec![coin]), Law::NoGain),
        case("a ring rolls on a floor, spinning", 300, on_floor(0.01, vec![wheel]), Law::NoGain),
        case("a stack of ten discs stands", 100, on_floor(0.02, stack), Law::NoGain),
        case("a sphere of 27,000 times their mass falls onto 48 spheres", 150, heavy, Law::NoGain),
        case("a lance into 18 ellipsoids", 60, Start::inertial(0.01, shot), Law::NoGain),
    ]
}
