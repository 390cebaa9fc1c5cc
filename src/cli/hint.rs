//! Hints for the program's user about an error of the library: options that the library does not have.

use super::exit::CliError;
use miette::{Diagnostic, LabeledSpan, SourceCode};
use relcp::batch::BatchError;
use relcp::export::ExportError;
use relcp::gpu::GpuError;
use relcp::measure::MeasureError;
use relcp::record::{RecordError, StatesError};
use relcp::render::RenderError;
use relcp::run::RunError;
use relcp::scene::{FaultKind, SceneError};
use relcp::step::Fault;
use std::error::Error;
use std::fmt;

/// An error with the program's hint instead of the library's help.
#[derive(Debug)]
pub(super) struct Hinted(pub CliError);

impl fmt::Display for Hinted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Error for Hinted {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.0.source()
    }
}

impl Diagnostic for Hinted {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        match of(&self.0) {
            Some(hint) => Some(Box::new(hint)),
            None => self.0.help(),
        }
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.0.labels()
    }
}

fn of(error: &CliError) -> Option<&'static str> {
    match error {
        CliError::Scene(error)
        | CliError::Render(RenderError::States(StatesError::Scene(error)))
        | CliError::Measure(MeasureError::States(StatesError::Scene(error)))
        | CliError::Export(ExportError::Scene(error)) => of_scene(error),
        CliError::Device(fault) | CliError::Start(Fault::Device(fault)) => of_device(fault),
        CliError::Run(RunError::Fault(Fault::Device(fault))) => of_device(fault),
        CliError::Render(RenderError::Device(fault)) => of_device(fault),
        CliError::Render(error) => of_render(error),
        CliError::Record(error)
        | CliError::Run(RunError::Record(error))
        | CliError::Export(ExportError::Record(error))
        | CliError::Measure(MeasureError::Record(error) | MeasureError::States(StatesError::Record(error)))
        | CliError::Batch(BatchError::Record(error)) => of_record(error),
        _ => None,
    }
}

fn of_scene(error: &SceneError) -> Option<&'static str> {
    let unknown = error.kind() == FaultKind::UnknownScene && error.help_text().is_none();
    unknown.then_some("`relcp scenes` lists the built-in scenes")
}

fn of_device(fault: &GpuError) -> Option<&'static str> {
    match fault {
        GpuError::NoF64 { .. } => Some("use --precision f32, or --backend cpu"),
        GpuError::Lost { .. } | GpuError::Hang { .. } => {
            Some("run again with --resume to continue from the last checkpoint")
        }
        GpuError::Kernel { .. } | GpuError::Refused { .. } => None,
        _ => Some("use --backend cpu"),
    }
}

fn of_record(error: &RecordError) -> Option<&'static str> {
    match error {
        RecordError::NotEmpty { .. } => {
            Some("choose another folder with --out, or continue the run in it with --resume")
        }
        RecordError::NoCheckpoint { .. } => {
            Some("name the folder of an earlier run with --out, or start a new one without --resume")
        }
        RecordError::OtherScene { .. } => Some("use the scene and the --set options of the run, or omit both"),
        RecordError::InUse { .. } => Some("wait for it, stop it, or name another folder with --out"),
        _ => None,
    }
}

fn of_render(error: &RenderError) -> Option<&'static str> {
    match error {
        RenderError::States(StatesError::Record(error)) | RenderError::Record(error) => of_record(error),
        RenderError::NoScale { .. } => Some("omit --range, or choose another --colour"),
        RenderError::Nothing { .. } => Some("omit --from and --to for all states"),
        RenderError::Foreign { .. } => Some("name another folder with --out"),
        RenderError::NoEncoder => Some("install ffmpeg, or make an animated PNG, which needs none: --movie NAME.png"),
        RenderError::Stopped { .. } => Some("run the same command again to start over and replace the files"),
        _ => None,
    }
}
