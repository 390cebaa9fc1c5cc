//! Why a run stopped.

use crate::record::RecordError;
use crate::step::Fault;
use miette::Diagnostic;
use thiserror::Error;

/// Why a run stopped.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum RunError {
    /// A step failed. The state before it is in the checkpoint.
    #[error(transparent)]
    #[diagnostic(help(
        "the state before this step is in the run's checkpoint; a smaller time.dt, or less force, may help"
    ))]
    Fault(#[from] Fault),
    /// A file could not be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
}
