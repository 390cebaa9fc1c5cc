//! A force of one's own: every ellipsoid is drawn to the origin by a spring and turned towards the z axis.

use relcp::glam::DVec3;
use relcp::{Bodies, Load, Scene, Simulation};

const SCENE: &str = r#"{
  "name": "spring", "seed": 3,
  "time": { "dt": 0.05, "end": 5.0 },
  "generate": [ { "isotropic": { "count": 60, "shape": { "ellipsoid": { "radii": [0.5, 0.5, 1.0] } }, "volume_fraction": 0.05 } } ]
}"#;

/// The mean of `cos^2` of the angles between the long axes and z: 1/3 where they point anywhere, 1 where all are
/// upright.
fn upright(bodies: &Bodies) -> f64 {
    let squares = bodies.orientation.iter().map(|q| (*q * DVec3::Z).z.powi(2));
    squares.sum::<f64>() / bodies.len() as f64
}

fn main() -> Result<(), relcp::Error> {
    let scene = Scene::parse(SCENE, "spring")?;
    let bodies = scene.build()?;
    let before = upright(&bodies);
    let mut simulation = Simulation::builder(scene).bodies(bodies).build()?;
    simulation.add_force(Box::new(|bodies: &Bodies, i: usize, _time: f64| {
        let axis = bodies.orientation[i] * DVec3::Z;
        let up = if axis.z < 0.0 { -DVec3::Z } else { DVec3::Z };
        Load { force: -bodies.position[i], torque: 2.0 * axis.cross(up) }
    }));
    let mut worst: f64 = 0.0;
    while !simulation.done() {
        worst = worst.max(simulation.step()?.max_overlap);
    }
    println!("upright: {before:.3} at the start, {:.3} at the end", upright(&simulation.state()?.bodies));
    println!("largest overlap of any step: {worst:.1e}");
    Ok(())
}
