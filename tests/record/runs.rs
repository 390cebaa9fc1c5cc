//! A resumed run writes the files of an uninterrupted run.

use crate::{rows, to_end};
use glam::DVec3;
use relcp::dynamics::Load;
use relcp::measure::{measure, select};
use relcp::record::{Folder, RecordError, States, read_state};
use relcp::run::{Run, RunError, Summary};
use relcp::{Bodies, Compute, Fault, Scene, Simulation};
use std::fs;
use std::path::Path;
use std::time::Duration;

/// Two rods that are pushed together, over 60 steps.
fn rods(folder: &Path) -> Run {
    let scene = rods_scene(folder);
    Run::start(Simulation::new(scene).unwrap(), Folder::create(&folder.join("run")).unwrap(), Duration::ZERO).unwrap()
}

fn rods_scene(folder: &Path) -> Scene {
    let path = folder.join("rods.json");
    fs::write(&path, include_str!("../data/rods.json")).unwrap();
    Scene::read(&path).unwrap()
}

/// The files that must be equal, and the bits of the states.
fn left(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(folder.join("states")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.extend([folder.join("scene.json"), folder.join("final.json")]);
    files.sort();
    files
        .iter()
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(path).unwrap()))
        .collect()
}

#[test]
fn a_run_that_crashed_after_a_checkpoint_goes_on_to_the_same_bits() {
    let (whole, broken) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let expected = to_end(rods(whole.path()));
    let mut run = rods(broken.path());
    for step in 1..=33 {
        run.advance().unwrap();
        if step == 17 {
            run.checkpoint().unwrap();
        }
    }
    drop(run);
    assert!(!broken.path().join("run/summary.json").exists());
    let folder = Folder::open(&broken.path().join("run")).unwrap();
    let resumed = Run::resume(rods_scene(broken.path()), folder, &Compute::Cpu).unwrap();
    assert_eq!((resumed.simulation().state().unwrap().step, resumed.totals().steps), (17, 17));
    let summary = to_end(resumed);
    let (whole, broken) = (whole.path().join("run"), broken.path().join("run"));
    assert_eq!(summary.state_hash, expected.state_hash);
    assert_eq!((summary.solver.clone(), summary.recursions), (expected.solver.clone(), expected.recursions));
    assert_eq!(rows(&broken), rows(&whole));
    assert_eq!(rows(&whole).len(), 61);
    assert_eq!(left(&broken), left(&whole));
}

#[test]
fn what_is_measured_while_it_runs_is_what_is_measured_afterwards_and_survives_a_crash() {
    let place = tempfile::tempdir().unwrap();
    let scene = || {
        let mut scene = rods_scene(place.path());
        scene.output.measures = vec!["radius".into(), "contacts".into(), "stress".into()];
        scene.output.step_stride = 4;
        scene.output.every = Some(scene.time.dt);
        scene
    };
    let start = |name: &str| {
        let (scene, folder) = (scene(), Folder::create(&place.path().join(name)).unwrap());
        Run::start(Simulation::new(scene).unwrap(), folder, Duration::ZERO).unwrap()
    };
    to_end(start("whole"));
    let mut run = start("broken");
    for step in 1..=33 {
        run.advance().unwrap();
        if step == 17 {
            run.checkpoint().unwrap();
        }
    }
    drop(run);
    let broken = Folder::open(&place.path().join("broken")).unwrap();
    to_end(Run::resume(scene(), broken.clone(), &Compute::Cpu).unwrap());
    let whole = Folder::view(&place.path().join("whole"));
    let measured = fs::read_to_string(whole.measures()).unwrap();
    assert_eq!(fs::read_to_string(broken.measures()).unwrap(), measured);

    let source = whole.path().to_str().unwrap();
    let states = States::open(source).unwrap();
    let measures = select(&scene().output.measures).unwrap();
    let after = measure(source, &states, &measures, &Default::default(), &mut |_, _| true).unwrap();
    let mut reader = csv::Reader::from_reader(measured.as_bytes());
    let columns: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.unwrap()).collect();
    assert_eq!(rows.len(), 15);
    let mut compared = 0;
    for row in rows {
        let step: u64 = row[0].parse().unwrap();
        let state = after.steps.iter().position(|of| *of == step).unwrap();
        for (column, cell) in columns.iter().zip(&row).skip(3) {
            let cell: Option<f64> = (!cell.is_empty()).then(|| cell.parse().unwrap());
            // States have no forces here, and rates need more than one state.
            let both = cell.zip(after.value(state, column));
            compared += usize::from(both.is_some());
            assert!(both.is_none_or(|(now, then)| now == then), "{column} of step {step}: {cell:?}");
        }
        let pressure = columns.iter().position(|column| column == "pressure").unwrap();
        assert!(!row[pressure].is_empty());
    }
    assert!(compared >= 15 * 3, "{compared}");
    let text = r#"{"name": "a", "time": {"dt": 0.1, "end": 1}, "output": {"measures": ["radius", "size"]},
        "bodies": [{"shape": {"sphere": {"radius": 1}}, "position": [0, 0, 0]}]}"#;
    let refused = Scene::parse(text, "a").unwrap_err().to_string();
    assert!(refused.contains("unknown measure \"size\"") && refused.contains("nematic"), "{refused}");
}

