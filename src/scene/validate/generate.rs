//! The rules of bodies placed by rule. Counts are refused by arithmetic, before anything is allocated.

use super::super::error::{FaultKind, SceneError};
use super::super::generate::{MAX_RING_RATIO, isotropic_volume, reachable_by_all};
use super::super::key::Key;
use super::super::{Component, Generate, Scene};
use super::shapes::check_shape;
use super::{MAX_BODIES, number, numbers, positive};
use crate::digits::{at_most, few};

impl Scene {
    /// How many bodies the scene starts with, at most `u64::MAX`.
    pub fn body_count(&self) -> u64 {
        self.generate.iter().fold(self.bodies.len() as u64, |sum, rule| sum.saturating_add(rule.count()))
    }

    pub(super) fn check_generate(&self, root: &Key) -> Result<(), SceneError> {
        let mut count = self.bodies.len() as u64;
        for (i, rule) in self.generate.iter().enumerate() {
            let key = root.field("generate");
            let key = key.index(i);
            let key = key.field(rule.name());
            count = count.saturating_add(rule.count());
            if count > MAX_BODIES {
                let place = if matches!(rule, Generate::Chainmail { .. }) { key } else { key.field("count") };
                let message = format!("the scene would have {count} bodies; at most {MAX_BODIES}");
                return Err(SceneError::new(FaultKind::TooLarge, place, message));
            }
            self.check_rule(&key, rule)?;
        }
        Ok(())
    }

    fn check_rule(&self, key: &Key, rule: &Generate) -> Result<(), SceneError> {
        let at_least_one = |name: &'static str, n: u64| {
            if n == 0 { Err(SceneError::bad(key.field(name), "must be at least 1")) } else { Ok(()) }
        };
        match rule {
            Generate::Isotropic { count, shape, mixture, volume_fraction, center, .. } => {
                at_least_one("count", *count)?;
                check_shape(&key.field("shape").field(shape.name()), shape)?;
                for (i, Component { count, shape, .. }) in mixture.iter().enumerate() {
                    let list = key.field("mixture");
                    let key = list.index(i);
                    if *count == 0 {
                        return Err(SceneError::bad(key.field("count"), "must be at least 1"));
                    }
                    check_shape(&key.field("shape").field(shape.name()), shape)?;
                }
                numbers(&key.field("center"), center)?;
                self.check_fraction(key, rule, *volume_fraction)
            }
            Generate::Chainmail { columns, rows, major_radius, minor_radius, .. } => {
                at_least_one("columns", *columns)?;
                at_least_one("rows", *rows)?;
                check_shape(key, &rule.shape())?;
                if *minor_radius > MAX_RING_RATIO * major_radius {
                    let limit = MAX_RING_RATIO * major_radius;
                    let message = format!(
                        "must be at most {limit}, {MAX_RING_RATIO} of the major radius, for rings to interlace",
                        limit = at_most(limit)
                    );
                    return Err(SceneError::bad(key.field("minor_radius"), message));
                }
                Ok(())
            }
            Generate::Founder { position, angle, count, .. } => {
                at_least_one("count", *count)?;
                check_shape(key, &rule.shape())?;
                numbers(&key.field("position"), position)?;
                number(&key.field("angle"), *angle)
            }
        }
    }

    /// A fraction that random placement reaches; left out, that which the number makes of a whole periodic cell.
    fn check_fraction(&self, key: &Key, rule: &Generate, given: Option<f64>) -> Result<(), SceneError> {
        let fraction_key = key.field("volume_fraction");
        let limit = reachable_by_all(rule, self.planar);
        let what = if rule.components().count() > 1 { "mixture" } else { "shape" };
        if let Some(fraction) = given {
            positive(&fraction_key, fraction)?;
            if fraction > limit {
                let message = format!(
                    "must be at most {limit} for this {what}, the limit of random placement without overlap",
                    limit = at_most(limit)
                );
                return Err(SceneError::bad(fraction_key, message));
            }
            return Ok(());
        }
        let Some(cell) = self.periods().volume(self.planar) else {
            let message = "is missing; only scenes that are periodic along all axes can omit it";
            return Err(SceneError::new(FaultKind::MissingKey, fraction_key, message));
        };
        let fraction = isotropic_volume(rule, self.planar) / cell;
        if fraction > limit {
            let message = format!(
                "fills {fraction} of the periodic cell; at most {limit} for this {what}, the limit of random placement without overlap",
                fraction = few(fraction),
                limit = at_most(limit)
            );
            return Err(SceneError::bad(key.field("count"), message));
        }
        Ok(())
    }
}
