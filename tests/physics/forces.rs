//! Propulsion, torques, traps and windows against their closed forms.

use crate::scenes::{ALONG_X, agrees_on_device, laws, parse, refusal, run};
use glam::DVec3;
use relcp::simulation::Compute;
use serde_json::{Value, json};

const RADII: [f64; 3] = [0.4, 0.5, 1.0];

fn rod(position: [f64; 3]) -> Value {
    json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "position": position, "orientation": ALONG_X})
}

fn scene(steps: u32, stepping: &str, law: Value, forces: Value, body: Value) -> Value {
    json!({"name": "driven", "time": {"dt": 1.0 / f64::from(steps), "end": 1, "stepping": stepping}, "dynamics": law,
           "forces": forces, "bodies": [body]})
}

fn overdamped() -> Value {
    json!({"overdamped": {"drag": 1.5}})
}

#[test]
fn a_propelled_rod_without_torque_goes_straight_along_its_axis() {
    for planar in [false, true] {
        let forces = json!([{"propulsion": {"force": 0.75}}, {"propulsion": {"force": -3, "axis": [0, -0.5, 0]}}]);
        let mut of = scene(16, "euler", overdamped(), forces, rod([0.0; 3]));
        of["planar"] = json!(planar);
        let at = run(parse(&of), &Compute::Cpu).bodies.position[0];
        // F / (xi L) = 0.25 along the axis, which is x, and 1 along the body's y, which is y.
        assert!((at - DVec3::new(0.25, 1.0, 0.0)).length() < 1e-14, "{at}");
    }
}

/// A rod that is propelled and turned in the plane goes round a circle: the error at the end of each scheme falls by
/// its order.
#[test]
fn a_propelled_rod_that_turns_goes_round_a_circle_to_the_order_of_the_scheme() {
    let turn = 2.0_f64;
    // w = 12 T / (xi L^3) = T; the heading begins along x.
    let forces = json!([{"propulsion": {"force": 3}}, {"torque": {"torque": [0, 0, turn]}}]);
    let expected = DVec3::new(turn.sin(), 1.0 - turn.cos(), 0.0) / turn;
    for (stepping, order) in [("euler", 1), ("midpoint", 2)] {
        let error = |steps: u32| {
            let mut of = scene(steps, stepping, overdamped(), forces.clone(), rod([0.0; 3]));
            of["planar"] = json!(true);
            run(parse(&of), &Compute::Cpu).bodies.position[0].distance(expected)
        };
        let [coarse, fine] = [64, 128].map(error);
        let ratio = coarse / fine;
        println!("{stepping}: {coarse:.2e}, {fine:.2e} with half the step, ratio {ratio:.3}");
        assert!((ratio / f64::from(1 << order) - 1.0).abs() < 0.05, "{stepping}: {ratio}");
    }
}

#[test]
fn a_torque_turns_each_body_at_the_rate_of_its_law() {
    let shapes = [
        (json!({"sphere": {"radius": 0.6}}), 1.2),
        (json!({"spherocylinder": {"diameter": 0.5, "length": 2}}), 2.0),
        (json!({"ellipsoid": {"radii": RADII}}), 2.0),
    ];
    for (shape, length) in shapes {
        for frame in ["space", "body"] {
            // The body's own z is x of space.
            let torque = if frame == "space" { [0.3, 0.0, 0.0] } else { [0.0, 0.0, 0.3] };
            let body = json!({"shape": shape, "position": [0, 0, 0], "orientation": ALONG_X});
            let forces = json!([{"torque": {"torque": torque, "frame": frame}}]);
            let of = |law: Value, stepping: &str| {
                let scene = parse(&scene(8, stepping, law, forces.clone(), body.clone()));
                run(scene, &Compute::Cpu).bodies
            };
            for stepping in ["euler", "midpoint"] {
                let slow = of(overdamped(), stepping).angular_velocity[0];
                let rate = 12.0 * 0.3 / (1.5 * f64::powi(length, 3));
                assert!((slow - DVec3::X * rate).length() < 1e-13 * rate, "{slow}");
                let ended = of(json!({"inertial": {"density": 2}}), stepping);
                let rate = 0.3 / (2.0 * ended.shape[0].unit_inertia().z);
                let off = (ended.angular_velocity[0] - DVec3::X * rate).length() / rate;
                assert!(off < 1e-12, "{shape} {frame} {stepping}: {} {rate}", ended.angular_velocity[0]);
            }
        }
    }
}