#[test]
fn a_step_that_cannot_be_taken_leaves_the_state_before_it() {
    let place = tempfile::tempdir().unwrap();
    let mut run = rods(place.path());
    let breaks = |_: &Bodies, _: usize, time: f64| Load {
        force: DVec3::splat(if time > 0.1 { f64::NAN } else { 0.0 }),
        torque: DVec3::ZERO,
    };
    run.add_force(Box::new(breaks));
    let fault = std::iter::repeat_with(|| run.advance()).find_map(Result::err).unwrap();
    assert!(matches!(fault, RunError::Fault(Fault::NotFinite { .. })), "{fault}");
    let taken = run.simulation().state().unwrap().clone();
    assert!(taken.step >= 5 && !run.done());
    drop(run);
    let folder = Folder::open(&place.path().join("run")).unwrap();
    assert_eq!(read_state(&folder.checkpoint()).unwrap().1, taken);
    let summary = fs::read_to_string(folder.summary()).unwrap();
    assert!(summary.contains("\"status\": \"stopped\"") && summary.contains("\"reason\": \"not_finite\""), "{summary}");
    assert!(folder.last().exists(), "the state before it, as a scene to go on from");
}

#[test]
fn a_damaged_checkpoint_gives_way_to_the_one_before() {
    let place = tempfile::tempdir().unwrap();
    let mut run = rods(place.path());
    for step in 1..=20 {
        run.advance().unwrap();
        if step % 10 == 0 {
            run.checkpoint().unwrap();
        }
    }
    drop(run);
    let folder = Folder::open(&place.path().join("run")).unwrap();
    fs::write(folder.checkpoint(), b"PK\x03\x04").unwrap();
    let run = Run::resume(rods_scene(place.path()), folder.clone(), &Compute::Cpu).unwrap();
    assert_eq!(run.simulation().state().unwrap().step, 10);
    assert!(run.notes()[0].contains("truncated"), "{:?}", run.notes());
    drop(run);
    fs::write(folder.checkpoint(), b"").unwrap();
    assert!(matches!(
        Run::resume(rods_scene(place.path()), folder, &Compute::Cpu),
        Err(RunError::Record(RecordError::State { .. }))
    ));
}

#[test]
fn another_scene_is_refused_by_its_keys() {
    let place = tempfile::tempdir().unwrap();
    drop(rods(place.path()));
    let mut scene = rods_scene(place.path());
    scene.time.dt *= 2.0;
    let folder = Folder::open(&place.path().join("run")).unwrap();
    match Run::resume(scene, folder, &Compute::Cpu) {
        Err(RunError::Record(RecordError::OtherScene { keys, .. })) => assert_eq!(keys, ["time.dt"]),
        other => panic!("{:?}", other.err()),
    }
}

