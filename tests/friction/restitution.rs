//! Restitution: bounces against their series, impacts with friction, and balances.

use crate::scenes::{assert_near, ball, floor, inertial, parse, run, run_on, start, weight, with};
use glam::DVec3;
use relcp::scene::Scene;
use serde_json::{Value, json};

fn bouncing(restitution: impl Into<Value>, friction: f64, body: Value, time: [f64; 2]) -> Value {
    let mut scene = inertial(friction, weight(0.0), json!([floor()]), vec![body], time);
    scene["contact"]["restitution"] = restitution.into();
    scene
}

#[test]
fn a_dropped_ball_reaches_the_square_of_the_coefficient_of_its_height() {
    for restitution in [0.5, 0.9] {
        let mut simulation = start(&bouncing(restitution, 0.0, ball([0.0, 0.0, 2.0]), [1e-3, 2.0]));
        let (mut peaks, mut before) = (Vec::new(), [2.0, 2.0]);
        run_on(&mut simulation, |simulation, _| {
            let z = simulation.state().unwrap().bodies.position[0].z;
            if before[1] > before[0] && before[1] > z && before[1] > 1.001 {
                peaks.push(before[1] - 1.0);
            }
            before = [before[1], z];
        });
        for (peak, bounce) in peaks.iter().zip(1..) {
            // A step of 1e-3 ends up to 4e-3 from the floor, and the ball turns back there.
            assert_near(*peak, restitution_of(restitution, bounce), 5e-3);
        }
        assert!(peaks.len() >= 2, "{peaks:?}");
    }
}

fn restitution_of(restitution: f64, bounce: i32) -> f64 {
    restitution.powi(2 * bounce)
}

#[test]
fn a_ball_that_hits_a_rough_floor_askew_leaves_with_what_the_impact_allows() {
    let hits = |friction: f64| {
        let thrown = with(ball([0.0, 0.0, 1.0005]), "velocity", json!([3, 0, -2]));
        let bodies = run(&bouncing(0.8, friction, thrown, [1e-3, 2e-3]));
        bodies.velocity[0]
    };
    // The normal impulse is (1 + rho) |v|, and a step of gravity acts before it.
    let slides = hits(0.1);
    assert_near(slides.x, 3.0 - 0.1 * 1.8 * 2.0, 3e-3);
    assert_near(slides.z, 1.6, 2e-2);
    assert_near(hits(0.5).x, 15.0 / 7.0, 1e-3);
}

#[test]
fn a_resting_ball_stays_and_a_number_stands_for_bodies_and_walls() {
    let mut simulation = start(&bouncing(0.9, 0.0, ball([0.0, 0.0, 1.0]), [0.01, 2.0]));
    run_on(&mut simulation, |_, report| assert!(report.contact_energy <= 1e-9, "{report:?}"));
    assert_near(simulation.state().unwrap().bodies.position[0].z, 1.0, 1e-6);
    let at_walls = bouncing(json!({"walls": 0.9}), 0.0, ball([0.0, 0.0, 1.0]), [0.01, 2.0]);
    assert_eq!(parse(&at_walls).contact.restitution.bodies, 0.0);
}

/// Balls in a row, not touching, of which the first comes with speed 1.
#[test]
fn the_last_ball_of_a_row_leaves_with_the_speed_of_the_first() {
    let row: Vec<Value> = (0..5)
        .map(|i| {
            let speed = if i == 0 { 1.0 } else { 0.0 };
            with(ball([2.02 * f64::from(i), 0.0, 0.0]), "velocity", json!([speed, 0.0, 0.0]))
        })
        .collect();
    let mut scene = inertial(0.0, json!([]), json!([]), row, [0.01, 1.0]);
    scene["contact"]["restitution"] = json!(1.0);
    let speeds: Vec<f64> = run(&scene).velocity.iter().map(|v| v.x).collect();
    for (speed, expected) in speeds.iter().zip([0.0, 0.0, 0.0, 0.0, 1.0]) {
        assert_near(*speed, expected, 1e-4);
    }
}

