//! The backend of a simulation, by its arguments.

use super::driver::opening;
use super::error::device;
use crate::gpu::{Choice, GpuError, Precision};
use crate::scene::Scene;
use crate::simulation::{Compute, worth_a_device};
use pyo3::exceptions::{PyRuntimeWarning, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::ffi::CString;
use std::sync::OnceLock;

/// The largest number of threads, as in the program: more than the cores of any machine.
const MOST_THREADS: usize = 1024;

/// The arguments of a simulation that select the backend.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'a> {
    pub backend: &'a str,
    pub threads: Option<usize>,
    pub precision: Option<&'a str>,
    pub adapter: Option<&'a str>,
}

impl Wanted<'_> {
    /// The backend for the scene; warns if it may be unexpected.
    pub fn settle(&self, py: Python<'_>, scene: &Scene) -> PyResult<Compute> {
        let precision = self.precision()?;
        match self.backend {
            "cpu" => self.cpu(precision),
            "gpu" => self.open(py, scene, precision),
            "auto" => self.automatic(py, precision, scene),
            other => Err(PyValueError::new_err(format!("backend: expected 'cpu', 'gpu' or 'auto', found {other:?}"))),
        }
    }

    fn precision(&self) -> PyResult<Option<Precision>> {
        match self.precision {
            None => Ok(None),
            Some("f32") => Ok(Some(Precision::F32)),
            Some("f64") => Ok(Some(Precision::F64)),
            Some(other) => Err(PyValueError::new_err(format!("precision: expected 'f32' or 'f64', found {other:?}"))),
        }
    }

    fn cpu(&self, precision: Option<Precision>) -> PyResult<Compute> {
        if precision == Some(Precision::F32) {
            return Err(PyValueError::new_err("the CPU computes in f64; omit precision, or use backend='gpu'"));
        }
        if self.adapter.is_some() {
            return Err(PyValueError::new_err("adapter names a device; use backend='gpu'"));
        }
        Ok(Compute::Cpu)
    }

    /// The CPU; warns if a hardware GPU may be faster.
    fn automatic(&self, py: Python<'_>, precision: Option<Precision>, scene: &Scene) -> PyResult<Compute> {
        let compute = self.cpu(precision)?;
        if let Some(why) = opening(py, || worth_a_device(scene, 1))? {
            warn(py, &format!("{why}; try backend='gpu'"))?;
        }
        Ok(compute)
    }

    fn open(&self, py: Python<'_>, scene: &Scene, precision: Option<Precision>) -> PyResult<Compute> {
        let choice = Choice { name: self.adapter.map(str::to_owned), software: true, ..Choice::default() };
        let opened = opening(py, || Compute::open_in(&choice, precision, scene))?;
        let compute = opened.map_err(|fault: GpuError| device(&fault))?;
        if let Compute::Gpu { gpu, .. } = &compute {
            gpu.warnings().iter().try_for_each(|warning| warn(py, warning))?;
        }
        Ok(compute)
    }

    /// The simulation's own threads, if their number is given; else those that the whole process shares.
    pub fn pool(&self) -> PyResult<Option<ThreadPool>> {
        match self.threads {
            Some(threads) if !(1..=MOST_THREADS).contains(&threads) => {
                Err(PyValueError::new_err(format!("threads: expected 1 to {MOST_THREADS}, found {threads}")))
            }
            // A forked process lacks the shared threads.
            None if !shared_threads_live() => pool(0).map(Some),
            None => Ok(None),
            Some(threads) => pool(threads).map(Some),
        }
    }
}

fn pool(threads: usize) -> PyResult<ThreadPool> {
    let built = ThreadPoolBuilder::new().num_threads(threads).build();
    built.map_err(|fault| super::error::SimulationError::new_err(format!("cannot create the thread pool: {fault}")))
}

/// Whether this process has the shared threads: the first process that calls this.
pub(super) fn shared_threads_live() -> bool {
    static FIRST: OnceLock<u32> = OnceLock::new();
    *FIRST.get_or_init(std::process::id) == std::process::id()
}

/// Warns the user.
pub(super) fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    let message = CString::new(message.replace('\0', " "))?;
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &message, 1)
}
