//! Runs on which forces and rules of a user's own act, which are not in the folder; and their tables, read back.

use crate::to_end;
use relcp::bodies::Bodies;
use relcp::dynamics::Load;
use relcp::record::{EarlierRun, EarlierState, Folder, Table, TableColumn};
use relcp::run::{Run, RunError, RunStatus};
use relcp::simulation::{Cell, CellState, CellValues, Rules};
use relcp::{Compute, Fault, Scene, Simulation};
use std::path::Path;
use std::time::Duration;

/// A cell that grows, over 40 steps.
fn scene() -> Scene {
    let removal = "removal=[{\"outside\":{\"sphere\":{\"center\":[0,0,0],\"radius\":50}}}]";
    Scene::load("colony", ["time.dt=0.01", "time.end=0.4", "output.picture=false", removal]).unwrap()
}

fn start(folder: &Path) -> Run {
    Run::start(Simulation::new(scene()).unwrap(), Folder::create(folder).unwrap(), Duration::ZERO).unwrap()
}

fn resume(folder: &Path) -> Run {
    Run::resume(scene(), Folder::open(folder).unwrap(), &Compute::Cpu).unwrap()
}

fn push(_: &Bodies, _: usize, _: f64) -> Load {
    Load { force: glam::DVec3::X, ..Load::default() }
}

/// Growth at half the rate, until a cell is longer than this.
struct Half(f64);

impl Rules for Half {
    fn update(&mut self, state: &CellState<'_>, cells: &mut CellValues) -> Result<(), String> {
        cells.rate.fill(0.5);
        let longest = state.bodies.shape.iter().map(|shape| shape.major_axis()).fold(0.0, f64::max);
        if longest > self.0 { Err("it is long".into()) } else { Ok(()) }
    }

    fn divide(&mut self, _: &Cell, _: [&mut Cell; 2]) -> Result<(), String> {
        Ok(())
    }
}

#[test]
fn a_run_that_is_resumed_without_what_acted_on_it_says_so() {
    let place = tempfile::tempdir().unwrap();
    let (whole, half) = (place.path().join("whole"), place.path().join("half"));
    let ruled = |mut run: Run| {
        run.add_force(Box::new(push));
        run.set_rules(Box::new(Half(9.0)));
        run
    };
    let expected = to_end(ruled(start(&whole)));
    let mut run = ruled(start(&half));
    (0..17).for_each(|_| assert!(run.advance().is_ok()));
    assert_eq!(run.finish().unwrap().status, RunStatus::Interrupted);
    let resumed = resume(&half);
    let notes = resumed.notes().join("; ");
    assert!(notes.contains("forces of a user's own") && notes.contains("rules of a user's own"), "{notes}");
    let resumed = ruled(resumed);
    assert!(resumed.notes().is_empty(), "{:?}", resumed.notes());
    assert_eq!(to_end(resumed).state_hash, expected.state_hash);
    let plain = place.path().join("plain");
    let plain_hash = to_end(start(&plain)).state_hash;
    assert_ne!(plain_hash, expected.state_hash);
    let mut again = Run::resume_until(scene(), Folder::open(&plain).unwrap(), 0.41, &Compute::Cpu).unwrap();
    assert!(again.notes().is_empty() && again.advance().is_ok());
}

#[test]
fn a_step_that_its_user_interrupts_is_to_be_taken_again() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("run");
    let mut run = start(&folder);
    run.set_rules(Box::new(Half(2.2)));
    let fault = loop {
        if let Err(fault) = run.advance() {
            break fault;
        }
    };
    assert!(matches!(fault, RunError::Fault(Fault::Rules { .. })), "{fault}");
    let (steps, last) = (run.simulation().steps(), run.folder().last());
    assert!(steps > 10 && last.is_file());
    run.interrupted().unwrap();
    let summary = run.finish().unwrap();
    assert_eq!((summary.status, summary.steps), (RunStatus::Interrupted, steps));
    assert!(!last.exists());
    assert_eq!(EarlierRun::state_of(&folder), Some(EarlierState::Unfinished));
    let summary = to_end(resume(&folder));
    assert_eq!((summary.status, summary.steps), (RunStatus::Done, 40));
}

#[test]
fn tables_are_read_back_as_they_are_written() {
    let place = tempfile::tempdir().unwrap();
    let folder = Folder::view(place.path());
    let mut run = start(&place.path().join("run"));
    let mut times = Vec::new();
    while !run.done() {
        times.push(run.advance().unwrap().time);
    }
    let path = run.folder().steps();
    run.finish().unwrap();
    let table = Table::steps(&path).unwrap();
    assert_eq!(table.column("time"), Some(&TableColumn::Numbers(times)));
    assert_eq!(table.column("step"), Some(&TableColumn::Integers((1..=40).collect())));
    let Some(TableColumn::Numbers(sliding)) = table.column("sliding") else { panic!("no column") };
    assert!(sliding.len() == 40 && sliding.iter().all(|cell| cell.is_nan()));
    let lives = Table::lineage(&path.with_file_name("lineage.csv")).unwrap();
    assert_eq!(lives.columns.len(), 9);
    assert!(Table::measures(&folder.measures()).is_err());
}
