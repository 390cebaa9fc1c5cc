//! A moved, turned or scaled scene gives the moved, turned or scaled result.

use super::{TOLERANCE, furthest, resolves};
use crate::laws::start;
use crate::random::{heap, parse};
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::dynamics::Load;
use relcp::scene::Scene;
use relcp::simulation::Simulation;
use relcp::step::StepReport;
use serde_json::{Value, json};

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
