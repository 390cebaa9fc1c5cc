//! Implicit bonds, joints, bonds without contact and pulls on a device: runs against the CPU's, and in two parts.

use crate::daughters::{bonds, founder};
use crate::device::{device, precisions};
use crate::implicit_bonds::{busy, hanging, inertial, overdamped, pendulum};
use crate::joints::{four_bar, hanging as jointed};
use crate::scenes::{agrees_on_device, in_two_parts, parse, run};
use relcp::record::state_hash;
use relcp::simulation::Compute;
use serde_json::{Value, json};

/// What a device's run may be off from the CPU's in f32 and f64, where nothing amplifies rounding.
const BOUNDS: [f64; 2] = [1e-4, 1e-7];

/// Each precision of the device.
fn computes() -> Vec<Compute> {
    let Some(gpu) = device() else { return Vec::new() };
    precisions(gpu).into_iter().map(|precision| Compute::Gpu { gpu: gpu.clone(), precision }).collect()
}

#[test]
fn implicit_bonds_and_joints_move_as_on_the_cpu() {
    for (name, of) in [
        ("a pendulum", pendulum(0.5, (0.01, 1.0))),
        ("a chain that hangs", hanging(&json!("rigid"), 1.001)),
        ("a linkage", four_bar(&overdamped(), (0.02, 1.0))),
        ("a linkage with inertia", four_bar(&inertial(), (0.02, 0.5))),
        ("rigid joints of all kinds", jointed(&inertial(), 7, false, (0.01, 20))),
        ("soft joints of all kinds", jointed(&overdamped(), 7, true, (0.01, 20))),
    ] {
        agrees_on_device(&parse(&of), name, BOUNDS);
    }
}

#[test]
fn bonds_break_and_bear_on_a_device_as_on_the_cpu_and_resume_to_the_same_bits() {
    let cases = [(overdamped(), true), (overdamped(), false), (inertial(), false)];
    for ((law, planar), rows) in cases.into_iter().flat_map(|case| ["auto", "paper"].map(|rows| (case.clone(), rows))) {
        let mut of = busy(&law, planar);
        of["contact"]["rows"] = json!(rows);
        let of = parse(&of);
        let cpu = run(of.clone(), &Compute::Cpu).bodies;
        for compute in computes() {
            let whole = run(of.clone(), &compute);
            assert_eq!(whole.bodies.broken_bonds, [2], "{law}");
            let pairs = || whole.bodies.bonds.iter().zip(&cpu.bonds);
            assert!(pairs().all(|(a, b)| a.number == b.number) && whole.bodies.bonds.len() == cpu.bonds.len());
            let off = pairs().map(|(a, b)| a.force.distance(b.force)).fold(0.0, f64::max);
            let most = cpu.bonds.iter().map(|bond| bond.force.length()).fold(0.0, f64::max);
            println!("{law} {planar} {rows}: tensions of up to {most:.3} within {off:.1e}");
            assert!(off < 0.05 * most, "{law} {planar}: {off:e} of {most:e}");
            let resumed = in_two_parts(&of, &compute);
            assert_eq!(state_hash(&resumed), state_hash(&whole), "{law} {planar}");
            assert_eq!(resumed.bodies.bonds, whole.bodies.bonds, "{law} {planar}");
        }
    }
    for (strength, broken) in [(1.001, &[][..]), (0.999, &[0, 1, 2, 3, 4])] {
        for compute in computes() {
            let of = parse(&hanging(&json!("rigid"), strength));
            assert_eq!(run(of, &compute).bodies.broken_bonds, broken, "{strength}");
        }
    }
}

fn ball(x: f64) -> Value {
    json!({"shape": {"sphere": {"radius": 0.5}}, "position": [x, 0, 0]})
}

