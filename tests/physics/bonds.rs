//! Bonds against closed forms: a stretched pair, a pull that turns, breaking, and chains at a temperature.

use crate::scenes::{ALONG_X, agrees_on_device, parse, refusal, run};
use glam::DVec3;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};

const STIFFNESS: f64 = 6.0;
const DRAG: f64 = 1.5;

fn scene(dynamics: &Value, (dt, end): (f64, f64), bodies: &[Value], bonds: &[Value]) -> Value {
    json!({"name": "bonded", "time": {"dt": dt, "end": end}, "dynamics": dynamics, "bodies": bodies, "bonds": bonds})
}

fn ball(x: f64) -> Value {
    json!({"shape": {"sphere": {"radius": 0.5}}, "position": [x, 0, 0]})
}

fn overdamped() -> Value {
    json!({"overdamped": {"drag": DRAG}})
}

/// Two balls whose centres a bond of length 2 holds together, stretched to 3.
fn stretched(dynamics: &Value, dt: f64, stepping: &str) -> Value {
    let bond = json!({"bodies": [0, 1], "at": [[0, 0, 0], [0, 0, 0]], "stiffness": STIFFNESS, "length": 2});
    let mut scene = scene(dynamics, (dt, 0.5), &[ball(0.0), ball(3.0)], &[bond]);
    scene["time"]["stepping"] = json!(stepping);
    scene
}

/// The errors at `dt` and half of it of a scene against `exact` at its end.
fn errors(of: impl Fn(f64) -> Value, dt: f64, exact: f64) -> [f64; 2] {
    [dt, 0.5 * dt].map(|dt| {
        let end = run(parse(&of(dt)), &Compute::Cpu).bodies;
        assert!((end.position[0] + end.position[1] - 3.0 * DVec3::X).length() < 1e-12, "the middle stays");
        (end.position[1].distance(end.position[0]) - exact).abs()
    })
}

#[test]
fn a_stretched_pair_relaxes_by_the_closed_form_of_its_law() {
    let rate = 2.0 * STIFFNESS / DRAG;
    let mass = 2.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.125;
    let frequency = (2.0 * STIFFNESS / mass).sqrt();
    let laws = [
        (overdamped(), 2.0 + (-0.5 * rate).exp()),
        (json!({"inertial": {"density": 2}}), 2.0 + (0.5 * frequency).cos()),
    ];
    for (law, exact) in laws {
        for (stepping, order) in [("euler", 2.0), ("midpoint", 4.0)] {
            let [coarse, fine] = errors(|dt| stretched(&law, dt, stepping), 0.5 / 64.0, exact);
            println!("{law}, {stepping}: {coarse:.2e} at 64 steps, {:.2} times that at 128", coarse / fine);
            assert!((coarse / fine / order - 1.0).abs() < 0.1 && coarse < 2e-2, "{law} {stepping} {coarse:e} {fine:e}");
        }
    }
}

/// The pulls at both ends are opposite and act at the points: of a free pair no force and no torque is left.
#[test]
fn the_pulls_of_a_bond_cancel_with_their_torques() {
    let bodies = [
        json!({"shape": {"spherocylinder": {"diameter": 0.4, "length": 2}}, "position": [0.3, -1, 0.2], "axis": [1, 2, 3]}),
        json!({"shape": {"ellipsoid": {"radii": [0.3, 0.5, 0.9]}}, "position": [2, 1, -1], "axis": [-3, 1, 1]}),
    ];
    let bond = json!({"bodies": [0, 1], "at": [[0, 0.1, 1], [0.2, -0.1, -0.8]], "stiffness": STIFFNESS, "length": 0.3});
    let of = parse(&scene(&overdamped(), (0.01, 0.01), &bodies, &[bond]));
    let start = of.build().unwrap();
    let end = run(of, &Compute::Cpu).bodies;
    let (mut force, mut torque, mut largest) = (DVec3::ZERO, DVec3::ZERO, 0.0_f64);
    for i in 0..2 {
        let length = start.shape[i].major_axis();
        let (f, t) = (DRAG * length * end.velocity[i], DRAG * length.powi(3) / 12.0 * end.angular_velocity[i]);
        force += f;
        torque += start.position[i].cross(f) + t;
        largest = largest.max(t.length());
    }
    assert!(largest > 1.0, "the pull turns the bodies: {largest}");
    assert!(force.length() < 1e-12 && torque.length() < 1e-12, "{force} {torque}");
    let points = [DVec3::new(0.0, 0.1, 1.0), DVec3::new(0.2, -0.1, -0.8)];
    let [a, b] = [0, 1].map(|i| start.position[i] + start.orientation[i] * points[i]);
    let pull = STIFFNESS * (a.distance(b) - 0.3) * (b - a).normalize();
    assert!((DRAG * 2.0 * end.velocity[0] - pull).length() < 1e-12);
}

