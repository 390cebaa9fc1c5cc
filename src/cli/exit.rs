//! Exit statuses and their causes.

use miette::Diagnostic;
use relcp::Error;
use relcp::batch::{BatchError, Ended, MemberError};
use relcp::export::ExportError;
use relcp::gpu::GpuError;
use relcp::measure::MeasureError;
use relcp::record::{RecordError, StatesError};
use relcp::render::RenderError;
use relcp::run::{RunError, RunStatus};
use relcp::scene::{FaultKind, SceneError};
use relcp::step::Fault;
use std::io;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exit {
    /// Done, and every step met its tolerances.
    Done = 0,
    /// An internal fault.
    Internal = 1,
    /// Bad arguments or a bad scene; nothing is written.
    Usage = 2,
    /// The run went to its end, but some step did not meet its tolerances; or it stopped at a step that cannot.
    OutOfTolerance = 3,
    /// A file could not be read or written.
    File = 4,
    /// No usable adapter, or a device that failed.
    Device = 5,
    /// Interrupted; a checkpoint is written.
    Interrupted = 130,
}

impl Exit {
    /// The exit status of a batch from those of two members: an interruption first, because the user asked for it, then
    /// the more serious one.
    pub(super) fn worse(self, other: Exit) -> Exit {
        let rank = |exit: Exit| match exit {
            Exit::Done => 0,
            Exit::OutOfTolerance => 1,
            Exit::Usage => 2,
            Exit::Internal => 3,
            Exit::Device => 4,
            Exit::File => 5,
            Exit::Interrupted => 6,
        };
        if rank(other) > rank(self) { other } else { self }
    }

    /// The exit status of a member of a batch.
    pub(super) fn of_member(ended: &Ended) -> Exit {
        match ended {
            Ended::Before(status) | Ended::Now(status) => (*status).into(),
            Ended::NotBegun => Exit::Interrupted,
            Ended::Failed(MemberError::Scene(error)) => error.into(),
            Ended::Failed(MemberError::Start(Fault::Device(_)) | MemberError::Device(_)) => Exit::Device,
            Ended::Failed(MemberError::Start(_)) => Exit::Usage,
            Ended::Failed(MemberError::Run(error)) => error.into(),
            Ended::Failed(_) => Exit::Internal,
        }
    }
}

impl From<&SceneError> for Exit {
    fn from(error: &SceneError) -> Exit {
        match error.kind() {
            FaultKind::Io => Exit::File,
            FaultKind::Interrupted => Exit::Interrupted,
            _ => Exit::Usage,
        }
    }
}

impl From<&RecordError> for Exit {
    fn from(error: &RecordError) -> Exit {
        match error {
            RecordError::NotEmpty { .. }
            | RecordError::OtherScene { .. }
            | RecordError::NoLaterEnd { .. }
            | RecordError::NoBranch { .. }
            | RecordError::InUse { .. } => Exit::Usage,
            _ => Exit::File,
        }
    }
}

impl From<&StatesError> for Exit {
    fn from(error: &StatesError) -> Exit {
        match error {
            StatesError::Record(error) => error.into(),
            StatesError::Scene(error) => error.into(),
            StatesError::Custom { .. } => Exit::Usage,
            _ => Exit::File,
        }
    }
}

impl From<&RunError> for Exit {
    fn from(error: &RunError) -> Exit {
        match error {
            RunError::Record(error) => error.into(),
            RunError::Fault(Fault::Device(_)) => Exit::Device,
            RunError::Fault(fault) if fault.is_of_scene() => Exit::OutOfTolerance,
            _ => Exit::Internal,
        }
    }
}

impl From<&ExportError> for Exit {
    fn from(error: &ExportError) -> Exit {
        match error {
            ExportError::Record(error) => error.into(),
            ExportError::Scene(error) => error.into(),
            ExportError::Unfit { .. } | ExportError::Custom { .. } => Exit::Usage,
            ExportError::Stopped { .. } => Exit::Interrupted,
            _ => Exit::File,
        }
    }
}

impl From<&MeasureError> for Exit {
    fn from(error: &MeasureError) -> Exit {
        match error {
            MeasureError::States(error) => error.into(),
            MeasureError::Record(error) => error.into(),
            MeasureError::Unknown { .. } => Exit::Usage,
            MeasureError::Stopped { .. } => Exit::Interrupted,
            _ => Exit::File,
        }
    }
}

impl From<&RenderError> for Exit {
    fn from(error: &RenderError) -> Exit {
        match error {
            RenderError::States(error) => error.into(),
            RenderError::Record(error) => error.into(),
            RenderError::NoState { .. } | RenderError::Encoder { .. } => Exit::File,
            RenderError::Device(_) => Exit::Device,
            RenderError::Stopped { .. } => Exit::Interrupted,
            _ => Exit::Usage,
        }
    }
}

impl From<&BatchError> for Exit {
    fn from(error: &BatchError) -> Exit {
        match error {
            BatchError::Scene(error) => error.into(),
            BatchError::Record(error) => error.into(),
            _ => Exit::Internal,
        }
    }
}

impl From<RunStatus> for Exit {
    fn from(status: RunStatus) -> Exit {
        match status {
            RunStatus::Done => Exit::Done,
            RunStatus::OutOfTolerance | RunStatus::Stopped => Exit::OutOfTolerance,
            RunStatus::Interrupted => Exit::Interrupted,
            _ => Exit::Internal,
        }
    }
}

/// Why a command ends early.
#[derive(Debug, thiserror::Error, Diagnostic)]
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
    #[diagnostic(transparent)]
    Export(#[from] ExportError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Measure(#[from] MeasureError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Batch(#[from] BatchError),
    #[error(transparent)]
    Start(Fault),
    #[error("{0}")]
    Usage(String),
    #[error("{message}")]
    #[diagnostic(help("to start a run with the last state that can be read: {command}"))]
    Damaged { message: String, command: String },
    #[error("{message}")]
    #[diagnostic(help("to continue it as it was started: {command}"))]
    OtherSettings { message: String, command: String },
    #[error(transparent)]
    Device(#[from] GpuError),
    #[error("could not write to standard output")]
    Output(#[source] io::Error),
}

impl CliError {
    /// A simulation that cannot be started.
    pub(super) fn start(error: Error) -> CliError {
        match error {
            Error::Scene(error) => CliError::Scene(error),
            Error::Fault(Fault::Device(fault)) | Error::Gpu(fault) => CliError::Device(fault),
            Error::Fault(fault) => CliError::Start(fault),
            other => CliError::Usage(other.to_string()),
        }
    }

    pub(super) fn exit(&self) -> Exit {
        match self {
            CliError::Scene(error) => error.into(),
            CliError::Export(error) => error.into(),
            CliError::Measure(error) => error.into(),
            CliError::Render(error) => error.into(),
            CliError::Record(error) => error.into(),
            CliError::Run(error) => error.into(),
            CliError::Batch(error) => error.into(),
            CliError::Device(_) => Exit::Device,
            CliError::Start(_) | CliError::Usage(_) | CliError::OtherSettings { .. } => Exit::Usage,
            CliError::Output(_) | CliError::Damaged { .. } => Exit::File,
        }
    }
}
