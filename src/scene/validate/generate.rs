//! The rules of bodies placed by rule. Counts are refused by arithmetic, before anything is allocated.

use super::super::error::{FaultKind, SceneError};
use super::super::generate::{MAX_RING_RATIO, copies, is_enclosed, is_inside, isotropic_volume, reachable_by_all};
use super::super::key::Key;
use super::super::{Component, Generate, Lengths, Repeat, Scene, Wall};
use super::shapes::check_shape;
use super::walls::{check_digits, check_upright, check_wall};
use super::{MAX_BODIES, number, numbers, positive};
use crate::digits::{at_most, few};
use crate::shape::Shape;

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
            check_repeat(&key, rule)?;
            // The settings that a count follows from come first.
            if let Generate::Lattice(lattice) = rule {
                self.check_lattice(&key, lattice)?;
            }
            if let Generate::Fence(fence) = rule {
                self.check_fence(&key, fence)?;
            }
            count = count.saturating_add(rule.count());
            if count > MAX_BODIES {
                let place = match rule {
                    Generate::Isotropic { .. } | Generate::Founder { .. } | Generate::Chain(_) => key.field("count"),
                    _ => key,
                };
                let message = format!("the scene would have {count} bodies; at most {MAX_BODIES}");
                return Err(SceneError::new(FaultKind::TooLarge, place, message));
            }
            self.check_rule(&key, rule)?;
        }
        Ok(())
    }

    fn check_rule(&self, key: &Key, rule: &Generate) -> Result<(), SceneError> {
        match rule {
            Generate::Isotropic { count, shape, lengths, mixture, region, center, .. } => {
                at_least(key, "count", *count, 1)?;
                check_shape(&key.field("shape").field(shape.name()), shape)?;
                check_lengths(key, shape, lengths.as_ref())?;
                for (i, Component { count, shape, lengths, .. }) in mixture.iter().enumerate() {
                    let list = key.field("mixture");
                    let key = list.index(i);
                    at_least(&key, "count", *count, 1)?;
                    check_shape(&key.field("shape").field(shape.name()), shape)?;
                    check_lengths(&key, shape, lengths.as_ref())?;
                }
                numbers(&key.field("center"), center)?;
                if let Some(region) = region {
                    self.check_region(&key.field("region"), region)?;
                }
                self.check_space(key, rule)
            }
            Generate::Chainmail { columns, rows, major_radius, minor_radius, .. } => {
                at_least(key, "columns", *columns, 1)?;
                at_least(key, "rows", *rows, 1)?;
                rule.components().try_for_each(|(_, ring, _)| check_shape(key, &ring))?;
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
                at_least(key, "count", *count, 1)?;
                rule.components().try_for_each(|(_, cell, _)| check_shape(key, &cell))?;
                numbers(&key.field("position"), position)?;
                number(&key.field("angle"), *angle)
            }
            Generate::Lattice(_) | Generate::Fence(_) => Ok(()),
            Generate::Chain(chain) => self.check_chain(key, chain),
        }
    }

    /// A region to place bodies in: a wall that neither moves nor touches bodies.
    pub(super) fn check_region(&self, key: &Key, region: &Wall) -> Result<(), SceneError> {
        let key = key.field(region.name());
        check_wall(&key, region)?;
        check_digits(&key, region, self.contact.overlap_tolerance)?;
        let given = [
            ("motion", region.motion().is_some()),
            ("friction", region.friction().is_some()),
            ("load", region.load().is_some()),
        ];
        if let Some((name, _)) = given.into_iter().find(|(_, given)| *given) {
            return Err(SceneError::bad(key.field(name), "is for walls only; a region is no wall"));
        }
        if self.planar { check_upright(&key, region, self.plane()) } else { Ok(()) }
    }

    /// The space of random bodies: a region, a volume fraction that random placement reaches, or the inside of walls.
    fn check_space(&self, key: &Key, rule: &Generate) -> Result<(), SceneError> {
        let Generate::Isotropic { volume_fraction, region, center, .. } = rule else { return Ok(()) };
        if !is_inside(self, rule) {
            return self.check_fraction(key, rule, *volume_fraction);
        }
        if region.is_some() && volume_fraction.is_some() {
            let message = "conflicts with `region`: the region and the number of bodies determine it; omit one of them";
            return Err(SceneError::bad(key.field("volume_fraction"), message));
        }
        match region {
            Some(region) if !is_enclosed(self, Some(region)) => {
                let message =
                    "leaves a way out together with the walls and the periods; bodies are placed in a closed space";
                let place = key.field("region");
                return Err(SceneError::bad(place.field(region.name()), message));
            }
            None if self.walls.is_empty() || !is_enclosed(self, None) => {
                let message = "is missing; only scenes that are periodic along all axes, or whose walls leave no way \
                               out, can omit it, or rules with a `region`";
                return Err(SceneError::new(FaultKind::MissingKey, key.field("volume_fraction"), message));
            }
            _ => {}
        }
        if *center != [0.0; 3] {
            let message = "is the middle of the cube of a `volume_fraction`, which this rule does not have; omit it";
            return Err(SceneError::bad(key.field("center"), message));
        }
        Ok(())
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
        let Some(cell) = self.periods().volume(self.planar) else { return Ok(()) };
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

pub(super) fn at_least(key: &Key, name: &str, count: u64, least: u64) -> Result<(), SceneError> {
    if count < least {
        return Err(SceneError::bad(key.field(name), format!("must be at least {least}")));
    }
    Ok(())
}

/// Lengths of rods, none shorter than thick.
fn check_lengths(key: &Key, shape: &Shape, lengths: Option<&Lengths>) -> Result<(), SceneError> {
    let Some(lengths) = lengths else { return Ok(()) };
    let key = key.field("lengths");
    if shape.rod_length().is_none() {
        return Err(SceneError::bad(key, "are for spherocylinders; other shapes have their sizes in `shape`"));
    }
    let key = key.field(lengths.name());
    let mut least = shape.thickness();
    for (name, length) in lengths.bounds() {
        let key = key.field(name);
        positive(&key, length)?;
        if length < least {
            let message = format!("must be at least {}: the diameter, or the shortest length", at_most(least));
            return Err(SceneError::bad(key, message));
        }
        let longest = shape.grown(lengths.at(1.0)).unwrap_or(*shape);
        longest.validate().map_err(|error| SceneError::bad(key, error.to_string()))?;
        least = length;
    }
    Ok(())
}

/// The copies of a rule.
fn check_repeat(key: &Key, rule: &Generate) -> Result<(), SceneError> {
    let repeat: &[Repeat] = match rule {
        Generate::Founder { repeat, .. } => repeat,
        Generate::Fence(fence) => &fence.repeat,
        Generate::Chain(chain) => &chain.repeat,
        _ => &[],
    };
    let list = key.field("repeat");
    for (i, of) in repeat.iter().enumerate() {
        let key = list.index(i);
        at_least(&key, "count", of.count, 1)?;
        numbers(&key.field("offset"), &of.offset)?;
        if of.count > 1 && of.offset == [0.0; 3] {
            return Err(SceneError::bad(key.field("offset"), "must not be zero: all copies would be in one place"));
        }
    }
    let copies = copies(repeat);
    if copies > MAX_BODIES {
        let message = format!("makes {copies} copies; at most {MAX_BODIES}");
        return Err(SceneError::new(FaultKind::TooLarge, list, message));
    }
    Ok(())
}
