//! The bending stiffness of bonds against closed forms: implicit Euler, cantilevers, buckling, angles in heat.

use crate::scenes::{in_two_parts, parse, refusal, run, watch};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};
use std::f64::consts::PI;

const DRAG: f64 = 1.5;
const DENSITY: f64 = 2.0;
/// A ball's resistance to turning, and its moment of inertia, at the radius 0.5.
const TURNING: f64 = DRAG / 12.0;

fn inertia() -> f64 {
    0.4 * DENSITY * PI / 6.0 * 0.25
}

fn overdamped() -> Value {
    json!({"overdamped": {"drag": DRAG}})
}

fn inertial() -> Value {
    json!({"inertial": {"density": DENSITY}})
}

/// A ball at the end of an arm of a fixed one, turned by `angle` about `axis`; the bond holds its centre, so that only
/// its turn is free.
fn turned(law: &Value, (axis, angle): (DVec3, f64), stiffness: &Value, (dt, end): (f64, f64)) -> Value {
    let q = DQuat::from_axis_angle(axis, angle);
    let bond = json!({"bodies": [0, 1], "at": [[1.2, 0, 0], [0, 0, 0]], "stiffness": "rigid",
        "bending": {"stiffness": stiffness, "axes": [[1, 0, 0], [2, 0, 0]]}});
    json!({"name": "bent", "time": {"dt": dt, "end": end}, "dynamics": law, "bonds": [bond],
        "contact": {"overlap_tolerance": 1e-9}, "solver": {"tolerance": 1e-11},
        "bodies": [{"shape": {"sphere": {"radius": 0.5}}, "position": [0, 0, 0], "fixed": true},
            {"shape": {"sphere": {"radius": 0.5}}, "position": [1.2, 0, 0], "orientation": [q.w, q.x, q.y, q.z]}]})
}

/// The angle of its bond.
fn bend_of(bodies: &Bodies) -> f64 {
    let along = bodies.orientation[1] * DVec3::X;
    along.cross(DVec3::X).length().atan2(along.x)
}

/// Implicit Euler of the angle, in steps that turn by `2 atan(w dt / 2)`, by the virtual work of the torque on the
/// velocity of the step.
fn by_closed_form(law: &Value, mut angle: f64, stiffness: f64, dt: f64, steps: usize) -> Vec<f64> {
    let mut speed = 0.0;
    let step = |_| {
        let (kept, pull) = if law.get("inertial").is_some() {
            (speed, dt * stiffness / inertia())
        } else {
            (0.0, stiffness / TURNING)
        };
        // w = kept - pull t / (1 + (w dt / 2)^2) with the angle t at the end, between -0.8 and 0.8.
        let bound = |end: f64| 2.0 * (0.5 * (end - angle)).tan() / dt;
        let (mut low, mut high) = (bound(-0.8), bound(0.8));
        for _ in 0..200 {
            let w: f64 = 0.5 * (low + high);
            let half = 0.5 * w * dt;
            if w < kept - pull * (angle + 2.0 * half.atan()) / (1.0 + half * half) { low = w } else { high = w }
        }
        speed = 0.5 * (low + high);
        angle += 2.0 * (0.5 * speed * dt).atan();
        angle
    };
    (0..steps).map(step).collect()
}

