//! Runs whose scene changes keys at given times.

use crate::{rows, to_end};
use relcp::record::{Folder, States};
use relcp::run::{Branch, Run};
use relcp::scene::KeyChange;
use relcp::{Compute, Scene, Simulation};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::time::Duration;

fn cells(end: f64, changes: Value) -> Scene {
    let sets = [format!("time.end={end}"), format!("changes={changes}")];
    // Slow growth has its own tolerance of the solver.
    let fixed = ["time.dt=0.01", "growth.rate=2", "growth.stop=null", "output.every=0.25", "output.picture=false"];
    Scene::load("colony", fixed.into_iter().chain(sets.iter().map(String::as_str))).unwrap()
}

fn begin(folder: &Path, scene: Scene) -> Run {
    let folder = Folder::create(folder).unwrap();
    Run::start(Simulation::new(scene).unwrap(), folder, Duration::ZERO).unwrap()
}

#[test]
fn a_run_with_a_change_has_the_bits_of_a_branch_with_it() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let changed = to_end(begin(&at("changed"), cells(2.5, json!([{"at": 1.5, "set": {"growth.rate": 0.05}}]))));
    to_end(begin(&at("first"), cells(1.5, json!([]))));
    let branch = Branch::open(&at("first"), None).unwrap();
    let scene = Scene::load(branch.scene(), ["growth.rate=0.05", "time.end=2.5"]).unwrap();
    let (simulation, parent) = branch.simulate(scene, &Compute::Cpu).unwrap();
    let folder = Folder::create(&at("second")).unwrap();
    let second = to_end(Run::start_from(simulation, folder, parent, Duration::ZERO).unwrap());
    assert_eq!(changed.state_hash, second.state_hash);
    assert_eq!(rows(&at("changed"))[151..], rows(&at("second"))[1..]);
    let plain = to_end(begin(&at("plain"), cells(2.5, json!([]))));
    assert!(plain.bodies > 2 * changed.bodies, "{} {}", plain.bodies, changed.bodies);
}

#[test]
fn a_run_that_is_killed_before_at_or_after_a_change_goes_on_to_the_same_bits() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let scene = || {
        let changes =
            json!([{"at": 0.505, "set": {"time.dt": 0.004, "growth.rate": 0.4}}, {"at": 1, "set": {"growth.rate": 3}}]);
        let mut scene = cells(1.25, changes);
        scene.output.measures = vec!["radius".into()];
        scene
    };
    let whole = to_end(begin(&at("whole"), scene()));
    // 51 steps of 0.01 to time 0.51, then steps of 0.004.
    assert_eq!(whole.steps, 51 + 185);
    assert!((whole.time - 1.25).abs() < 1e-12);
    let states = States::open(at("whole")).unwrap();
    let times: Vec<f64> = (0..states.len()).map(|i| states.read(i).unwrap().time).collect();
    for (time, expected) in times.iter().zip([0.0, 0.25, 0.5, 0.75, 1.0, 1.25]) {
        assert!((time - expected).abs() <= 0.004, "{times:?}");
    }
    for steps in [20, 51, 52, 180] {
        let path = at(&format!("{steps}"));
        let mut run = begin(&path, scene());
        for _ in 0..steps {
            run.advance().unwrap();
        }
        run.checkpoint().unwrap();
        drop(run);
        let folder = Folder::open(&path).unwrap();
        let recorded = Scene::read(folder.scene()).unwrap();
        let resumed = to_end(Run::resume(recorded, folder, &Compute::Cpu).unwrap());
        assert_eq!((&resumed.state_hash, rows(&path)), (&whole.state_hash, rows(&at("whole"))), "{steps}");
        let measured = |folder: &Path| fs::read(folder.join("measures.csv")).unwrap();
        assert_eq!(measured(&path), measured(&at("whole")));
    }
    // A branch knows the time of a state after the change.
    let branch = Branch::open(&at("whole"), Some(1.1)).unwrap();
    assert!((branch.time() - 1.0).abs() <= 0.004);
}

#[test]
fn the_final_scene_keeps_only_the_changes_that_are_still_to_come() {
    let changes = json!([{"at": 0.05, "set": {"growth.rate": 3}}, {"at": 1, "set": {"growth.rate": 1}}]);
    let mut simulation = Simulation::new(cells(2.0, changes)).unwrap();
    for _ in 0..10 {
        simulation.step().unwrap();
    }
    assert_eq!((simulation.changes_made(), simulation.scene().growth[0].rate), (1, 3.0));
    assert_eq!(simulation.whole_scene().growth[0].rate, 2.0);
    let last = simulation.final_scene().unwrap();
    assert_eq!(last.changes, [KeyChange::new(1.0, [("growth.rate".into(), json!(1))])]);
    assert_eq!(last.growth[0].rate, 3.0);
}

#[test]
fn a_force_that_was_added_acts_on_after_a_change() {
    use glam::DVec3;
    use relcp::dynamics::Load;
    let scene = r#"{ "name": "ball", "time": { "dt": 0.1, "end": 2 },
        "bodies": [ { "shape": { "sphere": { "radius": 1 } }, "position": [0, 0, 0] } ],
        "forces": [ { "uniform": { "force": [1, 0, 0] } } ],
        "changes": [ { "at": 1, "set": { "forces.0.uniform.force": [0, 1, 0] } } ] }"#;
    let mut simulation = Simulation::new(Scene::parse(scene, "ball.json").unwrap()).unwrap();
    simulation.add_force(Box::new(|_: &relcp::Bodies, _: usize, _: f64| Load { force: DVec3::Z, torque: DVec3::ZERO }));
    while !simulation.done() {
        simulation.step().unwrap();
    }
    // Of drag 1 for each length: mobility 1/2.
    let position = simulation.state().unwrap().bodies.position[0];
    assert!((position.x - position.y).abs() < 1e-12 && (position.z - 2.0 * position.x).abs() < 1e-12, "{position}");
}

