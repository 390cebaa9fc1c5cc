//! A folder of a test's own, and what the program did in it.

use crate::ran::Ran;
use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

/// A place of its own with the scene of two rods that are pushed together over 60 steps, as `rods.json`.
pub struct Place(pub tempfile::TempDir);

impl Place {
    pub fn new() -> Self {
        let place = Place(tempfile::tempdir().unwrap());
        fs::write(place.at("rods.json"), include_str!("../data/rods.json")).unwrap();
        place
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn relcp(&self, arguments: &[&str]) -> Ran {
        Ran::of(Command::cargo_bin("relcp").unwrap().current_dir(&self.0).args(arguments))
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.at(name)).unwrap()).unwrap()
    }
}

/// Sends a signal by the shell's own `kill`: bare systems have no program of this name.
#[cfg(unix)]
pub fn signal(child: &std::process::Child, signal: &str) {
    let kill = format!("kill {signal} {}", child.id());
    assert!(std::process::Command::new("sh").args(["-c", &kill]).status().unwrap().success());
}
