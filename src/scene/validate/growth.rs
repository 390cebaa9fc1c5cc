//! The rules of growth.

use super::super::error::{FaultKind, SceneError};
use super::super::key::Key;
use super::super::{DaughterBond, DivisionRule, GrowingShape, Growth, Method, Scene, Stop};
use super::{MAX_BODIES, number, positive};
use crate::digits::{at_least, at_most, exact, few};
use crate::dynamics::MOST_LENGTH_NOISE;
use crate::shape::Shape;
use std::f64::consts::LN_2;

impl Scene {
    pub(super) fn check_growth(&self, key: &Key) -> Result<(), SceneError> {
        if self.growth.is_empty() {
            return Ok(());
        }
        for (i, growth) in self.growth.iter().enumerate() {
            let entry = key.index(i);
            let entry = if self.is_one_growth() { key } else { &entry };
            self.check_species(entry, i)?;
            self.check_entry(entry, growth)?;
        }
        let population = self.final_population();
        if population > MAX_BODIES as f64 {
            let message = format!(
                "growth would reach {population} cells; the limit is {MAX_BODIES}",
                population = few(population)
            );
            return Err(SceneError::new(FaultKind::TooLarge, "time.end", message));
        }
        Ok(())
    }

    /// Whether growth is written as one object.
    pub(super) fn is_one_growth(&self) -> bool {
        matches!(self.growth.as_slice(), [one] if one.group.is_none())
    }

    /// What the entries of a list are to each other: no body in two, and what is of the run is there once.
    fn check_species(&self, key: &Key, i: usize) -> Result<(), SceneError> {
        let (growth, before) = (&self.growth[i], &self.growth[..i]);
        if let Some(other) = before.iter().position(|other| other.group == growth.group) {
            let of = match &growth.group {
                Some(group) => format!("the bodies of the group `{group}`"),
                None => "all bodies that no other entry names".to_owned(),
            };
            let message = format!("applies to {of}, like growth.{other}; a body belongs to one entry");
            return Err(SceneError::bad(key.field("group"), message));
        }
        self.check_group(key, growth.group.as_deref())?;
        if growth.stop.is_some()
            && let Some(other) = before.iter().position(|other| other.stop.is_some())
        {
            let message = format!("growth.{other} already has one; omit one of them");
            return Err(SceneError::bad(key.field("stop"), message));
        }
        if before.first().is_some_and(|first| first.on_no_room != growth.on_no_room) {
            let message = "applies to the whole run, but differs from growth.0; give all entries the same";
            return Err(SceneError::bad(key.field("on_no_room"), message));
        }
        Ok(())
    }

    fn check_daughters(&self, key: &Key, bond: &DaughterBond) -> Result<(), SceneError> {
        let finite = |value: f64| Some(value).filter(|value| !value.is_infinite());
        let numbers = [
            ("stiffness", finite(bond.stiffness)),
            ("gap", bond.gap),
            ("bending", bond.bending.and_then(finite)),
            ("break_force", bond.break_force),
        ];
        for (name, value) in numbers {
            value.map_or(Ok(()), |value| positive(&key.field(name), value))?;
        }
        if let Some(gap) = bond.gap {
            self.check_bond_length(&key.field("gap"), gap)?;
        }
        self.check_supports(&Key::ROOT, &key.to_string())
    }

    fn check_entry(&self, key: &Key, growth: &Growth) -> Result<(), SceneError> {
        number(&key.field("rate"), growth.rate)?;
        if growth.rate < 0.0 {
            return Err(SceneError::bad(
                key.field("rate"),
                format!("must not be negative, not {}", exact(growth.rate)),
            ));
        }
        noise(&key.field("rate_noise"), growth.rate_noise, 1.0, "a cell does not shrink")?;
        if growth.fastest_rate() * self.time.dt >= LN_2 {
            let message = format!("a cell would divide more than once in a step of {}", exact(self.time.dt));
            return Err(SceneError::bad(key.field("rate"), message));
        }
        self.check_division_rule(key, growth)?;
        if let Some(bond) = &growth.bond_daughters {
            if growth.shape != GrowingShape::Spherocylinder {
                let message = "is for spherocylinders: ellipsoids have no round ends to turn about each other";
                return Err(SceneError::bad(key.field("bond_daughters"), message));
            }
            self.check_daughters(&key.field("bond_daughters"), bond)?;
        }
        let turn = key.field("reorientation_degrees");
        number(&turn, growth.reorientation_degrees)?;
        if !(0.0..=180.0).contains(&growth.reorientation_degrees) {
            let message = format!("must be from 0 to 180, not {}", exact(growth.reorientation_degrees));
            return Err(SceneError::bad(turn, message));
        }
        self.check_stress(&key.field("stress_sensitivity"), growth)?;
        self.check_nutrient(&key.field("nutrient"), growth)?;
        if let Some(stop) = &growth.stop {
            check_stop(&key.field("stop"), stop)?;
        }
        self.check_cells(key, growth)
    }

