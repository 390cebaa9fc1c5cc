//! Scenes that break contact codes: degenerate poses, deep overlaps, extreme sizes and steps, singular systems. Every
//! one must end finite and within tolerance, or say that it is not; and a moved, turned or scaled scene must give the
//! moved, turned or scaled result.

use crate::laws::{body, rod, sphere, start};
use crate::random::{Random, heap, parse};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::dynamics::Load;
use relcp::internals::dynamics::{Pose, Twist, advance};
use relcp::scene::{OnFailure, Scene};
use relcp::simulation::Simulation;
use relcp::step::{StepReport, contacts};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, TAU};

const TOLERANCE: f64 = 1e-5;

fn ring(major: f64, minor: f64) -> Value {
    json!({"torus": {"major_radius": major, "minor_radius": minor}})
}

fn ellipsoid(radii: [f64; 3]) -> Value {
    json!({"ellipsoid": {"radii": radii}})
}

fn scene(dt: f64, bodies: &[Value], forces: Value) -> Scene {
    parse(&json!({"name": "hard", "time": {"dt": dt, "end": 1000.0 * dt}, "bodies": bodies, "forces": forces}))
}

/// The same where steps that cannot be taken are accepted and reported.
fn going_on(dt: f64, bodies: &[Value], forces: Value) -> Scene {
    let mut scene = scene(dt, bodies, forces);
    scene.contact.on_failure = OnFailure::Continue;
    scene
}

fn assert_finite(bodies: &Bodies) {
    for i in 0..bodies.len() {
        let finite =
            bodies.position[i].is_finite() && bodies.velocity[i].is_finite() && bodies.angular_velocity[i].is_finite();
        assert!(finite && bodies.orientation[i].is_normalized(), "body {i} is not finite");
    }
}

/// Steps and audits every accepted state from the bodies alone: what a report says must be true.
fn audited(simulation: &mut Simulation, steps: usize) -> Vec<StepReport> {
    (0..steps)
        .map(|_| {
            let report = simulation.step().unwrap();
            let bodies = &simulation.state().unwrap().bodies;
            assert_finite(bodies);
            let found = contacts(bodies, 0.0).iter().map(|contact| -contact.separation).fold(0.0, f64::max);
            let scale = bodies.shape.iter().map(|s| s.major_axis()).fold(0.0, f64::max);
            assert!((found - report.max_overlap).abs() <= 1e-12 * scale, "says {:e}, is {found:e}", report.max_overlap);
            report
        })
        .collect()
}

fn figures(name: &str, reports: &[StepReport]) -> (f64, u32) {
    let worst = reports.iter().map(|r| r.max_overlap).fold(0.0, f64::max);
    let unconverged = reports.iter().map(|r| r.unconverged).sum();
    let recursions: Vec<u32> = reports.iter().map(|r| r.recursions).take(6).collect();
    let rows = reports.iter().map(|r| r.constraints).max().unwrap();
    let products: u64 = reports.iter().map(|r| r.products).sum();
    println!(
        "{name}: worst {worst:.1e}, unconverged {unconverged}, first recursions {recursions:?}, {rows} rows, {products} products"
    );
    (worst, unconverged)
}

/// Ends every step within tolerance.
fn resolves(name: &str, simulation: &mut Simulation, steps: usize) {
    let reports = audited(simulation, steps);
    let (worst, unconverged) = figures(name, &reports);
    assert!(worst <= TOLERANCE && unconverged == 0, "{name}: worst {worst:e}, {unconverged} unconverged");
}

fn resolves_bodies(name: &str, bodies: &[Value], steps: usize) {
    resolves(name, &mut start(scene(1e-2, bodies, json!([]))), steps);
}

#[test]
fn concentric_bodies_part() {
    let shapes = [sphere(0.5), rod(0.5, 2.0), ellipsoid([1.0, 1.0, 2.0]), ellipsoid([0.5, 1.0, 1.5]), ring(1.0, 0.2)];
    let turned = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.9);
    for shape in &shapes {
        for pose in [DQuat::IDENTITY, turned] {
            let same = body(shape.clone(), [0.3, 0.1, -0.2], pose);
            resolves_bodies(&format!("two of {shape} in one pose"), &[same.clone(), same.clone()], 4);
            resolves_bodies(&format!("three of {shape} in one pose"), &[same.clone(), same.clone(), same.clone()], 4);
            let other = body(shape.clone(), [0.3, 0.1, -0.2], pose * DQuat::from_rotation_x(0.7));
            resolves_bodies(&format!("{shape} about one centre"), &[same, other], 4);
        }
    }
    let all = shapes[..3].iter().map(|s| body(s.clone(), [0.0; 3], DQuat::IDENTITY)).collect::<Vec<_>>();
    resolves_bodies("sphere, rod and ellipsoid about one centre", &all, 4);
}

