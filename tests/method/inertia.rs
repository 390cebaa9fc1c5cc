//! Bodies that turn freely keep their angular momentum and their energy, and contact adds none.

use crate::laws::{body, rod, sphere, start};
use crate::random::{Random, parse};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::dynamics::Load;
use relcp::scene::Scene;
use relcp::simulation::Simulation;
use serde_json::{Value, json};

const STEPPINGS: [&str; 2] = ["euler", "midpoint"];

pub fn ellipsoid(radii: [f64; 3]) -> Value {
    json!({"ellipsoid": {"radii": radii}})
}

fn ring() -> Value {
    json!({"torus": {"major_radius": 0.7, "minor_radius": 0.2}})
}

fn spinning(shape: Value, orientation: DQuat, spin: DVec3) -> Value {
    let mut body = body(shape, [0.0; 3], orientation);
    body["angular_velocity"] = json!(spin.to_array());
    body
}

fn free(bodies: Vec<Value>, dt: f64, end: f64, stepping: &str) -> Scene {
    parse(&json!({
        "name": "free", "time": {"dt": dt, "end": end, "stepping": stepping}, "dynamics": {"inertial": {"density": 1.0}},
        "bodies": bodies
    }))
}

/// The angular momentum about a body's centre and its energy of rotation.
fn spin(bodies: &Bodies, i: usize) -> (DVec3, f64) {
    let (q, w) = (bodies.orientation[i], bodies.angular_velocity[i]);
    let in_body = q.inverse() * w;
    let momentum = bodies.shape[i].unit_inertia() * in_body;
    (q * momentum, 0.5 * momentum.dot(in_body))
}

/// The largest changes of a lone body's angular momentum and energy over a run, as parts of what they were.
fn drift(scene: Scene) -> [f64; 2] {
    let mut simulation = start(scene);
    let (momentum, energy) = spin(&simulation.state().unwrap().bodies, 0);
    let mut worst = [0.0f64; 2];
    while !simulation.done() {
        simulation.step().unwrap();
        let (l, e) = spin(&simulation.state().unwrap().bodies, 0);
        worst[0] = worst[0].max((l - momentum).length() / momentum.length());
        worst[1] = worst[1].max((e / energy - 1.0).abs());
    }
    worst
}

/// What is left of roundings after thousands of steps.
const ROUNDINGS: f64 = 1e-11;

/// With the gyroscopic torque at the step's start these gained 27, 5.9 and 850 times their energy by Euler's steps, 5,
/// 0.8 and 4 % by midpoint steps.
#[test]
fn a_free_spin_does_not_gain_energy() {
    let spins = [
        ([0.15, 0.35, 0.6], [0.1, 20.0, 0.1]),
        ([0.35, 0.35, 0.6], [3.0, 15.0, 10.0]),
        ([0.5, 0.5, 0.2], [5.0, 9.0, 14.0]),
    ];
    for (radii, velocity) in spins {
        for stepping in STEPPINGS {
            let body = spinning(ellipsoid(radii), DQuat::IDENTITY, velocity.into());
            let worst = drift(free(vec![body], 0.01, 8.0, stepping));
            println!("{radii:?} {stepping}: momentum and energy off by {worst:?}");
            assert!(worst.iter().all(|off| *off < ROUNDINGS), "{radii:?} {stepping}: {worst:?}");
        }
    }
}

#[test]
fn every_shape_keeps_momentum_and_energy_up_to_a_turn_of_one_a_step() {
    let mut random = Random::new(3);
    for shape in [sphere(0.6), rod(0.3, 2.0), ellipsoid([0.2, 0.5, 1.0]), ellipsoid([1.0, 1.0, 0.01]), ring()] {
        for turn in [0.01, 0.3, 0.99] {
            for stepping in STEPPINGS {
                let dt = 0.01;
                let velocity = turn / dt * random.vector().normalize();
                let body = spinning(shape.clone(), DQuat::from_scaled_axis(random.vector()), velocity);
                let worst = drift(free(vec![body], dt, 10.0, stepping));
                assert!(worst.iter().all(|off| *off < ROUNDINGS), "{shape} {turn} {stepping}: {worst:?}");
            }
        }
    }
}

/// A spin that a step cannot follow: its angular momentum bounds its energy.
#[test]
fn a_spin_of_many_turns_a_step_keeps_its_momentum_and_a_bounded_energy() {
    for stepping in STEPPINGS {
        let body = spinning(ellipsoid([0.15, 0.35, 0.6]), DQuat::IDENTITY, DVec3::new(700.0, 2000.0, 300.0));
        let [momentum, energy] = drift(free(vec![body], 0.01, 5.0, stepping));
        println!("{stepping}: momentum off by {momentum:.1e}, energy by {energy:.1e}");
        assert!(momentum < ROUNDINGS && energy < 4.0, "{momentum:e} {energy:e}");
    }
}

