//! A loop of one's own: a colony grows until it has so many cells, then its picture is drawn.

use relcp::render::{View, picture};
use relcp::{Simulation, scene};
use std::error::Error;

const CELLS: usize = 32;

fn main() -> Result<(), Box<dyn Error>> {
    // The end is only a limit here, so it lies far off.
    let scene = scene::load("colony", &["time.end=10".into(), "growth.reorientation_degrees=2".into()])?;
    let bodies = scene.build()?;
    let mut simulation = Simulation::new(scene, bodies)?;
    while !simulation.done() && simulation.state()?.bodies.len() < CELLS {
        simulation.step()?;
    }
    let bodies = &simulation.state()?.bodies;
    println!("{} cells at time {:.3}, after {} steps", bodies.len(), simulation.time(), simulation.steps());
    let image = picture(bodies, &View { width: 640, height: 480, planar: true, ..View::default() });
    let path = std::env::temp_dir().join("population.png");
    image.write_png(&path)?;
    println!("{}", path.display());
    Ok(())
}