#[test]
fn rods_whose_axes_meet_part() {
    let thin = || rod(0.2, 2.0);
    let across = DQuat::from_rotation_y(FRAC_PI_2);
    let at = |x: [f64; 3], q| body(thin(), x, q);
    resolves_bodies("crossing at right angles", &[at([0.0; 3], DQuat::IDENTITY), at([0.0; 3], across)], 4);
    resolves_bodies("crossing off centre", &[at([0.0; 3], DQuat::IDENTITY), at([0.3, 0.0, 0.4], across)], 4);
    resolves_bodies(
        "nearly parallel",
        &[at([0.0; 3], DQuat::IDENTITY), at([0.05, 0.0, 0.4], DQuat::from_rotation_x(1e-9))],
        4,
    );
    resolves_bodies("parallel", &[at([0.0; 3], DQuat::IDENTITY), at([0.1, 0.0, 0.0], DQuat::IDENTITY)], 4);
    resolves_bodies("parallel, shifted", &[at([0.0; 3], DQuat::IDENTITY), at([0.1, 0.05, 0.9], DQuat::IDENTITY)], 4);
    resolves_bodies("collinear", &[at([0.0; 3], DQuat::IDENTITY), at([0.0, 0.0, 1.3], DQuat::IDENTITY)], 4);
    resolves_bodies("collinear, tips touch", &[at([0.0; 3], DQuat::IDENTITY), at([0.0, 0.0, 2.0], DQuat::IDENTITY)], 4);
    let star: Vec<Value> = (0..6).map(|i| at([0.0; 3], DQuat::from_rotation_x(f64::from(i) * TAU / 12.0))).collect();
    resolves_bodies("a star of six", &star, 4);
}

#[test]
fn bodies_inside_others_part() {
    let up = DQuat::IDENTITY;
    let inside =
        |big: Value, small: Value, x: [f64; 3]| [body(big, [0.0; 3], up), body(small, x, DQuat::from_rotation_y(0.3))];
    resolves_bodies("sphere in sphere", &inside(sphere(2.0), sphere(0.3), [0.5, 0.2, 0.1]), 4);
    resolves_bodies("sphere in ellipsoid", &inside(ellipsoid([1.0, 2.0, 3.0]), sphere(0.2), [0.1, 0.2, 0.3]), 4);
    resolves_bodies(
        "ellipsoid in ellipsoid",
        &inside(ellipsoid([1.0, 2.0, 3.0]), ellipsoid([0.2, 0.1, 0.3]), [0.1, 0.2, 0.3]),
        4,
    );
    resolves_bodies("rod in ellipsoid", &inside(ellipsoid([1.0, 2.0, 3.0]), rod(0.2, 0.8), [0.1, 0.2, 0.3]), 4);
    resolves_bodies("ellipsoid in sphere", &inside(sphere(2.0), ellipsoid([0.2, 0.1, 0.3]), [0.1, 0.2, 0.3]), 4);
    resolves_bodies("rod in rod", &inside(rod(2.0, 5.0), rod(0.2, 1.0), [0.1, 0.2, 0.3]), 4);
    resolves_bodies(
        "ring in ring, coaxial",
        &[body(ring(1.0, 0.3), [0.0; 3], up), body(ring(1.2, 0.3), [0.0; 3], up)],
        4,
    );
    resolves_bodies("ring in ring, askew", &inside(ring(1.0, 0.3), ring(1.1, 0.3), [0.05, 0.02, 0.01]), 4);
    resolves_bodies(
        "ring on equal ring",
        &[body(ring(1.0, 0.3), [0.0; 3], up), body(ring(1.0, 0.3), [0.0, 0.0, 0.1], up)],
        4,
    );
    resolves_bodies("sphere on a ring's tube", &inside(ring(1.0, 0.3), sphere(0.2), [1.05, 0.0, 0.0]), 4);
    resolves_bodies("small sphere at a ring's centre", &inside(ring(1.0, 0.3), sphere(0.2), [0.0; 3]), 4);
    resolves_bodies("rod through a ring", &inside(ring(1.0, 0.3), rod(0.4, 4.0), [0.0; 3]), 4);
    resolves_bodies("thick rod through a ring", &inside(ring(1.0, 0.3), rod(1.6, 4.0), [0.0; 3]), 4);
    resolves_bodies("rod through a ring's tube", &inside(ring(1.0, 0.3), rod(0.2, 2.0), [1.0, 0.0, 0.0]), 4);
}

