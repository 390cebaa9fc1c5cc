//! The rules of a background flow.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::{Flow, Scene};
use super::{number, numbers};
use crate::digits::{exact, short};
use glam::DVec3;

/// How far a vector may be from a unit one, and the cosine of two from zero: enough for six digits.
const UNIT_TOLERANCE: f64 = 1e-6;

impl Scene {
    /// What a flow needs: unit vectors at right angles, in a planar scene in the plane; a resistance; shapes whose turn
    /// in a flow is known; and no period along which it changes.
    pub(super) fn check_flow(&self, root: &Key) -> Result<(), SceneError> {
        let Some(flow) = &self.flow else { return Ok(()) };
        let key = root.field("flow");
        let Flow::Shear { rate, direction, gradient } = flow;
        let shear = key.field("shear");
        number(&shear.field("rate"), *rate)?;
        for (name, vector) in [("direction", direction), ("gradient", gradient)] {
            self.check_unit(&shear.field(name), vector)?;
        }
        let cosine = DVec3::from(*direction).dot(DVec3::from(*gradient));
        if cosine.abs() > UNIT_TOLERANCE {
            let message = format!(
                "must be at right angles to `direction`, as a shear flow does not change along itself; the cosine is {cosine}",
                cosine = short(cosine)
            );
            return Err(SceneError::bad(shear.field("gradient"), message));
        }
        if self.dynamics.has_inertia() && self.dynamics.drag_beside_inertia().is_none() {
            let message = "needs drag to carry bodies: set dynamics.inertial.drag, or choose the overdamped law";
            return Err(SceneError::bad(key, message));
        }
        self.check_shapes_in_flow(&key)?;
        self.check_flow_is_periodic(&shear.field("gradient"), gradient)
    }

    fn check_unit(&self, key: &Key, vector: &[f64; 3]) -> Result<(), SceneError> {
        numbers(key, vector)?;
        let length = DVec3::from(*vector).length();
        if (length - 1.0).abs() > UNIT_TOLERANCE {
            let message =
                format!("must be a unit vector, as [1, 0, 0] is; its length is {length}", length = short(length));
            return Err(SceneError::bad(key, message));
        }
        if self.planar && vector[2] != 0.0 {
            let message = format!("must be 0 in a planar scene, not {}", exact(vector[2]));
            return Err(SceneError::bad(key.index(2), message));
        }
        Ok(())
    }

    pub(super) fn check_shapes_in_flow(&self, key: &Key) -> Result<(), SceneError> {
        for (list, index, shape) in self.shapes() {
            if shape.bretherton().is_none() {
                let message = format!(
                    "{list}.{index} is a {name}, whose rotation in a flow is not known; omit the flow or choose another shape",
                    name = shape.name()
                );
                return Err(SceneError::bad(key, message));
            }
        }
        Ok(())
    }

    fn check_flow_is_periodic(&self, key: &Key, gradient: &[f64; 3]) -> Result<(), SceneError> {
        let Some(periodic) = &self.periodic else { return Ok(()) };
        let across = |axis: &usize| periodic.lengths[*axis].is_some() && gradient[*axis] != 0.0;
        let Some(axis) = (0..3).find(across) else { return Ok(()) };
        let message = format!(
            "makes the flow change along {}, a periodic axis: images of a body would move apart; set periodic.lengths.{axis} to null, or choose a gradient across the periodic axes",
            ["x", "y", "z"][axis]
        );
        Err(SceneError::bad(key.index(axis), message))
    }
}
