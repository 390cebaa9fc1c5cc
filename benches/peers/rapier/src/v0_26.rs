//! Rapier 0.26.

use crate::run::{Engine, Fault, Pose as Placed, Run};
use rapier_0_26::na::{Quaternion, UnitQuaternion};
use rapier_0_26::prelude::*;

/// The scene.
pub struct World {
    parameters: IntegrationParameters,
    pipeline: PhysicsPipeline,
    islands: IslandManager,
    broad_phase: DefaultBroadPhase,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    joints: ImpulseJointSet,
    multibodies: MultibodyJointSet,
    continuous: CCDSolver,
    handles: Vec<(RigidBodyHandle, f64)>,
    drag: Option<f64>,
    spin: f64,
}

impl World {
    /// The rods at the start.
    pub fn new(run: &Run) -> Result<Self, Fault> {
        let drag = run.setting("drag")?;
        let (mut bodies, mut colliders) = (RigidBodySet::new(), ColliderSet::new());
        let mut handles = Vec::new();
        for (placed, size) in run.start.iter().zip(&run.sizes) {
            let rod = run.rod(*size);
            let [x, y, z, w, i, j, k] = placed.map(|number| number as Real);
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
            let damping = drag.unwrap_or(0.0) as Real;
            let body = RigidBodyBuilder::dynamic()
                .position(Isometry::from_parts(vector![x, y, z].into(), turn))
                .linear_damping(damping)
                .angular_damping(damping)
                .can_sleep(false);
            let handle = bodies.insert(body);
            let mass =
                MassProperties::new(point![0.0, 0.0, 0.0], rod.mass as Real, Vector::repeat(rod.inertia as Real));
            let form = ColliderBuilder::capsule_z(size[1] as Real, size[0] as Real).friction(0.0).restitution(0.0);
            colliders.insert_with_parent(form.mass_properties(mass), handle, &mut bodies);
            handles.push((handle, rod.speed));
        }
        Ok(World {
            parameters: parameters(run)?,
            pipeline: PhysicsPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: DefaultBroadPhase::new(),
            narrow_phase: NarrowPhase::new(),
            bodies,
            colliders,
            joints: ImpulseJointSet::new(),
            multibodies: MultibodyJointSet::new(),
            continuous: CCDSolver::new(),
            handles,
            drag,
            spin: run.setting("spin")?.unwrap_or(0.0),
        })
    }
}

fn parameters(run: &Run) -> Result<IntegrationParameters, Fault> {
    let mut to = IntegrationParameters { dt: run.dt as Real, ..IntegrationParameters::default() };
    let count = |key: &str, default: usize| run.setting(key).map(|given| given.map_or(default, |n| n as usize));
    let number = |key: &str, default: Real| run.setting(key).map(|given| given.map_or(default, |x| x as Real));
    let iterations = count("iterations", to.num_solver_iterations.get())?;
    to.num_solver_iterations = iterations.try_into().map_err(|_| "iterations: at least 1")?;
    to.num_internal_pgs_iterations = count("pgs", to.num_internal_pgs_iterations)?;
    to.num_internal_stabilization_iterations = count("stabilization", to.num_internal_stabilization_iterations)?;
    to.contact_natural_frequency = number("frequency", to.contact_natural_frequency)?;
    to.contact_damping_ratio = number("damping_ratio", to.contact_damping_ratio)?;
    to.normalized_prediction_distance = number("prediction", to.normalized_prediction_distance)?;
    to.normalized_max_corrective_velocity = number("corrective", to.normalized_max_corrective_velocity)?;
    to.normalized_allowed_linear_error = number("allowed_error", to.normalized_allowed_linear_error)?;
    Ok(to)
}

impl Engine for World {
    fn step(&mut self, run: &Run) {
        for (k, (handle, speed)) in self.handles.iter().enumerate() {
            let Some(body) = self.bodies.get_mut(*handle) else { continue };
            let x = *body.translation();
            let velocity = run.velocity(k, [x.x, x.y, x.z].map(f64::from));
            let velocity = Vector::from(velocity.map(|v| v as Real)) * *speed as Real;
            match self.drag {
                None => {
                    body.set_linvel(velocity, true);
                    body.set_angvel(vector![0.0, 0.0, self.spin as Real], true);
                }
                Some(drag) => {
                    body.reset_forces(true);
                    body.add_force(velocity * (drag / speed) as Real, true);
                }
            }
        }
        self.pipeline.step(
            &vector![0.0, 0.0, 0.0],
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.joints,
            &mut self.multibodies,
            &mut self.continuous,
            None,
            &(),
            &(),
        );
    }

    fn poses(&self) -> Vec<Placed> {
        let pose = |(handle, _): &(RigidBodyHandle, f64)| {
            let body = &self.bodies[*handle];
            let (x, q) = (body.translation(), body.rotation());
            [x.x, x.y, x.z, q.w, q.i, q.j, q.k].map(f64::from)
        };
        self.handles.iter().map(pose).collect()
    }
}
