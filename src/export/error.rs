//! Why states could not be exported.

use crate::record::{RecordError, StatesError};
use crate::scene::SceneError;
use miette::Diagnostic;
use std::path::PathBuf;
use thiserror::Error;

/// Why states could not be exported. Files that are already complete remain.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum ExportError {
    /// A file could not be read or written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    /// A scene was refused.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// The folder does not belong to a run.
    #[error("{}: no state to export", path.display())]
    #[diagnostic(help(
        "name a run's folder (it has states/, checkpoint.npz or final.json), a state (.npz), a scene file or a built-in scene"
    ))]
    NoState {
        /// The folder.
        path: PathBuf,
    },
    /// A number that the format cannot represent.
    #[error("{origin}: body {body}: its {what} of {value:e} {why}")]
    Unfit {
        /// The state.
        origin: String,
        /// The first body concerned, by its row.
        body: usize,
        /// Which quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The problem.
        why: &'static str,
    },
    /// A shape that no format supports.
    #[error("{origin}: body {body} has a custom shape, which files cannot store")]
    Custom {
        /// The state.
        origin: String,
        /// The first body concerned, by its row.
        body: usize,
    },
    /// The caller requested a stop.
    #[error("stopped after {done} of {all} states")]
    Stopped {
        /// States done.
        done: usize,
        /// All states.
        all: usize,
    },
}

impl From<StatesError> for ExportError {
    fn from(error: StatesError) -> Self {
        match error {
            StatesError::Record(error) => ExportError::Record(error),
            StatesError::Scene(error) => ExportError::Scene(error),
            StatesError::NoState { path } => ExportError::NoState { path },
            StatesError::Custom { origin, body } => ExportError::Custom { origin, body },
        }
    }
}
