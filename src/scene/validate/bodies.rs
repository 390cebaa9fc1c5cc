//! The rules of bodies given one by one.

use super::super::error::{FaultKind, SceneError};
use super::super::key::Key;
use super::super::nearest::nearest;
use super::super::orientation::norm;
use super::super::{Body, BodyLineage, Scene};
use super::shapes::check_shape;
use super::{MAX_BODIES, SMALLEST_NUMBER, SMALLEST_QUATERNION, number, numbers, positive};
use crate::bodies::NO_GROUP;
use crate::digits::short;
use crate::dynamics::bonds::daughters::LARGEST_END;
use crate::shape::Shape;
use glam::DVec3;
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
            self.check_orientation(&key, body)?;
            self.check_velocities(&key, body)?;
            check_daughter_bonds(&key, body)?;
            if let Some(lineage) = &body.lineage {
                check_lineage(&key.field("lineage"), lineage, &mut ids)?;
            }
        }
        self.check_all_daughter_bonds(&key)?;
        self.check_next_id(root)
    }

    /// No two bodies have the same number at the same end, and the bonds have settings.
    fn check_all_daughter_bonds(&self, key: &Key) -> Result<(), SceneError> {
        let has_settings = self.growth.iter().any(|growth| growth.bond_daughters.is_some());
        let mut seen: [HashSet<u64>; 2] = Default::default();
        for (i, body) in self.bodies.iter().enumerate() {
            let Some(ends) = body.daughter_bonds else { continue };
            let body = key.index(i);
            let key = body.field("daughter_bonds");
            if !has_settings {
                let why = "needs growth.bond_daughters, which has the settings of these bonds";
                return Err(SceneError::bad(key, why));
            }
            for (end, number) in ends.into_iter().enumerate().filter(|(_, number)| *number > 0) {
                if !seen[end].insert(number) {
                    let side = ["lower", "upper"][end];
                    let why = format!(
                        "is the number at the {side} end of another body too; a bond joins an upper and a lower end"
                    );
                    return Err(SceneError::bad(key.index(end), why));
                }
            }
        }
        Ok(())
    }

    /// An id that a body had may not be given again.
    fn check_next_id(&self, root: &Key) -> Result<(), SceneError> {
        let Some(next) = self.next_id else { return Ok(()) };
        let key = root.field("next_id");
        if next > MAX_ID {
            return Err(SceneError::bad(key, format!("must be at most {MAX_ID}")));
        }
        let had = self.bodies.iter().filter_map(|body| body.lineage).map(|line| line.id.max(line.parent.unwrap_or(0)));
        match had.max() {
            Some(last) if next <= last => {
                let message = format!("{next} is not above {last}, which a body or its parent has");
                Err(SceneError::bad(key, message))
            }
            _ => Ok(()),
        }
    }

    /// At most one of the three ways to say how a body is oriented.
    fn check_orientation(&self, key: &Key, body: &Body) -> Result<(), SceneError> {
        let given = [
            ("orientation", body.orientation.is_some()),
            ("axis", body.axis.is_some()),
            ("angle", body.angle.is_some()),
        ];
        let mut given = given.into_iter().filter(|(_, given)| *given);
        if let (Some((first, _)), Some((second, _))) = (given.next(), given.next()) {
            let message = format!("conflicts with `{first}`, which sets the orientation too; omit one of them");
            return Err(SceneError::bad(key.field(second), message));
        }
        if let Some(axis) = body.axis {
            let key = key.field("axis");
            numbers(&key, &axis)?;
            if DVec3::from(axis).abs().max_element() < SMALLEST_NUMBER {
                return Err(SceneError::bad(key, "must have a direction, as [0, 0, 1]"));
            }
        }
        if let Some(angle) = body.angle {
            let key = key.field("angle");
            number(&key, angle)?;
            if !self.planar {
                return Err(SceneError::bad(key, "is an angle in the plane; in space, give `axis` or `orientation`"));
            }
        }
        Ok(())
    }

    /// Fixed bodies have no velocity and do not grow. A group with settings has bodies.
    pub(super) fn check_fixed(&self, root: &Key) -> Result<(), SceneError> {
        let (key, names) = (root.field("groups"), self.group_names());
        for name in self.groups.keys() {
            if !names.contains(name) {
                let message = match nearest(name, names.iter().map(String::as_str)) {
                    Some(near) => format!("no body is in this group; the nearest group is `{near}`"),
                    None => "no body is in this group; `bodies` and `generate` have `group`".to_owned(),
                };
                return Err(SceneError::bad(key.field(name), message));
            }
        }
        let fixed = self.fixed();
        let number = |group: Option<&str>| names.iter().position(|name| Some(name.as_str()) == group);
        let number = |group: Option<&str>| number(group).map_or(NO_GROUP, |n| n as u32);
        let bodies = self.bodies.iter().zip(self.ids()).enumerate();
        for (i, (body, _)) in bodies.filter(|(_, (body, id))| fixed.holds(*id, number(body.group.as_deref()))) {
            let (list, moves) = (root.field("bodies"), |v: Option<[f64; 3]>| v.is_some_and(|v| v != [0.0; 3]));
            let key = list.index(i);
            for (name, velocity) in [("velocity", body.velocity), ("angular_velocity", body.angular_velocity)] {
                if moves(velocity) {
                    return Err(SceneError::bad(key.field(name), "must be zero for a body that is fixed"));
                }
            }
            self.check_not_growing(&key.field("shape"), &body.shape, body.group.as_deref())?;
        }
        let held = |i: usize, group: Option<&str>| self.generate[i].is_fixed() || fixed.holds(u64::MAX, number(group));
        for (i, (_, shape, group)) in self.generated().filter(|(i, (.., group))| held(*i, *group)) {
            let list = root.field("generate");
            self.check_not_growing(&list.index(i).field(self.generate[i].name()), &shape, group)?;
        }
        Ok(())
    }

    fn check_not_growing(&self, key: &Key, shape: &Shape, group: Option<&str>) -> Result<(), SceneError> {
        if self.growth_of_body(group, shape).is_some() {
            let message = "would grow, which a fixed body cannot; name the species that grows with growth.group, or use spheres or walls as obstacles";
            return Err(SceneError::bad(key, message));
        }
        Ok(())
    }

    fn check_velocities(&self, key: &Key, body: &Body) -> Result<(), SceneError> {
        for (name, velocity) in [("velocity", body.velocity), ("angular_velocity", body.angular_velocity)] {
            let Some(velocity) = velocity else { continue };
            let key = key.field(name);
            if !self.dynamics.has_inertia() {
                let message = "has no meaning without inertia; omit it, or choose the inertial law";
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
    let Some(orientation) = body.orientation else { return Ok(()) };
    let key = key.field("orientation");
    numbers(&key, &orientation)?;
    let norm = norm(orientation);
    if norm < SMALLEST_QUATERNION {
        let message = format!(
            "has the norm {norm}; it is normalized, so it must be at least {SMALLEST_QUATERNION:e}",
            norm = short(norm)
        );
        return Err(SceneError::bad(key, message));
    }
    Ok(())
}

fn check_daughter_bonds(key: &Key, body: &Body) -> Result<(), SceneError> {
    let Some(ends) = body.daughter_bonds else { return Ok(()) };
    let key = key.field("daughter_bonds");
    if body.shape.rod_length().is_none() {
        return Err(SceneError::bad(key, "is for spherocylinders, whose daughters may be bonded"));
    }
    match ends.iter().position(|end| *end > LARGEST_END) {
        Some(end) => Err(SceneError::bad(key.index(end), format!("must be at most {LARGEST_END}"))),
        None if ends[0] == ends[1] && ends[0] > 0 => Err(SceneError::bad(key, "would bond the cell to itself")),
        None => Ok(()),
    }
}

fn check_lineage(key: &Key, lineage: &BodyLineage, ids: &mut HashSet<u64>) -> Result<(), SceneError> {
    number(&key.field("birth"), lineage.birth)?;
    lineage.birth_length.map_or(Ok(()), |length| positive(&key.field("birth_length"), length))?;
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
