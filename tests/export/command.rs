//! `relcp export` from outside.

use crate::gsd_file::read;
use crate::program::relcp;
use crate::scenes::{colony, every_shape};
use relcp::record::write_state;
use relcp::step::State;
use serde_json::Value;
use std::fs;
use std::path::Path;

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_run_is_exported_into_its_folder() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path());
    let (out, err) = relcp(place.path(), &["export", "colony", "--format", "gsd"], 0);
    assert!(
        out.starts_with("26 states of up to 8 bodies") && out.contains("colony.gsd") && err.is_empty(),
        "{out}{err}"
    );
    assert_eq!(read(&place.path().join("colony/gsd/colony.gsd")).len(), 26);
    let (out, _) = relcp(place.path(), &["export", "colony/", "--format", "vtk", "--quiet"], 0);
    assert!(out.is_empty());
    assert_eq!(
        names(&place.path().join("colony/vtk")),
        ["axes.pvd", "bodies.pvd", "contacts.pvd", "show.py", "states"]
    );
    assert_eq!(names(&place.path().join("colony/vtk/states")).len(), 78);
    // What it left does not keep the run from being gone on with, or exported again.
    relcp(place.path(), &["run", "--resume", "--out", "colony", "--quiet", "--backend", "cpu"], 0);
    relcp(place.path(), &["export", "colony", "--format", "vtk", "--quiet", "--threads", "1"], 0);
}

#[test]
fn json_is_one_document() {
    let place = tempfile::tempdir().unwrap();
    let arguments = ["export", "three-capsules", "--format", "vtk", "--out", "x", "--cutoff", "0.1", "--json"];
    let (out, _) = relcp(place.path(), &arguments, 0);
    let document: Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&document["format"], &document["folder"]), (&"vtk".into(), &"x".into()));
    assert_eq!((&document["states"], &document["bodies"]), (&1.into(), &3.into()));
    assert_eq!(document["files"][0], "x/bodies.pvd");
    let on_disk: u64 = ["x", "x/states"]
        .iter()
        .flat_map(|folder| fs::read_dir(place.path().join(folder)).unwrap())
        .map(|entry| entry.unwrap().metadata().unwrap())
        .filter(|meta| meta.is_file())
        .map(|meta| meta.len())
        .sum();
    assert_eq!(document["bytes"], on_disk);
}

#[test]
fn scenes_states_and_ends_of_runs_are_exported_too() {
    let place = tempfile::tempdir().unwrap();
    let run = colony(place.path());
    relcp(place.path(), &["export", "chainmail", "--format", "gsd"], 0);
    assert_eq!(read(&place.path().join("chainmail-gsd/chainmail.gsd"))[0]["particles/N"].u32s(), [36]);
    relcp(place.path(), &["export", "colony/states/state_0000000010.npz", "--format", "gsd"], 0);
    let frames = read(&place.path().join("state_0000000010-gsd/state_0000000010.gsd"));
    assert_eq!((frames.len(), frames[0]["configuration/step"].u64s()), (1, vec![10]));
    relcp(place.path(), &["export", "colony/final.json", "--format", "gsd", "--out", "end"], 0);
    let end = read(&place.path().join("end/final.gsd"));
    assert_eq!(end[0]["log/time"].f64s(), [2.5]);
    // Without states the checkpoint is exported, and without that the final state.
    fs::remove_dir_all(run.states()).unwrap();
    relcp(place.path(), &["export", "colony", "--format", "gsd"], 0);
    assert_eq!(read(&place.path().join("colony/gsd/colony.gsd"))[0]["configuration/step"].u64s(), [250]);
    fs::remove_file(run.checkpoint()).unwrap();
    relcp(place.path(), &["export", "colony", "--format", "gsd"], 0);
    let last = read(&place.path().join("colony/gsd/colony.gsd"));
    assert_eq!(last[0]["particles/position"].f32s(), end[0]["particles/position"].f32s());
    fs::remove_file(run.last()).unwrap();
    let (_, err) = relcp(place.path(), &["export", "colony", "--format", "gsd"], 4);
    assert!(err.contains("colony: no state to export") && err.contains("a run's folder"), "{err}");
}

#[test]
fn what_cannot_be_done_is_said_and_leaves_no_file() {
    let place = tempfile::tempdir().unwrap();
    let run = colony(place.path());
    for (arguments, status) in [
        (&["export", "colony"] as &[&str], 2),
        (&["export", "colony", "--format", "pdb"], 2),
        (&["export", "colony", "--format", "gsd", "--cutoff", "0.1"], 2),
        (&["export", "colony", "--format", "vtk", "--cutoff", "nan"], 2),
        (&["export", "no-such-run", "--format", "gsd"], 2),
        (&["export", "nothing.npz", "--format", "gsd", "--out", "new"], 4),
        (&["export", "colony", "--format", "gsd", "--out", "colony/scene.json"], 4),
    ] {
        let (out, err) = relcp(place.path(), arguments, status);
        assert!(out.is_empty() && !err.is_empty(), "{arguments:?}: {out}{err}");
    }
    let state = run.state(10);
    let mut bytes = fs::read(&state).unwrap();
    bytes[2000] ^= 1;
    fs::write(&state, bytes).unwrap();
    for format in ["gsd", "vtk"] {
        let alone = ["export", state.to_str().unwrap(), "--format", format, "--out", format];
        let (_, err) = relcp(place.path(), &alone, 4);
        assert!(err.contains("state_0000000010.npz") && err.contains("damaged"), "{err}");
        let (out, _) = relcp(place.path(), &["export", "colony", "--format", format], 0);
        assert!(out.contains("state_0000000010.npz") && out.contains("left out"), "{out}");
    }
    assert!(names(&place.path().join("gsd")).is_empty());
    assert_eq!(names(&place.path().join("vtk")), ["states"]);
}

#[test]
fn a_damaged_checkpoint_is_passed_over_with_a_note() {
    let place = tempfile::tempdir().unwrap();
    let run = colony(place.path());
    fs::write(run.checkpoint(), b"PK\x03\x04 and no more").unwrap();
    let (out, _) = relcp(place.path(), &["export", "colony", "--format", "gsd"], 0);
    assert!(out.contains("26 states") && out.contains("checkpoint.npz") && out.contains("left out"), "{out}");
}

#[test]
fn a_checkpoint_after_the_last_state_comes_last() {
    let place = tempfile::tempdir().unwrap();
    let run = colony(place.path());
    let bodies = every_shape().bodies;
    write_state(
        &run.checkpoint(),
        &State { step: 255, next_id: 200, bodies, warm: Vec::new(), ..State::default() },
        "x",
        2.55,
        None,
    )
    .unwrap();
    relcp(place.path(), &["export", "colony", "--format", "gsd"], 0);
    let frames = read(&run.path().join("gsd/colony.gsd"));
    assert_eq!((frames.len(), frames[26]["configuration/step"].u64s()), (27, vec![255]));
}

#[test]
fn help_has_examples() {
    let place = tempfile::tempdir().unwrap();
    let (out, _) = relcp(place.path(), &["export", "--help"], 0);
    assert!(out.contains("Examples:") && out.contains("--format") && out.contains("ovito") && out.contains("paraview"));
}
