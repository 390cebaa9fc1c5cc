//! Joints: pendulums on hinges, linkages, welded bodies, and what the three kinds keep and leave free.

use crate::scenes::{in_two_parts, parse, refusal, run, watch};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

const DENSITY: f64 = 2.0;
const GRAVITY: f64 = 10.0;

/// The mass and the moment of inertia of a ball of this radius.
fn inertia(radius: f64) -> (f64, f64) {
    let mass = DENSITY * 4.0 * PI / 3.0 * radius.powi(3);
    (mass, 0.4 * mass * radius * radius)
}

fn overdamped() -> Value {
    json!({"overdamped": {"drag": 1.0}})
}

fn inertial() -> Value {
    json!({"inertial": {"density": DENSITY}})
}

fn ball(radius: f64, position: DVec3, turned: DQuat) -> Value {
    json!({"shape": {"sphere": {"radius": radius}}, "position": position.to_array(),
        "orientation": [turned.w, turned.x, turned.y, turned.z]})
}

fn fixed(mut body: Value) -> Value {
    body["fixed"] = json!(true);
    body
}

fn scene(law: &Value, (dt, end): (f64, f64), bodies: &[Value], joints: &[Value]) -> Value {
    json!({"name": "jointed", "time": {"dt": dt, "end": end}, "dynamics": law, "bodies": bodies, "joints": joints})
}

/// How far the points of a joint are apart.
fn gap(bodies: &Bodies, [a, b]: [usize; 2], at: [DVec3; 2]) -> f64 {
    let point = |i: usize, at: DVec3| bodies.position[i] + bodies.orientation[i] * at;
    point(a, at[0]).distance(point(b, at[1]))
}

/// A ball hangs from a hinge about y: a compound pendulum. A force along the axis does not move it.
#[test]
fn a_body_on_a_hinge_swings_with_the_period_of_a_compound_pendulum() {
    let (reach, angle, dt) = (1.0, 0.1_f64, 0.01);
    let turned = DQuat::from_rotation_y(-angle);
    let hook = fixed(ball(0.1, DVec3::new(0.0, 0.0, 3.0), DQuat::IDENTITY));
    let hung = ball(0.5, turned * DVec3::new(0.0, 0.0, -reach), turned);
    let joint = json!({"hinge": {"bodies": [0, 1], "at": [[0, 0, -3], [0, 0, reach]], "axis": [0, 2, 0]}});
    let mut of = scene(&inertial(), (dt, 5.0), &[hook, hung], &[joint]);
    of["forces"] = json!([{"gravity": {"acceleration": [0, 3, -GRAVITY]}}]);
    let (mass, own) = inertia(0.5);
    let frequency = (mass * GRAVITY * reach / (own + mass * reach * reach)).sqrt();
    let (mut time, mut before, mut crossings) = (0.0, (0.0, angle), Vec::new());
    watch(&of, |bodies| {
        let apart = gap(bodies, [0, 1], [DVec3::new(0.0, 0.0, -3.0), DVec3::new(0.0, 0.0, reach)]);
        assert!(apart < 2e-5 && bodies.position[1].y.abs() < 2e-5, "{apart} {}", bodies.position[1]);
        let now = bodies.position[1].x.atan2(-bodies.position[1].z);
        if before.1 * now < 0.0 {
            crossings.push(before.0 + (time - before.0) * before.1 / (before.1 - now));
        }
        before = (time, now);
        time += dt;
    });
    let period = crossings[2] - crossings[0];
    let expected = TAU / ((frequency * dt).atan() / dt);
    println!("period {period:.5}, {expected:.5} expected");
    assert!((period / expected - 1.0).abs() < 2e-3, "{period} {expected}");
}

