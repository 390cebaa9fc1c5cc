//! Sheared periodic cells (Lees-Edwards boundaries): undisturbed bodies go with the cell exactly, crowded ones stay
//! apart within the tolerance, and neither which image a body is nor where the cell begins matters.

use crate::scenes::{ALONG_X, agrees_on_device, parse, run};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::contacts;
use relcp::simulation::{Compute, Simulation};
use relcp::step::StepReport;
use serde_json::{Value, json};

const TOLERANCE: f64 = 1e-7;

/// The periods of a crowd in the plane, and its shear rate.
const SIDES: [f64; 2] = [7.5, 6.3];
const RATE: f64 = 0.6;

fn cell(lengths: &Value, rate: f64, axes: [&str; 2]) -> Value {
    json!({"lengths": lengths, "shear": {"rate": rate, "direction": axes[0], "gradient": axes[1]}})
}

fn scene(dt: f64, end: f64, cell: &Value, bodies: &[Value]) -> Value {
    json!({"name": "sheared", "time": {"dt": dt, "end": end}, "periodic": cell, "bodies": bodies,
        "dynamics": {"overdamped": {"drag": 1.5}}, "solver": {"tolerance": 1e-10},
        "contact": {"overlap_tolerance": TOLERANCE}})
}

fn overlap(bodies: &Bodies) -> f64 {
    contacts(bodies, 0.0).iter().map(|c| -c.separation).fold(0.0, f64::max)
}

/// The bodies at the end of a run in each step of which the overlap of every pair, through every image, is within the
/// tolerance.
fn watched(of: &Value, mut see: impl FnMut(&StepReport, &Bodies)) -> Bodies {
    let mut simulation = Simulation::builder(parse(of)).on(&Compute::Cpu).build().unwrap();
    let mut touching = 0;
    while !simulation.done() {
        let report = simulation.step().unwrap();
        touching = touching.max(simulation.contacts(1e-5).unwrap().len());
        let bodies = &simulation.state().unwrap().bodies;
        assert!(overlap(bodies) <= TOLERANCE && !report.parted, "{:e}", overlap(bodies));
        see(&report, bodies);
    }
    println!("{touching} contacts in a step, at most");
    assert!(touching > 3, "none touch");
    simulation.state().unwrap().bodies.clone()
}

#[test]
fn bodies_that_nothing_disturbs_go_with_the_cell_exactly() {
    let places = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(-13.0, 41.0, -20.0)];
    for (axes, [d, e]) in [(["x", "y"], [0, 1]), (["x", "z"], [0, 2]), (["y", "z"], [1, 2])] {
        for dt in [0.04, 0.01] {
            let bodies: Vec<Value> = places
                .iter()
                .map(|x| json!({"shape": {"sphere": {"radius": 0.5}}, "position": x.to_array()}))
                .collect();
            let of = scene(dt, 2.0, &cell(&json!([10, 9, 8]), -1.5, axes), &bodies);
            let end = run(parse(&of), &Compute::Cpu).bodies;
            for (i, start) in places.into_iter().enumerate() {
                let mut there = start;
                there[d] += -1.5 * 2.0 * start[e];
                assert!(end.position[i].distance(there) < 1e-11, "{} {there}", end.position[i]);
            }
            let lengths = [10.0, 9.0, 8.0];
            let tilt = end.periods.tilt().unwrap();
            let offset = -3.0 * lengths[e];
            let turns = (offset - tilt.offset) / lengths[d];
            assert!((turns - turns.round()).abs() < 1e-12 && 2.0 * tilt.offset.abs() <= lengths[d], "{tilt:?}");
        }
    }
}

