//! Drag beside inertia.

use crate::forces::everything;
use crate::scenes::{ALONG_X, agrees_on_device, apart, parse, refusal, run};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::simulation::Compute;
use serde_json::{Value, json};

const DRAG: f64 = 3.0;
const DENSITY: f64 = 2.0;

fn shapes() -> [Value; 3] {
    [
        json!({"sphere": {"radius": 0.5}}),
        json!({"spherocylinder": {"diameter": 0.5, "length": 2}}),
        json!({"ellipsoid": {"radii": [0.3, 0.5, 1]}}),
    ]
}

fn ended(dt: f64, stepping: &str, body: &Value, forces: &Value) -> Bodies {
    let of = json!({"name": "slowed", "time": {"dt": dt, "end": 2, "stepping": stepping}, "bodies": [body],
        "dynamics": {"inertial": {"density": DENSITY, "drag": DRAG}}, "forces": forces});
    run(parse(&of), &Compute::Cpu).bodies
}

fn moving(shape: &Value, velocity: [f64; 3], spin: [f64; 3]) -> Value {
    let q = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.7);
    json!({"shape": shape, "position": [0, 0, 0], "orientation": [q.w, q.x, q.y, q.z], "velocity": velocity, "angular_velocity": spin})
}

/// `xi L / m`, and `xi L^3 / 12 I` about each principal axis.
fn rates(bodies: &Bodies) -> (f64, DVec3) {
    let (shape, length) = (bodies.shape[0], bodies.shape[0].major_axis());
    (DRAG * length / (DENSITY * shape.volume()), DRAG * length.powi(3) / 12.0 / (DENSITY * shape.unit_inertia()))
}

#[test]
fn a_velocity_relaxes_exactly_for_every_step_size() {
    let (velocity, force) = (DVec3::new(3.0, -1.0, 2.0), DVec3::new(0.5, 4.0, -1.0));
    for shape in shapes() {
        for stepping in ["euler", "midpoint"] {
            for dt in [2.0, 0.5, 0.01] {
                let body = moving(&shape, velocity.to_array(), [0.0; 3]);
                let bodies = ended(dt, stepping, &body, &json!([{"uniform": {"force": force.to_array()}}]));
                let rate = rates(&bodies).0;
                let steady = force / (DRAG * bodies.shape[0].major_axis());
                let expected = steady + (velocity - steady) * (-2.0 * rate).exp();
                let off = (bodies.velocity[0] - expected).length();
                assert!(off < 1e-13, "{shape} {stepping} {dt}: {off:e}");
            }
        }
    }
}

#[test]
fn a_turn_about_a_principal_axis_relaxes_exactly_for_every_step_size() {
    for shape in shapes() {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for (stepping, dt) in [("euler", 2.0), ("euler", 0.1), ("midpoint", 1.0), ("midpoint", 0.1)] {
                let mut body = moving(&shape, [0.0; 3], (0.3 * axis).to_array());
                body["orientation"] = json!([1, 0, 0, 0]);
                let bodies = ended(dt, stepping, &body, &json!([]));
                let expected = 0.3 * axis * (-2.0 * rates(&bodies).1.dot(axis)).exp();
                let off = (bodies.angular_velocity[0] - expected).length();
                assert!(off < 1e-13, "{shape} {axis} {stepping} {dt}: {off:e}");
            }
        }
    }
}

