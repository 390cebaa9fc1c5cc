//! The rules of the law of motion and of its drag.

use super::super::Scene;
use super::super::error::SceneError;
use super::super::key::Key;
use super::positive;
use crate::dynamics::Drag;

impl Scene {
    /// Coefficients are positive, and a fluid's drag on each shape is known.
    pub(super) fn check_dynamics(&self, key: &Key) -> Result<(), SceneError> {
        let key = key.field(self.dynamics.name());
        if let Some(density) = self.dynamics.density() {
            positive(&key.field("density"), density)?;
        }
        let Some(drag) = self.dynamics.any_drag() else { return Ok(()) };
        let key = key.field("drag");
        for (name, coefficient) in drag.coefficients() {
            match name {
                Some(name) => positive(&key.field(name), coefficient)?,
                None => positive(&key, coefficient)?,
            }
        }
        match drag {
            Drag::Viscosity(_) => self.check_shapes_in_fluid(&key.field("viscosity")),
            _ => Ok(()),
        }
    }

    fn check_shapes_in_fluid(&self, key: &Key) -> Result<(), SceneError> {
        let unknown = self.shapes().find(|(_, _, shape)| shape.is_general());
        let Some((list, index, shape)) = unknown else { return Ok(()) };
        let message = format!(
            "{list}.{index} is a {name}, whose drag in a fluid is not known; give `parallel` and `perpendicular`, or a number",
            name = shape.name()
        );
        Err(SceneError::bad(key, message))
    }
}
