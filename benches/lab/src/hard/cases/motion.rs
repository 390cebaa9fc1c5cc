//! Strongly driven bodies: rings pulled taut, impacts, and conservation with inertia.

use super::Case;
use crate::hard::laws::Law;
use crate::hard::start::{Random, Start, body, ellipsoid, moving, ring, rod, sphere, upright};
use glam::{DQuat, DVec3};
use relcp::scene::Body;
use relcp::shape::Shape;
use std::f64::consts::FRAC_PI_2;

pub(super) fn cases() -> Vec<Case> {
    [taut(), impacts(), inertia()].concat()
}

/// A chain of rings, each linked with the next, pulled at both ends.
fn links(count: usize, force: f64, dt: f64) -> Start {
    let at = |i: usize| {
        let turned = if i.is_multiple_of(2) { DQuat::IDENTITY } else { DQuat::from_rotation_x(FRAC_PI_2) };
        body(ring(1.0, 0.1), [1.5 * i as f64, 0.0, 0.0], turned)
    };
    let ends = [(0, [-force, 0.0, 0.0]), (count - 1, [force, 0.0, 0.0])];
    Start::still(dt, (0..count).map(at).collect()).pushed(&ends)
}

fn taut() -> Vec<Case> {
    let of = |name: &str, count, force, dt| Case::contact("rings", name, 60, links(count, force, dt)).of(Law::Linked);
    vec![
        of("two linked rings pulled taut", 2, 10.0, 0.01),
        of("chain of eight linked rings pulled taut", 8, 100.0, 0.01),
        of("two linked rings, pulled by their size a step", 2, 100.0, 0.05),
        of("chain of eight linked rings, pulled by a ring's size a step", 8, 100.0, 0.05),
    ]
}

/// The middle one of three is light and between heavy ones that come at it.
fn between(shape: impl Fn(f64) -> Shape, size: f64, speed: f64, dt: f64) -> Start {
    // They would meet in the third step.
    let away = 1.1 + 2.0 * speed * dt;
    let heavy = |side: f64| moving(upright(shape(1.0), [side * away, 0.0, 0.0]), [-side * speed, 0.0, 0.0], [0.0; 3]);
    let light = moving(upright(shape(size), [0.1, 0.02 * size, 0.0]), [0.0; 3], [0.0; 3]);
    Start::inertial(dt, vec![heavy(-1.0), light, heavy(1.0)])
}

fn impacts() -> Vec<Case> {
    let of = |name: String, start: Start| Case::contact("impact", name, 20, start).of(Law::InOrder);
    let spheres = |mass: &str, size: f64, speed: f64| {
        let name = format!("a sphere of {mass} between heavy ones, {speed} lengths a step");
        of(name, between(sphere, size, speed, 1.0))
    };
    let blunt = |size: f64| ellipsoid([size, 1.5 * size, 1.5 * size]);
    vec![
        spheres("1e-3 of the mass", 0.1, 0.25),
        spheres("1e-6 of the mass", 0.01, 0.25),
        spheres("1e-9 of the mass", 1e-3, 2.0),
        of("an ellipsoid of 1e-3 of the mass between heavy ones".into(), between(blunt, 0.1, 0.25, 1.0)),
        of("a fast sphere into a chain of ten".into(), cradle()),
    ]
}

fn cradle() -> Start {
    let mut bodies = vec![moving(upright(sphere(0.5), [-5.0, 0.0, 0.0]), [1000.0, 0.0, 0.0], [0.0; 3])];
    bodies.extend((0..10).map(|i| upright(sphere(0.5), [f64::from(i), 0.0, 0.0])));
    Start::inertial(1e-2, bodies)
}

/// Bodies on a lattice, apart, that fall together and turn.
fn cloud(seed: u64, shape: Shape, dt: f64) -> Start {
    let mut random = Random::new(seed);
    let pitch = 1.1 * shape.major_axis();
    let at = |i: u32| -> Body {
        let position = pitch * (DVec3::from([i % 3, i / 3 % 3, i / 9].map(f64::from)) - 1.0);
        let velocity = -20.0 * position + random.vector();
        let resting = body(shape, position.to_array(), random.orientation());
        moving(resting, velocity.to_array(), (5.0 * random.vector()).to_array())
    };
    Start::inertial(dt, (0..27).map(at).collect())
}

fn inertia() -> Vec<Case> {
    let shapes = [("spheres", sphere(0.5)), ("rods", rod(0.4, 1.6)), ("ellipsoids", ellipsoid([0.3, 0.5, 0.8]))];
    let of = |(name, shape): (&str, Shape)| {
        let start = cloud(5, shape, 0.01);
        let case =
            |what: &str| Case::contact("inertia", format!("27 {name} fall together: {what}"), 100, start.clone());
        // Solved so well that what is left is the method's own.
        let fine = Case { start: start.clone().solved_to(1e-11), ..case("energy") };
        [case("momentum").of(Law::Momentum), fine.of(Law::Energy)]
    };
    shapes.into_iter().flat_map(of).collect()
}