#[test]
fn an_overdamped_body_relaxes_in_a_trap_exponentially_to_the_order_of_the_scheme() {
    let (start, center) = (DVec3::new(2.0, -1.0, 0.5), DVec3::new(0.5, 0.25, 0.5));
    // k / (xi L) = 2 along x and y; z is free.
    let forces = json!([{"trap": {"stiffness": 6, "center": center.to_array(), "axes": [true, true, false]}}]);
    let expected = center + (start - center) * f64::exp(-2.0);
    for (stepping, order) in [("euler", 1), ("midpoint", 2)] {
        let end = |steps: u32| {
            let of = scene(steps, stepping, overdamped(), forces.clone(), rod(start.to_array()));
            run(parse(&of), &Compute::Cpu).bodies.position[0]
        };
        let a = 2.0 / 64.0;
        let each = if order == 1 { 1.0 - a } else { 1.0 - a + 0.5 * a * a };
        let of_scheme = center + (start - center) * f64::powi(each, 64);
        assert!((end(64) - of_scheme).length() < 1e-14, "{stepping}");
        let [coarse, fine] = [64, 128].map(|steps| end(steps).distance(expected));
        println!("{stepping}: {coarse:.2e}, {fine:.2e} with half the step, ratio {:.3}", coarse / fine);
        assert!((coarse / fine / f64::from(1 << order) - 1.0).abs() < 0.05, "{stepping}: {coarse} {fine}");
    }
}

#[test]
fn a_trap_across_a_periodic_side_draws_to_the_nearest_image() {
    let forces = json!([{"trap": {"stiffness": 3, "center": [4.5, 0, 0]}}]);
    let mut of = scene(200, "midpoint", overdamped(), forces, rod([-4.0, 1.0, 0.0]));
    of["periodic"] = json!({"lengths": [10, null, null]});
    of["time"]["end"] = json!(20);
    let at = run(parse(&of), &Compute::Cpu).bodies.position[0];
    assert!((at - DVec3::new(-5.5, 0.0, 0.0)).length() < 1e-7, "{at}");
}

/// A constant force moves an overdamped body by the time that its window is on, whatever the step.
#[test]
fn a_window_counts_for_the_time_that_it_is_on() {
    let windows = [
        (json!({"from": 0.25}), 0.75),
        (json!({"to": 0.3}), 0.3),
        (json!({"from": 0.111, "to": 0.777}), 0.666),
        (json!({"period": 0.2, "duty": 0.25}), 0.25),
        (json!({"period": 0.4}), 0.6),
        (json!({"from": 0.3, "to": 0.85, "period": 0.25, "duty": 0.2}), 0.15),
    ];
    for (window, on) in windows {
        for (steps, stepping) in [(10, "euler"), (7, "euler"), (7, "midpoint"), (3, "midpoint")] {
            for planar in [false, true] {
                let forces = json!([{"uniform": {"force": [3, -6, 0], "window": window}}]);
                let mut of = scene(steps, stepping, overdamped(), forces, rod([0.0; 3]));
                of["planar"] = json!(planar);
                let at = run(parse(&of), &Compute::Cpu).bodies.position[0];
                let expected = DVec3::new(1.0, -2.0, 0.0) * on;
                assert!((at - expected).length() < 1e-13, "{window} in {steps} {stepping}: {at}, not {expected}");
            }
        }
    }
}

/// Every force at once, on some bodies each, with contacts.
pub fn everything(planar: bool, law: &Value, stepping: &str, periodic: bool) -> Value {
    let body = |i: u32| {
        let (x, y) = (f64::from(i % 3) * 1.1, f64::from(i / 3) * 0.8);
        let z = if planar { 0.0 } else { 0.3 * f64::from(i) };
        let mut body = rod([x, y, z]);
        body["group"] = json!(["a", "b"][(i % 2) as usize]);
        if !planar {
            body["orientation"] = json!([1.0, 0.1 * f64::from(i), 0.4, -0.2]);
        }
        body
    };
    // In the plane the body's x is across it.
    let [space, own] = if planar { [[0.0, 0.0, 0.5], [0.4, 0.0, 0.0]] } else { [[0.1, -0.2, 0.5], [0.4, 0.1, -0.3]] };
    let forces = json!([
        {"uniform": {"force": [0.2, -0.1, 0], "group": "a", "window": {"from": 0.03, "to": 0.09}}},
        {"propulsion": {"force": 1.5, "window": {"period": 0.04, "duty": 0.3}}},
        {"propulsion": {"force": 0.5, "axis": [0, 1, 0], "group": "b"}},
        {"torque": {"torque": space}},
        {"torque": {"torque": own, "frame": "body", "group": "a"}},
        {"trap": {"stiffness": 2, "center": [1, 0.5, 0], "axes": [true, true, !planar], "window": {"from": 0.03, "to": 0.09}}}
    ]);
    let periods = if periodic { json!({"periodic": {"lengths": [12, null, null]}}) } else { json!({}) };
    let mut of = json!({"name": "everything", "planar": planar, "time": {"dt": 0.01, "end": 0.12, "stepping": stepping},
        "dynamics": law, "forces": forces, "bodies": (0..6).map(body).collect::<Vec<_>>(),
        "contact": {"overlap_tolerance": 1e-5}, "solver": {"tolerance": 1e-7}});
    of.as_object_mut().unwrap().extend(periods.as_object().unwrap().clone());
    of
}

