//! Exit statuses, and what leads to them.

use miette::Diagnostic;
use relcp::batch::{BatchError, Ended, MemberError};
use relcp::export::ExportError;
use relcp::gpu::GpuError;
use relcp::measure::MeasureError;
use relcp::record::RecordError;
use relcp::render::RenderError;
use relcp::run::{RunError, RunStatus};
use relcp::scene::SceneError;
use relcp::step::Fault;
use relcp::study::StudyError;
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
    fn of(code: i32) -> Exit {
        match code {
            2 => Exit::Usage,
            4 => Exit::File,
            130 => Exit::Interrupted,
            _ => Exit::Internal,
        }
    }

    /// Of two members' ends, the batch's: an interruption first, as it is the user's, then what most needs to be looked at.
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

    /// Of a member of a batch.
    pub(super) fn of_member(ended: &Ended) -> Exit {
        match ended {
            Ended::Before(status) | Ended::Now(status) => (*status).into(),
            Ended::NotBegun => Exit::Interrupted,
            Ended::Failed(MemberError::Scene(error)) => Exit::of(error.exit_code()),
            Ended::Failed(MemberError::Start(Fault::Device(_)) | MemberError::Device(_)) => Exit::Device,
            Ended::Failed(MemberError::Start(_) | MemberError::Unfit(_)) => Exit::Usage,
            Ended::Failed(MemberError::Run(error)) => Exit::of_run(error),
        }
    }

    fn of_run(error: &RunError) -> Exit {
        match error {
            RunError::Record(error) => Exit::of(error.exit_code()),
            RunError::Fault(Fault::Device(_)) => Exit::Device,
            RunError::Fault(fault) if fault.is_of_scene() => Exit::OutOfTolerance,
            RunError::Fault(_) => Exit::Internal,
        }
    }
}

impl From<RunStatus> for Exit {
    fn from(status: RunStatus) -> Exit {
        match status {
            RunStatus::Done => Exit::Done,
            RunStatus::OutOfTolerance | RunStatus::Stopped => Exit::OutOfTolerance,
            RunStatus::Interrupted => Exit::Interrupted,
            RunStatus::Fault => Exit::Internal,
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
            CliError::Export(error) => Exit::of(error.exit_code()),
            CliError::Measure(error) => Exit::of(error.exit_code()),
            CliError::Render(error) => Exit::of(error.exit_code()),
            CliError::Record(error) => Exit::of(error.exit_code()),
            CliError::Run(error) => Exit::of_run(error),
            CliError::Batch(error) => Exit::of(error.exit_code()),
            CliError::Device(_) => Exit::Device,
            CliError::Study(StudyError::Gpu(_) | StudyError::Fault(Fault::Device(_))) => Exit::Device,
            CliError::Study(StudyError::Record(error)) => Exit::of(error.exit_code()),
            CliError::Study(_) => Exit::Internal,
            CliError::Start(_) | CliError::Usage(_) | CliError::NoScene(_) => Exit::Usage,
            CliError::Output(_) => Exit::File,
        }
    }
}
