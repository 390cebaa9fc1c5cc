//! The limit of a series of steps.

use super::session::End;
use crate::simulation::Simulation;
use crate::step::Time;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The limit of a series of steps.
#[derive(Clone, Copy)]
pub(super) struct StepLimit {
    /// The largest number of steps.
    pub most: u64,
    /// No step passes this end.
    pub end: End,
}

impl StepLimit {
    /// The limit of a run to the scene's end, or to a given time.
    pub fn until(simulation: &Simulation, until: Option<f64>) -> PyResult<StepLimit> {
        let Some(until) = until else { return Ok(StepLimit { most: u64::MAX, end: End::OfScene }) };
        if !until.is_finite() {
            return Err(PyValueError::new_err("until: expected a finite time"));
        }
        let (time, taken) = (simulation.scene().time, simulation.steps());
        let within = until <= time.end;
        if !within && time.span(time.steps()) < 1.0 {
            return Err(PyValueError::new_err(format!(
                "until: the scene ends at {:?} with a shorter step, because dt does not divide its time; give the scene a later time.end",
                time.end
            )));
        }
        if !within && simulation.stopped_by().is_some() {
            return Err(PyValueError::new_err(
                "until: growth.stop ended this simulation, which a later time does not lift",
            ));
        }
        // The number of steps of a scene with this end.
        let steps = Time { end: until.max(time.start), ..time }.steps();
        let end = if within { End::OfScene } else { End::OfGrowth };
        Ok(StepLimit { most: steps.saturating_sub(taken), end })
    }
}

/// Whether a callback requests a stop, by returning Python's or numpy's False. All other values continue.
pub(super) fn asks_to_stop(answer: &Bound<'_, PyAny>) -> bool {
    answer.extract::<bool>().is_ok_and(|goes_on| !goes_on)
}
