//! Contacts read back: how many each body of a small colony has, and the worst overlap.

use relcp::{Scene, Simulation};

/// Surfaces nearer than this count as touching: four times the overlap that a step may leave.
const TOUCHING: f64 = 4e-5;

fn main() -> Result<(), relcp::Error> {
    let scene = Scene::load("colony", ["time.end=2.8"])?;
    let mut simulation = Simulation::new(scene)?;
    while !simulation.done() {
        simulation.step()?;
    }
    let bodies = &simulation.state()?.bodies;
    let mut count = vec![0; bodies.len()];
    let mut overlap: f64 = 0.0;
    for contact in simulation.contacts(TOUCHING)? {
        let [a, b] = contact.bodies;
        count[a] += 1;
        count[b] += 1;
        overlap = overlap.max(-contact.separation);
        let [point, _] = contact.points(bodies); // on a's surface, where b touches it
        println!("{a:>3} {b:>3}  {:>10.2e}  at {:.3} {:.3}", contact.separation, point.x, point.y);
    }
    for (lineage, count) in bodies.lineage.iter().zip(count) {
        println!("cell {} of generation {} has {count} contacts", lineage.id, lineage.generation);
    }
    println!("largest overlap {overlap:.1e}");
    Ok(())
}
