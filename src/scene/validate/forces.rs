//! The rules of forces.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::nearest::nearest;
use super::super::{Force, Scene, Stepping, Window};
use super::{SMALLEST_NUMBER, number, numbers, positive};
use crate::bodies::NO_GROUP;
use crate::digits::{at_most, exact};
use crate::dynamics::longest_stable_step;
use crate::shape::Shape;
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
            self.check_pull(&key, force)?;
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

    /// The numbers of a pull, and whether it is too stiff or too damped for the step: for the body of `bodies` that has
    /// its id, else for any body that the scene starts with. What is in the run's state only its start knows.
    fn check_pull(&self, key: &Key, force: &Force) -> Result<(), SceneError> {
        let Force::Pull { body, stiffness, point, most, damping, .. } = force else { return Ok(()) };
        numbers(&key.field("point"), point)?;
        most.map_or(Ok(()), |most| positive(&key.field("most"), most))?;
        damping.map_or(Ok(()), |damping| positive(&key.field("damping"), damping))?;
        if damping.is_some() && !self.dynamics.has_inertia() {
            let message = "needs the inertial law: without inertia the velocity follows from the forces";
            return Err(SceneError::bad(key.field("damping"), message));
        }
        let (dt, midpoint) = (self.time.dt, self.time.stepping == Stepping::Midpoint);
        let own = self.bodies.iter().zip(self.ids()).find(|(_, id)| id == body).map(|(own, _)| own.shape);
        let shapes: Vec<Shape> = match own {
            Some(shape) => vec![shape],
            None => {
                let listed = self.bodies.iter().map(|body| self.shortest(&body.shape, body.group.as_deref()));
                listed.chain(self.generated().map(|(_, (_, shape, group))| self.shortest(&shape, group))).collect()
            }
        };
        for shape in &shapes {
            let (way, turn) = self.dynamics.yields(shape, dt);
            // A pull beside the centre also turns the body towards the target.
            let lever = DVec3::from(*point).length_squared() * turn.max_element() / way;
            let stiffness = stiffness * (1.0 + lever);
            if let Some(longest) = longest_stable_step(&self.dynamics, midpoint, shape, stiffness, dt) {
                let message = format!(
                    "is too stiff for time.dt, {dt}: the body would leave the target, faster in each step; the longest stable step is {}",
                    at_most(longest),
                    dt = exact(dt)
                );
                return Err(SceneError::bad(key.field("stiffness"), message));
            }
            if damping.is_some_and(|damping| damping * way > dt) {
                let message = format!("stops the body within a step; at most {}", at_most(dt / way));
                return Err(SceneError::bad(key.field("damping"), message));
            }
        }
        Ok(())
    }

    /// Traps that are too stiff for the step: bodies would leave them faster and faster.
    pub(super) fn check_traps(&self, key: &Key) -> Result<(), SceneError> {
        if !self.forces.iter().any(|force| force.trap().is_some()) {
            return Ok(());
        }
        let fixed = self.fixed();
        let names = self.group_names();
        let number = |group: Option<&str>| group.and_then(|group| names.iter().position(|name| name == group));
        let bodies = self.bodies.iter().zip(self.ids()).enumerate();
        let bodies = bodies.map(|(i, (body, id))| ("bodies", i, id, body.shape, body.group.as_deref()));
        let moving = self.generated().filter(|(i, _)| !self.generate[*i].is_fixed());
        let rules = moving.map(|(i, (_, shape, group))| ("generate", i, u64::MAX, shape, group));
        for (list, i, id, shape, group) in bodies.chain(rules) {
            if !fixed.holds(id, number(group).map_or(NO_GROUP, |number| number as u32)) {
                self.check_trapped(key, &format!("{list}.{i}"), &self.shortest(&shape, group), group)?;
            }
        }
        Ok(())
    }

    /// The shape at the shortest that it is: a cell that divides leaves shorter ones.
    fn shortest(&self, shape: &Shape, group: Option<&str>) -> Shape {
        self.growth_of_body(group, shape).map_or(*shape, |(growth, _)| growth.shortest(shape))
    }

    fn check_trapped(&self, key: &Key, name: &str, shape: &Shape, group: Option<&str>) -> Result<(), SceneError> {
        let on = |force: &Force| force.group().is_none_or(|only| group == Some(only));
        let traps = || self.forces.iter().enumerate().filter(|(_, force)| on(force));
        for axis in 0..if self.planar { 2 } else { 3 } {
            let along = |force: &Force| {
                let stiffness = force.positive().map(|(_, stiffness)| stiffness);
                force.trap().filter(|(_, axes)| axes[axis]).and(stiffness).unwrap_or(0.0)
            };
            let dt = self.time.dt;
            // Of traps with windows one acts at a time, as far as is known, and none that acts in parts of steps alone.
            let lasting =
                |force: &Force| force.window().map_or(f64::INFINITY, |window| window.longest(self.time.start));
            let always: f64 = traps().filter(|(_, f)| lasting(f) == f64::INFINITY).map(|(_, f)| along(f)).sum();
            let at_times = traps().filter(|(_, f)| (2.0 * dt..f64::INFINITY).contains(&lasting(f)));
            let at_times = at_times.map(|(_, f)| along(f)).fold(0.0, f64::max);
            let midpoint = self.time.stepping == Stepping::Midpoint;
            let Some(longest) = longest_stable_step(&self.dynamics, midpoint, shape, always + at_times, dt) else {
                continue;
            };
            let Some((i, force)) = traps().max_by(|(_, a), (_, b)| along(a).total_cmp(&along(b))) else { continue };
            let message = format!(
                "is too stiff for time.dt, {dt}: {name} would leave the trap, faster in each step; the longest stable step is {}, and one of a tenth of it is near the exact motion",
                at_most(longest),
                dt = exact(dt)
            );
            return Err(SceneError::bad(key.index(i).field(force.name()).field("stiffness"), message));
        }
        Ok(())
    }

    /// What Brownian motion needs: a resistance, and steps of first order.
    pub(super) fn check_thermal(&self, root: &Key) -> Result<(), SceneError> {
        let Some(thermal) = &self.thermal else { return Ok(()) };
        let key = root.field("thermal");
        positive(&key.field("temperature"), thermal.temperature)?;
        if self.dynamics.has_inertia() && self.dynamics.drag_beside_inertia().is_none() {
            let message = "needs drag: set dynamics.inertial.drag, or choose the overdamped law";
            return Err(SceneError::bad(key, message));
        }
        if self.time.stepping == Stepping::Midpoint {
            let message = "midpoint steps are no more exact with random loads; with `thermal`, leave it \"euler\"";
            return Err(SceneError::bad(root.field("time").field("stepping"), message));
        }
        Ok(())
    }

    /// A group that is named has bodies.
    pub(super) fn check_group(&self, key: &Key, group: Option<&str>) -> Result<(), SceneError> {
        group.map_or(Ok(()), |group| self.check_name_of_group(&key.field("group"), group))
    }

    /// That a body has this group, which `key` names.
    pub(super) fn check_name_of_group(&self, key: &Key, group: &str) -> Result<(), SceneError> {
        let groups = self.group_names();
        if groups.iter().any(|known| known == group) {
            return Ok(());
        }
        let message = match nearest(group, groups.iter().map(String::as_str)) {
            Some(near) => format!("no body is in the group `{group}`; the nearest group is `{near}`"),
            None if groups.is_empty() => format!("no body is in the group `{group}`; no body has a group"),
            None => format!("no body is in the group `{group}`; the groups are {}", groups.join(", ")),
        };
        Err(SceneError::bad(key, message))
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
            Err(SceneError::bad(key.field("axes"), "must be true for at least one axis; omit it for all axes"))
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
        return Err(SceneError::bad(
            key.field("to"),
            format!("must be later than `from`, {from}, not {to}", from = exact(from), to = exact(to)),
        ));
    }
    period.map_or(Ok(()), |period| positive(&key.field("period"), period))?;
    let Some(duty) = duty else { return Ok(()) };
    let key = key.field("duty");
    if period.is_none() {
        return Err(SceneError::bad(key, "is a fraction of a period; set `period`, or omit it"));
    }
    positive(&key, duty)?;
    if duty > 1.0 {
        return Err(SceneError::bad(
            key,
            format!("is a part of the period, at most 1, not {duty}", duty = exact(duty)),
        ));
    }
    Ok(())
}
