//! A run: a simulation that steps to its end and writes its folder.

mod branch;
mod error;
#[cfg(feature = "mpi")]
mod follow;
mod hand;
mod measured;
mod memory;
mod own;
mod schedule;
mod steer;
mod summary;
mod until;
mod way;

pub use branch::Branch;
pub use error::RunError;
#[cfg(feature = "mpi")]
pub use follow::{follow, together};
pub use memory::peak_bytes;
pub use summary::{Constraints, PeakBytes, Recursions, RunStatus, SolverSummary, Summary};

use crate::record::lives::Lives;
use crate::record::steps::Steps;
use crate::record::{
    Folder, Header, LcpHeader, Parent, RecordError, StateError, Totals, differing_keys, durable, encode,
    encode_with_forces, read_state, scene_hash, write_lcp, write_state,
};
use crate::render::{Backdrop, View, picture};
use crate::scene::{Scene, StopReason};
use crate::simulation::{Compute, Simulation};
use crate::step::{Fault, State, StepReport, max_overlap_but};
use measured::Measures;
use schedule::Schedule;
use std::path::Path;
use std::time::{Duration, Instant};

/// Wall time between checkpoints, the most that a crash loses. A checkpoint costs far less than a second (22 MB at
/// 131,072 rods), so once per minute is negligible.
pub const CHECKPOINT_EVERY: Duration = Duration::from_secs(60);

/// The note of a run that begins with a state without multipliers.
const NO_MULTIPLIERS: &str = "the state has no multipliers of contacts, so the run goes on within its tolerances but \
                              not to the bits of the other run; checkpoints have them, and states with output.forces";

/// The size of a run's final picture in pixels: a run of seconds should not wait for it.
const PICTURE_SIDES: [u32; 2] = [1280, 720];

/// A simulation and its folder.
///
/// ```
/// use relcp::record::Folder;
/// use relcp::run::{Run, RunStatus};
/// use relcp::{Scene, Simulation};
/// let parent = tempfile::tempdir()?;
/// let scene = Scene::built_in("three-capsules")?;
/// let folder = Folder::create_in(parent.path(), &scene.name)?;
/// let mut run = Run::start(Simulation::new(scene)?, folder, std::time::Duration::ZERO)?;
/// while !run.done() {
///     run.advance()?;
/// }
/// let summary = run.finish()?;
/// assert_eq!((summary.status, summary.steps), (RunStatus::Done, 8));
/// # Ok::<(), relcp::Error>(())
/// ```
pub struct Run {
    simulation: Simulation,
    folder: Folder,
    steps: Steps,
    measures: Option<Measures>,
    lives: Option<Lives>,
    schedule: Schedule,
    /// Changes of the scene that the schedule and the measures follow.
    changes_followed: usize,
    scene_hash: String,
    totals: Totals,
    checkpoint_every: Duration,
    last_checkpoint: Instant,
    notes: Vec<String>,
    /// The last step since the run was begun or resumed, and its wall time.
    latest: Option<(StepReport, Duration)>,
    /// The summary of a run that stopped at a failed step.
    stopped: Option<Summary>,
}

impl Run {
    /// Starts a run in a new folder. `setup` is the wall time for placing its bodies.
    ///
    /// # Errors
    /// A file that cannot be written; [`StateError::Custom`] if a body has a custom shape, before anything is written.
    pub fn start(simulation: Simulation, folder: Folder, setup: Duration) -> Result<Self, RunError> {
        Run::begin(simulation, folder, setup, None)
    }

    /// [`Run::start`] of a simulation that begins with a state of another run ([`Branch::simulate`]), which the
    /// [`from.json`](Folder::parent) of the folder names.
    ///
    /// # Errors
    /// As [`Run::start`].
    pub fn start_from(
        simulation: Simulation,
        folder: Folder,
        parent: Parent,
        setup: Duration,
    ) -> Result<Self, RunError> {
        Run::begin(simulation, folder, setup, Some(parent))
    }

