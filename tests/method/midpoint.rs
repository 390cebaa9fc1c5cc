//! The midpoint step: its order with and without inertia and growth, and that it keeps what a step of first order
//! promises.

use crate::laws::{body, rod, sphere, start};
use crate::promises::{HEAPS, backend, objective};
use crate::random::{Random, heap, parse};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::internals::dynamics::stretch;
use relcp::internals::step::Verbs;
use relcp::scene::{Scene, Stepping};
use relcp::separation::{Placed, separation};
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use relcp::step::contacts;
use serde_json::json;
use std::f64::consts::FRAC_PI_2;

/// Where a scene ends with steps of `dt`: centres and long axes as numbers.
fn end(scene: &Scene, dt: f64, stepping: Stepping) -> Vec<f64> {
    let mut scene = scene.clone();
    scene.time.dt = dt;
    scene.time.stepping = stepping;
    let tolerance = scene.contact.overlap_tolerance;
    let mut simulation = start(scene);
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.max_overlap <= tolerance && report.unconverged == 0, "{report:?}");
    }
    let bodies = &simulation.state().unwrap().bodies;
    let axes = bodies.orientation.iter().map(|q| *q * DVec3::Z);
    bodies.position.iter().copied().chain(axes).flat_map(|v| v.to_array()).collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The errors of a scene at steps of `dt`, `dt / 2`, ... against midpoint steps of `dt / fine`.
fn errors(scene: &Scene, dt: f64, halvings: u32, fine: f64, stepping: Stepping) -> Vec<f64> {
    let exact = end(scene, dt / fine, Stepping::Midpoint);
    let of = |k: u32| apart(&end(scene, dt / f64::from(1 << k), stepping), &exact);
    let errors: Vec<f64> = (0..halvings).map(of).collect();
    println!("{} {stepping:?} from dt {dt}: {errors:.7?}, orders {:.2?}", scene.name, orders(&errors));
    errors
}

fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

#[test]
fn two_ellipsoids_pass_at_second_order() {
    let at_30 = |dt: f64, stepping| {
        let scene = Scene::load("two-ellipsoids", ["time.end=30"]).unwrap();
        let found = end(&scene, dt, stepping);
        // The upper body's centre and the angle of its long axis.
        [found[0], found[1], (found[7] / found[6]).atan()]
    };
    let fine = at_30(0.0015625, Stepping::Midpoint);
    for (found, independent) in fine.iter().zip([0.99505, 0.54426, -0.49413]) {
        assert!((found - independent).abs() < 1.5e-5, "{fine:?}");
    }
    let euler = at_30(0.003125, Stepping::Euler);
    let coarse: Vec<_> = (0..5).map(|k| at_30(0.2 / f64::from(1 << k), Stepping::Midpoint)).collect();
    for i in 0..3 {
        let errors: Vec<f64> = coarse.iter().map(|found| (found[i] - fine[i]).abs()).collect();
        println!("{errors:.7?}, orders {:.2?}; Euler at 0.003125 {:.1e}", orders(&errors), euler[i] - fine[i]);
        assert!(orders(&errors).iter().all(|order| *order >= 1.8), "{errors:?}");
        assert!((euler[i] - fine[i]).abs() < 3e-4, "{euler:?} {fine:?}");
    }
}

#[test]
fn the_order_does_not_depend_on_the_tolerance() {
    let mut scene = Scene::load("two-ellipsoids", ["time.end=30"]).unwrap();
    scene.contact.overlap_tolerance = 1e-9;
    let errors = errors(&scene, 0.4, 3, 128.0, Stepping::Midpoint);
    assert!(orders(&errors).iter().all(|order| *order >= 1.8), "{errors:?}");
}

/// The mean order of the upper body's path to t = 16 over four halvings, by a method that does not recur.
fn order_without_recursion(method: serde_json::Value) -> f64 {
    let mut scene = Scene::load("two-ellipsoids", ["time.end=16"]).unwrap();
    scene.contact.method = serde_json::from_value(method.clone()).unwrap();
    scene.time.stepping = Stepping::Midpoint;
    let end = |dt: f64| {
        let mut scene = scene.clone();
        scene.time.dt = dt;
        let mut simulation = start(scene);
        while !simulation.done() {
            assert_eq!(simulation.step().unwrap().recursions, 0);
        }
        simulation.state().unwrap().bodies.position[0]
    };
    let fine = end(0.4 / 256.0);
    let errors: Vec<f64> = (0..5).map(|k| (end(0.4 / f64::from(1 << k)) - fine).length()).collect();
    println!("{method}: {errors:.7?}, orders {:.2?}", orders(&errors));
    (errors[0] / errors[4]).log2() / 4.0
}