#[test]
fn a_later_end_is_allowed_after_steps_of_a_change_that_fit_and_refused_after_those_that_do_not() {
    let place = tempfile::tempdir().unwrap();
    // The scene's own step does not divide its time; that of the change does, and its steps are more than the scene's.
    for (name, dt, fits) in [("fits", 0.001, true), ("not", 0.0013, false)] {
        let folder = place.path().join(name);
        let scene = || {
            let changes = json!([{"at": 0.03, "set": {"time.dt": dt}}]);
            let mut scene = cells(0.1, changes);
            scene.time.dt = 0.03;
            scene
        };
        let first = to_end(begin(&folder, scene()));
        assert!(first.steps > 10, "{}", first.steps);
        let own = Scene::read(Folder::view(&folder).scene()).unwrap();
        let longer = Run::resume_until(own, Folder::open(&folder).unwrap(), 0.2, &Compute::Cpu);
        assert_eq!(longer.is_ok(), fits, "{name}");
        let Ok(longer) = longer else { continue };
        let mut whole = scene();
        whole.output.every = whole.output_every();
        whole.time.end = 0.2;
        let whole = to_end(begin(&place.path().join("whole"), whole));
        assert_eq!(to_end(longer).state_hash, whole.state_hash);
    }
}

/// Balls in a row that a force pushes together.
fn row(changes: &Value) -> Scene {
    let ball = |x: f64| json!({"shape": {"sphere": {"radius": 0.5}}, "position": [x, 0, 0], "group": "row"});
    let scene = json!({"name": "row", "time": {"dt": 0.02, "end": 1.2},
        "bodies": [ball(-2.0), ball(-0.8), ball(0.8), ball(2.0)],
        "forces": [{"trap": {"stiffness": 1, "center": [0, 0, 0]}}],
        "changes": changes, "output": {"every": 0.3, "picture": false}});
    Scene::parse(&scene.to_string(), "row.json").unwrap()
}

#[test]
fn bodies_leave_and_come_at_their_time_and_the_run_goes_on_after_a_kill_to_the_same_bits() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let changes = json!([
        {"at": 0.3, "remove": [1], "add": [
            {"shape": {"sphere": {"radius": 0.3}}, "position": [0, 1.5, 0], "group": "row"},
            {"shape": {"spherocylinder": {"diameter": 0.4, "length": 1}}, "position": [-0.5, -1.5, 0]}]},
        {"at": 0.6, "set": {"forces.0.trap.stiffness": 2}, "remove": [0, 4]}]);
    let whole = to_end(begin(&at("whole"), row(&changes)));
    assert_eq!(whole.bodies, 3);
    let states = States::open(at("whole")).unwrap();
    let ids = |k: usize| {
        let mut ids: Vec<u64> = states.read(k).unwrap().bodies.lineage.iter().map(|line| line.id).collect();
        ids.sort_unstable();
        ids
    };
    // The state at the time of a change is that before it.
    let all: Vec<_> = (0..5).map(ids).collect();
    assert_eq!(all, [vec![0, 1, 2, 3], vec![0, 1, 2, 3], vec![0, 2, 3, 4, 5], vec![2, 3, 5], vec![2, 3, 5]]);
    let own = || Scene::read(Folder::view(&at("whole")).scene()).unwrap();
    assert_eq!(own().changes, row(&changes).changes);
    // Changes act before the steps 16 and 31. Body 4 came with the first one.
    let lives = |folder: &Path| fs::read_to_string(Folder::view(folder).lineage()).unwrap();
    let removed: Vec<String> = lives(&at("whole")).lines().skip(1).map(str::to_owned).collect();
    assert_eq!(removed, ["16,0.3,1,,0.0,0,row,change,", "31,0.6,0,,0.0,0,row,change,", "31,0.6,4,,0.3,0,row,change,"]);
    for steps in [10, 15, 16, 29, 30, 31, 50] {
        let folder = at(&format!("killed-{steps}"));
        let mut run = begin(&folder, own());
        (0..steps).for_each(|_| assert!(run.advance().is_ok()));
        run.checkpoint().unwrap();
        drop(run);
        let again = to_end(Run::resume(own(), Folder::open(&folder).unwrap(), &Compute::Cpu).unwrap());
        assert_eq!(again.state_hash, whole.state_hash, "{steps}");
        assert_eq!(rows(&folder), rows(&at("whole")), "{steps}");
        assert_eq!(lives(&folder), lives(&at("whole")), "{steps}");
    }
    // A run without removals has no such file. A run that was killed as it created the file continues.
    let folder = at("empty-file");
    let mut run = begin(&folder, own());
    (0..10).for_each(|_| assert!(run.advance().is_ok()));
    run.checkpoint().unwrap();
    drop(run);
    let path = Folder::view(&folder).lineage();
    assert!(!path.exists());
    fs::write(&path, b"").unwrap();
    to_end(Run::resume(own(), Folder::open(&folder).unwrap(), &Compute::Cpu).unwrap());
    assert_eq!(lives(&folder), lives(&at("whole")));
}

#[test]
fn a_body_that_is_not_there_ends_the_run_with_its_change() {
    let place = tempfile::tempdir().unwrap();
    let mut run = begin(&place.path().join("run"), row(&json!([{"at": 0.1, "remove": [9]}])));
    let fault = (0..60).find_map(|_| run.advance().err()).unwrap().to_string();
    assert!(fault.contains("changes.0: id 9: no body has it now"), "{fault}");
    assert_eq!(run.simulation().steps(), 5);
}
