//! Why states could not be measured.

use super::ALL;
use crate::record::{RecordError, StatesError};
use miette::Diagnostic;
use std::path::PathBuf;
use thiserror::Error;

/// Why states could not be measured. Files that are already complete remain.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum MeasureError {
    /// A state could not be found or read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    States(StatesError),
    /// The folder does not belong to a run.
    #[error("{}: no state to measure", path.display())]
    #[diagnostic(help(
        "name a run's folder (it has states/, checkpoint.npz or final.json), a state (.npz), a scene file or a built-in scene"
    ))]
    NoState {
        /// The folder.
        path: PathBuf,
    },
    /// A file could not be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    /// The measure does not exist.
    #[error("unknown measure `{name}`")]
    #[diagnostic(help("the measures are {}", ALL.map(|measure| measure.name()).join(", ")))]
    Unknown {
        /// The requested name.
        name: String,
    },
    /// A body that cannot be measured.
    #[error("{origin}: body {body}: its {what}")]
    Unfit {
        /// The state.
        origin: String,
        /// The first body concerned, by its row.
        body: usize,
        /// Which quantity is wrong, and how.
        what: String,
    },
    /// A table or a plot could not be made.
    #[error("{}: could not create it: {what}", path.display())]
    Unmade {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        what: String,
    },
    /// The caller requested a stop.
    #[error("stopped after {done} of {all} states; nothing was written")]
    Stopped {
        /// States done.
        done: usize,
        /// All states.
        all: usize,
    },
}

impl From<StatesError> for MeasureError {
    fn from(error: StatesError) -> Self {
        match error {
            StatesError::NoState { path } => MeasureError::NoState { path },
            other => MeasureError::States(other),
        }
    }
}