/// A ring is not convex: a sphere that fits its hole nowhere is pushed to and fro across it, and the rows of one step,
/// each right at its own trial, have no common solution. Whatever is accepted must be reported as it is.
#[test]
fn a_sphere_too_large_for_the_hole_it_is_in_neither_hangs_the_step_nor_goes_unreported() {
    for x in [[0.0; 3], [0.05, 0.0, 0.0], [0.0, 0.0, 0.05], [0.02, 0.01, 0.1]] {
        let both = [body(ring(1.0, 0.3), [0.0; 3], DQuat::IDENTITY), body(sphere(0.9), x, DQuat::IDENTITY)];
        let mut simulation = start(going_on(1e-2, &both, json!([])));
        let reports = audited(&mut simulation, 8);
        figures(&format!("sphere in a hole, at {x:?}"), &reports);
        println!("{:?} {:?} {:?}", simulation.state().unwrap().bodies.position, reports[0].status, reports[0].residual);
        let last = reports.last().unwrap();
        assert!(last.within(TOLERANCE) || last.recursions == 64 || last.unconverged > 0, "{last:?}");
        let reach = simulation.state().unwrap().bodies.position.iter().map(|x| x.length()).fold(0.0, f64::max);
        assert!(reach < 10.0, "thrown away, to {reach}");
        assert!(reports.iter().all(|r| r.iterations < 10_000), "goes on where there is no solution");
    }
}

#[test]
fn extreme_sizes_resolve() {
    let up = DQuat::IDENTITY;
    let big_small = [body(sphere(10.0), [0.0; 3], up), body(sphere(0.01), [10.0, 0.0, 0.0], up)];
    resolves_bodies("spheres 1000:1", &big_small, 4);
    let inward = json!([{"radial_inward": {}}]);
    for (name, shapes) in [
        ("rods 100:1", [rod(0.04, 4.0), rod(0.04, 4.0)]),
        ("ellipsoids 100:1", [ellipsoid([0.02, 0.02, 2.0]), ellipsoid([0.02, 0.02, 2.0])]),
        ("discs 1:100", [ellipsoid([2.0, 2.0, 0.02]), ellipsoid([2.0, 2.0, 0.02])]),
        ("rods and discs", [rod(0.04, 4.0), ellipsoid([2.0, 2.0, 0.02])]),
    ] {
        let mut random = Random::new(11);
        let bodies: Vec<Value> = (0..20)
            .map(|i| body(shapes[i % 2].clone(), (1.5 * random.vector()).to_array(), random.orientation()))
            .collect();
        resolves(name, &mut start(scene(1e-2, &bodies, inward.clone())), 10);
    }
}

#[test]
fn many_small_spheres_pushed_onto_a_big_one() {
    let mut random = Random::new(12);
    let mut bodies = vec![body(sphere(3.0), [0.0; 3], DQuat::IDENTITY)];
    bodies.extend((0..200).map(|_| {
        let x = random.direction() * random.within(3.2, 4.5);
        body(sphere(0.3), x.to_array(), DQuat::IDENTITY)
    }));
    resolves("200 on one", &mut start(scene(0.05, &bodies, json!([{"radial_inward": {}}]))), 20);
}

