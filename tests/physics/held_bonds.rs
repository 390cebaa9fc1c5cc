//! What states have of bonds and joints that hold: tensions, torques and energies; bonds without contact; bonds that
//! break; messages that name a bond; chains in heat whose steps are long for their bonds.

use crate::scenes::{in_two_parts, parse, refusal, run, watch};
use glam::DVec3;
use relcp::bodies::{Bodies, HeldBond};
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};

const WEIGHT: f64 = 2.0;

fn ball(x: f64, y: f64, z: f64) -> Value {
    json!({"shape": {"sphere": {"radius": 0.5}}, "position": [x, y, z]})
}

/// Balls in a row below a fixed one, each a weight, with these keys in each bond.
fn hanging(keys: &Value) -> Value {
    let mut bodies: Vec<Value> = (0..6).map(|i| ball(0.0, 0.0, -1.3 * f64::from(i))).collect();
    bodies[0]["fixed"] = json!(true);
    let bond = |i: usize| {
        let mut bond = json!({"bodies": [i, i + 1], "at": [[0, 0, 0], [0, 0, 0]], "length": 1.3});
        bond.as_object_mut().unwrap().extend(keys.as_object().unwrap().clone());
        bond
    };
    json!({"name": "hanging", "time": {"dt": 0.01, "end": 6.0}, "dynamics": {"overdamped": {"drag": 1.0}},
        "forces": [{"uniform": {"force": [0, 0, -WEIGHT]}}], "solver": {"tolerance": 1e-9}, "bodies": bodies,
        "bonds": (0..5).map(bond).collect::<Vec<_>>()})
}

fn tensions(bodies: &Bodies) -> Vec<f64> {
    bodies.bonds.iter().map(|bond| bond.tension(bodies)).collect()
}

#[test]
fn the_bonds_of_a_hanging_chain_carry_5_4_3_2_and_1_weights() {
    for keys in [
        json!({"stiffness": "rigid"}),
        json!({"stiffness": 1e6}),
        json!({"stiffness": 30.0, "implicit": true}),
        json!({"stiffness": 30.0, "implicit": false}),
    ] {
        let state = run(parse(&hanging(&keys)), &Compute::Cpu);
        let found = tensions(&state.bodies);
        for (i, tension) in found.iter().enumerate() {
            let expected = (5 - i) as f64 * WEIGHT;
            assert!((tension - expected).abs() < 2e-3, "{keys}: bond {i} carries {tension}, not {expected}");
        }
    }
}

#[test]
fn explicit_bonds_have_their_pull_at_the_start_and_a_resumed_run_has_the_same_bonds() {
    let mut of = hanging(&json!({"stiffness": 30.0}));
    of["bodies"][1]["position"] = json!([0, 0, -1.5]);
    let scene = parse(&of);
    let found = tensions(&scene.build().unwrap());
    assert!((found[0] - 30.0 * 0.2).abs() < 1e-9 && (found[1] + 30.0 * 0.2).abs() < 1e-9, "{found:?}");
    for keys in [json!({"stiffness": 30.0}), json!({"stiffness": "rigid", "break_force": 9.0})] {
        let scene = parse(&hanging(&keys));
        assert!(in_two_parts(&scene, &Compute::Cpu) == run(scene.clone(), &Compute::Cpu), "{keys}");
    }
}

/// A rod that is welded to a fixed ball, and a weight along its length.
#[test]
fn a_weld_carries_the_weight_and_its_torque() {
    let rod = json!({"shape": {"spherocylinder": {"diameter": 0.4, "length": 2.0}}, "position": [1.8, 0, 0],
        "axis": [1, 0, 0]});
    let mut fixed = ball(0.0, 0.0, 0.0);
    fixed["fixed"] = json!(true);
    let weld = |stiff: &Value| {
        json!({"name": "beam", "time": {"dt": 0.02, "end": 2.0}, "dynamics": {"overdamped": {"drag": 1.0}},
            "forces": [{"uniform": {"force": [0, 0, -WEIGHT]}}], "bodies": [fixed, rod], "solver": {"tolerance": 1e-9},
            "joints": [{"weld": {"bodies": [0, 1], "at": [[0.6, 0, 0], [0, 0, -1.2]], "bending": stiff}}]})
    };
    for stiff in [json!("rigid"), json!(500.0)] {
        let state = run(parse(&weld(&stiff)), &Compute::Cpu);
        let HeldBond { force, torque, bending_energy, number, .. } = state.bodies.bonds[0];
        // The rod hangs by what the weld gives way, 1.2 * 2 / 500.
        let turn = stiff.as_f64().map_or(0.0, |stiff| 1.2 * WEIGHT / stiff);
        assert_eq!(number, 0);
        assert!(force.distance(DVec3::Z * WEIGHT) < 1e-3, "{stiff}: {force}");
        assert!((torque.length() - 1.2 * WEIGHT).abs() < 5e-3 && torque.y < 0.0, "{stiff}: {torque}");
        assert!((bending_energy - 0.5 * 1.2 * WEIGHT * turn).abs() < 1e-4, "{stiff}: {bending_energy}");
    }
}

