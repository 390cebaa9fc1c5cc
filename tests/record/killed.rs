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
const FED: [&str; 2] = ["fed.json", "time.end=6"];
const ELLIPSOIDS: [&str; 2] = ["ellipsoids.json", "time.end=5"];
const HEAVY: [&str; 2] = ["heavy.json", "time.end=4"];

/// Cells in a viscous fluid that grow by a field, die, and are pressed by a wall with drag that moves sideways.
const CULTURE: &str = r#"{"name": "fed", "seed": 3, "planar": true, "time": {"dt": 0.004, "end": 6},
    "dynamics": {"overdamped": {"drag": {"viscosity": 0.3}}}, "periodic": {"lengths": [16, null, null]},
    "walls": [{"half_space": {"normal": [0, 1, 0], "offset": 0}}, {"half_space": {"normal": [0, -1, 0], "offset": -14,
        "load": {"pressure": 0.5, "drag": 20}, "motion": {"velocity": [0.2, 0, 0]}}}],
    "fields": {"food": {"cells": [16, 14, 1], "spacing": 1, "center": [0, 7, 0], "diffusion": 3, "initial": 1,
        "held": [{"inside": {"box": {"minimum": [-2, 12, -1], "maximum": [2, 14, 1]}}, "value": 1}],
        "exchange": [{"uptake": 1, "half": 0.2}]}},
    "growth": {"group": "cells", "rate": 1, "rate_noise": 0.1, "division_length": 2, "reorientation_degrees": 10,
        "nutrient": {"field": "food", "half": 0.2}},
    "removal": [{"rate": 0.15, "group": "cells"}],
    "generate": [{"founder": {"length": 1.5, "diameter": 0.6, "angle": 30, "position": [-6, 2, 0], "group": "cells",
            "repeat": [{"count": 4, "offset": [4, 0, 0]}]}},
        {"lattice": {"kind": "square", "shape": {"sphere": {"radius": 0.4}}, "spacing": 2, "counts": [8, 2, 1],
            "center": [0, 6, 0], "group": "balls"}}]}"#;

/// Ellipsoids that grow by a field and slow down under pressure, in a round container.
const ROUND: &str = r#"{"name": "ellipsoids", "seed": 3, "planar": true, "time": {"dt": 0.004, "end": 5},
    "dynamics": {"overdamped": {"drag": {"viscosity": 0.3}}},
    "walls": [{"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 4}}],
    "fields": {"food": {"cells": [8, 8, 1], "spacing": 1, "diffusion": 3, "initial": 1,
        "exchange": [{"uptake": 0.3, "half": 0.2}], "boundary": {"x": [{"value": 1}, "closed"]}}},
    "growth": {"shape": "ellipsoid", "rate": 1, "rate_noise": 0.1, "division_length": 2, "reorientation_degrees": 10,
        "nutrient": {"field": "food", "half": 0.2}, "stress_sensitivity": 0.1, "on_no_room": "stall"},
    "bodies": [{"shape": {"ellipsoid": {"radii": [0.35, 0.35, 0.7]}}, "position": [1, 0, 0], "angle": 20}]}"#;

/// Bodies with inertia that drag along their axes slows, under a wall with a mass.
const PRESS: &str = r#"{"name": "heavy", "seed": 3, "time": {"dt": 0.004, "end": 4},
    "dynamics": {"inertial": {"density": 1, "drag": {"parallel": 0.1, "perpendicular": 0.3}}},
    "walls": [{"box": {"minimum": [-3, -3, 0], "maximum": [3, 3, 12]}},
        {"half_space": {"normal": [0, 0, -1], "offset": -11, "load": {"force": 30, "mass": 20, "velocity": 0.2}}}],
    "fields": {"heat": {"cells": [6, 6, 12], "spacing": 1, "center": [0, 0, 6], "diffusion": 0.5,
        "exchange": [{"secretion": 1}]}},
    "forces": [{"gravity": {"acceleration": [0, 0, -3]}}],
    "generate": [{"isotropic": {"count": 40, "shape": {"ellipsoid": {"radii": [0.5, 0.5, 0.8]}},
        "mixture": [{"count": 20, "shape": {"spherocylinder": {"diameter": 0.6, "length": 1.5}}}]}}]}"#;

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
    for ([file, _], text) in [(SHEARED, SUSPENSION), (FED, CULTURE), (ELLIPSOIDS, ROUND), (HEAVY, PRESS)] {
        std::fs::write(place.path().join(file), text).unwrap();
    }
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

#[test]
fn cells_that_feed_under_a_loaded_wall() {
    killed_and_resumed(FED, 6);
}

#[test]
fn bodies_with_drag_by_axis_under_a_heavy_wall() {
    killed_and_resumed(HEAVY, 7);
}

#[test]
fn ellipsoids_that_grow_in_a_round_container() {
    killed_and_resumed(ELLIPSOIDS, 8);
}