#[test]
fn single_solves_step_at_second_order_and_sub_spheres_at_first() {
    assert!(order_without_recursion(json!("snsd")) >= 1.8);
    // Contact passes from sphere to sphere: a proxy's surface has kinks, and a normal jumps at one somewhere in a step.
    let order = order_without_recursion(json!({"multisphere": {"count": 9}}));
    assert!((0.8..1.6).contains(&order), "{order}");
}

fn cells(length: [f64; 4], division_length: f64) -> Scene {
    let cell = |x: f64, y: f64, turn: f64, length: f64| {
        body(rod(0.5, length), [x, y, 0.0], DQuat::from_rotation_z(turn) * DQuat::from_rotation_y(FRAC_PI_2))
    };
    let [a, b, c, d] = length;
    parse(&json!({
        "name": "cells", "planar": true, "time": {"dt": 0.1, "end": 0.6}, "contact": {"overlap_tolerance": 1e-7},
        "growth": {"rate": 1.0, "division_length": division_length, "reorientation_degrees": 0.01},
        "bodies": [cell(0.0, 0.0, 0.1, a), cell(0.6, 0.75, 0.3, b), cell(-0.5, -0.8, -0.2, c), cell(2.5, -0.3, 0.7, d)]
    }))
}

#[test]
fn growing_cells_push_each_other_at_second_order() {
    let scene = cells([2.0, 2.2, 1.9, 2.1], 8.0);
    let midpoint = errors(&scene, 0.05, 4, 64.0, Stepping::Midpoint);
    assert!(orders(&midpoint).iter().all(|order| *order >= 1.8), "{midpoint:?}");
    let euler = errors(&scene, 0.05, 4, 64.0, Stepping::Euler);
    assert!(midpoint[3] < 0.2 * euler[3]);
}

#[test]
fn cells_that_divide_between_steps_do_so_at_first_order() {
    // A division waits for the next step's start, up to dt too late.
    let scene = cells([2.0, 2.2, 1.9, 2.1], 3.0);
    let errors = errors(&scene, 0.05, 5, 64.0, Stepping::Midpoint);
    assert!((errors[0] / errors[4]).log2() >= 4.0 * 0.8, "{errors:?}");
}

#[test]
fn a_stretch_is_the_derivative_of_the_separation_by_length() {
    let mut random = Random::new(11);
    let mut worst = 0.0f64;
    for k in 0..200 {
        let (mut a, b, _) = random.pair(["spherocylinder", ["spherocylinder", "ellipsoid", "sphere"][k % 3]]);
        if k % 10 == 0 {
            // As long as it is thick: it can only grow.
            a.shape = Shape::Spherocylinder { diameter: 0.6, length: 0.6 };
        }
        let length = a.shape.growing_length().unwrap();
        let at = |by: f64| {
            let shape = a.shape.grown(length + by).unwrap();
            let of = |p: &Placed, q: &Placed| separation(p, q, None).unwrap();
            (shape, of(&Placed { shape, ..a }, &b), of(&b, &Placed { shape, ..a }))
        };
        let step = 1e-6;
        let (_, first, second) = at(0.0);
        let (longer, after_first, after_second) = at(step);
        let (on_a, on_b) =
            (stretch(&a, &longer, first.lever_a, first.normal), stretch(&a, &longer, second.lever_b, -second.normal));
        // The separations are those of the pair in both orders.
        let off = (after_first.separation - first.separation + first.normal.dot(on_a)).abs();
        worst = worst.max(off).max((after_second.separation - second.separation - second.normal.dot(on_b)).abs());
    }
    println!("off by {:.1e} of the growth", worst / 1e-6);
    // The error of a forward difference is its step times the second derivative.
    assert!(worst < 1e-5 * 1e-6, "{worst:e}");
}