#[test]
fn a_gas_of_elastic_balls_keeps_its_energy_and_its_momentum_and_another_loses_it() {
    let gas = |restitution: f64, friction: f64| {
        let mut scene = inertial(friction, json!([]), json!([]), vec![], [0.005, 3.0]);
        scene["generate"] = json!([{"isotropic": {"count": 60, "shape": {"sphere": {"radius": 0.5}}}}]);
        scene["periodic"] = json!({"lengths": [7.0, 7.0, 7.0]});
        scene["contact"]["restitution"] = json!(restitution);
        let mut scene: Scene = parse(&scene);
        let built = scene.build().unwrap();
        let bodies = (0..built.len()).map(|i| {
            let mut body = relcp::scene::Body::new(built.shape[i], built.position[i].to_array());
            let s = i as f64;
            body.velocity = Some([(1.7 * s).sin(), (2.3 * s + 1.0).sin(), (3.1 * s + 2.0).sin()]);
            body
        });
        (scene.bodies, scene.generate) = (bodies.collect(), Vec::new());
        let mut simulation = relcp::Simulation::new(scene).unwrap();
        let energies = |simulation: &relcp::Simulation| {
            let bodies = &simulation.state().unwrap().bodies;
            let linear: f64 = bodies.velocity.iter().map(|v| v.length_squared()).sum();
            let angular: f64 = bodies.angular_velocity.iter().map(|w| 0.1 * w.length_squared()).sum();
            (linear + angular, bodies.velocity.iter().sum::<DVec3>())
        };
        let before = energies(&simulation);
        let mut dropped = 0;
        run_on(&mut simulation, |_, report| {
            dropped += report.restitution_dropped;
            assert!(report.contact_energy <= 1e-3, "{report:?}");
        });
        let after = energies(&simulation);
        assert!(after.1.abs_diff_eq(before.1, 1e-10), "{after:?} {before:?}");
        println!(
            "restitution {restitution}, friction {friction}: {} of the energy, dropped {dropped}",
            after.0 / before.0
        );
        after.0 / before.0
    };
    let elastic = gas(1.0, 0.0);
    assert!(elastic > 0.97 && elastic <= 1.0 + 1e-9, "{elastic}");
    let damped = gas(0.8, 0.0);
    assert!((0.2..0.8).contains(&damped), "{damped}");
    assert!(gas(0.8, 0.5) < damped);
}

#[test]
fn an_elastic_ball_bounces_off_a_ceiling_against_gravity_and_drag() {
    let ceiling = json!([{"half_space": {"normal": [0, 0, -1], "offset": -2}}]);
    for (restitution, drag) in [(1.0, 0.0), (1.0, 5.0), (0.9, 5.0)] {
        let thrown = with(ball([0.0, 0.0, 0.0]), "velocity", json!([0, 0, 8]));
        let mut scene = inertial(0.0, weight(0.0), ceiling.clone(), vec![thrown], [1e-3, 0.2]);
        scene["contact"]["restitution"] = json!(restitution);
        if drag > 0.0 {
            scene["dynamics"]["inertial"]["drag"] = json!(drag);
        }
        let mut simulation = start(&scene);
        let mut last = 8.0;
        let mut bounced = None;
        run_on(&mut simulation, |simulation, report| {
            assert_eq!(report.restitution_dropped, 0);
            let speed = simulation.state().unwrap().bodies.velocity[0].z;
            bounced = bounced.or_else(|| (speed < 0.0).then_some(-speed / last));
            last = speed;
        });
        // A step takes some thousandths of the speed.
        assert_near(bounced.unwrap(), restitution, 1e-2);
    }
}

#[test]
fn elastic_balls_with_heat_keep_their_temperature() {
    let mut scene = inertial(0.0, json!([]), json!([]), vec![], [0.005, 30.0]);
    scene["dynamics"]["inertial"] = json!({"density": 1.909_859_317_102_744, "drag": 2.0});
    scene["thermal"] = json!({"temperature": 1.0});
    scene["generate"] = json!([{"isotropic": {"count": 50, "shape": {"sphere": {"radius": 0.5}}}}]);
    scene["periodic"] = json!({"lengths": [5.0, 5.0, 5.0]});
    scene["contact"] = json!({"restitution": 1.0});
    let mut simulation = start(&scene);
    let (mut energies, mut dropped, mut step) = (Vec::new(), 0, 0);
    run_on(&mut simulation, |simulation, report| {
        dropped += report.restitution_dropped;
        step += 1;
        if step > 600 {
            let bodies = &simulation.state().unwrap().bodies;
            energies.push(bodies.velocity.iter().map(|v| v.length_squared()).sum::<f64>() / 150.0);
        }
    });
    let blocks: Vec<f64> = energies.chunks(540).map(|block| block.iter().sum::<f64>() / block.len() as f64).collect();
    let count = blocks.len() as f64;
    let mean = blocks.iter().sum::<f64>() / count;
    let error = (blocks.iter().map(|block| (block - mean).powi(2)).sum::<f64>() / (count * (count - 1.0))).sqrt();
    println!("temperature {mean} of 1, standard error {error}, restitution dropped in {dropped} of {step} steps");
    assert!((mean - 1.0).abs() < 3.0 * error + 0.01, "{mean} {error}");
}
