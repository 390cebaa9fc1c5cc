//! The states of a run or a scene: those of a run's folder in order, or a single one.

use super::error::StatesError;
use super::{Folder, read_state};
use crate::bodies::Bodies;
use crate::fields::Concentration;
use crate::scene::{self, Scene};
use crate::step::State;
use crate::warm::Warm;
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Receives the progress over states: the number done and the total. Returning `false` stops the work.
pub type Watch<'a> = &'a mut dyn FnMut(usize, usize) -> bool;

/// One state.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Steps taken.
    pub step: u64,
    /// The time.
    pub time: f64,
    /// The bodies.
    pub bodies: Bodies,
    /// The multipliers of the step's near pairs, if known: in a checkpoint, and in states recorded with
    /// `output.forces`.
    pub warm: Option<Vec<Warm>>,
    /// The number of bodies that each rule of the scene's `removal` has removed; empty before the first removal.
    pub removed: Vec<u64>,
    /// The concentrations of the scene's fields.
    pub fields: Vec<Concentration>,
}

impl Snapshot {
    /// This state with each centre in the cell about the origin ([`Bodies::wrapped`]).
    pub fn wrapped(&self) -> Cow<'_, Snapshot> {
        match self.bodies.wrapped() {
            Cow::Borrowed(_) => Cow::Borrowed(self),
            Cow::Owned(bodies) => {
                let Snapshot { step, time, .. } = *self;
                let Snapshot { warm, removed, fields, .. } = self.clone();
                Cow::Owned(Snapshot { step, time, bodies, warm, removed, fields })
            }
        }
    }

    /// Refuses a state with shapes that no format supports.
    pub(crate) fn refuse_custom(&self, origin: impl Fn() -> String) -> Result<(), StatesError> {
        let refused = |body| Err(StatesError::Custom { origin: origin(), body });
        self.bodies.first_custom().map_or(Ok(()), refused)
    }
}

/// The states to export, in the order of their steps. They are read one at a time, so a long run needs only the memory
/// of its largest state.
#[derive(Clone, Debug)]
pub struct States {
    name: String,
    entries: Vec<Entry>,
    notes: Vec<String>,
    /// Whether their scene is planar, if there is one.
    planar: Option<bool>,
}

#[derive(Clone, Debug)]
enum Entry {
    File(PathBuf),
    Held { origin: String, snapshot: Box<Snapshot> },
}

impl States {
    /// The states of `source`, which is
    ///
    /// * a run's folder: its `states/` in order, and the checkpoint in place of the state of its step, or after the
    ///   last (a checkpoint has the contact forces); `final.json` without both. A damaged state is omitted, with a
    ///   [note](States::notes);
    /// * a state file (`.npz`);
    /// * a scene file or the name of a built-in scene: its initial state.
    ///
    /// # Errors
    /// [`StatesError::NoState`] for a folder without states; a scene that cannot be read, or a state if there is no
    /// other.
    pub fn open(source: impl AsRef<Path>) -> Result<Self, StatesError> {
        let path = source.as_ref();
        if path.is_dir() {
            return States::of_run(path);
        }
        if path.extension().is_some_and(|extension| extension == "npz") {
            let name = stem(path);
            let planar = planar_of(path)?;
            return Ok(States { name, entries: vec![Entry::File(path.into())], notes: Vec::new(), planar });
        }
        let scene = Scene::load(path, scene::NO_OVERRIDES)?;
        let (time, bodies) = (scene.time.start, scene.build()?);
        let fields = scene.fields().start(&[]);
        let snapshot = Snapshot { step: 0, time, bodies, warm: None, removed: Vec::new(), fields };
        Ok(States {
            name: stem(path),
            planar: Some(scene.planar),
            ..States::single(&path.display().to_string(), snapshot)
        })
    }

    /// A single state; `name` appears in messages and in file names.
    ///
    /// ```
    /// use relcp::record::{Snapshot, States};
    /// use relcp::Scene;
    /// let bodies = Scene::built_in("three-capsules")?.build()?;
    /// let (removed, fields) = (Vec::new(), Vec::new());
    /// let states = States::single("mine", Snapshot { step: 0, time: 0.0, bodies, warm: None, removed, fields });
    /// assert_eq!((states.len(), states.read(0)?.bodies.len()), (1, 3));
    /// # Ok::<(), relcp::Error>(())
    /// ```
    pub fn single(name: &str, snapshot: Snapshot) -> Self {
        let entry = Entry::Held { origin: name.into(), snapshot: Box::new(snapshot) };
        States { name: name.into(), entries: vec![entry], notes: Vec::new(), planar: None }
    }

