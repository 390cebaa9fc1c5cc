//! What a step makes on the device and sends to and fro.

use crate::device::device;
use relcp::Scene;
use relcp::gpu::{Choice, Gpu, Precision};
use relcp::simulation::{Compute, Simulation};
use std::sync::Arc;

/// A device of its own, as other tests count too.
fn own() -> Option<Arc<Gpu>> {
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
