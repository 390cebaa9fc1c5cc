//! Runs that begin with a state of another run.

use crate::{rows, to_end};
use relcp::record::{Folder, Parent, RecordError, States};
use relcp::run::{Branch, Run, RunError};
use relcp::{Compute, Scene, Simulation};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Cells in a chamber that is open above: they grow, divide, leave, and draw random numbers.
fn cells(end: f64) -> Scene {
    let mut scene = Scene::built_in("colony").unwrap();
    scene.time = relcp::step::Time::new(0.01, end);
    scene.growth[0].stop = None;
    scene.growth[0].rate = 2.0;
    scene.output.every = Some(0.25);
    scene.output.picture = false;
    scene
}

fn begin(place: &Path, name: &str, scene: Scene) -> Run {
    let folder = Folder::create(&place.join(name)).unwrap();
    Run::start(Simulation::new(scene).unwrap(), folder, Duration::ZERO).unwrap()
}

/// A run to `end` in a folder.
fn parent(place: &Path, end: f64) -> PathBuf {
    to_end(begin(place, "parent", cells(end)));
    place.join("parent")
}

fn from(branch: &Branch, scene: Scene, folder: &Path) -> Result<Run, RunError> {
    let (simulation, parent) = branch.simulate(scene, &Compute::Cpu)?;
    Run::start_from(simulation, Folder::create(folder)?, parent, Duration::ZERO)
}

#[test]
fn a_run_from_anothers_last_state_has_the_bits_of_one_run() {
    let place = tempfile::tempdir().unwrap();
    let whole = to_end(begin(place.path(), "whole", cells(3.0)));
    assert!(whole.bodies > 16, "{}", whole.bodies);
    let branch = Branch::open(&parent(place.path(), 2.0), None).unwrap();
    assert_eq!((branch.step(), branch.time()), (200, 2.0));
    let mut scene = Scene::load(branch.scene(), relcp::scene::NO_OVERRIDES).unwrap();
    scene.time.end = 3.0;
    let folder = place.path().join("branch");
    let summary = to_end(from(&branch, scene, &folder).unwrap());
    assert_eq!((summary.state_hash, summary.steps), (whole.state_hash, 300));
    assert_eq!(rows(&folder)[1..], rows(&place.path().join("whole"))[201..]);
    let parent = Parent::of(&Folder::view(&folder)).unwrap().unwrap();
    assert_eq!((parent.step, parent.time, parent.multipliers), (200, 2.0, true));
    assert_eq!(parent.changed, ["time.end"]);
    // Its states begin with the other run's.
    let states = States::open(&folder).unwrap();
    let times: Vec<f64> = (0..states.len()).map(|i| states.read(i).unwrap().time).collect();
    assert_eq!(times, [2.0, 2.25, 2.5, 2.75, 3.0]);
}

#[test]
fn a_run_from_a_state_at_a_time_goes_on_in_time_with_a_changed_step_and_rate() {
    let place = tempfile::tempdir().unwrap();
    let branch = Branch::open(&parent(place.path(), 2.0), Some(1.1)).unwrap();
    assert_eq!((branch.step(), branch.time()), (100, 1.0));
    let scene = Scene::load(branch.scene(), ["time.dt=0.004", "growth.rate=1e-6", "time.end=1.4"]).unwrap();
    let folder = place.path().join("branch");
    let run = from(&branch, scene.clone(), &folder).unwrap();
    assert!(run.notes()[0].contains("no multipliers"), "{:?}", run.notes());
    assert!((run.simulation().time() - 1.0).abs() < 1e-12);
    let (cells, scene_now) = (run.simulation().bodies(), run.simulation().scene().clone());
    assert_eq!((scene_now.time.dt, scene_now.time.end), (0.01, 1.4));
    assert_eq!(scene_now.changes[0].set["time.dt"], 0.004);
    let length = |bodies: &relcp::Bodies| bodies.shape[0].growing_length().unwrap();
    let before = length(&run.simulation().state().unwrap().bodies);
    let summary = to_end(run);
    // They hardly grow any more.
    assert_eq!((summary.steps, summary.bodies), (200, cells));
    assert!((summary.time - 1.4).abs() < 1e-12);
    let after = Scene::read(folder.join("final.json")).unwrap().build().unwrap();
    assert!((length(&after) - before).abs() < 1e-5);
    let parent = Parent::of(&Folder::view(&folder)).unwrap().unwrap();
    assert_eq!(parent.changed, ["growth.rate", "time.dt", "time.end"]);
}

