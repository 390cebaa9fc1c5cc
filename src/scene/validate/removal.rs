//! The rules of removal.

use super::super::error::{FaultKind, SceneError};
use super::super::key::Key;
use super::super::{Removal, Scene};
use super::positive;
use super::walls::{check_upright, check_wall};
use crate::removal::MOST_RULES;

impl Scene {
    pub(super) fn check_removal(&self, list: &Key) -> Result<(), SceneError> {
        if self.removal.len() > MOST_RULES {
            let message = format!("{} rules of removal; at most {MOST_RULES}", self.removal.len());
            return Err(SceneError::new(FaultKind::TooLarge, list, message));
        }
        for (i, rule) in self.removal.iter().enumerate() {
            let key = list.index(i);
            let given: Vec<&str> = named(rule).collect();
            match given.as_slice() {
                [_] => {}
                [] => return Err(SceneError::bad(key, "must have `outside`, `inside` or `rate`")),
                [first, second, ..] => {
                    let message = format!("conflicts with `{first}`: a rule has only one of them; make two rules");
                    return Err(SceneError::bad(key.field(second), message));
                }
            }
            for (name, shape) in [("outside", &rule.outside), ("inside", &rule.inside)] {
                let Some(shape) = shape else { continue };
                let key = key.field(name);
                let key = key.field(shape.name());
                check_wall(&key, shape)?;
                if shape.motion().is_some() {
                    let message = "is for walls only; the border of a removal region does not move";
                    return Err(SceneError::bad(key.field("motion"), message));
                }
                if shape.load().is_some() {
                    let message = "is for walls only; the border of a removal region does not move";
                    return Err(SceneError::bad(key.field("load"), message));
                }
                if shape.friction().is_some() {
                    let message = "is for walls only; bodies do not touch the border of a removal region";
                    return Err(SceneError::bad(key.field("friction"), message));
                }
                if self.planar {
                    check_upright(&key, shape, self.plane())?;
                }
            }
            rule.rate.map_or(Ok(()), |rate| positive(&key.field("rate"), rate))?;
            self.check_group(&key, rule.group.as_deref())?;
            let fixed = |group: &String| self.groups.get(group).is_some_and(|group| group.fixed);
            if rule.group.as_ref().is_some_and(fixed) {
                return Err(SceneError::bad(
                    key.field("group"),
                    "is fixed; fixed bodies are obstacles, and never removed",
                ));
            }
        }
        Ok(())
    }
}

/// The settings of a rule.
fn named(rule: &Removal) -> impl Iterator<Item = &'static str> {
    let given = [("outside", rule.outside.is_some()), ("inside", rule.inside.is_some()), ("rate", rule.rate.is_some())];
    given.into_iter().filter(|(_, given)| *given).map(|(name, _)| name)
}
