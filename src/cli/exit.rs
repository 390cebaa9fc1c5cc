//! Exit statuses, and what leads to them.

use crate::gpu::GpuError;
use crate::record::{RecordError, RunError};
use crate::relcp::Fault;
use crate::scene::SceneError;
use crate::study::StudyError;
use miette::Diagnostic;
use std::io;
use thiserror::Error;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exit {
    /// Done, and every step met its tolerances.
    Done = 0,
    /// An internal fault.
    Internal = 1,
    /// Bad arguments or a bad scene; nothing is written.
    Usage = 2,
    /// The run went to its end, but some step did not meet its tolerances.
    OutOfTolerance = 3,
    /// A file could not be read or written.
    File = 4,
    /// No usable adapter, or a device that failed.
    Device = 5,
    /// Interrupted; a checkpoint is written.
    Interrupted = 130,
}

impl Exit {
    fn of(code: i32) -> Exit {
        match code {
            2 => Exit::Usage,
            4 => Exit::File,
            _ => Exit::Internal,
        }
    }
}

/// Why a command ends early.
#[derive(Debug, Error, Diagnostic)]
pub(super) enum CliError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Start(Fault),
    #[error("{0}")]
    Usage(String),
    #[error("there is no built-in scene `{0}`")]
    #[diagnostic(help("`relcp scenes` lists them"))]
    NoScene(String),
    #[error(transparent)]
    Device(#[from] GpuError),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error("could not write to standard output")]
    Output(#[source] io::Error),
}

impl CliError {
    /// A simulation that cannot be started.
    pub(super) fn start(fault: Fault) -> CliError {
        match fault {
            Fault::Device(fault) => CliError::Device(fault),
            fault => CliError::Start(fault),
        }
    }

    pub(super) fn exit(&self) -> Exit {
        match self {
            CliError::Scene(error) => Exit::of(error.exit_code()),
            CliError::Record(error) | CliError::Run(RunError::Record(error)) => Exit::of(error.exit_code()),
            CliError::Run(RunError::Fault(Fault::Device(_))) | CliError::Device(_) => Exit::Device,
            CliError::Run(RunError::Fault(_)) => Exit::Internal,
            CliError::Study(StudyError::Gpu(_) | StudyError::Fault(Fault::Device(_))) => Exit::Device,
            CliError::Study(StudyError::Io { .. }) => Exit::File,
            CliError::Study(_) => Exit::Internal,
            CliError::Start(_) | CliError::Usage(_) | CliError::NoScene(_) => Exit::Usage,
            CliError::Output(_) => Exit::File,
        }
    }
}
