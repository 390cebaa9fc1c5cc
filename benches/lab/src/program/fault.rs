//! Exit statuses and their causes.

use miette::Diagnostic;
use relcp::gpu::GpuError;
use relcp::record::RecordError;
use relcp::scene::{FaultKind, SceneError};
use relcp::step::Fault;
use relcp_lab::StudyError;
use std::io;

/// The exit statuses of the program, the same as those of `relcp`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Success: all results are within their tolerances.
    Done = 0,
    /// An internal fault.
    Internal = 1,
    /// Bad arguments.
    Usage = 2,
    /// A result of the study is outside its tolerance.
    OutOfTolerance = 3,
    /// A file could not be read or written.
    File = 4,
    /// No usable adapter, or a device fault.
    Device = 5,
    /// Interrupted; the same command continues the study.
    Interrupted = 130,
}

/// The reason why the program ends early.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum LabError {
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Record(#[from] RecordError),
    #[error(transparent)]
    Device(#[from] GpuError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Study(#[from] StudyError),
    #[error("could not write to standard output")]
    Output(#[source] io::Error),
}

impl LabError {
    pub fn exit(&self) -> Exit {
        match self {
            LabError::Usage(_) => Exit::Usage,
            LabError::Scene(error) if error.kind() == FaultKind::Io => Exit::File,
            LabError::Scene(_) => Exit::Usage,
            LabError::Record(error) | LabError::Study(StudyError::Record(error)) => of_record(error),
            LabError::Device(_) | LabError::Study(StudyError::Gpu(_) | StudyError::Fault(Fault::Device(_))) => {
                Exit::Device
            }
            LabError::Study(StudyError::Damaged(_)) | LabError::Output(_) => Exit::File,
            LabError::Study(StudyError::Elsewhere(_)) => Exit::Usage,
            LabError::Study(_) => Exit::Internal,
        }
    }
}

fn of_record(error: &RecordError) -> Exit {
    match error {
        RecordError::NotEmpty { .. }
        | RecordError::OtherScene { .. }
        | RecordError::NoLaterEnd { .. }
        | RecordError::InUse { .. } => Exit::Usage,
        _ => Exit::File,
    }
}