#[test]
fn a_closed_ring_of_spheres_squeezed() {
    let radius = 0.5 / (TAU / 24.0).sin();
    let bodies: Vec<Value> = (0..12)
        .map(|i| {
            let (s, c) = (TAU * f64::from(i) / 12.0).sin_cos();
            body(sphere(0.5), [radius * c, radius * s, 0.0], DQuat::IDENTITY)
        })
        .collect();
    for planar in [true, false] {
        let mut scene = scene(0.01, &bodies, json!([{"radial_inward": {}}]));
        scene.planar = planar;
        let mut simulation = start(scene);
        resolves(&format!("squeezed ring, planar {planar}"), &mut simulation, 50);
        let moved =
            simulation.state().unwrap().bodies.position.iter().map(|x| (x.length() - radius).abs()).fold(0.0, f64::max);
        println!("moved by {moved:e}");
        assert!(moved < 1e-4, "an arch holds itself: {moved:e}");
    }
}

#[test]
fn a_stack_of_spheres_compressed_from_both_ends() {
    let mut bodies: Vec<Value> =
        (0..30).map(|i| body(sphere(0.5), [1.0 * f64::from(i), 0.0, 0.0], DQuat::IDENTITY)).collect();
    bodies[0]["group"] = json!("low");
    bodies[29]["group"] = json!("high");
    let forces = json!([
        {"uniform": {"force": [10.0, 0.0, 0.0], "group": "low"}}, {"uniform": {"force": [-10.0, 0.0, 0.0], "group": "high"}}
    ]);
    let mut simulation = start(scene(0.1, &bodies, forces));
    resolves("stack", &mut simulation, 50);
    let total: f64 = simulation.state().unwrap().warm.iter().map(|w| w.gamma).sum();
    println!("total force {total}");
    // Every one of the 29 contacts carries the force of the ends.
    assert!((total - 290.0).abs() < 0.1, "{total}");
}

fn pushed(bodies: &mut [Value], forces: &[[f64; 3]]) -> Value {
    let mut all = Vec::new();
    for (i, force) in forces.iter().enumerate() {
        bodies[i]["group"] = json!(format!("g{i}"));
        all.push(json!({"uniform": {"force": force, "group": format!("g{i}")}}));
    }
    json!(all)
}

/// The deepest overlap on the way of one accepted step, over 200 poses between its ends.
fn deepest_on_the_way(before: &Bodies, after: &Bodies, dt: f64) -> f64 {
    let between = |part: f64| {
        let mut bodies = after.clone();
        for i in 0..bodies.len() {
            let from = Pose { position: before.position[i], orientation: before.orientation[i] };
            let twist = Twist { linear: after.velocity[i], angular: after.angular_velocity[i] };
            let pose = advance(from, twist, part * dt);
            (bodies.position[i], bodies.orientation[i]) = (pose.position, pose.orientation);
        }
        contacts(&bodies, 0.0).iter().map(|contact| -contact.separation).fold(0.0, f64::max)
    };
    (1..200).map(|k| between(f64::from(k) / 200.0)).fold(0.0, f64::max)
}

/// Of 100 random pairs thrown at each other, each by `jump` of its length a step, how many pass through each other:
/// overlap on the way by more than a fifth of their thickness.
fn passings(shape: &Value, length: f64, jump: f64) -> usize {
    let mut random = Random::new(81);
    let mut passed = 0;
    for _ in 0..100 {
        // The paths cross in the middle of the step.
        let way = random.direction();
        let aside = 0.3 * length * random.vector();
        let half = way * (0.5 * jump + 0.55) * length;
        let mut bodies = [
            body(shape.clone(), (-half).to_array(), random.orientation()),
            body(shape.clone(), (half + aside).to_array(), random.orientation()),
        ];
        let push = way * (jump * length * length);
        let forces = pushed(&mut bodies, &[push.to_array(), (-push).to_array()]);
        let mut simulation = start(going_on(1.0, &bodies, forces));
        for _ in 0..2 {
            let before = simulation.state().unwrap().bodies.clone();
            audited(&mut simulation, 1);
            if deepest_on_the_way(&before, &simulation.state().unwrap().bodies, 1.0) > 0.2 * before.shape[0].thickness()
            {
                passed += 1;
                break;
            }
        }
    }
    passed
}

