//! `relcp measure` from outside, on runs made by the program itself.
#![allow(clippy::unwrap_used)]

#[path = "common/program.rs"]
mod program;

use program::relcp;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// A colony from one cell to eight, in eleven states.
fn colony(folder: &Path) {
    colony_to(folder, "run", "2.5", false);
}

/// The same to time `end`, whose states may hold contact forces.
fn colony_to(folder: &Path, run: &str, end: &str, forces: bool) {
    let (end, forces) = (format!("time.end={end}"), format!("output.forces={forces}"));
    let sets = ["time.dt=0.02", &end, "growth.reorientation_degrees=20", "output.every=0.25", &forces];
    let mut arguments = vec!["run", "colony", "--out", run, "--quiet", "--backend", "cpu"];
    arguments.extend(sets.iter().flat_map(|set| ["--set", set]));
    relcp(folder, &arguments, 0);
}

/// The rows of a table by column; an empty cell is none.
fn table(path: &Path) -> Vec<BTreeMap<String, Option<f64>>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let row = |row: csv::StringRecord| {
        let cells = row.iter().map(|cell| (!cell.is_empty()).then(|| cell.parse().unwrap()));
        header.iter().map(String::from).zip(cells).collect()
    };
    reader.records().map(|record| row(record.unwrap())).collect()
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(&path).unwrap())).collect()
}

#[test]
fn a_run_is_measured_into_its_folder() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path());
    let (out, err) = relcp(place.path(), &["measure", "run", "--threads", "1"], 0);
    assert!(out.starts_with("11 states; the last, of 8 bodies at time 2.5:") && err.is_empty(), "{out}{err}");
    assert!(
        out.contains("note: stress: the state has no contact forces: only a checkpoint has, and states of a run with output.forces (10 of 11 states)"),
        "{out}"
    );
    let folder = place.path().join("run/measures");
    let rows = table(&folder.join("measures.csv"));
    assert_eq!(rows.len(), 11);
    // What the program says elsewhere of the same states.
    let (contacts, _) = relcp(place.path(), &["contacts", "run", "--cutoff", "0.0005", "--json"], 0);
    let contacts: Value = serde_json::from_str(&contacts).unwrap();
    let last = &rows[10];
    assert_eq!(last["touching"], Some(contacts["contacts"].as_array().unwrap().len() as f64));
    let end: Value = serde_json::from_slice(&fs::read(place.path().join("run/final.json")).unwrap()).unwrap();
    let bodies = end["bodies"].as_array().unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let centre = [0, 1].map(|k| bodies.iter().map(|body| number(&body["position"][k])).sum::<f64>() / 8.0);
    let squares = bodies.iter().flat_map(|body| [0, 1].map(|k| (number(&body["position"][k]) - centre[k]).powi(2)));
    let gyration = (squares.sum::<f64>() / 8.0).sqrt();
    assert!((last["radius_gyration"].unwrap() - gyration).abs() < 1e-12);
    let lengths = bodies.iter().map(|body| number(&body["shape"]["spherocylinder"]["length"]));
    assert!((last["length_mean"].unwrap() - lengths.sum::<f64>() / 8.0).abs() < 1e-12);
    // The first state is one cell: of what it has no more than one of, there is nothing.
    let first = &rows[0];
    for column in
        ["nematic_local", "correlation_length", "packing_core", "pushing", "pressure", "chains", "dissipation"]
    {
        assert_eq!(first[column], None, "{column}");
    }
    assert!((first["packing_hull"].unwrap() - 1.0).abs() < 1e-6);
    // A colony that grows is pressed, and expands.
    assert!(last["pressure"].unwrap() > 0.0 && last["pushing"].unwrap() > 0.0 && last["dissipation"].unwrap() > 0.0);
    assert!(last["stress_zz"].is_none() && rows[9]["pressure"].is_none());
    assert!(rows.iter().all(|row| row["expansion_rate"].unwrap() > 0.0 && row["packing_hull"].unwrap() < 1.0 + 1e-6));
    let forces = table(&folder.join("stress.csv"));
    assert!(forces.iter().all(|row| row["step"] == Some(125.0)));
}

