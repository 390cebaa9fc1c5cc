//! Periodic cells whose lengths change: undisturbed bodies go with the cell exactly, crowded ones stay apart within the
//! tolerance, and which image a body is does not matter.

use crate::scenes::{ALONG_X, agrees_on_device, parse, run};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::contacts;
use relcp::simulation::{Compute, Simulation};
use relcp::step::Fault;
use serde_json::{Value, json};

const TOLERANCE: f64 = 1e-7;

fn ball(radius: f64, position: [f64; 3]) -> Value {
    json!({"shape": {"sphere": {"radius": radius}}, "position": position})
}

fn scene(dt: f64, end: f64, cell: &Value, bodies: &[Value]) -> Value {
    json!({"name": "strained", "time": {"dt": dt, "end": end}, "periodic": cell, "bodies": bodies,
        "dynamics": {"overdamped": {"drag": 1.5}}, "contact": {"overlap_tolerance": TOLERANCE}})
}

fn started(of: &Value) -> Simulation {
    Simulation::builder(parse(of)).on(&Compute::Cpu).build().unwrap()
}

fn overlap(bodies: &Bodies) -> f64 {
    contacts(bodies, 0.0).iter().map(|c| -c.separation).fold(0.0, f64::max)
}

#[test]
fn bodies_that_nothing_disturbs_go_with_the_cell_exactly() {
    let rates = DVec3::new(-0.2, 0.3, 0.05);
    let cell = json!({"lengths": [10, 9, 8], "strain_rate": rates.to_array()});
    let places = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(-13.0, 4.0, 20.0)];
    for dt in [0.04, 0.01] {
        let bodies: Vec<Value> = places.iter().map(|x| ball(0.5, x.to_array())).collect();
        let end = run(parse(&scene(dt, 2.0, &cell, &bodies)), &Compute::Cpu).bodies;
        let stretch = 1.0 + 2.0 * rates;
        for (place, start) in end.position.iter().zip(places) {
            assert!(place.distance(start * stretch) < 1e-12, "{place}");
        }
        let lengths = end.periods.length();
        assert!(lengths.distance(DVec3::new(10.0, 9.0, 8.0) * stretch) < 1e-13, "{lengths}");
    }
}

/// A rod in the plane turns by the strain: `tan(angle)` from x grows as `h_y / h_x`.
#[test]
fn a_rod_turns_with_the_strain_to_first_order() {
    let cell = json!({"lengths": [20, 20, null], "strain_rate": [-0.2, 0.3, 0]});
    let start = 0.4_f64;
    let q = DQuat::from_rotation_z(start) * DQuat::from_xyzw(0.0, ALONG_X[2], 0.0, ALONG_X[0]);
    let rod = json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "position": [0, 0, 0],
        "orientation": [q.w, q.x, q.y, q.z]});
    let error = |dt: f64| {
        let mut of = scene(dt, 1.0, &cell, std::slice::from_ref(&rod));
        of["planar"] = json!(true);
        let axis = run(parse(&of), &Compute::Cpu).bodies.orientation[0] * DVec3::Z;
        ((axis.y / axis.x).atan() - (start.tan() * 1.3 / 0.8).atan()).abs()
    };
    let [coarse, fine] = [1.0 / 128.0, 1.0 / 256.0].map(error);
    println!("a rod: {coarse:.2e}, {fine:.2e} with half the step, ratio {:.3}", coarse / fine);
    assert!((coarse / fine / 2.0 - 1.0).abs() < 0.05, "{coarse:e} {fine:e}");
}

