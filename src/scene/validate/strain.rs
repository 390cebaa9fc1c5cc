//! The rules of a periodic cell whose lengths change.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::{Periodic, Scene, Stepping};
use super::numbers;
use crate::digits::{at_most, exact, short};

/// What a cell's side may move by in a step, in thicknesses of the thinnest body: less than what bodies must get deeper
/// into each other by to count as passing, and than what rows may be off by.
const MOST_MOVED: f64 = 0.125;

impl Scene {
    /// A cell that changes along its periods only, that stays long enough until the run's end and is slow enough for a
    /// step; and what is there that its flow carries.
    pub(super) fn check_strain(&self, root: &Key, cell: &Periodic) -> Result<(), SceneError> {
        let Some(rates) = &cell.strain_rate else { return Ok(()) };
        let key = root.field("periodic");
        let key = key.field("strain_rate");
        numbers(&key, rates)?;
        for axis in 0..3 {
            self.check_rate(root, &key, cell, axis)?;
        }
        if self.dynamics.has_inertia() && self.dynamics.drag_beside_inertia().is_none() {
            let message = "needs drag for the cell's flow to carry bodies: set dynamics.inertial.drag, or choose the overdamped law";
            return Err(SceneError::bad(key, message));
        }
        if self.flow.is_some() {
            let message = "already defines a flow; omit `flow`, or keep the cell's lengths constant";
            return Err(SceneError::bad(key, message));
        }
        self.check_goes_with_cell(root, &key, "strain_rate")?;
        self.check_shapes_in_flow(&key)
    }

    /// What a cell that changes by this key of `periodic` does not carry is not there.
    pub(super) fn check_goes_with_cell(&self, root: &Key, key: &Key, name: &str) -> Result<(), SceneError> {
        if self.time.stepping == Stepping::Midpoint {
            let message = format!(
                "midpoint steps are no more exact for contacts through a changing cell's sides; with `periodic.{name}`, leave it \"euler\""
            );
            return Err(SceneError::bad(root.field("time").field("stepping"), message));
        }
        if self.fixed().any() {
            let message = "moves the images of a body apart, which a fixed body cannot follow; omit `fixed`";
            return Err(SceneError::bad(key, message));
        }
        if let Some((i, force)) = self.forces.iter().enumerate().find(|(_, force)| force.trap().is_some()) {
            let message = format!(
                "pulls to one point, whose images a changing cell would move apart; omit it, or `periodic.{name}`"
            );
            return Err(SceneError::bad(root.field("forces").index(i).field(force.name()), message));
        }
        Ok(())
    }

    fn check_rate(&self, root: &Key, key: &Key, cell: &Periodic, axis: usize) -> Result<(), SceneError> {
        let (rate, key) = (cell.strain_rate.unwrap_or_default()[axis], key.index(axis));
        let Some(length) = cell.lengths[axis] else {
            let message = format!("must be 0 along an axis without a period, not {rate}", rate = exact(rate));
            return if rate == 0.0 { Ok(()) } else { Err(SceneError::bad(key, message)) };
        };
        for time in [self.time.start, self.time.end] {
            if 1.0 + rate * time <= 0.0 {
                let message = format!(
                    "leaves the cell no length at the time {time}: its length is {length} (1 + rate t)",
                    time = exact(time),
                    length = short(length)
                );
                return Err(SceneError::bad(key, message));
            }
            self.check_length(&root.field("periodic").field("lengths").index(axis), length * (1.0 + rate * time))?;
        }
        let (moved, most) = ((rate * length * self.time.dt).abs(), MOST_MOVED * self.thinnest());
        if moved > most {
            let message = format!(
                "changes the length by {moved} in a step; at most {most}, an eighth of the thinnest body: a smaller time.dt helps",
                moved = short(moved),
                most = at_most(most)
            );
            return Err(SceneError::bad(key, message));
        }
        Ok(())
    }
}
