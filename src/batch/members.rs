//! The members of a sweep: maps an index to its values and their locations in the file.

use super::ordered::Ordered;
use super::sweep::Sweep;
use crate::scene::{Override, SceneError, Source};
use serde_json::Value;
use std::collections::HashSet;
use std::sync::Arc;

/// A key with its value's location in the sweep file.
pub(super) struct Pick {
    pub key: String,
    pub value: Value,
    path: Vec<String>,
}

impl Pick {
    fn new<const N: usize>(key: &str, value: Value, path: [&str; N]) -> Self {
        Pick { key: key.to_owned(), value, path: path.map(str::to_owned).to_vec() }
    }

    /// The corresponding override of a scene.
    pub fn into_override(self, text: &Arc<Source>) -> Result<Override, SceneError> {
        Override::in_text(text, self.path, &self.key, self.value)
    }
}

impl Sweep {
    /// The varied values of member `index`, in the order in which they are applied. The index is a mixed-radix number:
    /// the seeds are its lowest digit, then the list, then the grid's keys from the last to the first.
    pub(super) fn picks(&self, index: usize) -> Vec<Pick> {
        let mut rest = index;
        let mut digit = |radix: usize| {
            let digit = rest % radix.max(1);
            rest /= radix.max(1);
            digit
        };
        let seed = self.seeds.as_ref().map(|seeds| (digit(seeds.len() as usize), seeds));
        let entry = self.list.as_ref().map(|list| (digit(list.len()), list));
        let mut picks: Vec<Pick> = self
            .grid
            .0
            .iter()
            .rev()
            .map(|(key, values)| {
                let value = digit(values.len());
                Pick::new(key, values[value].clone(), ["grid", key, &value.to_string()])
            })
            .collect();
        picks.reverse();
        if let Some((at, list)) = entry {
            let entries = list[at].0.iter();
            picks.extend(entries.map(|(key, value)| Pick::new(key, value.clone(), ["list", &at.to_string(), key])));
        }
        if let Some((at, seeds)) = seed {
            picks.push(Pick::new("seed", seeds.at(at).into(), ["seeds", &at.to_string()]));
        }
        picks
    }

    /// The values that all members have.
    pub(super) fn common(&self) -> impl Iterator<Item = Pick> + '_ {
        self.set.0.iter().map(|(key, value)| Pick::new(key, value.clone(), ["set", key]))
    }

    /// The varied keys, in the order of the file.
    pub(super) fn columns(&self) -> Vec<String> {
        let mut columns: Vec<String> = self.grid.0.iter().map(|(key, _)| key.clone()).collect();
        let mut seen: HashSet<&str> = self.grid.0.iter().map(|(key, _)| key.as_str()).collect();
        for (key, _) in self.list.iter().flatten().flat_map(|entry| &entry.0) {
            if seen.insert(key) {
                columns.push(key.clone());
            }
        }
        columns.extend(self.seeds.is_some().then(|| "seed".to_owned()));
        columns
    }
}

/// The varied values of one member, by their keys.
pub(super) fn values(picks: &[Pick]) -> Ordered<Value> {
    Ordered(picks.iter().map(|pick| (pick.key.clone(), pick.value.clone())).collect())
}