#[test]
fn forces_on_a_device_are_the_cpus() {
    for planar in [false, true] {
        for (law, stepping) in laws().iter().flat_map(|law| [(law, "euler"), (law, "midpoint")]) {
            let periodic = planar == (stepping == "midpoint");
            let name = format!("planar {planar}, {law}, {stepping}, periodic {periodic}");
            let scene = parse(&everything(planar, law, stepping, periodic));
            agrees_on_device(&scene, &name, [2e-4, 1e-10]);
        }
    }
}

#[test]
fn a_force_that_cannot_be_is_refused_with_its_place_and_a_remedy() {
    let cases = [
        (json!({"propulsion": {"force": 1, "axis": [0, 0, 0]}}), "propulsion.axis", "direction"),
        (json!({"trap": {"stiffness": 0, "center": [0, 0, 0]}}), "trap.stiffness", "positive"),
        (json!({"trap": {"stiffness": 1, "center": [0, 0, 0], "axes": [false, false, false]}}), "trap.axes", "true"),
        (json!({"torque": {"torque": [0, 0, 1], "group": "x"}}), "torque.group", "no body"),
        (json!({"torque": {"torque": [0, 0, 1], "window": {}}}), "torque.window", "from"),
        (json!({"torque": {"torque": [0, 0, 1], "window": {"from": 2, "to": 1}}}), "torque.window.to", "later"),
        (json!({"torque": {"torque": [0, 0, 1], "window": {"from": 2, "duty": 1}}}), "torque.window.duty", "period"),
        (
            json!({"torque": {"torque": [0, 0, 1], "window": {"period": 1, "duty": 1.5}}}),
            "torque.window.duty",
            "most 1",
        ),
        (json!({"torque": {"torque": [0, 0, 1], "window": {"period": 0}}}), "torque.window.period", "positive"),
    ];
    for (force, key, word) in cases {
        let (at, message) = refusal(&scene(10, "euler", overdamped(), json!([force]), rod([0.0; 3])));
        assert!(at == format!("forces.0.{key}") && message.contains(word), "{message}");
    }
    let many: Vec<_> = (1..30).map(|k| json!({"uniform": {"force": [1, 0, 0], "window": {"to": k}}})).collect();
    let (at, message) = refusal(&scene(10, "euler", overdamped(), json!(many), rod([0.0; 3])));
    assert!(at == "forces.24.uniform.window" && message.contains("at most 24"), "{message}");
}

#[test]
fn a_force_out_of_the_plane_is_refused() {
    let upright = json!({"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0]});
    let cases = [
        (rod([0.0; 3]), json!({"propulsion": {"force": 1, "axis": [1, 0, 0]}}), "propulsion.axis", "bodies.0"),
        (upright, json!({"propulsion": {"force": 1}}), "propulsion.axis", "in the plane"),
        (rod([0.0; 3]), json!({"torque": {"torque": [0, 1, 1]}}), "torque.torque.1", "must be 0"),
        (rod([0.0; 3]), json!({"torque": {"torque": [0, 0, 1], "frame": "body"}}), "torque.torque", "space"),
        (rod([0.0; 3]), json!({"trap": {"stiffness": 1, "center": [0, 0, 1]}}), "trap.center.2", "axes[2]"),
    ];
    for (body, force, key, word) in cases {
        let mut of = scene(10, "euler", overdamped(), json!([force]), body);
        of["planar"] = json!(true);
        let (at, message) = refusal(&of);
        assert!(at == format!("forces.0.{key}") && message.contains(word), "{message}");
    }
    let spheres = json!([{"isotropic": {"count": 3, "shape": {"sphere": {"radius": 1}}, "volume_fraction": 0.1}}]);
    let mut of = scene(10, "euler", overdamped(), json!([{"propulsion": {"force": 1}}]), rod([0.0; 3]));
    (of["planar"], of["generate"]) = (json!(true), spheres);
    let (at, message) = refusal(&of);
    assert!(at == "forces.0.propulsion.axis" && message.contains("generate.0"), "{message}");
}
