//! A scene made in code: two crossed rods are pushed together. Nothing is read or written.

use relcp::scene::{Body, Contact, Dynamics, Force, Output, Scene, Solver, Time};
use relcp::{Shape, Simulation};
use std::error::Error;
use std::f64::consts::FRAC_1_SQRT_2;

fn rod(group: &str, height: f64, orientation: [f64; 4]) -> Body {
    Body {
        shape: Shape::Spherocylinder { diameter: 0.5, length: 2.0 },
        position: [0.0, 0.0, height],
        orientation,
        velocity: None,
        angular_velocity: None,
        group: Some(group.into()),
        lineage: None,
    }
}

fn push(group: &str, force: f64) -> Force {
    Force::Uniform { force: [0.0, 0.0, force], group: Some(group.into()) }
}

fn main() -> Result<(), Box<dyn Error>> {
    // [w, x, y, z]: a quarter turn about y lays the axis, the body's z, along x; one about x lays it along y.
    let along_x = [FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2, 0.0];
    let along_y = [FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0, 0.0];
    let scene = Scene {
        name: "crossed rods".into(),
        seed: 1,
        dynamics: Dynamics::Overdamped { drag: 1.0 },
        time: Time { dt: 0.01, end: 2.0, start: 0.0, stepping: Default::default() },
        contact: Contact { overlap_tolerance: 1e-6, ..Contact::default() },
        solver: Solver::default(),
        planar: false,
        periodic: None,
        walls: Vec::new(),
        forces: vec![push("upper", -1.0), push("lower", 1.0)],
        growth: None,
        bodies: vec![rod("upper", 0.6, along_x), rod("lower", -0.6, along_y)],
        generate: Vec::new(),
        output: Output::default(),
    };
    let bodies = scene.build()?; // refuses what a scene file with these values would be refused for
    let mut simulation = Simulation::new(scene, bodies)?;
    while !simulation.done() {
        let report = simulation.step()?;
        assert!(report.within(1e-6));
    }
    let bodies = &simulation.state()?.bodies;
    let [upper, lower] = [0, 1].map(|i| bodies.position[i].z);
    println!("the axes end {:.6} apart, one diameter being 0.5", upper - lower);
    Ok(())
}