    /// A rule has its own target, and no other's.
    fn check_division_rule(&self, key: &Key, growth: &Growth) -> Result<(), SceneError> {
        let (own, target, own_noise) = growth.target();
        let (most, why) = match growth.rule {
            DivisionRule::Sizer => (MOST_LENGTH_NOISE, "no cell is born at the length at which it divides"),
            DivisionRule::Adder => (1.0, "a cell grows before it divides"),
            DivisionRule::Timer => (1.0, "a cell lives before it divides"),
        };
        let given = [
            ("division_length", "division_length_noise", growth.division_length, growth.division_length_noise),
            ("added_length", "added_length_noise", growth.added_length, growth.added_length_noise),
            ("division_time", "division_time_noise", growth.division_time, growth.division_time_noise),
        ];
        for (name, noise_name, value, spread) in given {
            if name == own {
                noise(&key.field(noise_name), own_noise, most, why)?;
                continue;
            }
            let rule = growth.rule.name();
            if value.is_some() || spread != 0.0 {
                let key = key.field(if value.is_some() { name } else { noise_name });
                return Err(SceneError::bad(
                    key,
                    format!("has no meaning with the rule \"{rule}\", which has `{own}`"),
                ));
            }
        }
        if growth.has_no_target() {
            let message = format!("is missing; the rule \"{}\" requires it", growth.rule.name());
            return Err(SceneError::bad(key.field(own), message));
        }
        positive(&key.field(own), target)?;
        if growth.rule == DivisionRule::Timer && growth.targets()[0] <= self.time.dt {
            let message = format!("must be longer than a step, {}, less its noise too", exact(self.time.dt));
            return Err(SceneError::bad(key.field(own), message));
        }
        Ok(())
    }

    fn check_stress(&self, key: &Key, growth: &Growth) -> Result<(), SceneError> {
        number(key, growth.stress_sensitivity)?;
        if growth.stress_sensitivity < 0.0 {
            let message = format!("must not be negative, not {}", exact(growth.stress_sensitivity));
            return Err(SceneError::bad(key, message));
        }
        if growth.stress_sensitivity > 0.0 && matches!(self.contact.method, Method::Multisphere { .. }) {
            let message = "needs the contact forces of smooth surfaces, so contact.method \"relcp\" or \"snsd\"";
            return Err(SceneError::bad(key, message));
        }
        Ok(())
    }

    fn check_cells(&self, key: &Key, growth: &Growth) -> Result<(), SceneError> {
        let mut cells = false;
        let (own, _, spread) = growth.target();
        for (list, index, shape, _, _) in self.growing().filter(|(_, _, _, of, _)| std::ptr::eq(*of, growth)) {
            cells = true;
            self.check_upright((list, index), &shape)?;
            let [shortest, _] = growth.targets();
            let thickness = shape.shortest_length();
            let noise = if spread > 0.0 { " (less its noise)" } else { "" };
            let short = match growth.rule {
                DivisionRule::Sizer => shape.grown(0.5 * shortest).is_none(),
                // A cell is no shorter than thick, and a daughter is half of her mother at birth and what she added.
                DivisionRule::Adder => shortest < thickness,
                DivisionRule::Timer => false,
            };
            if short {
                let twice = if growth.rule == DivisionRule::Sizer { "twice the" } else { "the" };
                let message = format!(
                    "must be at least {twice} diameter, {thickness}, of {of}{list}.{index}{noise}: a daughter is half as long as her mother, and never shorter than wide",
                    of = if shape.rod_length().is_some() { "" } else { "the tips of " },
                    thickness = at_least(thickness)
                );
                return Err(SceneError::bad(key.field(own), message));
            }
            let longest = self.longest(&shape, growth);
            if let Err(error) = longest.validate() {
                return Err(SceneError::bad(key.field(own), format!("{error} ({list}.{index} before it divides)")));
            }
        }
        if !cells {
            return Err(SceneError::bad(key, self.none_grow(growth)));
        }
        Ok(())
    }