/// Balls in the plane, each in its own cell of a lattice with some disorder.
fn crowd(radius: f64, turns: f64) -> Vec<Value> {
    let at = |i: i32, j: i32| {
        let wiggle = |k: i32| 0.12 * f64::from((7 * i + 5 * j + 3 * k) % 5 - 2);
        let image = if (i + j) % 3 == 0 { turns } else { 0.0 };
        ball(
            radius,
            [1.25 * f64::from(i) + wiggle(0) + 7.5 * image, 1.25 * f64::from(j) + wiggle(1) - 7.5 * image, 0.0],
        )
    };
    (0..6).flat_map(|i| (0..6).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect()
}

#[test]
fn a_crowd_is_compressed_within_the_tolerance_whichever_image_a_body_is() {
    let cell = json!({"lengths": [7.5, 7.5, null], "strain_rate": [-0.1, -0.1, 0]});
    let end = |turns: f64| {
        let mut of = scene(0.02, 1.0, &cell, &crowd(0.5, turns));
        (of["planar"], of["solver"]) = (json!(true), json!({"tolerance": 1e-10}));
        let mut simulation = started(&of);
        while !simulation.done() {
            let report = simulation.step().unwrap();
            let bodies = &simulation.state().unwrap().bodies;
            assert!(overlap(bodies) <= TOLERANCE && !report.parted, "{:e}", overlap(bodies));
        }
        assert!(!simulation.contacts(1e-5).unwrap().is_empty(), "none touch");
        simulation.state().unwrap().bodies.clone()
    };
    let [here, there] = [0.0, 2.0].map(end);
    let off = |i: usize| here.periods.nearest(here.position[i] - there.position[i]).length();
    let worst = (0..here.len()).map(off).fold(0.0, f64::max);
    println!("other images: {worst:.1e} apart");
    assert!(worst < 1e-7, "{worst:e}");
}

#[test]
fn a_cell_without_room_ends_the_run() {
    let cell = json!({"lengths": [4.2, null, null], "strain_rate": [-0.2, 0, 0]});
    let walls = json!([{"channel": {"normal": [0, 1, 0], "center": [0, 0, 0], "width": 1.00001}}]);
    let row: Vec<Value> = (0..4).map(|i| ball(0.5, [1.04 * f64::from(i), 0.0, 0.0])).collect();
    let mut of = scene(0.05, 1.0, &cell, &row);
    (of["planar"], of["walls"]) = (json!(true), walls);
    let mut simulation = started(&of);
    let fault = loop {
        assert!(!simulation.done(), "there was room");
        match simulation.step() {
            Ok(_) => assert!(overlap(&simulation.state().unwrap().bodies) <= TOLERANCE),
            Err(fault) => break fault,
        }
    };
    assert!(matches!(fault, Fault::Unresolved(_)), "{fault}");
    // Four balls have room until the cell is 4 long.
    assert!((simulation.time() - 0.2 / 0.84).abs() < 0.051, "{}", simulation.time());
}

#[test]
fn changing_cells_on_a_device_are_the_cpus() {
    let cell = json!({"lengths": [7.5, 7.5, null], "strain_rate": [-0.1, -0.05, 0]});
    let mut of = scene(0.02, 0.6, &cell, &crowd(0.5, 2.0));
    (of["planar"], of["solver"]) = (json!(true), json!({"tolerance": 1e-9}));
    agrees_on_device(&parse(&of), "a crowd in the plane", [2e-4, 1e-6]);
    let rod = |i: u32| {
        let q = DQuat::from_axis_angle(DVec3::new(1.0, f64::from(i % 3), 0.5).normalize(), 0.7 * f64::from(i));
        let place = [1.3 * f64::from(i % 3), 1.3 * f64::from(i / 3 % 3), 1.3 * f64::from(i / 9)];
        let shape = json!({"spherocylinder": {"diameter": 0.5, "length": 1}});
        json!({"shape": shape, "position": place, "orientation": [q.w, q.x, q.y, q.z]})
    };
    let cell = json!({"lengths": [4, 4.1, null], "strain_rate": [-0.2, -0.3, 0]});
    let bodies: Vec<Value> = (0..18).map(rod).collect();
    let mut of = scene(0.02, 0.4, &cell, &bodies);
    of["solver"] = json!({"tolerance": 1e-9});
    of["dynamics"] = json!({"inertial": {"density": 0.1, "drag": 20}});
    agrees_on_device(&parse(&of), "rods with inertia in space", [2e-4, 1e-6]);
}