/// The run to the end of its scene, and on to a later one.
fn on_to(place: &Path, scene: &Scene, until: f64) -> Result<Summary, RunError> {
    let folder = Folder::open(&place.join("run")).unwrap();
    Ok(to_end(Run::resume_until(scene.clone(), folder, until, &Compute::Cpu)?))
}

fn begun(place: &Path, scene: Scene) -> Run {
    Run::start(Simulation::new(scene).unwrap(), Folder::create(&place.join("run")).unwrap(), Duration::ZERO).unwrap()
}

#[test]
fn a_finished_run_goes_on_to_a_later_end_with_the_rows_and_the_bits_of_one_run() {
    let (place, whole_place) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut scene = rods_scene(place.path());
    scene.output.step_stride = 4;
    scene.time.end = scene.time.start + 10.0 * scene.time.dt;
    to_end(begun(place.path(), scene.clone()));
    let end = scene.time.start + 23.0 * scene.time.dt;
    let extended = on_to(place.path(), &scene, end).unwrap();
    let mut longer = scene.clone();
    longer.output.every = scene.output_every();
    longer.time.end = end;
    let whole = to_end(begun(whole_place.path(), longer.clone()));
    assert_eq!((&extended.state_hash, extended.steps), (&whole.state_hash, 23));
    assert_eq!(extended.scene_hash, whole.scene_hash);
    let [ours, theirs] = [&place, &whole_place].map(|place| rows(&place.path().join("run")));
    assert_eq!(ours, theirs);
    // After a crash between the later end in its scene and its checkpoint, it can be requested again.
    let refused = on_to(place.path(), &longer, 0.5 * end).err().unwrap();
    assert!(refused.to_string().contains("name a later one"), "{refused}");
}

#[test]
fn a_run_whose_last_step_was_shorter_does_not_go_on() {
    let place = tempfile::tempdir().unwrap();
    let mut scene = rods_scene(place.path());
    scene.time.end = scene.time.start + 2.5 * scene.time.dt;
    let mut run = begun(place.path(), scene.clone());
    // Before that step it is allowed.
    run.advance().unwrap();
    run.finish().unwrap();
    let end = scene.time.end;
    let mut longer = scene.clone();
    let summary = on_to(place.path(), &scene, end + 2.25 * scene.time.dt).unwrap();
    assert_eq!(summary.steps, 5);
    longer.output.every = scene.output_every();
    longer.time.end = end + 2.25 * scene.time.dt;
    let refused = on_to(place.path(), &longer, 10.0 * end).err().unwrap();
    assert!(refused.to_string().contains("final.json"), "{refused}");
}

#[test]
fn a_folder_that_a_run_is_writing_into_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let running = rods(place.path());
    let folder = Folder::open(&place.path().join("run")).unwrap();
    assert!(matches!(
        Run::resume(rods_scene(place.path()), folder, &Compute::Cpu),
        Err(RunError::Record(RecordError::InUse { .. }))
    ));
    drop(running);
}

#[test]
fn rows_that_are_missing_are_told() {
    let place = tempfile::tempdir().unwrap();
    let mut run = rods(place.path());
    for _ in 0..9 {
        run.advance().unwrap();
    }
    run.checkpoint().unwrap();
    drop(run);
    let folder = Folder::open(&place.path().join("run")).unwrap();
    let text = fs::read_to_string(folder.steps()).unwrap();
    let cut: Vec<&str> = text.lines().filter(|line| !line.starts_with("9,")).collect();
    fs::write(folder.steps(), cut.join("\n")).unwrap();
    let refused = Run::resume(rods_scene(place.path()), folder, &Compute::Cpu).err().unwrap();
    assert!(refused.to_string().contains("step 9"), "{refused}");
}
