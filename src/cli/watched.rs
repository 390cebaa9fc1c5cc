//! Work on a run's states: a bar on a terminal, and its end where it is interrupted.

use super::interrupt::Interrupt;
use indicatif::ProgressBar;
use relcp::record::Watch;
use std::io::IsTerminal;

/// Does `work`, which tells how many of all states are done, and asks whether to go on.
pub(super) fn watched<T>(quiet: bool, work: impl FnOnce(Watch<'_>) -> T) -> T {
    let interrupt = Interrupt::listen();
    let bar = (!quiet && std::io::stderr().is_terminal()).then(|| ProgressBar::new(0));
    let done = work(&mut |done, all| {
        if let Some(bar) = &bar {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        }
        !interrupt.asked()
    });
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    done
}
