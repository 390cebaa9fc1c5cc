//! Faults as Python's exceptions.

use crate::export::ExportError;
use crate::gpu::GpuError;
use crate::measure::MeasureError;
use crate::record::{self, StatesError};
use crate::render::RenderError;
use crate::scene::{self, FaultKind};
use crate::step::Fault;
use miette::Diagnostic;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;

create_exception!(relcp, Error, PyException, "The base class of all exceptions of relcp.");
create_exception!(
    relcp,
    SceneError,
    Error,
    "A scene was refused. Attributes: kind (str), key (dotted, as overrides take it), message, help (str or None), origin (str or None), line and \
     column (from 1; None if the scene is not text)."
);
create_exception!(
    relcp,
    SimulationError,
    Error,
    "A simulation could not be started, or a step failed. The simulation keeps its last accepted state."
);
create_exception!(relcp, DeviceError, Error, "There is no usable GPU, it does not support the scene, or it failed.");
create_exception!(relcp, RecordError, Error, "A file of a run, or a state file, could not be read or written.");

fn kind(kind: FaultKind) -> &'static str {
    match kind {
        FaultKind::Io => "io",
        FaultKind::UnknownScene => "unknown_scene",
        FaultKind::Syntax => "syntax",
        FaultKind::UnknownKey => "unknown_key",
        FaultKind::MissingKey => "missing_key",
        FaultKind::DuplicateKey => "duplicate_key",
        FaultKind::WrongType => "wrong_type",
        FaultKind::BadValue => "bad_value",
        FaultKind::TooLarge => "too_large",
        FaultKind::BadOverride => "bad_override",
        FaultKind::Placement => "placement",
        FaultKind::Interrupted => "interrupted",
    }
}

/// A scene's fault, with its location if the scene is text.
pub(super) fn scene_fault(py: Python<'_>, fault: &scene::SceneError, written: bool) -> PyErr {
    let place = |number: Option<usize>| number.filter(|_| written);
    let mut said = match (written, fault.key()) {
        (true, _) => fault.to_string(),
        (false, "") => fault.message().to_owned(),
        (false, key) => format!("{key}: {}", fault.message()),
    };
    if let Some(help) = fault.help_text() {
        said = format!("{said}\n{help}");
    }
    let error = SceneError::new_err(said);
    let value = error.value(py);
    let set = || {
        value.setattr("kind", kind(fault.kind()))?;
        value.setattr("key", fault.key())?;
        value.setattr("message", fault.message())?;
        value.setattr("help", fault.help_text())?;
        value.setattr("origin", fault.origin())?;
        value.setattr("line", place(fault.line()))?;
        value.setattr("column", place(fault.column()))
    };
    match set() {
        Ok(()) => error,
        Err(fault) => fault,
    }
}

/// A scene's fault from code, without a text.
pub(super) fn bad_scene(py: Python<'_>, kind: &str, message: String, cause: PyErr) -> PyErr {
    let error = SceneError::new_err(message.clone());
    error.set_cause(py, Some(cause));
    let value = error.value(py);
    let none = || py.None();
    let set = || {
        value.setattr("kind", kind)?;
        value.setattr("key", "")?;
        value.setattr("message", message)?;
        ["help", "origin", "line", "column"].into_iter().try_for_each(|name| value.setattr(name, none()))
    };
    match set() {
        Ok(()) => error,
        Err(fault) => fault,
    }
}

/// The fault of a step or a start.
pub(super) fn fault(fault: Fault) -> PyErr {
    match fault {
        Fault::Device(fault) => device(&fault),
        fault => SimulationError::new_err(fault.to_string()),
    }
}

/// A device's fault.
pub(super) fn device(fault: &GpuError) -> PyErr {
    DeviceError::new_err(fault.to_string())
}

/// A fault with its cause and its remedy.
pub(super) fn told(fault: &dyn Diagnostic) -> String {
    let cause = fault.source().map_or_else(String::new, |cause| format!(": {cause}"));
    let help = fault.help().map_or_else(String::new, |help| format!("\n{help}"));
    format!("{fault}{cause}{help}")
}

/// The fault of a file, with the system's error.
pub(super) fn recorded(fault: &record::RecordError) -> PyErr {
    RecordError::new_err(told(fault))
}

/// The fault of recorded states.
pub(super) fn states(py: Python<'_>, fault: &StatesError) -> PyErr {
    match fault {
        StatesError::Scene(fault) => scene_fault(py, fault, true),
        fault => RecordError::new_err(told(fault)),
    }
}

/// The fault of a picture or a page: of a file, or of an argument.
pub(super) fn rendered(py: Python<'_>, fault: RenderError) -> PyErr {
    match fault {
        RenderError::States(fault) => states(py, &fault),
        RenderError::Record(fault) => recorded(&fault),
        fault @ (RenderError::NoState { .. } | RenderError::NoEncoder | RenderError::Encoder { .. }) => {
            RecordError::new_err(told(&fault))
        }
        fault => PyValueError::new_err(told(&fault)),
    }
}

/// The fault of measures over a run.
pub(super) fn measured(py: Python<'_>, fault: MeasureError) -> PyErr {
    match fault {
        MeasureError::States(fault) => states(py, &fault),
        fault @ MeasureError::Unknown { .. } => PyValueError::new_err(told(&fault)),
        fault => RecordError::new_err(told(&fault)),
    }
}

/// The fault of an export.
pub(super) fn exported(py: Python<'_>, fault: ExportError) -> PyErr {
    match fault {
        ExportError::Scene(fault) => scene_fault(py, &fault, true),
        fault => RecordError::new_err(told(&fault)),
    }
}
