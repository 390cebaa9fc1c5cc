//! Growing and dividing rods in the plane, stepped by Rapier 0.36. Rapier neither grows nor divides bodies. So each rod
//! gets a longer capsule before every step, and at its division length two rods take its place.
//!
//! `peers-rapier version=0.36-colony frames=FILE dt= cells= every= radius= length= division= rate= turn= [settings]`:
//! from one rod of tip-to-tip `length` until there are so many `cells`; daughters turn by up to `turn` degrees. A frame
//! is its time, the number of rods, then for each its pose (position, orientation `w, x, y, z`), radius and half length
//! of its axis. Settings are those of [`super::single::v0_36`]; without `drag` each rod is at rest before every step.

use crate::run::{Fault, Run, cpu};
use crate::single::v0_36::parameters;
use rapier_0_36::prelude::*;
use std::fs::File;
use std::io::{BufWriter, Write};

/// A rod, as the engine holds it.
struct Cell {
    body: RigidBodyHandle,
    collider: ColliderHandle,
    length: f64,
}

/// The cells, and how they grow.
struct Colony {
    world: PhysicsWorld,
    cells: Vec<Cell>,
    radius: f64,
    /// The length of the first rod, which has the mass 1.
    first: f64,
    division: f64,
    /// The largest turn of a daughter, in radians.
    turn: f64,
    drag: Option<f64>,
    /// The state of the random numbers (Marsaglia's xorshift of 64 bits, 2003).
    random: u64,
}

impl Colony {
    fn new(run: &Run) -> Result<Self, Fault> {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        world.integration_parameters.dt = run.number("dt")? as Real;
        parameters(run, &mut world.integration_parameters)?;
        let (radius, first, division) = (run.number("radius")?, run.number("length")?, run.number("division")?);
        let (turn, drag) = (run.number("turn")?.to_radians(), run.setting("drag")?);
        let random = 0x9E37_79B9_7F4A_7C15;
        let mut colony = Colony { world, cells: Vec::new(), radius, first, division, turn, drag, random };
        colony.add([0.0, 0.0], 0.0, first, [0.0; 3]);
        Ok(colony)
    }

    fn capsule(&self, length: f64) -> SharedShape {
        SharedShape::capsule_x((0.5 * length - self.radius) as Real, self.radius as Real)
    }

    /// Of a rod of this length, about its centre, as in [`Run::rod`].
    fn mass(&self, length: f64) -> MassProperties {
        let mass = length / self.first;
        MassProperties::new(Vector::ZERO, mass as Real, Vector::splat((mass * length * length / 12.0) as Real))
    }

    /// Adds a rod with its axis at this angle from x, and its velocity along x and y and about z.
    fn add(&mut self, at: [f64; 2], angle: f64, length: f64, velocity: [Real; 3]) {
        let turned = Rotation::from_xyzw(0.0, 0.0, (0.5 * angle).sin() as Real, (0.5 * angle).cos() as Real);
        let damping = self.drag.unwrap_or(0.0) as Real;
        let body = RigidBodyBuilder::dynamic()
            .pose(Pose::from_parts(Vector::new(at[0] as Real, at[1] as Real, 0.0), turned))
            .linvel(Vector::new(velocity[0], velocity[1], 0.0))
            .angvel(Vector::new(0.0, 0.0, velocity[2]))
            .linear_damping(damping)
            .angular_damping(damping)
            .enabled_translations(true, true, false)
            .enabled_rotations(false, false, true)
            .can_sleep(false);
        let form = ColliderBuilder::new(self.capsule(length)).friction(0.0).restitution(0.0);
        let (body, collider) = self.world.insert(body.build(), form.mass_properties(self.mass(length)));
        self.cells.push(Cell { body, collider, length });
    }

    /// Uniform in -1 to 1.
    fn uniform(&mut self) -> f64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random as f64 / u64::MAX as f64 * 2.0 - 1.0
    }

    /// Lengthens all rods by this factor, and divides those that are long enough.
    fn grow(&mut self, factor: f64) {
        let mut long = Vec::new();
        for k in 0..self.cells.len() {
            self.cells[k].length *= factor;
            let length = self.cells[k].length;
            if length >= self.division {
                long.push(k);
                continue;
            }
            let (shape, mass) = (self.capsule(length), self.mass(length));
            let collider = &mut self.world.colliders[self.cells[k].collider];
            collider.set_shape(shape);
            collider.set_mass_properties(mass);
            if self.drag.is_none() {
                let body = &mut self.world.bodies[self.cells[k].body];
                body.set_linvel(Vector::ZERO, true);
                body.set_angvel(Vector::ZERO, true);
            }
        }
        for k in long.into_iter().rev() {
            let mother = self.cells.swap_remove(k);
            let body = &self.world.bodies[mother.body];
            let (x, q, v, w) = (body.translation(), *body.rotation(), body.linvel(), body.angvel());
            let angle = 2.0 * f64::from(q.z).atan2(f64::from(q.w));
            let (x, velocity) = ([f64::from(x.x), f64::from(x.y)], [v.x, v.y, w.z]);
            self.world.remove_body(mother.body);
            for side in [-0.25, 0.25] {
                let along = side * mother.length;
                let turn = self.turn * self.uniform();
                let at = [x[0] + along * angle.cos(), x[1] + along * angle.sin()];
                self.add(at, angle + turn, 0.5 * mother.length, velocity);
            }
        }
    }

    fn write(&self, to: &mut impl Write, time: f64) -> Result<(), Fault> {
        let mut numbers = vec![time, self.cells.len() as f64];
        for cell in &self.cells {
            let body = &self.world.bodies[cell.body];
            let (x, q) = (body.translation(), *body.rotation());
            numbers.extend([x.x, x.y, x.z, q.w, q.x, q.y, q.z].map(f64::from));
            numbers.extend([self.radius, 0.5 * cell.length - self.radius]);
        }
        numbers.iter().try_for_each(|number| to.write_all(&number.to_le_bytes()))?;
        Ok(())
    }
}

/// Runs the colony.
pub fn follow() -> Result<(), Fault> {
    let run = Run::of_settings()?;
    let (dt, every) = (run.number("dt")?, run.number("every")?);
    let (most, factor) = (run.number("cells")? as usize, (run.number("rate")? * dt).exp());
    let stride = ((every / dt).round() as u64).max(1);
    let mut colony = Colony::new(&run)?;
    let mut frames = BufWriter::new(File::create(run.word("frames")?)?);
    let (mut step, mut seconds, mut since) = (0_u64, 0.0, cpu());
    while colony.cells.len() < most {
        colony.grow(factor);
        colony.world.step();
        step += 1;
        if step.is_multiple_of(stride) || colony.cells.len() >= most {
            seconds += cpu() - since;
            colony.write(&mut frames, step as f64 * dt)?;
            since = cpu();
        }
    }
    frames.flush()?;
    let cells = colony.cells.len();
    println!("{{\"version\": \"0.36.1\", \"steps\": {step}, \"cells\": {cells}, \"cpu_s\": {seconds:.9}}}");
    Ok(())
}
