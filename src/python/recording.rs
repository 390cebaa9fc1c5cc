//! A run that Python drives and that is recorded as by `relcp run`. `relcp.run` is made of it.

use super::arrays::json;
use super::compute::Wanted;
use super::error::{SimulationError, fault, recorded, scene_fault};
use super::force::{ForceCalls, PyForce};
use super::rules::PyRules;
use super::scene::PyScene;
use super::session::Threads;
use crate::error::Error;
use crate::record::{Folder, RecordError};
use crate::run::{Branch, Run, RunError};
use crate::scene::Scene;
use crate::simulation::{Compute, Simulation};
use crate::step::Fault;
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// The default folder of runs, as the program's.
const RUNS: &str = "runs";

/// Where a run begins.
struct Start<'a> {
    out: Option<&'a Path>,
    resume: bool,
    until: Option<f64>,
    from: Option<(PathBuf, Option<f64>)>,
}

/// A run in progress; none after its end.
#[pyclass(frozen, name = "Recording", module = "relcp._relcp")]
pub(super) struct Recording {
    run: Mutex<Option<Run>>,
    threads: Threads,
    calls: ForceCalls,
    folder: PathBuf,
    notes: Vec<String>,
}

impl Start<'_> {
    fn folder(&self, scene: &Scene) -> Result<Folder, RecordError> {
        match self.out {
            Some(path) => Folder::create(path),
            None => Folder::create_in(Path::new(RUNS), &scene.name),
        }
    }

    /// Begins, or goes on with, the run of a scene, as `relcp run` does.
    fn run(&self, scene: Scene, compute: &Compute) -> Result<Run, Error> {
        let begun = Instant::now();
        if let (true, Some(path)) = (self.resume, self.out) {
            let folder = Folder::open(path).map_err(RunError::from)?;
            return Ok(match self.until {
                Some(until) => Run::resume_until(scene, folder, until, compute)?,
                None => Run::resume(scene, folder, compute)?,
            });
        }
        if let Some((run, time)) = &self.from {
            let branch = Branch::open(run, *time).map_err(RunError::from)?;
            let (simulation, parent) = branch.simulate(scene, compute)?;
            let folder = self.folder(simulation.scene()).map_err(RunError::from)?;
            return Ok(Run::start_from(simulation, folder, parent, begun.elapsed())?);
        }
        let bodies = scene.build()?;
        let simulation = Simulation::builder(scene).bodies(bodies).on(compute).build()?;
        let folder = self.folder(simulation.scene()).map_err(RunError::from)?;
        Ok(Run::start(simulation, folder, begun.elapsed())?)
    }
}

