//! Scenes, their runs, and how far two states are apart.

use crate::device::{device, precisions};
use relcp::bodies::Bodies;
use relcp::gpu::Precision;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use relcp::step::State;
use serde_json::{Value, json};

/// A rod's axis along x: the quarter turn about y.
pub const ALONG_X: [f64; 4] = [std::f64::consts::FRAC_1_SQRT_2, 0.0, std::f64::consts::FRAC_1_SQRT_2, 0.0];

pub fn parse(value: &Value) -> Scene {
    Scene::parse(&value.to_string(), "test").unwrap()
}

/// The dotted key and the message of what a scene is refused for.
pub fn refusal(value: &Value) -> (String, String) {
    let error = Scene::parse(&value.to_string(), "test").unwrap_err();
    (error.key().to_owned(), error.to_string())
}

/// The two laws, of unit coefficients.
pub fn laws() -> [Value; 2] {
    [json!({"overdamped": {"drag": 1.0}}), json!({"inertial": {"density": 1.0}})]
}

/// The state at the end of a scene's run.
pub fn run(scene: Scene, compute: &Compute) -> State {
    to_end(Simulation::builder(scene).on(compute).build().unwrap())
}

/// Takes all steps of a scene, and shows each state.
pub fn watch(of: &Value, mut see: impl FnMut(&Bodies)) -> Simulation {
    let mut simulation = Simulation::new(parse(of)).unwrap();
    see(&simulation.state().unwrap().bodies);
    while !simulation.done() {
        simulation.step().unwrap();
        see(&simulation.state().unwrap().bodies);
    }
    simulation
}

pub fn to_end(mut simulation: Simulation) -> State {
    while !simulation.done() {
        simulation.step().unwrap();
    }
    simulation.state().unwrap().clone()
}

/// The largest difference of places, orientations and velocities; velocities over the largest one.
pub fn apart(a: &Bodies, b: &Bodies) -> f64 {
    assert_eq!(a.len(), b.len());
    let worst = |of: &dyn Fn(usize) -> f64| (0..a.len()).map(of).fold(0.0, f64::max);
    let fastest = worst(&|i| b.velocity[i].length()).max(1.0);
    let turning = worst(&|i| b.angular_velocity[i].length()).max(1.0);
    let sides = |i: usize| {
        let (p, q) = (a.orientation[i], b.orientation[i]);
        (p - q).length().min((p + q).length())
    };
    worst(&|i| a.position[i].distance(b.position[i]))
        .max(worst(&sides))
        .max(worst(&|i| a.velocity[i].distance(b.velocity[i])) / fastest)
        .max(worst(&|i| a.angular_velocity[i].distance(b.angular_velocity[i])) / turning)
}

/// Runs a scene to its end on the CPU and on the device in each precision; and each in two parts, which must have the
/// same bits.
pub fn agrees_on_device(scene: &Scene, name: &str, bounds: [f64; 2]) {
    let reference = run(scene.clone(), &Compute::Cpu);
    assert!(in_two_parts(scene, &Compute::Cpu) == reference, "{name}: resumed on the CPU");
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let compute = Compute::Gpu { gpu: gpu.clone(), precision };
        let ours = run(scene.clone(), &compute);
        let mut off = apart(&ours.bodies, &reference.bodies);
        if precision == Precision::F64 && off >= bounds[1] {
            // A solve that took one iteration more ends elsewhere within its tolerance: a tighter one must bring both
            // together.
            let mut tighter = scene.clone();
            tighter.solver.tolerance = Some(1e-3 * scene.lcp_settings().tolerance);
            off = apart(&run(tighter.clone(), &compute).bodies, &run(tighter, &Compute::Cpu).bodies);
        }
        println!("{name}, {precision:?}: {off:.1e} from the CPU");
        let bound = if precision == Precision::F32 { bounds[0] } else { bounds[1] };
        assert!(off < bound, "{name}, {precision:?}: {off:e}");
    }
}

/// The run, resumed from its own state after half of its steps.
pub fn in_two_parts(scene: &Scene, compute: &Compute) -> State {
    let mut first = Simulation::builder(scene.clone()).on(compute).build().unwrap();
    for _ in 0..scene.time.steps() / 2 {
        first.step().unwrap();
    }
    let state = first.state().unwrap().clone();
    to_end(Simulation::builder(scene.clone()).on(compute).resume(state).build().unwrap())
}
