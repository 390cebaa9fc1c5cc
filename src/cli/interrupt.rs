//! Ctrl-C and termination: the first signal stops after the step, the second quits.

use super::exit::Exit;
use super::output;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Turns a file that exceeds the system's limit (`ulimit -f`) into a write error: without a handler the system ends the
/// program silently.
#[cfg(unix)]
pub(super) fn outlive_file_limits() {
    // Without the handler the system ends the program.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Other systems have no such limit.
#[cfg(not(unix))]
pub(super) fn outlive_file_limits() {}

/// Whether the user has requested a stop.
#[derive(Clone, Default)]
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Installs the signal handler. Without it signals end the program at once.
    pub(super) fn listen() -> Self {
        Interrupt::listen_and(|| output::message("stopping; once more to quit at once"))
    }

    /// [`Interrupt::listen`] that calls `say` at the first signal.
    pub(super) fn listen_and(say: impl Fn() + Send + 'static) -> Self {
        let interrupt = Interrupt::default();
        let asked = interrupt.clone();
        let installed = ctrlc::set_handler(move || {
            if asked.0.swap(true, Ordering::SeqCst) {
                std::process::exit(Exit::Interrupted as i32);
            }
            say();
        });
        // A limit on processor time (`ulimit -t`) warns some seconds before it ends the program.
        #[cfg(unix)]
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXCPU, interrupt.0.clone());
        if installed.is_err() {
            output::message("cannot install a signal handler: an interrupt will not leave a checkpoint");
        }
        interrupt
    }

    /// Ignores the first signal, for ranks other than 0.
    #[cfg(feature = "mpi")]
    pub(super) fn ignore() -> Self {
        Interrupt::listen_and(|| ())
    }

    pub(super) fn asked(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