impl Recording {
    fn held(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Option<Run>>> {
        let held = self.run.lock_py_attached(py);
        held.map_err(|_| SimulationError::new_err("an internal fault ended this run"))
    }

    /// Computes something from the run with the interpreter's lock released.
    fn compute<T: Send>(&self, py: Python<'_>, of: impl FnOnce(&mut Option<Run>) -> T + Send) -> PyResult<T> {
        drop(self.held(py)?);
        let computed = py.detach(|| {
            let mut run = self.run.lock().ok()?;
            let run = &mut *run;
            Some(self.threads.run(|| of(run)))
        });
        computed.ok_or_else(|| SimulationError::new_err("an internal fault ended this run"))
    }

    /// The exception of a run that stopped.
    fn stopped(&self, py: Python<'_>, no: RunError) -> PyErr {
        match no {
            RunError::Fault(no @ (Fault::Force { .. } | Fault::Rules { .. })) => {
                let raised = self.calls.take().unwrap_or_else(|| PyValueError::new_err(no.to_string()));
                if raised.is_instance_of::<PyKeyboardInterrupt>(py)
                    && let Ok(Err(no)) = self.compute(py, |run| run.as_mut().map_or(Ok(()), Run::interrupted))
                {
                    return recorded(&no);
                }
                raised
            }
            RunError::Fault(no @ Fault::Device(_)) => fault(no),
            RunError::Fault(no) => SimulationError::new_err(format!("{}: {no}", self.folder.display())),
            no => refused(py, no.into()),
        }
    }
}

/// The exception of a run that could not begin.
fn refused(py: Python<'_>, no: Error) -> PyErr {
    match no {
        Error::Scene(no) => scene_fault(py, &no, true),
        Error::Fault(no) | Error::Run(RunError::Fault(no)) => fault(no),
        Error::Record(no) | Error::Run(RunError::Record(no)) => recorded(&no),
        other => SimulationError::new_err(other.to_string()),
    }
}

#[pymethods]
impl Recording {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        scene: &PyScene,
        out: Option<PathBuf>,
        backend: &str,
        threads: Option<usize>,
        precision: Option<&str>,
        adapter: Option<&str>,
        resume: bool,
        until: Option<f64>,
        from: Option<(PathBuf, Option<f64>)>,
        forces: Vec<Bound<'_, PyAny>>,
        rules: Option<Bound<'_, PyAny>>,
        checkpoint_every: Option<f64>,
    ) -> PyResult<Self> {
        let wanted = Wanted { backend, threads, precision, adapter };
        let threads = Threads::new(wanted.pool()?);
        let every = checkpoint_every.map(Duration::try_from_secs_f64).transpose();
        let every = every.map_err(|_| PyValueError::new_err("checkpoint_every: expected a number of seconds"))?;
        let calls = ForceCalls::new();
        let groups = scene.0.group_names();
        // All arguments are checked before the folder is made.
        let force = |force| PyForce::new(force, calls.clone(), groups.clone());
        let forces = forces.into_iter().map(force).collect::<PyResult<Vec<_>>>()?;
        let rules = rules.map(|rules| PyRules::new(&rules, calls.clone(), scene.0.clone())).transpose()?;
        let compute = wanted.settle(py, &scene.0)?;
        let start = Start { out: out.as_deref(), resume, until, from };
        let begun = py.detach(|| threads.run(|| start.run(scene.0.clone(), &compute)));
        let mut run = begun.map_err(|no| refused(py, no))?;
        let has_own = !forces.is_empty() || rules.is_some();
        forces.into_iter().for_each(|force| run.add_force(Box::new(force)));
        rules.into_iter().for_each(|rules| run.set_rules(Box::new(rules)));
        if has_own {
            // Its first checkpoint knows nothing of these.
            py.detach(|| threads.run(|| run.checkpoint())).map_err(|no| refused(py, no.into()))?;
        }
        every.into_iter().for_each(|every| run.checkpoint_every(every));
        let notes = run.notes().iter().cloned().chain(run.simulation().scene().warnings()).collect();
        let folder = run.folder().path().to_owned();
        Ok(Recording { run: Mutex::new(Some(run)), threads, calls, folder, notes })
    }

    #[getter]
    fn folder(&self) -> PathBuf {
        self.folder.clone()
    }

    /// What its user should know: of the run, and of its scene.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Takes at least one step, then as many as fit into `wall` seconds; returns the number of all steps, the time, the
    /// number of bodies, and whether the end is reached.
    fn advance(&self, py: Python<'_>, wall: f64) -> PyResult<(u64, f64, usize, bool)> {
        let ran = self.compute(py, |run| {
            let Some(run) = run else { return Ok((0, 0.0, 0, true)) };
            let begun = Instant::now();
            while !run.done() {
                run.advance()?;
                if begun.elapsed().as_secs_f64() >= wall {
                    break;
                }
            }
            let simulation = run.simulation();
            simulation.device().iter().for_each(|gpu| gpu.rest());
            Ok((simulation.steps(), simulation.time(), simulation.bodies(), run.done()))
        })?;
        ran.map_err(|no| self.stopped(py, no))
    }

    /// Ends the run at its end, or before it, to be resumed; returns its summary, None if it has ended before.
    fn finish<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let ended = self.compute(py, |run| run.take().map(Run::finish).transpose())?;
        ended.map_err(|no| self.stopped(py, no))?.map(|summary| json(py, &summary)).transpose()
    }
}