#[test]
fn the_files_are_the_same_for_any_number_of_threads_and_those_not_made_again_go() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path());
    relcp(place.path(), &["measure", "run", "--threads", "1", "--quiet"], 0);
    let one = files(&place.path().join("run/measures"));
    let (json, _) = relcp(place.path(), &["measure", "run", "--threads", "3", "--json"], 0);
    let three = files(&place.path().join("run/measures"));
    assert_eq!(one, three);
    let printed: Value = serde_json::from_str(&json).unwrap();
    let written: Value = serde_json::from_slice(&three["measures.json"]).unwrap();
    for key in ["frame", "settings", "notes", "measures", "states"] {
        assert_eq!(printed[key], written[key]);
    }
    assert_eq!(written["frame"]["planar"], true);
    assert!(written["frame"]["planar_from"].as_str().unwrap().ends_with("scene.json"));
    let state = &written["states"][0];
    assert_eq!(state["values"]["pressure"], Value::Null);
    assert!(state["remarks"]["stress"].as_str().unwrap().contains("only a checkpoint"));
    assert!(written["states"][10]["profiles"]["correlation"].as_array().unwrap().len() > 2);
    assert_eq!(printed["files"].as_array().unwrap().len(), three.len());
    let plots = three.iter().filter(|(name, _)| name.ends_with(".svg"));
    assert!(plots.clone().count() > 10);
    for (name, bytes) in plots {
        let text = std::str::from_utf8(bytes).unwrap();
        assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"), "{name}");
        // A curve has lines of its width or a pale one's, unlike axes and ticks; or the dot of a single point; or bars.
        let marks = ["stroke-width=\"12\"", "stroke-width=\"6\"", "Q", "fill=\"#0072b2\""];
        assert!(marks.iter().any(|mark| text.contains(mark)), "{name}");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{name}");
    }
    fs::write(place.path().join("run/measures/mine.svg"), b"note").unwrap();
    relcp(place.path(), &["measure", "run", "--only", "radius", "--last", "--quiet"], 0);
    let left: Vec<String> = files(&place.path().join("run/measures")).into_keys().collect();
    assert_eq!(left, ["measures.csv", "measures.json", "mine.svg"]);
    let rows = table(&place.path().join("run/measures/measures.csv"));
    assert_eq!((rows.len(), rows[0]["bodies"], rows[0].len()), (1, Some(8.0), 6));
}

#[test]
fn states_and_scenes_are_measured_too() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path());
    let last = "run/states/state_0000000125.npz";
    let (out, _) = relcp(place.path(), &["measure", last, "--json", "--domain-angle", "10", "--neighbourhood", "5"], 0);
    let document: Value = serde_json::from_str(&out).unwrap();
    assert!(document["frame"]["planar_from"].as_str().unwrap().ends_with("scene.json"));
    assert_eq!(document["folder"], "state_0000000125-measures");
    let values = &document["states"][0]["values"];
    assert_eq!((&values["domain_angle_degrees"], &values["nematic_local_radius"]), (&10.0.into(), &5.0.into()));
    // Away from its run the state alone says that it is planar, and knows no drag.
    fs::copy(place.path().join(last), place.path().join("alone.npz")).unwrap();
    let (out, _) = relcp(place.path(), &["measure", "alone.npz", "--json"], 0);
    let alone: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&alone["frame"]["planar"], &alone["frame"]["drag"]), (&true.into(), &Value::Null));
    assert_eq!(alone["states"][0]["values"]["packing_hull"], values["packing_hull"]);
    let (out, _) = relcp(place.path(), &["measure", "alone.npz", "--only", "length,radius", "--json"], 0);
    let two: Value = serde_json::from_str(&out).unwrap();
    let names: Vec<_> = two["measures"].as_array().unwrap().iter().map(|measure| &measure["name"]).collect();
    assert_eq!(names, ["radius", "length"]);
    let (out, _) = relcp(place.path(), &["measure", "two-ellipsoids", "--json"], 0);
    let scene: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(scene["frame"]["planar"], false);
    assert_eq!(scene["states"][0]["values"]["length_mean"], Value::Null);
}

