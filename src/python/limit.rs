//! How far steps go.

use super::session::End;
use crate::simulation::Simulation;
use crate::step::Time;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// How far steps go.
#[derive(Clone, Copy)]
pub(super) struct StepLimit {
    /// So many steps at most.
    pub most: u64,
    /// None past this.
    pub end: End,
}

impl StepLimit {
    /// That of a run to the scene's end, or to a time of one's own.
    pub fn until(simulation: &Simulation, until: Option<f64>) -> PyResult<StepLimit> {
        let Some(until) = until else { return Ok(StepLimit { most: u64::MAX, end: End::OfScene }) };
        if !until.is_finite() {
            return Err(PyValueError::new_err("until: expected a finite time"));
        }
        let (time, taken) = (simulation.scene().time, simulation.steps());
        let within = until <= time.end;
        if !within && time.span(time.steps()) < 1.0 {
            return Err(PyValueError::new_err(format!(
                "until: the scene ends at {:?} with a shorter step, as dt does not divide its time; give the scene a later time.end",
                time.end
            )));
        }
        if !within && simulation.stopped_by().is_some() {
            return Err(PyValueError::new_err(
                "until: growth.stop ended this simulation, which a later time does not lift",
            ));
        }
        // As many steps as a scene with this end has.
        let steps = Time { end: until.max(time.start), ..time }.steps();
        let end = if within { End::OfScene } else { End::OfGrowth };
        Ok(StepLimit { most: steps.saturating_sub(taken), end })
    }
}

/// Whether a callback asks for an end: by False, of Python or numpy. What is anything else goes on.
pub(super) fn asks_to_stop(answer: &Bound<'_, PyAny>) -> bool {
    answer.extract::<bool>().is_ok_and(|goes_on| !goes_on)
}
