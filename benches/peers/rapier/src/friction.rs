//! Balls and rods with friction on planes, stepped by Rapier 0.36.
//!
//! `peers-rapier version=0.36-friction scene=FILE frames=FILE [settings]`. The scene's numbers: step, end, time between
//! frames, coefficient, gravity, how many planes, these (normal, offset), then bodies (radius, half length of the axis,
//! position, orientation `w, x, y, z`, velocity, spin). A frame is its time, then position, velocity and spin of each
//! body. Settings are those of [`super::single::v0_36`].

use crate::run::{Fault, Run, cpu, numbers};
use rapier_0_36::prelude::*;
use crate::single::v0_36::parameters;
use std::fs::File;
use std::io::{BufWriter, Write};

/// As a ball of radius 1 with the mass 1.
const DENSITY: f64 = 3.0 / (4.0 * std::f64::consts::PI);

/// Runs the scene.
pub fn follow() -> Result<(), Fault> {
    let run = Run::of_settings()?;
    let scene = numbers(run.word("scene")?)?;
    let mut rest = scene.iter().map(|number| *number as Real);
    let mut take = || rest.next().ok_or("the scene ends early");
    let [dt, end, every, mu] = [take()?, take()?, take()?, take()?];
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::new(take()?, take()?, take()?);
    world.integration_parameters.dt = dt;
    parameters(&run, &mut world.integration_parameters)?;
    for _ in 0..take()? as usize {
        let (normal, offset) = (Vector::new(take()?, take()?, take()?), take()?);
        let plane = ColliderBuilder::halfspace(rapier_0_36::na::Unit::new_unchecked(normal)).friction(mu).restitution(0.0);
        world.insert(RigidBodyBuilder::fixed().translation(normal * offset).build(), plane);
    }
    let mut handles = Vec::new();
    while let Ok(radius) = take() {
        let (half, at) = (take()?, Vector::new(take()?, take()?, take()?));
        let [w, x, y, z] = [take()?, take()?, take()?, take()?];
        let pose = Pose::from_parts(at, Rotation::from_xyzw(x, y, z, w));
        let body = RigidBodyBuilder::dynamic().pose(pose).linvel(Vector::new(take()?, take()?, take()?));
        let body = body.angvel(Vector::new(take()?, take()?, take()?)).can_sleep(false).build();
        let form = if half > 0.0 { ColliderBuilder::capsule_z(half, radius) } else { ColliderBuilder::ball(radius) };
        handles.push(world.insert(body, form.friction(mu).restitution(0.0).density(DENSITY as Real)).0);
    }
    let mut frames = BufWriter::new(File::create(run.word("frames")?)?);
    let mut frame = |world: &PhysicsWorld, time: f64| -> Result<(), Fault> {
        frames.write_all(&time.to_le_bytes())?;
        for handle in &handles {
            let body = &world.bodies[*handle];
            for v in [body.translation(), body.linvel(), body.angvel()] {
                [v.x, v.y, v.z].iter().try_for_each(|x| frames.write_all(&f64::from(*x).to_le_bytes()))?;
            }
        }
        Ok(frames.flush()?)
    };
    frame(&world, 0.0)?;
    let (steps, stride) = ((end / dt).round() as u64, (every / dt).round() as u64);
    let (mut seconds, mut since) = (0.0, cpu());
    for step in 1..=steps {
        world.step();
        if step % stride == 0 {
            seconds += cpu() - since;
            frame(&world, step as f64 * f64::from(dt))?;
            since = cpu();
        }
    }
    println!("{{\"steps\": {steps}, \"cpu_s\": {seconds:.9}}}");
    Ok(())
}
