//! A plan: a sweep whose scenes are read, validated and checked for duplicates.

use super::error::BatchError;
use super::member_state::Folders;
use super::members::{Pick, values};
use super::ordered::Ordered;
use super::sweep::Sweep;
use crate::record::{Fnv, folder_name, scene_hash};
use crate::scene::{BuiltIn, FaultKind, Override, Scene, SceneError, Source, is_bare};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Digits of the scene's hash in a folder's name. The index makes names unique, and the whole hash is compared before
/// use.
pub(super) const HASH_DIGITS: usize = 8;
/// Digits of the index in a folder's name: enough for most sweeps, so that names sort. It does not depend on the number
/// of members, so a sweep keeps its names if members are appended.
pub(super) const INDEX_DIGITS: usize = 4;

/// One run of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Member {
    /// Its index, from 0.
    pub index: usize,
    /// Its varied values, in the order in which they are applied.
    pub set: Ordered<Value>,
    /// The values of its scene in the plan's columns, also those that the plan leaves unchanged. A key that the scene
    /// does not have is null.
    pub values: Ordered<Value>,
    /// Hash of its scene.
    pub scene_hash: String,
    /// Steps of its scene.
    pub steps: u64,
}

impl Member {
    /// The name of its folder: its index and the first digits of its scene's hash.
    pub fn name(&self) -> String {
        format!("{:0INDEX_DIGITS$}-{}", self.index, self.short_hash())
    }

    pub(super) fn short_hash(&self) -> &str {
        self.scene_hash.get(..HASH_DIGITS).unwrap_or(&self.scene_hash)
    }

    /// Its varied values as text.
    pub fn label(&self) -> String {
        label(self.set.0.iter())
    }
}

fn label<'a>(sets: impl Iterator<Item = &'a (String, Value)>) -> String {
    let named: Vec<String> = sets.map(|(key, value)| format!("{key}={value}")).collect();
    named.join(", ")
}

/// A sweep, ready to run.
pub struct Plan {
    sweep: Sweep,
    text: Arc<Source>,
    scene: Source,
    columns: Vec<String>,
    members: Vec<Member>,
}

impl Plan {
    /// Reads a sweep file, its scene, and validates every member.
    ///
    /// # Errors
    /// [`BatchError::Scene`] with the location in the sweep or in the scene; two members with the same scene are
    /// refused too.
    pub fn open(path: &Path) -> Result<Self, BatchError> {
        Ok(Plan::new(Source::file(path)?, path.parent().unwrap_or(Path::new("")))?)
    }

    /// As [`Plan::open`], from a text. `origin` names it in messages, and paths of scene files are relative to the
    /// folder `base`.
    ///
    /// # Errors
    /// As [`Plan::open`].
    pub fn parse(text: &str, origin: &str, base: &Path) -> Result<Self, BatchError> {
        Ok(Plan::new(Source::new(text, origin), base)?)
    }

    /// The plan of a sweep, given as text, of a scene in code: the sweep's `scene` only names it in messages.
    ///
    /// # Errors
    /// As [`Plan::open`].
    pub fn of_scene(text: &str, origin: &str, scene: &Scene) -> Result<Self, BatchError> {
        let text = Source::new(text, origin);
        let sweep = sweep_of(&text)?;
        let scene = Source::new(&scene.to_json(), &sweep.scene);
        Ok(Plan::made_of(sweep, text, scene)?)
    }

    fn new(text: Source, base: &Path) -> Result<Self, SceneError> {
        let sweep = sweep_of(&text)?;
        let scene = scene_of(&sweep, &text, base)?;
        Plan::made_of(sweep, text, scene)
    }

    fn made_of(sweep: Sweep, text: Source, scene: Source) -> Result<Self, SceneError> {
        let text = Arc::new(text);
        let mut plan = Plan { columns: sweep.columns(), sweep, text, scene, members: Vec::new() };
        // The limit was checked.
        let count = plan.sweep.count().unwrap_or(0) as usize;
        let members: Vec<_> = (0..count).into_par_iter().map(|index| plan.member(index)).collect();
        plan.members = members.into_iter().collect::<Result<_, _>>()?;
        plan.refuse_duplicates()?;
        Ok(plan)
    }

    fn member(&self, index: usize) -> Result<Member, SceneError> {
        let picks = self.sweep.picks(index);
        let set = values(&picks);
        let scene = self.scene_with(picks).map_err(|error| match error.help_text() {
            Some(_) => error,
            None => error.with_help(format!("member {index}: {}", label(set.0.iter()))),
        })?;
        let values = Ordered(self.values_of(&scene, &set));
        Ok(Member { index, set, values, scene_hash: scene_hash(&scene), steps: scene.time.steps() })
    }