    /// An ellipsoid grows along its z, which is its longest axis then and stays so.
    fn check_upright(&self, (list, index): (&str, usize), shape: &Shape) -> Result<(), SceneError> {
        if shape.growing_length().is_none_or(|length| shape.grown(length).is_some()) {
            return Ok(());
        }
        let bodies = Key::ROOT.field(list);
        let key = bodies.index(index);
        let key = if list == "generate" { key.field(self.generate[index].name()) } else { key.field("shape") };
        let message = "the last of an ellipsoid's `radii` must be the largest where it grows, as that is along its z; \
                       name other bodies with growth.group";
        Err(SceneError::bad(key, message))
    }

    /// Says that a species has no body that grows.
    fn none_grow(&self, growth: &Growth) -> String {
        let who = growth.group.as_ref().map_or("the scene has none".into(), |g| format!("the group `{g}` has none"));
        let other = match growth.shape {
            GrowingShape::Spherocylinder => GrowingShape::Ellipsoid,
            _ => GrowingShape::Spherocylinder,
        };
        let of_other = Growth { shape: other, ..growth.clone() };
        let in_group = |group: Option<&str>| growth.group.is_none() || growth.group.as_deref() == group;
        let bodies = self.bodies.iter().map(|body| (body.shape, body.group.as_deref()));
        let mut all = bodies.chain(self.generated().map(|(_, (_, shape, group))| (shape, group)));
        let has_other = all.any(|(shape, group)| in_group(group) && of_other.length_of(&shape).is_some());
        match has_other {
            true => format!(
                "only {} grow by this entry, and {who}; with \"shape\": \"{}\" {} do",
                growth.shape.plural(),
                other.name(),
                other.plural()
            ),
            false => format!("only {} grow by this entry, and {who}", growth.shape.plural()),
        }
    }

    /// Bodies at the end of the run, from growth alone, at the most. Where the run stops before, it is at most twice
    /// the population that it stops at.
    fn final_population(&self) -> f64 {
        let stop = self.stop().unwrap_or_default();
        let end = self.time.end.min(stop.time.unwrap_or(f64::INFINITY)).max(self.time.start);
        let of = |(_, _, shape, growth, count): (&str, usize, Shape, &Growth, u64)| {
            let descendants = growth.most_descendants(shape.growing_length().unwrap_or(0.0), end - self.time.start);
            count as f64 * (descendants - 1.0)
        };
        let grown = self.body_count() as f64 + self.growing().map(of).sum::<f64>();
        let stopped = stop.population.map_or(f64::INFINITY, |population| 2.0 * population as f64);
        // What a scene starts with is there in any case.
        grown.min(stopped.max(self.body_count() as f64))
    }
}

/// A part of a mean by which cells differ, from zero to under `most`.
fn noise(key: &Key, value: f64, most: f64, why: &str) -> Result<(), SceneError> {
    number(key, value)?;
    if !(0.0..most).contains(&value) {
        return Err(SceneError::bad(
            key,
            format!(
                "must be from 0 to under {most}, so that {why}, not {value}",
                most = at_most(most),
                value = exact(value)
            ),
        ));
    }
    Ok(())
}

fn check_stop(key: &Key, stop: &Stop) -> Result<(), SceneError> {
    if *stop == Stop::default() {
        return Err(SceneError::bad(key, "must have a population, time or radius"));
    }
    if stop.population == Some(0) {
        return Err(SceneError::bad(key.field("population"), "must be at least 1"));
    }
    stop.time.map_or(Ok(()), |time| number(&key.field("time"), time))?;
    stop.radius.map_or(Ok(()), |radius| positive(&key.field("radius"), radius))
}
