//! A run's folder: its scene, states and tables, and what the program makes of them. `relcp.Run` is made of it.

use super::arrays::column;
use super::compute::warn;
use super::error::{self, exported, measured, recorded, rendered, scene_fault, states};
use super::measure;
use super::picture::one_of;
use super::reel::{self, PyReel, frames, pages};
use super::scene::PyScene;
use super::state::PyState;
use super::tables::{Touching, dict, of_measure};
use super::work::{quietly, watched};
use crate::export::{Format, export};
use crate::measure::{DOMAIN_ANGLE, Settings, measure as measure_all};
use crate::record::{EarlierRun, EarlierState, Folder, RecordError, States, Table};
use crate::scene::Scene;
use crate::view::{page_of_run, view};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// A run's folder as it was when it was read.
#[pyclass(frozen, name = "Recorded", module = "relcp._relcp")]
pub(super) struct Recorded {
    path: PathBuf,
    scene: Arc<Scene>,
    states: OnceLock<Arc<States>>,
}

impl Recorded {
    fn folder(&self) -> Folder {
        Folder::view(&self.path)
    }

    /// The states, found and checked once.
    fn states(&self, py: Python<'_>) -> PyResult<Arc<States>> {
        if let Some(found) = self.states.get() {
            return Ok(found.clone());
        }
        let found = quietly(py, || States::open(&self.path))?.map_err(|no| states(py, &no))?;
        found.notes().iter().try_for_each(|note| warn(py, note))?;
        Ok(self.states.get_or_init(|| Arc::new(found)).clone())
    }
}

