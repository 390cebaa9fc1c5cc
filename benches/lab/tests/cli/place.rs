//! A folder of a test's own, and what the program did in it.

use crate::ran::Ran;
use assert_cmd::Command;
use relcp::record::Folder;
use relcp::run::Run;
use relcp::{Scene, Simulation};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// A name that no file of the place has.
pub fn fresh() -> String {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    format!("out-{}", NEXT.fetch_add(1, Ordering::Relaxed))
}

/// A place of its own with a scene, which is no LCP, as `rods.json`.
pub struct Place(pub tempfile::TempDir);

impl Place {
    pub fn new() -> Self {
        let place = Place(tempfile::tempdir().unwrap());
        fs::write(place.at("rods.json"), include_str!("../../../../tests/data/rods.json")).unwrap();
        place
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the program.
    pub fn lab(&self, arguments: &[&str]) -> Ran {
        Ran::of(Command::cargo_bin("relcp-lab").unwrap().current_dir(&self.0).args(arguments))
    }

    /// A run of a scene to its end on the CPU, in a folder of this name.
    pub fn run(&self, scene: Scene, name: &str) {
        let folder = Folder::create(&self.at(name)).unwrap();
        let mut run = Run::start(Simulation::new(scene).unwrap(), folder, Duration::ZERO).unwrap();
        while !run.done() {
            run.advance().unwrap();
        }
        run.finish().unwrap();
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.at(name)).unwrap()).unwrap()
    }
}
