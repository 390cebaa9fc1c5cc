//! Batches that are stopped, or run member by member, end in the same bits.

use super::{Place, SWEEP, states};
use std::fs;
use std::process::Stdio;
use std::time::{Duration, Instant, SystemTime};

/// Members that take long enough to be stopped in the middle.
const LONG: &str = r#"{ "name": "long", "scene": "rods.json", "set": { "time.dt": 0.0001, "output.every": 0.01 },
                        "seeds": [1, 2, 3] }"#;

fn stopped(place: &Place, out: &str, signal: &str) -> (Option<i32>, String) {
    let started = SystemTime::now();
    let child = std::process::Command::new(assert_cmd::cargo::cargo_bin("relcp"))
        .current_dir(&place.0)
        .args(["batch", "sweep.json", "--backend", "cpu", "--jobs", "2", "--out", out])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    // A state of this time, not one that an earlier time left.
    let written = |name: &String| {
        fs::metadata(place.at(out).join(name).join("states/state_0000000500.npz")).ok()?.modified().ok()
    };
    let in_the_middle = |name: &String| written(name).is_some_and(|at| at > started);
    while !place.at(out).is_dir() || !place.folders(out).iter().any(in_the_middle) {
        assert!(begun.elapsed() < Duration::from_secs(600), "the batch does not get on");
        std::thread::sleep(Duration::from_millis(1));
    }
    // The shell's own: bare systems have no program of this name.
    let kill = format!("kill {signal} {}", child.id());
    let sent = std::process::Command::new("sh").args(["-c", &kill]).status().unwrap();
    assert!(sent.success());
    let ended = child.wait_with_output().unwrap();
    (ended.status.code(), String::from_utf8(ended.stderr).unwrap())
}

/// Killed, gone on with, interrupted, gone on with: the same bits as one that was left alone.
#[test]
fn a_stopped_batch_goes_on_to_the_same_bits() {
    let place = Place::new(LONG);
    assert_eq!(stopped(&place, "broken", "-KILL").0, None);
    let (status, err) = stopped(&place, "broken", "-INT");
    assert_eq!(status, Some(130), "{err}");
    assert!(err.contains("stopped; the same command continues"), "{err}");
    let table = place.json("broken/batch.json");
    let status: Vec<&str> =
        table["members"].as_array().unwrap().iter().map(|m| m["status"].as_str().unwrap()).collect();
    assert!(status.contains(&"interrupted") && !status.contains(&"fault"), "{status:?}");
    assert_eq!(place.batch(&["--out", "broken", "--quiet"]).expect(0).out, "");
    place.batch(&["--out", "whole", "--quiet", "--jobs", "1", "--threads", "3"]).expect(0);
    let (whole, broken) = (place.hashes("whole"), place.hashes("broken"));
    assert_eq!((states(&whole), whole.len()), (states(&broken), 3));
}

/// As an array of jobs on a cluster does it; `docs/batch.md` has this line.
#[test]
fn members_one_by_one_come_to_the_same_as_the_whole() {
    let place = Place::new(SWEEP);
    assert_eq!(place.batch(&["--count"]).expect(0).out, "4\n");
    let program = assert_cmd::cargo::cargo_bin("relcp");
    let documented = include_str!("../../docs/batch.md").lines().find(|line| line.contains("xargs -P")).unwrap();
    let script = documented.replace("rates.json", "sweep.json --backend cpu").replace("relcp batch", "\"$0\" batch");
    let ran =
        std::process::Command::new("sh").current_dir(&place.0).args(["-c", &script]).arg(program).output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    assert!(!place.at("runs/press/batch.csv").exists());
    assert!(place.batch(&["--table"]).expect(0).out.contains("done"));
    for jobs in ["1", "2"] {
        place.batch(&["--out", jobs, "--jobs", jobs, "--quiet"]).expect(0);
    }
    let by_one = place.hashes("runs/press");
    for whole in ["1", "2"] {
        assert_eq!(states(&place.hashes(whole)), states(&by_one), "{whole} jobs");
    }
    assert_eq!(by_one.len(), 4);
    let beyond = place.batch(&["--index", "4"]).expect(2);
    assert!(beyond.err.contains("has 4, numbered from 0"), "{}", beyond.err);
    place.batch(&["--index", "1", "--list"]).expect(2);
}
