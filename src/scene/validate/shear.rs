//! The rules of a periodic cell that is sheared.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::{Periodic, Scene};
use super::number;
use crate::digits::{at_most, short};

/// What the flow may part two touching bodies by in a step, in thicknesses of the thinnest: as rows are made where it
/// leads, no deeper than where normals may point to the wrong side.
const MOST_PARTED: f64 = 0.125;

impl Scene {
    /// A shear along one period and across another, slow enough for a step, of which the offset is a number that floats
    /// know until the run's end; and what is there that its flow carries.
    pub(super) fn check_shear(&self, root: &Key, cell: &Periodic) -> Result<(), SceneError> {
        let Some(shear) = &cell.shear else { return Ok(()) };
        let key = root.field("periodic");
        let key = key.field("shear");
        number(&key.field("rate"), shear.rate)?;
        if shear.gradient <= shear.direction {
            let message = "must be an axis after `direction`, as in the tilts xy, xz and yz of other programs: rename the axes of the scene";
            return Err(SceneError::bad(key.field("gradient"), message));
        }
        for (name, axis) in [("direction", shear.direction), ("gradient", shear.gradient)] {
            if cell.lengths[axis.index()].is_none() {
                let message = format!(
                    "must be a periodic axis: set periodic.lengths.{}, or omit `shear` and use `flow`",
                    axis.index()
                );
                return Err(SceneError::bad(key.field(name), message));
            }
        }
        if cell.strain_rate.is_some() {
            let message = "needs constant lengths; omit `shear` or `strain_rate`";
            return Err(SceneError::bad(key, message));
        }
        if self.flow.is_some() {
            let message = "already defines a flow; omit `flow`";
            return Err(SceneError::bad(key, message));
        }
        self.check_goes_with_cell(root, &key, "shear")?;
        if self.dynamics.drag().is_some() || self.dynamics.drag_beside_inertia().is_some() {
            self.check_shapes_in_flow(&key)?;
        }
        self.check_shear_rate(&key.field("rate"), shear.rate, cell.lengths[shear.gradient.index()].unwrap_or_default())
    }

    fn check_shear_rate(&self, key: &Key, rate: f64, across: f64) -> Result<(), SceneError> {
        let growing = self.growing().map(|(_, _, shape, growth, _)| self.longest(&shape, growth));
        let shapes = growing.chain(self.shapes().map(|(_, _, shape)| shape));
        let longest = shapes.map(|shape| 2.0 * shape.bounding_radius()).fold(0.0, f64::max);
        let (parted, most) = (rate.abs() * self.time.dt * longest, MOST_PARTED * self.thinnest());
        if parted > most {
            let message = format!(
                "separates the ends of the longest body by {parted} in a step; at most {most}, an eighth of the thinnest body: a smaller time.dt helps",
                parted = short(parted),
                most = at_most(most)
            );
            return Err(SceneError::bad(key, message));
        }
        let farthest = (rate * across).abs() * self.time.start.abs().max(self.time.end.abs());
        if farthest * f64::EPSILON > self.contact.overlap_tolerance {
            let message = format!(
                "displaces images by {farthest} until the run's end, where 64-bit floats are coarser than contact.overlap_tolerance: end the run earlier",
                farthest = short(farthest)
            );
            return Err(SceneError::bad(key, message));
        }
        Ok(())
    }
}
