//! The Python package `relcp`: scenes, simulations, their arrays and contacts, runs and their folders, with the feature
//! `python` only.
//!
//! It is thin: every number comes from [`crate::simulation::Simulation`], [`crate::record`] and [`crate::scene`]. The
//! interpreter's lock is released during computations. The package's entry module and its stubs are in the folder
//! `relcp` beside this file; `pyproject.toml` builds both with maturin.

mod arrays;
mod batch;
mod bodies;
mod bonds;
mod change;
mod compute;
mod contacts;
mod driver;
mod ensemble;
mod error;
mod force;
mod limit;
mod measure;
mod picture;
mod recorded;
mod recording;
mod reel;
mod report;
mod rules;
mod scene;
mod session;
mod simulation;
mod state;
mod tables;
mod work;

use crate::gpu::{Choice, adapters};
use crate::shape::Tag;
use pyo3::prelude::*;

/// The GPU adapters of this machine, better ones first, each as a dict: `name`, `kind`, `interface`, `driver`, `f64`,
/// `timestamps`, sizes in bytes, `lacks` (why it cannot be used) and `taken` (whether `backend="gpu"` uses it).
#[pyfunction]
#[pyo3(signature = (adapter=None))]
fn devices(py: Python<'_>, adapter: Option<String>) -> PyResult<Bound<'_, PyAny>> {
    let choice = Choice { name: adapter, software: true, ..Choice::default() };
    let found = driver::opening(py, || adapters(&choice))?;
    arrays::json(py, &found)
}

/// The measures: a description of each, by its name.
#[pyfunction]
fn measures() -> Vec<(&'static str, &'static str)> {
    crate::measure::ALL.iter().map(|measure| (measure.name(), measure.about().line)).collect()
}

/// The shapes of scenes: the name and the code of each.
#[pyfunction]
fn shapes() -> Vec<(&'static str, u32)> {
    Tag::ALL.iter().filter_map(|tag| Some((tag.upper_name()?, *tag as u32))).collect()
}

/// The built-in scenes: a description of each, by its name.
#[pyfunction]
fn scenes() -> Vec<(&'static str, &'static str)> {
    crate::scene::BuiltIn::ALL.iter().map(|scene| (scene.name, scene.summary)).collect()
}

/// The compiled half of the package `relcp`.
#[pymodule]
mod _relcp {
    #[pymodule_export]
    use super::batch::Planned;
    #[pymodule_export]
    use super::bodies::PyBodies;
    #[pymodule_export]
    use super::bonds::Bonds;
    #[pymodule_export]
    use super::contacts::{Contacts, WallContacts};
    #[pymodule_export]
    use super::ensemble::PyEnsemble;
    #[pymodule_export]
    use super::error::{DeviceError, Error, RecordError, SceneError, SimulationError};
    #[pymodule_export]
    use super::recorded::Recorded;
    #[pymodule_export]
    use super::recording::Recording;
    #[pymodule_export]
    use super::reel::PyReel;
    #[pymodule_export]
    use super::report::StepReport;
    #[pymodule_export]
    use super::scene::PyScene;
    #[pymodule_export]
    use super::simulation::PySimulation;
    #[pymodule_export]
    use super::state::PyState;
    #[pymodule_export]
    use super::{devices, measures, scenes, shapes};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn constants(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("NO_GROUP", super::arrays::NO_GROUP)?;
        module.add("NO_PARENT", super::arrays::NO_PARENT)
    }
}
