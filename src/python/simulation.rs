//! A simulation: steps with the interpreter's lock released, arrays copied out.

use super::arrays::{NO_PARENT, column, json, table, vectors};
use super::compute::{Wanted, warn};
use super::contacts::{AtWalls, Contacts, Pairs, WallContacts};
use super::driver::silently;
use super::error::{RecordError, SimulationError, fault, recorded, scene_fault};
use super::report::StepReport;
use super::scene::PyScene;
use super::session::{Session, Threads};
use crate::bodies::Bodies;
use crate::error::Error;
use crate::record::{read_state, scene_hash, state_hash};
use crate::simulation::Compute;
use crate::step::State;
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

/// Wall time between looks at Python's signals. To take back the interpreter's lock may cost its switch interval (5 ms)
/// where other threads run, so it is not done after every step; a person does not notice a twentieth of a second.
const SIGNALS_EVERY: Duration = Duration::from_millis(50);

type Column<'py, T> = PyResult<Bound<'py, PyArray1<T>>>;
type Table<'py, T> = PyResult<Bound<'py, PyArray2<T>>>;

/// A scene's bodies and what steps them: `Simulation(scene, backend="cpu", threads=None, precision=None,
/// adapter=None)`.
///
/// `backend` is "cpu", "gpu" (a software adapter will do) or "auto" (the CPU, until a hardware GPU is measured to be
/// faster); `threads` is a number of threads of its own, None those of the process, one a core; `precision` is "f32" or "f64" on
/// a GPU, f32 without it; `adapter` is a part of a GPU's name. The same scene gives the same bits for any number of
/// threads, and those of the program.
///
/// Every array is a copy of the state after the last accepted step, a row a body; N is the number of bodies. Lengths
/// and times are in the scene's units.
#[pyclass(frozen, name = "Simulation", module = "relcp")]
pub(super) struct PySimulation {
    session: Mutex<Session>,
    /// Its state may have to be read from a device.
    on_device: bool,
    /// A step may open a device.
    opens: bool,
}

impl PySimulation {
    fn hold(session: Session, compute: &Compute) -> Self {
        let (on_device, opens) = (!matches!(compute, Compute::Cpu), matches!(compute, Compute::Auto(_)));
        PySimulation { session: Mutex::new(session), on_device, opens }
    }

    /// Waits for the session, with the interpreter's lock released where another thread has it.
    fn session(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Session>> {
        let session = self.session.lock_py_attached(py);
        let session = session.map_err(|_| SimulationError::new_err("an internal fault ended this simulation"))?;
        if session.live() {
            return Ok(session);
        }
        Err(SimulationError::new_err(
            "this simulation's threads are in the process that this one was forked from; make it here, or save and resume it",
        ))
    }

    /// Computes something long, with the interpreter's lock released.
    fn compute<T: Send>(&self, py: Python<'_>, of: impl FnOnce(&mut Session) -> T + Send) -> PyResult<T> {
        drop(self.session(py)?);
        let computed = py.detach(|| self.session.lock().ok().map(|mut session| of(&mut session)));
        computed.ok_or_else(|| SimulationError::new_err("an internal fault ended this simulation"))
    }

    /// Copies something out of the state.
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

    /// Takes `most` steps, or those to the end.
    fn advance(&self, py: Python<'_>, most: u64, to_end: bool) -> PyResult<Option<StepReport>> {
        let (mut left, mut last) = (most, None);
        loop {
            let advance = || self.compute(py, |session| session.advance(left, to_end, SIGNALS_EVERY));
            let (batch, ended) = if self.opens { silently(py, advance)?? } else { advance()? };
            batch.messages.iter().try_for_each(|message| warn(py, message))?;
            ended.map_err(fault)?;
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
        let scene = scene.0.clone();
        let session = py.detach(|| Session::start(&compute, scene, threads)).map_err(|no| no_start(py, no))?;
        Ok(PySimulation::hold(session, &compute))
    }

    /// Goes on from a state that `save` or the program wrote for the same scene: from a checkpoint to the same bits, on
    /// the CPU, as if the run had never stopped. Raises RecordError where the file cannot be used, or is of another
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
            return Err(RecordError::new_err(format!("{}: the state is of another scene", path.display())));
        }
        let compute: Compute = wanted.settle(py, &scene.0)?;
        let (scene, totals) = (scene.0.clone(), header.totals.unwrap_or_default());
        let session = py.detach(|| Session::resume(&compute, scene, state, totals, threads)).map_err(fault)?;
        Ok(PySimulation::hold(session, &compute))
    }

    /// Takes `n` steps, also past the scene's end, and returns the last one's report. Ctrl-C ends it between two steps,
    /// with the state of the last one.
    ///
    /// Raises SimulationError or DeviceError where a step cannot be taken.
    #[pyo3(signature = (n=1))]
    fn step(&self, py: Python<'_>, n: u64) -> PyResult<StepReport> {
        let taken = self.advance(py, n, false)?;
        taken.ok_or_else(|| PyValueError::new_err("n: expected at least one step"))
    }