    /// Starts a run in a new folder: with its scene's own bodies, or with a state of another run.
    fn begin(
        simulation: Simulation,
        folder: Folder,
        setup: Duration,
        parent: Option<Parent>,
    ) -> Result<Self, RunError> {
        let begun = Instant::now();
        if let Some(body) = simulation.state()?.bodies.first_custom() {
            return Err(RecordError::state(folder.path())(StateError::Custom { body }).into());
        }
        let scene = simulation.whole_scene().clone();
        let steps = Steps::create(&folder.steps())?;
        let measures = Measures::create(&folder.measures(), &scene)?;
        let lives = removes(&scene).then(|| Lives::create(&folder.lineage(), scene.group_names())).transpose()?;
        if let Some(parent) = &parent {
            durable::write_json(&folder.parent(), parent)?;
        }
        write_scene(&folder.scene(), &scene.with_defaults())?;
        let mut totals = Totals {
            start_max_overlap: max_overlap_but(&scene.fixed(), &simulation.state()?.bodies, &simulation.walls()),
            ..Totals::default()
        };
        totals.wall.setup = (setup + begun.elapsed()).as_secs_f64();
        totals.wall.total = totals.wall.setup;
        totals.taken_up_by(&simulation);
        let (schedule, scene_hash) = (Schedule::of(&simulation, parent.as_ref()), scene_hash(&scene));
        let mut run = Run::new(simulation, folder, (steps, measures, lives), schedule, scene_hash, totals);
        if let Some(parent) = parent.filter(|parent| !parent.multipliers) {
            run.notes.push(format!("{NO_MULTIPLIERS} (step {} of {})", parent.step, parent.run));
        }
        run.record_state()?;
        run.checkpoint()?;
        Ok(run)
    }

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

    fn take_up(mut scene: Scene, folder: Folder, until: Option<f64>, compute: &Compute) -> Result<Self, RunError> {
        let begun = Instant::now();
        let mut notes = Vec::new();
        let (header, state, fallback) = read_checkpoint(&folder)?;
        let known = header.scene == scene_hash(&scene)
            || (until.is_some() && until::is_of(&header, &scene))
            || steer::is_of(&header, &folder, &scene);
        if !known {
            let keys = differing_keys(&folder.scene(), &scene);
            return Err(RecordError::OtherScene { path: folder.path().into(), keys }.into());
        }
        let no_later_end = |why: String| RecordError::NoLaterEnd { path: folder.path().into(), why };
        if let Some(until) = until {
            scene = until::extended(&scene, header.step, until).map_err(no_later_end)?;
        }
        let scene_hash = scene_hash(&scene);
        if let Some(fault) = fallback {
            // Removes the damaged one, so that the next checkpoint does not replace this good one.
            durable::rename(&folder.previous_checkpoint(), &folder.checkpoint())?;
            notes.push(format!("{fault}; continuing from the previous checkpoint, at step {}", header.step));
        }
        if header.program != env!("CARGO_PKG_VERSION") {
            notes.push(format!(
                "the run was begun by version {}: its last bits may differ from here on",
                header.program
            ));
        }
        let parent = Parent::of(&folder)?;
        let simulation = Simulation::start(compute, scene, state)?;
        let schedule = Schedule::of(&simulation, parent.as_ref());
        if let Some(reason) = simulation.stopped_by().filter(|_| until.is_some()) {
            let why = if reason == StopReason::NoBodies { until::EMPTY } else { until::STOPPED };
            return Err(no_later_end(why.into()).into());
        }
        let last_row = match simulation.stopped_by() {
            Some(_) => Some(header.step).filter(|step| *step > parent.map_or(0, |parent| parent.step)),
            None => schedule.last_row(header.step),
        };
        let steps = Steps::reopen(&folder.steps(), last_row)?;
        let measures = Measures::reopen(&folder.measures(), simulation.scene(), last_row)?;
        let groups = simulation.scene().group_names();
        let begun_file = removes(simulation.scene()) || Lives::is_begun(&folder.lineage())?;
        let lives = begun_file.then(|| Lives::reopen(&folder.lineage(), groups, header.step)).transpose()?;
        folder.rewind(header.step)?;
        let mut totals = header.totals.unwrap_or_default();
        let setup = begun.elapsed().as_secs_f64();
        totals.wall.setup += setup;
        totals.wall.total += setup;
        totals.taken_up_by(&simulation);
        notes.extend(totals.own.iter().map(|own| own::without(own)));
        let saved = folder.count_lcps()?;
        let mut run = Run::new(simulation, folder, (steps, measures, lives), schedule, scene_hash, totals);
        run.simulation.count_lcps(saved);
        run.notes = notes;
        if until.is_some() {
            write_scene(&run.folder.scene(), &run.simulation.whole_scene().with_defaults())?;
            run.checkpoint()?;
        }
        Ok(run)
    }

    fn new(
        simulation: Simulation,
        folder: Folder,
        (steps, measures, lives): (Steps, Option<Measures>, Option<Lives>),
        schedule: Schedule,
        scene_hash: String,
        totals: Totals,
    ) -> Self {
        let (checkpoint_every, last_checkpoint) = (CHECKPOINT_EVERY, Instant::now());
        let (notes, changes_followed) = (Vec::new(), simulation.changes_made());
        Run {
            simulation,
            folder,
            steps,
            measures,
            lives,
            schedule,
            changes_followed,
            scene_hash,
            totals,
            checkpoint_every,
            last_checkpoint,
            notes,
            latest: None,
            stopped: None,
        }
    }

