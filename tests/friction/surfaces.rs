//! What moves surfaces beside bodies: walls, images in a sheared cell, growth.

use crate::scenes::{G, assert_near, ball, floor, inertial, rod, run, run_on, start, weight, with};
use glam::{DQuat, DVec3, EulerRot};
use serde_json::json;

#[test]
fn a_conveyor_takes_a_rod_along_until_it_has_its_speed() {
    let belt = json!([{"half_space": {"normal": [0, 0, 1], "offset": 0, "motion": {"velocity": [2, 0, 0]}}}]);
    let speed = |end: f64| run(&inertial(0.25, weight(0.0), belt.clone(), vec![rod(0.5)], [0.01, end])).velocity[0].x;
    assert_near(speed(0.5), 0.25 * G * 0.5, 1e-9);
    assert_near(speed(2.0), 2.0, 1e-9);
}

#[test]
fn a_block_on_a_spring_sticks_to_a_belt_and_slips() {
    // From where the spring's pull is the limit it swings about that place, from the belt's speed and back to it.
    let (speed, stiffness, friction) = (0.5, 20.0_f64, 0.4);
    let belt = json!([{"half_space": {"normal": [0, 0, 1], "offset": 0, "motion": {"velocity": [speed, 0, 0]}}}]);
    let spring = json!({"trap": {"center": [0, 0, 0], "stiffness": stiffness, "axes": [true, false, false]}});
    let pull = json!({"gravity": {"acceleration": [0, 0, -G]}});
    let mut scene = inertial(friction, json!([pull, spring]), belt, vec![rod(0.5)], [1e-3, 6.0]);
    // A mass of 1.
    let volume = std::f64::consts::PI * (0.25 * 3.0 + 1.0 / 6.0);
    scene["dynamics"]["inertial"]["density"] = json!(1.0 / volume);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    run_on(&mut start(&scene), |simulation, _| {
        if simulation.time() > 3.0 {
            let x = simulation.state().unwrap().bodies.position[0].x;
            (least, most) = (least.min(x), most.max(x));
        }
    });
    assert_near(most, friction * G / stiffness + speed / stiffness.sqrt(), 1e-3);
    assert_near(0.5 * (most - least), speed / stiffness.sqrt(), 1e-3);
}

#[test]
fn a_turned_ball_turns_another_that_it_is_pressed_to() {
    // Mobilities 1/2 and 3/2: both surfaces have one velocity, by a friction force of 0.15.
    let of = |x: f64, group: &str| with(ball([x, 0.0, 0.0]), "group", json!(group));
    let press = |force: f64, group: &str| json!({"uniform": {"force": [force, 0.0, 0.0], "group": group}});
    let bodies = run(&json!({"name": "gears", "time": {"dt": 0.01, "end": 0.01},
        "dynamics": {"overdamped": {"drag": 1.0}}, "contact": {"friction": 1.0},
        "bodies": [of(-1.0, "left"), of(1.0, "right")],
        "forces": [press(1.0, "left"), press(-1.0, "right"),
            {"torque": {"torque": [0.0, 0.0, 0.4], "group": "left"}}]}));
    for (found, expected) in [
        (bodies.angular_velocity[0].z, 0.375),
        (bodies.angular_velocity[1].z, -0.225),
        (bodies.velocity[0].y, -0.075),
        (bodies.velocity[1].y, 0.075),
    ] {
        assert_near(found, expected, 1e-4);
    }
}

#[test]
fn a_turned_scene_moves_as_it_did() {
    let fall = |turn: DQuat| {
        let orientation = turn * DQuat::from_rotation_x(0.4);
        let ellipsoid = json!({"shape": {"ellipsoid": {"radii": [0.5, 0.7, 1.2]}},
            "position": (turn * DVec3::new(0.0, 0.0, 1.3)).to_array(),
            "orientation": [orientation.w, orientation.x, orientation.y, orientation.z],
            "velocity": (turn * DVec3::new(1.0, 0.5, 0.0)).to_array()});
        let floor = json!([{"half_space": {"normal": (turn * DVec3::Z).to_array(), "offset": 0}}]);
        let pull = json!([{"gravity": {"acceleration": (turn * DVec3::new(0.0, 0.0, -G)).to_array()}}]);
        let bodies = run(&inertial(0.4, pull, floor, vec![ellipsoid], [0.01, 1.0]));
        [bodies.velocity[0], bodies.angular_velocity[0]].map(|v| turn.inverse() * v)
    };
    let plain = fall(DQuat::IDENTITY);
    assert!(plain[1].length() > 0.1, "{plain:?}");
    for turn in [DQuat::from_rotation_x(1.0), DQuat::from_euler(EulerRot::XYZ, 0.3, -2.0, 1.1)] {
        let turned = fall(turn);
        for (a, b) in plain.iter().zip(&turned) {
            assert!(a.abs_diff_eq(*b, 1e-5), "{plain:?} {turned:?}");
        }
    }
}

