//! What goes to standard output and standard error. Neither may be there: a closed pipe ends the writing, not the
//! program.

use super::exit::CliError;
use super::hint::Hinted;
use serde::Serialize;
use std::collections::BTreeSet;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use textwrap::{WordSeparator, WordSplitter};

/// Writes to standard output. That its reader has gone away is no fault.
pub(super) fn write(with: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), CliError> {
    let mut out = BufWriter::new(io::stdout().lock());
    let written = with(&mut out).and_then(|()| out.flush());
    // What could not be written must not be tried again when the buffer goes.
    let _ = out.into_parts();
    match written {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(CliError::Output),
    }
}

/// Writes one JSON document.
pub(super) fn json<T: Serialize>(value: &T) -> Result<(), CliError> {
    write(|out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        writeln!(out)
    })
}

/// A number of things, in words.
pub(super) fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

/// A number of bytes, in words.
pub(super) fn size(bytes: u64) -> String {
    match bytes {
        bytes if bytes < 1_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        bytes => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

/// A path as an argument of a command: quoted where a shell would take it apart.
pub(super) fn argument(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "-_./\\:,+@%=".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// Writes a line to standard error.
pub(super) fn message(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Writes warnings to standard error.
pub(super) fn warn(warnings: &[String]) {
    warnings.iter().for_each(|warning| message(&format!("warning: {warning}")));
}

/// Writes a line to standard error, unless it was written there before: of many runs each may have it to say.
pub(super) fn message_once(text: &str) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    if SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(text.to_owned()) {
        message(text);
    }
}

/// Lets errors break their lines at spaces only, so that names, numbers and paths stay whole.
pub(super) fn whole_words() {
    // Only a handler that is set already is refused, and this one is set once.
    let _ = miette::set_hook(Box::new(|_| {
        let options = miette::MietteHandlerOpts::new().break_words(false);
        let options = options.word_separator(WordSeparator::AsciiSpace).word_splitter(WordSplitter::NoHyphenation);
        Box::new(options.build())
    }));
}

/// Writes an error to standard error, with its causes, location and hint.
pub(super) fn report(error: CliError) {
    let _ = write!(io::stderr(), "{:?}", miette::Report::new(Hinted(error)));
}
