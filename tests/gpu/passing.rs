//! Bodies that pass each other, on the device and on the CPU.

use crate::device::{device, precisions};
use relcp::Scene;
use relcp::simulation::{Compute, Simulation};
use relcp::step::StepReport;
use std::path::Path;

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
        let found = steps(&Compute::Gpu { gpu: gpu.clone(), precision }, &["time.dt=0.01", "time.end=0.1"]);
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
