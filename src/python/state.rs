//! A recorded state: the arrays of its bodies, and what is computed from it.

use super::arrays::{self, column};
use super::bodies::{Column, PyBodies};
use super::bonds::{Bonds, Held};
use super::contacts::{AtWalls, Contacts, Pairs, WallContacts, is_smooth};
use super::error::rendered;
use super::measure;
use super::picture::{self, Look, Picture};
use super::work::quietly;
use crate::fields::Concentration;
use crate::record::{Snapshot, TOUCHING};
use crate::render::{still, still_file};
use crate::scene::Scene;
use crate::simulation::CellValues;
use crate::view::{Pages, page_of_state};
use crate::walls::Walls;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// A recorded state of a run: the arrays of a `Simulation`, one row per body, each made when it is read. Every array is
/// a read-only copy.
#[pyclass(frozen, extends = PyBodies, name = "State", module = "relcp")]
pub(super) struct PyState {
    scene: Arc<Scene>,
    step: u64,
    removed: Vec<u64>,
    fields: Vec<Concentration>,
    has_forces: bool,
}

impl PyState {
    /// A state of a run of `scene`.
    pub fn new(scene: Arc<Scene>, state: Snapshot) -> PyClassInitializer<Self> {
        let Snapshot { step, time, bodies, warm, removed, fields } = state;
        let has_forces = warm.is_some();
        let names = scene.group_names().into();
        let base = PyBodies::new(bodies, time, warm.unwrap_or_default(), names);
        PyClassInitializer::from(base).add_subclass(PyState { scene, step, removed, fields, has_forces })
    }

    /// A copy of it as it was recorded.
    fn snapshot(slf: &PyRef<'_, Self>) -> Snapshot {
        let base = slf.as_super();
        let warm = slf.has_forces.then(|| base.warm.clone());
        let (step, removed, fields) = (slf.step, slf.removed.clone(), slf.fields.clone());
        Snapshot { step, time: base.time, bodies: base.bodies.clone(), warm, removed, fields }
    }

    /// The scene with its changes before this state.
    fn scene_then(&self) -> Arc<Scene> {
        self.scene.after(self.step).map_or_else(|| self.scene.clone(), Arc::new)
    }

    /// The cutoff that a user gives, or a thousandth of the thinnest body's thickness.
    fn cutoff(slf: &PyRef<'_, Self>, given: Option<f64>) -> PyResult<f64> {
        if given.is_some_and(|cutoff| !cutoff.is_finite()) {
            return Err(PyValueError::new_err("cutoff: expected a finite length"));
        }
        let shapes = &slf.as_super().bodies.shape;
        let thinnest = shapes.iter().map(|shape| shape.thickness()).fold(f64::INFINITY, f64::min);
        Ok(given.unwrap_or(if thinnest.is_finite() { TOUCHING * thinnest } else { 0.0 }))
    }

    fn cells(slf: &PyRef<'_, Self>) -> PyResult<CellValues> {
        let (scene, bodies) = (slf.scene_then(), &slf.as_super().bodies);
        quietly(slf.py(), || CellValues::in_scene(&scene, bodies))
    }
}

#[pymethods]
impl PyState {
    /// The number of steps before it.
    #[getter]
    fn step(&self) -> u64 {
        self.step
    }

    /// The number of its bodies.
    #[getter]
    fn n_bodies(slf: PyRef<'_, Self>) -> usize {
        slf.as_super().bodies.len()
    }

    /// Whether it was recorded with its contact forces: the last state of a run, and with `output.forces` each.
    #[getter]
    fn has_forces(&self) -> bool {
        self.has_forces
    }

