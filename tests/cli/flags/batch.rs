//! Flags of `relcp batch`.

use super::{Case, Place, case, compute, fresh, json, ran, shows_json, shows_quiet, threads, tiny};
use std::fs;

pub const CASES: &[Case] = &[
    case("batch", "--out", out),
    case("batch", "--jobs", jobs),
    case("batch", "--retry", retry),
    case("batch", "--index", index),
    case("batch", "--count", count),
    case("batch", "--list", list),
    case("batch", "--table", table),
    case("batch", "--backend", compute::shows_backend),
    case("batch", "--adapter", compute::shows_adapter),
    case("batch", "--precision", compute::shows_precision),
    case("batch", "--threads", threads::shows),
    case("batch", "--json", shows_json),
    case("batch", "--quiet", shows_quiet),
];

/// A tiny batch with more words: what it printed, and the files that it left, by their names.
fn left(place: &Place, more: &[&str]) -> (String, Vec<String>) {
    let out = fresh();
    let words = tiny(place, "batch", &out);
    let words: Vec<&str> = words.iter().map(String::as_str).chain(more.iter().copied()).collect();
    let printed = place.relcp(&words).expect(0).out;
    let names = fs::read_dir(place.at(&out)).into_iter().flatten();
    let mut names: Vec<String> = names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    (printed, names)
}

fn out(place: &Place, command: &str) {
    let (_, names) = left(place, &[]);
    assert_eq!(names.len(), 4, "{names:?}");
    assert!(names[0].starts_with("0000-") && names[2..] == ["batch.csv", "batch.json"], "{names:?}");
    assert!(!place.at("runs").exists(), "{command}");
    place.relcp(&["batch", "sweep.json", "--quiet"]).expect(0);
    assert!(place.at("runs/ends/batch.csv").is_file());
}

/// Of members that take a while, the second is begun before the first has ended, or not.
fn jobs(place: &Place, _: &str) {
    let sweep =
        r#"{"name": "long", "scene": "rods.json", "set": {"time.dt": 0.001}, "grid": {"time.end": [0.6, 0.7]}}"#;
    fs::write(place.at("long.json"), sweep).unwrap();
    let together = |jobs: &str| {
        let words = ["batch", "long.json", "--backend", "cpu", "--log", "info", "--jobs", jobs, "--out", &fresh()];
        let err = place.relcp(&words).expect(0).err;
        let line = |said: &str| err.lines().position(|line| line.contains(said)).unwrap_or_else(|| panic!("{err}"));
        line("state of step 0 into").max(line("/0001-")) < line("1 of 2: ")
    };
    assert!(!together("1"));
    assert!(together("2"));
    ran(place, "batch", &["--jobs", "0"]).expect(2);
}

/// A body so light that its velocity is no number.
const STOPS: &str = r#"{ "name": "stops", "time": { "dt": 1e50, "end": 5e50 },
  "dynamics": { "inertial": { "density": 1e-60 } }, "contact": { "overlap_tolerance": 1e-50 },
  "forces": [ { "uniform": { "force": [1e50, 0, 0] } } ],
  "bodies": [ { "shape": { "sphere": { "radius": 1e-40 } }, "position": [0, 0, 0] } ] }"#;

fn retry(place: &Place, _: &str) {
    fs::write(place.at("stops.json"), STOPS).unwrap();
    fs::write(place.at("stop.json"), r#"{"name": "stop", "scene": "stops.json"}"#).unwrap();
    let out = fresh();
    let batch = ["batch", "stop.json", "--backend", "cpu", "--out", &out];
    let tried = "stopped: step 1";
    assert!(place.relcp(&batch).expect(3).err.contains(tried));
    let left_alone = place.relcp(&batch).expect(3).err;
    assert!(left_alone.contains("stopped earlier") && !left_alone.contains(tried), "{left_alone}");
    assert!(place.relcp(&[&batch[..], &["--retry"]].concat()).expect(3).err.contains(tried));
}

fn index(place: &Place, _: &str) {
    let (_, names) = left(place, &["--index", "1"]);
    assert!(names.len() == 1 && names[0].starts_with("0001-"), "{names:?}");
    ran(place, "batch", &["--index", "2"]).expect(2);
}

fn count(place: &Place, _: &str) {
    assert_eq!(left(place, &["--count"]), ("2\n".into(), Vec::new()));
}

fn list(place: &Place, _: &str) {
    let (printed, names) = left(place, &["--list"]);
    assert!(printed.lines().count() == 2 && names.is_empty(), "{printed}{names:?}");
    assert!(printed.contains("/0000-") && printed.contains("time.end=0.06"), "{printed}");
}

fn table(place: &Place, _: &str) {
    let (printed, names) = left(place, &["--table"]);
    assert!(printed.contains("missing") && names == ["batch.csv", "batch.json"], "{printed}{names:?}");
    assert_eq!(json(place, "batch", &["--table"])["members"][1]["status"], "missing");
}
