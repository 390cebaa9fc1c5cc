//! Runs that are killed at any moment (`kill -9`) and taken up again end in the same bits as one that was left alone.
//! `RELCP_KILLS=20` kills each of them so many times in place of a few.

use assert_cmd::cargo::cargo_bin;
use rand::{RngExt, SeedableRng};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Kills of one scene, without `RELCP_KILLS`.
const KILLS: usize = 3;

const COLONY: [&str; 2] = ["colony", "time.end=4.3"];
const COMPACTION: [&str; 2] = ["compaction", "time.end=12"];
const SHEARED: [&str; 2] = ["sheared.json", "time.end=3"];
const BONDED: [&str; 2] = ["chaining", "time.end=2"];
const ROUGH: [&str; 2] = ["pile", "time.end=1"];

/// A suspension in a sheared cell, with Brownian motion.
const SUSPENSION: &str = r#"{"name": "sheared", "seed": 5, "planar": true, "time": {"dt": 0.01, "end": 3},
    "periodic": {"lengths": [16, 14, null], "shear": {"rate": 1.0, "direction": "x", "gradient": "y"}},
    "generate": [{"isotropic": {"count": 54, "shape": {"spherocylinder": {"diameter": 1, "length": 2}}}}],
    "dynamics": {"overdamped": {"drag": 1}}, "thermal": {"temperature": 0.01}}"#;

fn relcp(place: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(cargo_bin("relcp"));
    command.current_dir(place).args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn hash(folder: &Path) -> String {
    let summary: Value = serde_json::from_slice(&std::fs::read(folder.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["status"], "done");
    summary["state_hash"].as_str().unwrap().to_owned()
}

fn start(place: &Path, [scene, end]: [&str; 2], folder: &str) -> Command {
    let shared = ["run", scene, "--backend", "cpu", "--quiet", "--checkpoint-every", "0.05"];
    let mut command = relcp(place, &shared);
    command.args(["--set", end, "--set", "output.every=0.5", "--out", folder]);
    command
}

fn killed_and_resumed(scene: [&str; 2], seed: u64) {
    let kills = std::env::var("RELCP_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(KILLS);
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join(SHEARED[0]), SUSPENSION).unwrap();
    let begun = Instant::now();
    assert!(start(place.path(), scene, "whole").status().unwrap().success());
    let (whole, expected) = (begun.elapsed(), hash(&place.path().join("whole")));
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let (mut taken_up, mut begun_again) = (0, 0);
    for kill in 0..kills {
        let name = format!("killed-{kill}");
        let folder = place.path().join(&name);
        let mut child = start(place.path(), scene, &name).spawn().unwrap();
        std::thread::sleep(whole.mul_f64(random.random::<f64>()));
        child.kill().unwrap();
        child.wait().unwrap();
        // Killed before there was a checkpoint, it begins again.
        if folder.join("checkpoint.npz").exists() {
            taken_up += 1;
            let again =
                relcp(place.path(), &["run", "--resume", "--backend", "cpu", "--quiet", "--out", &name]).status();
            assert_eq!(again.unwrap().code(), Some(0), "kill {kill}");
        } else {
            begun_again += 1;
            let _ = std::fs::remove_dir_all(&folder);
            assert!(start(place.path(), scene, &name).status().unwrap().success());
        }
        assert_eq!(hash(&folder), expected, "kill {kill}");
        let steps = std::fs::read_to_string(folder.join("steps.csv")).unwrap();
        assert_eq!(steps, without_times(&steps, &place.path().join("whole/steps.csv")), "kill {kill}");
        let _ = std::fs::remove_dir_all(&folder);
    }
    println!("{}: {taken_up} taken up, {begun_again} begun again", scene[0]);
    assert!(taken_up > 0, "every kill came too early: {:?} for the whole run", whole);
}

/// The steps of the whole run with the wall times of these.
fn without_times(these: &str, whole: &Path) -> String {
    let whole = std::fs::read_to_string(whole).unwrap();
    let line = |(ours, theirs): (&str, &str)| {
        let (steps, _) = theirs.rsplit_once(',').unwrap();
        let (_, time) = ours.rsplit_once(',').unwrap();
        format!("{steps},{time}\n")
    };
    assert_eq!(these.lines().count(), whole.lines().count());
    these.lines().zip(whole.lines()).map(line).collect()
}

#[test]
fn a_growing_colony() {
    killed_and_resumed(COLONY, 1);
}

#[test]
fn a_compaction() {
    killed_and_resumed(COMPACTION, 2);
}

#[test]
fn a_sheared_suspension() {
    killed_and_resumed(SHEARED, 3);
}

#[test]
fn chains_of_cells() {
    killed_and_resumed(BONDED, 4);
}

#[test]
fn a_heap_with_friction() {
    killed_and_resumed(ROUGH, 5);
}
