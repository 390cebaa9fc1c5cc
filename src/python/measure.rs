//! A measure of a state, as a dict.

use super::arrays::column;
use super::error::told;
use crate::measure::{Found, Frame, LeftOut, Measure, Settings, View, select};
use crate::record::Snapshot;
use crate::scene::Scene;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The measure of a name.
pub(super) fn named(name: &str) -> PyResult<&'static dyn Measure> {
    match select(&[name.to_owned()]).map_err(|no| PyValueError::new_err(told(&no)))?[..] {
        [measure] => Ok(measure),
        _ => Err(PyValueError::new_err("name: expected the name of one measure")),
    }
}

/// What a measure finds in a state of a scene.
pub(super) fn found(scene: &Scene, state: &Snapshot, measure: &dyn Measure) -> Result<Found, LeftOut> {
    let settings = Settings::default();
    let frame = Frame::of_scene(scene, scene.name.clone());
    measure.of(&View::new(state, &frame, &settings))
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
