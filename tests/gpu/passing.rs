//! Bodies that pass each other, on the device and on the CPU.

use crate::device::{device, precisions};
use relcp::Scene;
use relcp::gpu::{Choice, Gpu};
use relcp::simulation::{Compute, Simulation};
use relcp::step::StepReport;
use std::path::Path;
use std::sync::Arc;

fn steps(compute: &Compute, sets: &[&str]) -> Vec<StepReport> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/torn-chain.json");
    let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
    let scene = Scene::load(path.to_str().unwrap(), &sets).unwrap();
    let mut simulation = Simulation::builder(scene).on(compute).build().unwrap();
    let mut found = Vec::new();
    while !simulation.done() {
        found.push(simulation.step().unwrap());
    }
    found
}

#[test]
fn rings_that_a_step_of_the_device_tears_apart_are_held_by_the_cpu() {
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let found = steps(&Compute::Gpu { gpu: gpu.clone(), precision }, &[]);
        assert!(found[0].by_cpu && found[0].pieces > 1, "{precision:?}: {:?}", found[0]);
        assert!(found.iter().all(|step| step.passed.is_none() && step.max_overlap <= 1e-5), "{precision:?}");
        assert!(found.iter().any(|step| !step.by_cpu), "{precision:?}: the device goes on");
        // Slowly enough they hold on the device.
        let found = steps(&Compute::Gpu { gpu: gpu.clone(), precision }, &["time.dt=0.002", "time.end=0.1"]);
        assert!(found.iter().all(|step| step.passed.is_none() && !step.by_cpu), "{precision:?}");
    }
}

#[test]
fn rings_that_come_apart_are_told_of_on_a_device() {
    let Some(gpu) = device() else { return };
    // Torn so fast that a 64th of the step is too long as well.
    let fast = ["contact.on_failure=continue", "contact.recursion=exact", "time.dt=20", "time.end=40"];
    let cpu = steps(&Compute::Cpu, &fast);
    for precision in precisions(gpu) {
        let found = steps(&Compute::Gpu { gpu: gpu.clone(), precision }, &fast);
        assert!(
            cpu[0].passed.is_some() && found[0].passed.is_some(),
            "{precision:?}: {:?}, the CPU {:?}",
            found[0],
            cpu[0]
        );
    }
}

/// Rods of thickness 0.5 in rows, which all drift by `drift` in a step.
fn drifting(planar: bool, drift: f64) -> Scene {
    let rod = |i: usize| {
        let (x, y) = (2.1 * (i % 8) as f64, 0.55 * (i / 8) as f64);
        format!(
            r#"{{"shape": {{"spherocylinder": {{"diameter": 0.5, "length": 2}}}}, "position": [{x}, {y}, 0],
            "orientation": [0.5, 0.5, 0.5, 0.5]}}"#
        )
    };
    let bodies: Vec<String> = (0..64).map(rod).collect();
    let dt = 0.1;
    // The drag of a rod is its length.
    let force = 2.0 * drift / dt;
    let text = format!(
        r#"{{"name": "drift", "planar": {planar}, "time": {{"dt": {dt}, "end": 1}},
        "forces": [{{"uniform": {{"force": [0, {force}, 0]}}}}], "bodies": [{}]}}"#,
        bodies.join(",")
    );
    Scene::parse(&text, "test").unwrap()
}

fn counted(gpu: &Arc<Gpu>, scene: &Scene) -> (Vec<StepReport>, u64) {
    let precision = relcp::gpu::Precision::F32;
    let compute = Compute::Gpu { gpu: gpu.clone(), precision };
    let mut simulation = Simulation::builder(scene.clone()).on(&compute).build().unwrap();
    let before = gpu.counters().bytes_read;
    let reports = (0..8).map(|_| simulation.step().unwrap()).collect();
    (reports, gpu.counters().bytes_read - before)
}

#[test]
fn a_cloud_that_moves_far_as_a_whole_stays_on_the_device() {
    let Some(gpu) = device() else { return };
    // One of its own, as others count too.
    let choice = Choice { name: Some(gpu.name().to_owned()), software: true, ..Choice::default() };
    let gpu = Arc::new(Gpu::open(&choice).unwrap());
    for planar in [false, true] {
        // By three thicknesses a step; the places of 64 bodies alone are 1,024 bytes.
        let (reports, read) = counted(&gpu, &drifting(planar, 1.5));
        assert!(reports.iter().all(|step| step.passed.is_none() && !step.by_cpu && step.pieces == 1));
        println!("planar {planar}: {read} bytes in 8 steps");
        assert!(read < 8 * 1024, "{read}");
    }
}

#[test]
fn rings_are_torn_apart_on_a_device_in_a_drift_too() {
    let Some(gpu) = device() else { return };
    let all = r#"{"uniform": {"force": [0, 400, 0]}}"#;
    let pulled = r#"{"uniform": {"force": [-100, 0, 0], "group": "first"}},
        {"uniform": {"force": [100, 0, 0], "group": "last"}}"#;
    let forces = format!("forces=[{all}, {pulled}]");
    for precision in precisions(gpu) {
        let found = steps(&Compute::Gpu { gpu: gpu.clone(), precision }, &[&forces]);
        assert!(found[0].by_cpu && found[0].pieces > 1, "{precision:?}: {:?}", found[0]);
        assert!(found.iter().all(|step| step.passed.is_none() && step.max_overlap <= 1e-5), "{precision:?}");
        assert!(found.iter().any(|step| !step.by_cpu), "{precision:?}: the device goes on");
    }
}
