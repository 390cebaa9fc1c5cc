//! Conversion of Rust data to numpy arrays, and of documents to dicts. All arrays are copies: a later step does not
//! change them.

use glam::DVec3;
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use serde::Serialize;

/// The parent of a founder, as in state files.
pub(super) const NO_PARENT: u64 = u64::MAX;

/// One number per row.
pub(super) fn column<T: Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    values.into_pyarray(py)
}

/// `N` numbers per row.
pub(super) fn table<T: Element, const N: usize>(py: Python<'_>, rows: Vec<[T; N]>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let shape = [rows.len(), N];
    rows.into_flattened().into_pyarray(py).reshape(shape)
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
