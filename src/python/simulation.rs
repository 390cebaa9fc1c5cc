//! A simulation: steps with the interpreter's lock released, and copied arrays.

use super::arrays::{self, column, json, named, table, vectors};
use super::bodies::{self, Column, Table};
use super::bonds::{Bonds, Held};
use super::change::{bodies as bodies_of, refused, setting, which};
use super::compute::Wanted;
use super::contacts::{AtWalls, Contacts, Pairs, WallContacts, is_smooth};
use super::error::{RecordError, SimulationError, fault, recorded, rendered, scene_fault};
use super::force::{ForceCalls, PyForce};
use super::limit::{StepLimit, asks_to_stop};
use super::measure;
use super::picture::{self, Look, Picture};
use super::report::StepReport;
use super::rules::PyRules;
use super::scene::{PyScene, dumps};
use super::session::{End, Session, Threads};
use crate::bodies::Bodies;
use crate::error::Error;
use crate::record::{Snapshot, decode, read_state, scene_hash, state_hash};
use crate::render::{still, still_file};
use crate::run::Summary;
use crate::scene::Scene;
use crate::simulation::{CellValues, Change, Compute, Rules};
use crate::step::{Fault, State};
use crate::view::{Pages, page_of_state};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

/// Wall time between checks of Python's signals. Acquiring the interpreter's lock may cost its switch interval (5 ms)
/// if other threads run, so it does not happen after every step; a delay of a twentieth of a second is not noticeable.
const SIGNALS_EVERY: Duration = Duration::from_millis(50);

/// A scene's bodies and their backend: `Simulation(scene, backend="cpu", threads=None, precision=None,
/// adapter=None)`.
///
/// `backend` is "cpu", "gpu" (a hardware GPU, or else a software adapter) or "auto" (the CPU, with a warning if a
/// hardware GPU may be faster). `threads` is its own number of threads; None uses those of the process, one per core.
/// `precision` is "f32" or "f64" on a GPU; by default f64 on a software adapter and f32 on hardware; `adapter` is a
/// part of a GPU's name. The same scene gives the same bits for any number of threads, and those of the program.
///
/// Every array is a read-only copy of the state after the last accepted step, with one row per body; N is the number of
/// bodies. `set`, `add` and `remove` change the state, `rules` lets cells decide. Lengths and times are in the scene's
/// units.
#[pyclass(frozen, name = "Simulation", module = "relcp")]
pub(super) struct PySimulation {
    session: Mutex<Session>,
    /// Whether its state is on a device.
    on_device: bool,
    /// Shared with its forces and its rules.
    force_calls: ForceCalls,
    /// The functions of its forces and the object of its rules, for pickles.
    given: Mutex<Given>,
}

/// What Python has given a simulation.
#[derive(Default)]
struct Given {
    forces: Vec<Py<PyAny>>,
    rules: Option<Py<PyAny>>,
}

impl PySimulation {
    fn hold(session: Session, compute: &Compute) -> Self {
        let on_device = !matches!(compute, Compute::Cpu);
        let (session, given) = (Mutex::new(session), Mutex::default());
        PySimulation { session, on_device, force_calls: ForceCalls::new(), given }
    }

    /// Starts a scene from its own bodies.
    pub(super) fn start(py: Python<'_>, scene: &Scene, compute: &Compute, threads: Threads) -> PyResult<Self> {
        let scene = scene.clone();
        let session = py.detach(|| Session::start(compute, scene, threads)).map_err(|no| no_start(py, no))?;
        Ok(PySimulation::hold(session, compute))
    }

    /// The limit of a run to the scene's end, or to a given time.
    pub(super) fn limit(&self, py: Python<'_>, until: Option<f64>) -> PyResult<StepLimit> {
        StepLimit::until(self.session(py)?.simulation(), until)
    }

    /// Steps without the interpreter's lock until it should stop; it also waits for the session without the lock.
    pub(super) fn run_quietly(&self, limit: StepLimit, wall: Duration, stops: &AtomicBool) -> Result<(), Fault> {
        let Ok(mut session) = self.session.lock() else { return Ok(()) };
        let mut left = limit.most;
        while left > 0 && !stops.load(Ordering::Relaxed) {
            let (batch, ended) = session.advance(left, limit.end, wall);
            ended?;
            left -= batch.taken;
            if batch.taken == 0 {
                break;
            }
        }
        session.simulation().device().iter().for_each(|gpu| gpu.rest());
        Ok(())
    }

