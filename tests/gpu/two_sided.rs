//! What contact does on the way to a trial, on the device and on the CPU; steps whose contacts push apart what does not
//! touch go to the CPU.

use crate::device::{device, precisions};
use relcp::gpu::{Gpu, Precision};
use relcp::internals::backend::cpu::Cpu;
use relcp::internals::backend::gpu::Device;
use relcp::internals::freedom::{PLANAR, SPATIAL};
use relcp::internals::step::Verbs;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use relcp::step::{Effect, State, StepReport};
use std::sync::Arc;

/// The part of a thickness that a contact that pushes may end apart, as steps have it.
const GAP: f64 = 0.02;

fn scene(text: &str) -> Scene {
    Scene::parse(text, "two-sided").unwrap()
}

fn on(gpu: &Arc<Gpu>, precision: Precision, scene: Scene) -> Simulation {
    Simulation::builder(scene).on(&Compute::Gpu { gpu: gpu.clone(), precision }).build().unwrap()
}

/// All steps of a scene, and the state that they end in.
fn run(mut simulation: Simulation) -> (Vec<StepReport>, Simulation) {
    let mut reports = Vec::new();
    while !simulation.done() {
        reports.push(simulation.step().unwrap());
    }
    (reports, simulation)
}

/// Two balls nearly in line between walls that close.
fn pressed(dt: f64) -> Scene {
    scene(&format!(
        r#"{{"name": "pressed", "planar": true, "time": {{"dt": {dt}, "end": 1}},
        "walls": [{{"half_space": {{"normal": [1, 0, 0], "offset": -2}}}},
            {{"half_space": {{"normal": [-1, 0, 0], "offset": -2, "motion": {{"velocity": [-1, 0, 0]}}}}}}],
        "bodies": [{{"shape": {{"sphere": {{"radius": 1}}}}, "position": [-1, -0.0005, 0]}},
            {{"shape": {{"sphere": {{"radius": 1}}}}, "position": [1, 0.0005, 0]}}]}}"#
    ))
}

/// Rods of revolution whose contact turns them.
fn crossing() -> Scene {
    scene(
        r#"{"name": "crossing", "dynamics": {"inertial": {"density": 1}}, "time": {"dt": 0.01, "end": 0.3},
        "bodies": [{"shape": {"spherocylinder": {"diameter": 0.1, "length": 2}}, "position": [0, 0, 0],
                "axis": [1, 0, 0], "velocity": [0, 0, 8]},
            {"shape": {"spherocylinder": {"diameter": 0.1, "length": 2}}, "position": [0.43, 0.43, 0.8],
                "axis": [-0.25, 0.42, 0.23]}]}"#,
    )
}

#[test]
fn balls_pressed_in_line_step_aside_and_are_not_thrown() {
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let (steps, simulation) = run(on(gpu, precision, pressed(0.01)));
        let most = steps.iter().fold(0.0, |most: f64, step| most.max(step.largest_move));
        let by_cpu = steps.iter().filter(|step| step.by_cpu).count();
        let y: Vec<f64> = simulation.state().unwrap().bodies.position.iter().map(|p| p.y).collect();
        println!("{precision:?}: {y:?}, moved by {most:.3} at most, {by_cpu} of {} steps by the CPU", steps.len());
        assert!((y[1] - y[0] - 3.0_f64.sqrt()).abs() < 2e-3, "{precision:?}: {y:?}");
        assert!(most < 0.5, "{precision:?}: {most}");
        assert!(by_cpu > 0 && by_cpu < steps.len() / 2, "{precision:?}: {by_cpu}");
    }
}

/// One trial of a step's first rows, by both backends, and what contact does on the way.
fn effects<const D: usize>(scene: &Scene, precision: Precision, gpu: &Arc<Gpu>) -> [Effect; 2] {
    let state =
        || State { step: 0, next_id: 1000, bodies: scene.build().unwrap(), warm: Vec::new(), ..State::default() };
    let mut ours = Device::new(gpu.clone(), precision, &scene.model(), state()).unwrap();
    let mut cpu = Cpu::<D>::new(&scene.model(), state()).unwrap();
    let backends: [&mut dyn Verbs; 2] = [&mut ours, &mut cpu];
    backends.map(|backend| {
        backend.begin().unwrap();
        backend.append_near().unwrap();
        backend.solve(1e-8).unwrap();
        backend.trial(scene.contact.overlap_tolerance).unwrap();
        backend.effect(GAP).unwrap()
    })
}

/// Rods and a ring on a floor and beside each other, all driven against what is there.
fn driven(planar: bool) -> Scene {
    let ring = r#", {"shape": {"torus": {"major_radius": 0.8, "minor_radius": 0.2}}, "position": [3, 0, 0.9],
        "axis": [0.1, 1, 0.3]}"#;
    scene(&format!(
        r#"{{"name": "driven", "planar": {planar}, "time": {{"dt": 0.1, "end": 1}},
        "walls": [{{"half_space": {{"normal": [0, 1, 0], "offset": -1}}}}],
        "forces": [{{"uniform": {{"force": [0.4, -3, 0]}}}}, {{"radial_inward": {{}}}}],
        "bodies": [{{"shape": {{"spherocylinder": {{"diameter": 0.5, "length": 2}}}}, "position": [0, -0.7, 0],
                "axis": [1, 0.02, 0]}},
            {{"shape": {{"spherocylinder": {{"diameter": 0.5, "length": 2}}}}, "position": [0.3, 0, 0],
                "axis": [0.3, 1, 0]}},
            {{"shape": {{"sphere": {{"radius": 0.3}}}}, "position": [1, 0.2, 0]}}{}]}}"#,
        if planar { "" } else { ring }
    ))
}

