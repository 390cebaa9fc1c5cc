//! What a step makes on the device and sends to and fro.

use crate::device::{device, precisions};
use relcp::Scene;
use relcp::gpu::{Choice, Gpu, Precision};
use relcp::simulation::{Compute, Simulation};
use std::sync::Arc;

/// A device of its own, as other tests count too.
pub fn own() -> Option<Arc<Gpu>> {
    let choice = Choice { name: Some(device()?.name().to_owned()), software: true, ..Choice::default() };
    Some(Arc::new(Gpu::open(&choice).unwrap()))
}

fn on(gpu: &Arc<Gpu>, scene: Scene) -> Simulation {
    let compute = Compute::Gpu { gpu: gpu.clone(), precision: Precision::F32 };
    Simulation::builder(scene).on(&compute).build().unwrap()
}

#[test]
fn divisions_make_no_buffers() {
    let Some(gpu) = own() else { return };
    let sets = ["growth.division_length_noise=0.2", "growth.rate_noise=0.2", "time.end=4"];
    let mut simulation = on(&gpu, Scene::load("colony", sets).unwrap());
    while simulation.bodies() < 3 {
        simulation.step().unwrap();
    }
    let made = gpu.buffers_made();
    let (mut steps, mut divisions) = (0, 0);
    while simulation.bodies() < 10 {
        let before = simulation.bodies();
        simulation.step().unwrap();
        (steps, divisions) = (steps + 1, divisions + u32::from(simulation.bodies() > before));
    }
    assert!(divisions >= 6, "{divisions} steps with divisions of {steps}");
    assert_eq!(gpu.buffers_made(), made, "in {steps} steps");
}

/// Rods in rows on a plane, `side` by `side`, with a gap that no step closes. Rods less than 0.05 apart get a
/// constraint.
fn rods(side: usize, gap: f64, growth: &str) -> Scene {
    let rod = |i: usize| {
        let (x, y) = (2.1 * (i % side) as f64, (0.5 + gap) * (i / side) as f64);
        format!(
            r#"{{"shape": {{"spherocylinder": {{"diameter": 0.5, "length": 2}}}}, "position": [{x}, {y}, 0],
            "orientation": [0.5, 0.5, 0.5, 0.5]}}"#
        )
    };
    let bodies: Vec<String> = (0..side * side).map(rod).collect();
    let text = format!(
        r#"{{"name": "rods", "planar": true, "time": {{"dt": 0.001, "end": 1}}, "contact": {{"cutoff": 0.05}}, {growth}
        "forces": [{{"uniform": {{"force": [0, 0.1, 0]}}}}], "bodies": [{}]}}"#,
        bodies.join(",")
    );
    Scene::parse(&text, "test").unwrap()
}

/// Reads, bytes read and bytes written of each of a few steps after the first, which searches for pairs.
fn sent(gpu: &Arc<Gpu>, scene: Scene, constraints: bool) -> Vec<[u64; 3]> {
    let mut simulation = on(gpu, scene);
    let mut step = || {
        let before = gpu.counters();
        let report = simulation.step().unwrap();
        assert_eq!(report.constraints > 0, constraints, "{report:?}");
        let after = gpu.counters();
        let bytes = [after.bytes_read - before.bytes_read, after.bytes_written - before.bytes_written];
        [after.reads - before.reads, bytes[0], bytes[1]]
    };
    step();
    (0..6).map(|_| step()).collect()
}

#[test]
fn a_step_without_events_sends_no_more_for_more_bodies() {
    let Some(gpu) = own() else { return };
    let growth = r#""growth": {"rate": 0.01, "division_length": 4, "division_length_noise": 0.1, "rate_noise": 0.2},"#;
    for growth in ["", growth] {
        for gap in [0.07, 0.01] {
            // A solve of up to 1,024 bodies, pairs and rows is one program, which is sent to the device each time.
            let [few, many] = [34, 50].map(|side| sent(&gpu, rods(side, gap, growth), gap < 0.05));
            println!("gap {gap}: {few:?}");
            // What is written are the parameters of dispatches, of which there are as many.
            assert_eq!(few, many, "1,156 and 2,500 rods with gaps of {gap}");
            assert!(few.iter().all(|[_, read, _]| *read < 1156));
        }
    }
}

#[test]
fn a_step_without_constraints_waits_for_two_reports() {
    let Some(gpu) = own() else { return };
    let reads: Vec<u64> = sent(&gpu, rods(4, 0.07, ""), false).iter().map(|[reads, ..]| *reads).collect();
    assert_eq!(reads, [2; 6]);
}

/// The built-in scenes in their first steps; a colony that grows past one workgroup compiles the others at that step.
#[test]
fn all_kernels_are_compiled_before_the_first_step() {
    let Some(gpu) = own() else { return };
    for name in ["colony", "compaction", "chainmail", "two-ellipsoids", "three-capsules"] {
        for precision in precisions(&gpu) {
            let compute = Compute::Gpu { gpu: gpu.clone(), precision };
            let scene = Scene::built_in(name).unwrap();
            let mut simulation = Simulation::builder(scene).on(&compute).build().unwrap();
            let made = gpu.pipelines().len();
            for _ in 0..3 {
                simulation.step().unwrap();
            }
            let late: Vec<String> = gpu.pipelines()[made..].iter().map(|pipeline| pipeline.name.clone()).collect();
            assert!(late.is_empty(), "{name} {}: {late:?}", precision.name());
        }
    }
}
