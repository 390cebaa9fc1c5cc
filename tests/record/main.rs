//! What a run leaves in its folder, and runs that are taken up again from it.
#![allow(clippy::unwrap_used)]

mod branch;
mod changes;
mod killed;
mod lcps;
mod own;
mod runs;
mod steered;

use relcp::run::{Run, Summary};
use std::fs;
use std::path::Path;

/// Takes the run to its end.
fn to_end(mut run: Run) -> Summary {
    while !run.done() {
        run.advance().unwrap();
    }
    run.finish().unwrap()
}

/// `steps.csv` without its last column, the wall time.
fn rows(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("steps.csv")).unwrap();
    text.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned()).collect()
}
