//! Batches: what a sweep file means, and `relcp batch` from outside.
#![allow(clippy::unwrap_used)]

mod folders;
mod plan;
#[path = "../common/ran.rs"]
mod ran;
#[cfg(unix)]
mod resumed;
mod statuses;

use crate::ran::Ran;
use assert_cmd::Command;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::time::SystemTime;

/// A place of its own with the scene of two rods that are pushed together, as `rods.json`, and a sweep of ten steps
/// each.
struct Place(tempfile::TempDir);

const SWEEP: &str = r#"{ "name": "press", "scene": "rods.json", "set": { "time.end": 0.2 },
                         "grid": { "forces.0.uniform.force.2": [-1, -2] }, "seeds": [1, 2] }"#;

impl Place {
    fn new(sweep: &str) -> Self {
        let place = Place(tempfile::tempdir().unwrap());
        fs::write(place.at("rods.json"), include_str!("../data/rods.json")).unwrap();
        fs::write(place.at("sweep.json"), sweep).unwrap();
        place
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `relcp batch sweep.json` and these.
    fn batch(&self, arguments: &[&str]) -> Ran {
        let mut command = Command::cargo_bin("relcp").unwrap();
        command.current_dir(&self.0).args(["batch", "sweep.json", "--backend", "cpu"]);
        Ran::of(command.args(arguments))
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.at(name)).unwrap()).unwrap()
    }

    /// The folders of a batch's members.
    fn folders(&self, out: &str) -> Vec<String> {
        let entries = fs::read_dir(self.at(out)).unwrap().map(|entry| entry.unwrap());
        let folders = entries.filter(|entry| entry.file_type().unwrap().is_dir());
        let mut names: Vec<String> = folders.map(|entry| entry.file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Of each member's folder, the hash of the state and when the summary was written.
    fn hashes(&self, out: &str) -> BTreeMap<String, (Value, SystemTime)> {
        let of = |name: String| {
            let path = format!("{out}/{name}/summary.json");
            let written = fs::metadata(self.at(&path)).unwrap().modified().unwrap();
            (name, (self.json(&path)["state_hash"].clone(), written))
        };
        self.folders(out).into_iter().map(of).collect()
    }
}

fn states(hashes: &BTreeMap<String, (Value, SystemTime)>) -> Vec<(&String, &Value)> {
    hashes.iter().map(|(name, (hash, _))| (name, hash)).collect()
}
