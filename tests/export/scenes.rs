//! What is exported: bodies of every shape, and a colony that grows.

use glam::{DQuat, DVec3};
use relcp::Scene;
use relcp::bodies::{Bodies, Lineage, NO_GROUP};
use relcp::record::{Folder, Snapshot, decode};
use relcp::run::Run;
use relcp::separation::Placed;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use std::path::Path;
use std::time::Duration;

/// Numbers between 0 and 1, the same every time.
pub struct Draw(pub u64);

impl Draw {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) - 0.5
    }
}

fn shape(kind: usize, draw: &mut Draw) -> Shape {
    let mut size = |from: f64| from + draw.next();
    match kind {
        0 => Shape::Sphere { radius: size(0.3) },
        1 => Shape::Spherocylinder { diameter: size(0.3), length: size(1.3) },
        2 => Shape::Ellipsoid { radii: [size(0.3), size(0.5), size(1.0)] },
        _ => Shape::Torus { major_radius: size(1.3), minor_radius: 0.5 * size(0.1) },
    }
}

/// Ten bodies of every shape, all of different sizes, turned and moving at random; the second rod is as long as it is
/// thick.
pub fn every_shape() -> Snapshot {
    let mut draw = Draw(1);
    let mut bodies = Bodies::default();
    for k in 0..40 {
        let mut shape = shape(k / 10, &mut draw);
        if k == 11 {
            shape = Shape::Spherocylinder { diameter: 0.7, length: 0.7 };
        }
        let [a, b] = [draw.vector(), draw.vector()];
        let orientation = DQuat::from_xyzw(a.x, a.y, a.z, b.x).normalize();
        let position = 20.0 * draw.vector();
        let i = bodies.push(Placed { shape, position, orientation }, if k % 3 == 0 { NO_GROUP } else { 1 });
        bodies.velocity[i] = draw.vector();
        bodies.angular_velocity[i] = draw.vector();
        bodies.lineage[i] = Lineage {
            id: 100 + i as u64,
            parent: (k % 2 == 0).then_some(i as u64),
            birth: draw.next(),
            generation: k as u32 % 5,
            birth_length: None,
        };
    }
    Snapshot { step: 12, time: 0.1 + 0.2, bodies, warm: None, removed: Vec::new(), fields: Vec::new() }
}

/// The run of a colony that grows from one cell to eight, in `parent`.
pub fn colony(parent: &Path) -> Folder {
    let sets = ["time.dt=0.01", "time.end=2.5", "growth.reorientation_degrees=20", "output.every=0.1"];
    let scene = Scene::load("colony", sets).unwrap();
    let bodies = scene.build().unwrap();
    let folder = Folder::create_in(parent, &scene.name).unwrap();
    let mut run =
        Run::start(Simulation::builder(scene).bodies(bodies).build().unwrap(), folder.clone(), Duration::ZERO).unwrap();
    while !run.done() {
        run.advance().unwrap();
    }
    run.finish().unwrap();
    folder
}

/// Rods of more sizes than a GSD file has types for.
pub fn many_rods(count: usize) -> Snapshot {
    let mut draw = Draw(2);
    let mut bodies = Bodies::default();
    for _ in 0..count {
        let shape = Shape::Spherocylinder { diameter: 0.5, length: 2.0 + 2.0 * draw.next() };
        let position = 100.0 * draw.vector();
        let orientation = DQuat::from_rotation_x(draw.next()) * DQuat::from_rotation_y(6.0 * draw.next());
        bodies.push(Placed { shape, position, orientation }, NO_GROUP);
    }
    Snapshot { step: 3, time: 1.5, bodies, warm: None, removed: Vec::new(), fields: Vec::new() }
}

/// Copies of a stored colony side by side, each rod of a length of its own.
pub fn large(count: usize) -> Snapshot {
    let mut draw = Draw(3);
    let (_, state) = decode(include_bytes!("../../assets/states/colony-1024.npz")).unwrap();
    let (one, mut bodies) = (state.bodies, Bodies::default());
    for k in 0..count {
        let (copy, i) = (k / one.len(), k % one.len());
        let mut placed = one.placed(i);
        placed.position += 100.0 * DVec3::new((copy % 12) as f64, (copy / 12) as f64, 0.0);
        placed.shape = placed.shape.grown(2.0 + 2.0 * draw.next()).unwrap();
        bodies.push(placed, one.group[i]);
        bodies.lineage[k] = Lineage { id: k as u64, parent: None, ..one.lineage[i] };
    }
    Snapshot { step: 0, time: 6.9, bodies, warm: None, removed: Vec::new(), fields: Vec::new() }
}
