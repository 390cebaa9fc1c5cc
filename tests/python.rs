//! The Python package: built by maturin, installed by pip into a folder of its own, and tested by `tests/python`.
//!
//! `RELCP_PYTHON` names a Python with `maturin`, `numpy` and `pip`; without it the test prints `SKIP`, but with
//! `RELCP_REQUIRE_PYTHON=1` `python3` must do. It compiles the dependencies once more, as PyO3 asks for other features
//! of some.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

/// Runs a command in the repository and shows what it says.
fn run(command: &mut Command) {
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    println!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}: {}", output.status);
}

/// The wheel that maturin left.
fn wheel(folder: &Path) -> std::path::PathBuf {
    let mut files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.find(|path| path.extension().is_some_and(|extension| extension == "whl")).unwrap()
}

#[test]
fn the_python_package_does_what_its_tests_ask() {
    let required = std::env::var("RELCP_REQUIRE_PYTHON").is_ok_and(|required| required == "1");
    let python = std::env::var("RELCP_PYTHON").ok().or_else(|| required.then(|| "python3".into()));
    let has = |python: &String| {
        let asked = Command::new(python).args(["-c", "import maturin, numpy, pip"]).output();
        asked.is_ok_and(|output| output.status.success())
    };
    let Some(python) = python.filter(has) else {
        assert!(!required, "RELCP_REQUIRE_PYTHON is set, and there is no Python with maturin, numpy and pip");
        println!("SKIP the Python package: RELCP_PYTHON does not name a Python with maturin, numpy and pip");
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let (wheels, site) = (place.path().join("wheels"), place.path().join("site"));
    run(Command::new(&python).args(["-m", "maturin", "build", "--profile", "python", "--out"]).arg(&wheels));
    let pip = ["-m", "pip", "install", "--quiet", "--no-deps", "--no-index", "--target"];
    run(Command::new(&python).args(pip).arg(&site).arg(wheel(&wheels)));
    run(Command::new(&python)
        .args(["-m", "unittest", "discover", "-v", "-s", "tests/python"])
        .env("PYTHONPATH", &site)
        .env("RELCP_PROGRAM", env!("CARGO_BIN_EXE_relcp")));
}
