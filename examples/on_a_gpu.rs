//! A step computed on a GPU, and on the CPU where there is none: only one line tells a simulation which.

use relcp::gpu::{Choice, Precision};
use relcp::{Compute, Scene, Simulation};

fn main() -> Result<(), relcp::Error> {
    let scene = Scene::load("compaction", ["generate.0.isotropic.count=200", "time.end=2"])?;
    // A software adapter will do too; without this, only hardware is taken.
    let choice = Choice { software: true, ..Choice::default() };
    let compute = Compute::open(&choice, Precision::F32, &scene).unwrap_or_else(|reason| {
        println!("computing on the CPU: {reason}");
        Compute::Cpu
    });
    let mut simulation = Simulation::builder(scene).on(&compute).build()?;
    if let Some(gpu) = simulation.device() {
        println!("computing on {}", gpu.name());
    }
    let mut products = 0;
    while !simulation.done() {
        products += simulation.step()?.products;
    }
    // The state is read back here, and audited on the CPU in f64.
    let contacts = simulation.contacts(0.0)?;
    let overlap = contacts.iter().map(|contact| -contact.separation).fold(0.0, f64::max);
    println!("{} steps, {products} products, the largest overlap {overlap:.1e}", simulation.steps());
    assert!(overlap < 1e-4);
    Ok(())
}