/// A crank of length 1, a coupler of 3 and a rocker of 2.5 on a ground of 3, whose crank a torque turns around.
pub fn four_bar(law: &Value, (dt, end): (f64, f64)) -> Value {
    let points = [DVec3::ZERO, DVec3::X, coupler_end(0.0), DVec3::new(3.0, 0.0, 0.0)];
    let bar = |i: usize| {
        let way = points[i + 1] - points[i];
        ball(0.1, 0.5 * (points[i] + points[i + 1]), DQuat::from_rotation_z(way.y.atan2(way.x)))
    };
    let ground = fixed(ball(0.1, DVec3::new(0.0, -4.0, 0.0), DQuat::IDENTITY));
    let mut bodies = vec![ground, bar(0), bar(1), bar(2)];
    bodies[1]["group"] = json!("crank");
    let hinge = |bodies: [usize; 2], at: [[f64; 3]; 2]| json!({"hinge": {"bodies": bodies, "at": at}});
    let joints = [
        hinge([0, 1], [[0.0, 4.0, 0.0], [-0.5, 0.0, 0.0]]),
        hinge([1, 2], [[0.5, 0.0, 0.0], [-1.5, 0.0, 0.0]]),
        hinge([2, 3], [[1.5, 0.0, 0.0], [-1.25, 0.0, 0.0]]),
        hinge([3, 0], [[1.25, 0.0, 0.0], [3.0, 4.0, 0.0]]),
    ];
    let mut of = scene(law, (dt, end), &bodies, &joints);
    of["planar"] = json!(true);
    of["forces"] = json!([{"torque": {"torque": [0, 0, 2], "frame": "space", "group": "crank"}}]);
    of
}

/// Where coupler and rocker meet at an angle of the crank: above the line of the other ends.
fn coupler_end(crank: f64) -> DVec3 {
    let (from, to) = (DVec3::new(crank.cos(), crank.sin(), 0.0), DVec3::new(3.0, 0.0, 0.0));
    let (way, distance) = (to - from, to.distance(from));
    let along = (3.0 * 3.0 - 2.5 * 2.5 + distance * distance) / (2.0 * distance);
    let up = (9.0 - along * along).sqrt();
    from + along * way / distance + up * DVec3::Z.cross(way) / distance
}

#[test]
fn a_four_bar_linkage_stays_closed_and_moves_as_its_geometry_says() {
    for (law, end) in [(overdamped(), 60.0), (inertial(), 3.0)] {
        let (mut around, mut before, mut worst) = (0.0, 0.0, 0.0_f64);
        watch(&four_bar(&law, (0.02, end)), |bodies| {
            let at = |i: usize, along: f64| bodies.position[i] + bodies.orientation[i] * DVec3::new(along, 0.0, 0.0);
            let points =
                [at(1, -0.5), at(1, 0.5).midpoint(at(2, -1.5)), at(2, 1.5).midpoint(at(3, -1.25)), at(3, 1.25)];
            let gaps =
                [points[0], at(1, 0.5) - at(2, -1.5), at(2, 1.5) - at(3, -1.25), points[3] - DVec3::new(3.0, 0.0, 0.0)];
            gaps.iter().for_each(|gap| assert!(gap.length() < 2e-5, "{law}: {gap}"));
            let crank = points[1].y.atan2(points[1].x);
            worst = worst.max(points[2].distance(coupler_end(crank)));
            let turned: f64 = crank - before;
            around += turned - TAU * (turned / TAU).round();
            before = crank;
        });
        println!("{law}: the crank turned by {around:.2}, the rocker is off by {worst:.1e} at most");
        assert!(around > TAU && worst < 2e-4, "{law}: {around} {worst}");
    }
}

/// Two balls of different radii, welded.
fn welded(law: &Value, joint: &Value, (dt, end): (f64, f64)) -> Value {
    let q = DQuat::from_rotation_x(0.7);
    let bodies = [ball(0.5, DVec3::ZERO, DQuat::IDENTITY), ball(0.3, DVec3::new(1.0, 0.0, 0.0), q)];
    scene(law, (dt, end), &bodies, &[json!({"weld": joint})])
}

fn rigid_weld() -> Value {
    json!({"bodies": [0, 1], "at": [[0.5, 0, 0], [-0.5, 0, 0]]})
}