#[test]
fn places_and_tumbling_come_at_the_order_of_the_scheme() {
    let shape = &shapes()[2];
    for (stepping, order) in [("euler", 1), ("midpoint", 2)] {
        let body = moving(shape, [1.0, 2.0, -0.5], [2.0, -1.0, 3.0]);
        let end = |steps: f64| {
            ended(2.0 / steps, stepping, &body, &json!([{"torque": {"torque": [0.1, 0.2, 0], "frame": "body"}}]))
        };
        let [coarse, fine, finest] = [64.0, 128.0, 4096.0].map(end);
        let rate = rates(&coarse).0;
        let expected = DVec3::new(1.0, 2.0, -0.5) * (1.0 - (-2.0 * rate).exp()) / rate;
        let places = [&coarse, &fine].map(|bodies| bodies.position[0].distance(expected));
        let turns = [&coarse, &fine].map(|bodies| bodies.angular_velocity[0].distance(finest.angular_velocity[0]));
        for (what, [coarse, fine]) in [("places", places), ("turns", turns)] {
            let ratio = coarse / fine / f64::from(1 << order);
            println!("{stepping}, {what}: {coarse:.2e}, {fine:.2e} with half the step, ratio {:.3}", coarse / fine);
            assert!((ratio - 1.0).abs() < 0.1, "{stepping}: {coarse:e} {fine:e}");
        }
    }
}

/// Bodies that are light against their drag move as the overdamped law says, with contacts.
#[test]
fn light_bodies_move_as_overdamped_ones() {
    for planar in [false, true] {
        let of = |law: &Value| {
            let mut of = everything(planar, law, "euler", false);
            // Else the rows of overdamped steps in the plane are made elsewhere, and overlaps parted first.
            of["contact"]["rows"] = json!("paper");
            for (i, body) in of["bodies"].as_array_mut().unwrap().iter_mut().enumerate() {
                body["position"] = json!([0.3 * i as f64, 0.51 * i as f64, 0.0]);
                body["orientation"] = json!(ALONG_X);
            }
            // A torque makes a body tumble a little within the step.
            let forces = of["forces"].as_array_mut().unwrap();
            forces.retain(|force| force.get("torque").is_none());
            forces.push(json!({"trap": {"stiffness": 40, "center": [0, 0, 0]}}));
            run(parse(&of), &Compute::Cpu).bodies
        };
        let slow = of(&json!({"overdamped": {"drag": DRAG}}));
        let light = of(&json!({"inertial": {"density": 1e-9, "drag": DRAG}}));
        let off = (0..slow.len()).map(|i| slow.position[i].distance(light.position[i])).fold(0.0, f64::max);
        let moved = (0..slow.len()).map(|i| slow.velocity[i].length()).fold(0.0, f64::max);
        println!("planar {planar}: {off:.1e}, at velocities of {moved:.2}");
        assert!(off < 1e-4, "planar {planar}: {off:e}");
    }
}

#[test]
fn drag_on_a_device_is_the_cpus() {
    for planar in [false, true] {
        for stepping in ["euler", "midpoint"] {
            let law = json!({"inertial": {"density": 1.5, "drag": 20}});
            let scene = parse(&everything(planar, &law, stepping, false));
            agrees_on_device(&scene, &format!("planar {planar}, {stepping}"), [2e-4, 1e-9]);
        }
    }
    for stepping in ["euler", "midpoint"] {
        let body = moving(&shapes()[2], [1.0, 2.0, -0.5], [20.0, -10.0, 30.0]);
        let of = json!({"name": "slowed", "time": {"dt": 0.05, "end": 1, "stepping": stepping}, "bodies": [body],
            "dynamics": {"inertial": {"density": DENSITY, "drag": DRAG}}});
        agrees_on_device(&parse(&of), &format!("a spinning ellipsoid, {stepping}"), [2e-5, 1e-12]);
    }
}

#[test]
fn a_drag_that_is_none_is_refused() {
    let of = json!({"name": "slowed", "time": {"dt": 0.05, "end": 1}, "bodies": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0]}],
        "dynamics": {"inertial": {"density": 1, "drag": 0}}});
    let (key, message) = refusal(&of);
    assert!(key == "dynamics.inertial.drag" && message.contains("must be positive"), "{message}");
    // A scene without it is as it was.
    let [plain, _] = [(); 2].map(|()| everything(false, &json!({"inertial": {"density": 1}}), "euler", false));
    let written = parse(&plain).to_json();
    assert!(!written.contains("drag"), "{written}");
    assert!(apart(&run(parse(&plain), &Compute::Cpu).bodies, &run(parse(&plain), &Compute::Cpu).bodies) == 0.0);
}
