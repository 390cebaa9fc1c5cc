//! Members of an ensemble against the same scenes alone on the device.

use crate::device::{device, precisions};
use relcp::gpu::{Ensemble, Gpu, GpuError, Precision};
use relcp::record::state_hash;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use std::sync::Arc;

/// Scenes that differ in kernels, sizes and lengths.
fn scenes() -> Vec<Scene> {
    let colony = |seed: u64, rate: f64| {
        let sets =
            [format!("seed={seed}"), format!("growth.rate={rate}"), "time.dt=0.01".into(), "time.end=2.2".into()];
        Scene::load("colony", &sets).unwrap()
    };
    let short = |name: &str, sets: &[&str]| Scene::load(name, sets.iter().copied()).unwrap();
    vec![
        colony(1, 1.0),
        colony(2, 1.0),
        colony(3, 1.3),
        short("two-ellipsoids", &["time.end=0.2"]),
        short("chainmail", &["time.end=0.1"]),
        short("piston", &["time.end=0.05"]),
        short("three-capsules", &[]),
    ]
}

fn run(gpu: Arc<Gpu>, precision: Precision, scene: Scene) -> String {
    let mut simulation = Simulation::builder(scene).on(&Compute::Gpu { gpu, precision }).build().unwrap();
    while !simulation.done() {
        simulation.step().unwrap();
    }
    state_hash(simulation.state().unwrap())
}

#[test]
fn a_members_bits_are_those_of_the_scene_alone_on_that_device() {
    let Some(gpu) = device() else { return };
    for precision in precisions(gpu) {
        let alone: Vec<String> = scenes().into_iter().map(|scene| run(gpu.clone(), precision, scene)).collect();
        let ensemble = Ensemble::new(gpu.clone()).unwrap();
        let together: Vec<String> = std::thread::scope(|scope| {
            let begin = |scene: Scene| {
                let member = ensemble.member();
                scope.spawn(move || run(member, precision, scene))
            };
            let threads: Vec<_> = scenes().into_iter().rev().map(begin).collect();
            threads.into_iter().rev().map(|thread| thread.join().unwrap()).collect()
        });
        println!("{precision:?}: {:?}", ensemble.rounds());
        assert_eq!(together, alone, "{precision:?}");
        assert!(ensemble.rounds().dispatches < ensemble.rounds().asked);
    }
}
