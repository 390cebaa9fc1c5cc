//! The keys of friction, what does not support it, and what it leaves alone.

use crate::scenes::{G, assert_near, ball, floor, inertial, parse, rod, run, start, weight, with};
use relcp::Simulation;
use relcp::record::{decode, encode, state_hash};
use relcp::scene::{Friction, Scene};
use serde_json::{Value, json};

#[test]
fn a_smooth_wall_keeps_a_rods_speed_and_groups_have_their_own_coefficient() {
    let thrown = || with(rod(0.5), "velocity", json!([5, 0, 0]));
    let smooth = json!([{"half_space": {"normal": [0, 0, 1], "offset": 0, "friction": 0.0}}]);
    let bodies = run(&inertial(0.5, weight(0.0), smooth, vec![thrown()], [0.01, 0.5]));
    assert_near(bodies.velocity[0].x, 5.0, 1e-12);
    let rough = json!([{"half_space": {"normal": [0, 0, 1], "offset": 0, "friction": 0.2}}]);
    let bodies = run(&inertial(0.0, weight(0.0), rough, vec![thrown()], [0.01, 0.5]));
    assert_near(bodies.velocity[0].x, 5.0 - 0.2 * G * 0.5, 1e-9);
    // A rod that slides on two fixed ones of another group.
    let on_fixed = |is: f64| {
        let fixed = |y: f64| with(with(rod(0.5), "position", json!([0.0, y, 0.5])), "fixed", json!(true));
        let slider = json!({"shape": {"spherocylinder": {"diameter": 1.0, "length": 4.0}}, "position": [0.0, 0.0, 1.5],
            "axis": [0, 1, 0], "velocity": [1, 0, 0], "group": "slider"});
        let bed = [-1.0, 1.0].map(|y| with(fixed(y), "group", json!("bed")));
        let bodies = bed.into_iter().chain([slider]).collect();
        let friction = json!({"bodies": 0.7, "groups": [{"between": ["slider", "bed"], "is": is}]});
        run(&inertial(friction, weight(0.0), json!([]), bodies, [0.01, 0.3])).velocity[2].x
    };
    assert_near(on_fixed(0.0), 1.0, 1e-9);
    assert!(on_fixed(0.1) < 0.95);
}

/// What reading a scene with these keys says.
fn refused(key: &str, value: Value) -> String {
    let mut scene = inertial(
        0.3,
        weight(0.0),
        json!([floor()]),
        vec![with(ball([0.0, 0.0, 1.0]), "group", json!("a"))],
        [0.01, 1.0],
    );
    let (outer, inner) = key.split_once('.').unwrap();
    if scene[outer].is_null() {
        scene[outer] = json!({});
    }
    scene[outer][inner] = value;
    Scene::parse(&scene.to_string(), "scene").err().map(|fault| fault.to_string()).unwrap_or_default()
}

#[test]
fn what_friction_cannot_be_is_refused_with_its_key() {
    for (key, value, says) in [
        ("contact.friction", json!(-0.1), "between 0 and 10"),
        ("contact.friction", json!(11), "between 0 and 10"),
        ("contact.friction", json!({"walls": 10.5}), "friction.walls"),
        ("contact.friction", json!("rough"), "a number, or an object"),
        ("contact.friction", json!({"wall": 0.5}), "wall"),
        ("contact.friction", json!({"groups": [{"between": ["a", "b"], "is": 0.1}]}), "`b`"),
        (
            "contact.friction",
            json!({"groups": [{"between": ["a", "a"], "is": 0.1}, {"between": ["a", "a"], "is": 0.2}]}),
            "same groups",
        ),
        ("contact.elastic_slip", json!(-1), "must not be negative"),
        ("contact.restitution", json!(1.5), "between 0 and 1"),
        ("contact.restitution", json!({"walls": -1}), "restitution.walls"),
        ("contact.on_failure", json!("continue"), "conflicts with friction"),
        ("time.stepping", json!("midpoint"), "conflicts with friction"),
        ("solver.kind", json!("interior_point"), "conflicts with friction"),
        ("solver.dump", json!({"when": "slow"}), "conflicts with friction"),
    ] {
        let said = refused(key, value);
        assert!(said.contains(says), "{key}: {said}");
    }
    for (key, value) in [
        ("contact.restitution", json!({"bodies": 0.5})),
        ("contact.friction", json!({"bodies": 0.2})),
        ("contact.friction", json!({"groups": [{"between": ["a", "a"], "is": 0.1}]})),
        ("contact.elastic_slip", json!(0)),
        ("solver.kind", json!("apgd")),
        ("solver.kind", json!("pair_block_cg")),
    ] {
        assert_eq!(refused(key, value), "", "{key}");
    }
}

#[test]
fn a_scene_with_friction_reads_as_it_was_written() {
    let mut scene = parse(&inertial(0.3, weight(0.0), json!([floor()]), vec![ball([0.0, 0.0, 1.0])], [0.01, 1.0]));
    let again = |scene: &Scene| Scene::parse(&scene.to_json(), "scene").unwrap();
    assert!(scene.to_json().contains("\"friction\": 0.3"));
    assert_eq!(again(&scene), scene);
    scene.contact.friction.walls = 0.1;
    assert_eq!(again(&scene), scene);
    let smooth = parse(&inertial(0.0, weight(0.0), json!([floor()]), vec![ball([0.0, 0.0, 1.0])], [0.01, 1.0]));
    assert!(!smooth.with_defaults().to_json().contains("friction") && smooth.contact.friction == Friction::default());
    assert!(scene.with_defaults().to_json().contains("elastic_slip"));
}

/// Rods that fall onto a floor in a heap.
fn heap() -> Value {
    let walls = json!([{"box": {"minimum": [-3, -3, 0], "maximum": [3, 3, 30]}}]);
    let mut scene = inertial(0.4, weight(0.0), walls, vec![], [0.01, 0.6]);
    scene["generate"] = json!([{"isotropic": {"count": 30, "volume_fraction": 0.15, "center": [0, 0, 3],
        "shape": {"spherocylinder": {"diameter": 0.6, "length": 1.5}}}}]);
    scene
}

#[test]
fn a_run_that_was_stopped_and_resumed_has_the_bits_of_one_that_was_not() {
    let scene = heap();
    let mut whole = start(&scene);
    let mut held = None;
    while !whole.done() {
        whole.step().unwrap();
        if whole.state().unwrap().step == 45 {
            held = Some(encode(whole.state().unwrap(), "x", whole.time(), None).unwrap());
        }
    }
    // A state that is no checkpoint has no forces.
    let (_, without) = decode(&held.unwrap()).unwrap();
    assert!(without.warm.is_empty());
    let mut first = start(&scene);
    for _ in 0..45 {
        first.step().unwrap();
    }
    let bytes = relcp::record::encode_with_forces(first.state().unwrap(), "x", first.time()).unwrap();
    let (header, state) = decode(&bytes).unwrap();
    assert_eq!((header.version, &state), (3, first.state().unwrap()));
    assert!(state.warm.iter().any(|w| w.tangent.length() > 0.0));
    let mut resumed = Simulation::builder(parse(&scene)).resume(state).build().unwrap();
    while !resumed.done() {
        resumed.step().unwrap();
    }
    assert_eq!(state_hash(resumed.state().unwrap()), state_hash(whole.state().unwrap()));
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let scene = heap();
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = start(&scene);
            while !simulation.done() {
                simulation.step().unwrap();
            }
            state_hash(simulation.state().unwrap())
        })
    };
    assert_eq!(hash(1), hash(4));
}
