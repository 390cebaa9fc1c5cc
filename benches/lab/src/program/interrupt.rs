//! Ctrl-C and termination signals: the first requests a stop after the current measurement, the second quits.

use super::fault::Exit;
use super::output;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user has requested a stop.
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Starts to listen. If the system has no such signals, they end the program as usual.
    pub fn listen() -> Self {
        let asked = Arc::new(AtomicBool::new(false));
        let heard = asked.clone();
        let listens = ctrlc::set_handler(move || {
            if heard.swap(true, Ordering::SeqCst) {
                std::process::exit(Exit::Interrupted as i32);
            }
            output::message("stopping; once more to quit at once");
        });
        if listens.is_err() {
            output::message("an interrupt ends the program at once: the system's signals cannot be listened to");
        }
        Interrupt(asked)
    }

    pub fn asked(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
