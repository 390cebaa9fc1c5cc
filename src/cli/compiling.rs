//! Progress on standard error while a device's kernels are compiled before the first step; some drivers take half a
//! minute.

use super::output;
use indicatif::{ProgressBar, ProgressStyle};
use relcp::gpu::Gpu;
use relcp::simulation::Compute;
use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Nothing is shown before this much time has passed.
const QUIET_FOR: Duration = Duration::from_secs(1);
/// Time between lines without a terminal.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// Time between updates of the text.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// Calls `make`, which compiles kernels, and shows the number of kernels so far.
pub(super) fn watch<T>(compute: &Compute, quiet: bool, make: impl FnOnce() -> T) -> T {
    let Compute::Gpu { gpu, .. } = compute else { return make() };
    if quiet {
        return make();
    }
    std::thread::scope(|scope| {
        let (made, ends) = channel();
        scope.spawn(move || show(gpu, &ends));
        let result = make();
        drop(made);
        result
    })
}

/// Shows the number of kernels until the sender is dropped.
fn show(gpu: &Gpu, ends: &Receiver<()>) {
    let (begun, before, mut shown) = (Instant::now(), gpu.pipelines().len(), Instant::now());
    let mut bar: Option<ProgressBar> = None;
    while ends.recv_timeout(POLL_INTERVAL) == Err(RecvTimeoutError::Timeout) {
        if begun.elapsed() < QUIET_FOR {
            continue;
        }
        let text = format!("compiled {} kernels for {}", gpu.pipelines().len() - before, gpu.name());
        if std::io::stderr().is_terminal() {
            let bar = bar.get_or_insert_with(|| {
                let style = ProgressStyle::with_template("{spinner} {msg}");
                ProgressBar::new_spinner().with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
            });
            bar.set_message(text);
            bar.tick();
        } else if shown.elapsed() >= LINE_EVERY {
            shown = Instant::now();
            output::message(&text);
        }
    }
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
}
