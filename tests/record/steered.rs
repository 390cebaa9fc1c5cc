//! Runs that their user changes while they go on.

use crate::{rows, to_end};
use relcp::record::Folder;
use relcp::run::Run;
use relcp::{Compute, Error, Scene, Simulation};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::Duration;

fn colony(more: &[&str]) -> Scene {
    let fixed = ["time.dt=0.01", "time.end=2.5", "growth.rate=2", "growth.stop=null", "output.picture=false"];
    Scene::load("colony", fixed.iter().chain(more).copied()).unwrap()
}

fn begin(folder: &Path, scene: Scene) -> Run {
    Run::start(Simulation::new(scene).unwrap(), Folder::create(folder).unwrap(), Duration::ZERO).unwrap()
}

fn set(value: Value) -> BTreeMap<String, Value> {
    value.as_object().unwrap().clone().into_iter().collect()
}

fn take(run: &mut Run, steps: usize) {
    for _ in 0..steps {
        run.advance().unwrap();
    }
}

/// A run of a folder's scene from its start.
fn again(folder: &Path, other: &Path) -> String {
    to_end(begin(other, Scene::read(Folder::view(folder).scene()).unwrap())).state_hash
}

#[test]
fn changes_between_those_of_the_scene_are_repeated_to_the_same_bits() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let own = r#"changes=[{"at": 0.505, "set": {"growth.rate": 1}}, {"at": 1.2, "set": {"time.dt": 0.008}}]"#;
    let mut run = begin(&at("run"), colony(&[own, "output.measures=[\"radius\"]"]));
    run.change(set(json!({"growth.rate": 3}))).unwrap();
    take(&mut run, 51);
    // At the state at which the scene's own first change is due.
    run.change(set(json!({"time.dt": 0.004, "growth.rate": 1.5}))).unwrap();
    assert_eq!(run.simulation().coming_scene().growth[0].rate, 1.5);
    assert_eq!(run.simulation().scene().growth[0].rate, 3.0);
    take(&mut run, 200);
    run.change(set(json!({"seed": 9, "growth.reorientation_degrees": 15}))).unwrap();
    let changes = run.simulation().whole_scene().changes.clone();
    assert!(changes.len() == 5 && changes.windows(2).all(|two| two[0].at <= two[1].at), "{changes:?}");
    let hash = to_end(run).state_hash;
    assert_eq!(hash, again(&at("run"), &at("again")));
    assert_eq!(rows(&at("run")), rows(&at("again")));
    let measured = |name: &str| fs::read(at(name).join("measures.csv")).unwrap();
    assert_eq!(measured("run"), measured("again"));
}

#[test]
fn the_end_here_has_the_last_row_and_state_also_after_a_resumption() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    for (name, steps) in [("none", 0), ("some", 3)] {
        let scene = || colony(&["output.step_stride=7", "output.measures=[\"radius\"]"]);
        let mut run = begin(&at(name), scene());
        take(&mut run, 40);
        run.checkpoint().unwrap();
        drop(run);
        let mut run = Run::resume(scene(), Folder::open(&at(name)).unwrap(), &Compute::Cpu).unwrap();
        take(&mut run, steps);
        run.end_here().unwrap();
        assert!(run.done() && run.simulation().steps() == 40 + steps.max(1) as u64);
        let summary = to_end(run);
        let other = at(&format!("{name}-again"));
        assert_eq!(summary.state_hash, again(&at(name), &other));
        assert_eq!(rows(&at(name)), rows(&other));
        // It is taken up again, and goes on past its end to the bits of a run that never ended there.
        let own = Scene::read(Folder::view(&at(name)).scene()).unwrap();
        let folder = || Folder::open(&at(name)).unwrap();
        assert_eq!(to_end(Run::resume(own.clone(), folder(), &Compute::Cpu).unwrap()).state_hash, summary.state_hash);
        let longer = to_end(Run::resume_until(own, folder(), 2.5, &Compute::Cpu).unwrap());
        let plain = to_end(begin(&at(&format!("{name}-plain")), scene()));
        assert_eq!(longer.state_hash, plain.state_hash);
    }
}

#[test]
fn a_checkpoint_at_an_end_that_the_scene_does_not_know_yet_is_known() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let mut run = begin(&at("run"), colony(&[]));
    take(&mut run, 30);
    let scene = fs::read(at("run").join("scene.json")).unwrap();
    run.end_here().unwrap();
    drop(run);
    // Killed after the checkpoint and before the scene.
    fs::write(at("run").join("scene.json"), scene).unwrap();
    let own = Scene::read(Folder::view(&at("run")).scene()).unwrap();
    let resumed = to_end(Run::resume(own, Folder::open(&at("run")).unwrap(), &Compute::Cpu).unwrap());
    assert_eq!(resumed.state_hash, to_end(begin(&at("plain"), colony(&[]))).state_hash);
}

#[test]
fn another_scene_than_that_of_the_folder_stays_refused() {
    let place = tempfile::tempdir().unwrap();
    let mut run = begin(&place.path().join("run"), colony(&[]));
    take(&mut run, 30);
    run.checkpoint().unwrap();
    let path = run.folder().path().to_owned();
    drop(run);
    for other in [r#"changes=[{"at": 1, "set": {"growth.rate": 1}}]"#, "time.end=0.3", "seed=2"] {
        let refused = Run::resume(colony(&[other]), Folder::open(&path).unwrap(), &Compute::Cpu);
        assert!(refused.is_err(), "{other}");
    }
}

#[test]
fn a_change_that_the_bodies_do_not_allow_changes_nothing() {
    let scene = r#"{ "name": "lens", "time": { "dt": 0.1, "end": 1 },
        "bodies": [ { "shape": { "ellipsoid": { "radii": [1, 1, 0.5] } }, "position": [0, 0, 0] } ],
        "forces": [ { "uniform": { "force": [1, 0, 0] } } ] }"#;
    let place = tempfile::tempdir().unwrap();
    let mut run = begin(&place.path().join("run"), Scene::parse(scene, "lens.json").unwrap());
    take(&mut run, 3);
    let before = fs::read(run.folder().scene()).unwrap();
    let refused = run.change(set(json!({"contact.method": {"multisphere": {"count": 5}}})));
    assert!(matches!(&refused, Err(Error::Scene(fault)) if fault.to_string().contains("oblate")), "{refused:?}");
    let refused = run.change(set(json!({"forces.0.uniform.force": [1, 0]})));
    assert!(matches!(&refused, Err(Error::Scene(fault)) if fault.key().contains("force")), "{refused:?}");
    assert!(run.simulation().whole_scene().changes.is_empty() && run.simulation().scene().changes.is_empty());
    assert_eq!(fs::read(run.folder().scene()).unwrap(), before);
    run.change(set(json!({"forces.0.uniform.force": [0, 2, 0]}))).unwrap();
    take(&mut run, 3);
    // Of drag 1 for each length: mobility 1/2.
    let position = run.simulation().state().unwrap().bodies.position[0];
    assert!((position.y - 2.0 * position.x).abs() < 1e-12 && position.x > 0.1, "{position}");
}