    /// Sets the wall time between checkpoints, by default [`CHECKPOINT_EVERY`].
    pub fn checkpoint_every(&mut self, wall: Duration) {
        self.checkpoint_every = wall;
    }

    /// Notes for the user on the resumption.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The simulation.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Its folder.
    pub fn folder(&self) -> &Folder {
        &self.folder
    }

    /// The totals so far.
    pub fn totals(&self) -> &Totals {
        &self.totals
    }

    /// Whether the scene's end is reached.
    pub fn done(&self) -> bool {
        self.simulation.done()
    }

    /// Takes one step and records it.
    ///
    /// If the step fails, the state before it becomes the checkpoint and `final.json`, and the summary has the reason.
    pub fn advance(&mut self) -> Result<StepReport, RunError> {
        let begun = Instant::now();
        let stepped = self.simulation.step();
        self.save_lcps()?;
        let report = match stepped {
            Ok(report) => report,
            // A failed device has no state: the last checkpoint remains.
            Err(fault @ (Fault::Device(_) | Fault::Processes(_))) => return Err(fault.into()),
            Err(fault) => {
                self.stopped = Some(self.close(RunStatus::Stopped, Some(&fault))?);
                return Err(fault.into());
            }
        };
        let wall = begun.elapsed();
        self.totals.add(&report, self.simulation.scene().contact.overlap_tolerance, wall);
        self.record(&report, wall)?;
        Ok(report)
    }

    /// Without `removal` the file begins with the first body that a change takes out.
    fn record_lives(&mut self) -> Result<(), RecordError> {
        let ended = self.simulation.ended();
        if self.lives.is_none() && !ended.is_empty() {
            let groups = self.simulation.scene().group_names();
            self.lives = Some(Lives::create(&self.folder.lineage(), groups)?);
        }
        self.lives.as_mut().map_or(Ok(()), |lives| lives.push(ended))
    }

    fn record(&mut self, report: &StepReport, wall: Duration) -> Result<(), RunError> {
        let begun = Instant::now();
        tell(report, self.simulation.scene().contact.overlap_tolerance, wall);
        self.latest = Some((*report, wall));
        self.follow_changes();
        self.record_lives()?;
        // The schedule does not know the end in advance.
        let done = self.simulation.done();
        if done || self.schedule.row_due(report.step) {
            self.steps.push(report, wall.as_secs_f64())?;
            if let Some(measures) = &mut self.measures {
                measures.push(&self.simulation)??;
            }
        }
        if done || self.schedule.state_due(report.step) {
            self.record_state()?;
            self.steps.flush()?;
            self.measures.as_mut().map_or(Ok(()), Measures::flush)?;
            self.lives.as_mut().map_or(Ok(()), Lives::flush)?;
        }
        self.count_output(begun);
        if self.last_checkpoint.elapsed() >= self.checkpoint_every {
            self.checkpoint()?;
        }
        Ok(())
    }

    /// Records from now on as the scene with its changes so far.
    fn follow_changes(&mut self) {
        let made = self.simulation.changes_made();
        if made != self.changes_followed {
            self.changes_followed = made;
            self.schedule = self.schedule.changed(self.simulation.scene());
            self.measures.as_mut().into_iter().for_each(|measures| measures.follow(self.simulation.scene()));
        }
    }

    /// Saves the LCPs that the scene's `solver.dump` selects.
    fn save_lcps(&mut self) -> Result<(), RunError> {
        let begun = Instant::now();
        let kept = self.simulation.take_lcps();
        if kept.is_empty() {
            return Ok(());
        }
        let folder = self.folder.lcps();
        std::fs::create_dir_all(&folder).map_err(RecordError::io(&folder, "create the folder"))?;
        for kept in kept {
            let header = LcpHeader::new(&self.simulation, &kept);
            write_lcp(&self.folder.lcp(kept.step, kept.recursion), &kept.lcp, &header)?;
        }
        self.count_output(begun);
        Ok(())
    }

    fn record_state(&mut self) -> Result<(), RunError> {
        let state = self.simulation.state()?;
        self.totals.farthest_way = self.totals.farthest_way.max(way::farthest(self.simulation.scene(), &state.bodies));
        let path = self.folder.state(state.step);
        log::info!("state of step {} into {}", state.step, path.display());
        let (hash, time) = (&self.scene_hash, self.simulation.time());
        let bytes = match self.simulation.scene().output.forces {
            true => encode_with_forces(state, hash, time),
            false => encode(state, hash, time, None),
        };
        let bytes = bytes.map_err(RecordError::state(&path))?;
        Ok(durable::place(&path, &bytes)?)
    }