/// A step looks at its two ends only. Rows from the swept reach part two spheres at any speed; where bodies turn, a row
/// takes the turn for straight motion, so that a large one may end free of overlap on the other side.
#[test]
fn bodies_do_not_pass_through_each_other_in_a_step_of_a_quarter_of_their_length() {
    for (name, shape, length) in
        [("spheres", sphere(0.5), 1.0), ("rods", rod(0.5, 2.0), 2.0), ("ellipsoids", ellipsoid([0.3, 0.5, 1.0]), 2.0)]
    {
        let found = [0.1, 0.25, 0.5, 1.0, 3.0, 10.0, 1e3].map(|jump| (jump, passings(&shape, length, jump)));
        println!("{name}: (lengths a step, of 100 passed) {found:?}");
        for (jump, passed) in found {
            let sure = name == "spheres" || jump <= 0.25;
            assert!(!sure || passed == 0, "{name} at {jump} lengths a step: {passed} of 100 passed");
        }
    }
}

#[test]
fn a_large_step_of_a_heap_stays_within_tolerance() {
    for dt in [1.0, 10.0] {
        for (seed, kinds) in [(21, ["sphere"].as_slice()), (22, &["spherocylinder", "ellipsoid"])] {
            let mut simulation = start(heap(seed, kinds, 24, dt));
            let reports = audited(&mut simulation, 5);
            let (worst, unconverged) = figures(&format!("{kinds:?} dt {dt}"), &reports);
            for report in &reports {
                let says = !report.within(TOLERANCE) || report.unconverged > 0;
                assert!(report.max_overlap <= TOLERANCE || says);
                assert!(report.max_overlap <= TOLERANCE || report.recursions == 64, "gave up early: {report:?}");
            }
            assert!(dt > 1.0 || (worst <= TOLERANCE && unconverged == 0));
        }
    }
}

#[test]
fn a_tiny_step_resolves() {
    for kinds in [["sphere"], ["spherocylinder"], ["ellipsoid"]] {
        let mut simulation = start(heap(31, &kinds, 24, 1e-9));
        resolves(&format!("{kinds:?} dt 1e-9"), &mut simulation, 5);
    }
}

/// A heap pushed together by forces that do not care where the origin is.
fn movable(seed: u64, kinds: &[&str], tolerance: f64) -> (Scene, Bodies) {
    let mut scene = heap(seed, kinds, 16, 0.02);
    scene.forces.clear();
    scene.solver.tolerance = Some(tolerance);
    let mut bodies = scene.build().unwrap();
    // Positions and shifts are multiples of 2^-20, so that differences far from the origin are the same numbers.
    let grid = 2f64.powi(-20);
    bodies.position.iter_mut().for_each(|x| *x = (*x / grid).round() * grid);
    (scene, bodies)
}

fn pulled_together(scene: &Scene, bodies: Bodies, turned: DQuat, steps: usize) -> Bodies {
    let mut simulation = Simulation::builder(scene.clone()).bodies(bodies).build().unwrap();
    simulation.add_force(Box::new(move |bodies: &Bodies, i: usize, _: f64| {
        let to_first = bodies.position[0] - bodies.position[i];
        Load { force: to_first + turned * DVec3::new(0.1, 0.2, 0.3), torque: turned * DVec3::new(0.2, -0.1, 0.1) }
    }));
    resolves("moved heap", &mut simulation, steps);
    simulation.state().unwrap().bodies.clone()
}

fn furthest(found: &Bodies, expected: &Bodies, shift: DVec3, turned: DQuat) -> f64 {
    (0..found.len())
        .map(|i| {
            let x = (found.position[i] - shift - turned * expected.position[i]).length();
            let probe = DVec3::new(1.0, 2.0, -1.0).normalize();
            let q = (found.orientation[i] * probe - turned * (expected.orientation[i] * probe)).length();
            x.max(q)
        })
        .fold(0.0, f64::max)
}

#[test]
fn far_from_the_origin_nothing_changes() {
    for (seed, kinds) in [(41, ["sphere"].as_slice()), (42, &["spherocylinder"]), (43, &["ellipsoid"])] {
        let (scene, bodies) = movable(seed, kinds, 1e-10);
        let at_origin = pulled_together(&scene, bodies.clone(), DQuat::IDENTITY, 5);
        let shift = DVec3::new(1e6, -1e6, 1e6);
        let mut moved = bodies.clone();
        moved.position.iter_mut().for_each(|x| *x += shift);
        let far = pulled_together(&scene, moved, DQuat::IDENTITY, 5);
        let off = furthest(&far, &at_origin, shift, DQuat::IDENTITY);
        let spacing = 2f64.powi(-33);
        println!("{kinds:?}: off by {off:.1e}, {:.1} spacings of the coordinates", off / spacing);
        // Ellipsoids 146 spacings, the others 3.
        assert!(off < 4e-8, "{off:e}");
    }
}

