//! Extreme sizes, closed rings, stacks and jams.

use super::{TOLERANCE, audited, ellipsoid, furthest, resolves, resolves_bodies, ring, scene};
use crate::laws::{body, rod, sphere, start};
use crate::random::{Random, heap};
use glam::{DQuat, DVec3};
use relcp::simulation::Simulation;
use serde_json::{Value, json};
use std::f64::consts::TAU;

#[test]
fn extreme_sizes_resolve() {
    let up = DQuat::IDENTITY;
    let big_small = [body(sphere(10.0), [0.0; 3], up), body(sphere(0.01), [10.0, 0.0, 0.0], up)];
    resolves_bodies("spheres 1000:1", &big_small, 4);
    let inward = json!([{"radial_inward": {}}]);
    for (name, shapes) in [
        ("rods 100:1", [rod(0.04, 4.0), rod(0.04, 4.0)]),
        ("ellipsoids 100:1", [ellipsoid([0.02, 0.02, 2.0]), ellipsoid([0.02, 0.02, 2.0])]),
        ("discs 1:100", [ellipsoid([2.0, 2.0, 0.02]), ellipsoid([2.0, 2.0, 0.02])]),
        ("rods and discs", [rod(0.04, 4.0), ellipsoid([2.0, 2.0, 0.02])]),
    ] {
        let mut random = Random::new(11);
        let bodies: Vec<Value> = (0..20)
            .map(|i| body(shapes[i % 2].clone(), (1.5 * random.vector()).to_array(), random.orientation()))
            .collect();
        resolves(name, &mut start(scene(1e-2, &bodies, inward.clone())), 10);
    }
}

#[test]
fn many_small_spheres_pushed_onto_a_big_one() {
    let mut random = Random::new(12);
    let mut bodies = vec![body(sphere(3.0), [0.0; 3], DQuat::IDENTITY)];
    bodies.extend((0..200).map(|_| {
        let x = random.direction() * random.within(3.2, 4.5);
        body(sphere(0.3), x.to_array(), DQuat::IDENTITY)
    }));
    resolves("200 on one", &mut start(scene(0.05, &bodies, json!([{"radial_inward": {}}]))), 20);
}

#[test]
fn a_closed_ring_of_spheres_squeezed() {
    let radius = 0.5 / (TAU / 24.0).sin();
    let bodies: Vec<Value> = (0..12)
        .map(|i| {
            let (s, c) = (TAU * f64::from(i) / 12.0).sin_cos();
            body(sphere(0.5), [radius * c, radius * s, 0.0], DQuat::IDENTITY)
        })
        .collect();
    for planar in [true, false] {
        let mut scene = scene(0.01, &bodies, json!([{"radial_inward": {}}]));
        scene.planar = planar;
        let mut simulation = start(scene);
        resolves(&format!("squeezed ring, planar {planar}"), &mut simulation, 50);
        let moved =
            simulation.state().unwrap().bodies.position.iter().map(|x| (x.length() - radius).abs()).fold(0.0, f64::max);
        println!("moved by {moved:e}");
        assert!(moved < 1e-4, "an arch holds itself: {moved:e}");
    }
}

#[test]
fn a_stack_of_spheres_compressed_from_both_ends() {
    let mut bodies: Vec<Value> =
        (0..30).map(|i| body(sphere(0.5), [1.0 * f64::from(i), 0.0, 0.0], DQuat::IDENTITY)).collect();
    bodies[0]["group"] = json!("low");
    bodies[29]["group"] = json!("high");
    let forces = json!([
        {"uniform": {"force": [10.0, 0.0, 0.0], "group": "low"}}, {"uniform": {"force": [-10.0, 0.0, 0.0], "group": "high"}}
    ]);
    let mut simulation = start(scene(0.1, &bodies, forces));
    resolves("stack", &mut simulation, 50);
    let total: f64 = simulation.state().unwrap().warm.iter().map(|w| w.gamma).sum();
    println!("total force {total}");
    // Every one of the 29 contacts carries the force of the ends.
    assert!((total - 290.0).abs() < 0.1, "{total}");
}

#[test]
fn a_jammed_start_without_forces_stays_put() {
    let mut bodies = Vec::new();
    for i in 0..27 {
        let x = [f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)];
        bodies.push(body(sphere(0.5), x, DQuat::IDENTITY));
    }
    let mut simulation = start(scene(0.1, &bodies, json!([])));
    let before = simulation.state().unwrap().bodies.position.clone();
    resolves("27 touching spheres", &mut simulation, 20);
    assert_eq!(simulation.state().unwrap().bodies.position, before);

    let mut settled = start(heap(71, &["spherocylinder", "ellipsoid"], 24, 0.02));
    settled.step().unwrap();
    let mut still = settled.scene().clone();
    still.forces.clear();
    let bodies = settled.state().unwrap().bodies.clone();
    let mut still = Simulation::builder(still).bodies(bodies.clone()).build().unwrap();
    resolves("a heap without its forces", &mut still, 20);
    let moved = furthest(&still.state().unwrap().bodies, &bodies, DVec3::ZERO, DQuat::IDENTITY);
    println!("moved by {moved:e}");
    // What is left to part is at most the tolerance a contact.
    assert!(moved < 10.0 * TOLERANCE, "{moved:e}");
}

#[test]
fn one_body_and_bodies_that_never_meet() {
    let one = [body(ring(1.0, 0.2), [1.0, 2.0, 3.0], DQuat::IDENTITY)];
    let mut simulation = start(scene(0.1, &one, json!([{"radial_inward": {}}])));
    resolves("one body", &mut simulation, 10);
    assert_eq!(simulation.state().unwrap().warm, []);
    let apart: Vec<Value> =
        (0..10).map(|i| body(rod(0.5, 1.0), [100.0 * f64::from(i), 0.0, 0.0], DQuat::IDENTITY)).collect();
    let mut simulation = start(scene(0.1, &apart, json!([{"uniform": {"force": [0.0, 0.0, 1.0]}}])));
    let reports = audited(&mut simulation, 10);
    assert!(reports.iter().all(|r| (r.constraints, r.iterations, r.max_overlap) == (0, 0, 0.0)));
    assert!(simulation.state().unwrap().bodies.position.iter().all(|x| (x.z - 1.0).abs() < 1e-12));
}

#[test]
fn bodies_given_beside_a_scene_without_any_still_touch() {
    let with = scene(
        0.1,
        &[body(sphere(0.5), [0.0; 3], DQuat::IDENTITY), body(sphere(0.5), [0.9, 0.0, 0.0], DQuat::IDENTITY)],
        json!([]),
    );
    let bodies = with.build().unwrap();
    let mut empty = with;
    empty.bodies.clear();
    let mut simulation = Simulation::builder(empty).bodies(bodies).build().unwrap();
    assert_eq!(simulation.step().unwrap().constraints, 1);
}
