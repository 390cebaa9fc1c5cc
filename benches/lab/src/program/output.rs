//! What goes to standard output and standard error.

use super::fault::LabError;
use env_logger::Builder;
use log::LevelFilter;
use serde::Serialize;
use std::collections::BTreeSet;
use std::error::Error;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::sync::{Mutex, PoisonError};

/// Writes to standard output. That its reader has gone away is no fault.
pub fn write(with: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), LabError> {
    let mut out = BufWriter::new(io::stdout().lock());
    let written = with(&mut out).and_then(|()| out.flush());
    // What could not be written must not be tried again when the buffer goes.
    let _ = out.into_parts();
    match written {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(LabError::Output),
    }
}

/// Writes one JSON document.
pub fn json<T: Serialize>(value: &T) -> Result<(), LabError> {
    write(|out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        writeln!(out)
    })
}

/// Writes a line to standard error.
pub fn message(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Writes a line to standard error, unless it was written there before: of many studies each may have it to say.
pub fn message_once(text: &str) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    if SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(text.to_owned()) {
        message(text);
    }
}

/// Writes an error to standard error, with its causes.
pub fn report(error: &LabError) {
    message(&format!("error: {error}"));
    let mut cause = error.source();
    while let Some(error) = cause {
        message(&format!("  because: {error}"));
        cause = error.source();
    }
}

/// Starts a log of the library to standard error.
pub fn log(level: Option<LevelFilter>) {
    let Some(level) = level else { return };
    // The graphics libraries have much to say: of them, faults alone. There is one logger in a program, and no other.
    let _ = Builder::new().parse_filters(&format!("error,relcp={level}")).try_init();
}
