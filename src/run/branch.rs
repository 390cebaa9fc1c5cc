//! A run that begins with a state of another run.

use super::RunError;
use crate::digits::exact;
use crate::record::{Folder, Parent, RecordError, all_differing_keys, read_state, state_hash};
use crate::scene::changes::{is_in, is_of_contacts, is_settled};
use crate::scene::{KeyChange, Scene};
use crate::simulation::{Compute, Simulation};
use crate::step::State;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A recorded time that is later by this part of a step than the one asked for counts as that time.
const ROUNDING: f64 = 1e-6;

/// A recorded state of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Recorded {
    step: u64,
    time: f64,
    is_checkpoint: bool,
}

/// A state of a run that another run can begin with.
///
/// ```
/// use relcp::record::Folder;
/// use relcp::run::{Branch, Run};
/// use relcp::simulation::{Compute, Simulation};
/// use relcp::Scene;
/// let parent = tempfile::tempdir()?;
/// let scene = Scene::load("two-ellipsoids", ["time.end=0.5"])?;
/// let folder = Folder::create_in(parent.path(), "first")?;
/// let mut run = Run::start(Simulation::new(scene)?, folder, std::time::Duration::ZERO)?;
/// while !run.done() {
///     run.advance()?;
/// }
/// let first = run.folder().path().to_owned();
/// run.finish()?;
///
/// let branch = Branch::open(&first, None)?;
/// let scene = Scene::load(branch.scene(), ["time.end=0.6", "forces.0.uniform.force=[0,-2,0]"])?;
/// let (simulation, begun_with) = branch.simulate(scene, &Compute::Cpu)?;
/// assert_eq!((simulation.steps(), begun_with.step), (50, 50));
/// let folder = Folder::create_in(parent.path(), "second")?;
/// let second = Run::start_from(simulation, folder, begun_with, std::time::Duration::ZERO)?;
/// # Ok::<(), relcp::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Branch {
    folder: Folder,
    source: PathBuf,
    recorded: Recorded,
    /// The other run's.
    before: Scene,
    /// Keys that were set for this branch.
    set: Vec<String>,
}

impl Branch {
    /// Finds the last state of the run in `path` that is not later than `time`; without a time the last state.
    ///
    /// # Errors
    /// [`RecordError::NoBranch`] if the run has no such state; a scene or a state that cannot be read.
    pub fn open(path: &Path, time: Option<f64>) -> Result<Self, RecordError> {
        let folder = Folder::view(path);
        let none = |why: String| RecordError::NoBranch { path: path.into(), why };
        let scene = Scene::read(folder.scene()).map_err(|error| none(error.to_string()))?;
        let states = folder.recorded()?.into_iter();
        let mut all: Vec<(Recorded, PathBuf)> = states
            .map(|(step, path)| (Recorded { step, time: scene.time_after(step), is_checkpoint: false }, path))
            .collect();
        // A checkpoint has the multipliers, so it precedes the state of the same step.
        for path in [folder.previous_checkpoint(), folder.checkpoint()] {
            if let Ok((header, _)) = read_state(&path) {
                all.push((Recorded { step: header.step, time: header.time, is_checkpoint: true }, path));
            }
        }
        all.sort_by_key(|(recorded, _)| (recorded.step, recorded.is_checkpoint));
        let Some((first, _)) = all.first().cloned() else {
            return Err(none("there is no state; name the folder of a run".into()));
        };
        let until = time.map_or(f64::INFINITY, |time| time + ROUNDING * scene.time.dt);
        let Some((recorded, source)) = all.into_iter().rfind(|(recorded, _)| recorded.time <= until) else {
            let asked = exact(time.unwrap_or(f64::NAN));
            return Err(none(format!("its first state is at time {}, after {asked}", exact(first.time))));
        };
        Ok(Branch { folder, source, recorded, before: scene, set: Vec::new() })
    }

    /// The branch with dotted keys that its user has set. Their values hold from the state on, also where an earlier
    /// entry of `changes` sets the key, and where the value is the scene's own.
    #[must_use]
    pub fn with_keys(self, keys: impl IntoIterator<Item = String>) -> Self {
        Branch { set: keys.into_iter().collect(), ..self }
    }

    /// The scene of the other run.
    pub fn scene(&self) -> PathBuf {
        self.folder.scene()
    }

    /// The time of the state.
    pub fn time(&self) -> f64 {
        self.recorded.time
    }

    /// Steps taken before the state.
    pub fn step(&self) -> u64 {
        self.recorded.step
    }

