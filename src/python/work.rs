//! Long work on a run's states, with the interpreter's lock released.

use super::compute::Wanted;
use super::session::Threads;
use crate::record::Watch;
use pyo3::prelude::*;
use std::time::{Duration, Instant};

/// Wall time between checks of Python's signals.
const SIGNALS_EVERY: Duration = Duration::from_millis(50);

/// Does `work` without the interpreter's lock. Ctrl-C ends it between two states.
pub(super) fn watched<T: Send, E: Send>(
    py: Python<'_>,
    work: impl FnOnce(Watch<'_>) -> Result<T, E> + Send,
) -> PyResult<Result<T, E>> {
    let mut raised = None;
    let done = quietly(py, || {
        let mut last = Instant::now();
        work(&mut |_, _| {
            if raised.is_none() && last.elapsed() >= SIGNALS_EVERY {
                last = Instant::now();
                raised = Python::attach(|py| py.check_signals()).err();
            }
            raised.is_none()
        })
    })?;
    raised.map_or(Ok(done), Err)
}

/// Does `work` without the interpreter's lock, on threads that this process has.
pub(super) fn quietly<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let wanted = Wanted { backend: "cpu", threads: None, precision: None, adapter: None };
    let threads = Threads::new(wanted.pool()?);
    Ok(py.detach(|| threads.run(work)))
}
