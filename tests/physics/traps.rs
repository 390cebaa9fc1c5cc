//! Traps that are too stiff for the step: the limit that a scene is refused by is that of its steps.

use crate::scenes::{parse, refusal};
use relcp::scene::Scene;
use relcp::simulation::Simulation;
use relcp::step::Fault;
use serde_json::{Value, json};

const STIFFNESS: f64 = 3.0;

fn scene(law: &Value, stepping: &str, dt: f64, steps: usize) -> Value {
    json!({"name": "trapped", "dynamics": law, "time": {"dt": dt, "end": dt * steps as f64, "stepping": stepping},
        "forces": [{"trap": {"stiffness": STIFFNESS, "center": [0, 0, 0], "axes": [true, false, false]}}],
        "bodies": [{"shape": {"spherocylinder": {"diameter": 0.4, "length": 1.2}}, "position": [1, 0, 0]}]})
}

/// The longest step that the message of a refused scene names, rounded down to three digits.
fn limit(law: &Value, stepping: &str) -> f64 {
    let (key, message) = refusal(&scene(law, stepping, 100.0, 10));
    assert_eq!(key, "forces.0.trap.stiffness");
    let named = message.split("longest stable step is ").nth(1).unwrap();
    named.split(',').next().unwrap().parse().unwrap()
}

/// The largest distance over the steps of a run that is not validated, which ends where the body has run away.
fn farthest(scene: Scene) -> f64 {
    let bodies = {
        let mut short = scene.clone();
        short.time.dt = 1e-6;
        short.time.end = 1e-6;
        short.build().unwrap()
    };
    let mut simulation = Simulation::builder(scene).bodies(bodies).build().unwrap();
    let mut farthest = 0.0_f64;
    while !simulation.done() {
        match simulation.step() {
            Ok(_) => farthest = farthest.max(simulation.state().unwrap().bodies.position[0].x.abs()),
            Err(Fault::RunAway { distance, .. }) => return farthest.max(distance),
            Err(fault) => panic!("{fault}"),
        }
    }
    farthest
}

#[test]
fn the_limit_is_where_bodies_begin_to_leave() {
    let laws = [
        json!({"overdamped": {"drag": 1.5}}),
        json!({"inertial": {"density": 2.0}}),
        json!({"inertial": {"density": 2.0, "drag": 0.4}}),
        json!({"inertial": {"density": 0.5, "drag": 3.0}}),
    ];
    for (law, stepping) in laws.iter().flat_map(|law| ["euler", "midpoint"].map(|stepping| (law, stepping))) {
        let limit = limit(law, stepping);
        // A step of just that length is accepted.
        parse(&scene(law, stepping, limit, 4));
        if law.get("overdamped").is_some() {
            assert!((limit / (2.0 * 1.5 * 1.2 / STIFFNESS) - 1.0).abs() < 1e-4, "{limit}");
        }
        let run = |part: f64| {
            // Below the limit the scene is accepted; above it its text is not, and it is made from one that is.
            let mut scene = parse(&scene(law, stepping, 0.9 * limit, 1));
            (scene.time.dt, scene.time.end) = (part * limit, part * limit * 400.0);
            assert_eq!(scene.validate().is_ok(), part < 1.0, "{law} {stepping} {part}");
            farthest(scene)
        };
        let (below, above) = (run(0.99), run(1.03));
        println!("{law} {stepping}: longest stable step {limit}, farthest below {below:.3e}, above {above:.3e}");
        assert!(below < 20.0 && above > 1e3, "{law} {stepping}: {below} {above}");
    }
}

#[test]
fn which_traps_are_too_stiff() {
    let law = json!({"overdamped": {"drag": 1.5}});
    // The limit is 1.2.
    let with = |forces: Value, dt: f64| {
        let mut scene = scene(&law, "euler", dt, 4);
        scene["bodies"][0]["group"] = json!("rods");
        scene["forces"] = forces;
        scene
    };
    let trap = |more: Value| {
        let mut trap = json!({"trap": {"stiffness": STIFFNESS, "center": [0, 0, 0]}});
        trap["trap"].as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        trap
    };
    parse(&with(json!([trap(json!({}))]), 1.2));
    let (key, message) = refusal(&with(json!([trap(json!({}))]), 1.21));
    assert_eq!(key, "forces.0.trap.stiffness");
    assert!(message.contains("bodies.0 would leave the trap") && message.contains("step is 1.2,"), "{message}");
    // Two together, along one axis; not along different ones.
    let [x, y] = [json!({"axes": [true, false, false]}), json!({"axes": [false, true, true]})];
    let (key, _) = refusal(&with(json!([trap(x.clone()), trap(json!({"stiffness": 3.5}))]), 1.0));
    assert_eq!(key, "forces.1.trap.stiffness");
    parse(&with(json!([trap(x), trap(y)]), 1.0));
    // Of groups.
    refusal(&with(json!([trap(json!({"group": "rods"}))]), 1.3));
    let mut two = with(json!([trap(json!({"group": "balls"}))]), 1.3);
    two["bodies"]
        .as_array_mut()
        .unwrap()
        .push(json!({"shape": {"sphere": {"radius": 2}}, "position": [9, 0, 0], "group": "balls"}));
    parse(&two);
    // An obstacle is not moved by it.
    let mut fixed = with(json!([trap(json!({}))]), 1.3);
    fixed["bodies"][0]["fixed"] = json!(true);
    parse(&fixed);
    // Windows: of a pulse within a step the share counts, one that lasts is as any trap.
    parse(&with(json!([trap(json!({"window": {"from": 0.1, "to": 1.0}}))]), 1.3));
    parse(&with(json!([trap(json!({"window": {"period": 1, "duty": 0.5}}))]), 1.3));
    refusal(&with(json!([trap(json!({"window": {"from": 2}}))]), 1.3));
    refusal(&with(json!([trap(json!({"window": {"period": 10, "duty": 0.5}}))]), 1.3));
    // The shortest cell that growth leaves: half of the division length, 0.75.
    let mut growing = with(json!([trap(json!({}))]), 0.8);
    growing["bodies"][0]["angle"] = json!(0);
    growing["planar"] = json!(true);
    parse(&growing);
    growing["growth"] = json!({"rate": 0.01, "division_length": 1.5});
    let (_, message) = refusal(&growing);
    assert!(message.contains("step is 0.75,"), "{message}");
}