    /// Writes the checkpoint, and keeps the one before it. The rows and states up to it are synced first.
    pub fn checkpoint(&mut self) -> Result<(), RunError> {
        let begun = Instant::now();
        self.steps.sync()?;
        self.measures.as_mut().map_or(Ok(()), Measures::sync)?;
        self.lives.as_mut().map_or(Ok(()), Lives::sync)?;
        durable::sync_folder(&self.folder.states())?;
        let path = self.folder.checkpoint();
        log::info!("checkpoint into {}", path.display());
        if path.exists() {
            durable::rename(&path, &self.folder.previous_checkpoint())?;
        }
        write_state(&path, self.simulation.state()?, &self.scene_hash, self.simulation.time(), Some(&self.totals))?;
        self.last_checkpoint = Instant::now();
        self.count_output(begun);
        Ok(())
    }

    fn count_output(&mut self, begun: Instant) {
        let spent = begun.elapsed().as_secs_f64();
        self.totals.wall.output += spent;
        self.totals.wall.total += spent;
    }

    /// Ends the run: at its end, or before it, to be resumed. Writes a checkpoint, a picture and the summary, and the
    /// final state if the end is reached. A run that stopped at a failed step has written them.
    pub fn finish(mut self) -> Result<Summary, RunError> {
        if let Some(summary) = self.stopped {
            return Ok(summary);
        }
        let status = match (self.simulation.done(), self.totals.clean()) {
            (false, _) => RunStatus::Interrupted,
            (true, true) => RunStatus::Done,
            (true, false) => RunStatus::OutOfTolerance,
        };
        self.close(status, None)
    }

    fn close(&mut self, status: RunStatus, stopped: Option<&Fault>) -> Result<Summary, RunError> {
        self.checkpoint()?;
        let begun = Instant::now();
        let scene = self.simulation.scene();
        let overlap = max_overlap_but(&scene.fixed(), &self.simulation.state()?.bodies, &self.simulation.walls());
        if self.simulation.done() || stopped.is_some() {
            write_scene(&self.folder.last(), &self.simulation.final_scene()?)?;
        }
        // Before the picture, whose memory must not count as the simulation's.
        let mut summary = Summary::new(&self.simulation, &self.totals, &self.scene_hash, (status, stopped), overlap)?;
        self.draw()?;
        self.count_output(begun);
        summary.wall_seconds = self.totals.wall;
        durable::write_json(&self.folder.summary(), &summary)?;
        Ok(summary)
    }

    fn draw(&self) -> Result<(), RunError> {
        if !self.simulation.scene().output.picture {
            return Ok(());
        }
        let [width, height] = PICTURE_SIDES;
        let view = View { width, height, planar: self.simulation.scene().planar, ..View::default() };
        let path = self.folder.picture();
        let mut bytes = Vec::new();
        let state = self.simulation.state()?;
        let bodies = state.bodies.wrapped();
        let mut image = picture(&bodies, &view);
        let backdrop = Backdrop::of(self.simulation.scene());
        let backdrop = backdrop.of_state(self.simulation.time(), &bodies.walls, &state.fields);
        backdrop.behind(&mut image, &view, &bodies);
        image.encode(&mut bytes).map_err(RecordError::io(&path, "pack it"))?;
        Ok(durable::write(&path, &bytes)?)
    }
}

/// Logs a step.
fn tell(report: &StepReport, tolerance: f64, wall: Duration) {
    let StepReport { step, bodies, constraints, recursions, products, residual, max_overlap, .. } = report;
    log::debug!(
        "step {step}: {bodies} bodies, {constraints} constraints, {recursions} recursions, {products} products, residual {residual:.2e}, \
        overlap {max_overlap:.2e}, {:.3} s",
        wall.as_secs_f64()
    );
    if report.failed_attempts > 0 {
        let StepReport { failed_attempts, pieces, waiting, by_cpu, .. } = report;
        log::info!(
            "step {step}: {failed_attempts} attempts failed; taken in {pieces} pieces, {waiting} cells waiting, by the CPU: {by_cpu}"
        );
    }
    if report.unconverged > 0 {
        log::warn!("step {step}: a solve ended as {:?} with a residual of {residual:.2e}", report.status);
    }
    if *max_overlap > tolerance {
        log::warn!("step {step}: overlap {max_overlap:.3e} of {tolerance:.1e} allowed, {:?}", report.worst_pair);
    }
}

fn removes(scene: &Scene) -> bool {
    !scene.removal.is_empty()
}

fn write_scene(path: &Path, scene: &Scene) -> Result<(), RecordError> {
    let mut bytes = Vec::new();
    scene.write_json(&mut bytes).map_err(RecordError::io(path, "write it"))?;
    durable::write(path, &bytes)
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
