//! The state of a member, from its folder.

use super::plan::{HASH_DIGITS, INDEX_DIGITS, Member, Plan};
use crate::record::{Folder, RecordError, differing_keys, scene_hash};
use crate::run::RunStatus;
use crate::scene::{Scene, StopReason};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The part of a run's `summary.json` that a table shows. A length that was not finite is `None`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The status of the run.
    pub status: RunStatus,
    /// Whether it reached its end.
    pub completed: bool,
    /// The condition of `growth.stop` that ended it; absent in summaries of earlier versions.
    #[serde(default)]
    pub stopped_by: Option<StopReason>,
    /// Why it is out of tolerance or stopped, in one word; absent in summaries of earlier versions.
    #[serde(default)]
    pub reason: Option<String>,
    /// Why it stopped, in a sentence.
    #[serde(default)]
    pub message: Option<String>,
    /// Hash of its scene.
    pub scene_hash: String,
    /// Hash of its last state.
    pub state_hash: String,
    /// Steps taken.
    pub steps: u64,
    /// Bodies now.
    pub bodies: u64,
    /// Largest overlap that a step left.
    pub max_overlap: Option<f64>,
    /// Recursions.
    pub recursions: Recursions,
    /// The solver.
    pub solver: Products,
    /// Wall time.
    pub wall_seconds: Wall,
    /// The backend.
    pub backend: String,
    /// The precision.
    pub precision: String,
    /// The version of the program.
    pub version: String,
}

/// Recursions of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recursions {
    /// The mean per step.
    pub mean: f64,
}

/// The work of the solver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Products {
    /// Applications of `A` over all solves.
    pub products: u64,
}

/// Wall time of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Seconds, over all resumptions.
    pub total: f64,
}

/// The content of a member's folder.
#[derive(Clone, Debug, PartialEq)]
pub enum MemberState {
    /// Nothing, or the folder does not exist.
    Missing,
    /// A run that stopped before its first checkpoint.
    Unstarted,
    /// A run with a checkpoint and without a summary: it is running, or was killed.
    Unfinished,
    /// A run with a summary.
    Summed(Box<Outcome>),
}

/// The existing folders of the members of a plan.
#[derive(Debug, Default)]
pub struct Folders {
    root: PathBuf,
    /// The folders by the digits of the hash in their names.
    named: BTreeMap<String, Vec<PathBuf>>,
}

impl Folders {
    /// Lists the folder `root` of a batch, which may not exist yet.
    ///
    /// # Errors
    /// [`RecordError::Io`] if it cannot be listed.
    pub fn read(root: &Path) -> Result<Self, RecordError> {
        let mut folders = Folders { root: root.into(), named: BTreeMap::new() };
        let entries = match fs::read_dir(root) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(folders),
            entries => entries.map_err(RecordError::io(root, "use it as a folder"))?,
        };
        for entry in entries {
            let path = entry.map_err(RecordError::io(root, "list it"))?.path();
            if let Some(digits) = digits_of(&path) {
                folders.named.entry(digits).or_default().push(path);
            }
        }
        folders.named.values_mut().for_each(|paths| paths.sort());
        Ok(folders)
    }

    /// The folder of a member, and its state: the folder with the member's name, or one of the same scene under another
    /// index, from before the sweep was changed.
    ///
    /// # Errors
    /// [`RecordError::OtherScene`] if the folder with its name belongs to a different scene, [`RecordError::NotEmpty`]
    /// if it contains no run but other files, and files that cannot be read.
    pub fn of(&self, plan: &Plan, member: &Member) -> Result<(PathBuf, MemberState), RecordError> {
        let own = self.root.join(member.name());
        let state = member_state(plan, member, &own)?;
        if state != MemberState::Missing {
            return Ok((own, state));
        }
        for path in self.named.get(member.short_hash()).into_iter().flatten().filter(|path| **path != own) {
            match self::member_state(plan, member, path) {
                Ok(MemberState::Missing) | Err(RecordError::OtherScene { .. }) => {}
                found => return Ok((path.clone(), found?)),
            }
        }
        Ok((own, MemberState::Missing))
    }

    /// Whether any folder has the name of a member of this plan, with any index.
    pub(super) fn has_member_of(&self, plan: &Plan) -> bool {
        plan.members().iter().any(|member| self.named.contains_key(member.short_hash()))
    }

    /// Folders with names like those of members that belong to no member of this plan.
    pub fn strangers(&self, plan: &Plan) -> Vec<&Path> {
        let known: HashSet<&str> = plan.members().iter().map(Member::short_hash).collect();
        let strange = self.named.iter().filter(|(digits, _)| !known.contains(digits.as_str()));
        strange.flat_map(|(_, paths)| paths).map(PathBuf::as_path).collect()
    }
}

/// The digits of the hash in the name of a member's folder.
fn digits_of(path: &Path) -> Option<String> {
    let (index, digits) = path.file_name()?.to_str()?.split_once('-')?;
    let named = index.len() >= INDEX_DIGITS && index.bytes().all(|b| b.is_ascii_digit());
    let hashed = digits.len() == HASH_DIGITS && digits.bytes().all(|b| b.is_ascii_hexdigit());
    (named && hashed && path.is_dir()).then(|| digits.to_owned())
}

fn member_state(plan: &Plan, member: &Member, path: &Path) -> Result<MemberState, RecordError> {
    let folder = Folder::at(path);
    match fs::read_dir(path) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(MemberState::Missing),
        Err(e) => return Err(RecordError::io(path, "use it as a folder")(e)),
        Ok(mut entries) => {
            if entries.next().is_none() {
                return Ok(MemberState::Missing);
            }
        }
    }
    let guard = |hash: &str| if hash == member.scene_hash { Ok(()) } else { Err(other_scene(plan, member, &folder)) };
    if let Some(outcome) = outcome(&folder)? {
        guard(&outcome.scene_hash)?;
        return Ok(MemberState::Summed(Box::new(outcome)));
    }
    if folder.scene().exists() {
        let recorded = Scene::read(folder.scene());
        let recorded =
            recorded.map_err(|e| RecordError::Mangled { path: folder.scene(), what: e.message().to_owned() })?;
        guard(&scene_hash(&recorded))?;
        let begun = folder.checkpoint().exists() || folder.previous_checkpoint().exists();
        return Ok(if begun { MemberState::Unfinished } else { MemberState::Unstarted });
    }
    // A run's first file is steps.csv, its second scene.json.
    if folder.steps().exists() || folder.states().exists() {
        return Ok(MemberState::Unstarted);
    }
    Err(RecordError::NotEmpty { path: path.into() })
}

fn other_scene(plan: &Plan, member: &Member, folder: &Folder) -> RecordError {
    let keys = plan.scene(member.index).map(|scene| differing_keys(&folder.scene(), &scene));
    RecordError::OtherScene { path: folder.path().into(), keys: keys.unwrap_or_default() }
}

fn outcome(folder: &Folder) -> Result<Option<Outcome>, RecordError> {
    let path = folder.summary();
    match fs::read(&path) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(RecordError::io(&path, "read it")(e)),
        Ok(bytes) => match serde_json::from_slice(&bytes) {
            Ok(outcome) => Ok(Some(outcome)),
            Err(e) => Err(RecordError::Mangled { path, what: format!("it is not a run's summary: {e}") }),
        },
    }
}
