//! The rules of planar scenes: everything is mirrored by one plane of constant z, and stays so.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::orientation::unit;
use super::super::{Body, Force, Generate, Scene};
use crate::shape::Shape;
use glam::{DMat3, DVec3};

/// How far a body's axis may lean out of its plane of symmetry (a sine): rounding of an orientation stays below a tenth of a millionth of it.
const LEAN: f64 = 1e-9;

impl Scene {
    pub(super) fn check_planar(&self, root: &Key) -> Result<(), SceneError> {
        let plane = match self.bodies.first() {
            Some(body) if self.generate.is_empty() => body.position[2],
            _ => 0.0,
        };
        for (i, body) in self.bodies.iter().enumerate() {
            check_body(&root.field("bodies").index(i), body, plane)?;
            self.check_growing(&root.field("bodies").index(i), body)?;
        }
        for (i, rule) in self.generate.iter().enumerate() {
            check_rule(&root.field("generate").index(i), rule)?;
        }
        for (i, force) in self.forces.iter().enumerate() {
            check_force(&root.field("forces").index(i), force, plane)?;
        }
        Ok(())
    }

    /// A cell that stands upright in the plane is mirrored by it, but its daughters would not be.
    fn check_growing(&self, key: &Key, body: &Body) -> Result<(), SceneError> {
        let upright = matches!(body.shape, Shape::Spherocylinder { .. }) && axis(body).z.abs() > LEAN;
        if self.growth.is_some() && upright {
            return Err(SceneError::bad(
                key.field("orientation"),
                "a growing spherocylinder of a planar scene must lie in the x-y plane",
            ));
        }
        Ok(())
    }
}

fn axis(body: &Body) -> DVec3 {
    unit(body.orientation) * DVec3::Z
}

fn check_body(key: &Key, body: &Body, plane: f64) -> Result<(), SceneError> {
    if body.position[2] != plane {
        let message = format!("bodies of a planar scene share one z, here {plane:?}, not {:?}", body.position[2]);
        return Err(SceneError::bad(key.field("position").index(2), message));
    }
    if !is_mirrored(body) {
        let message = "the body must be mirrored by the plane: its axis in it or across it, or one of its principal axes across it";
        return Err(SceneError::bad(key.field("orientation"), message));
    }
    let zero = |name: &'static str, index: usize, value: f64| {
        if value == 0.0 {
            Ok(())
        } else {
            Err(SceneError::bad(key.field(name).index(index), format!("must be 0 in a planar scene, not {value:?}")))
        }
    };
    if let Some(velocity) = body.velocity {
        zero("velocity", 2, velocity[2])?;
    }
    if let Some(turn) = body.angular_velocity {
        zero("angular_velocity", 0, turn[0])?;
        zero("angular_velocity", 1, turn[1])?;
    }
    Ok(())
}

/// Whether the plane of constant z through its centre mirrors a body.
fn is_mirrored(body: &Body) -> bool {
    match body.shape {
        Shape::Sphere { .. } => true,
        Shape::Spherocylinder { .. } | Shape::Torus { .. } => {
            let axis = axis(body);
            axis.z.abs() <= LEAN || axis.truncate().length() <= LEAN
        }
        Shape::Ellipsoid { radii } => {
            // z must be an eigenvector of R diag(r^2) R^T.
            let turn = DMat3::from_quat(unit(body.orientation));
            let radii = DVec3::from(radii);
            let form = turn * DMat3::from_diagonal(radii * radii) * turn.transpose();
            form.z_axis.truncate().abs().max_element() <= LEAN * radii.max_element().powi(2)
        }
    }
}

fn check_rule(key: &Key, rule: &Generate) -> Result<(), SceneError> {
    match rule {
        Generate::Isotropic { shape: Shape::Sphere { .. }, .. } | Generate::Founder { .. } => Ok(()),
        Generate::Isotropic { .. } => Err(SceneError::bad(
            key.field("isotropic"),
            "isotropic orientations leave the plane; a planar scene can draw spheres only",
        )),
        Generate::Chainmail { .. } => Err(SceneError::bad(
            key.field("chainmail"),
            "interlaced rings lean out of the plane; make the scene spatial",
        )),
    }
}

fn check_force(key: &Key, force: &Force, plane: f64) -> Result<(), SceneError> {
    let across = |name: &'static str, vector: &[f64; 3]| {
        if vector[2] == 0.0 {
            return Ok(());
        }
        let message = format!("must be 0 in a planar scene, not {:?}", vector[2]);
        Err(SceneError::bad(key.field(force.name()).field(name).index(2), message))
    };
    match force {
        Force::Uniform { force, .. } => across("force", force),
        Force::Gravity { acceleration, .. } => across("acceleration", acceleration),
        Force::RadialInward { .. } | Force::RadialOutward { .. } if plane != 0.0 => {
            let message = format!("points out of the plane z = {plane:?}; a radial field needs the plane z = 0");
            Err(SceneError::bad(key.field(force.name()), message))
        }
        Force::RadialInward { .. } | Force::RadialOutward { .. } => Ok(()),
    }
}
