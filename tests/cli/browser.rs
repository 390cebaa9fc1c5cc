//! The page of a live run and that of the viewer in a real browser, by `tests/readers/check_browser.py`.

use std::path::Path;
use std::process::{Command, Stdio};

/// Names of a browser that the script knows how to drive.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
/// Cells that the colony is watched up to; RELCP_BROWSER_CELLS=1024 for more. With software rendering on a busy machine
/// a state takes seconds, in which the colony doubles.
const CELLS: &str = "64";

fn runs(program: &str) -> bool {
    let tried = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    tried.is_ok_and(|status| status.success())
}

#[test]
fn a_colony_is_watched_and_steered_in_a_browser_and_repeated_to_the_same_bits() {
    let browser = BROWSERS.into_iter().find(|name| runs(name));
    let (Some(browser), true) = (browser, runs("python3")) else {
        println!("SKIP the pages in a browser: needs python3 and one of {}", BROWSERS.join(", "));
        return;
    };
    let place = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers/check_browser.py");
    let cells = std::env::var("RELCP_BROWSER_CELLS").unwrap_or_else(|_| CELLS.into());
    let said = Command::new("python3")
        .arg(script)
        .arg(assert_cmd::cargo::cargo_bin("relcp"))
        .arg(place.path().join("run"))
        .args(["--browser", browser, "--cells", &cells])
        .output()
        .unwrap();
    let (out, err) = (String::from_utf8_lossy(&said.stdout), String::from_utf8_lossy(&said.stderr));
    assert!(said.status.success() && !out.contains("FAIL"), "{}\n{out}\n{err}", said.status);
    assert!(out.matches("\nok  ").count() > 20, "{out}");
    println!("{out}");
}