    fn of_run(path: &Path) -> Result<Self, StatesError> {
        let folder = Folder::view(path);
        let mut recorded = folder.recorded()?;
        let mut notes = Vec::new();
        let mut held = None;
        let checkpoint = folder.checkpoint();
        if checkpoint.exists() {
            match read_state(&checkpoint) {
                Ok((header, state)) => {
                    recorded.retain(|(step, _)| *step != header.step);
                    let snapshot = Snapshot {
                        step: header.step,
                        time: header.time,
                        bodies: state.bodies,
                        warm: header.warm.map(|_| state.warm),
                        removed: state.removed,
                        fields: state.fields,
                    };
                    held = Some(Entry::Held { origin: checkpoint.display().to_string(), snapshot: Box::new(snapshot) });
                }
                Err(fault) if recorded.is_empty() => return Err(fault.into()),
                Err(fault) => notes.push(format!("{fault}; it is left out")),
            }
        }
        let after = held.as_ref().map_or(0, |entry| match entry {
            Entry::Held { snapshot, .. } => recorded.partition_point(|(step, _)| *step < snapshot.step),
            Entry::File(_) => recorded.len(),
        });
        let mut entries: Vec<Entry> = recorded.into_iter().map(|(_, path)| Entry::File(path)).collect();
        if let Some(held) = held {
            entries.insert(after, held);
        }
        let name = name_of(path);
        let entries = States::whole(entries, &mut notes)?;
        if entries.is_empty() {
            let last = folder.last();
            return match last.exists() {
                true => Ok(States { name, ..States::open(last)? }),
                false => Err(StatesError::NoState { path: path.into() }),
            };
        }
        Ok(States { name, entries, notes, planar: planar_of(path)? })
    }

    /// The readable entries, with a note for each damaged one; the fault of the first if none is readable.
    fn whole(entries: Vec<Entry>, notes: &mut Vec<String>) -> Result<Vec<Entry>, StatesError> {
        let fault = |entry: &Entry| match entry {
            Entry::File(path) => read_state(path).err(),
            Entry::Held { .. } => None,
        };
        let mut faults: Vec<_> = entries.par_iter().map(fault).collect();
        if faults.iter().all(Option::is_some)
            && let Some(fault) = faults.iter_mut().find_map(Option::take)
        {
            return Err(fault.into());
        }
        notes.extend(faults.iter().flatten().map(|fault| format!("{fault}; it is left out")));
        Ok(entries.into_iter().zip(faults).filter(|(_, fault)| fault.is_none()).map(|(entry, _)| entry).collect())
    }

    /// The last state alone.
    pub fn last(mut self) -> Self {
        self.entries.drain(..self.entries.len().saturating_sub(1));
        self
    }

    /// Whether the run is planar, by its scene. Without a scene: whether all bodies of the last state have centres in
    /// one plane of constant z and are mirror-symmetric in it.
    ///
    /// # Errors
    /// A state that cannot be read.
    pub fn planar(&self) -> Result<bool, StatesError> {
        match (self.planar, self.entries.len()) {
            (Some(planar), _) => Ok(planar),
            (None, 0) => Ok(false),
            (None, all) => Ok(flat(&self.read(all - 1)?.bodies)),
        }
    }

    /// The base name of files: the run's folder, the file or the scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number of states.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Notes for the user on the search of the states.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The origin of state `i`, less than [`States::len`], for messages.
    pub fn origin(&self, i: usize) -> String {
        match &self.entries[i] {
            Entry::File(path) => path.display().to_string(),
            Entry::Held { origin, .. } => origin.clone(),
        }
    }

    /// State `i`, less than [`States::len`].
    ///
    /// # Errors
    /// A file that cannot be read, or is damaged.
    pub fn read(&self, i: usize) -> Result<Cow<'_, Snapshot>, StatesError> {
        match &self.entries[i] {
            Entry::Held { snapshot, .. } => Ok(Cow::Borrowed(snapshot)),
            Entry::File(path) => {
                let (header, mut state) = read_state(path)?;
                let warm = header.warm.map(|_| std::mem::take(&mut state.warm));
                let State { mut bodies, removed, fields, .. } = state;
                // A file of an older program lacks this flag.
                bodies.planar |= self.planar == Some(true);
                Ok(Cow::Owned(Snapshot { step: header.step, time: header.time, bodies, warm, removed, fields }))
            }
        }
    }
}

/// The `scene.json` that belongs to a run's folder, or to a state in one.
pub(crate) fn scene_of(source: &Path) -> Option<PathBuf> {
    let found = |folder: &Path| Some(Folder::view(folder).scene()).filter(|scene| scene.is_file());
    if source.is_dir() {
        return found(source);
    }
    if source.extension()? != "npz" {
        return None;
    }
    let folder = source.canonicalize().ok()?.parent()?.to_path_buf();
    found(&folder).or_else(|| found(folder.parent()?))
}

/// Whether that scene is planar.
fn planar_of(source: &Path) -> Result<Option<bool>, StatesError> {
    scene_of(source).map(|path| Ok(Scene::read(&path)?.planar)).transpose()
}

fn flat(bodies: &Bodies) -> bool {
    let plane = bodies.position.first().map(|position| position.z);
    plane.is_some()
        && bodies.position.iter().all(|position| Some(position.z) == plane)
        && bodies.shape.iter().zip(&bodies.orientation).all(|(shape, q)| shape.is_planar_symmetric(*q))
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "state".into(), |stem| stem.to_string_lossy().into_owned())
}

/// The name of a folder, which may be given as `.` or with a trailing `..`.
fn name_of(path: &Path) -> String {
    let named = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    named(path).or_else(|| named(&path.canonicalize().ok()?)).unwrap_or_else(|| "run".into())
}
