//! What the programs, `relcp` and that of the laboratory, have in common around their commands: what drivers read from
//! the environment, the log, and what goes to standard output and standard error. Neither stream may be there: a closed
//! pipe ends the writing, not the program.

use env_logger::{Builder, Env};
use log::LevelFilter;
use miette::Diagnostic;
use serde::Serialize;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use textwrap::{WordSeparator, WordSplitter};

/// The folder of the session. Mesa writes "error: XDG_RUNTIME_DIR is invalid" to standard error at every start in an
/// environment without it: cron, ssh, containers, job queues. The drivers do not use the folder for computing.
const SESSION: &str = "XDG_RUNTIME_DIR";

/// The variable that takes levels by module, as `relcp=debug,wgpu_core=info`; `--log` wins over it.
const LEVELS: &str = "RELCP_LOG";

/// Has drivers write nothing, and errors break their lines at spaces only, so that names, numbers and paths stay whole.
pub fn prepare() {
    if std::env::var_os(SESSION).is_none() {
        restart_with(SESSION, std::env::temp_dir().as_os_str());
    }
    // Only a handler that is set already is refused, and this one is set once.
    let _ = miette::set_hook(Box::new(|_| {
        let options = miette::MietteHandlerOpts::new().break_words(false);
        let options = options.word_separator(WordSeparator::AsciiSpace).word_splitter(WordSplitter::NoHyphenation);
        Box::new(options.build())
    }));
}

/// Starts the program anew with a variable set: a process cannot change its environment safely once it has threads. The
/// process and its number stay the same. Where that fails the program goes on.
#[cfg(unix)]
pub fn restart_with(variable: &str, value: &OsStr) {
    use std::os::unix::process::CommandExt;
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let name = arguments.next().unwrap_or_default();
    let mut again = std::process::Command::new(program);
    again.arg0(name).args(arguments).env(variable, value);
    // Returns only where the system refuses; then the driver does what it does without the variable.
    let _refused = again.exec();
}

/// Other systems have no such drivers.
#[cfg(not(unix))]
pub fn restart_with(_variable: &str, _value: &OsStr) {}

/// Starts the log on standard error: nothing unless a level or the variable `RELCP_LOG` asks for it.
pub fn start_log(level: Option<LevelFilter>) {
    let mut builder = match level {
        // The graphics libraries have much to say: of them, faults alone.
        Some(level) => {
            let mut builder = Builder::new();
            builder.parse_filters(&format!("error,relcp={level}"));
            builder
        }
        None => Builder::from_env(Env::new().filter_or(LEVELS, "off")),
    };
    let begun = Instant::now();
    builder.format(move |out, record| {
        let (seconds, level) = (begun.elapsed().as_secs_f64(), record.level());
        writeln!(out, "{seconds:9.3} {level:<5} {}: {}", record.target(), record.args())
    });
    // There is one logger in a program: where one is set already, it stays.
    let _ = builder.try_init();
}

/// Writes to standard output. That its reader has gone away is no fault.
///
/// # Errors
/// What else goes wrong while it is written.
pub fn write(with: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    let written = with(&mut out).and_then(|()| out.flush());
    // What could not be written must not be tried again when the buffer goes.
    let _ = out.into_parts();
    match written {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Writes one JSON document to standard output.
///
/// # Errors
/// As [`write`].
pub fn json<T: Serialize>(value: &T) -> io::Result<()> {
    write(|out| {
        serde_json::to_writer_pretty(&mut *out, value)?;
        writeln!(out)
    })
}

/// Writes a line to standard error.
pub fn message(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Writes a line to standard error, unless it was written there before: of many runs each may have it to say.
pub fn message_once(text: &str) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    if SAID.lock().unwrap_or_else(PoisonError::into_inner).insert(text.to_owned()) {
        message(text);
    }
}

/// Writes an error to standard error, with its causes, its place and what would be right.
pub fn report(error: impl Diagnostic + Send + Sync + 'static) {
    let _ = write!(io::stderr(), "{:?}", miette::Report::new(error));
}
