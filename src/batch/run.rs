//! Runs members, several at a time.
//!
//! Each member is an ordinary run, so its bits do not depend on concurrent members or on threads. A failed member does
//! not stop the others.

use super::error::{BatchError, MemberError};
use super::member_state::{Folders, MemberState};
use super::plan::{Member, Plan};
use crate::record::Folder;
use crate::run::{Run, RunError, RunStatus};
use crate::scene::{FaultKind, Scene};
use crate::simulation::{Compute, Simulation};
use crate::step::{State, StepReport};
use rayon::ThreadPool;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// How to run them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// The largest number of concurrent members.
    pub jobs: usize,
    /// Threads of all concurrent members together; each gets its share, at least one.
    pub threads: usize,
    /// Whether failed members continue from their last accepted state.
    pub retry: bool,
}

/// How a member ended.
#[derive(Debug)]
pub enum Ended {
    /// It was left alone: an earlier run ended with this status.
    Before(RunStatus),
    /// It ran, and has this status.
    Now(RunStatus),
    /// It was not started, because the batch was stopped.
    NotBegun,
    /// It failed.
    Failed(MemberError),
}

/// Chooses the backend of a scene; see [`Compute`]. Members of a [`gpu::Ensemble`](crate::gpu::Ensemble) share one
/// device.
pub type Settle<'a> = dyn Fn(&Scene) -> Result<Compute, MemberError> + Sync + 'a;

/// Observes a batch from several threads, and can stop it.
pub trait Watch: Sync {
    /// Whether all members should stop after their current step, with a checkpoint.
    fn stop(&self) -> bool {
        false
    }
    /// The number of members that will run, and of all their steps.
    fn planned(&self, _members: usize, _steps: u64) {}
    /// A member starts or continues.
    fn begun(&self, _member: &Member, _run: &Run) {}
    /// A member took a step.
    fn stepped(&self, _member: &Member, _report: &StepReport) {}
    /// A member ended, or was left alone.
    fn ended(&self, _member: &Member, _ended: &Ended) {}
}

/// A member to run.
struct Task<'a> {
    place: usize,
    member: &'a Member,
    folder: PathBuf,
    state: MemberState,
}

struct Crew<'a> {
    plan: &'a Plan,
    tasks: Vec<Task<'a>>,
    next: AtomicUsize,
    settle: &'a Settle<'a>,
    watch: &'a dyn Watch,
    ended: Mutex<Vec<(usize, Ended)>>,
}

/// Runs these members of a plan in folders under `out`, and returns how each ended, in the order of `members`.
///
/// ```no_run
/// use relcp::batch::{Options, Plan, Table, Watch, run};
/// use relcp::simulation::Compute;
/// struct Nobody;
/// impl Watch for Nobody {}
/// let plan = Plan::open("rates.json".as_ref())?;
/// let out = plan.folder_in("runs".as_ref());
/// let options = Options { jobs: 2, threads: 4, retry: false };
/// run(&plan, &out, plan.members(), options, &|_| Ok(Compute::Cpu), &Nobody)?;
/// print!("{}", Table::of(&plan, &out, plan.members())?);
/// # Ok::<(), relcp::batch::BatchError>(())
/// ```
///
/// All folders are checked before anything runs. A finished member is left alone, and a stopped one continues from its
/// checkpoint.
///
/// # Errors
/// A folder that belongs to a different scene or contains other files; then no folder is changed. Failures of running
/// members are in their [`Ended`].
pub fn run(
    plan: &Plan,
    out: &Path,
    members: &[Member],
    options: Options,
    settle: &Settle,
    watch: &dyn Watch,
) -> Result<Vec<Ended>, BatchError> {
    let (tasks, mut ended) = tasks(plan, out, members, options.retry)?;
    let steps = tasks.iter().map(|task| task.member.steps).sum();
    watch.planned(tasks.len(), steps);
    for (place, ended) in &ended {
        watch.ended(&members[*place], ended);
    }
    let jobs = options.jobs.clamp(1, tasks.len().max(1));
    let pools: Vec<ThreadPool> = (0..jobs)
        .map(|_| rayon::ThreadPoolBuilder::new().num_threads((options.threads / jobs).max(1)).build())
        .collect::<Result<_, _>>()
        .map_err(|e| BatchError::Threads(e.to_string()))?;
    let crew = Crew { plan, tasks, next: AtomicUsize::new(0), settle, watch, ended: Mutex::default() };
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| pool.install(|| crew.work()));
        }
    });
    ended.extend(crew.ended.into_inner().unwrap_or_else(PoisonError::into_inner));
    ended.sort_by_key(|(place, _)| *place);
    Ok(ended.into_iter().map(|(_, ended)| ended).collect())
}