    fn scene_with(&self, picks: Vec<Pick>) -> Result<Scene, SceneError> {
        let picks = self.sweep.common().chain(picks);
        let sets: Vec<Override> = picks.map(|pick| pick.into_override(&self.text)).collect::<Result<_, _>>()?;
        self.scene.scene(&sets)
    }

    /// The values of a scene for the columns.
    fn values_of(&self, scene: &Scene, set: &Ordered<Value>) -> Vec<(String, Value)> {
        let set: HashMap<&str, &Value> = set.0.iter().map(|(key, value)| (key.as_str(), value)).collect();
        let unset = self.columns.iter().any(|column| !set.contains_key(column.as_str()));
        // As large as the scene, so it is made only if needed.
        let whole = if unset { serde_json::to_value(scene.with_defaults()).unwrap_or_default() } else { Value::Null };
        let in_scene = |column: &str| value_at(&whole, column).cloned().unwrap_or_default();
        let value = |column: &String| {
            (column.clone(), set.get(column.as_str()).map_or_else(|| in_scene(column), |value| (*value).clone()))
        };
        self.columns.iter().map(value).collect()
    }

    fn refuse_duplicates(&self) -> Result<(), SceneError> {
        let mut seen: HashMap<&str, &Member> = HashMap::new();
        for member in &self.members {
            if let Some(first) = seen.insert(&member.scene_hash, member) {
                let (a, b) = (first.index, member.index);
                let message = format!("members {a} and {b} are the same scene ({}; {})", first.label(), member.label());
                return Err(SceneError::bad("", message).of(self.text.origin()));
            }
        }
        Ok(())
    }

    /// The sweep.
    pub fn sweep(&self) -> &Sweep {
        &self.sweep
    }

    /// The varied keys: those of the grid, those of the list, and `seed`.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The members, in their order.
    pub fn members(&self) -> &[Member] {
        &self.members
    }

    /// The scene of a member.
    ///
    /// # Errors
    /// [`FaultKind::BadValue`] if there is no member with this index.
    pub fn scene(&self, index: usize) -> Result<Scene, SceneError> {
        if index >= self.members.len() {
            return Err(SceneError::bad("", format!("there is no member {index}")).of(self.text.origin()));
        }
        self.scene_with(self.sweep.picks(index))
    }

    /// The sweep's default folder in `parent`. A name that cannot name a folder gets digits of its hash, so that sweeps
    /// do not share a folder. A folder without these digits is kept if it has members of this sweep.
    pub fn folder_in(&self, parent: &Path) -> PathBuf {
        let (name, plain) = (&self.sweep.name, folder_name(&self.sweep.name));
        let own = parent.join(&plain);
        if plain == *name || Folders::read(&own).is_ok_and(|folders| folders.has_member_of(self)) {
            return own;
        }
        let mut hash = Fnv::default();
        hash.update(name.as_bytes());
        parent.join(format!("{plain}-{}", &hash.hex()[..HASH_DIGITS]))
    }
}

fn value_at<'v>(whole: &'v Value, dotted: &str) -> Option<&'v Value> {
    dotted.split('.').map(str::trim).try_fold(whole, |here, part| match here {
        Value::Array(elements) => elements.get(part.parse::<usize>().ok()?),
        other => other.get(part),
    })
}

fn sweep_of(text: &Source) -> Result<Sweep, SceneError> {
    let sweep: Sweep = text.document()?;
    sweep.validate().map_err(|error| text.put(error))?;
    Ok(sweep)
}

/// The allowed sources of a sweep's scene.
const SOURCES: &str = "a built-in scene by its name, or a file relative to the sweep's folder";

/// The scene's text: a built-in scene, or a file relative to the sweep's folder.
fn scene_of(sweep: &Sweep, text: &Source, base: &Path) -> Result<Source, SceneError> {
    if let Some(built_in) = BuiltIn::named(&sweep.scene) {
        return Ok(Source::new(built_in.text, built_in.name));
    }
    let path = base.join(&sweep.scene);
    if !path.exists() && is_bare(Path::new(&sweep.scene)) {
        let unknown = BuiltIn::find(&sweep.scene).err().unwrap_or_else(|| SceneError::bad("", "is not there"));
        let help = unknown.help_text().map(str::to_owned);
        let fault = SceneError::new(FaultKind::UnknownScene, "scene", unknown.message());
        return Err(text.put(fault.with_help(help.unwrap_or_else(|| SOURCES.into()))));
    }
    Source::file(&path).map_err(|error| match error.kind() {
        FaultKind::Io => {
            let file = error.origin().unwrap_or_default();
            let fault = SceneError::new(FaultKind::Io, "scene", format!("{file} {}", error.message()));
            text.put(match error.help_text() {
                Some(help) => fault.with_help(help),
                None => fault.with_help(SOURCES),
            })
        }
        _ => error,
    })
}
