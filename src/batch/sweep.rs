//! A sweep: one scene in many variants, as in a sweep file (JSON).

use super::ordered::Ordered;
use crate::scene::SceneError;
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt;

/// The largest number of members of a sweep: each has a folder of about ten files, and more would exceed the limits of
/// file systems and queues.
pub const MAX_MEMBERS: u64 = 100_000;
/// The longest name, in bytes: it names a folder, like that of a scene.
const MAX_NAME_BYTES: usize = 128;

/// One scene in many variants: every combination of the grid's values, the list's entries and the seeds.
///
/// Keys are dotted, as in overrides. `set` is applied first, then the grid, the list and the seed. In the order of
/// members the grid's first key varies slowest, then its other keys, then the list; the seeds vary fastest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// A name, which also names the folder.
    pub name: String,
    /// A built-in scene's name, or the path of a scene file, relative to the sweep's folder.
    pub scene: String,
    /// Values that all members have.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, Value>")]
    pub set: Ordered<Value>,
    /// The values of each of these keys, in all combinations.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, Vec<Value>>")]
    pub grid: Ordered<Vec<Value>>,
    /// Sets of values that belong together; each is combined with the grid and the seeds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<BTreeMap<String, Value>>>")]
    pub list: Option<Vec<Ordered<Value>>>,
    /// The seeds; without them the scene's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seeds: Option<Seeds>,
}

/// Seeds, as a list or as a range.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Seeds {
    /// A list.
    Listed(Vec<u64>),
    /// A range.
    Row(SeedRow),
}

/// A range of seeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeedRow {
    /// The first.
    pub from: u64,
    /// Their number.
    #[schemars(range(min = 1))]
    pub count: u64,
}

impl Seeds {
    /// Their number.
    pub fn len(&self) -> u64 {
        match self {
            Seeds::Listed(seeds) => seeds.len() as u64,
            Seeds::Row(row) => row.count,
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The seed at an index.
    pub(super) fn at(&self, index: usize) -> u64 {
        match self {
            Seeds::Listed(seeds) => seeds[index],
            Seeds::Row(row) => row.from + index as u64,
        }
    }
}

impl<'de> Deserialize<'de> for Seeds {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SeedsVisitor)
    }
}

/// Written by hand, because an untagged enum gives no useful error.
struct SeedsVisitor;

impl<'de> Visitor<'de> for SeedsVisitor {
    type Value = Seeds;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of seeds or {\"from\": 1, \"count\": 10}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Seeds, A::Error> {
        let mut seeds = Vec::new();
        while let Some(seed) = seq.next_element()? {
            seeds.push(seed);
        }
        Ok(Seeds::Listed(seeds))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Seeds, A::Error> {
        SeedRow::deserialize(MapAccessDeserializer::new(map)).map(Seeds::Row)
    }
}

impl Sweep {
    /// Checks that the sweep can be expanded: a valid folder name, no empty list of values, no key that is varied
    /// twice, not too many members.
    pub(super) fn validate(&self) -> Result<(), SceneError> {
        let unfit = |c: char| c == '/' || c == '\\' || c.is_control();
        if self.name.trim_matches('.').is_empty() || self.name.len() > MAX_NAME_BYTES || self.name.contains(unfit) {
            let message =
                format!("must be a name of at most {MAX_NAME_BYTES} bytes without slashes; it names a folder");
            return Err(SceneError::bad("name", message));
        }
        for (key, values) in &self.grid.0 {
            if values.is_empty() {
                return Err(SceneError::bad(format!("grid.{key}"), "has no values, so the sweep has no members"));
            }
        }
        if self.list.as_ref().is_some_and(Vec::is_empty) {
            return Err(SceneError::bad("list", "is empty, so the sweep has no members; omit it"));
        }
        self.check_seeds()?;
        self.check_twice()?;
        match self.count() {
            Some(count) if count <= MAX_MEMBERS => Ok(()),
            _ => Err(SceneError::bad("", format!("has more than {MAX_MEMBERS} members"))),
        }
    }

    fn check_seeds(&self) -> Result<(), SceneError> {
        match &self.seeds {
            Some(Seeds::Row(row)) if row.count == 0 => Err(SceneError::bad("seeds.count", "must be 1 or more")),
            Some(Seeds::Row(row)) if row.from.checked_add(row.count - 1).is_none() => {
                Err(SceneError::bad("seeds", format!("goes beyond the largest seed, {}", u64::MAX)))
            }
            Some(seeds) if seeds.is_empty() => {
                Err(SceneError::bad("seeds", "is empty, so the sweep has no members; omit it"))
            }
            _ => Ok(()),
        }
    }

    /// Refuses a key that is varied in two ways: one of them would be lost silently.
    fn check_twice(&self) -> Result<(), SceneError> {
        let grid: Vec<&str> = self.grid.0.iter().map(|(key, _)| key.as_str()).collect();
        for (index, entry) in self.list.iter().flatten().enumerate() {
            for (key, _) in &entry.0 {
                if let Some(other) = grid.iter().find(|other| overlap(key, other)) {
                    let message = format!("is also varied by the grid, as `{other}`; use only one of the two");
                    return Err(SceneError::bad(format!("list.{index}.{key}"), message));
                }
                if self.seeds.is_some() && overlap(key, "seed") {
                    return Err(SceneError::bad(
                        format!("list.{index}.{key}"),
                        "is also varied by `seeds`; use only one of the two",
                    ));
                }
            }
        }
        match grid.iter().find(|key| self.seeds.is_some() && overlap(key, "seed")) {
            Some(key) => {
                Err(SceneError::bad(format!("grid.{key}"), "is also varied by `seeds`; use only one of the two"))
            }
            None => Ok(()),
        }
    }

    /// The number of members, if it does not overflow.
    pub(super) fn count(&self) -> Option<u64> {
        let grid = self.grid.0.iter().map(|(_, values)| values.len() as u64);
        let list = self.list.as_ref().map_or(1, |list| list.len() as u64);
        let seeds = self.seeds.as_ref().map_or(1, Seeds::len);
        grid.chain([list, seeds]).try_fold(1_u64, u64::checked_mul)
    }
}

/// Whether two dotted keys are the same, or one is a part of the other.
fn overlap(a: &str, b: &str) -> bool {
    a.split('.').zip(b.split('.')).all(|(a, b)| a.trim() == b.trim())
}

/// The JSON Schema of sweep files, for editors and other programs.
///
/// ```
/// assert!(relcp::batch::schema()["properties"]["grid"].is_object());
/// ```
pub fn schema() -> Value {
    schemars::schema_for!(Sweep).to_value()
}