type Sorted<'a> = (Vec<Task<'a>>, Vec<(usize, Ended)>);

/// The members to run, and how the others have ended.
fn tasks<'a>(plan: &Plan, out: &Path, members: &'a [Member], retry: bool) -> Result<Sorted<'a>, BatchError> {
    let folders = Folders::read(out)?;
    let (mut tasks, mut ended) = (Vec::new(), Vec::new());
    for (place, member) in members.iter().enumerate() {
        let (folder, state) = folders.of(plan, member)?;
        match &state {
            MemberState::Summed(outcome) if outcome.completed || (outcome.status.is_stopped() && !retry) => {
                ended.push((place, Ended::Before(outcome.status)));
            }
            _ => tasks.push(Task { place, member, folder, state }),
        }
    }
    Ok((tasks, ended))
}

impl Crew<'_> {
    /// Runs tasks until none is left.
    fn work(&self) {
        while let Some(task) = self.tasks.get(self.next.fetch_add(1, Ordering::Relaxed)) {
            let ended = if self.watch.stop() { Ended::NotBegun } else { self.end(task) };
            self.watch.ended(task.member, &ended);
            self.ended.lock().unwrap_or_else(PoisonError::into_inner).push((task.place, ended));
        }
    }

    fn end(&self, task: &Task) -> Ended {
        match self.step(task) {
            Ok(status) => Ended::Now(status),
            // Stopped while its bodies were placed: nothing was written yet.
            Err(MemberError::Scene(error)) if error.kind() == FaultKind::Interrupted => Ended::NotBegun,
            Err(error) => Ended::Failed(error),
        }
    }

    fn step(&self, task: &Task) -> Result<RunStatus, MemberError> {
        let mut run = self.begin(task)?;
        self.watch.begun(task.member, &run);
        while !run.done() && !self.watch.stop() {
            let report = run.advance()?;
            self.watch.stepped(task.member, &report);
        }
        // The device is not needed for the files and the picture that follow.
        run.simulation().device().iter().for_each(|gpu| gpu.rest());
        Ok(run.finish()?.status)
    }

    fn begin(&self, task: &Task) -> Result<Run, MemberError> {
        let begun = Instant::now();
        let scene = self.plan.scene(task.member.index)?;
        let compute = (self.settle)(&scene)?;
        if matches!(task.state, MemberState::Unfinished | MemberState::Summed(_)) {
            let folder = Folder::open(&task.folder).map_err(RunError::from)?;
            return Ok(Run::resume(scene, folder, &compute)?);
        }
        let state = State::new(scene.build_while(&mut |_| !self.watch.stop())?);
        let simulation = Simulation::start(&compute, scene, state).map_err(MemberError::Start)?;
        // The folder is created last, so that a member that cannot start leaves no files.
        let folder = match task.state {
            MemberState::Unstarted => Folder::restart(&task.folder),
            _ => Folder::create(&task.folder),
        };
        Ok(Run::start(simulation, folder.map_err(RunError::from)?, begun.elapsed())?)
    }
}
