//! Implicit bonds against the closed forms of implicit Euler, pendulums, and balances; chains at any stiffness.

use crate::scenes::{in_two_parts, parse, refusal, run, watch};
use glam::DVec3;
use relcp::bodies::Bodies;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

const DRAG: f64 = 1.5;
const DENSITY: f64 = 2.0;
const GRAVITY: f64 = 10.0;

/// The mass of a ball of radius 0.5.
fn mass() -> f64 {
    DENSITY * PI / 6.0
}

pub fn overdamped() -> Value {
    json!({"overdamped": {"drag": DRAG}})
}

pub fn inertial() -> Value {
    json!({"inertial": {"density": DENSITY}})
}

fn ball(x: f64, y: f64, z: f64) -> Value {
    json!({"shape": {"sphere": {"radius": 0.5}}, "position": [x, y, z]})
}

fn fixed(mut body: Value) -> Value {
    body["fixed"] = json!(true);
    body
}

/// A bond between centres.
fn bond(bodies: [usize; 2], stiffness: &Value, length: f64) -> Value {
    json!({"bodies": bodies, "at": [[0, 0, 0], [0, 0, 0]], "stiffness": stiffness, "length": length, "implicit": true})
}

fn scene(dynamics: &Value, (dt, end): (f64, f64), bodies: &[Value], bonds: &[Value]) -> Value {
    json!({"name": "held", "time": {"dt": dt, "end": end}, "dynamics": dynamics, "bodies": bodies, "bonds": bonds,
        "solver": {"tolerance": 1e-9}})
}

fn pulled_down(mut scene: Value) -> Value {
    scene["forces"] = json!([{"gravity": {"acceleration": [0, 0, -GRAVITY]}}]);
    scene
}

fn apart(bodies: &Bodies) -> f64 {
    bodies.position[0].distance(bodies.position[1])
}

/// A pair that is stretched by 1, by implicit Euler: its stretch after each of `steps`.
fn by_closed_form(law: &Value, stiffness: f64, dt: f64, steps: usize) -> Vec<f64> {
    let (mut stretch, mut speed) = (1.0, 0.0);
    let step = |_| {
        if law.get("inertial").is_some() {
            let pull = 2.0 * stiffness / mass();
            speed = (speed - dt * pull * stretch) / (1.0 + dt * dt * pull);
            stretch += dt * speed;
        } else {
            stretch /= 1.0 + 2.0 * stiffness / DRAG * dt;
        }
        stretch
    };
    (0..steps).map(step).collect()
}