#[test]
fn bodies_of_a_bond_without_contact_overlap_and_others_do_not() {
    let bonds = |contact: bool| {
        json!({"name": "in", "time": {"dt": 0.01, "end": 1.0}, "dynamics": {"overdamped": {"drag": 1.0}},
            "forces": [{"uniform": {"force": [-1, 0, 0]}}],
            "bodies": [ball(0.0, 0.0, 0.0), ball(0.6, 0.0, 0.0), ball(3.0, 0.0, 0.0)],
            "bonds": [{"bodies": [0, 1], "at": [[0, 0, 0], [0, 0, 0]], "stiffness": "rigid", "length": 0.6,
            "contact": contact}]})
    };
    let mut of = bonds(false);
    of["bodies"][0]["fixed"] = json!(true);
    of["time"]["end"] = json!(4.0);
    let simulation = watch(&of, |bodies| {
        assert!((bodies.position[0].distance(bodies.position[1]) - 0.6).abs() < 1e-4);
        assert!(relcp::contacts(bodies, 0.0).iter().all(|contact| contact.separation > -1e-4));
    });
    // The third ball comes up against the second.
    let bodies = &simulation.state().unwrap().bodies;
    assert!((bodies.position[2].x - 1.6).abs() < 1e-3, "{}", bodies.position[2]);
    // With contact the bond and the balls contradict each other.
    let of = bonds(true);
    let mut simulation = Simulation::new(parse(&of)).unwrap();
    assert!(simulation.step().is_err());
    // What a bond held apart from contact is a contact where it breaks.
    let mut of = bonds(false);
    of["bonds"][0]["break_force"] = json!(1.5);
    of["forces"] =
        json!([{"uniform": {"force": [0, 0, 0]}}, {"uniform": {"force": [4, 0, 0], "window": {"from": 0.5}}}]);
    of["bodies"][0]["fixed"] = json!(true);
    of["bodies"].as_array_mut().unwrap().truncate(2);
    let state = run(parse(&of), &Compute::Cpu);
    assert_eq!(state.bodies.broken_bonds, [0]);
    assert!(state.bodies.bonds.is_empty());
    assert!(state.bodies.position[1].x > 1.0 - 1e-4);
}

#[test]
fn bonds_that_break_are_counted_by_step() {
    let mut of = hanging(&json!({"stiffness": "rigid", "break_force": 7.0}));
    of["time"]["end"] = json!(0.5);
    let mut simulation = Simulation::new(parse(&of)).unwrap();
    let mut broken = 0;
    while !simulation.done() {
        let before = simulation.state().unwrap().bodies.broken_bonds.len();
        let report = simulation.step().unwrap();
        let now = simulation.state().unwrap().bodies.broken_bonds.len();
        assert_eq!(report.broken_bonds as usize, now - before);
        broken += report.broken_bonds;
    }
    assert!(broken >= 1);
    assert_eq!(simulation.state().unwrap().bodies.bonds.len() as u32, 5 - broken);
}

#[test]
fn a_step_that_bonds_cannot_hold_names_one_and_a_scene_its_key() {
    let bond = |bodies: [usize; 2], length: f64| json!({"bodies": bodies, "at": [[0, 0, 0], [0, 0, 0]], "stiffness": "rigid", "length": length});
    let bodies = [ball(0.0, 0.0, 0.0), ball(3.0, 0.0, 0.0), ball(3.0, 3.0, 0.0)];
    let of = json!({"name": "two", "time": {"dt": 0.01, "end": 0.1}, "dynamics": {"overdamped": {"drag": 1.0}},
        "bodies": bodies, "bonds": [bond([1, 2], 3.0), bond([0, 1], 2.0), bond([0, 1], 2.5)]});
    let fault = Simulation::new(parse(&of)).unwrap().step().unwrap_err();
    let message = fault.to_string();
    assert_eq!(fault.name(), "bond", "{message}");
    assert!(message.contains("bodies 0 and 1 are off what bonds[1] allows by"), "{message}");
    let mut wrong = of.clone();
    wrong["bonds"][2]["contact"] = json!("no");
    assert_eq!(refusal(&wrong).0, "bonds.2.contact");
    let mut joint = of;
    joint["bonds"] = json!([]);
    joint["joints"] = json!([{"ball": {"bodies": [0, 1], "at": [[1.5, 0, 0], [-1.5, 0, 0]]}},
        {"ball": {"bodies": [0, 1], "at": [[1.5, 0, 0], [1.5, 0, 0]]}}]);
    let message = Simulation::new(parse(&joint)).unwrap().step().unwrap_err().to_string();
    assert!(message.contains("what joints["), "{message}");
}

/// Rods whose gaps are shorter than the way that heat takes them in a step: pressed bonds turn by any angle.
#[test]
fn a_chain_in_heat_whose_steps_are_long_for_its_gaps_goes_on() {
    let of = |seed: u64| {
        json!({"name": "heat", "seed": seed, "dynamics": {"overdamped": {"drag": 1.0}},
            "time": {"dt": 0.005, "end": 2.0}, "thermal": {"temperature": 0.3},
            "flow": {"shear": {"rate": 2.0, "direction": [1, 0, 0], "gradient": [0, 1, 0]}},
            "generate": [{"chain": {"count": 12, "shape": {"spherocylinder": {"diameter": 0.25, "length": 1.0}},
                "path": {"straight": {"axis": [0, 1, 0]}}, "gap": 0.05, "stiffness": 100, "bending": 0.5}}]})
    };
    for seed in [1, 2] {
        let (mut most, mut pieces, mut sum) = (0, 0, 0);
        let mut simulation = Simulation::new(parse(&of(seed))).unwrap();
        while !simulation.done() {
            let report = simulation.step().unwrap_or_else(|fault| panic!("seed {seed}: {fault}"));
            most = most.max(report.recursions);
            sum += report.recursions;
            pieces += u32::from(report.pieces > 1);
        }
        println!("seed {seed}: recursions at most {most}, {sum} in all, {pieces} steps in pieces");
    }
}
