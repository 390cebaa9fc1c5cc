//! Values that Python gives for bodies, as changes of the state.

use super::arrays::loads;
use super::error::{fault, scene_fault};
use super::scene::{DICT, dumps, from_text};
use crate::bodies::NO_GROUP;
use crate::scene::{Body, Scene};
use crate::simulation::{Change, ChangeError, Values, Which};
use glam::{DQuat, DVec3};
use pyo3::exceptions::{PyIndexError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The module of the package that makes arrays of what users give.
const GIVEN: &str = "relcp._given";

/// The keys of a scene that say what a body of it may have.
const OF_BODIES: [&str; 5] = ["name", "time", "dynamics", "planar", "contact"];

/// The exception of a change that was refused.
pub(super) fn refused(py: Python<'_>, no: ChangeError) -> PyErr {
    match no {
        ChangeError::Scene(no) => scene_fault(py, &no, false),
        ChangeError::Fault(no) => fault(no),
        ChangeError::Which(no) => PyIndexError::new_err(no),
        other => PyValueError::new_err(other.to_string()),
    }
}

/// The bodies that indices, a mask or ids choose, and their number.
pub(super) fn which(
    of: Option<&Bound<'_, PyAny>>,
    ids: Option<&Bound<'_, PyAny>>,
    bodies: usize,
) -> PyResult<(Which, usize)> {
    match (of, ids) {
        (Some(_), Some(_)) => Err(PyTypeError::new_err("bodies are chosen by `of` or by `ids`, not by both")),
        (None, None) => Ok((Which::All, bodies)),
        (Some(of), None) => {
            let chosen: Vec<usize> = given(of.py(), "indices", (of, bodies))?.extract()?;
            let count = chosen.len();
            Ok((Which::Indices(chosen), count))
        }
        (None, Some(ids)) => {
            let chosen: Vec<u64> = given(ids.py(), "ids", (ids,))?.extract()?;
            let count = chosen.len();
            Ok((Which::Ids(chosen), count))
        }
    }
}

fn given<'py>(
    py: Python<'py>,
    function: &str,
    arguments: impl pyo3::call::PyCallArgs<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    py.import(GIVEN)?.getattr(function)?.call1(arguments)
}

/// `count` rows of `N` numbers; one row stands for all.
fn rows<const N: usize>(value: &Bound<'_, PyAny>, name: &str, count: usize) -> PyResult<Vec<[f64; N]>> {
    let flat: Vec<f64> = given(value.py(), "rows", (value, name, count, N))?.extract()?;
    Ok(flat.as_chunks::<N>().0.to_vec())
}

/// `count` numbers; one stands for all.
pub(super) fn numbers(value: &Bound<'_, PyAny>, name: &str, count: usize) -> PyResult<Vec<f64>> {
    given(value.py(), "rows", (value, name, count, 1))?.extract()
}

/// `count` groups by name or index; one stands for all.
pub(super) fn groups(value: &Bound<'_, PyAny>, count: usize, scene: &Scene) -> PyResult<Vec<u32>> {
    let own: Vec<i32> = given(value.py(), "groups", (value, count, scene.group_names()))?.extract()?;
    Ok(own.into_iter().map(|group| u32::try_from(group).unwrap_or(NO_GROUP)).collect())
}

/// The change that gives bodies values. Groups come first, as they say who grows.
pub(super) fn setting(
    which: &Which,
    count: usize,
    values: &[(&str, Option<Bound<'_, PyAny>>)],
    scene: &Scene,
) -> PyResult<Change> {
    let mut change = Change::new();
    let vectors = |value: &Bound<'_, PyAny>, name: &str| -> PyResult<Vec<DVec3>> {
        Ok(rows::<3>(value, name, count)?.into_iter().map(DVec3::from_array).collect())
    };
    for (name, value) in values.iter().filter_map(|(name, value)| Some((*name, value.as_ref()?))) {
        if name == "columns" {
            for (name, value) in &value.cast::<PyDict>()?.clone() {
                let name: String = name.extract()?;
                let own = numbers(&value, &name, count)?;
                change = change.set(which.clone(), Values::Column(name, own));
            }
            continue;
        }
        let value = match name {
            "position" => Values::Position(vectors(value, name)?),
            "orientation" => {
                let turns = rows::<4>(value, name, count)?;
                Values::Orientation(turns.into_iter().map(|[w, x, y, z]| DQuat::from_xyzw(x, y, z, w)).collect())
            }
            "velocity" => Values::Velocity(vectors(value, name)?),
            "angular_velocity" => Values::AngularVelocity(vectors(value, name)?),
            "length" => Values::Length(numbers(value, name, count)?),
            "rate" => Values::Rate(numbers(value, name, count)?),
            "division_length" => Values::DivisionLength(numbers(value, name, count)?),
            _ => Values::Group(groups(value, count, scene)?),
        };
        change = change.set(which.clone(), value);
    }
    Ok(change)
}

/// Bodies from dicts as in a scene's `bodies`.
pub(super) fn bodies(value: &Bound<'_, PyAny>, scene: &Scene) -> PyResult<Vec<Body>> {
    let py = value.py();
    let whole = loads(py, &scene.with_defaults().to_json())?;
    let small = PyDict::new(py);
    for key in OF_BODIES {
        small.set_item(key, whole.get_item(key)?)?;
    }
    // Its groups are not those of these bodies alone.
    whole.get_item("contact")?.call_method1("pop", ("friction", py.None()))?;
    small.set_item("bodies", value)?;
    Ok(from_text(py, &dumps(small.as_any(), DICT)?, DICT, &[], false)?.0.bodies)
}
