//! Silence from graphics drivers.
//!
//! Mesa writes "error: XDG_RUNTIME_DIR is invalid" to standard error at every start in an environment without this
//! variable: cron, ssh, containers, job queues. The drivers do not use the folder for computing. A process cannot
//! change its environment safely once it has threads, so the program starts anew with the variable set.

/// Starts the program anew with `XDG_RUNTIME_DIR` set, in an environment without it. The process and its number stay
/// the same. Where that fails the program goes on.
#[cfg(unix)]
pub fn silence() {
    use std::os::unix::process::CommandExt;
    if std::env::var_os("XDG_RUNTIME_DIR").is_some() {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let name = arguments.next().unwrap_or_default();
    let mut again = std::process::Command::new(program);
    again.arg0(name).args(arguments).env("XDG_RUNTIME_DIR", std::env::temp_dir());
    // Returns only where the system refuses; the driver's lines are then all that is wrong.
    let _refused = again.exec();
}

/// Other systems have no such variable.
#[cfg(not(unix))]
pub fn silence() {}
