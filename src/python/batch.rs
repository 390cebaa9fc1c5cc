//! Many runs of one scene, as `relcp batch` makes them. `relcp.batch` is made of it.

use super::arrays::json;
use super::compute::Wanted;
use super::error::{SimulationError, device, recorded, scene_fault};
use super::scene::PyScene;
use crate::batch::{BatchError, Ended, Member, MemberError, Options, Plan, Table, Watch, run};
use crate::gpu::{Ensemble, Precision};
use crate::scene::Scene;
use crate::simulation::Compute;
use crate::step::StepReport;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::error::Error as _;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Wall time between checks of Python's signals, and between two calls of the progress.
const SIGNALS_EVERY: Duration = Duration::from_millis(50);

/// Members that run at a time on a device by default, as in the program.
const MEMBERS_AT_ONCE: usize = 64;

/// The default folder of runs, as the program's.
const RUNS: &str = "runs";

/// A sweep whose scenes are read and checked.
#[pyclass(frozen, name = "Planned", module = "relcp._relcp")]
pub(super) struct Planned(Plan);

/// What members tell while they run.
#[derive(Default)]
struct Progress {
    stops: AtomicBool,
    all: AtomicU64,
    taken: AtomicU64,
}

impl Watch for Progress {
    fn stop(&self) -> bool {
        self.stops.load(Ordering::Relaxed)
    }

    fn planned(&self, _members: usize, steps: u64) {
        self.all.store(steps, Ordering::Relaxed);
    }

    fn stepped(&self, _member: &Member, _report: &StepReport) {
        self.taken.fetch_add(1, Ordering::Relaxed);
    }
}

/// The devices of members.
struct Devices(Option<(Ensemble, Precision)>);

impl Devices {
    fn of(compute: &Compute) -> PyResult<Self> {
        Ok(Devices(match compute {
            Compute::Gpu { gpu, precision } => {
                Some((Ensemble::new(gpu.clone()).map_err(|no| device(&no))?, *precision))
            }
            _ => None,
        }))
    }

    fn of_member(&self, scene: &Scene) -> Result<Compute, MemberError> {
        let Some((ensemble, precision)) = &self.0 else { return Ok(Compute::Cpu) };
        Compute::check(scene).map_err(MemberError::Device)?;
        Ok(Compute::Gpu { gpu: ensemble.member(), precision: *precision })
    }
}

/// The exception of a batch that could not begin.
fn refused(py: Python<'_>, no: BatchError) -> PyErr {
    match no {
        BatchError::Scene(no) => scene_fault(py, &no, true),
        BatchError::Record(no) => recorded(&no),
        no => SimulationError::new_err(no.to_string()),
    }
}

/// An error with its causes.
fn chain(error: &MemberError) -> String {
    let mut said = error.to_string();
    let mut cause = error.source();
    while let Some(own) = cause {
        if !said.contains(&own.to_string()) {
            said = format!("{said}: {own}");
        }
        cause = own.source();
    }
    said
}

/// Runs members on threads of their own, while this one checks signals and calls `progress`.
fn watched<T: Send>(
    py: Python<'_>,
    telling: &Progress,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let mut raised = Ok(());
    let done = py.detach(|| {
        std::thread::scope(|scope| {
            let working = scope.spawn(work);
            while !working.is_finished() {
                std::thread::park_timeout(SIGNALS_EVERY);
                if raised.is_ok() {
                    let (all, taken) = (telling.all.load(Ordering::Relaxed), telling.taken.load(Ordering::Relaxed));
                    raised = Python::attach(|py| {
                        py.check_signals()?;
                        progress.map_or(Ok(()), |progress| progress.call1(py, (taken, all)).map(drop))
                    });
                    telling.stops.store(raised.is_err(), Ordering::Relaxed);
                }
            }
            working.join()
        })
    });
    raised?;
    done.map_err(|_| SimulationError::new_err("an internal fault ended this batch"))
}

#[pymethods]
impl Planned {
    /// The plan of a sweep in JSON, of a given scene, or of the one that it names relative to the folder `base`.
    #[new]
    fn new(py: Python<'_>, text: &str, origin: &str, base: PathBuf, scene: Option<&PyScene>) -> PyResult<Self> {
        let plan = match scene {
            Some(scene) => Plan::of_scene(text, origin, &scene.0),
            None => Plan::parse(text, origin, &base),
        };
        plan.map(Planned).map_err(|no| refused(py, no))
    }

    fn __len__(&self) -> usize {
        self.0.members().len()
    }

    /// The default folder of its runs.
    #[getter]
    fn folder(&self) -> PathBuf {
        self.0.folder_in(Path::new(RUNS))
    }

    /// Runs the members that have not ended, in folders under `out`. `progress` is called with the steps taken and all
    /// steps. Returns the members that failed, with the reason.
    #[allow(clippy::too_many_arguments)]
    fn run(
        &self,
        py: Python<'_>,
        out: PathBuf,
        backend: &str,
        jobs: Option<usize>,
        threads: Option<usize>,
        precision: Option<&str>,
        adapter: Option<&str>,
        retry: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<(usize, String)>> {
        if backend == "auto" {
            return Err(PyValueError::new_err("backend: a batch is computed by 'cpu' or 'gpu'"));
        }
        if jobs == Some(0) {
            return Err(PyValueError::new_err("jobs: expected at least one"));
        }
        let wanted = Wanted { backend, threads, precision, adapter };
        wanted.pool()?;
        let plan = &self.0;
        let first = plan.scene(0).map_err(|no| scene_fault(py, &no, true))?;
        let devices = Devices::of(&wanted.settle(py, &first)?)?;
        let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, NonZeroUsize::get));
        let jobs = jobs.unwrap_or(if devices.0.is_some() { MEMBERS_AT_ONCE } else { threads });
        let options = Options { jobs, threads, retry };
        let telling = Progress::default();
        let ran = watched(py, &telling, progress.as_ref(), || {
            run(plan, &out, plan.members(), options, &|scene| devices.of_member(scene), &telling)
        })?;
        let ended = ran.map_err(|no| refused(py, no))?;
        let failed = plan.members().iter().zip(&ended).filter_map(|(member, ended)| match ended {
            Ended::Failed(no) => Some((member.index, chain(no))),
            _ => None,
        });
        Ok(failed.collect())
    }

    /// The table of the results so far, which is also written into the folder; `failed` says why members failed.
    fn table<'py>(&self, py: Python<'py>, out: PathBuf, failed: Vec<(usize, String)>) -> PyResult<Bound<'py, PyAny>> {
        let mut table = Table::of(&self.0, &out, self.0.members()).map_err(|no| refused(py, no))?;
        failed.into_iter().for_each(|(index, why)| table.failed(index, why));
        if out.is_dir() {
            table.write(&out).map_err(|no| refused(py, no))?;
        }
        json(py, &table)
    }
}
