//! Which run `relcp run --resume` goes on with. Each test is named by its symptom.

use super::place::Place;
use std::fs;

/// A run of the two rods that is stopped after a step.
fn stopped(place: &Place, more: &[&str]) {
    let run = ["run", "rods.json", "--quiet", "--max-wall", "0"];
    place.relcp(&[&run[..], more].concat()).expect(130);
}

#[test]
fn resume_alone_takes_the_newest_unfinished_run_and_says_which() {
    let place = Place::new();
    let none = place.relcp(&["run", "--resume"]).expect(2).err;
    assert!(none.contains("no run to resume in runs") && none.contains("--out DIR"), "{none}");
    stopped(&place, &["--set", "name=first"]);
    stopped(&place, &["--set", "name=second"]);
    place.relcp(&["run", "rods.json", "--quiet"]).expect(0);
    let err = place.relcp(&["run", "--resume"]).expect(0).err;
    assert!(err.contains("resuming runs/second, the newest of 2 unfinished runs in runs"), "{err}");
    assert_eq!(place.json("runs/second/summary.json")["status"], "done");
    let err = place.relcp(&["run", "--resume"]).expect(0).err;
    assert!(err.contains("resuming runs/first\n"), "{err}");
    let err = place.relcp(&["run", "--resume"]).expect(2).err;
    assert!(err.contains("3 runs have ended") && err.contains("--until"), "{err}");
    let err = place.relcp(&["run", "--resume", "--until", "2"]).expect(0).err;
    assert!(err.contains("resuming runs/first\n"), "{err}");
}

#[test]
fn a_stopped_run_with_settings_of_its_own_goes_on_with_them_and_says_so() {
    let place = Place::new();
    let sets = ["--set", "growth.rate=0.9", "--set", "time.end=0.05", "--quiet", "--max-wall", "0"];
    place.relcp(&[&["run", "colony"], &sets[..]].concat()).expect(130);
    let err = place.relcp(&["run", "colony", "--resume"]).expect(0).err;
    let says = "resuming runs/colony, with its own settings: it differs from colony in growth.rate, time.end";
    assert!(err.contains(says), "{err}");
    let scene = place.json("runs/colony/scene.json");
    assert_eq!((scene["growth"]["rate"].as_f64(), scene["time"]["end"].as_f64()), (Some(0.9), Some(0.05)));
}

#[test]
fn other_settings_than_those_asked_for_are_refused_with_the_exact_command() {
    let place = Place::new();
    stopped(&place, &["--set", "seed=7"]);
    for more in [&[][..], &["--set", "seed=8"]] {
        let refused = place.relcp(&[&["run", "rods.json", "--resume"], more].concat()).expect(2).err;
        let refused = refused.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert!(refused.contains("seed") && refused.contains("relcp run --resume --out runs/rods"), "{refused}");
    }
    place.relcp(&["run", "rods.json", "--resume", "--set", "seed=7", "--quiet"]).expect(0);
}

#[test]
fn of_several_runs_of_a_scene_the_one_with_these_settings_goes_on() {
    let place = Place::new();
    stopped(&place, &[]);
    stopped(&place, &["--set", "seed=7"]);
    let err = place.relcp(&["run", "rods.json", "--resume"]).expect(0).err;
    assert!(err.contains("resuming runs/rods\n"), "{err}");
    assert_eq!(place.json("runs/rods-2/summary.json")["status"], "interrupted");
}

/// A limit of a file's size, as a full disk, ends the run with a message, and `steps.csv` with a whole row.
#[test]
#[cfg(target_os = "linux")]
fn a_file_that_cannot_grow_is_a_message_and_ends_with_a_whole_row() {
    let place = Place::new();
    let script = "ulimit -f 8; exec \"$0\" run rods.json --set time.end=20 --set output.picture=false --out run";
    let program = assert_cmd::cargo::cargo_bin("relcp");
    let mut shell = std::process::Command::new("sh");
    let ran = shell.current_dir(&place.0).args(["-c", script]).arg(program).output().unwrap();
    let err = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(4), "{err}");
    assert!(err.contains("File too large"), "{err}");
    let rows = fs::read_to_string(place.at("run/steps.csv")).unwrap();
    let columns = rows.lines().next().unwrap().split(',').count();
    assert!(rows.ends_with('\n') && rows.lines().all(|row| row.split(',').count() == columns), "{rows}");
}

#[test]
fn a_run_whose_checkpoints_are_damaged_is_refused_with_the_command_that_starts_from_its_last_state() {
    let place = Place::new();
    stopped(&place, &["--set", "name=cut"]);
    for name in ["checkpoint.npz", "checkpoint.previous.npz"] {
        let file = place.at(&format!("runs/cut/{name}"));
        if let Ok(bytes) = fs::read(&file) {
            fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        }
    }
    let err = place.relcp(&["run", "--resume", "--out", "runs/cut"]).expect(4).err;
    let said = err.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("truncated") && said.contains("relcp run --from runs/cut"), "{err}");
    place.relcp(&["run", "--from", "runs/cut", "--quiet"]).expect(0);
}
