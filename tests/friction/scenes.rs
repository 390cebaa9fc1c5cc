//! The scenes of these tests: weight `G` on bodies that touch a floor.

use relcp::bodies::Bodies;
use relcp::scene::Scene;
use relcp::simulation::Simulation;
use relcp::step::StepReport;
use serde_json::{Value, json};

pub const G: f64 = 9.81;

/// A sphere of radius 1.
pub fn ball(position: [f64; 3]) -> Value {
    json!({"shape": {"sphere": {"radius": 1.0}}, "position": position})
}

/// Ten balls on the floor z = 0, six, three and one.
pub fn pyramid() -> Vec<Value> {
    let (across, up) = (3.0_f64.sqrt(), 2.0 * (2.0_f64 / 3.0).sqrt());
    let place = |layer: i32, i: i32, j: i32| {
        let [layer, i, j] = [layer, i, j].map(f64::from);
        ball([2.0 * i + j + layer, across * (j + layer / 3.0), 1.0 + up * layer])
    };
    let layers = [3, 2, 1].into_iter().zip(0..);
    layers
        .flat_map(|(side, layer)| (0..side).flat_map(move |i| (0..side - i).map(move |j| place(layer, i, j))))
        .collect()
}

/// A rod that lies along x. It touches a floor at both ends, so that it slides along x without turning.
pub fn rod(height: f64) -> Value {
    json!({"shape": {"spherocylinder": {"diameter": 1.0, "length": 4.0}}, "position": [0, 0, height], "axis": [1, 0, 0]})
}

pub fn with(mut body: Value, key: &str, value: Value) -> Value {
    body[key] = value;
    body
}

pub fn floor() -> Value {
    json!({"half_space": {"normal": [0, 0, 1], "offset": 0}})
}

/// Weight on an incline of this angle that falls towards x, in the axes of the incline.
pub fn weight(incline: f64) -> Value {
    json!([{"gravity": {"acceleration": [G * incline.sin(), 0.0, -G * incline.cos()]}}])
}

/// A scene with inertia, of this friction.
pub fn inertial(friction: impl Into<Value>, forces: Value, walls: Value, bodies: Vec<Value>, time: [f64; 2]) -> Value {
    json!({"name": "rough", "time": {"dt": time[0], "end": time[1]}, "dynamics": {"inertial": {"density": 1.0}},
        "contact": {"friction": friction.into()}, "forces": forces, "walls": walls, "bodies": bodies})
}

pub fn parse(scene: &Value) -> Scene {
    Scene::parse(&scene.to_string(), "scene").unwrap_or_else(|fault| panic!("{fault}\n{scene:#}"))
}

pub fn start(scene: &Value) -> Simulation {
    Simulation::new(parse(scene)).unwrap()
}

/// Takes all steps, each of which must hold what a step with friction promises; returns the bodies at the end.
pub fn run(scene: &Value) -> Bodies {
    let mut simulation = start(scene);
    run_on(&mut simulation, |_, _| ());
    simulation.state().unwrap().bodies.clone()
}

/// The same, and shows each step.
pub fn run_on(simulation: &mut Simulation, mut after: impl FnMut(&Simulation, &StepReport)) {
    let tolerance = simulation.scene().contact.overlap_tolerance;
    while !simulation.done() {
        let report = simulation.step().unwrap();
        assert!(report.within(tolerance) && report.settled(tolerance), "{report:?}");
        after(simulation, &report);
    }
}

#[track_caller]
pub fn assert_near(found: f64, expected: f64, error: f64) {
    assert!((found - expected).abs() <= error, "{found} is not {expected}, by {:e}", found - expected);
}
