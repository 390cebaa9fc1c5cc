//! Bodies that rest on each other, and where they do not.

use crate::scenes::{G, assert_near, ball, floor, inertial, pyramid, run, run_on, start, weight};
use relcp::Simulation;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// How far a ball sinks in a time of 1 that lies on `count` balls that touch on a floor.
fn sinks(count: u32, between: f64, below: f64) -> f64 {
    let around = 1.0 / (0.5 * TAU / f64::from(count)).sin();
    let base = (0..count).map(|i| TAU * f64::from(i) / f64::from(count));
    let mut bodies: Vec<Value> = base.map(|turn| ball([around * turn.cos(), around * turn.sin(), 1.0])).collect();
    let top = 1.0 + (4.0 - around * around).sqrt();
    bodies.push(ball([0.0, 0.0, top]));
    let friction = json!({"bodies": between, "walls": below});
    let end = run(&inertial(friction, weight(0.0), json!([floor()]), bodies, [0.01, 1.0]));
    top - end.position[count as usize].z
}

#[test]
fn a_ball_rests_on_others_where_friction_suffices() {
    // Between balls the tangent of half of the angle from the vertical, on the floor its part of the load.
    for (count, part) in [(2, 3.0), (3, 4.0)] {
        // The top ball's contacts are inclined by this angle from the vertical.
        let around = 1.0 / (0.5 * TAU / f64::from(count)).sin();
        let between = (0.5 * (0.5 * around).asin()).tan();
        let below = between / part;
        assert!(sinks(count, 1.02 * between, 1.02 * below) < 1e-5);
        assert!(sinks(count, 0.98 * between, 1.02 * below) > 1e-2);
        assert!(sinks(count, 1.02 * between, 0.98 * below) > 1e-2);
    }
}

/// What a solve leaves of a slip, 1e-6, adds up to the elastic slip of 1e-4 within some thousand steps.
#[test]
fn a_pile_of_ten_balls_does_not_collapse_after_thousands_of_steps() {
    let scene = inertial(0.6, weight(0.0), json!([floor()]), pyramid(), [0.01, 100.0]);
    let mut simulation = start(&scene);
    let before = simulation.state().unwrap().bodies.clone();
    run_on(&mut simulation, |_, _| ());
    let after = &simulation.state().unwrap().bodies;
    let moved = before.position.iter().zip(&after.position).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(moved < 5e-5, "{moved:e}");
}

#[test]
fn a_ladder_stands_where_friction_holds_it() {
    let moved = |friction: f64, angle: f64| {
        let (x, z) = (angle.cos() + 0.05, angle.sin() + 0.05);
        let ladder = json!({"shape": {"spherocylinder": {"diameter": 0.1, "length": 2.1}}, "position": [x, 0.0, z],
            "axis": [-angle.cos(), 0.0, angle.sin()]});
        let walls = json!([floor(), {"half_space": {"normal": [1, 0, 0], "offset": 0}}]);
        (run(&inertial(friction, weight(0.0), walls, vec![ladder], [0.01, 1.0])).position[0].x - x).abs()
    };
    // The thin ladder's tan = (1 - mu^2) / 2 mu is 0.98788 and 0.64350; these are of a rod with round ends.
    for (friction, least) in [(0.3, 0.96999), (0.5, 0.61350)] {
        assert!(moved(friction, 1.005 * least) < 1e-5);
        assert!(moved(friction, 0.995 * least) > 1e-2);
    }
}

#[test]
fn a_rod_whose_foot_slides_has_a_solution_in_each_step() {
    // Painleve's rod: beyond a coefficient of 1.41 no bounded force solves the rigid equations at an instant.
    let angle = 55.0_f64.to_radians();
    for friction in [0.5, 1.2, 2.0, 4.0] {
        let rod = json!({"shape": {"spherocylinder": {"diameter": 0.1, "length": 2.1}}, "velocity": [-4, 0, 0],
            "position": [angle.cos(), 0.0, angle.sin() + 0.05], "axis": [angle.cos(), 0.0, angle.sin()]});
        let scene = inertial(friction, weight(0.0), json!([floor()]), vec![rod], [0.001, 0.4]);
        run_on(&mut start(&scene), |_, report| assert!(report.contact_energy <= 0.0, "{report:?}"));
    }
}

/// The mechanical energy of balls of radius 1 and density 1.
fn energy(simulation: &Simulation) -> f64 {
    let bodies = &simulation.state().unwrap().bodies;
    let of = |i: usize| {
        let (v, w) = (bodies.velocity[i], bodies.angular_velocity[i]);
        bodies.shape[i].volume() * (0.5 * v.length_squared() + 0.2 * w.length_squared() + G * bodies.position[i].z)
    };
    (0..bodies.len()).map(of).sum()
}

#[test]
fn balls_that_fall_into_a_box_lose_energy_and_obey_the_law() {
    let walls = json!([{"box": {"minimum": [-4, -4, 0], "maximum": [4, 4, 30]}}]);
    let mut scene = inertial(0.5, weight(0.0), walls, vec![], [0.01, 1.5]);
    scene["generate"] = json!([{"isotropic": {"count": 40, "shape": {"sphere": {"radius": 1.0}}, "volume_fraction": 0.2,
        "center": [0, 0, 6]}}]);
    let mut simulation = start(&scene);
    let (mut before, mut contacts) = (energy(&simulation), 0);
    run_on(&mut simulation, |simulation, report| {
        let now = energy(simulation);
        // Symplectic steps of free fall change it by m g^2 dt^2 / 2 a step.
        let of_stepping = 40.0 * 4.2 * G * G * 1e-4;
        assert!(now <= before + of_stepping, "{now} after {before}");
        before = now;
        for w in &simulation.state().unwrap().warm {
            assert!(w.tangent.length() <= 0.5 * w.gamma * (1.0 + 1e-9), "{w:?}");
        }
        contacts = report.sliding.unwrap() + report.sticking.unwrap();
    });
    assert!(contacts > 30, "{contacts}");
    assert_near(simulation.time(), 1.5, 1e-12);
}