/// A ball on a fixed one, drawn by a force: the tension is `F (1 - e^(-k t / xi L))`, until it is over the strength.
fn drawn(strength: f64) -> Value {
    let mut anchor = ball(0.0);
    anchor["fixed"] = json!(true);
    let bond = json!({"bodies": [0, 1], "at": [[0, 0, 0], [0, 0, 0]], "stiffness": STIFFNESS, "length": 1.5,
        "break_force": strength});
    let mut scene = scene(&overdamped(), (1.0 / 512.0, 1.0), &[anchor, ball(1.5)], &[bond]);
    scene["forces"] = json!([{"uniform": {"force": [3, 0, 0]}}]);
    scene
}

#[test]
fn a_bond_breaks_when_its_tension_is_over_its_strength() {
    let of = parse(&drawn(2.0));
    let mut simulation = Simulation::new(of.clone()).unwrap();
    while simulation.state().unwrap().bodies.broken_bonds.is_empty() {
        simulation.step().unwrap();
    }
    let expected = -DRAG / STIFFNESS * f64::ln(1.0 - 2.0 / 3.0);
    println!("broken at {}, by the closed form {expected}", simulation.time());
    assert!((simulation.time() - expected).abs() < 3.0 / 512.0, "{}", simulation.time());
    let end = run(of, &Compute::Cpu).bodies;
    assert!((end.velocity[1] - DVec3::X * 3.0 / DRAG).length() < 1e-12, "it is free: {}", end.velocity[1]);
    assert_eq!(end.position[0], DVec3::ZERO);
    let held = run(parse(&drawn(3.5)), &Compute::Cpu).bodies;
    assert!(held.broken_bonds.is_empty() && (held.position[1].x - 2.0).abs() < 0.02, "{}", held.position[1]);
}

#[test]
fn a_pushed_bond_does_not_break() {
    let bond = json!({"bodies": [0, 1], "at": [[0, 0, 0], [0, 0, 0]], "stiffness": STIFFNESS, "length": 3,
        "break_force": 1});
    let end = run(parse(&scene(&overdamped(), (0.01, 0.5), &[ball(0.0), ball(1.0)], &[bond])), &Compute::Cpu).bodies;
    assert!(end.broken_bonds.is_empty() && end.position[1].x > 1.5);
}

#[test]
fn a_run_goes_on_from_its_final_scene_with_the_bonds_that_hold() {
    let mut of = drawn(2.0);
    of["bodies"].as_array_mut().unwrap().push(ball(6.0));
    let spare = json!({"bodies": [1, 2], "at": [[0, 0, 0], [0, 0, 0]], "stiffness": 1, "length": 4.5});
    of["bonds"].as_array_mut().unwrap().push(spare);
    let of = parse(&of);
    let end = run(of.clone(), &Compute::Cpu);
    assert_eq!(end.bodies.broken_bonds, [0]);
    let last = of.final_scene(&end.bodies, 1.0);
    assert_eq!(last.bonds, of.bonds[1..]);
    assert!(last.build().unwrap().broken_bonds.is_empty());
}