    /// (N,): relative growth rates without pressure; zero for a body that does not grow.
    #[getter]
    fn rates(slf: PyRef<'_, Self>) -> Column<'_, f64> {
        let py = slf.py();
        Ok(column(py, PyState::cells(&slf)?.rate))
    }

    /// (N,): lengths at which cells divide; infinite by a timer, and for a body that does not grow.
    #[getter]
    fn division_lengths(slf: PyRef<'_, Self>) -> Column<'_, f64> {
        let py = slf.py();
        Ok(column(py, PyState::cells(&slf)?.division_length))
    }

    /// All pairs of bodies whose separation is at most `cutoff`, a length; by default a thousandth of the thinnest
    /// body's thickness. `gamma` and `force` are NaN in a state without forces.
    #[pyo3(signature = (cutoff=None))]
    fn contacts(slf: PyRef<'_, Self>, cutoff: Option<f64>) -> PyResult<Contacts> {
        let (py, cutoff) = (slf.py(), PyState::cutoff(&slf, cutoff)?);
        let (has_forces, base) = (slf.has_forces, slf.as_super());
        let (bodies, warm) = (&base.bodies, has_forces.then_some(&base.warm[..]));
        let found = quietly(py, || Pairs::of(bodies, warm, cutoff))?;
        Contacts::new(py, found)
    }

    /// All bodies and surfaces of walls whose separation is at most `cutoff`, as `contacts`.
    #[pyo3(signature = (cutoff=None))]
    fn wall_contacts(slf: PyRef<'_, Self>, cutoff: Option<f64>) -> PyResult<WallContacts> {
        let (py, cutoff) = (slf.py(), PyState::cutoff(&slf, cutoff)?);
        let (scene, base) = (slf.scene_then(), slf.as_super());
        let (bodies, warm) = (&base.bodies, slf.has_forces.then_some(&base.warm[..]));
        let walls = Walls::new(&scene.walls, scene.planar).at(base.time).gone(&base.bodies.walls);
        let found = quietly(py, || AtWalls::of(&walls, bodies, warm, is_smooth(&scene), cutoff))?;
        WallContacts::new(py, found)
    }

    /// The bonds and joints that hold. `force`, `torque` and `tension` are NaN in a state without forces.
    #[getter]
    fn bonds(slf: PyRef<'_, Self>) -> PyResult<Bonds> {
        Bonds::new(slf.py(), Held::of(&slf.as_super().bodies))
    }

    /// The concentrations of the scene's fields by name, each indexed by x, y and z.
    #[getter]
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        arrays::fields(py, &self.fields)
    }

    /// A measure of this state by its name, as `Simulation.measure`.
    fn measure<'py>(slf: PyRef<'py, Self>, name: &str) -> PyResult<Bound<'py, PyDict>> {
        let (py, measure, state) = (slf.py(), measure::named(name)?, PyState::snapshot(&slf));
        let scene = slf.scene_then();
        let found = quietly(py, || measure::found(&scene, &state, measure))?;
        measure::dict(py, measure, found)
    }

    /// A picture of this state, as `Simulation.render`.
    #[pyo3(signature = (width=960, height=None, *, view=None, colour="orientation", range=None, background="white", words=true))]
    #[allow(clippy::too_many_arguments)]
    fn render<'py>(
        slf: PyRef<'py, Self>,
        width: u32,
        height: Option<u32>,
        view: Option<&str>,
        colour: &str,
        range: Option<[f64; 2]>,
        background: &str,
        words: bool,
    ) -> PyResult<Picture<'py>> {
        let frames = Look { width, height, view, colour, range, background, words }.frames()?;
        let (py, scene, state) = (slf.py(), slf.scene_then(), PyState::snapshot(&slf));
        let drawn = quietly(py, || still(&scene, state, &frames))?;
        picture::array(py, drawn.map_err(|no| rendered(py, no))?)
    }

    /// Writes a picture of this state into a file, as `Simulation.save_picture`.
    #[pyo3(signature = (path, width=960, height=None, *, view=None, colour="orientation", range=None, background="white", words=true))]
    #[allow(clippy::too_many_arguments)]
    fn save_picture(
        slf: PyRef<'_, Self>,
        path: PathBuf,
        width: u32,
        height: Option<u32>,
        view: Option<&str>,
        colour: &str,
        range: Option<[f64; 2]>,
        background: &str,
        words: bool,
    ) -> PyResult<PathBuf> {
        let look = Look { width, height, view, colour, range, background, words };
        let frames = picture::in_file(&look, &path)?;
        let (py, scene, state) = (slf.py(), slf.scene_then(), PyState::snapshot(&slf));
        let drawn = quietly(py, || still_file(&scene, state, &frames))?;
        picture::placed(py, path, drawn)
    }

    /// The page of `relcp view` of this state, as `Simulation.show`.
    #[pyo3(signature = (width=None, height=None, *, colour="orientation"))]
    fn show<'py>(
        slf: PyRef<'py, Self>,
        width: Option<Bound<'py, PyAny>>,
        height: Option<Bound<'py, PyAny>>,
        colour: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let pages = Pages { colour: Some(picture::quantity(colour)?), ..Pages::default() };
        let (py, scene, state) = (slf.py(), slf.scene_then(), PyState::snapshot(&slf));
        let made = quietly(py, || page_of_state(&scene, state, &pages))?;
        let (page, viewed) = made.map_err(|no| rendered(py, no))?;
        picture::page(py, page, &viewed.notes, width, height)
    }

    fn __repr__(slf: PyRef<'_, Self>) -> String {
        let base = slf.as_super();
        format!("State(step={}, time={}, bodies={})", slf.step, base.time, base.bodies.len())
    }
}