#[test]
fn what_contact_does_is_what_the_cpu_finds() {
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let (bound, apart) = if precision == Precision::F32 { (2e-4, 1e-5) } else { (1e-6, 1e-7) };
        let cases = [
            ("pressed", effects::<PLANAR>(&pressed(0.01), precision, gpu)),
            ("driven in the plane", effects::<PLANAR>(&driven(true), precision, gpu)),
            ("driven in space", effects::<SPATIAL>(&driven(false), precision, gpu)),
        ];
        for (what, [ours, cpu]) in &cases {
            println!("{what} {precision:?}: {ours:?}, the CPU {cpu:?}");
            assert!((ours.largest_move - cpu.largest_move).abs() <= bound * cpu.largest_move, "{what} {precision:?}");
            // The CPU looks at each branch, the device at the nearest one.
            assert!(ours.push_gap <= cpu.push_gap + (bound * cpu.push_gap).max(apart), "{what} {precision:?}");
            assert_eq!((ours.apart > 0, ours.thrown > 0), (cpu.apart > 0, cpu.thrown > 0), "{what} {precision:?}");
            assert!(ours.axial_spin < 1e-6, "{what} {precision:?}");
            assert_eq!(ours.moved, cpu.moved.filter(|_| ours.apart > 0), "{what} {precision:?}");
        }
        // A ball and a wall have one branch.
        let [ours, cpu] = cases[0].1;
        assert!((ours.push_gap - cpu.push_gap).abs() <= bound * cpu.push_gap, "{precision:?}");
        assert_eq!((ours.push_pair, ours.apart, ours.thrown), (cpu.push_pair, cpu.apart, cpu.thrown), "{precision:?}");
    }
}

#[test]
fn contact_does_not_spin_rods_about_their_axes() {
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let bound = if precision == Precision::F32 { 1e-6 } else { 1e-12 };
        let (steps, simulation) = run(on(gpu, precision, crossing()));
        let most = steps.iter().fold(0.0, |most: f64, step| most.max(step.axial_spin));
        let moved = steps.iter().fold(0.0, |most: f64, step| most.max(step.largest_move));
        let bodies = &simulation.state().unwrap().bodies;
        let spin = |i: usize| (bodies.orientation[i] * glam::DVec3::Z).dot(bodies.angular_velocity[i]).abs();
        let spins = [spin(0), spin(1)];
        let by_cpu = steps.iter().filter(|step| step.by_cpu).count();
        println!("{precision:?}: {most:.1e} in a step, spins {spins:?}, moved by {moved}, {by_cpu} steps by the CPU");
        // Some rows are made at trials, to which bodies turn.
        assert!(steps.iter().any(|step| step.recursions > 0), "{precision:?}");
        assert!(moved > 1e-4 && by_cpu == 0, "{precision:?}: {moved} {by_cpu}");
        assert!(most < bound && spins.iter().all(|spin| *spin < 100.0 * bound), "{precision:?}: {most} {spins:?}");
    }
}

#[test]
fn a_colony_is_not_handed_over() {
    let Some(gpu) = device() else { return };
    let mut simulation = on(gpu, Precision::F32, Scene::load("colony", ["time.dt=0.004"]).unwrap());
    let (mut steps, mut gap, mut most) = (0, 0.0_f64, 0.0_f64);
    while simulation.bodies() < 256 && !simulation.done() {
        let step = simulation.step().unwrap();
        assert!(!step.by_cpu, "step {steps}, {} cells: {step:?}", simulation.bodies());
        (steps, gap, most) = (steps + 1, gap.max(step.largest_push_gap), most.max(step.largest_move));
    }
    println!("{} cells in {steps} steps, pushes at {gap:.1e} at most, moves of {most:.1e}", simulation.bodies());
    assert!(gap > 0.0 && most > 0.0);
}

#[test]
fn a_chamber_that_fills_and_overflows_throws_nobody() {
    let Some(gpu) = device() else { return };
    let text = r#"{"name": "trap", "seed": 1, "planar": true, "time": {"dt": 0.004, "end": 3.9},
        "walls": [{"channel": {"normal": [1, 0, 0], "center": [0, 0, 0], "width": 10.7}},
            {"half_space": {"normal": [0, 1, 0], "offset": 0}}],
        "growth": {"rate": 1.0, "rate_noise": 0.1, "rule": "adder", "added_length": 2, "added_length_noise": 0.2,
            "reorientation_degrees": 3},
        "removal": [{"outside": {"half_space": {"normal": [0, -1, 0], "offset": -10}}}],
        "bodies": [{"shape": {"spherocylinder": {"diameter": 1, "length": 2}}, "position": [0, 3, 0], "angle": 40}]}"#;
    let mut simulation = on(gpu, Precision::F32, scene(text));
    let (mut steps, mut by_cpu, mut most, mut left, mut removed) = (0, 0, 0.0_f64, 0, 0);
    while !simulation.done() {
        let step = simulation.step().unwrap();
        steps += 1;
        by_cpu += usize::from(step.by_cpu);
        most = most.max(step.largest_move);
        left = left.max(simulation.removed() - removed);
        removed = simulation.removed();
    }
    let cells = simulation.bodies();
    println!("{cells} cells after {steps} steps, {by_cpu} by the CPU; {removed} left, {left} at most in a step");
    println!("moves of {most:.3} at most");
    assert!(removed > 0 && left <= 3 && most < 0.5, "{left} {most}");
    assert!(by_cpu < steps / 10, "{by_cpu} of {steps}");
}