    /// Its device is idle for a while.
    pub(super) fn rest(&self) {
        if let Ok(session) = self.session.lock() {
            session.simulation().device().iter().for_each(|gpu| gpu.rest());
        }
    }

    /// The summary of its run so far, without the interpreter's lock; none after an internal fault.
    pub(super) fn summed(&self) -> Result<Option<Summary>, Fault> {
        self.session.lock().ok().map(|mut session| session.summary()).transpose()
    }

    /// Waits for the session, with the interpreter's lock released if another thread has it.
    fn session(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Session>> {
        if self.force_calls.is_evaluating() {
            return Err(SimulationError::new_err(
                "this simulation is evaluating a force or a rule during a step; use the argument of that function instead",
            ));
        }
        let session = self.session.lock_py_attached(py);
        let session = session.map_err(|_| SimulationError::new_err("an internal fault ended this simulation"))?;
        if session.live() {
            return Ok(session);
        }
        Err(SimulationError::new_err(
            "this simulation's threads are in the parent of this forked process; create the simulation here, or save and resume it",
        ))
    }

    /// Runs a long computation with the interpreter's lock released.
    fn compute<T: Send>(&self, py: Python<'_>, of: impl FnOnce(&mut Session) -> T + Send) -> PyResult<T> {
        drop(self.session(py)?);
        let computed = py.detach(|| self.session.lock().ok().map(|mut session| of(&mut session)));
        computed.ok_or_else(|| SimulationError::new_err("an internal fault ended this simulation"))
    }

    /// Copies data from the state.
    fn copy<T: Send>(&self, py: Python<'_>, of: impl FnOnce(&State) -> T + Send) -> PyResult<T> {
        let copied = match self.on_device {
            true => self.compute(py, |session| session.simulation().state().map(of))?,
            false => self.session(py)?.simulation().state().map(of),
        };
        copied.map_err(fault)
    }

    fn bodies<T: Send>(&self, py: Python<'_>, of: impl FnOnce(&Bodies) -> T + Send) -> PyResult<T> {
        self.copy(py, |state| of(&state.bodies))
    }

    /// The exception for a step's fault: that of a force or a rule if it raised one.
    pub(super) fn fault(&self, no: Fault) -> PyErr {
        match (&no, self.force_calls.take()) {
            (Fault::Force { .. } | Fault::Rules { .. }, Some(raised)) => raised,
            (Fault::Rules { .. }, None) => PyValueError::new_err(no.to_string()),
            _ => fault(no),
        }
    }

    /// Changes the state.
    fn change(&self, py: Python<'_>, change: &Change) -> PyResult<Vec<u64>> {
        self.compute(py, |session| session.change(change))?.map_err(|no| refused(py, no))
    }

    /// What rules may change, as it is now.
    fn cells(&self, py: Python<'_>) -> PyResult<CellValues> {
        self.compute(py, |session| session.cell_values())?.map_err(fault)
    }

    /// The scene as it is now, and the present state as a recorded one.
    fn present(&self, py: Python<'_>) -> PyResult<(Scene, Snapshot)> {
        let present = self.compute(py, |session| {
            let simulation = session.simulation();
            simulation.state().map(|state| {
                let snapshot = Snapshot {
                    step: state.step,
                    time: simulation.time(),
                    bodies: state.bodies.clone(),
                    warm: Some(state.warm.clone()),
                    removed: state.removed.clone(),
                    fields: state.fields.clone(),
                };
                (simulation.scene().clone(), snapshot)
            })
        })?;
        present.map_err(fault)
    }

    fn given(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Given>> {
        let given = self.given.lock_py_attached(py);
        given.map_err(|_| SimulationError::new_err("an internal fault ended this simulation"))
    }

    /// Takes steps, if any are left.
    fn advance(&self, py: Python<'_>, limit: StepLimit) -> PyResult<Option<StepReport>> {
        let StepLimit { most: mut left, end } = limit;
        let mut last = None;
        loop {
            let (batch, ended) = self.compute(py, |session| session.advance(left, end, SIGNALS_EVERY))?;
            ended.map_err(|no| self.fault(no))?;
            left -= batch.taken;
            last = batch.last.or(last);
            if left == 0 || batch.taken == 0 {
                return Ok(last.map(|(report, wall)| StepReport::new(&report, wall)));
            }
            py.check_signals()?;
        }
    }
}

fn no_start(py: Python<'_>, no: Error) -> PyErr {
    match no {
        Error::Scene(refused) => scene_fault(py, &refused, true),
        Error::Fault(refused) => fault(refused),
        other => SimulationError::new_err(other.to_string()),
    }
}

#[pymethods]
impl PySimulation {
    #[new]
    #[pyo3(signature = (scene, backend="cpu", threads=None, precision=None, adapter=None))]
    fn new(
        py: Python<'_>,
        scene: &PyScene,
        backend: &str,
        threads: Option<usize>,
        precision: Option<&str>,
        adapter: Option<&str>,
    ) -> PyResult<Self> {
        let wanted = Wanted { backend, threads, precision, adapter };
        let threads = Threads::new(wanted.pool()?);
        let compute: Compute = wanted.settle(py, &scene.0)?;
        PySimulation::start(py, &scene.0, &compute, threads)
    }

    /// Continues from a state that `save` or the program wrote for the same scene: from a checkpoint, on the CPU, to
    /// the same bits as an uninterrupted run. Raises RecordError if the file cannot be used, or belongs to a different
    /// scene.
    #[staticmethod]
    #[pyo3(signature = (scene, path, backend="cpu", threads=None, precision=None, adapter=None))]
    fn resume(
        py: Python<'_>,
        scene: &PyScene,
        path: PathBuf,
        backend: &str,
        threads: Option<usize>,
        precision: Option<&str>,
        adapter: Option<&str>,
    ) -> PyResult<Self> {
        let wanted = Wanted { backend, threads, precision, adapter };
        let threads = Threads::new(wanted.pool()?);
        let (header, state) = py.detach(|| read_state(&path)).map_err(|no| recorded(&no))?;
        if header.scene != scene_hash(&scene.0) {
            return Err(RecordError::new_err(format!("{}: the state belongs to a different scene", path.display())));
        }
        let compute: Compute = wanted.settle(py, &scene.0)?;
        let (scene, totals) = (scene.0.clone(), header.totals.unwrap_or_default());
        let session = py.detach(|| Session::resume(&compute, scene, state, totals, threads)).map_err(fault)?;
        Ok(PySimulation::hold(session, &compute))
    }

    /// Takes `n` steps and returns the last one's report. It ends at the scene's end or its `growth.stop`, unless
    /// `past_end`. Ctrl-C ends it between two steps, with the state of the last one.
    ///
    /// Raises SimulationError or DeviceError if a step fails, or if the end is already reached.
    #[pyo3(signature = (n=1, *, past_end=false))]
    fn step(&self, py: Python<'_>, n: u64, past_end: bool) -> PyResult<StepReport> {
        if n == 0 {
            return Err(PyValueError::new_err("n: expected at least one step"));
        }
        let end = if past_end { End::None } else { End::OfScene };
        self.advance(py, StepLimit { most: n, end })?.ok_or_else(|| {
            SimulationError::new_err(
                "the scene's end is reached, and no step was taken; past_end=True takes steps beyond it",
            )
        })
    }

    /// Steps to the scene's end or its `growth.stop`, and returns the summary. Ctrl-C ends it between two steps; call
    /// it again to continue.
    ///
    /// `until` replaces the end by the first step whose time is at least this, also past the scene's end, but not past
    /// `growth.stop`. `callback` is called after every `every` steps, and after the last, with the report of that step;
    /// the run ends if it returns False. It may read the simulation.
    ///
    /// Raises SimulationError or DeviceError if a step fails, and the exceptions of the callback.
    #[pyo3(signature = (*, until=None, callback=None, every=1))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        until: Option<f64>,
        callback: Option<Bound<'py, PyAny>>,
        every: u64,
    ) -> PyResult<Bound<'py, PyAny>> {
        if every == 0 {
            return Err(PyValueError::new_err("every: expected at least one step"));
        }
        let StepLimit { most, end } = StepLimit::until(self.session(py)?.simulation(), until)?;
        let last = self.steps(py)?.saturating_add(most);
        let stride = if callback.is_some() { every } else { u64::MAX };
        loop {
            // The callback or another thread may have taken steps meanwhile.
            let left = last.saturating_sub(self.steps(py)?);
            let limit = StepLimit { most: stride.min(left), end };
            let Some(report) = self.advance(py, limit)? else { break };
            if let Some(callback) = &callback
                && asks_to_stop(&callback.call1((report,))?)
            {
                break;
            }
            py.check_signals()?;
        }
        self.summary(py)
    }