#[test]
fn a_stretched_pair_relaxes_as_implicit_euler_says_at_any_stiffness() {
    for law in [overdamped(), inertial()] {
        for dt in [1e-3, 1e-2, 1e-1] {
            for stiffness in [1e1, 1e3, 1e5, 1e7, 1e9] {
                let bonds = [bond([0, 1], &json!(stiffness), 2.0)];
                let of = scene(&law, (dt, 10.0 * dt), &[ball(0.0, 0.0, 0.0), ball(3.0, 0.0, 0.0)], &bonds);
                let mut found = Vec::new();
                watch(&of, |bodies| found.push(apart(bodies) - 2.0));
                let expected = by_closed_form(&law, stiffness, dt, 10);
                for (found, expected) in found[1..].iter().zip(&expected) {
                    assert!((found - expected).abs() < 1e-8, "{law} {dt} {stiffness}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn a_rigid_pair_has_its_length_after_one_step() {
    for law in [overdamped(), inertial()] {
        let bonds = [bond([0, 1], &json!("rigid"), 2.0)];
        let of = scene(&law, (0.1, 0.5), &[ball(0.0, 0.0, 0.0), ball(3.0, 0.0, 0.0)], &bonds);
        let end = watch(&of, |_| {}).state().unwrap().bodies.clone();
        assert!((apart(&end) - 2.0).abs() < 1e-8, "{}", apart(&end));
        // A start that is off is put right in no time: it does not become speed.
        assert!(end.velocity.iter().all(|v| v.length() < 1e-6), "{:?}", end.velocity);
    }
}

/// `exp` and `cos` are what the closed forms of implicit Euler tend to, to first order.
#[test]
fn relaxation_is_of_first_order_in_dt() {
    let (stiffness, end) = (6.0, 0.5);
    let exact = [(-2.0 * stiffness / DRAG * end).exp(), ((2.0 * stiffness / mass()).sqrt() * end).cos()];
    for (law, exact) in [overdamped(), inertial()].into_iter().zip(exact) {
        let error = |steps: f64| {
            let bonds = [bond([0, 1], &json!(stiffness), 2.0)];
            let of = scene(&law, (end / steps, end), &[ball(0.0, 0.0, 0.0), ball(3.0, 0.0, 0.0)], &bonds);
            (apart(&run(parse(&of), &Compute::Cpu).bodies) - 2.0 - exact).abs()
        };
        let (coarse, fine) = (error(256.0), error(512.0));
        println!("{law}: {coarse:.2e} at 256 steps, {:.2} times that at 512", coarse / fine);
        assert!((coarse / fine - 2.0).abs() < 0.1, "{law} {coarse:e} {fine:e}");
    }
}

/// The energy of balls.
fn energy(bodies: &Bodies) -> f64 {
    let of = |(v, x): (&DVec3, &DVec3)| mass() * (0.5 * v.length_squared() + GRAVITY * x.z);
    bodies.velocity.iter().zip(&bodies.position).map(of).sum()
}

/// A ball on a rigid bond of length 2, from this angle.
pub fn pendulum(angle: f64, (dt, end): (f64, f64)) -> Value {
    let hung = ball(2.0 * angle.sin(), 0.0, -2.0 * angle.cos());
    let bonds = [bond([0, 1], &json!("rigid"), 2.0)];
    pulled_down(scene(&inertial(), (dt, end), &[fixed(ball(0.0, 0.0, 0.0)), hung], &bonds))
}

/// By implicit Euler a small swing has the factor `1 / (1 - i w dt)` a step: the period is right to second order, the
/// amplitude falls by `(1 + (w dt)^2)^-1/2`.
#[test]
fn a_rigid_pendulum_swings_with_the_period_of_implicit_euler_and_keeps_its_length() {
    let frequency = (GRAVITY / 2.0_f64).sqrt();
    for dt in [0.02, 0.01] {
        let (mut time, mut before, mut crossings, mut lowest) = (0.0, (0.0, 0.1), Vec::new(), 0.0_f64);
        watch(&pendulum(0.1, (dt, 6.0)), |bodies| {
            let d = bodies.position[1];
            assert!((d.length() - 2.0).abs() <= 1e-5, "{}", d.length());
            let angle = d.x.atan2(-d.z);
            if before.1 * angle < 0.0 {
                crossings.push(before.0 + (time - before.0) * before.1 / (before.1 - angle));
            }
            if crossings.len() == 1 {
                lowest = lowest.min(angle);
            }
            before = (time, angle);
            time += dt;
        });
        let period = 2.0 * (crossings[2] - crossings[0]) / 2.0;
        let expected = TAU / ((frequency * dt).atan() / dt);
        // The first turn comes after half a period.
        let left = 0.1 * (1.0 + (frequency * dt).powi(2)).powf(-0.5 * (0.5 * expected / dt));
        println!("dt {dt}: period {period:.5}, {expected:.5} expected; amplitude {:.5}, {left:.5}", -lowest);
        assert!((period / expected - 1.0).abs() < 2e-3, "{period} {expected}");
        assert!((-lowest / left - 1.0).abs() < 1e-2, "{lowest} {left}");
    }
}

#[test]
fn the_energy_of_rigid_pendulums_never_rises() {
    for (angle, dt) in [(1.5, 0.01), (1.5, 0.05), (3.0, 0.02)] {
        let mut before = f64::INFINITY;
        watch(&pendulum(angle, (dt, 2.0)), |bodies| {
            let now = energy(bodies);
            assert!(now <= before + 1e-4, "{angle} {dt}: {before} {now}");
            before = now;
        });
    }
}

/// A rod on a rigid bond of length 0, a ball joint, at its tip: the period of a physical pendulum.
#[test]
fn a_rod_on_a_ball_joint_swings_as_a_physical_pendulum() {
    let angle = 0.1_f64;
    let (reach, dt) = (1.0, 0.005);
    let along = DVec3::new(angle.sin(), 0.0, -angle.cos());
    let rod = json!({"shape": {"spherocylinder": {"diameter": 0.2, "length": 2.0 * reach}},
        "position": (reach * along).to_array(), "axis": along.to_array()});
    let hook = fixed(json!({"shape": {"sphere": {"radius": 0.05}}, "position": [0, 5, 0]}));
    let joint = json!({"bodies": [0, 1], "at": [[0, -5, 0], [0, 0, -reach]], "stiffness": "rigid"});
    let of = pulled_down(scene(&inertial(), (dt, 3.0), &[hook, rod], &[joint]));
    let shape = parse(&of).build().unwrap().shape[1];
    let inertia = shape.unit_inertia().x / shape.volume() + reach * reach;
    let frequency = (GRAVITY * reach / inertia).sqrt();
    let (mut time, mut before, mut crossings) = (0.0, (0.0, angle), Vec::new());
    watch(&of, |bodies| {
        let tip = bodies.position[1] - reach * (bodies.orientation[1] * DVec3::Z);
        assert!(tip.length() <= 3e-5, "{tip}");
        let now = bodies.position[1].x.atan2(-bodies.position[1].z);
        if before.1 * now < 0.0 {
            crossings.push(before.0 + (time - before.0) * before.1 / (before.1 - now));
        }
        before = (time, now);
        time += dt;
    });
    let period = 2.0 * (crossings[1] - crossings[0]);
    println!("period {period:.5}, {:.5} expected", TAU / frequency);
    assert!((period * frequency / TAU - 1.0).abs() < 3e-3, "{period}");
}

/// Balls of weight 1 under each other, each bond as strong as `strength` times the weight that it bears.
pub fn hanging(stiffness: &Value, strength: f64) -> Value {
    const BALLS: usize = 5;
    let mut bodies = vec![fixed(ball(0.0, 0.0, 0.0))];
    bodies.extend((1..=BALLS).map(|i| ball(0.0, 0.0, -1.5 * i as f64)));
    let bonds = (0..BALLS).map(|i| {
        let mut bond = bond([i, i + 1], stiffness, 1.5);
        bond["break_force"] = json!(strength * (BALLS - i) as f64);
        bond
    });
    let mut scene = scene(&overdamped(), (0.1, 2.0), &bodies, &bonds.collect::<Vec<_>>());
    scene["forces"] = json!([{"uniform": {"force": [0, 0, -1]}}]);
    scene
}

#[test]
fn the_bonds_of_a_hanging_chain_bear_the_weight_below_them() {
    for stiffness in [json!(1e7), json!("rigid")] {
        assert_eq!(run(parse(&hanging(&stiffness, 1.001)), &Compute::Cpu).bodies.broken_bonds, [] as [u32; 0]);
        let broken = run(parse(&hanging(&stiffness, 0.999)), &Compute::Cpu).bodies.broken_bonds;
        assert_eq!(broken, [0, 1, 2, 3, 4], "{stiffness}");
        // Only the bond that is too weak.
        let mut of = hanging(&stiffness, 1.001);
        of["bonds"][2]["break_force"] = json!(2.999);
        assert_eq!(run(parse(&of), &Compute::Cpu).bodies.broken_bonds, [2], "{stiffness}");
    }
}

/// A zigzag of balls, one end held, under gravity.
fn zigzag(law: &Value, balls: usize, stiffness: &Value, (dt, steps): (f64, f64)) -> Value {
    let mut bodies: Vec<_> = (0..balls).map(|i| ball(1.2 * i as f64, 0.0, 0.5 * (i % 2) as f64)).collect();
    bodies[0] = fixed(bodies[0].take());
    let bonds: Vec<_> = (1..balls).map(|i| bond([i - 1, i], stiffness, 1.3)).collect();
    let mut scene = scene(law, (dt, steps * dt), &bodies, &bonds);
    scene["solver"] = json!({});
    scene["forces"] = json!([{"uniform": {"force": [0, 0, -WEIGHT]}}]);
    scene
}

const WEIGHT: f64 = 10.0;

/// `RELCP_CHAIN_BALLS=500` takes longer chains.
#[test]
fn chains_of_fifty_do_not_explode_at_any_stiffness_and_step() {
    let balls = std::env::var("RELCP_CHAIN_BALLS").map_or(50, |balls| balls.parse().unwrap());
    let bonds = balls as f64 - 1.0;
    for law in [overdamped(), inertial()] {
        for dt in [1e-3, 1e-2, 1e-1] {
            for stiffness in [json!(1e1), json!(1e3), json!(1e6), json!(1e9), json!("rigid")] {
                let of = zigzag(&law, balls, &stiffness, (dt, 10.0));
                // Some times what all weights together stretch a bond by.
                let most = 4.0 * bonds * WEIGHT / stiffness.as_f64().unwrap_or(f64::INFINITY) + 2e-5;
                let mut farthest = 0.0_f64;
                let mut stretched = 0.0_f64;
                let simulation = watch(&of, |bodies| {
                    for pair in bodies.position.windows(2) {
                        stretched = stretched.max(pair[0].distance(pair[1]) - 1.3);
                    }
                    farthest = bodies.position.iter().fold(farthest, |far, x| far.max(x.length()));
                });
                println!("{law} {dt} {stiffness}: stretched by {stretched:.2e}, steps {}", simulation.steps());
                assert!(stretched <= most, "{law} {dt} {stiffness}: {stretched} {most}");
                assert!(farthest <= bonds * (1.3 + most) + 1e-3, "{law} {dt} {stiffness}: {farthest}");
            }
        }
    }
}

/// The energy of a zigzag's balls and bonds.
fn energy_of_chain(bodies: &Bodies, stiffness: Option<f64>) -> f64 {
    let of = |(v, x): (&DVec3, &DVec3)| 0.5 * mass() * v.length_squared() + WEIGHT * x.z;
    let stretch = |pair: &[DVec3]| pair[0].distance(pair[1]) - 1.3;
    let springs = bodies.position.windows(2).map(|pair| 0.5 * stiffness.unwrap_or(0.0) * stretch(pair).powi(2));
    bodies.velocity.iter().zip(&bodies.position).map(of).sum::<f64>() + springs.sum::<f64>()
}

#[test]
fn the_energy_of_a_falling_chain_never_rises() {
    for (stiffness, dt) in [(json!("rigid"), 0.02), (json!("rigid"), 0.1), (json!(1e5), 0.02), (json!(1e3), 0.05)] {
        let (mut before, mut rise) = (f64::INFINITY, 0.0_f64);
        watch(&zigzag(&inertial(), 20, &stiffness, (dt, 40.0)), |bodies| {
            let now = energy_of_chain(bodies, stiffness.as_f64());
            rise = rise.max(now - before);
            before = now;
        });
        println!("{stiffness} {dt}: largest rise {rise:.1e}");
        // What the tolerance of 1e-5 in each bond's length leaves to the tensions, up to 200.
        assert!(rise <= 5e-3, "{stiffness} {dt}: {rise:e}");
    }
}

/// Rods with ball joints from tip to tip, the first fixed, from the horizontal.
fn jointed(law: &Value, rods: usize, (dt, steps): (f64, f64)) -> Value {
    let rod = |i: usize| json!({"shape": {"spherocylinder": {"diameter": 0.2, "length": 1.0}}, "position": [1.2 * i as f64, 0, 0], "axis": [1, 0, 0]});
    let mut bodies: Vec<_> = (0..rods).map(rod).collect();
    bodies[0] = fixed(bodies[0].take());
    let joint = |i: usize| json!({"bodies": [i, i + 1], "at": [[0, 0, 0.6], [0, 0, -0.6]], "stiffness": "rigid"});
    let bonds: Vec<_> = (0..rods - 1).map(joint).collect();
    let mut scene = scene(law, (dt, steps * dt), &bodies, &bonds);
    scene["solver"] = json!({});
    scene["forces"] = json!([{"uniform": {"force": [0, 0, -1]}}]);
    scene
}

/// Each joint's pull turns with its rods: without the stiffness of this, making rows anew would not converge.
#[test]
fn rods_on_ball_joints_hold_together_in_long_steps_that_are_taken_whole() {
    for law in [overdamped(), inertial()] {
        let mut simulation = Simulation::new(parse(&jointed(&law, 20, (0.05, 20.0)))).unwrap();
        let mut most = 0;
        while !simulation.done() {
            let report = simulation.step().unwrap();
            most = most.max(report.recursions);
            assert!(report.pieces == 1 && report.recursions <= 20, "{law}: {report:?}");
            let bodies = &simulation.state().unwrap().bodies;
            let tip = |i: usize, side: f64| bodies.position[i] + bodies.orientation[i] * (0.6 * side * DVec3::Z);
            for i in 0..19 {
                let gap = tip(i, 1.0).distance(tip(i + 1, -1.0));
                assert!(gap <= 2e-5, "{law} {i}: {gap}");
            }
        }
        println!("{law}: at most {most} recursions");
    }
}

#[test]
fn a_bond_that_is_too_short_presses_its_bodies_against_each_other() {
    for law in [overdamped(), inertial()] {
        let bonds = [bond([0, 1], &json!(100.0), 0.8)];
        let of = scene(&law, (0.05, 2.0), &[ball(0.0, 0.0, 0.0), ball(1.5, 0.0, 0.0)], &bonds);
        let state = watch(&of, |bodies| assert!(apart(bodies) >= 1.0 - 1e-5)).state().unwrap().clone();
        assert!((apart(&state.bodies) - 1.0).abs() < 1e-5, "{}", apart(&state.bodies));
        let push: f64 = state.warm.iter().map(|w| w.gamma).sum();
        assert!(state.warm.len() == 1 && (push - 20.0).abs() < 1e-2, "{law}: {push}");
    }
}

#[test]
fn a_rigid_bond_without_room_for_its_bodies_ends_the_run_and_throws_nothing() {
    let bonds = [bond([0, 1], &json!("rigid"), 0.8)];
    let of = scene(&overdamped(), (0.05, 0.5), &[ball(0.0, 0.0, 0.0), ball(1.5, 0.0, 0.0)], &bonds);
    let mut simulation = Simulation::new(parse(&of)).unwrap();
    let fault = simulation.step().unwrap_err();
    assert!(["bond", "overlap"].contains(&fault.name()), "{fault}");
    assert_eq!(apart(&simulation.state().unwrap().bodies), 1.5, "the state before the step stays");
}

/// A chain with joints, a tether and a crowd, some of which breaks.
pub fn busy(law: &Value, planar: bool) -> Value {
    let rod = |x: f64, y: f64| json!({"shape": {"spherocylinder": {"diameter": 0.3, "length": 1.2}}, "position": [x, y, 0], "axis": [1, 0.2 * x, 0]});
    let mut bodies: Vec<_> = (0..5).map(|i| rod(1.3 * f64::from(i) - 2.5, 0.1 * f64::from(i))).collect();
    bodies.push(fixed(json!({"shape": {"sphere": {"radius": 0.4}}, "position": [-1, 2, 0]})));
    bodies.push(json!({"shape": {"sphere": {"radius": 0.4}}, "position": [0, 0.7, 0]}));
    let joint = |i: usize| {
        json!({"bodies": [i, i + 1], "at": [[0, 0, 0.65], [0, 0, -0.65]], "stiffness": 1e6, "implicit": true,
            "break_force": if i == 2 { 0.5 } else { 1e6 }})
    };
    let mut bonds: Vec<_> = (0..4).map(joint).collect();
    bonds.push(bond([5, 0], &json!("rigid"), 2.5));
    let mut scene = scene(law, (0.01, 0.3), &bodies, &bonds);
    scene["forces"] = json!([{"uniform": {"force": [1, -1, 0]}}]);
    (scene["planar"], scene["contact"]) = (json!(planar), json!({"friction": if planar { 0.0 } else { 0.3 }}));
    scene["periodic"] = json!({"lengths": [8, null, null]});
    scene
}

#[test]
fn runs_with_implicit_bonds_resume_to_the_same_bits() {
    for (law, planar) in [(overdamped(), true), (overdamped(), false), (inertial(), false)] {
        let of = parse(&busy(&law, planar));
        let whole = run(of.clone(), &Compute::Cpu);
        assert_eq!(whole.bodies.broken_bonds, [2], "{law}");
        assert!(in_two_parts(&of, &Compute::Cpu) == whole, "{law} {planar}");
    }
}

/// A dumbbell that spins and flies keeps its momentum.
#[test]
fn bonds_keep_the_momentum() {
    let thrown = |mut body: Value, v: [f64; 3]| {
        body["velocity"] = json!(v);
        body
    };
    let bodies = [thrown(ball(0.0, 0.0, 0.0), [1.0, 2.0, 0.0]), thrown(ball(2.0, 0.0, 0.0), [1.0, -2.0, 0.5])];
    let of = scene(&inertial(), (0.01, 1.0), &bodies, &[bond([0, 1], &json!("rigid"), 2.0)]);
    watch(&of, |bodies| {
        let sum = bodies.velocity[0] + bodies.velocity[1];
        assert!(sum.distance(DVec3::new(2.0, 0.0, 0.5)) < 1e-12, "{sum}");
        assert!((apart(bodies) - 2.0).abs() <= 1e-5);
    });
}

#[test]
fn bonds_are_implicit_where_explicit_ones_would_explode_or_where_a_scene_says_so() {
    let of = |stiffness: f64| {
        let mut bond = bond([0, 1], &json!(stiffness), 2.0);
        bond.as_object_mut().unwrap().remove("implicit");
        scene(&overdamped(), (0.1, 0.1), &[ball(0.0, 0.0, 0.0), ball(3.0, 0.0, 0.0)], &[bond])
    };
    // The explicit limit is k dt 2 / xi = 2.
    let stretch = |of: &Value| apart(&run(parse(of), &Compute::Cpu).bodies) - 2.0;
    assert!((stretch(&of(14.0)) - (1.0 - 0.1 * 28.0 / DRAG)).abs() < 1e-12, "explicit");
    assert!((stretch(&of(16.0)) - 1.0 / (1.0 + 0.1 * 32.0 / DRAG)).abs() < 1e-9, "implicit");
    let mut told = of(14.0);
    told["bonds"][0]["implicit"] = json!(true);
    assert!((stretch(&told) - 1.0 / (1.0 + 0.1 * 28.0 / DRAG)).abs() < 1e-9, "implicit");
    let mut refused = of(16.0);
    refused["bonds"][0]["implicit"] = json!(false);
    assert_eq!(refusal(&refused).0, "bonds.0.stiffness");
    let mut midpoint = of(16.0);
    midpoint["time"]["stepping"] = json!("midpoint");
    let (key, message) = refusal(&midpoint);
    assert!(key == "bonds.0.stiffness" && message.contains("time.stepping"), "{message}");
}

#[test]
fn what_does_not_support_implicit_bonds_is_refused_with_its_key() {
    let base = || pendulum(0.1, (0.01, 0.1));
    let edits: [(&str, &str, Value); 4] = [
        ("time", "stepping", json!("midpoint")),
        ("solver", "kind", json!("bbpgd")),
        ("contact", "on_failure", json!("continue")),
        ("solver", "dump", json!({"when": "unconverged"})),
    ];
    for (outer, inner, value) in edits {
        let mut of = base();
        of[outer][inner] = value;
        let (key, message) = refusal(&of);
        assert_eq!(key, format!("{outer}.{inner}"), "{message}");
        assert!(
            message.contains("implicit bonds (bonds[0])") || message.contains("implicit bonds (bonds.0)"),
            "{message}"
        );
    }
    let mut of = base();
    of["bonds"][0]["implicit"] = json!(false);
    assert_eq!(refusal(&of).0, "bonds.0.implicit");
    let mut of = base();
    of["bonds"][0]["stiffness"] = json!("stiff");
    assert!(refusal(&of).1.contains("rigid"), "{}", refusal(&of).1);
    let scene = parse(&base());
    let written = serde_json::to_string(&scene).unwrap();
    assert!(written.contains("\"stiffness\":\"rigid\""), "{written}");
    assert_eq!(Scene::parse(&written, "again").unwrap().bonds, scene.bonds);
}
