//! Bodies that do not move.

use crate::scenes::{ALONG_X, agrees_on_device, laws, parse, refusal, run};
use glam::DVec3;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};

fn sphere(radius: f64, position: [f64; 3]) -> Value {
    json!({"shape": {"sphere": {"radius": radius}}, "position": position})
}

fn with(mut body: Value, keys: &Value) -> Value {
    body.as_object_mut().unwrap().extend(keys.as_object().unwrap().clone());
    body
}

fn scene(dt: f64, end: f64, forces: &Value, bodies: &[Value]) -> Value {
    json!({"name": "obstacles", "time": {"dt": dt, "end": end}, "dynamics": {"overdamped": {"drag": 1.0}},
           "forces": forces, "bodies": bodies, "contact": {"overlap_tolerance": 1e-8}})
}

/// An overdamped ball that is pushed down slides off a fixed one: `tan(angle / 2)` from the top grows as `exp(F t / (xi
/// L (R + r)))`.
#[test]
fn a_ball_slides_off_a_fixed_one_at_the_rate_of_theory() {
    let (top, apart) = (0.3_f64, 1.5);
    for planar in [false, true] {
        let error = |dt: f64| {
            // In the plane down is -y, else -z.
            let place = [apart * top.sin(), apart * top.cos()];
            let (down, place) = match planar {
                true => ([0.0, -3.0, 0.0], [place[0], place[1], 0.0]),
                false => ([0.0, 0.0, -3.0], [place[0], 0.0, place[1]]),
            };
            let bodies = [with(sphere(1.0, [0.0; 3]), &json!({"fixed": true})), sphere(0.5, place)];
            let mut of = scene(dt, 0.5, &json!([{"uniform": {"force": down}}]), &bodies);
            of["planar"] = json!(planar);
            let end = run(parse(&of), &Compute::Cpu);
            let (at, fixed) = (end.bodies.position[1], end.bodies.position[0]);
            assert_eq!(fixed, DVec3::ZERO);
            assert!((at.length() - apart).abs() < dt * dt * 3.0, "{at}");
            let height = if planar { at.y } else { at.z };
            let expected = 2.0 * ((0.5 * top).tan() * (3.0 * 0.5 / apart).exp()).atan();
            (at.x.atan2(height) - expected).abs()
        };
        let [coarse, fine] = [1.0 / 64.0, 1.0 / 128.0].map(error);
        println!("planar {planar}: {coarse:.2e} and {fine:.2e} with half the step, ratio {:.3}", coarse / fine);
        assert!((coarse / fine / 2.0 - 1.0).abs() < 0.1 && coarse < 1e-2, "{coarse} {fine}");
    }
}

/// A ball that rests on a fixed one is held by as much as it is pushed.
#[test]
fn a_fixed_body_takes_the_force_that_holds_another() {
    let bodies = [with(sphere(1.0, [0.0; 3]), &json!({"fixed": true})), sphere(0.5, [0.0, 0.0, 1.5])];
    for law in laws() {
        let mut of = scene(0.1, 0.5, &json!([{"uniform": {"force": [0, 0, -2.5]}}]), &bodies);
        of["dynamics"] = law.clone();
        let end = run(parse(&of), &Compute::Cpu);
        assert!((end.warm[0].gamma - 2.5).abs() < 1e-6, "{law}: {}", end.warm[0].gamma);
        assert!((end.bodies.position[1].z - 1.5).abs() < 1e-7, "{law}: {}", end.bodies.position[1]);
    }
}

#[test]
fn two_fixed_bodies_have_no_row_and_no_overlap() {
    for method in [json!("relcp"), json!({"multisphere": {"count": 3}})] {
        let rod = json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 2}}, "position": [0, 0, 0.1], "orientation": ALONG_X});
        let held = json!({"group": "posts"});
        let bodies = [with(sphere(1.0, [0.0; 3]), &held), with(rod, &held), sphere(0.4, [0.0, 0.0, 3.0])];
        let mut of = scene(0.1, 0.3, &json!([]), &bodies);
        of["groups"] = json!({"posts": {"fixed": true}});
        of["contact"]["method"] = method;
        of["walls"] = json!([{"half_space": {"normal": [0, 0, 1], "offset": -1}}]);
        let mut simulation = Simulation::new(parse(&of)).unwrap();
        let start = simulation.state().unwrap().bodies.clone();
        while !simulation.done() {
            let report = simulation.step().unwrap();
            assert_eq!((report.constraints, report.max_overlap), (0, 0.0));
        }
        assert_eq!(simulation.state().unwrap().bodies, start);
    }
}

