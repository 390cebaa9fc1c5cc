//! A folder of a test's own, and what the program did in it.

use assert_cmd::Command;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

/// Looks, every ten milliseconds, whether something has come. Not for ever, so that a test of what never comes ends.
pub fn comes(mut condition: impl FnMut() -> bool) -> bool {
    (0..60_000).any(|_| {
        let has_come = condition();
        if !has_come {
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        has_come
    })
}

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
        let output = Command::cargo_bin("relcp").unwrap().current_dir(&self.0).args(arguments).output().unwrap();
        Ran {
            status: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
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

#[derive(Debug)]
pub struct Ran {
    pub status: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ran {
    #[track_caller]
    pub fn expect(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "{self:#?}");
        self
    }
}