#[test]
fn a_turned_and_moved_scene_gives_the_turned_and_moved_result() {
    let turned = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.7).normalize(), 1.3);
    let shift = DVec3::new(0.7, -1.1, 0.4);
    for (seed, kinds) in
        [(51, ["sphere"].as_slice()), (52, &["spherocylinder"]), (53, &["ellipsoid"]), (54, &["torus"])]
    {
        let (scene, bodies) = movable(seed, kinds, 1e-12);
        let here = pulled_together(&scene, bodies.clone(), DQuat::IDENTITY, 3);
        let mut there = bodies;
        for i in 0..there.len() {
            there.position[i] = turned * there.position[i] + shift;
            there.orientation[i] = (turned * there.orientation[i]).normalize();
        }
        let there = pulled_together(&scene, there, turned, 3);
        let off = furthest(&there, &here, shift, turned);
        println!("{kinds:?}: off by {off:.1e}");
        assert!(off < 1e-9, "{off:e}");
    }
}

#[test]
fn a_scaled_scene_gives_the_scaled_result() {
    for (seed, kinds) in
        [(61, ["sphere"].as_slice()), (62, &["spherocylinder"]), (63, &["ellipsoid"]), (64, &["torus"])]
    {
        let run = |s: f64| {
            let scene = heap(seed, kinds, 16, 0.02);
            let mut value = serde_json::to_value(&scene).unwrap();
            for body in value["bodies"].as_array_mut().unwrap() {
                scale_numbers(&mut body["shape"], s);
                scale_numbers(&mut body["position"], s);
            }
            value["forces"] = json!([]);
            value["contact"]["overlap_tolerance"] = json!(TOLERANCE * s);
            value["solver"]["tolerance"] = json!(1e-12 * s);
            let mut simulation = start(parse(&value));
            // u = F / (drag L) and w = 12 T / (drag L^3): velocities scale with the lengths where F does as s^2 and T
            // as s^3.
            simulation.add_force(Box::new(move |bodies: &Bodies, i: usize, _: f64| Load {
                force: -s * bodies.position[i],
                torque: DVec3::ZERO,
            }));
            let reports: Vec<StepReport> = (0..3).map(|_| simulation.step().unwrap()).collect();
            for report in &reports {
                assert!(report.max_overlap <= TOLERANCE * s && report.unconverged == 0, "scale {s:e}: {report:?}");
            }
            let recursions: u32 = reports.iter().map(|r| r.recursions).sum();
            (simulation.state().unwrap().bodies.clone(), recursions)
        };
        let (one, recursions) = run(1.0);
        for s in [1e-6, 1e6, 1e-20] {
            let (mut scaled, of_scaled) = run(s);
            scaled.position.iter_mut().for_each(|x| *x /= s);
            let off = furthest(&scaled, &one, DVec3::ZERO, DQuat::IDENTITY);
            println!("{kinds:?} scale {s:e}: off by {off:.1e}, {recursions} and {of_scaled} recursions");
            assert!(off < 1e-9, "{off:e}");
        }
    }
}

fn scale_numbers(value: &mut Value, s: f64) {
    match value {
        Value::Number(number) => *value = json!(number.as_f64().unwrap() * s),
        Value::Array(all) => all.iter_mut().for_each(|v| scale_numbers(v, s)),
        Value::Object(all) => all.values_mut().for_each(|v| scale_numbers(v, s)),
        _ => {}
    }
}

#[test]
fn a_jammed_start_without_forces_stays_put() {
    let mut bodies = Vec::new();
    for i in 0..27 {
        let x = [f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)];
        bodies.push(body(sphere(0.5), x, DQuat::IDENTITY));
    }
    let mut simulation = start(scene(0.1, &bodies, json!([])));
    let before = simulation.state().unwrap().bodies.position.clone();
    resolves("27 touching spheres", &mut simulation, 20);
    assert_eq!(simulation.state().unwrap().bodies.position, before);

    let mut settled = start(heap(71, &["spherocylinder", "ellipsoid"], 24, 0.02));
    settled.step().unwrap();
    let mut still = settled.scene().clone();
    still.forces.clear();
    let bodies = settled.state().unwrap().bodies.clone();
    let mut still = Simulation::builder(still).bodies(bodies.clone()).build().unwrap();
    resolves("a heap without its forces", &mut still, 20);
    let moved = furthest(&still.state().unwrap().bodies, &bodies, DVec3::ZERO, DQuat::IDENTITY);
    println!("moved by {moved:e}");
    // What is left to part is at most the tolerance a contact.
    assert!(moved < 10.0 * TOLERANCE, "{moved:e}");
}

