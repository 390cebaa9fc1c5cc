//! Many simulations that run together: on a device as one ensemble, on the CPU over its cores.

use super::arrays::json;
use super::compute::Wanted;
use super::limit::StepLimit;
use super::scene::PyScene;
use super::session::Threads;
use super::simulation::PySimulation;
use crate::gpu::Ensemble;
use crate::scene::Scene;
use crate::simulation::Compute;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Wall time between checks of Python's signals.
const SIGNALS_EVERY: Duration = Duration::from_millis(50);

/// Many scenes that run together: `Ensemble(scenes, backend="cpu", threads=None, precision=None, adapter=None)`.
///
/// On a GPU all members are computed as one: a kernel is launched once for all members that need it. On the CPU they
/// share `threads` threads, by default one per core. Each member is a `Simulation`, by its index, with the bits of its
/// scene alone on this device.
#[pyclass(frozen, name = "Ensemble", module = "relcp")]
pub(super) struct PyEnsemble {
    members: Vec<Py<PySimulation>>,
    /// The number of concurrent members.
    at_once: usize,
}

/// The members that are left, and the results of the others.
struct Running {
    next: AtomicUsize,
    stops: AtomicBool,
    ended: Mutex<usize>,
    changed: Condvar,
}

impl PyEnsemble {
    /// Runs `each` for all members, several at once, with the interpreter's lock released. Ctrl-C signals `each` to
    /// stop.
    fn run_all<T: Send>(
        &self,
        py: Python<'_>,
        each: impl Fn(&PySimulation, usize, &AtomicBool) -> T + Sync,
    ) -> PyResult<Vec<T>> {
        let members: Vec<&PySimulation> = self.members.iter().map(Py::get).collect();
        let count = members.len();
        let results: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
        let running = Running {
            next: AtomicUsize::new(0),
            stops: AtomicBool::new(false),
            ended: Mutex::new(0),
            changed: Condvar::new(),
        };
        let raised = py.detach(|| {
            std::thread::scope(|scope| {
                for _ in 0..self.at_once.min(count) {
                    scope.spawn(|| {
                        while let Some((nth, member)) = running.take(&members) {
                            let result = each(member, nth, &running.stops);
                            *results[nth].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
                            running.end();
                        }
                    });
                }
                running.watch(count)
            })
        });
        raised?;
        let result = |of: Mutex<Option<T>>| of.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(results.into_iter().filter_map(result).collect())
    }
}

impl Running {
    fn take<'a>(&self, members: &[&'a PySimulation]) -> Option<(usize, &'a PySimulation)> {
        let nth = self.next.fetch_add(1, Ordering::Relaxed);
        members.get(nth).map(|member| (nth, *member))
    }

    fn end(&self) {
        *self.ended.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.changed.notify_all();
    }

    /// Waits for all of them, and checks Python's signals meanwhile.
    fn watch(&self, count: usize) -> PyResult<()> {
        let mut raised = Ok(());
        let mut ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        while *ended < count {
            ended = self.changed.wait_timeout(ended, SIGNALS_EVERY).unwrap_or_else(PoisonError::into_inner).0;
            if raised.is_ok() {
                drop(ended);
                raised = Python::attach(|py| py.check_signals());
                self.stops.store(raised.is_err(), Ordering::Relaxed);
                ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
            }
        }
        raised
    }
}

#[pymethods]
impl PyEnsemble {
    #[new]
    #[pyo3(signature = (scenes, backend="cpu", threads=None, precision=None, adapter=None))]
    fn new(
        py: Python<'_>,
        scenes: Vec<Bound<'_, PyScene>>,
        backend: &str,
        threads: Option<usize>,
        precision: Option<&str>,
        adapter: Option<&str>,
    ) -> PyResult<Self> {
        let Some(first) = scenes.first() else { return Err(PyValueError::new_err("scenes: expected at least one")) };
        if backend == "auto" {
            return Err(PyValueError::new_err("backend: an ensemble is computed by 'cpu' or 'gpu'"));
        }
        let wanted = Wanted { backend, threads, precision, adapter };
        wanted.pool()?;
        let compute = wanted.settle(py, &first.get().0)?;
        let device = match &compute {
            Compute::Gpu { gpu, .. } => Some(Ensemble::new(gpu.clone()).map_err(|no| super::error::device(&no))?),
            _ => None,
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let at_once = if device.is_some() { scenes.len() } else { threads.unwrap_or(cores) };
        let of_member = |scene: &Scene| -> PyResult<Compute> {
            let (Some(ensemble), Compute::Gpu { precision, .. }) = (&device, &compute) else {
                return Ok(Compute::Cpu);
            };
            Compute::check(scene).map_err(|no| super::error::device(&no))?;
            Ok(Compute::Gpu { gpu: ensemble.member(), precision: *precision })
        };
        let mut members = Vec::new();
        for (nth, scene) in scenes.iter().enumerate() {
            let scene = &scene.get().0;
            let own = Wanted { threads: Some(1), ..wanted }.pool()?;
            let started =
                of_member(scene).and_then(|compute| PySimulation::start(py, scene, &compute, Threads::new(own)));
            let member = started.map_err(|no| {
                no.value(py)
                    .call_method1("add_note", (format!("member {nth} of the ensemble"),))
                    .map_or_else(|e| e, |_| no)
            })?;
            member.rest();
            members.push(Py::new(py, member)?);
        }
        Ok(PyEnsemble { members, at_once })
    }

    fn __len__(&self) -> usize {
        self.members.len()
    }

    fn __getitem__(&self, py: Python<'_>, index: isize) -> PyResult<Py<PySimulation>> {
        let place = if index < 0 { index + self.members.len() as isize } else { index };
        let member = usize::try_from(place).ok().and_then(|place| self.members.get(place));
        member.map(|member| member.clone_ref(py)).ok_or_else(|| PyIndexError::new_err(format!("no member {index}")))
    }

    /// Runs every member to its scene's end, or to the first step whose time is at least `until`, as `Simulation.run`
    /// does, with the interpreter's lock released. Returns a list with None for each member that reached it, and the
    /// SimulationError or DeviceError of each member that failed; the others continue. Ctrl-C ends all of them between
    /// two steps; call it again to continue.
    #[pyo3(signature = (*, until=None))]
    fn run(&self, py: Python<'_>, until: Option<f64>) -> PyResult<Vec<Option<PyErr>>> {
        let mut limits: Vec<StepLimit> = Vec::new();
        for member in &self.members {
            limits.push(member.get().limit(py, until)?);
        }
        let ran = self.run_all(py, |member, nth, stops| member.run_quietly(limits[nth], SIGNALS_EVERY, stops))?;
        Ok(ran.into_iter().zip(&self.members).map(|(ran, member)| ran.err().map(|no| member.get().fault(no))).collect())
    }

    /// The summaries of all members, as `Simulation.summary`.
    fn summaries<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let made = self.run_all(py, |member, _, _| member.summed())?;
        made.into_iter().map(|summary| json(py, &summary.map_err(super::error::fault)?)).collect()
    }
}
