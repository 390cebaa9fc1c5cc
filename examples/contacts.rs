//! Contacts read back: how many each body of a small colony has, and the worst overlap.

use relcp::{Simulation, scene};
use std::error::Error;

/// Surfaces nearer than this count as touching: four times the overlap that a step may leave.
const TOUCHING: f64 = 4e-5;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = scene::load("colony", &["time.end=2.8".into()])?;
    let bodies = scene.build()?;
    let mut simulation = Simulation::new(scene, bodies)?;
    while !simulation.done() {
        simulation.step()?;
    }
    let bodies = &simulation.state()?.bodies;
    let mut count = vec![0; bodies.len()];
    let mut overlap: f64 = 0.0;
    for ([a, b], pair) in simulation.contacts(TOUCHING)? {
        count[a] += 1;
        count[b] += 1;
        overlap = overlap.max(-pair.separation);
        let point = bodies.position[a] + pair.lever_a; // on a's surface, where b touches it
        println!("{a:>3} {b:>3}  {:>10.2e}  at {:.3} {:.3}", pair.separation, point.x, point.y);
    }
    for (lineage, count) in bodies.lineage.iter().zip(count) {
        println!("cell {} of generation {} has {count} contacts", lineage.id, lineage.generation);
    }
    println!("largest overlap {overlap:.1e}");
    Ok(())
}