    /// Steps to the scene's end, or what its `growth.stop` ends it at, and returns the summary. Ctrl-C ends it between
    /// two steps; call it again to go on.
    ///
    /// Raises SimulationError or DeviceError where a step cannot be taken.
    fn run<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.advance(py, u64::MAX, true)?;
        self.summary(py)
    }

    /// The scene.
    #[getter]
    fn scene(&self, py: Python<'_>) -> PyResult<PyScene> {
        Ok(PyScene(self.session(py)?.simulation().scene().clone()))
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

    /// What takes the next step, "cpu" or "gpu"; with backend="auto" it may change.
    #[getter]
    fn backend(&self, py: Python<'_>) -> PyResult<&'static str> {
        Ok(self.session(py)?.simulation().machine().name())
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
        table(py, self.bodies(py, |bodies| bodies.orientation.iter().map(|q| [q.w, q.x, q.y, q.z]).collect())?)
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
        Ok(column(py, self.bodies(py, |bodies| bodies.shape.iter().map(|shape| shape.major_axis()).collect())?))
    }

    /// (N,) uint32: 0 sphere, 1 spherocylinder, 2 ellipsoid, 3 torus.
    #[getter]
    fn shapes<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        Ok(column(py, self.bodies(py, |bodies| bodies.shape.iter().map(|shape| shape.code().0).collect())?))
    }

    /// (N, 3): sizes in a scene's order, what a shape has not is zero: radius; diameter, length; three radii; major and
    /// minor radius.
    #[getter]
    fn sizes<'py>(&self, py: Python<'py>) -> Table<'py, f64> {
        table(py, self.bodies(py, |bodies| bodies.shape.iter().map(|shape| shape.code().1).collect())?)
    }

    /// (N,) uint32: index into the scene's `group_names`; `relcp.NO_GROUP` where a body has none.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        Ok(column(py, self.bodies(py, |bodies| bodies.group.clone())?))
    }

    /// (N,) uint64: identities, unique over a run; a division ends one and begins two.
    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> Column<'py, u64> {
        Ok(column(py, self.bodies(py, |bodies| bodies.lineage.iter().map(|l| l.id).collect())?))
    }

    /// (N,) uint64: the id that divided into this one; `relcp.NO_PARENT` for a founder.
    #[getter]
    fn parents<'py>(&self, py: Python<'py>) -> Column<'py, u64> {
        let parents = |bodies: &Bodies| bodies.lineage.iter().map(|l| l.parent.unwrap_or(NO_PARENT)).collect();
        Ok(column(py, self.bodies(py, parents)?))
    }

    /// (N,): times of birth.
    #[getter]
    fn births<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Ok(column(py, self.bodies(py, |bodies| bodies.lineage.iter().map(|l| l.birth).collect())?))
    }

    /// (N,) uint32: divisions since the founder.
    #[getter]
    fn generations<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        Ok(column(py, self.bodies(py, |bodies| bodies.lineage.iter().map(|l| l.generation).collect())?))
    }

    /// A hash of every bit of the state; the program's `summary.json` has the same for the same state.
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
            session.compute(|simulation| simulation.state().map(|state| Pairs::of(state, cutoff)))
        })?;
        Contacts::new(py, found.map_err(fault)?)
    }

    /// All bodies and surfaces of walls whose separation is at most `cutoff`, a length, computed afresh.
    #[pyo3(signature = (cutoff=0.0))]
    fn wall_contacts(&self, py: Python<'_>, cutoff: f64) -> PyResult<WallContacts> {
        let cutoff = checked(cutoff)?;
        let found = self.compute(py, |session| {
            let walls = session.simulation().walls();
            session
                .compute(move |simulation| simulation.state().map(|state| AtWalls::of(&walls, &state.bodies, cutoff)))
        })?;
        WallContacts::new(py, found.map_err(fault)?)
    }

    /// What the run did so far, with the keys of the program's `summary.json`; `final_max_overlap` is computed afresh
    /// from the state.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let summary = self.compute(py, |session| session.summary())?.map_err(fault)?;
        json(py, &summary)
    }

    /// The state as a scene that goes on from it, as the program's `final.json`.
    fn final_scene(&self, py: Python<'_>) -> PyResult<PyScene> {
        let scene = self.compute(py, |session| {
            let simulation = session.simulation();
            simulation.state().map(|state| simulation.scene().final_scene(&state.bodies, simulation.time()))
        })?;
        scene.map(PyScene).map_err(fault)
    }

    /// Writes the state as the program's checkpoint, whole or not at all: numpy reads it as `.npz`, `resume` goes on
    /// from it. Raises RecordError.
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
            simulation.machine().name()
        ))
    }
}

fn checked(cutoff: f64) -> PyResult<f64> {
    if cutoff.is_finite() { Ok(cutoff) } else { Err(PyValueError::new_err("cutoff: expected a finite length")) }
}