#[test]
fn a_run_from_another_that_was_killed_goes_on_to_the_same_bits() {
    let place = tempfile::tempdir().unwrap();
    let branch = Branch::open(&parent(place.path(), 1.0), Some(0.5)).unwrap();
    let scene = Scene::load(branch.scene(), ["growth.rate=3"]).unwrap();
    let whole = to_end(from(&branch, scene.clone(), &place.path().join("whole")).unwrap());
    for (name, steps) in [("at once", 0), ("later", 20)] {
        let path = place.path().join(name);
        let mut run = from(&branch, scene.clone(), &path).unwrap();
        for _ in 0..steps {
            run.advance().unwrap();
        }
        drop(run);
        let folder = Folder::open(&path).unwrap();
        let scene = Scene::read(folder.scene()).unwrap();
        let resumed = to_end(Run::resume(scene, folder, &Compute::Cpu).unwrap());
        assert_eq!(
            (&resumed.state_hash, rows(&path)),
            (&whole.state_hash, rows(&place.path().join("whole"))),
            "{name}"
        );
    }
}

#[test]
fn what_a_state_has_settled_is_refused_with_its_keys_and_nothing_is_written() {
    let place = tempfile::tempdir().unwrap();
    let path = parent(place.path(), 0.5);
    let branch = Branch::open(&path, None).unwrap();
    let refused = |sets: &[&str]| {
        let scene = Scene::load(branch.scene(), sets).unwrap();
        match branch.simulate(scene, &Compute::Cpu) {
            Err(RunError::Record(RecordError::NoBranch { why, .. })) => why,
            Err(error) => panic!("{error}"),
            Ok(_) => panic!("{sets:?} was accepted"),
        }
    };
    assert!(refused(&["planar=false"]).contains("planar cannot change"));
    let founder = refused(&["generate.0.founder.length=1.9", "time.start=0.1"]);
    assert!(founder.contains("generate.0.founder.length") && founder.contains("time.start"), "{founder}");
    assert!(refused(&["time.end=0.2"]).contains("before the state's time"));
    let none = |path: &Path, time| Branch::open(path, time).unwrap_err().to_string();
    assert!(none(&path, Some(-1.0)).contains("first state is at time 0"));
    assert!(none(&place.path().join("nowhere"), None).contains("no run can begin"));
    fs::create_dir(place.path().join("empty")).unwrap();
    assert!(none(&place.path().join("empty"), None).contains("no run can begin"));
}

#[test]
fn a_key_that_a_change_has_set_may_be_set_again() {
    let place = tempfile::tempdir().unwrap();
    let mut scene = cells(2.0);
    let change = |at: f64, rate: f64| relcp::scene::KeyChange::new(at, [("growth.rate".to_owned(), rate.into())]);
    scene.changes = vec![change(0.5, 1.0)];
    to_end(begin(place.path(), "parent", scene.clone()));
    scene.changes.push(change(1.5, 2.0));
    let whole = to_end(begin(place.path(), "whole", scene));
    let branch = Branch::open(&place.path().join("parent"), Some(1.5)).unwrap().with_keys(["growth.rate".to_owned()]);
    let own = branch.scene();
    // Another value, and the one that the scene has without its changes.
    let hash = |value: &str, name: &str| {
        let scene = Scene::load(&own, [format!("growth.rate={value}")]).unwrap();
        let run = from(&branch, scene, &place.path().join(name)).unwrap();
        assert_eq!(run.simulation().whole_scene().changes.len(), 2, "{value}");
        to_end(run).state_hash
    };
    // The state has no multipliers, so that the bits are not those of the whole run.
    let [same, slower, faster] =
        [("2", "same"), ("1", "slower"), ("3", "faster")].map(|(value, name)| hash(value, name));
    assert!(same != slower && slower != faster && same != faster, "{same} {slower} {faster}");
    let lengths = |folder: &str| {
        let bodies = Scene::read(place.path().join(folder).join("final.json")).unwrap().build().unwrap();
        bodies.shape.iter().map(|shape| shape.growing_length().unwrap()).sum::<f64>()
    };
    let [parent, same, slower, faster] = ["parent", "same", "slower", "faster"].map(lengths);
    assert!(
        (slower - parent).abs() < 1e-9 && (same - lengths("whole")).abs() < 1e-9,
        "{parent} {same} {slower} {faster}"
    );
    assert!(whole.bodies > 1 && slower < same && same < faster, "{slower} {same} {faster}");
}
