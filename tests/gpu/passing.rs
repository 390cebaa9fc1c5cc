//! Bodies that pass each other, on the device and on the CPU.

use crate::device::{device, precisions};
use relcp::relcp::{Compute, Passed, Simulation};
use relcp::scene;
use std::path::Path;

fn passages(compute: &Compute, sets: &[String]) -> Vec<Option<Passed>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/torn-chain.json");
    let scene = scene::load(path.to_str().unwrap(), sets).unwrap();
    let bodies = scene.build().unwrap();
    let mut simulation = Simulation::new_on(compute, scene, bodies).unwrap();
    let mut found = Vec::new();
    while !simulation.done() {
        found.push(simulation.step().unwrap().passed);
    }
    found
}

#[test]
fn rings_that_come_apart_are_told_of_on_a_device() {
    let Some(gpu) = device() else { return };
    for sets in [vec![], vec!["time.dt=0.01".to_string(), "time.end=0.1".to_string()]] {
        let cpu = passages(&Compute::Cpu, &sets);
        assert_eq!(cpu.iter().any(Option::is_some), sets.is_empty());
        for precision in precisions(gpu) {
            let found = passages(&Compute::Gpu { gpu: gpu.clone(), precision }, &sets);
            println!("{precision:?}: {found:?}, the CPU {cpu:?}");
            let told = |steps: &[Option<Passed>]| steps.iter().map(Option::is_some).collect::<Vec<_>>();
            assert_eq!(told(&found)[..2], told(&cpu)[..2], "{precision:?}");
            assert_eq!(found[0], cpu[0], "{precision:?}");
            assert_eq!(found.iter().any(Option::is_some), sets.is_empty());
        }
    }
}
