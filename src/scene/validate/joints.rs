//! The rules of joints.

use super::super::error::{FaultKind, SceneError};
use super::super::key::Key;
use super::super::{Joint, SMALLEST_NUMBER, Scene, quaternion_norm};
use super::{MAX_BODIES, SMALLEST_QUATERNION, numbers, positive};
use glam::DVec3;

/// How far the axis of a hinge may be from z in a planar scene, as a part of its length.
const ASIDE: f64 = 1e-9;

impl Scene {
    pub(super) fn check_joints(&self, root: &Key) -> Result<(), SceneError> {
        let list = &root.field("joints");
        if self.joints.len() as u64 > MAX_BODIES {
            let message = format!("{} joints; at most {MAX_BODIES}", self.joints.len());
            return Err(SceneError::new(FaultKind::TooLarge, list, message));
        }
        let roster = self.roster();
        let held = self.joints.iter().flat_map(Joint::bodies).max().map_or(0, |last| last.saturating_add(1));
        let anchors = self.anchors(held);
        let is_fixed = |body: usize, group: Option<&str>| anchors.hold(body, group);
        for (i, joint) in self.joints.iter().enumerate() {
            let key = list.index(i);
            let key = key.field(joint.name());
            check_numbers(&key, joint)?;
            self.check_ends(&key, joint.bodies(), &roster, &is_fixed)?;
            self.check_rest(&key, joint)?;
            if let Joint::Hinge { axis: None, .. } = joint
                && !self.planar
            {
                let message = "is required in space: a direction in the axes of the first body, [x, y, z]";
                return Err(SceneError::bad(key.field("axis"), message));
            }
        }
        if self.joints.is_empty() { Ok(()) } else { self.check_supports(root, "joints") }
    }

    /// How a joint rests is given, or its bodies are listed.
    fn check_rest(&self, key: &Key, joint: &Joint) -> Result<(), SceneError> {
        let key = &key.field("rest");
        let listed = |body: &usize| *body < self.bodies.len();
        match joint.rest() {
            Some(Some(rest)) => {
                numbers(key, &rest)?;
                if quaternion_norm(rest) < SMALLEST_QUATERNION {
                    return Err(SceneError::bad(key, "has no direction; write [w, x, y, z]"));
                }
            }
            Some(None) if !joint.bodies().iter().all(listed) => {
                let message = "is required where `generate` places a body: how the second body is oriented in the axes \
                               of the first one, [w, x, y, z]";
                return Err(SceneError::bad(key, message));
            }
            _ => {}
        }
        Ok(())
    }

    /// In a planar scene the points of a joint lie in the plane, hinges turn about z, and what rests does so in the
    /// plane.
    pub(super) fn check_planar_joints(&self, key: &Key) -> Result<(), SceneError> {
        let roster = self.roster();
        for (i, joint) in self.joints.iter().enumerate() {
            let key = key.index(i);
            let key = key.field(joint.name());
            for (end, (body, at)) in joint.bodies().into_iter().zip(joint.at()).enumerate() {
                roster.check_in_plane(&key.field("at").index(end), body, at.into())?;
            }
            let Joint::Hinge { axis: Some(axis), bodies, .. } = *joint else { continue };
            let axis = DVec3::from(axis).normalize();
            let known = roster.body(bodies[0]).and_then(|body| body.rotation);
            if known.is_none_or(|q| (q * axis).truncate().length() > ASIDE) {
                let message = "is not z; hinges of a planar scene turn about z, so omit it";
                return Err(SceneError::bad(key.field("axis"), message));
            }
        }
        Ok(())
    }
}

fn check_numbers(key: &Key, joint: &Joint) -> Result<(), SceneError> {
    for (end, at) in joint.at().iter().enumerate() {
        let list = key.field("at");
        numbers(&list.index(end), at)?;
    }
    let (stiffness, bending) = joint.stiffnesses();
    for (name, value) in [("stiffness", Some(stiffness)), ("bending", bending)] {
        if let Some(value) = value.filter(|value| !value.is_infinite()) {
            positive(&key.field(name), value)?;
        }
    }
    if bending.is_some() && joint.at() == [[0.0; 3]; 2] {
        return Err(SceneError::bad(key.field("at"), "needs an arm: it is at the centre of both bodies"));
    }
    if let Joint::Hinge { axis: Some(axis), .. } = joint {
        numbers(&key.field("axis"), axis)?;
        if DVec3::from(*axis).length() < SMALLEST_NUMBER {
            return Err(SceneError::bad(key.field("axis"), "is no direction"));
        }
    }
    Ok(())
}
