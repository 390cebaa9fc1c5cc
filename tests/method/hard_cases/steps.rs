//! Large and tiny steps: bodies keep their order and do not pass through each other.

use super::{TOLERANCE, audited, ellipsoid, figures, going_on, pushed, resolves, scene};
use crate::laws::{body, rod, sphere, start};
use crate::random::{Random, heap};
use glam::DQuat;
use relcp::bodies::Bodies;
use relcp::internals::dynamics::{Pose, Twist, advance};
use relcp::step::contacts;
use serde_json::Value;

/// The deepest overlap on the way of one accepted step, over 200 poses between its ends.
fn deepest_on_the_way(before: &Bodies, after: &Bodies, dt: f64) -> f64 {
    let between = |part: f64| {
        let mut bodies = after.clone();
        for i in 0..bodies.len() {
            let from = Pose { position: before.position[i], orientation: before.orientation[i] };
            let twist = Twist { linear: after.velocity[i], angular: after.angular_velocity[i] };
            let pose = advance(from, twist, part * dt);
            (bodies.position[i], bodies.orientation[i]) = (pose.position, pose.orientation);
        }
        contacts(&bodies, 0.0).iter().map(|contact| -contact.separation).fold(0.0, f64::max)
    };
    (1..200).map(|k| between(f64::from(k) / 200.0)).fold(0.0, f64::max)
}

/// Of 100 random pairs thrown at each other, each by `jump` of its length a step, how many pass through each other:
/// overlap on the way by more than a fifth of their thickness.
fn passings(shape: &Value, length: f64, jump: f64) -> usize {
    let mut random = Random::new(81);
    let mut passed = 0;
    for _ in 0..100 {
        // The paths cross in the middle of the step.
        let way = random.direction();
        let aside = 0.3 * length * random.vector();
        let half = way * (0.5 * jump + 0.55) * length;
        let mut bodies = [
            body(shape.clone(), (-half).to_array(), random.orientation()),
            body(shape.clone(), (half + aside).to_array(), random.orientation()),
        ];
        let push = way * (jump * length * length);
        let forces = pushed(&mut bodies, &[push.to_array(), (-push).to_array()]);
        let mut simulation = start(going_on(1.0, &bodies, forces));
        for _ in 0..2 {
            let before = simulation.state().unwrap().bodies.clone();
            audited(&mut simulation, 1);
            if deepest_on_the_way(&before, &simulation.state().unwrap().bodies, 1.0) > 0.2 * before.shape[0].thickness()
            {
                passed += 1;
                break;
            }
        }
    }
    passed
}

/// A step looks at its two ends only. Rows from the swept reach part two spheres at any speed; where bodies turn, a row
/// takes the turn for straight motion, so that a large one may end free of overlap on the other side.
#[test]
fn bodies_do_not_pass_through_each_other_in_a_step_of_a_quarter_of_their_length() {
    for (name, shape, length) in
        [("spheres", sphere(0.5), 1.0), ("rods", rod(0.5, 2.0), 2.0), ("ellipsoids", ellipsoid([0.3, 0.5, 1.0]), 2.0)]
    {
        let found = [0.1, 0.25, 0.5, 1.0, 3.0, 10.0, 1e3].map(|jump| (jump, passings(&shape, length, jump)));
        println!("{name}: (lengths a step, of 100 passed) {found:?}");
        for (jump, passed) in found {
            let sure = name == "spheres" || jump <= 0.25;
            assert!(!sure || passed == 0, "{name} at {jump} lengths a step: {passed} of 100 passed");
        }
    }
}

#[test]
fn a_large_step_of_a_heap_stays_within_tolerance() {
    for dt in [1.0, 10.0] {
        for (seed, kinds) in [(21, ["sphere"].as_slice()), (22, &["spherocylinder", "ellipsoid"])] {
            let mut simulation = start(heap(seed, kinds, 24, dt));
            let reports = audited(&mut simulation, 5);
            let (worst, unconverged) = figures(&format!("{kinds:?} dt {dt}"), &reports);
            for report in &reports {
                let says = !report.within(TOLERANCE) || report.unconverged > 0;
                assert!(report.max_overlap <= TOLERANCE || says);
                assert!(report.max_overlap <= TOLERANCE || report.recursions == 64, "gave up early: {report:?}");
            }
            assert!(dt > 1.0 || (worst <= TOLERANCE && unconverged == 0));
        }
    }
}

#[test]
fn a_tiny_step_resolves() {
    for kinds in [["sphere"], ["spherocylinder"], ["ellipsoid"]] {
        let mut simulation = start(heap(31, &kinds, 24, 1e-9));
        resolves(&format!("{kinds:?} dt 1e-9"), &mut simulation, 5);
    }
}

#[test]
fn a_chain_pushed_by_a_fast_body_keeps_its_order() {
    // The second body has no motion of its own: only contact brings it near the third, within the same step.
    for speed in [5.0, 20.0, 100.0] {
        let mut bodies: Vec<Value> =
            [-3.0, 0.0, 3.0].iter().map(|x| body(sphere(0.5), [*x, 0.0, 0.0], DQuat::IDENTITY)).collect();
        let forces = pushed(&mut bodies, &[[speed, 0.0, 0.0]]);
        let mut simulation = start(scene(1.0, &bodies, forces));
        resolves(&format!("chain at {speed}"), &mut simulation, 1);
        let x: Vec<f64> = simulation.state().unwrap().bodies.position.iter().map(|x| x.x).collect();
        println!("{x:?}");
        assert!(x[0] < x[1] && x[1] < x[2], "a body passed through another: {x:?}");
    }
}

#[test]
fn a_body_squeezed_out_fast_does_not_pass_through_a_third() {
    // Two fast bodies pinch a small one, which leaves between them faster than either comes, towards a wall of spheres.
    for speed in [1.0, 2.0, 5.0, 10.0] {
        let mut bodies = vec![
            body(sphere(1.0), [-2.0, 0.0, 0.0], DQuat::IDENTITY),
            body(sphere(1.0), [2.0, 0.0, 0.0], DQuat::IDENTITY),
            body(sphere(0.3), [0.0, 0.5, 0.0], DQuat::IDENTITY),
            body(sphere(20.0), [0.0, 24.0, 0.0], DQuat::IDENTITY),
        ];
        let forces = pushed(&mut bodies, &[[2.0 * speed, 0.0, 0.0], [-2.0 * speed, 0.0, 0.0]]);
        let mut simulation = start(scene(1.0, &bodies, forces));
        let report = audited(&mut simulation, 1);
        figures(&format!("squeezed at {speed}"), &report);
        let x = &simulation.state().unwrap().bodies.position;
        println!("{} {}", x[2], x[3]);
        assert!(x[2].y < x[3].y, "passed through: {x:?}");
    }
}
