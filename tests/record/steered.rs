//! Runs that their user changes while they go on.

use crate::{rows, to_end};
use relcp::record::Folder;
use relcp::run::Run;
use relcp::scene::{Body, KeyChange};
use relcp::{Compute, Error, Scene, Shape, Simulation};
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

/// The largest overlap of a run's steps so far.
fn widest(folder: &Path) -> f64 {
    let table = fs::read_to_string(folder.join("steps.csv")).unwrap();
    let mut lines = table.lines();
    let column = lines.next().unwrap().split(',').position(|name| name == "max_overlap").unwrap();
    lines.map(|line| line.split(',').nth(column).unwrap().parse::<f64>().unwrap()).fold(0.0, f64::max)
}

#[test]
fn chainmail_that_is_dragged_stays_within_its_tolerance_and_is_dragged_again_to_the_same_bits() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let sets = [
        "time.end=6",
        "output.picture=false",
        "generate.0.chainmail.columns=3",
        "generate.0.chainmail.rows=3",
        "forces=[]",
    ];
    let scene = Scene::load("chainmail", sets).unwrap();
    let tolerance = scene.contact.overlap_tolerance;
    let mut run = begin(&at("run"), scene);
    let places = run.simulation().state().unwrap().bodies.position.clone();
    let start = places[0];
    // Away from the others, which have to follow.
    let away = -3.0 * start.normalize();
    for part in 0..10 {
        let target = start - away * 0.1 * f64::from(part + 1);
        run.pull(0, [0.0; 3], target.to_array()).unwrap();
        take(&mut run, 20);
    }
    run.let_go(0).unwrap();
    assert!(run.simulation().coming_scene().forces.is_empty());
    assert_eq!(run.simulation().whole_scene().changes.len(), 11);
    let now = run.simulation().state().unwrap().bodies.position.clone();
    let moved: Vec<f64> = now.iter().zip(&places).map(|(now, before)| now.distance(*before)).collect();
    // The others follow only as the links pull them.
    assert!(moved[0] > 0.3 && moved[1] > 0.05 && moved[1] < moved[0], "{moved:?}");
    run.end_here().unwrap();
    let hash = to_end(run).state_hash;
    assert!(widest(&at("run")) <= tolerance, "{}", widest(&at("run")));
    assert_eq!(hash, again(&at("run"), &at("again")));
}

#[test]
fn bodies_that_a_user_drags_places_and_removes_are_so_again_also_after_a_kill() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let mut run = begin(&at("run"), colony(&[]));
    take(&mut run, 60);
    let first = run.simulation().state().unwrap().bodies.lineage[0].id;
    run.pull(first, [0.0, 0.0, 0.5], [4.0, 3.0, 7.0]).unwrap();
    run.pull(first, [0.0, 0.0, 0.5], [4.0, 3.0, 0.0]).unwrap();
    // The plane's own z, so that the second asks for nothing new.
    assert_eq!(run.simulation().whole_scene().changes.len(), 1);
    take(&mut run, 15);
    let rod = |x: f64, y: f64| {
        let mut rod = Body::new(Shape::Spherocylinder { diameter: 1.0, length: 2.5 }, [x, y, 0.0]);
        rod.axis = Some([1.0, 1.0, 0.0]);
        rod
    };
    let before = run.simulation().bodies();
    run.change_by(KeyChange::new(0.0, []).with_bodies(vec![], vec![rod(6.0, 0.0)])).unwrap();
    // It comes with the next step, and the state to come has it already.
    assert_eq!(
        (run.simulation().bodies(), run.simulation().coming_state().unwrap().bodies.len()),
        (before, before + 1)
    );
    let placed = *run.simulation().coming_state().unwrap().bodies.lineage.last().unwrap();
    take(&mut run, 5);
    let refused = run.change_by(KeyChange::new(0.0, []).with_bodies(vec![first + 999], vec![]));
    assert!(matches!(&refused, Err(Error::Change(_))), "{refused:?}");
    let mut held = rod(9.0, 0.0);
    held.fixed = true;
    let refused = run.change_by(KeyChange::new(0.0, []).with_bodies(vec![], vec![held]));
    assert!(matches!(&refused, Err(Error::Scene(fault)) if fault.key() == "changes.2.add.0.fixed"), "{refused:?}");
    let refused = run.pull(first + 999, [0.0; 3], [0.0; 3]);
    assert!(refused.is_err());
    run.change_by(KeyChange::new(0.0, []).with_bodies(vec![placed.id], vec![])).unwrap();
    run.let_go(first).unwrap();
    let there = |run: &Run| run.simulation().state().unwrap().bodies.lineage.iter().any(|line| line.id == placed.id);
    assert!(there(&run));
    take(&mut run, 1);
    assert!(!there(&run));
    run.change_by(KeyChange::new(0.0, []).with_bodies(vec![], vec![rod(6.0, 0.0), rod(-6.0, 1.0)])).unwrap();
    drop(run);
    // Killed before the step that places them.
    let own = Scene::read(Folder::view(&at("run")).scene()).unwrap();
    let expected = again(&at("run"), &at("again"));
    let resumed = to_end(Run::resume(own, Folder::open(&at("run")).unwrap(), &Compute::Cpu).unwrap());
    assert_eq!(resumed.state_hash, expected);
    assert_eq!(rows(&at("run")), rows(&at("again")));
}

#[test]
fn a_pulled_ball_comes_to_its_target_as_a_spring_does() {
    let scene = r#"{ "name": "ball", "time": { "dt": 0.01, "end": 1 }, "dynamics": { "overdamped": { "drag": 2 } },
        "bodies": [ { "shape": { "sphere": { "radius": 0.5 } }, "position": [0, 0, 0] },
                    { "shape": { "sphere": { "radius": 0.5 } }, "position": [0, 9, 0] } ],
        "forces": [ { "pull": { "body": 1, "target": [1, 9, 0], "stiffness": 4 } },
                    { "pull": { "body": 0, "target": [50, 0, 0], "stiffness": 4, "most": 3 } },
                    { "pull": { "body": 7, "target": [50, 0, 0], "stiffness": 4 } } ] }"#;
    let mut simulation = Simulation::new(Scene::parse(scene, "ball.json").unwrap()).unwrap();
    (0..50).for_each(|_| assert!(simulation.step().is_ok()));
    let at = simulation.state().unwrap().bodies.position.clone();
    // Drag 2 for each length of 1: the way to the target shrinks by 1 - 0.01 * 4 / 2 in each step.
    assert!((1.0 - at[1].x - 0.98_f64.powi(50)).abs() < 1e-12 && at[1].y == 9.0, "{at:?}");
    assert!((at[0].x - 0.5 * 3.0 / 2.0).abs() < 1e-12, "{at:?}");
}