#[test]
fn a_symmetric_top_turns_at_second_order() {
    // R(t) = turn by t L / J_x about L, then in body axes by t (1 / J_z - 1 / J_x) L_z about the axis.
    let (start, velocity) = (DQuat::from_rotation_x(0.4), DVec3::new(0.6, 1.1, -0.9));
    for stepping in STEPPINGS {
        let error = |dt: f64| {
            let scene = free(vec![spinning(ellipsoid([0.5, 0.5, 1.5]), start, velocity)], dt, 4.0, stepping);
            let bodies = scene.build().unwrap();
            let (moments, (momentum, _)) = (bodies.shape[0].unit_inertia(), spin(&bodies, 0));
            let along = (start.inverse() * momentum).z;
            let exact = DQuat::from_scaled_axis(4.0 / moments.x * momentum)
                * start
                * DQuat::from_rotation_z(4.0 * along * (1.0 / moments.z - 1.0 / moments.x));
            let mut simulation = Simulation::builder(scene).bodies(bodies).build().unwrap();
            while !simulation.done() {
                simulation.step().unwrap();
            }
            let q = simulation.state().unwrap().bodies.orientation[0];
            (q - exact).length().min((q + exact).length())
        };
        let errors = [0.08, 0.04, 0.02, 0.01].map(error);
        let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
        println!("{stepping}: errors {errors:?}, orders {orders:.3?}");
        assert!(orders.iter().all(|order| (1.95..2.05).contains(order)), "{stepping}: {errors:?}");
    }
}

#[test]
fn a_torque_adds_its_impulse_to_the_angular_momentum() {
    let torque = DVec3::new(0.3, -0.2, 0.5);
    for stepping in STEPPINGS {
        let scene = free(
            vec![spinning(ellipsoid([0.2, 0.5, 0.9]), DQuat::IDENTITY, DVec3::new(1.0, 2.0, 3.0))],
            0.01,
            5.0,
            stepping,
        );
        let mut simulation = start(scene);
        simulation.add_force(Box::new(move |_: &Bodies, _: usize, _: f64| Load { force: DVec3::ZERO, torque }));
        let (momentum, _) = spin(&simulation.state().unwrap().bodies, 0);
        while !simulation.done() {
            simulation.step().unwrap();
        }
        let (found, _) = spin(&simulation.state().unwrap().bodies, 0);
        let off = (found - momentum - 5.0 * torque).length();
        assert!(off < 1e-12, "{stepping}: {off:e}");
    }
}

/// A top under a torque that turns with time, against many more steps.
#[test]
fn a_torque_in_time_turns_a_body_at_the_order_of_the_step() {
    for (stepping, least) in STEPPINGS.into_iter().zip([0.85, 1.9]) {
        let end = |dt: f64| {
            let top = spinning(ellipsoid([0.5, 0.8, 1.2]), DQuat::from_rotation_y(0.3), DVec3::new(0.5, 1.0, 0.2));
            let mut simulation = start(free(vec![top], dt, 2.0, stepping));
            simulation.add_force(Box::new(|bodies: &Bodies, i: usize, time: f64| Load {
                force: DVec3::ZERO,
                torque: 3.0 * DVec3::new((2.0 * time).sin(), 0.5, (3.0 * time).cos())
                    - 0.4 * bodies.angular_velocity[i],
            }));
            while !simulation.done() {
                simulation.step().unwrap();
            }
            simulation.state().unwrap().bodies.orientation[0]
        };
        let fine = end(0.04 / 256.0);
        let errors = [0.04, 0.02, 0.01].map(|dt| (end(dt) - fine).length());
        let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
        println!("{stepping}: errors {errors:?}, orders {orders:.3?}");
        assert!(orders.iter().all(|order| *order > least), "{stepping}: {errors:?}");
    }
}

#[test]
fn a_run_that_goes_on_from_its_state_has_the_same_bits() {
    for stepping in STEPPINGS {
        let bodies = vec![
            spinning(ellipsoid([0.2, 0.5, 0.9]), DQuat::from_rotation_x(0.3), DVec3::new(1.0, 9.0, 3.0)),
            body(rod(0.4, 1.5), [0.9, 0.1, 0.2], DQuat::from_rotation_y(0.8)),
        ];
        let scene = free(bodies, 0.01, 1.0, stepping);
        let mut whole = start(scene.clone());
        for _ in 0..40 {
            whole.step().unwrap();
        }
        let mut resumed = Simulation::builder(scene).resume(whole.state().unwrap().clone()).build().unwrap();
        for _ in 0..40 {
            whole.step().unwrap();
            resumed.step().unwrap();
        }
        assert_eq!(whole.state().unwrap(), resumed.state().unwrap());
    }
}
