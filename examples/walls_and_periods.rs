//! Walls and a periodic axis in one scene: rods are driven both ways along a square duct that closes on itself.

use relcp::scene::{Force, Generate, Periodic, Time, Wall};
use relcp::{Scene, Shape, Simulation};

/// The duct's length, and its sides.
const LENGTH: f64 = 12.0;
const SIDE: f64 = 5.0;

fn rods(group: &str) -> Generate {
    let shape = Shape::Spherocylinder { diameter: 0.5, length: 1.5 };
    Generate::Isotropic {
        count: 30,
        shape,
        lengths: None,
        mixture: Vec::new(),
        volume_fraction: Some(0.05),
        region: None,
        center: [0.0; 3],
        group: Some(group.into()),
    }
}

fn drive(group: &str, force: f64) -> Force {
    Force::Uniform { force: [force, 0.0, 0.0], group: Some(group.into()), window: None }
}

fn main() -> Result<(), relcp::Error> {
    let mut scene = Scene::new("two-way duct", Time::new(0.02, 10.0));
    scene.seed = 7;
    scene.periodic = Some(Periodic::new([Some(LENGTH), None, None]));
    scene.walls = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .map(|normal| Wall::Channel { normal, center: [0.0; 3], width: SIDE, motion: None, friction: None })
        .to_vec();
    scene.generate = vec![rods("east"), rods("west")];
    scene.forces = vec![drive("east", 2.0), drive("west", -2.0)];
    let tolerance = scene.contact.overlap_tolerance;

    let mut simulation = Simulation::new(scene)?;
    while !simulation.done() {
        assert!(simulation.step()?.within(tolerance));
    }
    let bodies = &simulation.state()?.bodies;
    // Positions are not wrapped: the cell that a rod is in counts its laps.
    let laps = bodies.position.iter().map(|x| bodies.periods.wrapped(*x).1.x);
    let (east, west): (Vec<i64>, Vec<i64>) = laps.partition(|laps| *laps >= 0);
    println!("laps: {} eastwards, {} westwards", east.iter().sum::<i64>(), -west.iter().sum::<i64>());
    // A pair may touch across the duct's open end: its contact says through which image.
    let contacts = simulation.contacts(1e-4)?;
    let across = contacts.iter().filter(|contact| contact.image.x != 0).count();
    let at_walls = simulation.wall_contacts(1e-4)?;
    println!("{} contacts of rods, {across} of them with an image; {} at walls", contacts.len(), at_walls.len());
    assert!(at_walls.iter().all(|contact| contact.separation >= -tolerance));
    Ok(())
}