    /// A simulation of `scene` that begins with this state: bodies, ancestry, multipliers, the number of steps and with
    /// it the random streams. [`Run::start_from`](super::Run::start_from) makes a run of it.
    ///
    /// The scene is that of the other run, with other values of keys. `planar`, `periodic`, `bodies`, `generate`,
    /// `groups` and the bodies of `bonds` must not differ. Another `time.dt` becomes one of its `changes`, at the time
    /// of the state, and so does each key that differs and that an earlier change sets. Where nothing differs and the
    /// state has multipliers, the simulation has the bits of the other one on the CPU.
    ///
    /// # Errors
    /// [`RecordError::NoBranch`] with the keys that must not differ, or if the scene ends before the state; a state
    /// that cannot be read; what [`SimulationBuilder::build`](crate::simulation::SimulationBuilder::build) refuses.
    pub fn simulate(&self, mut scene: Scene, compute: &Compute) -> Result<(Simulation, Parent), RunError> {
        let (state, parent) = self.take(&mut scene)?;
        Ok((Simulation::start(compute, scene, state)?, parent))
    }

    fn take(&self, scene: &mut Scene) -> Result<(State, Parent), RecordError> {
        let mut changed = all_differing_keys(&self.folder.scene(), scene);
        let settled: Vec<&str> = changed.iter().map(String::as_str).filter(|key| is_settled(key)).collect();
        if !settled.is_empty() {
            return Err(self.refuse(format!("{} cannot change: the state has them already", settled.join(", "))));
        }
        let time = self.recorded.time;
        if let Some((wall, why)) = scene.jump_from(&self.before, time) {
            return Err(self.refuse(format!("walls.{wall} {why}")));
        }
        scene.follow_defaults(&self.before);
        let (header, mut state) = read_state(&self.source)?;
        let again = self.undone(scene, &changed);
        // A value that the scene has without its changes does not differ.
        let same: Vec<String> = again.keys().filter(|key| !changed.contains(key)).cloned().collect();
        changed.extend(same);
        self.change_step_size(scene);
        self.change_again(scene, again);
        if scene.time.end < time {
            let end = exact(scene.time.end);
            return Err(self.refuse(format!("time.end, {end}, is before the state's time, {}", exact(time))));
        }
        scene.validate().map_err(|error| self.refuse(error.to_string()))?;
        let fits = !changed.iter().any(|key| is_of_contacts(key));
        if !fits {
            state.warm.clear();
        }
        if changed.iter().any(|key| key.starts_with("removal")) {
            state.removed.clear();
        }
        let parent = Parent {
            run: self.folder.path().display().to_string(),
            step: header.step,
            time,
            state_hash: state_hash(&state),
            multipliers: header.warm.is_some() && fits,
            changed,
        };
        Ok((state, parent))
    }

    /// Makes another step size a change at the state's time, so that the steps before keep their times.
    fn change_step_size(&self, scene: &mut Scene) {
        let dt = std::mem::replace(&mut scene.time.dt, self.before.time.dt);
        if dt != scene.time.dt {
            let made = scene.changes.partition_point(|change| change.at <= self.recorded.time);
            scene.changes.insert(made, KeyChange::new(self.recorded.time, [("time.dt".into(), dt.into())]));
        }
    }

    /// The values of this branch that a change before the state would take back, by their keys.
    fn undone(&self, scene: &Scene, changed: &[String]) -> BTreeMap<String, Value> {
        let made = scene.changes.iter().take_while(|change| change.at <= self.recorded.time);
        let made: Vec<&String> = made.flat_map(|change| change.set.keys()).collect();
        let is_undone = |key: &&String| made.iter().any(|set| is_in(key, set) || is_in(set, key));
        let values = serde_json::to_value(scene).unwrap_or_default();
        let value = |key: &String| {
            let place = format!("/{}", key.replace('.', "/"));
            values.pointer(&place).map(|value| (key.clone(), value.clone()))
        };
        let own = changed.iter().chain(&self.set).filter(|key| !is_in(key, "changes"));
        own.filter(is_undone).filter_map(value).collect()
    }

    /// Sets these values at the state's time.
    fn change_again(&self, scene: &mut Scene, values: BTreeMap<String, Value>) {
        if !values.is_empty() {
            let made = scene.changes.partition_point(|change| change.at <= self.recorded.time);
            scene.changes.insert(made, KeyChange::new(self.recorded.time, values));
        }
    }

    fn refuse(&self, why: String) -> RecordError {
        RecordError::NoBranch { path: self.folder.path().into(), why }
    }
}
