//! Scenes that break contact codes: degenerate poses, deep overlaps, extreme sizes and steps, singular systems. Every
//! one must end finite and within tolerance, or say that it is not; and a moved, turned or scaled scene must give the
//! moved, turned or scaled result.

mod crowds;
mod moved;
mod overlaps;
mod steps;

use crate::laws::start;
use crate::random::parse;
use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use relcp::scene::{OnFailure, Scene};
use relcp::simulation::Simulation;
use relcp::step::{StepReport, contacts};
use serde_json::{Value, json};

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

fn pushed(bodies: &mut [Value], forces: &[[f64; 3]]) -> Value {
    let mut all = Vec::new();
    for (i, force) in forces.iter().enumerate() {
        bodies[i]["group"] = json!(format!("g{i}"));
        all.push(json!({"uniform": {"force": force, "group": format!("g{i}")}}));
    }
    json!(all)
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
