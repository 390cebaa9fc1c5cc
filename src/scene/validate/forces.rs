//! The rules of forces.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::nearest::nearest;
use super::super::{Force, Scene, Stepping, Window};
use super::{SMALLEST_NUMBER, number, numbers, positive};
use glam::DVec3;

/// Most different windows of a scene: their shares are parameters of a kernel, of which 256 bytes are one part.
const MOST_WINDOWS: usize = 24;

impl Scene {
    pub(super) fn check_forces(&self, key: &Key) -> Result<(), SceneError> {
        let mut windows: Vec<&Window> = Vec::new();
        for (i, force) in self.forces.iter().enumerate() {
            let key = key.index(i);
            let key = key.field(force.name());
            check_numbers(&key, force)?;
            if force.needs_mass() && !self.dynamics.has_inertia() {
                let message = "needs the inertial law, where bodies have mass; `uniform` is a force per body";
                return Err(SceneError::bad(key, message));
            }
            self.check_group(&key, force.group())?;
            let Some(window) = force.window() else { continue };
            let key = key.field("window");
            check_window(&key, window)?;
            if !windows.contains(&window) {
                windows.push(window);
            }
            if windows.len() > MOST_WINDOWS {
                let message = format!("is the scene's window number {}; at most {MOST_WINDOWS} differ", windows.len());
                return Err(SceneError::bad(key, message));
            }
        }
        Ok(())
    }

    /// What Brownian motion needs: a resistance, and steps of first order.
    pub(super) fn check_thermal(&self, root: &Key) -> Result<(), SceneError> {
        let Some(thermal) = &self.thermal else { return Ok(()) };
        let key = root.field("thermal");
        positive(&key.field("temperature"), thermal.temperature)?;
        if self.dynamics.has_inertia() && self.dynamics.drag_beside_inertia().is_none() {
            let message =
                "needs a resistance, which heat belongs to: give dynamics.inertial.drag, or choose the overdamped law";
            return Err(SceneError::bad(key, message));
        }
        if self.time.stepping == Stepping::Midpoint {
            let message = "random loads make steps with a middle no more exact; with `thermal`, leave it \"euler\"";
            return Err(SceneError::bad(root.field("time").field("stepping"), message));
        }
        Ok(())
    }

    /// A group that is named has bodies.
    pub(super) fn check_group(&self, key: &Key, group: Option<&str>) -> Result<(), SceneError> {
        let groups = self.group_names();
        let Some(group) = group.filter(|g| !groups.iter().any(|known| known == g)) else { return Ok(()) };
        let message = match nearest(group, groups.iter().map(String::as_str)) {
            Some(near) => format!("no body is in the group `{group}`; the nearest group is `{near}`"),
            None => format!("no body is in the group `{group}`; no body has a group"),
        };
        Err(SceneError::bad(key.field("group"), message))
    }
}

fn check_numbers(key: &Key, force: &Force) -> Result<(), SceneError> {
    if let Some((name, vector)) = force.vector() {
        numbers(&key.field(name), vector)?;
    }
    if let Some((name, value)) = force.positive() {
        positive(&key.field(name), value)?;
    }
    if let (Some(strength), Some((name, axis))) = (force.along_axis(), force.vector()) {
        number(&key.field("force"), strength)?;
        if DVec3::from(*axis).abs().max_element() < SMALLEST_NUMBER {
            return Err(SceneError::bad(key.field(name), "must have a direction; [0, 0, 1] is the body's own z"));
        }
    }
    match force.trap() {
        Some((_, [false, false, false])) => {
            Err(SceneError::bad(key.field("axes"), "must be true for an axis at least; without it, it is for all"))
        }
        _ => Ok(()),
    }
}

pub(super) fn check_window(key: &Key, window: &Window) -> Result<(), SceneError> {
    let Window { from, to, period, duty } = *window;
    if *window == Window::default() {
        return Err(SceneError::bad(key, "must have `from`, `to` or `period`; without a window it is always on"));
    }
    from.map_or(Ok(()), |from| number(&key.field("from"), from))?;
    to.map_or(Ok(()), |to| number(&key.field("to"), to))?;
    if let (Some(from), Some(to)) = (from, to)
        && to <= from
    {
        return Err(SceneError::bad(key.field("to"), format!("must be later than `from`, {from:?}, not {to:?}")));
    }
    period.map_or(Ok(()), |period| positive(&key.field("period"), period))?;
    let Some(duty) = duty else { return Ok(()) };
    let key = key.field("duty");
    if period.is_none() {
        return Err(SceneError::bad(key, "is a part of a period; give `period`, or leave it out"));
    }
    positive(&key, duty)?;
    if duty > 1.0 {
        return Err(SceneError::bad(key, format!("is a part of the period, at most 1, not {duty:?}")));
    }
    Ok(())
}
