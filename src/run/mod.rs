//! A run: a simulation that steps to its end and writes its folder.

mod branch;
mod error;
mod files;
#[cfg(feature = "mpi")]
mod follow;
mod hand;
mod measured;
mod memory;
mod own;
mod resume;
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
pub use way::start_warning;

use crate::record::lives::Lives;
use crate::record::steps::Steps;
use crate::record::{Folder, Parent, RecordError, StateError, Totals, durable, scene_hash};
use crate::scene::Scene;
use crate::simulation::Simulation;
use crate::step::{Fault, StepReport, max_overlap_but};
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

/// The tables of a run.
type Tables = (Steps, Option<Measures>, Option<Lives>);

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

    fn new(
        simulation: Simulation,
        folder: Folder,
        (steps, measures, lives): Tables,
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
                self.totals.add_failed(begun.elapsed());
                self.stopped = Some(self.close(RunStatus::Stopped, Some(&fault))?);
                return Err(fault.into());
            }
        };
        let wall = begun.elapsed();
        self.totals.add(&report, self.simulation.scene().contact.overlap_tolerance, wall);
        self.record(&report, wall)?;
        Ok(report)
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
}

fn removes(scene: &Scene) -> bool {
    !scene.removal.is_empty()
}

fn write_scene(path: &Path, scene: &Scene) -> Result<(), RecordError> {
    let mut bytes = Vec::new();
    scene.write_json(&mut bytes).map_err(RecordError::io(path, "write it"))?;
    durable::write(path, &bytes)
}