/// Rods and balls that are driven through fixed ones.
fn crowd(planar: bool, law: &Value, stepping: &str) -> Value {
    let mut bodies = Vec::new();
    for i in 0..5_u32 {
        let (x, lift) = (f64::from(i) * 1.2, if planar { 0.0 } else { 0.15 * f64::from(i) });
        let rod = json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.5}}, "position": [x, 0.1 * x, 0], "orientation": ALONG_X});
        bodies.push(with(sphere(0.4, [x, -0.8, 0.0]), &json!({"group": "posts"})));
        bodies.push(rod);
        bodies.push(with(sphere(0.3, [x, 0.9, 0.0]), &json!({"fixed": i % 2 == 0})));
        for body in bodies.iter_mut().skip(3 * i as usize) {
            body["position"][2] = json!(lift);
        }
    }
    let mut of = scene(0.01, 0.2, &json!([{"uniform": {"force": [0.5, -3, 0]}}]), &bodies);
    of["groups"] = json!({"posts": {"fixed": true}});
    (of["planar"], of["dynamics"], of["time"]["stepping"]) = (json!(planar), law.clone(), json!(stepping));
    of["walls"] = json!([{"half_space": {"normal": [0, 1, 0], "offset": -1.25}}]);
    of["contact"]["overlap_tolerance"] = json!(1e-5);
    of
}

#[test]
fn a_crowd_among_fixed_bodies_on_a_device_is_the_cpus() {
    for planar in [false, true] {
        for (law, stepping) in laws().iter().flat_map(|law| [(law, "euler"), (law, "midpoint")]) {
            let name = format!("planar {planar}, {law}, {stepping}");
            let scene = parse(&crowd(planar, law, stepping));
            let start = scene.build().unwrap();
            let end = run(scene.clone(), &Compute::Cpu).bodies;
            for i in 0..start.len() {
                let fixed = i % 3 == 0 || i % 6 == 2;
                let stays = end.position[i] == start.position[i] && end.orientation[i] == start.orientation[i];
                assert_eq!(stays, fixed, "{name}: body {i}");
            }
            assert!(relcp::step::contacts(&end, 0.0).iter().all(|contact| contact.separation > -1e-5), "{name}");
            // A rod that turns about the end of another in one of 20 steps makes 1e-7 to 5e-5, and of velocities 3e-3.
            agrees_on_device(&scene, &name, [5e-3, 2e-5]);
        }
    }
}

#[test]
fn a_run_goes_on_from_its_final_scene_with_the_same_fixed_bodies() {
    let scene = parse(&crowd(true, &laws()[0], "euler"));
    let end = run(scene.clone(), &Compute::Cpu).bodies;
    let last = scene.final_scene(&end, 0.2);
    let again = relcp::Scene::parse(&last.to_json(), "final.json").unwrap();
    assert_eq!((again.fixed(), &again.groups), (scene.fixed(), &scene.groups));
}

#[test]
fn what_a_fixed_body_cannot_have_is_refused() {
    let rod = json!({"shape": {"spherocylinder": {"diameter": 0.5, "length": 1.5}}, "position": [0, 0, 0], "orientation": ALONG_X});
    let of = |bodies: &[Value], more: Value| {
        let mut of = scene(0.1, 1.0, &json!([]), bodies);
        of.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        refusal(&of)
    };
    let growth = json!({"growth": {"rate": 1, "division_length": 2}});
    let fixed = [with(rod.clone(), &json!({"fixed": true})), sphere(1.0, [9.0; 3])];
    let (at, message) = of(&fixed, growth.clone());
    assert!(at == "bodies.0.shape" && message.contains("would grow"), "{message}");
    let named = [with(rod, &json!({"group": "a"}))];
    let (at, message) = of(&named, with(growth, &json!({"groups": {"a": {"fixed": true}}})));
    assert!(at == "bodies.0.shape" && message.contains("would grow"), "{message}");
    let (at, message) = of(&named, json!({"groups": {"b": {"fixed": true}}}));
    assert!(at == "groups.b" && message.contains("no body is in this group"), "{message}");
    let moving = [with(sphere(1.0, [0.0; 3]), &json!({"fixed": true, "velocity": [1, 0, 0]}))];
    let (at, message) = of(&moving, json!({"dynamics": {"inertial": {"density": 1}}}));
    assert!(at == "bodies.0.velocity" && message.contains("must be zero"), "{message}");
}
