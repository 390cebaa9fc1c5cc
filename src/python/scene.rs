//! Scenes from names, files, text and dicts.

use super::arrays::loads;
use super::error::{bad_scene, scene_fault};
use crate::record::scene_hash;
use crate::scene::{Override, Scene, SceneError, Source};
use pyo3::exceptions::{PyException, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::PathBuf;

/// The name in messages of a scene without a text.
pub(super) const DICT: &str = "dict";

/// Everything that determines a run: validated and immutable. `Scene(value, overrides=None)` is `from_dict`.
#[pyclass(frozen, name = "Scene", module = "relcp")]
pub(super) struct PyScene(pub Scene);

/// A Python value as JSON text. numpy arrays and numbers become lists and numbers by their `tolist`. A fault names the
/// value.
pub(super) fn dumps(value: &Bound<'_, PyAny>, name: &str) -> PyResult<String> {
    let py = value.py();
    let arguments = PyDict::new(py);
    arguments.set_item("allow_nan", false)?;
    arguments.set_item("default", py.import("operator")?.call_method1("methodcaller", ("tolist",))?)?;
    match py.import("json")?.call_method("dumps", (value,), Some(&arguments)) {
        Ok(text) => text.extract(),
        Err(fault) if fault.is_instance_of::<PyException>(py) => {
            let message =
                format!("{name}: expected dicts, lists, text, finite numbers, booleans and None: {}", fault.value(py));
            Err(bad_scene(py, "wrong_type", message, fault))
        }
        Err(interrupt) => Err(interrupt),
    }
}

/// Overrides: a dict from dotted keys to values, one string `KEY=VALUE`, or several. A fault names the override as
/// written.
fn overrides(py: Python<'_>, given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Override>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    let fault = |no: SceneError| scene_fault(py, &no, true);
    if let Ok(dict) = given.cast::<PyDict>() {
        let set = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            let key: String = key.extract()?;
            let name = format!("overrides[{key:?}]");
            let json = dumps(&value, &name)?;
            Override::of_json(name, &key, &json).map_err(fault)
        };
        return dict.iter().map(set).collect();
    }
    let text = |name: String, text: Bound<'_, PyAny>| {
        let text: String = text.extract()?;
        Override::named(format!("{name} {text:?}"), &text).map_err(fault)
    };
    if given.is_instance_of::<PyString>() {
        return Ok(vec![text("overrides".into(), given.clone())?]);
    }
    given.try_iter()?.enumerate().map(|(index, set)| text(format!("overrides[{index}]"), set?)).collect()
}

pub(super) fn from_text(
    py: Python<'_>,
    text: &str,
    origin: &str,
    sets: &[Override],
    written: bool,
) -> PyResult<PyScene> {
    // A fault in an override keeps its origin; a location in the text has no meaning for a dict.
    py.detach(|| Source::new(text, origin).scene(sets)).map(PyScene).map_err(|fault| {
        let in_text = fault.origin() == Some(origin);
        scene_fault(py, &fault, written || !in_text)
    })
}

#[pymethods]
impl PyScene {
    #[new]
    #[pyo3(signature = (value, overrides=None))]
    fn new(value: &Bound<'_, PyAny>, overrides: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let dict = value.cast::<PyDict>().map_err(|_| {
            PyTypeError::new_err(format!(
                "Scene: expected a dict, found {}; Scene.load reads built-in scenes and files, Scene.from_json text",
                value.get_type().name().map_or_else(|_| "another type".to_owned(), |name| name.to_string())
            ))
        })?;
        PyScene::from_dict(dict, overrides)
    }

    /// Reads a built-in scene by its name, or else a scene file by its path.
    ///
    /// `overrides` replaces values: `{"time.end": 20, "bodies.0.position.1": 2.5}` or `["time.end=20"]`. Raises
    /// SceneError with the location of the fault.
    #[staticmethod]
    #[pyo3(signature = (source, overrides=None))]
    fn load(py: Python<'_>, source: PathBuf, overrides: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let sets = self::overrides(py, overrides)?;
        py.detach(|| Scene::load_with(&source, &sets)).map(PyScene).map_err(|fault| scene_fault(py, &fault, true))
    }

    /// Reads a scene from JSON text; `origin` names the text in messages. Raises SceneError with line and column.
    #[staticmethod]
    #[pyo3(signature = (text, overrides=None, origin="text"))]
    fn from_json(py: Python<'_>, text: &str, overrides: Option<&Bound<'_, PyAny>>, origin: &str) -> PyResult<Self> {
        from_text(py, text, origin, &self::overrides(py, overrides)?, true)
    }

    /// Makes a scene from a dict with a scene file's keys; numpy arrays may replace lists. Raises SceneError with
    /// the key of the fault.
    #[staticmethod]
    #[pyo3(signature = (value, overrides=None))]
    fn from_dict(value: &Bound<'_, PyDict>, overrides: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let py = value.py();
        from_text(py, &dumps(value, DICT)?, DICT, &self::overrides(py, overrides)?, false)
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// The seed of all random numbers.
    #[getter]
    fn seed(&self) -> u64 {
        self.0.seed
    }

    /// Step size.
    #[getter]
    fn dt(&self) -> f64 {
        self.0.time.dt
    }

    /// Time at which a run starts.
    #[getter]
    fn start(&self) -> f64 {
        self.0.time.start
    }

    /// Time at which a run ends.
    #[getter]
    fn end(&self) -> f64 {
        self.0.time.end
    }

    /// The number of steps of a run, unless it stops early.
    #[getter]
    fn steps(&self) -> u64 {
        self.0.time.steps()
    }

    /// Whether bodies stay in the plane z = 0.
    #[getter]
    fn planar(&self) -> bool {
        self.0.planar
    }

    /// Names of the groups; `Simulation.groups` indexes them.
    #[getter]
    fn group_names(&self) -> Vec<String> {
        self.0.group_names()
    }

    /// A hash of the scene with every default written out; the program's `summary.json` has the same.
    #[getter]
    fn hash(&self) -> String {
        scene_hash(&self.0)
    }

    /// The scene as JSON with every default written out, like a run's `scene.json`.
    fn to_json(&self) -> String {
        self.0.with_defaults().to_json()
    }

    /// The scene as a dict with every default written out.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        loads(py, &self.to_json())
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<PyScene>().is_ok_and(|other| other.get().0.with_defaults() == self.0.with_defaults())
    }

    /// It is immutable, so a copy is the scene itself.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    /// Pickled as its JSON text, which keeps every number exactly.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((py.import("relcp")?.getattr("_scene_of_json")?, (self.0.to_json(),)))
    }

    fn __repr__(&self) -> String {
        format!("Scene({:?}, dt={}, end={})", self.0.name, self.0.time.dt, self.0.time.end)
    }
}