fn inertial(apart: f64) -> Scene {
    let sets = ["dynamics={\"inertial\":{\"density\":0.2}}", "time.end=3", "contact.overlap_tolerance=1e-8"];
    let mut scene = Scene::load("two-ellipsoids", sets).unwrap();
    for body in &mut scene.bodies {
        body.position[1] *= apart;
        body.angular_velocity = Some([0.3, 0.2, 0.4]);
    }
    scene
}

#[test]
fn bodies_with_inertia_fly_and_turn_at_second_order() {
    let errors = errors(&inertial(4.0), 0.04, 4, 128.0, Stepping::Midpoint);
    assert!(orders(&errors).iter().all(|order| *order >= 1.9), "{errors:?}");
}

#[test]
fn bodies_with_inertia_collide_at_first_order() {
    let scene = inertial(0.64);
    let [midpoint, euler] = [Stepping::Midpoint, Stepping::Euler].map(|s| errors(&scene, 0.04, 5, 128.0, s));
    // Both come to the same end. When a body is hit within the step decides, not how well it turns until then.
    for errors in [midpoint, euler] {
        assert!((errors[0] / errors[4]).log2() >= 4.0 * 0.8, "{errors:?}");
    }
}

#[test]
fn a_collision_is_inelastic_wherever_in_the_step_it_comes() {
    for gap in [0.0, 0.003, 0.5] {
        let moving = |x: f64, u: f64| {
            let mut body = body(sphere(0.5), [x, 0.0, 0.0], DQuat::IDENTITY);
            body["velocity"] = json!([u, 0.0, 0.0]);
            body
        };
        let mut simulation = start(parse(&json!({
            "name": "collision", "time": {"dt": 0.01, "end": 1.0, "stepping": "midpoint"},
            "dynamics": {"inertial": {"density": 2.0}}, "solver": {"tolerance": 1e-13},
            "bodies": [moving(-0.5 - gap, 3.0), moving(0.5, -1.0)]
        })));
        while !simulation.done() {
            assert!(simulation.step().unwrap().max_overlap <= 1e-12);
        }
        let bodies = &simulation.state().unwrap().bodies;
        assert!(bodies.velocity.iter().all(|u| (*u - DVec3::X).length() < 1e-11), "{:?}", bodies.velocity);
        assert!((bodies.position[1].x - bodies.position[0].x - 1.0).abs() < 1e-11);
    }
}

#[test]
fn every_built_in_scene_holds_its_tolerance_at_every_step() {
    let scenes: [(&str, &[&str]); 6] = [
        ("two-ellipsoids", &["time.dt=0.2"]),
        ("three-capsules", &[]),
        ("compaction", &["generate.0.isotropic.count=60", "time.end=60", "time.dt=0.2"]),
        ("chainmail", &["time.end=1", "time.dt=0.02", "generate.0.chainmail.columns=3", "generate.0.chainmail.rows=3"]),
        ("colony", &["time.end=3.5", "time.dt=0.02"]),
        ("colony", &["time.end=2.5", "time.dt=0.02", "dynamics={\"inertial\":{\"density\":1.0}}"]),
    ];
    for (name, sets) in scenes {
        let sets: Vec<String> = sets.iter().copied().chain(["time.stepping=\"midpoint\""]).map(str::to_owned).collect();
        let mut simulation = start(Scene::load(name, &sets).unwrap());
        let (mut recursions, mut most, mut worst) = (0, 0, 0.0f64);
        while !simulation.done() {
            let report = simulation.step().unwrap();
            assert_eq!(report.unconverged, 0);
            (recursions, most) = (recursions + report.recursions, most.max(report.recursions));
            worst = worst.max(report.max_overlap);
        }
        let audited = contacts(&simulation.state().unwrap().bodies, 0.0);
        let audited = audited.iter().map(|contact| -contact.separation).fold(0.0, f64::max);
        println!("{name}: {} bodies, {recursions} recursions, {most} at most, {worst:.1e}", simulation.bodies());
        assert!(worst <= 1e-5 && audited <= 1e-5, "{name}: {worst:e} {audited:e}");
        if simulation.scene().planar {
            assert!(simulation.state().unwrap().bodies.position.iter().all(|x| x.z == 0.0));
        }
    }
}

