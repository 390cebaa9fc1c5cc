//! The rules of friction: coefficients in range, groups that there are, and settings that support it.

use super::super::error::SceneError;
use super::super::key::Key;
use super::super::{Friction, OnFailure, Restitution, Scene, Stepping};
use super::number;
use crate::constraint::friction::LARGEST_COEFFICIENT;
use crate::digits::{exact, short};

/// Solvers that support friction and implicit bonds.
const SOLVERS: &str = "\"auto\", \"pair_block_cg\" or \"apgd\"";

impl Scene {
    pub(super) fn check_friction(&self, root: &Key) -> Result<(), SceneError> {
        let contact = root.field("contact");
        let key = contact.field("friction");
        let friction = &self.contact.friction;
        if *friction == Friction::of_all(friction.bodies) {
            check_coefficient(&key, friction.bodies)?;
        }
        check_coefficient(&key.field("bodies"), friction.bodies)?;
        check_coefficient(&key.field("walls"), friction.walls)?;
        let list = key.field("groups");
        for (i, of) in friction.groups.iter().enumerate() {
            let key = list.index(i);
            check_coefficient(&key.field("is"), of.is)?;
            let between = key.field("between");
            for (side, name) in of.between.iter().enumerate() {
                self.check_name_of_group(&between.index(side), name)?;
            }
            let [a, b] = &of.between;
            let same = |other: &[String; 2]| other == &of.between || other == &[b.clone(), a.clone()];
            if let Some(first) = friction.groups[..i].iter().position(|earlier| same(&earlier.between)) {
                let message = format!("names the same groups as {}", list.index(first));
                return Err(SceneError::bad(between, message));
            }
        }
        for (i, wall) in self.walls.iter().enumerate() {
            let list = root.field("walls");
            let key = list.index(i);
            let key = key.field(wall.name());
            wall.friction().map_or(Ok(()), |own| check_coefficient(&key.field("friction"), own))?;
        }
        self.check_restitution(root)?;
        if let Some(slip) = self.contact.elastic_slip {
            number(&contact.field("elastic_slip"), slip)?;
            if slip < 0.0 {
                let message = format!("must not be negative, not {slip}", slip = short(slip));
                return Err(SceneError::bad(contact.field("elastic_slip"), message));
            }
        }
        if self.friction().is_none() {
            return Ok(());
        }
        self.check_supports(root, "friction (contact.friction, walls[].friction)")
    }

    /// Coefficients of restitution in range, under the inertial law and with Euler steps.
    fn check_restitution(&self, root: &Key) -> Result<(), SceneError> {
        let contact = root.field("contact");
        let (key, restitution) = (contact.field("restitution"), self.contact.restitution);
        if restitution == Restitution::of_all(restitution.bodies) {
            check_between(&key, restitution.bodies, 1.0)?;
        }
        check_between(&key.field("bodies"), restitution.bodies, 1.0)?;
        check_between(&key.field("walls"), restitution.walls, 1.0)?;
        if restitution.is_none() {
            return Ok(());
        }
        if !self.dynamics.has_inertia() {
            return Err(SceneError::bad(key, "needs dynamics.inertial: bodies without inertia do not bounce"));
        }
        if self.time.stepping == Stepping::Midpoint {
            let message = "conflicts with contact.restitution: it needs \"euler\" steps";
            return Err(SceneError::bad(root.field("time").field("stepping"), message));
        }
        Ok(())
    }

    /// Refuses settings that do not support `what` yet, friction or implicit bonds.
    pub(super) fn check_supports(&self, root: &Key, what: &str) -> Result<(), SceneError> {
        let Some(([outer, inner], why)) = self.refuses_cones() else { return Ok(()) };
        let message = format!("conflicts with {what}: {why}");
        Err(SceneError::bad(root.field(outer).field(inner), message))
    }

    /// The key of a setting that does not support multipliers other than those of contact without friction, and what is
    /// needed.
    pub(in crate::scene) fn refuses_cones(&self) -> Option<([&'static str; 2], String)> {
        if self.time.stepping == Stepping::Midpoint {
            return Some((["time", "stepping"], "it needs \"euler\" steps".into()));
        }
        if !self.solver.kind.supports_friction() {
            return Some((["solver", "kind"], format!("it needs {SOLVERS}")));
        }
        if self.contact.on_failure == OnFailure::Continue {
            return Some((["contact", "on_failure"], "it needs \"stop\"".into()));
        }
        let dumped = self.solver.dump.is_some();
        dumped.then(|| (["solver", "dump"], "LCPs over cones cannot be saved".into()))
    }
}

fn check_coefficient(key: &Key, coefficient: f64) -> Result<(), SceneError> {
    check_between(key, coefficient, LARGEST_COEFFICIENT)
}

fn check_between(key: &Key, coefficient: f64, most: f64) -> Result<(), SceneError> {
    number(key, coefficient)?;
    if (0.0..=most).contains(&coefficient) {
        return Ok(());
    }
    let message = format!("must be between 0 and {most}, not {coefficient}", coefficient = exact(coefficient));
    Err(SceneError::bad(key, message))
}