/// Balls and rods in the plane in rows so near each other that they cannot slide over each other, some of them at
/// images some cells away.
fn crowd(images: i32, origin: DVec3) -> Vec<Value> {
    let at = |i: i32, j: i32| {
        let wiggle = |k: i32| 0.02 * f64::from((7 * i + 3 * j + 2 * k) % 5 - 2);
        let away = f64::from(if images == 0 { 0 } else { (i + 2 * j) % 3 - 1 } * images);
        let up = f64::from(if images == 0 { 0 } else { (2 * i + j) % 5 - 2 } * images);
        let row = 1.5 * (f64::from(i) + 0.5 * f64::from(j % 2));
        let place = origin
            + DVec3::new(row + wiggle(0) + SIDES[0] * away, 1.05 * f64::from(j) + wiggle(1) + SIDES[1] * up, 0.0);
        if (i + j) % 2 == 0 {
            return json!({"shape": {"sphere": {"radius": 0.58}}, "position": place.to_array()});
        }
        let turn = DQuat::from_rotation_z(0.6 * f64::from(i * j)) * DQuat::from_xyzw(0.0, ALONG_X[2], 0.0, ALONG_X[0]);
        json!({"shape": {"spherocylinder": {"diameter": 0.7, "length": 1.15}}, "position": place.to_array(),
            "orientation": [turn.w, turn.x, turn.y, turn.z]})
    };
    (0..5).flat_map(|i| (0..6).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect()
}

fn crowded(dt: f64, end: f64, dynamics: &Value, images: i32, origin: DVec3) -> Value {
    let bodies = crowd(images, origin);
    let mut of = scene(dt, end, &cell(&json!([SIDES[0], SIDES[1], null]), RATE, ["x", "y"]), &bodies);
    (of["planar"], of["dynamics"]) = (json!(true), dynamics.clone());
    // With inertia a body starts with the velocity of its own place.
    if dynamics.get("inertial").is_some() {
        for body in of["bodies"].as_array_mut().unwrap() {
            let y = body["position"][1].as_f64().unwrap();
            body["velocity"] = json!([RATE * y, 0, 0]);
        }
    }
    of
}

fn laws() -> [Value; 3] {
    [
        json!({"overdamped": {"drag": 1.5}}),
        json!({"inertial": {"density": 0.5, "drag": 2}}),
        json!({"inertial": {"density": 0.5}}),
    ]
}

#[test]
fn a_sheared_crowd_is_the_same_whichever_image_a_body_is_and_wherever_the_cell_begins() {
    let (dt, end) = (0.02, 1.4);
    for law in laws() {
        let reference = watched(&crowded(dt, end, &law, 0, DVec3::ZERO), |_, _| {});
        let worst = |there: &Bodies, origin: DVec3| {
            // The flow is zero at the origin, so that the whole goes with its own place.
            let moved = origin + DVec3::new(RATE * end * origin.y, 0.0, 0.0);
            let off = |i: usize| {
                let place = reference.periods.nearest(reference.position[i] + moved - there.position[i]).length();
                let (p, q) = (reference.orientation[i], there.orientation[i]);
                place.max((p - q).length().min((p + q).length()))
            };
            (0..there.len()).map(off).fold(0.0, f64::max)
        };
        let images = watched(&crowded(dt, end, &law, 3, DVec3::ZERO), |_, _| {});
        let origin = DVec3::new(1.3, -2.9, 0.0);
        let shifted = watched(&crowded(dt, end, &law, 0, origin), |_, _| {});
        let off = [worst(&images, DVec3::ZERO), worst(&shifted, origin)];
        println!("{law}: other images {:.1e} apart, another origin {:.1e}", off[0], off[1]);
        assert!(off.iter().all(|off| *off < 1e-9), "{off:?}");
    }
}

#[test]
fn sheared_cells_on_a_device_are_the_cpus() {
    let law = json!({"overdamped": {"drag": 1.5}});
    agrees_on_device(&parse(&crowded(0.02, 0.6, &law, 2, DVec3::ZERO)), "a crowd in the plane", [2e-4, 1e-6]);
    let rod = |i: u32| {
        let q = DQuat::from_axis_angle(DVec3::new(1.0, f64::from(i % 3), 0.5).normalize(), 0.7 * f64::from(i));
        let place = [1.3 * f64::from(i % 3), 1.3 * f64::from(i / 3 % 3), 1.3 * f64::from(i / 9) - 8.0];
        let shape = json!({"spherocylinder": {"diameter": 0.5, "length": 1}});
        json!({"shape": shape, "position": place, "orientation": [q.w, q.x, q.y, q.z], "velocity": [0, -0.7 * place[2], 0]})
    };
    let bodies: Vec<Value> = (0..27).map(rod).collect();
    let mut of = scene(0.02, 0.4, &cell(&json!([null, 3.9, 4]), -0.7, ["y", "z"]), &bodies);
    of["dynamics"] = json!({"inertial": {"density": 0.1, "drag": 20}});
    agrees_on_device(&parse(&of), "rods with inertia in space", [2e-4, 1e-6]);
}