    /// Adds a force to those of the scene: a function that is called once per step with the bodies (`Bodies`) and
    /// returns forces (N, 3) in space axes, or a tuple of forces and torques about the centres, both (N, 3).
    ///
    /// With midpoint stepping it is also called in the step's middle, and again for each piece of a repeated step. It
    /// must depend only on its argument, or a run cannot be repeated; a saved state and the scene do not contain it. On
    /// a GPU it is called on the host, with a state that is read back in each step. Its exception ends the step and is
    /// raised by `step` or `run`, with the state before that step. It cannot use this simulation.
    fn add_force(&self, py: Python<'_>, force: Bound<'_, PyAny>) -> PyResult<()> {
        let group_names = self.session(py)?.simulation().scene().group_names();
        let made = PyForce::new(force.clone(), self.force_calls.clone(), group_names)?;
        self.session(py)?.add_force(Box::new(made));
        self.given(py)?.forces.push(force.unbind());
        Ok(())
    }

    /// Sets values of bodies between two steps: arrays with one row per body, or for the bodies of `of` (indices, a
    /// slice or a mask) or `ids`; a single row stands for all of these. All is set, or after an exception nothing.
    ///
    /// `position` (N, 3); `orientation` (N, 4), [w, x, y, z], normalized; `velocity` and `angular_velocity` (N, 3),
    /// under the inertial law; `length` (N,), tip to tip, of spherocylinders and of ellipsoids that grow; `rate` (N,),
    /// relative growth per time, and `division_length` (N,), of cells that grow, in place of their species' (infinite:
    /// never divides); `group` (N,), by name or index (NO_GROUP, or None in a list: none); `columns`, a dict of names
    /// to arrays (N,) of your own, which daughters inherit and states hold. On a GPU the state is read back and
    /// written.
    ///
    /// Raises ValueError with the argument and the row, IndexError for bodies that there are not.
    #[pyo3(signature = (
        of=None, *, ids=None, position=None, orientation=None, velocity=None, angular_velocity=None, length=None,
        rate=None, division_length=None, group=None, columns=None
    ))]
    #[allow(clippy::too_many_arguments)]
    fn set<'py>(
        &self,
        py: Python<'py>,
        of: Option<&Bound<'py, PyAny>>,
        ids: Option<&Bound<'py, PyAny>>,
        position: Option<Bound<'py, PyAny>>,
        orientation: Option<Bound<'py, PyAny>>,
        velocity: Option<Bound<'py, PyAny>>,
        angular_velocity: Option<Bound<'py, PyAny>>,
        length: Option<Bound<'py, PyAny>>,
        rate: Option<Bound<'py, PyAny>>,
        division_length: Option<Bound<'py, PyAny>>,
        group: Option<Bound<'py, PyAny>>,
        columns: Option<Bound<'py, PyAny>>,
    ) -> PyResult<()> {
        let (scene, bodies) = {
            let session = self.session(py)?;
            (session.simulation().scene().clone(), session.simulation().bodies())
        };
        let (which, count) = which(of, ids, bodies)?;
        let values = [
            ("group", group),
            ("position", position),
            ("orientation", orientation),
            ("velocity", velocity),
            ("angular_velocity", angular_velocity),
            ("length", length),
            ("rate", rate),
            ("division_length", division_length),
            ("columns", columns),
        ];
        self.change(py, &setting(&which, count, &values, &scene)?)?;
        Ok(())
    }

    /// Adds bodies, dicts as in a scene's `bodies`, after all others; returns their ids. They are born now, in groups
    /// that bodies of the scene start in. Raises SceneError with the key of the fault.
    fn add<'py>(&self, py: Python<'py>, bodies: &Bound<'py, PyAny>) -> Column<'py, i64> {
        let scene = self.session(py)?.simulation().scene().clone();
        let change = Change::new().add_bodies(bodies_of(bodies, &scene)?);
        Ok(column(py, self.change(py, &change)?.into_iter().map(bodies::id).collect()))
    }

    /// Removes the bodies of `of` (indices, a slice or a mask), or those with these `ids`.
    #[pyo3(signature = (of=None, *, ids=None))]
    fn remove(&self, py: Python<'_>, of: Option<&Bound<'_, PyAny>>, ids: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        if of.is_none() && ids.is_none() {
            return Err(PyTypeError::new_err("remove: name bodies by `of` or `ids`; of=slice(None) stands for all"));
        }
        let bodies = self.session(py)?.simulation().bodies();
        let (which, _) = which(of, ids, bodies)?;
        self.change(py, &Change::new().remove_bodies(which))?;
        Ok(())
    }

    /// Gives dotted keys of the scene other values from the present state on: forces, growth, walls' motion, the step.
    /// The change becomes one of the scene's `changes`, so that `scene` is a run that repeats it, to the same bits.
    /// Raises SceneError, and changes nothing, for what a scene may not change.
    #[pyo3(name = "change")]
    fn change_keys(&self, py: Python<'_>, keys: &Bound<'_, PyDict>) -> PyResult<()> {
        let text = dumps(keys, "keys")?;
        let set = serde_json::from_str(&text).map_err(|no| PyValueError::new_err(format!("keys: {no}")))?;
        let changed = self.compute(py, |session| session.change_keys(set))?;
        changed.map_err(|no| match no {
            Error::Scene(no) => scene_fault(py, &no, false),
            Error::Fault(no) => fault(no),
            no => SimulationError::new_err(no.to_string()),
        })
    }

    /// An object that decides how cells grow and divide, or None. It has `update(cells)`, called before each step,
    /// `divide(mother, daughters)`, called for each cell that divides, or both; see `relcp.Cells` and `relcp.Cell`.
    ///
    /// The methods must depend on their arguments alone, and keep what they remember in columns, or a run cannot be
    /// repeated. Exceptions, and values that are not allowed (ValueError, with the cell), end the step and are raised
    /// by `step` or `run`, with the state before that step.
    #[getter]
    fn rules(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        Ok(self.given(py)?.rules.as_ref().map(|rules| rules.clone_ref(py)))
    }

    #[setter]
    fn set_rules(&self, py: Python<'_>, rules: Option<Bound<'_, PyAny>>) -> PyResult<()> {
        let scene = self.session(py)?.simulation().scene().clone();
        let made = rules.as_ref().map(|rules| PyRules::new(rules, self.force_calls.clone(), scene)).transpose()?;
        self.session(py)?.set_rules(made.map(|made| Box::new(made) as Box<dyn Rules>));
        self.given(py)?.rules = rules.map(Bound::unbind);
        Ok(())
    }

    /// A measure of the present state by its name, as `relcp measure` has it: a dict of values by column (None where
    /// undefined), `remark` (why a part is missing, or None), and for a measure with a profile `profile`, a dict of
    /// arrays.
    fn measure<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
        let measure = measure::named(name)?;
        let (scene, state) = self.present(py)?;
        let found = self.compute(py, |session| session.compute(|_| measure::found(&scene, &state, measure)))?;
        measure::dict(py, measure, found)
    }

    /// A picture of the present state as `relcp render` draws it: (height, width, 4) uint8, red, green, blue, opacity.
    ///
    /// `height` is by default nine sixteenths of `width`. `view` is "top", "front", "right" or "oblique"; by default
    /// "top" for a planar scene. `colour` is the quantity that colours show, `range` the two ends of its scale,
    /// `background` "white", "dark" or "transparent"; `words` writes time, numbers and scales into it.
    #[pyo3(signature = (width=960, height=None, *, view=None, colour="orientation", range=None, background="white", words=true))]
    #[allow(clippy::too_many_arguments)]
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: u32,
        height: Option<u32>,
        view: Option<&str>,
        colour: &str,
        range: Option<[f64; 2]>,
        background: &str,
        words: bool,
    ) -> PyResult<Picture<'py>> {
        let frames = Look { width, height, view, colour, range, background, words }.frames()?;
        let (scene, state) = self.present(py)?;
        let drawn = self.compute(py, |session| session.compute(|_| still(&scene, state, &frames)))?;
        picture::array(py, drawn.map_err(|no| rendered(py, no))?)
    }

    /// Writes a picture as `render` makes it into a file: `.png`, or vectors of a planar scene seen from the top,
    /// `.svg` and `.pdf`. Returns its path.
    #[pyo3(signature = (path, width=960, height=None, *, view=None, colour="orientation", range=None, background="white", words=true))]
    #[allow(clippy::too_many_arguments)]
    fn save_picture(
        &self,
        py: Python<'_>,
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
        let (scene, state) = self.present(py)?;
        let drawn = self.compute(py, |session| session.compute(|_| still_file(&scene, state, &frames)))?;
        picture::placed(py, path, drawn)
    }

    /// The page of `relcp view` of the present state, as an object that notebooks show; `save` writes it. `width` and
    /// `height` are in pixels, or text such as "100%".
    #[pyo3(signature = (width=None, height=None, *, colour="orientation"))]
    fn show<'py>(
        &self,
        py: Python<'py>,
        width: Option<Bound<'py, PyAny>>,
        height: Option<Bound<'py, PyAny>>,
        colour: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let pages = Pages { colour: Some(picture::quantity(colour)?), ..Pages::default() };
        let (scene, state) = self.present(py)?;
        let made = self.compute(py, |session| session.compute(|_| page_of_state(&scene, state, &pages)))?;
        let (page, viewed) = made.map_err(|no| rendered(py, no))?;
        picture::page(py, page, &viewed.notes, width, height)
    }

    /// (N,): relative growth rates without pressure; zero for a body that does not grow.
    #[getter]
    fn rates<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Ok(column(py, self.cells(py)?.rate))
    }

    /// (N,): lengths at which cells divide; infinite by a timer, and for a body that does not grow.
    #[getter]
    fn division_lengths<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Ok(column(py, self.cells(py)?.division_length))
    }

    /// The columns of your own, (N,) each, by name.
    #[getter]
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        named(py, self.cells(py)?.columns)
    }

    /// The name of each body's shape, a list.
    #[getter]
    fn shape_labels(&self, py: Python<'_>) -> PyResult<Vec<&'static str>> {
        self.bodies(py, bodies::shape_labels)
    }

    /// The name of each body's group, a list; None for a body without one.
    #[getter]
    fn group_labels(&self, py: Python<'_>) -> PyResult<Vec<Option<String>>> {
        let names = self.session(py)?.simulation().scene().group_names();
        self.bodies(py, |bodies| bodies::group_labels(bodies, &names))
    }

    /// The number of bodies after the last accepted step.
    #[getter]
    fn n_bodies(&self, py: Python<'_>) -> PyResult<usize> {
        self.count(py)
    }

    /// The number of steps accepted so far.
    #[getter]
    fn n_steps(&self, py: Python<'_>) -> PyResult<u64> {
        self.steps(py)
    }

    /// Pickled as the scene, a checkpoint, and the forces and rules that were given, which must be picklable too. The
    /// copy goes on to the same bits on the CPU.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (scene, state, threads) = {
            let session = self.session(py)?;
            let state = session.encoded().map_err(fault)?;
            (session.simulation().whole_scene().clone(), state, session.own_threads())
        };
        let state = state.map_err(|no| SimulationError::new_err(no.to_string()))?;
        let (backend, precision) = match self.on_device {
            true => ("gpu", Some(self.precision(py)?)),
            false => ("cpu", None),
        };
        let given = self.given(py)?;
        let forces: Vec<Py<PyAny>> = given.forces.iter().map(|force| force.clone_ref(py)).collect();
        let rules = given.rules.as_ref().map(|rules| rules.clone_ref(py));
        let arguments = (PyScene(scene), PyBytes::new(py, &state), backend, threads, precision, forces, rules);
        let restore = py.import("relcp")?.getattr("Simulation")?.getattr("_restore")?;
        Ok((restore, arguments.into_pyobject(py)?))
    }

    /// Restores a simulation from its pickle.
    #[staticmethod]
    #[allow(clippy::too_many_arguments)]
    fn _restore(
        py: Python<'_>,
        scene: &PyScene,
        state: &[u8],
        backend: &str,
        threads: Option<usize>,
        precision: Option<&str>,
        forces: Vec<Bound<'_, PyAny>>,
        rules: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let wanted = Wanted { backend, threads, precision, adapter: None };
        let threads = Threads::new(wanted.pool()?);
        let (header, state) = py.detach(|| decode(state)).map_err(|no| RecordError::new_err(no.to_string()))?;
        let compute: Compute = wanted.settle(py, &scene.0)?;
        let (scene, totals) = (scene.0.clone(), header.totals.unwrap_or_default());
        let session = py.detach(|| Session::resume(&compute, scene, state, totals, threads)).map_err(fault)?;
        let simulation = PySimulation::hold(session, &compute);
        forces.into_iter().try_for_each(|force| simulation.add_force(py, force))?;
        simulation.set_rules(py, rules)?;
        Ok(simulation)
    }

    /// The scene, with all changes in its `changes`.
    #[getter]
    fn scene(&self, py: Python<'_>) -> PyResult<PyScene> {
        Ok(PyScene(self.session(py)?.simulation().whole_scene().clone()))
    }

    /// Steps accepted so far.
    #[getter]
    fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(self.session(py)?.simulation().steps())
    }

    /// Bodies after the last accepted step.
    #[getter(bodies)]
    fn count(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.session(py)?.simulation().bodies())
    }

    /// Time after the last accepted step.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.session(py)?.simulation().time())
    }

    /// Whether the scene's end is reached.
    #[getter]
    fn done(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.session(py)?.simulation().done())
    }

    /// The backend, "cpu" or "gpu".
    #[getter]
    fn backend(&self, py: Python<'_>) -> PyResult<&'static str> {
        Ok(self.session(py)?.simulation().machine())
    }

    /// "f32" or "f64".
    #[getter]
    fn precision(&self, py: Python<'_>) -> PyResult<&'static str> {
        Ok(self.session(py)?.simulation().precision().name())
    }

    /// The name of the GPU that computes; None on the CPU.
    #[getter]
    fn adapter(&self, py: Python<'_>) -> PyResult<Option<String>> {
        Ok(self.session(py)?.simulation().device().map(|gpu| gpu.name().to_owned()))
    }

    /// (N, 3): centres.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, self.bodies(py, |bodies| vectors(&bodies.position))?)
    }

    /// (N, 4): unit quaternions [w, x, y, z], body axes to space, as in scenes and states.
    #[getter]
    fn orientations<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, self.bodies(py, bodies::orientations)?)
    }

    /// (N, 3): unit vectors, each body's own z in space: the axis of rods and rings.
    #[getter]
    fn axes<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, self.bodies(py, bodies::axes)?)
    }

    /// (N, 3): velocities, length / time; under the overdamped law those of the last step.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, self.bodies(py, |bodies| vectors(&bodies.velocity))?)
    }

    /// (N, 3): angular velocities in space axes, 1 / time; as `velocities`.
    #[getter]
    fn angular_velocities<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, self.bodies(py, |bodies| vectors(&bodies.angular_velocity))?)
    }

    /// (N,): length of the major axis, tip to tip for a rod.
    #[getter]
    fn lengths<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Ok(column(py, self.bodies(py, bodies::lengths)?))
    }

    /// (N,) uint32: 0 sphere, 1 spherocylinder, 2 ellipsoid, 3 torus, 5 superellipsoid.
    #[getter]
    fn shapes<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        Ok(column(py, self.bodies(py, bodies::shapes)?))
    }

    /// (N, 3): sizes in the order of a scene, padded with zeros: radius; diameter, length; three radii; major and minor
    /// radius.
    #[getter]
    fn sizes<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, self.bodies(py, bodies::sizes)?)
    }

    /// (N, 2): exponents `[n1, n2]` of superellipsoids, zero of other shapes.
    #[getter]
    fn exponents<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, self.bodies(py, bodies::exponents)?)
    }

    /// (N,) int32: index into the scene's `group_names`; `relcp.NO_GROUP`, -1, for a body without a group.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> Column<'py, i32> {
        Ok(column(py, self.bodies(py, bodies::groups)?))
    }

    /// (N,) int64: identities, unique over a run; a division ends one and begins two.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Column<'py, i64> {
        Ok(column(py, self.bodies(py, bodies::ids)?))
    }

    /// (N,) int64: the id that divided into this one; `relcp.NO_PARENT`, -1, for a founder.
    #[getter]
    fn parents<'py>(&self, py: Python<'py>) -> Column<'py, i64> {
        Ok(column(py, self.bodies(py, bodies::parents)?))
    }

    /// (N,): times of birth.
    #[getter]
    fn births<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Ok(column(py, self.bodies(py, bodies::births)?))
    }

    /// (N,) uint32: divisions since the founder.
    #[getter]
    fn generations<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        Ok(column(py, self.bodies(py, bodies::generations)?))
    }

    /// A hash of every bit of the state, as in the program's `summary.json`.
    #[getter]
    fn state_hash(&self, py: Python<'_>) -> PyResult<String> {
        self.copy(py, state_hash)
    }

    /// All pairs of bodies whose separation is at most `cutoff`, a length, computed afresh in f64 on the CPU from the
    /// bodies alone.
    #[pyo3(signature = (cutoff=0.0))]
    fn contacts(&self, py: Python<'_>, cutoff: f64) -> PyResult<Contacts> {
        let cutoff = checked(cutoff)?;
        let found = self.compute(py, |session| {
            session.compute(|simulation| {
                simulation.state().map(|state| Pairs::of(&state.bodies, Some(&state.warm), cutoff))
            })
        })?;
        Contacts::new(py, found.map_err(fault)?)
    }

    /// All bodies and surfaces of walls whose separation is at most `cutoff`, a length, computed afresh, with the
    /// forces of the last step on the walls.
    #[pyo3(signature = (cutoff=0.0))]
    fn wall_contacts(&self, py: Python<'_>, cutoff: f64) -> PyResult<WallContacts> {
        let cutoff = checked(cutoff)?;
        let found = self.compute(py, |session| {
            session.compute(|simulation| {
                let (walls, smooth) = (simulation.walls(), is_smooth(simulation.scene()));
                simulation.state().map(|state| AtWalls::of(&walls, &state.bodies, Some(&state.warm), smooth, cutoff))
            })
        })?;
        WallContacts::new(py, found.map_err(fault)?)
    }

    /// The bonds and joints that hold, with the forces of the last step.
    #[getter]
    fn bonds(&self, py: Python<'_>) -> PyResult<Bonds> {
        let held = self.compute(py, |session| {
            session.compute(|simulation| simulation.state().map(|state| Held::of(&state.bodies)))
        })?;
        Bonds::new(py, held.map_err(fault)?)
    }

    /// The concentrations of the scene's fields by name, each indexed by x, y and z.
    #[getter]
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = self.compute(py, |session| {
            session.compute(|simulation| simulation.state().map(|state| state.fields.clone()))
        })?;
        arrays::fields(py, &found.map_err(fault)?)
    }

    /// The summary of the run so far, with the keys of the program's `summary.json`; `final_max_overlap` is computed
    /// afresh from the state.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let summary = self.compute(py, |session| session.summary())?.map_err(fault)?;
        json(py, &summary)
    }

    /// The state as a scene that continues from it, like the program's `final.json`.
    fn final_scene(&self, py: Python<'_>) -> PyResult<PyScene> {
        let scene = self.compute(py, |session| session.simulation().final_scene())?;
        scene.map(PyScene).map_err(fault)
    }

    /// Writes the state as the program's checkpoint, atomically: numpy reads it as `.npz`, and `resume` continues from
    /// it. Raises RecordError.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let saved = self.compute(py, |session| session.save(&path))?.map_err(fault)?;
        saved.map_err(|no| recorded(&no))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let session = self.session(py)?;
        let simulation = session.simulation();
        let (name, bodies) = (&simulation.scene().name, simulation.bodies());
        let (steps, time) = (simulation.steps(), simulation.time());
        Ok(format!(
            "Simulation({name:?}, bodies={bodies}, steps={steps}, time={time}, backend={:?})",
            simulation.machine()
        ))
    }
}

fn checked(cutoff: f64) -> PyResult<f64> {
    if cutoff.is_finite() { Ok(cutoff) } else { Err(PyValueError::new_err("cutoff: expected a finite length")) }
}