#[test]
fn one_body_and_bodies_that_never_meet() {
    let one = [body(ring(1.0, 0.2), [1.0, 2.0, 3.0], DQuat::IDENTITY)];
    let mut simulation = start(scene(0.1, &one, json!([{"radial_inward": {}}])));
    resolves("one body", &mut simulation, 10);
    assert_eq!(simulation.state().unwrap().warm, []);
    let apart: Vec<Value> =
        (0..10).map(|i| body(rod(0.5, 1.0), [100.0 * f64::from(i), 0.0, 0.0], DQuat::IDENTITY)).collect();
    let mut simulation = start(scene(0.1, &apart, json!([{"uniform": {"force": [0.0, 0.0, 1.0]}}])));
    let reports = audited(&mut simulation, 10);
    assert!(reports.iter().all(|r| (r.constraints, r.iterations, r.max_overlap) == (0, 0, 0.0)));
    assert!(simulation.state().unwrap().bodies.position.iter().all(|x| (x.z - 1.0).abs() < 1e-12));
}

#[test]
fn a_chain_pushed_by_a_fast_body_keeps_its_order() {
    // The second body has no motion of its own: only contact brings it near the third, within the same step.
    for speed in [5.0, 20.0, 100.0] {
        let mut bodies: Vec<Value> =
            [-3.0, 0.0, 3.0].iter().map(|x| body(sphere(0.5), [*x, 0.0, 0.0], DQuat::IDENTITY)).collect();
        let forces = pushed(&mut bodies, &[[speed, 0.0, 0.0]]);
        let mut simulation = start(scene(1.0, &bodies, forces));
        resolves(&format!("chain at {speed}"), &mut simulation, 1);
        let x: Vec<f64> = simulation.state().unwrap().bodies.position.iter().map(|x| x.x).collect();
        println!("{x:?}");
        assert!(x[0] < x[1] && x[1] < x[2], "a body passed through another: {x:?}");
    }
}

#[test]
fn a_body_squeezed_out_fast_does_not_pass_through_a_third() {
    // Two fast bodies pinch a small one, which leaves between them faster than either comes, towards a wall of spheres.
    for speed in [1.0, 2.0, 5.0, 10.0] {
        let mut bodies = vec![
            body(sphere(1.0), [-2.0, 0.0, 0.0], DQuat::IDENTITY),
            body(sphere(1.0), [2.0, 0.0, 0.0], DQuat::IDENTITY),
            body(sphere(0.3), [0.0, 0.5, 0.0], DQuat::IDENTITY),
            body(sphere(20.0), [0.0, 24.0, 0.0], DQuat::IDENTITY),
        ];
        let forces = pushed(&mut bodies, &[[2.0 * speed, 0.0, 0.0], [-2.0 * speed, 0.0, 0.0]]);
        let mut simulation = start(scene(1.0, &bodies, forces));
        let report = audited(&mut simulation, 1);
        figures(&format!("squeezed at {speed}"), &report);
        let x = &simulation.state().unwrap().bodies.position;
        println!("{} {}", x[2], x[3]);
        assert!(x[2].y < x[3].y, "passed through: {x:?}");
    }
}

#[test]
fn bodies_given_beside_a_scene_without_any_still_touch() {
    let with = scene(
        0.1,
        &[body(sphere(0.5), [0.0; 3], DQuat::IDENTITY), body(sphere(0.5), [0.9, 0.0, 0.0], DQuat::IDENTITY)],
        json!([]),
    );
    let bodies = with.build().unwrap();
    let mut empty = with;
    empty.bodies.clear();
    let mut simulation = Simulation::builder(empty).bodies(bodies).build().unwrap();
    assert_eq!(simulation.step().unwrap().constraints, 1);
}
