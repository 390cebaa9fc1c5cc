//! Writing to standard output and standard error.

pub(super) use relcp::internals::program::{message, message_once};

use super::exit::CliError;
use super::hint::Hinted;
use relcp::internals::program;
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;

/// Writes to standard output.
pub(super) fn write(with: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), CliError> {
    program::write(with).map_err(CliError::Output)
}

/// Writes one JSON document.
pub(super) fn json<T: Serialize>(value: &T) -> Result<(), CliError> {
    program::json(value).map_err(CliError::Output)
}

/// A number with its noun, such as `3 bodies`.
pub(super) fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

/// A number of bytes with its unit.
pub(super) fn size(bytes: u64) -> String {
    match bytes {
        bytes if bytes < 1_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        bytes => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

/// A path as an argument of a command, quoted if a shell would split it.
pub(super) fn argument(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "-_./\\:,+@%=".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// Writes warnings to standard error.
pub(super) fn warn(warnings: &[String]) {
    warnings.iter().for_each(|warning| message(&format!("warning: {warning}")));
}

/// Writes an error to standard error, with its causes, its location and its remedy.
pub(super) fn report(error: CliError) {
    program::report(Hinted(error));
}
