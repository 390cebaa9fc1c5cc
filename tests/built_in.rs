//! Every built-in scene, to its end: that it gets there, that no step throws a body, and what it came to. The paper's
//! sizes (`*-full`) are left out.
//!
//! Those that take seconds are run by each `cargo test`; `RELCP_ALL_SCENES=1` runs the others too, which takes some
//! minutes in all, and `RELCP_SEEDS=1,2,3` runs each with these seeds in the place of its own:
//!
//! ```sh
//! RELCP_ALL_SCENES=1 RELCP_SEEDS=1,2,3 cargo test --test built_in -- --nocapture
//! ```
#![allow(clippy::unwrap_used)]

use glam::DVec3;
use relcp::scene::BuiltIn;
use relcp::{Bodies, Scene, Simulation};
use std::collections::HashMap;
use std::time::Instant;

/// Scenes that take less than ten seconds each in the profile of the tests.
const QUICK: [&str; 12] = [
    "two-ellipsoids",
    "three-capsules",
    "chainmail",
    "filament",
    "piston",
    "mother-machine",
    "ladder",
    "silo",
    "biofilm",
    "pressed-ring",
    "bidisperse-packing",
    "mother-machine-array",
];

/// The others.
const LONG: [&str; 12] = [
    "compaction",
    "colony",
    "active-nematic",
    "sedimentation",
    "two-strains",
    "swarm",
    "pile",
    "drum",
    "rough-channel",
    "chaining",
    "shear-cell",
    "dice",
];

/// A body goes less than this in a step, in lengths of the longest.
const MOST_MOVE: f64 = 1.0;

/// What a run came to.
#[derive(Debug)]
struct Ran {
    name: String,
    seed: u64,
    status: String,
    steps: u64,
    bodies: usize,
    /// The largest move in a step of a body that stayed, in lengths of the longest.
    largest_move: f64,
    moved_in_step: u64,
    removed: u64,
    /// The most that left in one step.
    most_leaving: usize,
    seconds: f64,
}

impl Ran {
    fn is_well(&self) -> bool {
        self.status == "done" && self.largest_move <= MOST_MOVE
    }

    fn to_line(&self) -> String {
        format!(
            "{:<16} seed {:<3} {} after {} steps, {} bodies, largest move {:.3} lengths in step {}, {} left, {} at most in a step, {:.1} s",
            self.name,
            self.seed,
            self.status,
            self.steps,
            self.bodies,
            self.largest_move,
            self.moved_in_step,
            self.removed,
            self.most_leaving,
            self.seconds
        )
    }
}

/// The farthest that a body went that is there before and after, in lengths of the longest.
fn farthest(before: &Bodies, after: &Bodies) -> f64 {
    let old: HashMap<u64, DVec3> = before.lineage.iter().zip(&before.position).map(|(line, x)| (line.id, *x)).collect();
    let way = |i: usize| old.get(&after.lineage[i].id).map_or(0.0, |x| (after.position[i] - *x).length());
    let longest = after.shape.iter().map(|shape| shape.major_axis()).fold(0.0, f64::max);
    let ways = (0..after.len()).map(way);
    if after.is_empty() { 0.0 } else { ways.fold(0.0, f64::max) / longest }
}

fn run(name: &str, seed: Option<u64>) -> Ran {
    let mut scene = Scene::built_in(name).unwrap();
    scene.seed = seed.unwrap_or(scene.seed);
    let (begun, seed) = (Instant::now(), scene.seed);
    let mut simulation = Simulation::new(scene).unwrap();
    let mut before = simulation.state().unwrap().bodies.clone();
    let mut ran = Ran {
        name: name.into(),
        seed,
        status: "done".into(),
        steps: 0,
        bodies: before.len(),
        largest_move: 0.0,
        moved_in_step: 0,
        removed: 0,
        most_leaving: 0,
        seconds: 0.0,
    };
    while !simulation.done() {
        let report = match simulation.step() {
            Ok(report) => report,
            Err(fault) => {
                ran.status = format!("stopped: {fault}");
                break;
            }
        };
        let after = &simulation.state().unwrap().bodies;
        let way = farthest(&before, after);
        if way > ran.largest_move {
            (ran.largest_move, ran.moved_in_step) = (way, report.step);
        }
        ran.most_leaving = ran.most_leaving.max(report.removed);
        before.clone_from(after);
    }
    (ran.steps, ran.bodies, ran.removed) = (simulation.steps(), simulation.bodies(), simulation.removed());
    ran.seconds = begun.elapsed().as_secs_f64();
    ran
}

/// The seeds that the environment names; none for each scene's own.
fn seeds() -> Vec<Option<u64>> {
    match std::env::var("RELCP_SEEDS") {
        Ok(text) => text.split(',').map(|seed| Some(seed.trim().parse().unwrap())).collect(),
        Err(_) => vec![None],
    }
}

/// Runs scenes one after another, and fails with all that are not well.
fn run_all(names: &[&str]) {
    let mut bad = Vec::new();
    for name in names {
        for seed in seeds() {
            let ran = run(name, seed);
            println!("{}", ran.to_line());
            if !ran.is_well() {
                bad.push(ran.to_line());
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn quick_built_in_scenes_run_to_their_end_and_throw_nobody() {
    run_all(&QUICK);
}

#[test]
fn long_built_in_scenes_run_to_their_end_and_throw_nobody() {
    if std::env::var_os("RELCP_ALL_SCENES").is_none() {
        println!("SKIP: RELCP_ALL_SCENES=1 runs {}", LONG.join(", "));
        return;
    }
    run_all(&LONG);
}

#[test]
fn every_built_in_scene_is_run() {
    let all = BuiltIn::ALL.iter().map(|scene| scene.name).filter(|name| !name.ends_with("-full"));
    let missing: Vec<&str> = all.filter(|name| !QUICK.contains(name) && !LONG.contains(name)).collect();
    assert_eq!(missing, [""; 0]);
}
