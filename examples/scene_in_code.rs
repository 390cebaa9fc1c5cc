//! A scene made in code: two crossed rods are pushed together. Nothing is read or written.

use relcp::scene::{Body, Force, Time};
use relcp::{Scene, Shape, Simulation};
use std::f64::consts::FRAC_1_SQRT_2;

fn rod(group: &str, height: f64, orientation: [f64; 4]) -> Body {
    let shape = Shape::Spherocylinder { diameter: 0.5, length: 2.0 };
    let mut body = Body::new(shape, [0.0, 0.0, height]);
    body.orientation = Some(orientation);
    body.group = Some(group.into());
    body
}

fn push(group: &str, force: f64) -> Force {
    Force::Uniform { force: [0.0, 0.0, force], group: Some(group.into()), window: None }
}

fn main() -> Result<(), relcp::Error> {
    // [w, x, y, z]: a quarter turn about y lays the axis, the body's z, along x; one about x lays it along y.
    let along_x = [FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2, 0.0];
    let along_y = [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0, 0.0];
    // Everything that is not set has the default of a scene file.
    let mut scene = Scene::new("crossed rods", Time::new(0.01, 2.0));
    scene.contact.overlap_tolerance = 1e-6;
    scene.forces = vec![push("upper", -1.0), push("lower", 1.0)];
    scene.bodies = vec![rod("upper", 0.6, along_x), rod("lower", -0.6, along_y)];
    let mut simulation = Simulation::new(scene)?; // refuses what a scene file with these values would be refused for
    while !simulation.done() {
        let report = simulation.step()?;
        assert!(report.within(1e-6));
    }
    let bodies = &simulation.state()?.bodies;
    let [upper, lower] = [0, 1].map(|i| bodies.position[i].z);
    println!("the axes end {:.6} apart, one diameter being 0.5", upper - lower);
    Ok(())
}