#[test]
fn a_turning_floor_takes_a_ball_around() {
    // A ball on a turntable goes around a circle with 2/7 of the table's angular velocity, about the middle where it
    // starts to roll with v = 2/7 (w x r) there.
    let spin = 0.7;
    let table = json!([{"half_space": {"normal": [0, 0, 1], "offset": 0,
        "motion": {"velocity": [0, 0, 0], "angular_velocity": [0, 0, spin]}}}]);
    let speed = 2.0 / 7.0 * spin * 3.0;
    // Rolling there: v + w x (-z) is the table's velocity, (0, spin 3, 0).
    let start = with(
        with(ball([3.0, 0.0, 1.0]), "velocity", json!([0.0, speed, 0.0])),
        "angular_velocity",
        json!([spin * 3.0 - speed, 0.0, 0.0]),
    );
    let bodies = run(&inertial(0.5, weight(0.0), table, vec![start], [0.001, 2.0]));
    let at = bodies.position[0];
    assert_near(at.truncate().length(), 3.0, 2e-3);
    assert_near(at.y.atan2(at.x), 2.0 / 7.0 * spin * 2.0, 2e-3);
}

#[test]
fn free_bodies_keep_both_momenta_and_gain_no_energy() {
    let spheres: Vec<_> = (0..27)
        .map(|i| {
            let at = [i % 3, i / 3 % 3, i / 9].map(|k| 2.05 * f64::from(k - 1));
            let twist = |s: f64| json!([(s * at[1]).sin(), (s * at[2] + 1.0).sin(), (s * at[0] + 2.0).sin()]);
            let to_centre = DVec3::from(at) * -0.6;
            let velocity = to_centre + 0.3 * DVec3::new((3.0 * at[1]).sin(), (5.0 * at[2]).cos(), (7.0 * at[0]).sin());
            with(with(ball(at), "velocity", json!(velocity.to_array())), "angular_velocity", twist(2.0))
        })
        .collect();
    let mut simulation = start(&inertial(0.6, json!([]), json!([]), spheres, [0.01, 1.5]));
    let momenta = |simulation: &relcp::Simulation| {
        let bodies = &simulation.state().unwrap().bodies;
        let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..bodies.len() {
            let mass = bodies.shape[i].volume();
            linear += mass * bodies.velocity[i];
            angular += mass * (bodies.position[i].cross(bodies.velocity[i]) + 0.4 * bodies.angular_velocity[i]);
        }
        (linear, angular)
    };
    let before = momenta(&simulation);
    let mut touched = 0;
    run_on(&mut simulation, |_, report| {
        touched += report.sliding.unwrap() + report.sticking.unwrap();
        assert!(report.contact_energy <= 1e-3, "{report:?}");
    });
    assert!(touched > 50, "{touched}");
    let after = momenta(&simulation);
    assert!(after.0.abs_diff_eq(before.0, 1e-11) && after.1.abs_diff_eq(before.1, 1e-10), "{before:?} {after:?}");
}

#[test]
fn a_rod_that_grows_on_a_rough_floor_stays_where_its_middle_is() {
    let cell = json!({"shape": {"spherocylinder": {"diameter": 1.0, "length": 2.0}}, "position": [0, 0, 0.5],
        "axis": [1, 0, 0]});
    let bodies = run(&json!({"name": "grows", "time": {"dt": 0.01, "end": 0.5}, "walls": [floor()],
        "dynamics": {"overdamped": {"drag": 1.0}}, "contact": {"friction": 0.5},
        "forces": [{"uniform": {"force": [0, 0, -1]}}], "bodies": [cell],
        "growth": {"rate": 1.0, "division_length": 40.0}}));
    assert!(bodies.shape[0].major_axis() > 3.0);
    assert!(bodies.position[0].truncate().length() < 1e-7, "{}", bodies.position[0]);
}

#[test]
fn the_image_of_a_rod_in_a_sheared_cell_drags_another_along() {
    // The two lie along each other and are pressed together across the border of the cell, where images go by at 4.5.
    let lying = |y: f64, group: &str| with(with(rod(0.0), "position", json!([0.0, y, 0.0])), "group", json!(group));
    let press = |force: f64, group: &str| json!({"uniform": {"force": [0.0, force, 0.0], "group": group}});
    let bodies = run(&json!({"name": "sheared", "planar": true, "time": {"dt": 0.001, "end": 0.01},
        "dynamics": {"inertial": {"density": 1.0}}, "contact": {"friction": 0.5},
        "periodic": {"lengths": [12.0, 9.0, null], "shear": {"direction": "x", "gradient": "y", "rate": 0.5}},
        "bodies": [lying(-3.0, "lower"), lying(5.0, "upper")],
        "forces": [press(-3.0, "lower"), press(3.0, "upper")]}));
    // Friction turns both to the same side, and what goes by along a tilted rod presses less.
    let expected = 0.5 * 3.0 * 0.01 / bodies.shape[0].volume();
    assert_near(bodies.velocity[1].x, expected, 1e-2 * expected);
    assert_near(bodies.velocity[0].x, -bodies.velocity[1].x, 1e-12);
}