#[test]
fn a_welded_pair_flies_as_one_body() {
    let mut of = welded(&inertial(), &rigid_weld(), (0.005, 2.0));
    let ([mass_a, mass_b], spin) = ([0.5, 0.3].map(|radius| inertia(radius).0), DVec3::new(0.0, 0.0, 1.0));
    let centre = DVec3::X * mass_b / (mass_a + mass_b);
    for (i, x) in [DVec3::ZERO, DVec3::X].into_iter().enumerate() {
        of["bodies"][i]["velocity"] = json!((DVec3::new(0.3, 0.1, -0.2) + spin.cross(x - centre)).to_array());
        of["bodies"][i]["angular_velocity"] = json!(spin.to_array());
    }
    let mut turned = 0.0;
    let rest = DQuat::from_rotation_x(0.7);
    watch(&of, |bodies| {
        let momentum = mass_a * bodies.velocity[0] + mass_b * bodies.velocity[1];
        assert!(momentum.distance((mass_a + mass_b) * DVec3::new(0.3, 0.1, -0.2)) < 1e-11, "{momentum}");
        let [a, b] = [bodies.orientation[0], bodies.orientation[1]];
        assert!((a * rest).angle_between(b) < 4e-5, "{}", (a * rest).angle_between(b));
        assert!(gap(bodies, [0, 1], [DVec3::new(0.5, 0.0, 0.0), DVec3::new(-0.5, 0.0, 0.0)]) < 2e-5);
        turned = (a * DVec3::X).y.atan2((a * DVec3::X).x);
    });
    // Implicit Euler takes a part `w dt / 2` of the angular momentum of the flight about the common centre a time.
    assert!((turned - 2.0).abs() < 0.02, "{turned}");
}

/// Under a torque a pair gets the angular acceleration of its own moment of inertia.
#[test]
fn a_welded_pair_has_the_moments_of_inertia_of_both_and_of_their_distance() {
    let [(mass_a, own_a), (mass_b, own_b)] = [0.5, 0.3].map(inertia);
    let reduced = mass_a * mass_b / (mass_a + mass_b);
    for (axis, moment) in [(DVec3::X, own_a + own_b), (DVec3::Z, own_a + own_b + reduced)] {
        let mut of = welded(&inertial(), &rigid_weld(), (0.01, 0.5));
        of["bodies"][0]["group"] = json!("driven");
        of["forces"] = json!([{"torque": {"torque": (0.2 * axis).to_array(), "frame": "space", "group": "driven"}}]);
        let end = run(parse(&of), &Compute::Cpu).bodies;
        for spin in &end.angular_velocity {
            assert!((spin.dot(axis) / (0.2 * 0.5 / moment) - 1.0).abs() < 2e-3, "{axis}: {spin}");
        }
    }
}

#[test]
fn a_soft_weld_turns_by_the_torque_over_its_stiffness_about_every_axis() {
    for (axis, planar) in [(DVec3::X, false), (DVec3::new(0.0, 0.6, 0.8), false), (DVec3::Z, true)] {
        let joint = json!({"bodies": [0, 1], "at": [[1, 0, 0], [0, 0, 0]], "bending": 2.0});
        let mut of = welded(&overdamped(), &joint, (1.0, 60.0));
        of["bodies"][0]["fixed"] = json!(true);
        of["bodies"][1]["orientation"] = json!([1, 0, 0, 0]);
        of["planar"] = json!(planar);
        of["solver"] = json!({"tolerance": 1e-9});
        of["forces"] = json!([{"torque": {"torque": (1.5 * axis).to_array(), "frame": "space"}}]);
        let turned = run(parse(&of), &Compute::Cpu).bodies.orientation[1].to_scaled_axis();
        assert!(turned.distance(0.75 * axis) < 1e-4, "{axis}: {turned}");
    }
}

/// The energy of balls of radius 0.2.
fn energy(bodies: &Bodies) -> f64 {
    let (mass, own) = inertia(0.2);
    let of = |i: usize| {
        0.5 * mass * bodies.velocity[i].length_squared()
            + 0.5 * own * bodies.angular_velocity[i].length_squared()
            + mass * GRAVITY * bodies.position[i].z
    };
    (1..bodies.len()).map(of).sum()
}

/// Balls of radius 0.2 along x, one held, with joints of all kinds half-way between neighbours.
pub fn hanging(law: &Value, balls: usize, soft: bool, (dt, steps): (f64, usize)) -> Value {
    let mut bodies: Vec<_> =
        (0..balls).map(|i| ball(0.2, DVec3::new(i as f64, 0.0, 0.0), DQuat::from_rotation_x(0.3 * i as f64))).collect();
    bodies[0] = fixed(bodies[0].take());
    let stiffness = if soft { json!(1e4) } else { json!("rigid") };
    let joint = |i: usize| {
        let mut inner = json!({"bodies": [i, i + 1], "at": [[0.5, 0, 0], [-0.5, 0, 0]], "stiffness": stiffness});
        let kind = ["hinge", "ball", "weld"][i % 3];
        if kind != "ball" {
            inner["bending"] = if soft { json!(50.0) } else { json!("rigid") };
        }
        if kind == "hinge" {
            inner["axis"] = json!([0.1, 1, 0.3]);
        }
        json!({ kind: inner })
    };
    let mut of = scene(law, (dt, dt * steps as f64), &bodies, &(0..balls - 1).map(joint).collect::<Vec<_>>());
    of["forces"] = json!([{"uniform": {"force": [0, 0, -inertia(0.2).0 * GRAVITY]}}]);
    of
}

