//! A loop of one's own: a colony grows until it has so many cells, then its picture is drawn.

use relcp::render::{View, picture};
use relcp::{Scene, Simulation};

const CELLS: usize = 32;

fn main() -> Result<(), relcp::Error> {
    // The end is only a limit here, so it lies far off.
    let scene = Scene::load("colony", ["time.end=10", "growth.reorientation_degrees=2"])?;
    let mut simulation = Simulation::new(scene)?;
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
