//! The rules of bodies given one by one.

use super::super::error::{FaultKind, SceneError};
use super::super::key::Key;
use super::super::orientation::norm;
use super::super::{Body, BodyLineage, Scene};
use super::shapes::check_shape;
use super::{MAX_BODIES, SMALLEST_QUATERNION, number, numbers};
use std::collections::HashSet;

/// Identities must survive programs that read JSON numbers as 64-bit floats.
const MAX_ID: u64 = 1 << 53;

impl Scene {
    pub(super) fn check_bodies(&self, root: &Key) -> Result<(), SceneError> {
        let key = root.field("bodies");
        if self.bodies.is_empty() && self.generate.is_empty() {
            return Err(SceneError::bad(key, "a scene needs at least one body, here or by `generate`"));
        }
        if self.bodies.len() as u64 > MAX_BODIES {
            let message = format!("{} bodies; at most {MAX_BODIES}", self.bodies.len());
            return Err(SceneError::new(FaultKind::TooLarge, key, message));
        }
        let mut ids = HashSet::new();
        for (i, body) in self.bodies.iter().enumerate() {
            let key = key.index(i);
            check_body(&key, body)?;
            self.check_velocities(&key, body)?;
            if let Some(lineage) = &body.lineage {
                check_lineage(&key.field("lineage"), lineage, &mut ids)?;
            }
        }
        Ok(())
    }

    fn check_velocities(&self, key: &Key, body: &Body) -> Result<(), SceneError> {
        for (name, velocity) in [("velocity", body.velocity), ("angular_velocity", body.angular_velocity)] {
            let Some(velocity) = velocity else { continue };
            let key = key.field(name);
            if !self.dynamics.has_inertia() {
                let message = "has no meaning without inertia; leave it out, or choose the inertial law";
                return Err(SceneError::bad(key, message));
            }
            numbers(&key, &velocity)?;
        }
        Ok(())
    }
}

fn check_body(key: &Key, body: &Body) -> Result<(), SceneError> {
    check_shape(&key.field("shape").field(body.shape.name()), &body.shape)?;
    numbers(&key.field("position"), &body.position)?;
    let key = key.field("orientation");
    numbers(&key, &body.orientation)?;
    let norm = norm(body.orientation);
    if norm < SMALLEST_QUATERNION {
        let message =
            format!("has the norm {norm:e}; it is normalized, so it must be at least {SMALLEST_QUATERNION:e}");
        return Err(SceneError::bad(key, message));
    }
    Ok(())
}

fn check_lineage(key: &Key, lineage: &BodyLineage, ids: &mut HashSet<u64>) -> Result<(), SceneError> {
    number(&key.field("birth"), lineage.birth)?;
    for (name, id) in [("id", Some(lineage.id)), ("parent", lineage.parent)] {
        if id.is_some_and(|id| id >= MAX_ID) {
            return Err(SceneError::bad(key.field(name), format!("must be less than {MAX_ID}")));
        }
    }
    if lineage.parent == Some(lineage.id) {
        return Err(SceneError::bad(key.field("parent"), "must not be the body's own id"));
    }
    if !ids.insert(lineage.id) {
        let message = format!("{} is another body's id already; ids are unique", lineage.id);
        return Err(SceneError::bad(key.field("id"), message));
    }
    Ok(())
}
