//! A measure of the present state, as a dict.

use super::arrays::column;
use crate::measure::{Found, Frame, LeftOut, Measure, Settings, View};
use crate::record::Snapshot;
use crate::simulation::Simulation;
use crate::step::Fault;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What a measure finds in the present state.
pub(super) fn found(simulation: &Simulation, measure: &dyn Measure) -> Result<Result<Found, LeftOut>, Fault> {
    let state = simulation.state()?;
    let snapshot = Snapshot {
        step: state.step,
        time: simulation.time(),
        bodies: state.bodies.clone(),
        warm: Some(state.warm.clone()),
        removed: state.removed.clone(),
    };
    let (scene, settings) = (simulation.scene(), Settings::default());
    let frame = Frame::of_scene(scene, scene.name.clone());
    Ok(measure.of(&View::new(&snapshot, &frame, &settings)))
}

/// It as values by column, with a remark, and with the profile where the measure has one.
pub(super) fn dict<'py>(
    py: Python<'py>,
    measure: &dyn Measure,
    found: Result<Found, LeftOut>,
) -> PyResult<Bound<'py, PyDict>> {
    let found = found.unwrap_or_else(|left_out| Found { remark: Some(left_out.0), ..Found::default() });
    let dict = PyDict::new(py);
    for (at, of) in measure.columns().iter().enumerate() {
        dict.set_item(of.name, found.values.get(at).copied().flatten())?;
    }
    dict.set_item("remark", found.remark)?;
    if let Some(profile) = measure.profile() {
        let columns = PyDict::new(py);
        for (at, of) in profile.columns.iter().enumerate() {
            let cell = |row: &Vec<Option<f64>>| row.get(at).copied().flatten().unwrap_or(f64::NAN);
            columns.set_item(of.name, column(py, found.rows.iter().map(cell).collect()))?;
        }
        dict.set_item("profile", columns)?;
    }
    Ok(dict)
}