#[pymethods]
impl Recorded {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let folder = Folder::view(&path);
        if !folder.scene().is_file() {
            let why = if path.is_dir() { "it has no scene.json" } else { "there is no such folder" };
            let message = format!("{}: not the folder of a run: {why}", path.display());
            return Err(error::RecordError::new_err(message));
        }
        let scene = py.detach(|| Scene::read(folder.scene())).map_err(|no| scene_fault(py, &no, true))?;
        Ok(Recorded { path, scene: Arc::new(scene), states: OnceLock::new() })
    }

    fn scene(&self) -> PyScene {
        PyScene((*self.scene).clone())
    }

    /// The number of states.
    fn len(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.states(py)?.len())
    }

    /// One state.
    fn state<'py>(&self, py: Python<'py>, nth: usize) -> PyResult<Bound<'py, PyState>> {
        let all = self.states(py)?;
        if nth >= all.len() {
            return Err(PyIndexError::new_err(format!("state {nth}; there are {}", all.len())));
        }
        let read = quietly(py, || all.read(nth).map(|state| state.into_owned()))?.map_err(|no| states(py, &no))?;
        Bound::new(py, PyState::new(self.scene.clone(), read))
    }

    /// Steps, times and numbers of bodies of all states.
    fn heads<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = self.states(py)?;
        let head = |nth: usize| all.read(nth).map(|state| (state.step as i64, state.time, state.bodies.len() as i64));
        let heads = quietly(py, || (0..all.len()).into_par_iter().map(head).collect::<Result<Vec<_>, _>>())?;
        let heads = heads.map_err(|no| states(py, &no))?;
        let dict = PyDict::new(py);
        dict.set_item("step", column(py, heads.iter().map(|head| head.0).collect()))?;
        dict.set_item("time", column(py, heads.iter().map(|head| head.1).collect()))?;
        dict.set_item("bodies", column(py, heads.iter().map(|head| head.2).collect()))?;
        Ok(dict)
    }

    /// A table of the folder: "steps", "measures" or "lineage"; None where the run does not write it.
    fn table<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyDict>>> {
        type Read = fn(&Path) -> Result<Table, RecordError>;
        let folder = self.folder();
        let (path, read): (PathBuf, Read) = match name {
            "steps" => (folder.steps(), Table::steps),
            "measures" => (folder.measures(), Table::measures),
            _ => (folder.lineage(), Table::lineage),
        };
        if !path.exists() {
            return Ok(None);
        }
        let table = py.detach(|| read(&path)).map_err(|no| recorded(&no))?;
        dict(py, table).map(Some)
    }

    /// The text of `summary.json`; None before the run's first end.
    fn summary(&self) -> PyResult<Option<String>> {
        let path = self.folder().summary();
        match std::fs::read_to_string(&path) {
            Ok(text) => Ok(Some(text)),
            Err(no) if no.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(no) => Err(recorded(&RecordError::io(&path, "read it")(no))),
        }
    }

    /// "running", "ended" or "unfinished"; None without a checkpoint.
    fn standing(&self) -> Option<&'static str> {
        EarlierRun::state_of(&self.path).map(|state| match state {
            EarlierState::Running => "running",
            EarlierState::Ended => "ended",
            EarlierState::Unfinished => "unfinished",
        })
    }

    /// The contacts of all states with forces, and the number of these states.
    fn contacts<'py>(&self, py: Python<'py>, cutoff: Option<f64>) -> PyResult<(Bound<'py, PyDict>, usize)> {
        if cutoff.is_some_and(|cutoff| !cutoff.is_finite()) {
            return Err(PyValueError::new_err("cutoff: expected a finite length"));
        }
        let all = self.states(py)?;
        let found = watched(py, |watch| Touching::of(&all, cutoff, watch))?.map_err(|no| states(py, &no))?;
        Ok((found.dict(py)?, found.states))
    }

    /// A measure over all states: its columns, those of its profile, and notes.
    #[pyo3(signature = (name, bin=None, neighbourhood=None, domain_angle=None, cutoff=None, seed=1))]
    #[allow(clippy::too_many_arguments, clippy::type_complexity)]
    fn measure<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        bin: Option<f64>,
        neighbourhood: Option<f64>,
        domain_angle: Option<f64>,
        cutoff: Option<f64>,
        seed: u64,
    ) -> PyResult<(Bound<'py, PyDict>, Option<Bound<'py, PyDict>>, Vec<String>)> {
        for (of, value) in [("bin", bin), ("neighbourhood", neighbourhood), ("domain_angle", domain_angle)] {
            if value.is_some_and(|value| !(value > 0.0 && value.is_finite())) {
                return Err(PyValueError::new_err(format!("{of}: expected a positive number")));
            }
        }
        let domain_angle_degrees = domain_angle.unwrap_or(DOMAIN_ANGLE);
        let settings = Settings { bin, neighbourhood, domain_angle_degrees, cutoff, seed, ..Settings::default() };
        let (measure, all) = (measure::named(name)?, self.states(py)?);
        let found = watched(py, |watch| measure_all(&self.path, &all, &[measure], &settings, watch))?;
        let found = found.map_err(|no| measured(py, no))?;
        let (rows, profile) = of_measure(py, &found)?;
        Ok((rows, profile, found.notes))
    }

    /// Writes all states, or the last, in another format; returns the files and notes.
    fn export(
        &self,
        py: Python<'_>,
        format: &str,
        path: Option<PathBuf>,
        cutoff: Option<f64>,
        last: bool,
    ) -> PyResult<(Vec<PathBuf>, Vec<String>)> {
        let formats =
            [("gsd", Format::Gsd), ("lammps", Format::Lammps), ("vtk", Format::Vtk { cutoff }), ("xyz", Format::Xyz)];
        let format_of = one_of("format", format, &formats)?;
        if cutoff.is_some() && format != "vtk" {
            return Err(PyValueError::new_err(format!("cutoff: selects contacts, and {format} has none; vtk does")));
        }
        let all = (*self.states(py)?).clone();
        let all = if last { all.last() } else { all };
        let path = path.unwrap_or_else(|| self.path.join(format));
        let done = watched(py, |watch| export(&all, format_of, &path, watch))?.map_err(|no| exported(py, no))?;
        Ok((done.files, done.notes))
    }

    /// The pictures of the states; `look` has the arguments of `render`, and `fit`.
    fn reel(
        &self,
        py: Python<'_>,
        look: &Bound<'_, PyDict>,
        every: usize,
        start: Option<f64>,
        end: Option<f64>,
    ) -> PyResult<PyReel> {
        PyReel::of(py, self.scene.clone(), self.states(py)?, frames(look, every, start, end)?)
    }

    /// Makes a movie of the states.
    #[allow(clippy::too_many_arguments)]
    fn movie(
        &self,
        py: Python<'_>,
        path: PathBuf,
        frames_a_second: u32,
        look: &Bound<'_, PyDict>,
        every: usize,
        start: Option<f64>,
        end: Option<f64>,
    ) -> PyResult<PathBuf> {
        let frames = frames(look, every, start, end)?;
        reel::movie(py, (&self.path, &*self.states(py)?), &frames, frames_a_second, &path)?;
        Ok(path)
    }

    /// Writes the page of `relcp view`; returns its file and notes.
    fn view(
        &self,
        py: Python<'_>,
        path: Option<PathBuf>,
        colour: &str,
        every: usize,
        start: Option<f64>,
        end: Option<f64>,
    ) -> PyResult<(PathBuf, Vec<String>)> {
        let (pages, all) = (pages(colour, every, start, end)?, self.states(py)?);
        let path = path.unwrap_or_else(|| self.path.join("view.html"));
        let done = watched(py, |watch| view(&self.path, &all, &pages, &path, watch))?;
        Ok((path, done.map_err(|no| rendered(py, no))?.notes))
    }

    /// The page of `relcp view`, and notes.
    fn page(
        &self,
        py: Python<'_>,
        colour: &str,
        every: usize,
        start: Option<f64>,
        end: Option<f64>,
    ) -> PyResult<(String, Vec<String>)> {
        let (pages, all) = (pages(colour, every, start, end)?, self.states(py)?);
        let made = watched(py, |watch| page_of_run(&self.path, &all, &pages, watch))?;
        let (page, viewed) = made.map_err(|no| rendered(py, no))?;
        Ok((String::from_utf8_lossy(&page).into_owned(), viewed.notes))
    }
}
