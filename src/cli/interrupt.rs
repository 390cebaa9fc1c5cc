//! Ctrl-C and termination: the first asks to stop after the step, the second quits.

use super::exit::Exit;
use super::output;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Lets a file that would grow over the system's limit (`ulimit -f`) be a fault of writing, with a message: without a
/// handler the system ends the program silently.
#[cfg(unix)]
pub(super) fn outlive_file_limits() {
    // Where the system refuses the handler, it ends the program as ever.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

/// Other systems have no such limit.
#[cfg(not(unix))]
pub(super) fn outlive_file_limits() {}

/// Whether the user has asked to stop.
#[derive(Clone, Default)]
pub(super) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on. Where the system has no signals to listen to, they end the program as ever.
    pub(super) fn listen() -> Self {
        Interrupt::listen_and(|| output::message("stopping; once more to quit at once"))
    }

    /// As [`Interrupt::listen`], with a message for the first signal.
    pub(super) fn listen_and(say: impl Fn() + Send + 'static) -> Self {
        let interrupt = Interrupt::default();
        let asked = interrupt.clone();
        let heard = ctrlc::set_handler(move || {
            if asked.0.swap(true, Ordering::SeqCst) {
                std::process::exit(Exit::Interrupted as i32);
            }
            say();
        });
        // A limit of the processor's time (`ulimit -t`) warns some seconds before it ends the program.
        #[cfg(unix)]
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXCPU, interrupt.0.clone());
        if heard.is_err() {
            output::message("an interrupt will not leave a checkpoint: the system's signals cannot be listened to");
        }
        interrupt
    }

    /// Says nothing at the first, for a process that another one leads.
    #[cfg(feature = "mpi")]
    pub(super) fn ignore() -> Self {
        Interrupt::listen_and(|| ())
    }

    pub(super) fn asked(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
