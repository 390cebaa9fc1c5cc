//! One body on a floor: sliding, sticking and rolling.

use crate::scenes::{G, assert_near, ball, floor, inertial, rod, run, weight, with};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// The velocity along x and the height after a time of 1 of a rod that starts at rest on an incline.
fn on_incline(angle: f64, friction: f64) -> [f64; 2] {
    let bodies = run(&inertial(friction, weight(angle), json!([floor()]), vec![rod(0.5)], [0.01, 1.0]));
    [bodies.velocity[0].x, bodies.position[0].z]
}

#[test]
fn a_rod_on_an_incline_slides_where_it_is_steep_and_stays_on_it() {
    let limit = 0.5_f64.atan();
    for (angle, friction) in [(0.4, 0.3), (0.4, 0.5), (limit - 1e-3, 0.5), (limit + 1e-3, 0.5)] {
        let [speed, height] = on_incline(angle, friction);
        assert_near(speed, (G * (angle.sin() - friction * angle.cos())).max(0.0), 1e-9);
        assert_near(height, 0.5, 1e-9);
    }
}

fn rolling(incline: f64, friction: f64, ball: Value, end: f64) -> relcp::bodies::Bodies {
    run(&inertial(friction, weight(incline), json!([floor()]), vec![ball], [0.01, end]))
}

#[test]
fn a_thrown_ball_slides_then_rolls() {
    let thrown = || with(ball([0.0, 0.0, 1.0]), "velocity", json!([5, 0, 0]));
    assert_near(rolling(0.0, 0.3, thrown(), 0.2).velocity[0].x, 5.0 - 0.3 * G * 0.2, 1e-9);
    let bodies = rolling(0.0, 0.3, thrown(), 1.0);
    assert_near(bodies.velocity[0].x, 25.0 / 7.0, 1e-8);
    assert_near(bodies.angular_velocity[0].y, 25.0 / 7.0, 1e-8);
    // The convex relaxation of the law lifts it by 0.07.
    assert_near(bodies.position[0].z, 1.0, 1e-9);
}

#[test]
fn a_ball_on_an_incline_rolls_or_slips() {
    let angle = 0.5_f64;
    // Stick gives by the elastic slip, 100 solver tolerances.
    assert_near(rolling(angle, 0.3, ball([0.0, 0.0, 1.0]), 1.0).velocity[0].x, 5.0 / 7.0 * G * angle.sin(), 1e-6);
    let slips = rolling(angle, 0.1, ball([0.0, 0.0, 1.0]), 1.0);
    assert_near(slips.velocity[0].x, G * (angle.sin() - 0.1 * angle.cos()), 1e-9);
    assert_near(slips.angular_velocity[0].y, 2.5 * 0.1 * G * angle.cos(), 1e-9);
}

#[test]
fn a_billiard_ball_with_side_spin_ends_where_theory_says() {
    let spun = with(with(ball([0.0, 0.0, 1.0]), "velocity", json!([4, 0, 0])), "angular_velocity", json!([-5, -3, 2]));
    let bodies = rolling(0.0, 0.2, spun, 2.0);
    // v - 2/7 (v + w x (-z)), while the spin about the normal stays.
    for (found, expected) in bodies.velocity[0].to_array().into_iter().zip([2.0, 10.0 / 7.0, 0.0]) {
        assert_near(found, expected, 1e-8);
    }
    assert_near(bodies.angular_velocity[0].z, 2.0, 1e-12);
}

#[test]
fn friction_has_no_preferred_direction() {
    for k in 0..19 {
        let angle = TAU * f64::from(k) / 19.0;
        let thrown = with(ball([0.0, 0.0, 1.0]), "velocity", json!([3.0 * angle.cos(), 3.0 * angle.sin(), 0.0]));
        let at = run(&inertial(0.4, weight(0.0), json!([floor()]), vec![thrown], [0.005, 0.1])).position[0];
        assert_near(at.y.atan2(at.x).rem_euclid(TAU), angle, 1e-9);
        // Sums of velocities after each step: v t - mu g (t^2 + t dt) / 2.
        assert_near(at.truncate().length(), 0.3 - 0.4 * G * 0.5 * (0.01 + 0.1 * 0.005), 1e-9);
    }
}

#[test]
fn without_inertia_friction_slows_what_is_pressed() {
    let moved = |body: Value, along: f64, against: f64, friction: f64| {
        let bodies = run(&json!({"name": "pressed", "time": {"dt": 0.01, "end": 1.0}, "walls": [floor()],
            "dynamics": {"overdamped": {"drag": 1.0}}, "contact": {"friction": friction},
            "forces": [{"uniform": {"force": [along, 0.0, -against]}}], "bodies": [body]}));
        let q = bodies.orientation[0];
        [bodies.position[0].x, 2.0 * q.y.atan2(q.w)]
    };
    // A rod of length 4 has the mobility 1/4 and slides.
    assert_near(moved(rod(0.5), 1.0, 1.0, 0.3)[0], 0.7 / 4.0, 1e-9);
    assert_near(moved(rod(0.5), 1.0, 1.0, 2.0)[0], 0.0, 1e-9);
    // A ball has the mobilities 1/2 and 3/2: it rolls with F m_t m_r R^2 / (m_t + m_r R^2), or slides.
    let rolls = moved(ball([0.0, 0.0, 1.0]), 1.0, 1.0, 0.3);
    assert_near(rolls[0], 0.375, 1e-6);
    assert_near(rolls[1], 0.375, 1e-6);
    let slides = moved(ball([0.0, 0.0, 1.0]), 1.0, 0.2, 0.3);
    assert_near(slides[0], 0.47, 1e-7);
    assert_near(slides[1], 0.09, 1e-7);
}