#[test]
fn rows_only_tighten_and_the_recursion_ends() {
    let (mut tightened, mut appended) = (0, 0);
    for (seed, kinds) in (0..8).zip(HEAPS.iter().cycle()) {
        let mut scene = heap(seed, kinds, 24, 0.05);
        scene.time.stepping = Stepping::Midpoint;
        let mut backend = backend(&scene);
        for _ in 0..2 {
            backend.begin().unwrap();
            backend.append_near().unwrap();
            backend.solve(scene.lcp_settings().tolerance).unwrap();
            backend.middle().unwrap();
            backend.append_near().unwrap();
            let (mut last, mut recursions) = (f64::INFINITY, 0);
            loop {
                let outcome = backend.solve(scene.lcp_settings().tolerance).unwrap();
                assert!(outcome.residual <= 1e-10, "{outcome:?}");
                let (problem, gamma) = backend.lcp();
                let (objective, least) = objective(problem, gamma);
                let scale = 1e-9 * gamma.iter().sum::<f64>().max(1.0);
                assert!(objective <= last + scale, "the objective rose from {last} to {objective}");
                assert!(least >= -1e-9, "a retained row is violated by {least:e}");
                last = objective;
                let before = problem.clone();
                let overlap = backend.trial(scene.contact.overlap_tolerance).unwrap();
                if overlap.violations == 0 {
                    break;
                }
                if recursions < 3 {
                    backend.tighten_violations().unwrap();
                } else {
                    backend.append_violations(false).unwrap();
                }
                recursions += 1;
                assert!(recursions < 64, "the recursion does not end");
                let (after, _) = backend.lcp();
                let rows = before.q.len();
                assert_eq!((&after.pair[..rows], &after.jacobian[..rows]), (&before.pair[..], &before.jacobian[..]));
                assert!(after.q.iter().zip(&before.q).all(|(after, before)| after <= before));
                let moved = after.q.iter().zip(&before.q).filter(|(after, before)| after < before).count();
                assert!(moved + after.q.len() - rows >= overlap.violations, "each violating pair has its turn");
                (tightened, appended) = (tightened + moved, appended + after.q.len() - rows);
            }
            backend.accept().unwrap();
        }
    }
    println!("{tightened} rows tightened, {appended} appended");
    assert!(tightened > 10 && appended > 3, "the heaps hardly tried it: {tightened} {appended}");
}

/// The centres of a colony that goes on from `bodies` for a time of 0.05.
fn centres_after(bodies: &Bodies, sets: &[&str]) -> Vec<DVec3> {
    let sets = sets.iter().chain(&["time.start=4", "time.end=4.05", "contact.overlap_tolerance=1e-6"]);
    let scene = Scene::load("colony", sets).unwrap();
    let mut simulation = Simulation::builder(scene).bodies(bodies.clone()).build().unwrap();
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-6);
    }
    simulation.state().unwrap().bodies.position.clone()
}

/// Where rods lie side by side the nearest points jump from end to end in a step: an offset that was moved for the one
/// end pushed at the other, and midpoint steps came out ten times farther off than the paper's.
#[test]
fn crowded_rods_whose_contacts_jump_are_no_farther_off_than_by_eulers_steps() {
    let scene = Scene::load("colony", ["time.end=4", "time.dt=0.01"]).unwrap();
    let founder = scene.build().unwrap();
    let mut colony = Simulation::builder(scene).bodies(founder).build().unwrap();
    while !colony.done() {
        colony.step().unwrap();
    }
    let bodies = &colony.state().unwrap().bodies;
    assert_eq!(bodies.len(), 32);
    let fine = centres_after(bodies, &["time.dt=2e-4"]);
    let off = |sets: &[&str]| {
        let found = centres_after(bodies, sets);
        let squares: f64 = found.iter().zip(&fine).map(|(x, y)| (*x - *y).length_squared()).sum();
        (squares / fine.len() as f64).sqrt()
    };
    let [euler, midpoint] = ["euler", "midpoint"].map(|kind| off(&["time.dt=0.01", &format!("time.stepping={kind}")]));
    println!("{euler:.2e} by Euler's steps, {midpoint:.2e} by midpoint steps");
    assert!(midpoint < euler, "{midpoint} against {euler}");
}