#[test]
fn the_energy_of_joints_that_fall_never_rises() {
    for dt in [0.01, 0.05] {
        let (mut before, mut rise) = (f64::INFINITY, 0.0_f64);
        watch(&hanging(&inertial(), 10, false, (dt, 60)), |bodies| {
            let now = energy(bodies);
            rise = rise.max(now - before);
            before = now;
        });
        println!("dt {dt}: largest rise {rise:.1e} of {before:.2}");
        // What the tolerance of 1e-5 in each joint leaves to the pulls, up to 10 weights.
        assert!(rise <= 1e-3, "{dt}: {rise:e}");
    }
}

#[test]
fn joints_of_all_kinds_hold_in_long_steps() {
    for law in [overdamped(), inertial()] {
        for soft in [false, true] {
            for dt in [1e-3, 1e-2, 1e-1] {
                let mut worst = 0.0_f64;
                let mut simulation = Simulation::new(parse(&hanging(&law, 30, soft, (dt, 20)))).unwrap();
                let mut most = (0, 0);
                while !simulation.done() {
                    let report = simulation.step().unwrap();
                    most = (most.0.max(report.recursions), most.1.max(report.pieces));
                    let bodies = &simulation.state().unwrap().bodies;
                    let at = [DVec3::new(0.5, 0.0, 0.0), DVec3::new(-0.5, 0.0, 0.0)];
                    worst = (0..29).map(|i| gap(bodies, [i, i + 1], at)).fold(worst, f64::max);
                }
                println!("{law} soft {soft} {dt}: gap {worst:.1e}, recursions and pieces {most:?}");
                // What 29 weights stretch a soft joint by, some times over.
                let weight = inertia(0.2).0 * GRAVITY;
                assert!(
                    worst < if soft { 4.0 * 29.0 * weight / 1e4 + 2e-5 } else { 2e-5 },
                    "{law} {soft} {dt}: {worst}"
                );
            }
        }
    }
}

#[test]
fn runs_with_joints_resume_to_the_same_bits_and_their_ends_are_scenes() {
    for law in [overdamped(), inertial()] {
        let of = parse(&hanging(&law, 8, true, (0.01, 10)));
        let whole = run(of.clone(), &Compute::Cpu);
        assert!(in_two_parts(&of, &Compute::Cpu) == whole, "{law}");
        // Joints rest in the final scene as they did at the start.
        let end = of.final_scene(&whole.bodies, 0.1);
        let written = Scene::parse(&serde_json::to_string(&end).unwrap(), "end").unwrap();
        assert_eq!(written.joints, end.joints);
        let json = serde_json::to_value(&end.joints).unwrap();
        let rest: Vec<f64> = serde_json::from_value(json[0]["hinge"]["rest"].clone()).unwrap();
        let turned = DQuat::from_xyzw(rest[1], rest[2], rest[3], rest[0]);
        assert!(turned.angle_between(DQuat::from_rotation_x(0.3)) < 1e-7, "{turned}");
    }
}