#[test]
fn a_bent_pair_straightens_as_implicit_euler_says_at_any_stiffness() {
    for law in [overdamped(), inertial()] {
        for axis in [DVec3::Z, DVec3::new(0.0, 1.0, -2.0).normalize()] {
            for (dt, stiffness) in [(1e-3, 0.1), (1e-2, 10.0), (0.1, 1e3), (0.1, 1e6), (1e-2, 1e9)] {
                let of = turned(&law, (axis, 0.8), &json!(stiffness), (dt, 10.0 * dt));
                let mut found = Vec::new();
                watch(&of, |bodies| found.push(bend_of(bodies)));
                for (found, expected) in found[1..].iter().zip(by_closed_form(&law, 0.8, stiffness, dt, 10)) {
                    let error = (found - expected.abs()).abs();
                    assert!(error < 1e-7, "{law} {dt} {stiffness}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn a_bond_that_is_rigid_against_bends_is_straight_after_one_step_and_keeps_its_twist_free() {
    for law in [overdamped(), inertial()] {
        let mut of = turned(&law, (DVec3::Y, 0.8), &json!("rigid"), (0.1, 0.5));
        of["forces"] = json!([{"torque": {"torque": [0.01, 0.02, 0.03], "frame": "space"}}]);
        let mut steps = 0;
        let end = watch(&of, |bodies| {
            assert!(steps == 0 || bend_of(bodies) < 1e-8, "{law}: {}", bend_of(bodies));
            steps += 1;
        });
        let end = end.state().unwrap().bodies.clone();
        // Only the torque along the axis turns it.
        let twist = (end.orientation[1] * DVec3::Y).dot(DVec3::Z);
        assert!(twist > 1e-3, "{law}: {twist}");
    }
}

/// `exp` and `cos` are what the closed forms tend to, to first order.
#[test]
fn straightening_is_of_first_order_in_dt() {
    let (stiffness, end) = (0.2, 0.5);
    let exact = [0.5 * (-stiffness / TURNING * end).exp(), 0.5 * ((stiffness / inertia()).sqrt() * end).cos()];
    for (law, exact) in [overdamped(), inertial()].into_iter().zip(exact) {
        let error = |steps: f64| {
            let of = turned(&law, (DVec3::Z, 0.5), &json!(stiffness), (end / steps, end));
            (bend_of(&run(parse(&of), &Compute::Cpu).bodies) - exact.abs()).abs()
        };
        let (coarse, fine) = (error(128.0), error(256.0));
        println!("{law}: {coarse:.2e} at 128 steps, {:.2} times that at 256", coarse / fine);
        assert!((coarse / fine - 2.0).abs() < 0.1, "{law} {coarse:e} {fine:e}");
    }
}

/// Two free bodies, bent and thrown: what they have together stays.
#[test]
fn bends_keep_the_momentum_and_the_angular_momentum_falls_little() {
    let q = DQuat::from_rotation_y(0.9) * DQuat::from_rotation_x(0.4);
    let body = |x: f64, q: DQuat, v: [f64; 3]| json!({"shape": {"sphere": {"radius": 0.5}}, "position": [x, 0, 0], "orientation": [q.w, q.x, q.y, q.z], "velocity": v});
    let bond = json!({"bodies": [0, 1], "at": [[0.7, 0, 0], [-0.7, 0, 0]], "stiffness": 200.0, "bending": 3.0, "implicit": true});
    let tip = DVec3::new(0.7, 0.0, 0.0);
    let centre = tip + q * tip;
    let mut second = body(0.0, q, [0.0, -0.3, 0.2]);
    second["position"] = json!(centre.to_array());
    let of = json!({"name": "thrown", "time": {"dt": 0.002, "end": 1.0}, "dynamics": inertial(), "bonds": [bond],
        "bodies": [body(0.0, DQuat::IDENTITY, [0.1, 0.3, 0.0]), second]});
    let momenta = |bodies: &Bodies| {
        let mass = DENSITY * PI / 6.0;
        let spin =
            |i: usize| mass * bodies.position[i].cross(bodies.velocity[i]) + inertia() * bodies.angular_velocity[i];
        (mass * (bodies.velocity[0] + bodies.velocity[1]), spin(0) + spin(1))
    };
    let mut first = None;
    let mut off = 0.0_f64;
    watch(&of, |bodies| {
        let (momentum, spin) = momenta(bodies);
        let (momentum_then, spin_then) = *first.get_or_insert((momentum, spin));
        assert!(momentum.distance(momentum_then) < 1e-12, "{momentum}");
        off = off.max(spin.distance(spin_then));
    });
    println!("angular momentum off by {off:.1e} of {}", first.unwrap().1.length());
    assert!(off < 0.02 * first.unwrap().1.length(), "{off}");
}

/// Links of length 1 in a line from a fixed one, with these directions; the last is in the group `loaded`.
fn chain(directions: &[f64], bending: &Value, (dt, steps): (f64, usize)) -> Value {
    let body = |position: [f64; 2], angle: f64| {
        json!({"shape": {"sphere": {"radius": 0.3}}, "position": [position[0], position[1], 0],
            "orientation": [(0.5 * angle).cos(), 0, 0, (0.5 * angle).sin()]})
    };
    let mut bodies = vec![body([-0.5, 0.0], 0.0)];
    bodies[0]["fixed"] = json!(true);
    let mut tip = [0.0, 0.0];
    for angle in directions {
        let half = [0.5 * angle.cos(), 0.5 * angle.sin()];
        bodies.push(body([tip[0] + half[0], tip[1] + half[1]], *angle));
        tip = [tip[0] + 2.0 * half[0], tip[1] + 2.0 * half[1]];
    }
    bodies[directions.len()]["group"] = json!("loaded");
    let bond = |i: usize| json!({"bodies": [i, i + 1], "at": [[0.5, 0, 0], [-0.5, 0, 0]], "stiffness": "rigid", "bending": bending});
    json!({"name": "beam", "planar": true, "time": {"dt": dt, "end": dt * steps as f64}, "dynamics": overdamped(),
        "bodies": bodies, "bonds": (0..directions.len()).map(bond).collect::<Vec<_>>(),
        "contact": {"overlap_tolerance": 1e-8}, "solver": {"tolerance": 1e-10}})
}

fn direction(bodies: &Bodies, i: usize) -> f64 {
    let along = bodies.orientation[i] * DVec3::X;
    along.y.atan2(along.x)
}

/// A force on the centre of the last of `n` links across a chain: its links bend by `F (n - i + 1/2) / B` one after
/// another.
#[test]
fn a_clamped_chain_bends_under_an_end_force_as_a_discrete_cantilever() {
    let (n, stiffness, force) = (8, 3.0, 1e-4);
    for planar in [true, false] {
        let mut of = chain(&vec![0.0; n], &json!(stiffness), (1e4, 10));
        of["planar"] = json!(planar);
        of["forces"] = json!([{"uniform": {"force": [0, force, 0], "group": "loaded"}}]);
        let end = run(parse(&of), &Compute::Cpu).bodies;
        let mut expected = 0.0;
        let mut deflection = 0.0;
        for i in 1..=n {
            expected += force * ((n - i) as f64 + 0.5) / stiffness;
            deflection += if i < n { expected } else { 0.5 * expected };
            let found = direction(&end, i);
            assert!((found / expected - 1.0).abs() < 1e-3, "{planar} {i}: {found} {expected}");
        }
        let found = end.position[n].y;
        println!("planar {planar}: deflection {found:.6e}, {deflection:.6e} expected");
        assert!((found / deflection - 1.0).abs() < 1e-3, "{found} {deflection}");
    }
}

/// The load at which a clamped chain of `n` links buckles that is pressed at the centre of its last link:
/// `4 B sin^2(pi / 4 n)`, with directions as `sin(pi i / 2 n)`.
fn buckling_load(n: usize, stiffness: f64) -> f64 {
    4.0 * stiffness * (PI / (4 * n) as f64).sin().powi(2)
}

/// The rate at which a chain with this shape moves aside under a load.
fn rate_of_growth(n: usize, stiffness: f64, load: f64, dt: f64) -> f64 {
    let directions: Vec<f64> = (1..=n).map(|i| 1e-3 * (0.5 * PI * i as f64 / n as f64).sin()).collect();
    let mut of = chain(&directions, &json!(stiffness), (dt, 20));
    of["forces"] = json!([{"uniform": {"force": [-load, 0, 0], "group": "loaded"}}]);
    let mut aside = Vec::new();
    watch(&of, |bodies| aside.push(bodies.position[n].y));
    // After the first steps only what grows most is left.
    (aside[20] / aside[10]).ln() / (10.0 * dt)
}

#[test]
fn a_chain_buckles_at_its_critical_load() {
    let stiffness = 2.0;
    for (n, dt) in [(6, 30.0), (12, 200.0)] {
        let critical = buckling_load(n, stiffness);
        let rates = [0.98, 1.02].map(|part| rate_of_growth(n, stiffness, part * critical, dt));
        assert!(rates[0] < 0.0 && rates[1] > 0.0, "{n}: {rates:?}");
        let found = critical * (0.98 + 0.04 * rates[0] / (rates[0] - rates[1]));
        let limit = PI * PI * stiffness / (4 * n * n) as f64;
        println!("{n} links: load {found:.6}, {critical:.6} expected, {limit:.6} of a beam");
        assert!((found / critical - 1.0).abs() < 2e-3, "{n}: {found} {critical}");
        assert!((critical / limit - 1.0).abs() < 0.02);
    }
}

/// A bond of some length bends at both ends. A torque turns each by half; a force across it by its own lever.
#[test]
fn a_bond_of_some_length_bends_at_both_ends() {
    let (stiffness, torque, force, gap, arm) = (2.0, 0.8, 1e-3, 0.4, 0.6);
    let scene = |forces: Value| {
        json!({"name": "gap", "time": {"dt": 10.0, "end": 500.0}, "dynamics": overdamped(), "forces": forces,
            "bodies": [{"shape": {"sphere": {"radius": 0.3}}, "position": [-arm, 0, 0], "fixed": true},
                {"shape": {"sphere": {"radius": 0.3}}, "position": [gap + arm, 0, 0]}],
            "bonds": [{"bodies": [0, 1], "at": [[arm, 0, 0], [-arm, 0, 0]], "stiffness": "rigid", "length": gap,
                "bending": stiffness}],
            "contact": {"overlap_tolerance": 1e-8}, "solver": {"tolerance": 1e-10}})
    };
    let ends = |bodies: &Bodies| {
        let foot = bodies.position[1] - arm * (bodies.orientation[1] * DVec3::X);
        (foot.y.atan2(foot.x), direction(bodies, 1))
    };
    let (bond, body) = ends(
        &run(parse(&scene(json!([{"torque": {"torque": [0, 0, torque], "frame": "space"}}]))), &Compute::Cpu).bodies,
    );
    assert!(
        (bond - 0.5 * torque / stiffness).abs() < 1e-6 && (body - torque / stiffness).abs() < 1e-6,
        "{bond} {body}"
    );
    let (bond, body) = ends(&run(parse(&scene(json!([{"uniform": {"force": [0, force, 0]}}]))), &Compute::Cpu).bodies);
    let expected = [gap + arm, gap + 2.0 * arm].map(|lever| 0.5 * force * lever / stiffness);
    assert!(
        (bond / expected[0] - 1.0).abs() < 1e-3 && (body / expected[1] - 1.0).abs() < 1e-3,
        "{bond} {body} {expected:?}"
    );
}

/// Balls that can only turn, each against a bond of its own: the angle has the density `sin(t) exp(-B t^2 / 2 kT)`, in
/// the plane that of Gauss with the cosine `exp(-kT / 2 B)`, so that a filament of such links of length `l` has the
/// persistence length `B l / kT` where `B` is many `kT`.
#[test]
fn angles_in_heat_have_the_density_of_boltzmann() {
    let (pairs, stiffness, heat, dt) = (100, 1.0, 0.25, 0.005);
    for planar in [true, false] {
        let one = turned(&overdamped(), (DVec3::Z, 0.0), &json!(stiffness), (dt, 6.0));
        let mut of = one.clone();
        (of["contact"], of["solver"]) = (json!({}), json!({}));
        (of["planar"], of["thermal"]) = (json!(planar), json!({"temperature": heat}));
        let (mut bodies, mut bonds) = (Vec::new(), Vec::new());
        for pair in 0..pairs {
            for i in 0..2 {
                let mut body = one["bodies"][i].clone();
                body["position"][1] = json!(3.0 * f64::from(pair));
                bodies.push(body);
            }
            let mut bond = one["bonds"][0].clone();
            bond["bodies"] = json!([2 * pair, 2 * pair + 1]);
            bonds.push(bond);
        }
        (of["bodies"], of["bonds"]) = (json!(bodies), json!(bonds));
        let (mut sum, mut count, mut step) = (0.0, 0.0, 0);
        watch(&of, |bodies| {
            step += 1;
            // Ten relaxation times in.
            if step > 200 {
                for pair in 0..pairs as usize {
                    sum += (bodies.orientation[2 * pair + 1] * DVec3::X).x;
                    count += 1.0;
                }
            }
        });
        let density = |t: f64| (-0.5 * stiffness * t * t / heat).exp() * if planar { 1.0 } else { t.sin() };
        let points = || (0..10_000).map(|i| (f64::from(i) + 0.5) * PI / 10_000.0);
        let expected = points().map(|t| t.cos() * density(t)).sum::<f64>() / points().map(density).sum::<f64>();
        let found = sum / count;
        println!("planar {planar}: mean cosine {found:.4}, {expected:.4} expected");
        // Implicit Euler takes `B dt / 2 xi`, 2 %, of the variance; the rest is chance.
        assert!((found - expected).abs() < 0.05 * (1.0 - expected) + 0.005, "{planar}: {found} {expected}");
    }
}

/// A zigzag of rods in the plane or in space.
fn filament(rods: usize, law: &Value, bending: &Value, gap: f64, (dt, steps): (f64, usize)) -> Value {
    let rod = |i: usize| json!({"shape": {"spherocylinder": {"diameter": 0.2, "length": 1.0}}, "position": [(1.0 + gap) * i as f64, 0, 0], "axis": [1, 0, 0]});
    let mut bodies: Vec<_> = (0..rods).map(rod).collect();
    bodies[0]["fixed"] = json!(true);
    let bond = |i: usize| json!({"bodies": [i, i + 1], "at": [[0, 0, 0.5], [0, 0, -0.5]], "stiffness": "rigid", "length": gap, "bending": bending});
    json!({"name": "filament", "time": {"dt": dt, "end": dt * steps as f64}, "dynamics": law, "bodies": bodies,
        "bonds": (0..rods - 1).map(bond).collect::<Vec<_>>(), "forces": [{"uniform": {"force": [0, 0.3, -1]}}]})
}

/// `RELCP_CHAIN_RODS=500` takes longer filaments.
#[test]
fn filaments_of_fifty_do_not_explode_at_any_bending_stiffness_and_step() {
    let rods = std::env::var("RELCP_CHAIN_RODS").map_or(50, |rods| rods.parse().unwrap());
    let bonds = rods as f64 - 1.0;
    for law in [overdamped(), inertial()] {
        for dt in [1e-3, 1e-2, 1e-1] {
            for stiffness in [json!(1e-6), json!(1e-2), json!(1e2), json!(1e6), json!(1e9), json!("rigid")] {
                let mut simulation = Simulation::new(parse(&filament(rods, &law, &stiffness, 0.05, (dt, 10)))).unwrap();
                let (mut most, mut pieces, mut products) = (0, 0, 0);
                let (mut stretched, mut bent) = (0.0_f64, 0.0_f64);
                while !simulation.done() {
                    let report = simulation.step().unwrap();
                    most = most.max(report.recursions);
                    pieces = pieces.max(report.pieces);
                    products += report.products;
                    let bodies = &simulation.state().unwrap().bodies;
                    let tip =
                        |i: usize, side: f64| bodies.position[i] + bodies.orientation[i] * (0.5 * side * DVec3::Z);
                    for i in 0..rods - 1 {
                        stretched = stretched.max((tip(i, 1.0).distance(tip(i + 1, -1.0)) - 0.05).abs());
                        bent = bent.max(
                            (bodies.orientation[i] * DVec3::Z).angle_between(bodies.orientation[i + 1] * DVec3::Z),
                        );
                    }
                }
                println!(
                    "{law} {dt} {stiffness}: stretch {stretched:.1e}, bend {bent:.1e}, recursions {most}, pieces {pieces}, products {products}"
                );
                assert!(stretched < 2e-5, "{law} {dt} {stiffness}: {stretched}");
                // Weights of all rods on one bend, some times over.
                let most = stiffness.as_f64().map_or(0.0, |stiffness| 4.0 * bonds * bonds / stiffness) + 1e-4;
                assert!(bent < most, "{law} {dt} {stiffness}: {bent}");
            }
        }
    }
}

#[test]
fn runs_with_bending_resume_to_the_same_bits() {
    for (law, gap) in [(overdamped(), 0.05), (inertial(), 0.0)] {
        let of = parse(&filament(50, &law, &json!(5.0), gap, (0.01, 6)));
        assert!(in_two_parts(&of, &Compute::Cpu) == run(of, &Compute::Cpu), "{law}");
    }
}

#[test]
fn bending_that_means_nothing_is_refused_with_its_key() {
    let base = || turned(&overdamped(), (DVec3::Z, 0.1), &json!(1.0), (0.1, 0.1));
    let refused = |edit: &dyn Fn(&mut Value)| {
        let mut of = base();
        edit(&mut of);
        refusal(&of)
    };
    let (key, message) = refused(&|of| of["bonds"][0]["bending"] = json!(1.0));
    assert!(key == "bonds.0.bending" && message.contains("body 1 has no direction"), "{message}");
    assert_eq!(refused(&|of| of["bonds"][0]["bending"]["stiffness"] = json!(-1.0)).0, "bonds.0.bending.stiffness");
    assert_eq!(refused(&|of| of["bonds"][0]["bending"]["axes"][1] = json!([0, 0, 0])).0, "bonds.0.bending.axes.1");
    assert_eq!(refused(&|of| of["bonds"][0]["implicit"] = json!(false)).0, "bonds.0.implicit");
    let (key, message) = refused(&|of| of["bonds"][0]["bending"] = json!("stiff"));
    assert!(key.starts_with("bonds.0.bending") && message.contains("rigid"), "{key} {message}");
    let (key, _) = refused(&|of| {
        of["planar"] = json!(true);
        of["bonds"][0]["bending"]["axes"][0] = json!([0, 0, 1]);
    });
    assert_eq!(key, "bonds.0.bending.axes.0");
    assert_eq!(refused(&|of| of["time"]["stepping"] = json!("midpoint")).0, "time.stepping");
    for bending in
        [json!(2.5), json!("rigid"), json!({"stiffness": "rigid", "axes": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]})]
    {
        let mut of = base();
        of["bonds"][0]["at"][1] = json!([0.1, 0, 0]);
        of["bonds"][0]["bending"] = bending.clone();
        let scene = parse(&of);
        let written = serde_json::to_value(&scene).unwrap();
        assert_eq!(written["bonds"][0]["bending"], bending);
        assert_eq!(Scene::parse(&written.to_string(), "again").unwrap().bonds, scene.bonds);
    }
}
