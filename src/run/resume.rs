//! A run that goes on from its checkpoint, to its scene's end or to a later one.

use super::{Measures, Run, RunError, Tables, own, removes, steer, until, write_scene};
use crate::record::lives::Lives;
use crate::record::steps::Steps;
use crate::record::{Folder, Header, Parent, RecordError, differing_keys, durable, read_state, scene_hash};
use crate::run::schedule::Schedule;
use crate::scene::{Scene, StopReason};
use crate::simulation::{Compute, Simulation};
use crate::step::State;
use std::time::Instant;

impl Run {
    /// Continues the run of `scene` in `folder` from its checkpoint, to the same bits as an uninterrupted run.
    ///
    /// If the checkpoint is damaged, the previous one is used, with a [note](Run::notes). Rows and states after the
    /// checkpoint are removed; the run makes them again.
    ///
    /// # Errors
    /// [`RecordError::OtherScene`] if the folder belongs to a different scene; a checkpoint that cannot be read, a file
    /// that cannot be written, and everything that
    /// [`SimulationBuilder::build`](crate::simulation::SimulationBuilder::build) refuses.
    pub fn resume(scene: Scene, folder: Folder, compute: &Compute) -> Result<Self, RunError> {
        Run::take_up(scene, folder, None, compute)
    }

    /// [`Run::resume`] to a later end than the scene's: a finished run continues, on the CPU to the same bits as a run
    /// that was started with this end. Its `scene.json` then has the later end.
    ///
    /// # Errors
    /// As [`Run::resume`]; [`RecordError::NoLaterEnd`] if the end is not later, if the run's last step was shorter than
    /// the others, or if `growth.stop` ended it.
    pub fn resume_until(scene: Scene, folder: Folder, until: f64, compute: &Compute) -> Result<Self, RunError> {
        Run::take_up(scene, folder, Some(until), compute)
    }

    fn take_up(scene: Scene, folder: Folder, until: Option<f64>, compute: &Compute) -> Result<Self, RunError> {
        let begun = Instant::now();
        let (header, state, fallback) = read_checkpoint(&folder)?;
        let scene = scene_to_continue(scene, &folder, &header, until)?;
        let scene_hash = scene_hash(&scene);
        let mut notes = notes_on(&folder, &header, fallback)?;
        let parent = Parent::of(&folder)?;
        let simulation = Simulation::start(compute, scene, state)?;
        if let Some(reason) = simulation.stopped_by().filter(|_| until.is_some()) {
            let why = if reason == StopReason::NoBodies { until::EMPTY } else { until::STOPPED };
            return Err(no_later_end(&folder, why.into()).into());
        }
        let schedule = Schedule::of(&simulation, parent.as_ref());
        let last_row = match simulation.stopped_by() {
            Some(_) => Some(header.step).filter(|step| *step > parent.map_or(0, |parent| parent.step)),
            None => schedule.last_row(header.step),
        };
        let tables = reopen(&simulation, &folder, header.step, last_row)?;
        folder.rewind(header.step)?;
        let mut totals = header.totals.unwrap_or_default();
        let setup = begun.elapsed().as_secs_f64();
        totals.wall.setup += setup;
        totals.wall.total += setup;
        totals.taken_up_by(&simulation);
        notes.extend(totals.own.iter().map(|own| own::without(own)));
        let saved = folder.count_lcps()?;
        let mut run = Run::new(simulation, folder, tables, schedule, scene_hash, totals);
        run.simulation.count_lcps(saved);
        run.notes = notes;
        if until.is_some() {
            write_scene(&run.folder.scene(), &run.simulation.whole_scene().with_defaults())?;
            run.checkpoint()?;
        }
        Ok(run)
    }
}

/// The scene that the folder's run goes on with; refused where the checkpoint is of another.
fn scene_to_continue(scene: Scene, folder: &Folder, header: &Header, until: Option<f64>) -> Result<Scene, RecordError> {
    let known = header.scene == scene_hash(&scene)
        || (until.is_some() && until::is_of(header, &scene))
        || steer::is_of(header, folder, &scene);
    if !known {
        let keys = differing_keys(&folder.scene(), &scene);
        return Err(RecordError::OtherScene { path: folder.path().into(), keys });
    }
    match until {
        Some(until) => until::extended(&scene, header.step, until).map_err(|why| no_later_end(folder, why)),
        None => Ok(scene),
    }
}

fn no_later_end(folder: &Folder, why: String) -> RecordError {
    RecordError::NoLaterEnd { path: folder.path().into(), why }
}

/// What the user must know of the checkpoint. A damaged one is removed, so that the next checkpoint does not replace
/// the good one before it.
fn notes_on(folder: &Folder, header: &Header, fallback: Option<RecordError>) -> Result<Vec<String>, RecordError> {
    let mut notes = Vec::new();
    if let Some(fault) = fallback {
        durable::rename(&folder.previous_checkpoint(), &folder.checkpoint())?;
        notes.push(format!("{fault}; continuing from the previous checkpoint, at step {}", header.step));
    }
    if header.program != env!("CARGO_PKG_VERSION") {
        let version = &header.program;
        notes.push(format!("the run was begun by version {version}: its last bits may differ from here on"));
    }
    Ok(notes)
}

/// The folder's tables, without the rows after the checkpoint.
fn reopen(simulation: &Simulation, folder: &Folder, step: u64, last_row: Option<u64>) -> Result<Tables, RunError> {
    let scene = simulation.scene();
    let steps = Steps::reopen(&folder.steps(), last_row)?;
    let measures = Measures::reopen(&folder.measures(), scene, last_row)?;
    let has_lives = removes(scene) || Lives::is_begun(&folder.lineage())?;
    let lives = has_lives.then(|| Lives::reopen(&folder.lineage(), scene.group_names(), step)).transpose()?;
    Ok((steps, measures, lives))
}

/// The last readable checkpoint, with the fault of the newer one if it is the older. If neither is readable, the fault
/// of the newer one.
fn read_checkpoint(folder: &Folder) -> Result<(Header, State, Option<RecordError>), RecordError> {
    match read_state(&folder.checkpoint()) {
        Ok((header, state)) => Ok((header, state, None)),
        Err(fault) => match read_state(&folder.previous_checkpoint()) {
            Ok((header, state)) => Ok((header, state, Some(fault))),
            Err(_) => Err(fault),
        },
    }
}
