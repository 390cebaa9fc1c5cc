//! Shapes of one's own, by their support functions: rounded dice and eggs are pressed together.

use relcp::glam::DVec3;
use relcp::shape::{Convex, ConvexError, Shape};
use relcp::{Bodies, Load, Scene, Simulation};

/// Balls to place the bodies by: each holds a die or an egg.
const SCENE: &str = r#"{
  "name": "dice and eggs", "seed": 5,
  "time": { "dt": 0.05, "end": 4.0 },
  "generate": [ { "isotropic": { "count": 16, "shape": { "sphere": { "radius": 1.0 } }, "volume_fraction": 0.1 } } ]
}"#;

/// The point of an ellipsoid whose outward normal is `n`: the gradient of the support function `|radii n|`.
fn ellipsoid(radii: DVec3, n: DVec3) -> DVec3 {
    radii * radii * n / (radii * n).length()
}

/// The same of a die: points of convex bodies add up to a convex body's, those of three needles to a rounded cube's.
fn die(n: DVec3) -> DVec3 {
    DVec3::AXES.map(|axis| ellipsoid(0.05 + 0.4 * axis, n)).into_iter().sum()
}

/// The same of an egg: the support function of an ellipsoid, and `0.04 n_z^3`.
fn egg(n: DVec3) -> DVec3 {
    ellipsoid(DVec3::new(0.6, 0.6, 0.8), n) + 0.04 * (3.0 * n.z.powi(2) * DVec3::Z - 2.0 * n.z.powi(3) * n)
}

fn main() -> Result<(), relcp::Error> {
    let die = Convex::new(die)?;
    // Where its centre of mass is not the origin, a shape is refused, and the error says where it is.
    let egg = match Convex::new(egg) {
        Err(ConvexError::OffCentre { centre }) => Convex::new(move |n| egg(n) - DVec3::from_array(centre))?,
        other => other?,
    };
    println!("a die of volume {:.4} and an egg of volume {:.4}", die.volume(), egg.volume());
    let scene = Scene::parse(SCENE, "dice and eggs")?;
    let mut bodies = scene.build()?;
    for (i, shape) in bodies.shape.iter_mut().enumerate() {
        *shape = Shape::Convex(if i % 2 == 0 { die } else { egg });
    }
    let mut simulation = Simulation::builder(scene).bodies(bodies).build()?;
    simulation.add_force(Box::new(|bodies: &Bodies, i: usize, _time: f64| Load {
        force: -4.0 * bodies.position[i],
        torque: DVec3::ZERO,
    }));
    while !simulation.done() {
        simulation.step()?;
    }
    let contacts = simulation.contacts(1e-4)?; // computed afresh
    let overlap = contacts.iter().map(|contact| -contact.separation).fold(0.0, f64::max);
    assert!(overlap <= 1e-5);
    println!("{} contacts, the largest overlap {overlap:.1e}", contacts.len());
    Ok(())
}
