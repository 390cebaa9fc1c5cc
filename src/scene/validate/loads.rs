//! The rules of walls under a load.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::{Scene, Stepping, Wall, WallLoad};
use super::{number, positive};
use glam::DVec3;

/// The cosine of a wall's velocity with its normal that counts as none: enough for six digits.
const ALONG: f64 = 1e-6;

impl Scene {
    /// One force and one resistance; a motion along the wall at most; Euler steps, in which the load is solved with
    /// contact.
    pub(super) fn check_load(&self, wall_key: &Key, wall: &Wall, load: &WallLoad) -> Result<(), SceneError> {
        let key = &wall_key.field("load");
        match (load.force, load.pressure) {
            (Some(force), None) => number(&key.field("force"), force)?,
            (None, Some(pressure)) => self.check_pressure(&key.field("pressure"), wall, pressure)?,
            (None, None) => return Err(SceneError::bad(key, "needs `force` or `pressure`")),
            (Some(_), Some(_)) => {
                return Err(SceneError::bad(key.field("pressure"), "conflicts with `force`: omit one"));
            }
        }
        match (load.drag, load.mass) {
            (Some(drag), None) => positive(&key.field("drag"), drag)?,
            (None, Some(mass)) => positive(&key.field("mass"), mass)?,
            (None, None) => {
                return Err(SceneError::bad(key, "needs `drag` or `mass`, which the load moves the wall against"));
            }
            (Some(_), Some(_)) => return Err(SceneError::bad(key.field("mass"), "conflicts with `drag`: omit one")),
        }
        if let Some(velocity) = load.velocity {
            number(&key.field("velocity"), velocity)?;
            if load.mass.is_none() {
                let message = "needs `mass`: the velocity of a wall with drag follows from its load";
                return Err(SceneError::bad(key.field("velocity"), message));
            }
        }
        self.check_moves_along(wall_key, wall)?;
        if self.time.stepping == Stepping::Midpoint {
            return Err(SceneError::bad(key, "needs Euler steps: set time.stepping to \"euler\""));
        }
        if self.contact.restitution.walls > 0.0 {
            let message = "conflicts with contact.restitution.walls, which walls under a load do not support";
            return Err(SceneError::bad(key, message));
        }
        Ok(())
    }

    /// A pressure acts on an area that is known and constant.
    fn check_pressure(&self, key: &Key, wall: &Wall, pressure: f64) -> Result<(), SceneError> {
        number(key, pressure)?;
        let strained = self.periodic.is_some_and(|cell| cell.strain_rate.is_some());
        if strained || wall.areas(&self.periods(), self.planar).first().copied().flatten().is_none() {
            let message = "needs a wall of constant area: make all directions along it periodic, without periodic.strain_rate, or give `force`";
            return Err(SceneError::bad(key, message));
        }
        Ok(())
    }

    /// The load determines the motion along the normal.
    fn check_moves_along(&self, key: &Key, wall: &Wall) -> Result<(), SceneError> {
        let (Some(motion), Wall::HalfSpace { normal, .. }) = (wall.motion(), wall) else { return Ok(()) };
        let key = key.field("motion");
        if motion.angular_velocity.is_some_and(|turning| turning != [0.0; 3]) {
            return Err(SceneError::bad(
                key.field("angular_velocity"),
                "conflicts with `load`: a wall under a load does not turn",
            ));
        }
        let (velocity, normal) = (DVec3::from(motion.velocity), DVec3::from(*normal));
        if velocity.dot(normal).abs() > ALONG * velocity.length() * normal.length() {
            let message = "must be along the wall, as `load` determines how it moves along its normal";
            return Err(SceneError::bad(key.field("velocity"), message));
        }
        Ok(())
    }
}