#[test]
fn joints_that_mean_nothing_are_refused_with_their_keys() {
    let base = || welded(&overdamped(), &rigid_weld(), (0.1, 0.1));
    let refused = |edit: &dyn Fn(&mut Value)| {
        let mut of = base();
        edit(&mut of);
        refusal(&of)
    };
    assert_eq!(refused(&|of| of["joints"][0]["weld"]["bodies"] = json!([0, 0])).0, "joints.0.weld.bodies");
    assert_eq!(refused(&|of| of["joints"][0]["weld"]["bodies"] = json!([0, 7])).0, "joints.0.weld.bodies.1");
    assert_eq!(refused(&|of| of["joints"][0]["weld"]["stiffness"] = json!(0)).0, "joints.0.weld.stiffness");
    assert_eq!(refused(&|of| of["joints"][0]["weld"]["rest"] = json!([0, 0, 0, 0])).0, "joints.0.weld.rest");
    assert_eq!(refused(&|of| of["joints"][0]["weld"]["at"] = json!([[0, 0, 0], [0, 0, 0]])).0, "joints.0.weld.at");
    let (key, message) = refused(&|of| of["joints"][0] = json!({"hinge": rigid_weld()}));
    assert!(key == "joints.0.hinge.axis" && message.contains("required in space"), "{message}");
    let (key, _) = refused(&|of| {
        of["joints"][0] = json!({"hinge": rigid_weld()});
        of["joints"][0]["hinge"]["axis"] = json!([1, 0, 0]);
        of["bodies"][1]["orientation"] = json!([1, 0, 0, 0]);
        of["planar"] = json!(true);
    });
    assert_eq!(key, "joints.0.hinge.axis");
    let (key, message) = refused(&|of| of["time"]["stepping"] = json!("midpoint"));
    assert!(key == "time.stepping" && message.contains("joints"), "{message}");
    let (key, message) = refused(&|of| {
        of["generate"] = json!([{"founder": {"diameter": 0.5, "length": 2.0, "position": [5, 0, 0]}}]);
        of["joints"][0]["weld"]["bodies"] = json!([0, 2]);
    });
    assert!(key == "joints.0.weld.rest" && message.contains("required"), "{message}");
}

/// A rigid joint, whose points start apart on both sides of a fixed rod, would draw its ball through the rod.
#[test]
fn a_joint_that_starts_far_off_draws_no_body_through_another_unseen() {
    for law in [overdamped(), inertial()] {
        let balls = [
            ball(0.3, DVec3::new(0.3, 2.0, 0.0), DQuat::IDENTITY),
            fixed(ball(0.3, DVec3::new(0.0, -2.0, 0.0), DQuat::IDENTITY)),
        ];
        let joint = json!({"ball": {"bodies": [0, 1], "at": [[0, 0, 0], [0, 1, 0]]}});
        let mut of = scene(&law, (0.01, 0.1), &balls, &[joint]);
        of["planar"] = json!(true);
        of["generate"] = json!([{"fence": {"points": [[-3, 0, 0], [3, 0, 0]], "diameter": 0.4}}]);
        let mut simulation = Simulation::new(parse(&of)).unwrap();
        let mut passed = false;
        let stopped = loop {
            if simulation.done() {
                break false;
            }
            match simulation.step() {
                Ok(report) => passed |= report.passed.is_some(),
                Err(_) => break true,
            }
        };
        let below = simulation.state().unwrap().bodies.position[0].y < 0.0;
        assert!(!below || passed || stopped, "it went through without a word");
        assert!(passed || stopped, "there is no way");
    }
}

/// Rows of rigid hinges and welds in a loop say the same more than once.
#[test]
fn loops_of_rigid_joints_keep_their_shape() {
    let corner = |i: usize| DVec3::new((TAU * i as f64 / 3.0).cos(), (TAU * i as f64 / 3.0).sin(), 0.1 * i as f64);
    let turned = |i: usize| DQuat::from_scaled_axis(DVec3::new(0.3, -0.2 * i as f64, 0.7));
    let balls: Vec<Value> = (0..3).map(|i| ball(0.3, corner(i), turned(i))).collect();
    // The middle of two balls, in the axes of each.
    let between = |a: usize, b: usize| {
        let middle = 0.5 * (corner(a) + corner(b));
        [a, b].map(|i| (turned(i).inverse() * (middle - corner(i))).to_array())
    };
    let weld = |a: usize, b: usize| json!({"weld": {"bodies": [a, b], "at": between(a, b)}});
    for law in [overdamped(), inertial()] {
        for joints in [vec![weld(0, 1), weld(1, 2), weld(2, 0)], vec![weld(0, 1), weld(0, 1), weld(1, 2)]] {
            let mut of = scene(&law, (0.01, 0.2), &balls, &joints);
            of["forces"] = json!([{"uniform": {"force": [0.4, 0.1, -1.0]}}]);
            let side = |bodies: &Bodies, a: usize, b: usize| (bodies.position[a] - bodies.position[b]).length();
            watch(&of, |bodies| {
                for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                    let right = (corner(a) - corner(b)).length();
                    assert!((side(bodies, a, b) - right).abs() < 5e-5, "{a} {b}: {}", side(bodies, a, b) - right);
                }
            });
        }
    }
}
