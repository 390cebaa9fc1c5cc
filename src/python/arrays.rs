//! Conversion of Rust data to numpy arrays, and of documents to dicts. All arrays are copies that a later step does not
//! change. They are read-only, as writing to a copy would change no simulation.

use crate::fields::Concentration;
use glam::DVec3;
use numpy::ndarray::Dimension;
use numpy::{Element, IntoPyArray, PyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

/// The parent of a founder.
pub(super) const NO_PARENT: i64 = -1;

/// The group of a body without one.
pub(super) const NO_GROUP: i32 = -1;

/// One number per row.
pub(super) fn column<T: Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    read_only(values.into_pyarray(py))
}

/// Named columns as a dict.
pub(super) fn named<'py, T: Element>(
    py: Python<'py>,
    columns: impl IntoIterator<Item = (impl AsRef<str>, Vec<T>)>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, values) in columns {
        dict.set_item(name.as_ref(), column(py, values))?;
    }
    Ok(dict)
}

fn read_only<T: Element, D: Dimension>(array: Bound<'_, PyArray<T, D>>) -> Bound<'_, PyArray<T, D>> {
    let locked = array.readwrite().make_nonwriteable();
    (*locked).clone()
}

/// `N` numbers per row.
pub(super) fn table<T: Element, const N: usize>(py: Python<'_>, rows: Vec<[T; N]>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let shape = [rows.len(), N];
    rows.into_flattened().into_pyarray(py).reshape(shape).map(read_only)
}

/// The concentrations of fields by name, each indexed by x, y and z.
pub(super) fn fields<'py>(py: Python<'py>, fields: &[Concentration]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for of in fields {
        // x is fastest.
        let [x, y, z] = of.grid.cells.map(|count| count as usize);
        let array = of.values.clone().into_pyarray(py).reshape([z, y, x])?;
        dict.set_item(&of.name, read_only(array.transpose()?))?;
    }
    Ok(dict)
}

/// Vectors as rows.
pub(super) fn vectors(of: &[DVec3]) -> Vec<[f64; 3]> {
    of.iter().map(DVec3::to_array).collect()
}

/// A document as dicts, lists and numbers; numbers are exact, and non-finite ones are None.
pub(super) fn json<'py, T: Serialize>(py: Python<'py>, document: &T) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(document).map_err(|e| super::error::Error::new_err(e.to_string()))?;
    loads(py, &text)
}

/// JSON text as dicts, lists and numbers.
pub(super) fn loads<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}
