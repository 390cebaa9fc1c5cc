//! Standard output and standard error.

pub use relcp::internals::program::{message, message_once, report};

use super::fault::LabError;
use relcp::internals::program;
use serde::Serialize;
use std::io::{self, Write};

/// Writes to standard output.
pub fn write(with: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), LabError> {
    program::write(with).map_err(LabError::Output)
}

/// Writes one JSON document.
pub fn json<T: Serialize>(value: &T) -> Result<(), LabError> {
    program::json(value).map_err(LabError::Output)
}
