//! Tables over a run as dicts of arrays.

use super::arrays::{column, named};
use super::bodies::id;
use crate::measure::Measured;
use crate::record::{States, StatesError, Table, TableColumn, Watch, contacts};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The columns of contacts over a run.
const OF_CONTACTS: [&str; 12] = [
    "time",
    "separation",
    "gamma",
    "force_x",
    "force_y",
    "force_z",
    "normal_x",
    "normal_y",
    "normal_z",
    "point_x",
    "point_y",
    "point_z",
];

/// A table as a dict of arrays.
pub(super) fn dict<'py>(py: Python<'py>, table: Table) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, values) in table.columns {
        match values {
            TableColumn::Integers(values) => dict.set_item(name, column(py, values))?,
            TableColumn::Numbers(values) => dict.set_item(name, column(py, values))?,
            TableColumn::Words(values) => dict.set_item(name, values)?,
        }
    }
    Ok(dict)
}

/// The columns of a measure over all states, and those of its profile.
pub(super) fn of_measure<'py>(
    py: Python<'py>,
    found: &Measured,
) -> PyResult<(Bound<'py, PyDict>, Option<Bound<'py, PyDict>>)> {
    let integers = |values: &mut dyn Iterator<Item = u64>| column(py, values.map(|value| value as i64).collect());
    let number = |cell: Option<f64>| cell.unwrap_or(f64::NAN);
    let rows = PyDict::new(py);
    rows.set_item("step", integers(&mut found.steps.iter().copied()))?;
    rows.set_item("time", column(py, found.times.clone()))?;
    rows.set_item("bodies", integers(&mut found.bodies.iter().map(|bodies| *bodies as u64)))?;
    for (at, of) in found.columns().enumerate() {
        let values = (0..found.len()).map(|state| number(found.values(state).nth(at).flatten()));
        rows.set_item(of.name, column(py, values.collect()))?;
    }
    let Some(profile) = found.measures.first().and_then(|measure| measure.profile()) else { return Ok((rows, None)) };
    let all = || {
        let states = found.found.first().into_iter().flatten().enumerate();
        states.flat_map(|(state, found)| found.iter().flat_map(move |found| found.rows.iter().map(move |r| (state, r))))
    };
    let of_rows = PyDict::new(py);
    of_rows.set_item("step", integers(&mut all().map(|(state, _)| found.steps[state])))?;
    of_rows.set_item("time", column(py, all().map(|(state, _)| found.times[state]).collect()))?;
    for (at, of) in profile.columns.iter().enumerate() {
        let values = all().map(|(_, row)| number(row.get(at).copied().flatten()));
        of_rows.set_item(of.name, column(py, values.collect()))?;
    }
    Ok((rows, Some(of_rows)))
}

/// The contacts of all states that have forces, by column.
#[derive(Default)]
pub(super) struct Touching {
    step: Vec<i64>,
    ids: [Vec<i64>; 2],
    numbers: Vec<[f64; OF_CONTACTS.len()]>,
    /// The number of these states.
    pub states: usize,
}

impl Touching {
    /// Reads them.
    pub fn of(states: &States, cutoff: Option<f64>, watch: Watch<'_>) -> Result<Self, StatesError> {
        let mut all = Touching::default();
        for nth in 0..states.len() {
            if !watch(nth, states.len()) {
                break;
            }
            let state = states.read(nth)?;
            if state.warm.is_none() {
                continue;
            }
            all.states += 1;
            for contact in contacts(&state, cutoff) {
                all.step.push(state.step as i64);
                for (ids, body) in all.ids.iter_mut().zip(contact.pair) {
                    ids.push(id(state.bodies.lineage[body].id));
                }
                let ([fx, fy, fz], [nx, ny, nz]) = (contact.force().to_array(), contact.normal.to_array());
                let [x, y, z] = contact.point.to_array();
                let [separation, gamma] = [contact.separation, contact.gamma];
                all.numbers.push([state.time, separation, gamma, fx, fy, fz, nx, ny, nz, x, y, z]);
            }
        }
        Ok(all)
    }

    /// The columns.
    pub fn dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let [a, b] = &self.ids;
        let dict = named(py, [("step", self.step.clone()), ("id_a", a.clone()), ("id_b", b.clone())])?;
        for (at, name) in OF_CONTACTS.into_iter().enumerate() {
            dict.set_item(name, column(py, self.numbers.iter().map(|row| row[at]).collect()))?;
        }
        Ok(dict)
    }
}