#[test]
fn bodies_of_a_bond_without_contact_overlap_on_a_device_too() {
    let mut of = json!({"name": "in", "time": {"dt": 0.01, "end": 4.0}, "dynamics": {"overdamped": {"drag": 1.0}},
        "forces": [{"uniform": {"force": [-1, 0, 0]}}], "bodies": [ball(0.0), ball(0.6), ball(3.0)],
        "bonds": [{"bodies": [0, 1], "at": [[0, 0, 0], [0, 0, 0]], "stiffness": "rigid", "length": 0.6,
            "contact": false}]});
    of["bodies"][0]["fixed"] = json!(true);
    agrees_on_device(&parse(&of), "a bond without contact", BOUNDS);
    // An explicit one.
    of["bonds"][0]["stiffness"] = json!(10.0);
    of["time"]["end"] = json!(1.0);
    agrees_on_device(&parse(&of), "a spring without contact", BOUNDS);
}

#[test]
fn a_pull_draws_a_body_on_a_device_as_on_the_cpu() {
    let of = json!({"name": "drawn", "time": {"dt": 0.01, "end": 1.0}, "dynamics": {"overdamped": {"drag": 1.0}},
        "forces": [{"pull": {"body": 0, "target": [3, 1, 0], "stiffness": 4}},
            {"uniform": {"force": [-0.2, 0, 0]}}], "bodies": [ball(0.0), ball(1.1)]});
    agrees_on_device(&parse(&of), "a pull", BOUNDS);
    for compute in computes() {
        let [first, second] = [0, 1].map(|i| run(parse(&of), &compute).bodies.position[i]);
        assert!(first.x > 0.5 && first.distance(second) > 1.0 - 1e-5, "{first} {second}");
    }
}

/// Without turns at divisions the chain of cells is straight. In space four cells buckle by rounding.
#[test]
fn daughters_are_bonded_on_a_device_as_on_the_cpu() {
    for (planar, end, cells) in [(true, 2.6, 16), (false, 0.7, 2)] {
        for bond in [json!({"stiffness": "rigid"}), json!({"stiffness": 50, "bending": 0.3, "gap": 0.1})] {
            let mut of = founder(&bond, 0.0, planar);
            of["time"]["end"] = json!(end);
            let of = parse(&of);
            let cpu = run(of.clone(), &Compute::Cpu).bodies;
            assert!(cpu.len() == cells && bonds(&cpu).len() == cpu.len() - 1, "{bond}");
            agrees_on_device(&of, "a chain of cells", BOUNDS);
            for compute in computes() {
                let found = run(of.clone(), &compute).bodies;
                assert_eq!(bonds(&found), bonds(&cpu), "{bond} {planar}");
                let pairs = || found.bonds.iter().zip(&cpu.bonds);
                assert!(found.bonds.len() == cpu.bonds.len() && pairs().all(|(a, b)| a.bodies == b.bodies));
                let off = pairs().map(|(a, b)| a.force.distance(b.force)).fold(0.0, f64::max);
                let most = cpu.bonds.iter().map(|bond| bond.force.length()).fold(0.0, f64::max);
                println!("{bond} {planar}: tensions of up to {most:.3} within {off:.1e}");
                assert!(off < 0.05 * most + 1e-3, "{bond} {planar}: {off:e} of {most:e}");
            }
        }
    }
}

#[test]
fn bonds_of_daughters_break_on_a_device_and_resume_to_the_same_bits() {
    for (bond, holds) in [
        (json!({"stiffness": 50, "bending": 0.3, "gap": 0.1}), true),
        (json!({"stiffness": 1e4, "break_force": 1e-3}), false),
    ] {
        let of = parse(&founder(&bond, 8.0, true));
        for compute in computes() {
            let whole = run(of.clone(), &compute);
            let left = bonds(&whole.bodies).len();
            println!("{bond}: {left} of {} bonds", whole.bodies.len() - 1);
            assert!(if holds { left == 15 } else { left < 15 }, "{bond}: {left}");
            let resumed = in_two_parts(&of, &compute);
            assert_eq!(state_hash(&resumed), state_hash(&whole), "{bond}");
            assert_eq!(resumed.bodies.bonds, whole.bodies.bonds, "{bond}");
        }
    }
}
