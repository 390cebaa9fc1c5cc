//! Suppresses a message of graphics drivers, as in `src/cli/driver.rs`.
//!
//! Mesa writes "error: XDG_RUNTIME_DIR is invalid" to standard error if a device is opened in an environment without
//! this variable. The package sets the variable in Python's `os.environ` for this time, and then removes it.

use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use std::sync::{Mutex, PoisonError};

const VARIABLE: &str = "XDG_RUNTIME_DIR";

/// The number of threads that are opening a device, and the value to which the first of them set the variable.
static LENT: Mutex<(usize, Option<String>)> = Mutex::new((0, None));

/// Opens a device with the interpreter's lock released.
pub(super) fn opening<T: Send>(py: Python<'_>, open: impl FnOnce() -> T + Send) -> PyResult<T> {
    if cfg!(not(unix)) {
        return Ok(py.detach(open));
    }
    lend(py)?;
    let opened = py.detach(open);
    take_back(py)?;
    Ok(opened)
}

fn environment(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    py.import("os")?.getattr("environ")
}

fn lend(py: Python<'_>) -> PyResult<()> {
    let mut lent = LENT.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
    let environment = environment(py)?;
    if !environment.contains(VARIABLE)? {
        let folder = std::env::temp_dir().to_string_lossy().into_owned();
        environment.set_item(VARIABLE, &folder)?;
        lent.1 = Some(folder);
    }
    lent.0 += 1;
    Ok(())
}

/// The last thread removes the variable, unless other code has changed it.
fn take_back(py: Python<'_>) -> PyResult<()> {
    let mut lent = LENT.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
    lent.0 -= 1;
    if lent.0 > 0 {
        return Ok(());
    }
    let Some(folder) = lent.1.take() else { return Ok(()) };
    let environment = environment(py)?;
    let now: Option<String> = environment.call_method1("get", (VARIABLE,))?.extract()?;
    if now.as_ref() == Some(&folder) { environment.del_item(VARIABLE) } else { Ok(()) }
}
