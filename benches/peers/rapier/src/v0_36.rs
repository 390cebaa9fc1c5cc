//! Rapier 0.36, in the precision of the crate that the module above names `engine`.

use super::engine::prelude::*;
use crate::run::{Engine, Fault, Pose as Placed, Rod, Run};

/// The scene.
pub struct World {
    world: PhysicsWorld,
    handles: Vec<(RigidBodyHandle, Rod)>,
    drag: Option<f64>,
    spin: f64,
}

impl World {
    /// The rods at the start.
    pub fn new(run: &Run) -> Result<Self, Fault> {
        let drag = run.setting("drag")?;
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        parameters(run, &mut world.integration_parameters)?;
        let mut handles = Vec::new();
        for (placed, size) in run.start.iter().zip(&run.sizes) {
            let rod = run.rod(*size);
            let [x, y, z, w, i, j, k] = placed.map(|number| number as Real);
            let pose = Pose::from_parts(Vector::new(x, y, z), Rotation::from_xyzw(i, j, k, w));
            let damping = drag.unwrap_or(0.0) as Real;
            let body = RigidBodyBuilder::dynamic().pose(pose).linear_damping(damping).angular_damping(damping);
            let mass = MassProperties::new(Vector::ZERO, rod.mass as Real, Vector::splat(rod.inertia as Real));
            let form = ColliderBuilder::capsule_z(size[1] as Real, size[0] as Real).friction(0.0).restitution(0.0);
            handles.push((world.insert(body.can_sleep(false).build(), form.mass_properties(mass)).0, rod));
        }
        Ok(World { world, handles, drag, spin: run.setting("spin")?.unwrap_or(0.0) })
    }
}

/// Sets what the run says of the engine.
pub fn parameters(run: &Run, to: &mut IntegrationParameters) -> Result<(), Fault> {
    if run.dt > 0.0 {
        to.dt = run.dt as Real;
    }
    let count = |key: &str, default: usize| run.setting(key).map(|given| given.map_or(default, |n| n as usize));
    let number = |key: &str, default: Real| run.setting(key).map(|given| given.map_or(default, |x| x as Real));
    to.num_solver_iterations = count("iterations", to.num_solver_iterations)?;
    to.num_internal_pgs_iterations = count("pgs", to.num_internal_pgs_iterations)?;
    to.num_internal_stabilization_iterations = count("stabilization", to.num_internal_stabilization_iterations)?;
    to.contact_softness.natural_frequency = number("frequency", to.contact_softness.natural_frequency)?;
    to.contact_softness.damping_ratio = number("damping_ratio", to.contact_softness.damping_ratio)?;
    to.normalized_prediction_distance = number("prediction", to.normalized_prediction_distance)?;
    to.normalized_max_corrective_velocity = number("corrective", to.normalized_max_corrective_velocity)?;
    to.normalized_allowed_linear_error = number("allowed_error", to.normalized_allowed_linear_error)?;
    to.contact_recycling = count("recycling", usize::from(to.contact_recycling))? != 0;
    Ok(())
}

impl Engine for World {
    fn step(&mut self, run: &Run) {
        for (k, (handle, Rod { speed, inertia, .. })) in self.handles.iter().enumerate() {
            let body = &mut self.world.bodies[*handle];
            let x = body.translation();
            let velocity = run.velocity(k, [x.x, x.y, x.z].map(f64::from));
            let velocity = Vector::from_array(velocity.map(|v| v as Real)) * *speed as Real;
            match self.drag {
                None => {
                    body.set_linvel(velocity, true);
                    body.set_angvel(Vector::new(0.0, 0.0, self.spin as Real), true);
                }
                Some(drag) => {
                    body.reset_forces(true);
                    body.reset_torques(true);
                    body.add_force(velocity * (drag / speed) as Real, true);
                    body.add_torque(Vector::new(0.0, 0.0, (drag * inertia * self.spin) as Real), true);
                }
            }
        }
        self.world.step();
    }

    fn poses(&self) -> Vec<Placed> {
        let pose = |(handle, _): &(RigidBodyHandle, Rod)| {
            let body = &self.world.bodies[*handle];
            let (x, q) = (body.translation(), *body.rotation());
            [x.x, x.y, x.z, q.w, q.x, q.y, q.z].map(f64::from)
        };
        self.handles.iter().map(pose).collect()
    }
}
