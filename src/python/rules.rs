//! Rules of cells that are methods of a Python object.
//!
//! The object's `update` and `divide`, where it has them, are called with the interpreter's lock on the thread that
//! takes the step. What they see and set are the classes `Cells` and `Cell` of the package.

use super::bodies::{PyBodies, group};
use super::change::{groups, numbers};
use super::force::ForceCalls;
use crate::scene::Scene;
use crate::simulation::{Cell, CellState, CellValues, Rules};
use numpy::IntoPyArray;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// The module of the package with what rules see.
const MODULE: &str = "relcp._rules";

/// A Python object as rules.
pub(super) struct PyRules {
    object: Py<PyAny>,
    calls: ForceCalls,
    scene: Scene,
}

impl PyRules {
    /// The rules of an object that has `update`, `divide` or both.
    pub fn new(object: &Bound<'_, PyAny>, calls: ForceCalls, scene: Scene) -> PyResult<Self> {
        let methods = ["update", "divide"];
        let has = methods.into_iter().filter(|name| object.hasattr(*name).unwrap_or(false));
        let mut count = 0;
        for name in has {
            count += 1;
            if !object.getattr(name)?.is_callable() {
                return Err(PyTypeError::new_err(format!("rules: {name} is not a method")));
            }
        }
        if count == 0 {
            return Err(PyTypeError::new_err(
                "rules: expected an object with update(cells), divide(mother, daughters)",
            ));
        }
        Ok(PyRules { object: object.clone().unbind(), calls, scene })
    }

    fn method<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.object.bind(py).getattr_opt(name)
    }

    fn updated(&self, py: Python<'_>, state: &CellState<'_>, cells: &mut CellValues) -> PyResult<()> {
        let Some(update) = self.method(py, "update")? else { return Ok(()) };
        let columns = PyDict::new(py);
        for (name, values) in &cells.columns {
            columns.set_item(name, values.clone().into_pyarray(py))?;
        }
        let arguments = (
            Bound::new(py, PyBodies::of_cells(state, self.scene.group_names().into()))?,
            cells.rate.clone().into_pyarray(py),
            cells.division_length.clone().into_pyarray(py),
            cells.group.iter().map(|own| group(*own)).collect::<Vec<_>>().into_pyarray(py),
            columns,
            self.scene.group_names(),
        );
        let seen = py.import(MODULE)?.getattr("Cells")?.call1(arguments)?;
        update.call1((&seen,))?;
        let count = cells.rate.len();
        cells.rate = numbers(&seen.getattr("rates")?, "rates", count)?;
        cells.division_length = numbers(&seen.getattr("division_lengths")?, "division_lengths", count)?;
        cells.group = groups(&seen.getattr("groups")?, count, &self.scene)?;
        for (name, values) in &seen.getattr("_columns")?.cast_into::<PyDict>()? {
            let name: String = name.extract()?;
            let values = numbers(&values, &name, count)?;
            cells.columns.insert(name, values);
        }
        Ok(())
    }

    fn seen<'py>(&self, py: Python<'py>, cell: &Cell) -> PyResult<Bound<'py, PyAny>> {
        let own_group = self.scene.group_names().get(cell.group as usize).cloned();
        let columns = PyDict::new(py);
        for (name, value) in &cell.columns {
            columns.set_item(name, value)?;
        }
        let arguments = (cell.id, cell.length, cell.rate, cell.division_length, own_group, columns);
        py.import(MODULE)?.getattr("Cell")?.call1(arguments)
    }

    fn divided(&self, py: Python<'_>, mother: &Cell, daughters: [&mut Cell; 2]) -> PyResult<()> {
        let Some(divide) = self.method(py, "divide")? else { return Ok(()) };
        let pair = [self.seen(py, daughters[0])?, self.seen(py, daughters[1])?];
        divide.call1((self.seen(py, mother)?, PyTuple::new(py, &pair)?))?;
        for (cell, seen) in daughters.into_iter().zip(&pair) {
            cell.length = seen.getattr("length")?.extract()?;
            cell.rate = seen.getattr("rate")?.extract()?;
            cell.division_length = seen.getattr("division_length")?.extract()?;
            cell.group = groups(&seen.getattr("group")?, 1, &self.scene)?[0];
            for (name, value) in &seen.getattr("_columns")?.cast_into::<PyDict>()? {
                cell.columns.insert(name.extract()?, value.extract()?);
            }
        }
        Ok(())
    }
}

/// Says in a note of an exception, where Python has notes, which cell divided.
fn noted(py: Python<'_>, raised: PyErr, cell: u64) -> PyErr {
    let note = format!("in rules.divide, when cell {cell} divided");
    // A Python before 3.11 has no notes; the exception is the same.
    let _ = raised.value(py).call_method1("add_note", (note,));
    raised
}

impl Rules for PyRules {
    fn update(&mut self, state: &CellState<'_>, cells: &mut CellValues) -> Result<(), String> {
        self.calls.ask(|py| self.updated(py, state, cells))
    }

    fn divide(&mut self, mother: &Cell, daughters: [&mut Cell; 2]) -> Result<(), String> {
        self.calls.ask(|py| self.divided(py, mother, daughters).map_err(|raised| noted(py, raised, mother.id)))
    }
}