#[test]
fn figures_are_made_in_the_formats_that_are_asked_for() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path());
    let names = |figures: &str| {
        relcp(place.path(), &["measure", "run", "--only", "radius", "--figures", figures, "--quiet"], 0);
        files(&place.path().join("run/measures"))
    };
    let all = names("svg,pdf,png");
    let begins = |name: &str, start: &[u8]| all[name].starts_with(start);
    assert!(begins("radius_gyration.svg", b"<svg") && begins("radius_gyration.pdf", b"%PDF"), "{:?}", all.keys());
    assert!(begins("radius_gyration.png", b"\x89PNG"));
    // What is not asked for is not left there.
    let one = names("pdf");
    assert!(one.contains_key("radius_gyration.pdf") && one.keys().all(|name| !name.ends_with("g")), "{:?}", one.keys());
}

#[test]
fn what_cannot_be_measured_is_said() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path());
    fs::create_dir(place.path().join("empty")).unwrap();
    fs::write(place.path().join("text.npz"), b"a text").unwrap();
    for (arguments, status, said) in [
        (&["measure"] as &[&str], 2, "RUN"),
        (&["measure", "run", "--only", "colour"], 2, "the measures are"),
        (&["measure", "run", "--bin", "0"], 2, "not above zero"),
        (&["measure", "run", "--bin", "nan"], 2, "finite"),
        (&["measure", "empty"], 4, "no state to measure"),
        (&["measure", "no-such-run"], 2, "no-such-run"),
        (&["measure", "text.npz"], 4, "not a state file"),
        (&["measure", "run", "--out", "run/scene.json"], 4, "scene.json"),
    ] {
        let (out, err) = relcp(place.path(), arguments, status);
        assert!(out.is_empty() && err.contains(said), "{arguments:?}: {out}{err}");
    }
    assert!(!place.path().join("run/measures").exists());
    let state = place.path().join("run/states/state_0000000025.npz");
    let mut bytes = fs::read(&state).unwrap();
    bytes[1500] ^= 1;
    fs::write(&state, bytes).unwrap();
    let (_, err) = relcp(place.path(), &["measure", state.to_str().unwrap(), "--out", "alone"], 4);
    assert!(err.contains("state_0000000025.npz") && err.contains("damaged"), "{err}");
    fs::write(place.path().join("run/scene.json"), b"{").unwrap();
    // A bad scene, as everywhere.
    let (_, err) = relcp(place.path(), &["measure", "run"], 2);
    assert!(err.contains("scene.json:1:1"), "{err}");
}

#[test]
fn states_with_forces_are_measured_as_a_checkpoint_of_their_step() {
    let place = tempfile::tempdir().unwrap();
    colony_to(place.path(), "with", "2.5", true);
    colony_to(place.path(), "without", "2", false);
    let rows = ["with", "without"].map(|run| {
        relcp(place.path(), &["measure", run, "--quiet"], 0);
        table(&place.path().join(run).join("measures/measures.csv"))
    });
    let [with, without] = &rows;
    assert!(with[2..].iter().any(|row| row["pressure"].unwrap() > 0.0 && row["chains"].is_some()));
    assert!(with[1..].iter().all(|row| row["pressure"].is_some() && row["pushing"].is_some()));
    // The checkpoint at the end of the shorter run is at the ninth state of the longer; its rate is not that of an end.
    for (column, value) in without[8].iter().filter(|(name, _)| *name != "expansion_rate") {
        assert_eq!(*value, with[8][column], "{column}");
    }
    assert!(without[8]["pressure"].unwrap() > 0.0 && without[7]["pressure"].is_none());
    assert!(place.path().join("with/measures/pressure.svg").is_file());
    assert!(!place.path().join("without/measures/pressure.svg").is_file());
    // A scene that does not ask for them is written as before.
    let scene = |run: &str| fs::read_to_string(place.path().join(run).join("scene.json")).unwrap();
    assert!(scene("with").contains("\"forces\": true") && !scene("without").contains("\"forces\": false"));
}

#[test]
fn a_damaged_checkpoint_leaves_the_states_to_be_measured() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path());
    fs::write(place.path().join("run/checkpoint.npz"), b"PK\x03\x04 and no more").unwrap();
    let (out, _) = relcp(place.path(), &["measure", "run"], 0);
    assert!(out.contains("11 states") && out.contains("checkpoint.npz") && out.contains("left out"), "{out}");
    let rows = table(&place.path().join("run/measures/measures.csv"));
    assert!(rows.iter().all(|row| row["pressure"].is_none() && row["touching"].is_some()));
    assert!(!place.path().join("run/measures/stress.csv").exists());
}
