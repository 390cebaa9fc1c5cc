//! The rules of planar scenes: everything is mirrored by one plane of constant z, and stays so.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::{Body, Force, Generate, Repeat, Scene, generate};
use super::patterns::{check_planar_chain, check_planar_fence, check_planar_lattice, flat};
use crate::digits::exact;
use crate::dynamics::Load;
use crate::shape::PLANAR_TOLERANCE;
use glam::{DQuat, DVec3};

impl Scene {
    pub(super) fn check_planar(&self, root: &Key) -> Result<(), SceneError> {
        let plane = self.plane();
        for (i, body) in self.bodies.iter().enumerate() {
            check_body(&root.field("bodies").index(i), body, plane)?;
            self.check_growing(&root.field("bodies").index(i), body)?;
        }
        for (i, rule) in self.generate.iter().enumerate() {
            check_rule(&root.field("generate").index(i), rule)?;
            self.check_standing(&root.field("generate").index(i), rule)?;
        }
        for (i, force) in self.forces.iter().enumerate() {
            self.check_planar_force(&root.field("forces").index(i), force, plane)?;
        }
        self.check_planar_bonds(&root.field("bonds"))?;
        self.check_planar_joints(&root.field("joints"))
    }

    fn check_planar_force(&self, key: &Key, force: &Force, plane: f64) -> Result<(), SceneError> {
        let key = key.field(force.name());
        if force.is_radial() && plane != 0.0 {
            let message = format!(
                "points out of the plane z = {plane}; a radial field needs the plane z = 0",
                plane = exact(plane)
            );
            return Err(SceneError::bad(key, message));
        }
        if let Some((center, [_, _, true])) = force.trap()
            && center[2] != plane
        {
            let message = format!(
                "must be that of the plane, {plane}, not {}; or set axes[2] to false",
                exact(center[2]),
                plane = exact(plane)
            );
            return Err(SceneError::bad(key.field("center").index(2), message));
        }
        if let Force::Pull { target, .. } = force
            && target[2] != plane
        {
            let message = format!("must be that of the plane, {}, not {}", exact(plane), exact(target[2]));
            return Err(SceneError::bad(key.field("target").index(2), message));
        }
        if force.turns_with_body() { self.check_turning(&key, force) } else { check_fixed(&key, force) }
    }

    /// A force that turns with its bodies stays in the plane where it is in it for each.
    fn check_turning(&self, key: &Key, force: &Force) -> Result<(), SceneError> {
        let Some((name, _)) = force.vector() else { return Ok(()) };
        let key = key.field(name);
        let on = |group: Option<&str>| force.group().is_none_or(|only| group == Some(only));
        for (i, body) in self.bodies.iter().enumerate().filter(|(_, body)| on(body.group.as_deref())) {
            if leaves_plane(force, body.rotation()) {
                let message = format!("points out of the plane on bodies.{i}, as that is oriented; {}", remedy(force));
                return Err(SceneError::bad(key, message));
            }
        }
        for (i, (_, shape, _)) in self.generated().filter(|(_, (.., group))| on(*group)) {
            match generate::planar_orientation(&self.generate[i], &shape) {
                Some(orientation) if !leaves_plane(force, orientation) => {}
                _ => {
                    let message = format!(
                        "points out of the plane on bodies that generate.{i} places; {}, or list the bodies in `bodies`",
                        remedy(force)
                    );
                    return Err(SceneError::bad(key, message));
                }
            }
        }
        Ok(())
    }

    /// The z of all bodies of a planar scene.
    pub(crate) fn plane(&self) -> f64 {
        match self.bodies.first() {
            Some(body) if self.generate.is_empty() => body.position[2],
            _ => 0.0,
        }
    }

    /// A cell that stands upright in the plane is mirrored by it, but its daughters would not be.
    fn check_growing(&self, key: &Key, body: &Body) -> Result<(), SceneError> {
        let axis = body.rotation() * DVec3::Z;
        let grows = self.growth_of_body(body.group.as_deref(), &body.shape).is_some();
        if grows && axis.z.abs() > PLANAR_TOLERANCE {
            return Err(SceneError::bad(
                key.field(body.orientation_key()),
                "a growing body of a planar scene must lie in the x-y plane",
            ));
        }
        Ok(())
    }
}