/// Chains of rods, tip to tip and apart from each other, each straight along x.
fn chains(count: usize, rods: usize, (dt, end): (f64, f64)) -> Value {
    let rod = |chain: usize, rod: usize| {
        json!({"shape": {"spherocylinder": {"diameter": 0.01, "length": 1}},
            "position": [rod as f64, 30 * (chain % 8), 30 * (chain / 8)], "orientation": ALONG_X})
    };
    let bodies: Vec<_> = (0..count * rods).map(|i| rod(i / rods, i % rods)).collect();
    let joint = |i: usize| json!({"bodies": [i, i + 1], "at": [[0, 0, 0.5], [0, 0, -0.5]], "stiffness": JOINT});
    let bonds: Vec<_> = (0..count * rods).filter(|i| (i + 1) % rods > 0).map(joint).collect();
    let mut scene = scene(&json!({"overdamped": {"drag": 1}}), (dt, end), &bodies, &bonds);
    (scene["thermal"], scene["seed"]) = (json!({"temperature": 1}), json!(7));
    scene
}

const JOINT: f64 = 50.0;

/// From straight chains at a temperature: `<R^2> = N b^2` of the freely jointed chain, and `3 kT / k` for each joint,
/// which is a spring. The slowest time of a chain of four is some 0.5. A chain's squares are averaged over time, and
/// the error is that of the means.
#[test]
fn chains_of_rods_have_the_end_to_end_distance_of_freely_jointed_ones() {
    const CHAINS: usize = 64;
    const RODS: usize = 4;
    let mut simulation = Simulation::new(parse(&chains(CHAINS, RODS, (1e-3, 5.0)))).unwrap();
    let (mut sums, mut samples) = ([0.0; CHAINS], 0.0);
    while !simulation.done() {
        assert!(simulation.step().unwrap().max_overlap <= 1e-5);
        if simulation.steps() < 1500 || !simulation.steps().is_multiple_of(100) {
            continue;
        }
        let bodies = &simulation.state().unwrap().bodies;
        let tip = |i: usize, side: f64| bodies.position[i] + bodies.orientation[i] * (0.5 * side * DVec3::Z);
        let squared = |chain: usize| (tip(RODS * (chain + 1) - 1, 1.0) - tip(RODS * chain, -1.0)).length_squared();
        samples += 1.0;
        sums.iter_mut().enumerate().for_each(|(chain, sum)| *sum += squared(chain));
    }
    let means = sums.map(|sum| sum / samples);
    let (n, expected) = (CHAINS as f64, RODS as f64 + 3.0 / JOINT * (RODS - 1) as f64);
    let mean = means.iter().sum::<f64>() / n;
    let error = (means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
    println!("<R^2> {mean:.3} +- {error:.3}, freely jointed {expected:.3}");
    assert!((mean - expected).abs() < 3.0 * error, "{mean} {error}");
}

/// A chain that folds on itself and tears beside a tether, in periodic space over the cell's border; some bonds break.
fn torn(dynamics: &Value, stepping: &str, planar: bool) -> Value {
    let rod = |x: f64, y: f64| json!({"shape": {"spherocylinder": {"diameter": 0.3, "length": 1.2}}, "position": [x, y, 0], "axis": [1, 0.2 * x, 0]});
    let mut bodies: Vec<_> = (0..5).map(|i| rod(1.3 * f64::from(i) - 2.5, 0.1 * f64::from(i))).collect();
    bodies[4]["group"] = json!("end");
    bodies.push(json!({"shape": {"sphere": {"radius": 0.4}}, "position": [-1, 2, 0], "fixed": true}));
    let joint = |i: usize| {
        json!({"bodies": [i, i + 1], "at": [[0, 0, 0.6], [0, 0, -0.6]], "stiffness": 20, "length": 0.1,
            "break_force": if i == 2 { 1.0 } else { 1e3 }})
    };
    let mut bonds: Vec<_> = (0..4).map(joint).collect();
    bonds.push(json!({"bodies": [5, 0], "at": [[0, 0, 0], [0, 0, 0]], "stiffness": 3, "length": 0.5}));
    let mut scene = scene(dynamics, (0.01, 0.3), &bodies, &bonds);
    scene["forces"] = json!([{"uniform": {"force": [6, 2, 0], "group": "end"}}]);
    (scene["planar"], scene["time"]["stepping"]) = (json!(planar), json!(stepping));
    scene["periodic"] = json!({"lengths": [8, null, null]});
    if stepping == "euler" && dynamics.get("overdamped").is_some() {
        scene["thermal"] = json!({"temperature": 0.01});
    }
    scene
}

#[test]
fn bonds_pull_and_break_on_a_device_as_on_the_cpu() {
    let inertial = json!({"inertial": {"density": 1}});
    let cases = [(overdamped(), "euler", false), (overdamped(), "midpoint", true), (inertial, "midpoint", false)];
    for (law, stepping, planar) in cases {
        let of = parse(&torn(&law, stepping, planar));
        let broken = run(of.clone(), &Compute::Cpu).bodies.broken_bonds;
        assert_eq!(broken, [2], "{law} {stepping}");
        agrees_on_device(&of, &format!("{law}, {stepping}, planar {planar}"), [1e-4, 1e-7]);
    }
}

/// Rods that are bonded end to end, in shear.
fn sheared_chain(dt: f64, stiffness: f64) -> Value {
    let shape = json!({"spherocylinder": {"diameter": 0.2, "length": 1.8}});
    let rod = |i: usize| json!({"shape": shape, "position": [2.2 * i as f64, 0, 0], "axis": [1, 0, 0]});
    let bond = |i: usize| json!({"bodies": [i, i + 1], "at": [[0, 0, 1], [0, 0, -1]], "stiffness": stiffness, "length": 0.2, "implicit": false});
    json!({"name": "chain", "time": {"dt": dt, "end": 4000.0 * dt}, "dynamics": {"overdamped": {"drag": 1}},
        "flow": {"shear": {"rate": 1, "direction": [1, 0, 0], "gradient": [0, 0, 1]}},
        "bodies": (0..5).map(rod).collect::<Vec<_>>(), "bonds": (0..4).map(bond).collect::<Vec<_>>()})
}

#[test]
fn an_explicit_chain_that_would_explode_is_refused_although_each_bond_alone_is_stable() {
    let (key, message) = refusal(&sheared_chain(0.01, 100.0));
    assert!(key.starts_with("bonds.") && key.ends_with(".stiffness"), "{key}");
    assert!(message.contains("together") && message.contains("unstable over"), "{message}");
    let longest: f64 = message.split("unstable over ").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
    // A little below what it names the chain holds together, however it turns and coils.
    let state = run(parse(&sheared_chain(0.98 * longest, 100.0)), &Compute::Cpu);
    for i in 0..4 {
        let apart = state.bodies.position[i].distance(state.bodies.position[i + 1]);
        assert!(apart < 2.6, "{i}: {apart}");
    }
}

#[test]
fn a_body_that_is_driven_away_without_end_is_a_fault() {
    let mut of = json!({"name": "away", "time": {"dt": 0.1, "end": 1e3}, "dynamics": {"inertial": {"density": 1}},
        "forces": [{"uniform": {"force": [1e6, 0, 0]}}],
        "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, 0]}]});
    let mut simulation = relcp::Simulation::new(parse(&of)).unwrap();
    let fault = loop {
        if let Err(fault) = simulation.step() {
            break fault;
        }
    };
    assert_eq!(fault.name(), "run_away");
    assert!(fault.to_string().contains("body 0 is 1.05e6 from where the scene starts"), "{fault}");
    of["time"]["end"] = json!(0.1);
    assert!(relcp::Simulation::new(parse(&of)).unwrap().step().is_ok());
}
