//! The rules of growth.

use super::super::error::{FaultKind, SceneError};
use super::super::key::Key;
use super::super::{Growth, Method, Scene, Stop};
use super::{MAX_BODIES, number, positive};
use crate::dynamics::MOST_LENGTH_NOISE;
use crate::shape::Shape;
use std::f64::consts::LN_2;

impl Scene {
    pub(super) fn check_growth(&self, key: &Key) -> Result<(), SceneError> {
        let Some(growth) = &self.growth else { return Ok(()) };
        number(&key.field("rate"), growth.rate)?;
        if growth.rate < 0.0 {
            return Err(SceneError::bad(key.field("rate"), format!("must not be negative, not {:?}", growth.rate)));
        }
        noise(&key.field("rate_noise"), growth.rate_noise, 1.0, "a cell does not shrink")?;
        let born = "no cell is born at the length at which it divides";
        noise(&key.field("division_length_noise"), growth.division_length_noise, MOST_LENGTH_NOISE, born)?;
        if growth.fastest_rate() * self.time.dt >= LN_2 {
            let message = format!("a cell would divide more than once in a step of {:?}", self.time.dt);
            return Err(SceneError::bad(key.field("rate"), message));
        }
        positive(&key.field("division_length"), growth.division_length)?;
        let turn = key.field("reorientation_degrees");
        number(&turn, growth.reorientation_degrees)?;
        if !(0.0..=180.0).contains(&growth.reorientation_degrees) {
            let message = format!("must be from 0 to 180, not {:?}", growth.reorientation_degrees);
            return Err(SceneError::bad(turn, message));
        }
        self.check_stress(&key.field("stress_sensitivity"), growth)?;
        if let Some(stop) = &growth.stop {
            check_stop(&key.field("stop"), stop)?;
        }
        self.check_cells(key, growth)
    }

    fn check_stress(&self, key: &Key, growth: &Growth) -> Result<(), SceneError> {
        number(key, growth.stress_sensitivity)?;
        if growth.stress_sensitivity < 0.0 {
            let message = format!("must not be negative, not {:?}", growth.stress_sensitivity);
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
        for (list, index, shape) in self.shapes() {
            let Some(length) = shape.growing_length() else { continue };
            cells = true;
            let division_key = key.field("division_length");
            let [shortest, longest] = growth.division_lengths();
            if shape.grown(0.5 * shortest).is_none() {
                let message = format!(
                    "must be at least twice the diameter, {:?}, of {list}.{index}{}: a daughter is half as long, and never shorter than wide",
                    shape.thickness(),
                    if growth.division_length_noise > 0.0 { " (less its noise)" } else { "" }
                );
                return Err(SceneError::bad(division_key, message));
            }
            let longest = length.max(longest * (growth.fastest_rate() * self.time.dt).exp());
            if let Some(Err(error)) = shape.grown(longest).map(|cell| cell.validate()) {
                return Err(SceneError::bad(division_key, format!("{error} ({list}.{index} before it divides)")));
            }
        }
        if !cells {
            return Err(SceneError::bad(key, "only spherocylinders grow, and the scene has none"));
        }
        let population = self.final_population();
        if population > MAX_BODIES as f64 {
            let message = format!("growth would reach {population:.1e} cells; the limit is {MAX_BODIES}");
            return Err(SceneError::new(FaultKind::TooLarge, "time.end", message));
        }
        Ok(())
    }

    /// Bodies at the end of the run, from exponential growth alone: a cell of length `L` becomes `2^k` cells with `k`
    /// the least for which `L exp(rate T) / 2^k` is below the division length; with noise at the most. Where the run
    /// stops before, it is at most twice the population that it stops at.
    fn final_population(&self) -> f64 {
        let Some(growth) = &self.growth else { return self.body_count() as f64 };
        let stop = growth.stop.unwrap_or_default();
        let end = self.time.end.min(stop.time.unwrap_or(f64::INFINITY)).max(self.time.start);
        let stretch = growth.fastest_rate() * (end - self.time.start) / LN_2;
        let descendants = |shape: &Shape| match shape.growing_length() {
            Some(length) => {
                let doublings = stretch + (length / growth.division_lengths()[0]).log2();
                (doublings.floor() + 1.0).max(0.0).exp2()
            }
            None => 1.0,
        };
        let given: f64 = self.bodies.iter().map(|b| descendants(&b.shape)).sum();
        let generated: f64 = self.generate.iter().map(|g| g.count() as f64 * descendants(&g.shape())).sum();
        let stopped = stop.population.map_or(f64::INFINITY, |population| 2.0 * population as f64);
        // What a scene starts with is there in any case.
        (given + generated).min(stopped.max(self.body_count() as f64))
    }
}

/// A part of a mean by which cells differ, from zero to under `most`.
fn noise(key: &Key, value: f64, most: f64, why: &str) -> Result<(), SceneError> {
    number(key, value)?;
    if !(0.0..most).contains(&value) {
        return Err(SceneError::bad(key, format!("must be from 0 to under {most:.4}, so that {why}, not {value:?}")));
    }
    Ok(())
}

fn check_stop(key: &Key, stop: &Stop) -> Result<(), SceneError> {
    if *stop == Stop::default() {
        return Err(SceneError::bad(key, "must say at which population, time or radius"));
    }
    if stop.population == Some(0) {
        return Err(SceneError::bad(key.field("population"), "must be at least 1"));
    }
    stop.time.map_or(Ok(()), |time| number(&key.field("time"), time))?;
    stop.radius.map_or(Ok(()), |radius| positive(&key.field("radius"), radius))
}