impl Scene {
    /// The same for the bodies of a lattice.
    fn check_standing(&self, key: &Key, rule: &Generate) -> Result<(), SceneError> {
        let Generate::Lattice(lattice) = rule else { return Ok(()) };
        let grows = self.growth_of_body(lattice.group.as_deref(), &lattice.shape).is_some();
        let axis = generate::orientation_of_lattice(lattice) * DVec3::Z;
        if grows && !lattice.random && axis.z.abs() > PLANAR_TOLERANCE {
            let message = "growing bodies of a planar scene must lie in the x-y plane";
            return Err(SceneError::bad(key.field(rule.name()).field("axis"), message));
        }
        Ok(())
    }
}

fn check_body(key: &Key, body: &Body, plane: f64) -> Result<(), SceneError> {
    if body.position[2] != plane {
        let message = format!(
            "bodies of a planar scene share one z, here {plane}, not {}",
            exact(body.position[2]),
            plane = exact(plane)
        );
        return Err(SceneError::bad(key.field("position").index(2), message));
    }
    if !body.shape.is_planar_symmetric(body.rotation()) {
        let message = "the body must be mirrored by the plane: its axis in it or across it, or one of its principal axes across it";
        return Err(SceneError::bad(key.field(body.orientation_key()), message));
    }
    let zero = |name: &'static str, index: usize, value: f64| {
        if value == 0.0 {
            Ok(())
        } else {
            Err(SceneError::bad(
                key.field(name).index(index),
                format!("must be 0 in a planar scene, not {value}", value = exact(value)),
            ))
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

fn check_rule(key: &Key, rule: &Generate) -> Result<(), SceneError> {
    match rule {
        Generate::Isotropic { .. } if rule.components().any(|(_, shape, _)| shape.is_general()) => {
            let message = "superellipsoids and custom shapes need not be mirrored by the plane as they are drawn; list the bodies in `bodies`";
            Err(SceneError::bad(key.field("isotropic"), message))
        }
        Generate::Founder { position: [.., z], .. } | Generate::Isotropic { center: [.., z], .. } if *z != 0.0 => {
            let place = if matches!(rule, Generate::Founder { .. }) { "position" } else { "center" };
            let message = format!("bodies placed by rule are in the plane z = 0, not {z}", z = exact(*z));
            Err(SceneError::bad(key.field(rule.name()).field(place).index(2), message))
        }
        Generate::Isotropic { .. } => Ok(()),
        Generate::Founder { repeat, .. } => check_copies(key, rule, repeat),
        Generate::Lattice(lattice) => check_planar_lattice(&key.field(rule.name()), lattice),
        Generate::Fence(fence) => {
            check_planar_fence(&key.field(rule.name()), fence)?;
            check_copies(key, rule, &fence.repeat)
        }
        Generate::Chain(chain) => {
            check_planar_chain(&key.field(rule.name()), chain)?;
            check_copies(key, rule, &chain.repeat)
        }
        Generate::Chainmail { .. } => Err(SceneError::bad(
            key.field("chainmail"),
            "interlaced rings lean out of the plane; make the scene spatial",
        )),
    }
}

/// Copies beside each other in the plane.
fn check_copies(key: &Key, rule: &Generate, repeat: &[Repeat]) -> Result<(), SceneError> {
    let rule = key.field(rule.name());
    let list = rule.field("repeat");
    repeat.iter().enumerate().try_for_each(|(i, of)| flat(&list.index(i).field("offset"), &of.offset))
}

/// A force whose vector is in space axes: only a load in the plane is allowed.
fn check_fixed(key: &Key, force: &Force) -> Result<(), SceneError> {
    let (Some(load), Some((name, vector))) = (force.everywhere(DQuat::IDENTITY), force.vector()) else {
        return Ok(());
    };
    let out = [load.torque.x, load.torque.y, load.force.z];
    let key = key.field(name);
    match out.iter().position(|part| *part != 0.0) {
        Some(axis) => {
            let message = format!("must be 0 in a planar scene, not {}", exact(vector[axis]));
            Err(SceneError::bad(key.index(axis), message))
        }
        None => Ok(()),
    }
}

/// Whether a force on a body in `orientation` leaves the plane by more than rounding.
fn leaves_plane(force: &Force, orientation: DQuat) -> bool {
    let Load { force, torque } = force.everywhere(orientation).unwrap_or_default();
    let out = force.z.abs().max(torque.x.abs()).max(torque.y.abs());
    out > PLANAR_TOLERANCE * (force.length() + torque.length())
}

/// What makes such a force one in the plane.
fn remedy(force: &Force) -> &'static str {
    match force.along_axis() {
        Some(_) => "choose an axis that is in the plane there",
        None => "a torque about z of space has `frame`: \"space\"",
    }
}
