//! `from.json`: the state of another run that a run began with.

use super::error::RecordError;
use super::folder::Folder;
use serde::{Deserialize, Serialize};

/// The state of another run that a run began with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Parent {
    /// The folder of the other run, as it was named.
    pub run: String,
    /// Steps taken before the state.
    pub step: u64,
    /// Its time.
    pub time: f64,
    /// Its [hash](super::state_hash).
    pub state_hash: String,
    /// Whether it had the multipliers of its contacts. If it did, and no key changed, both runs have the same bits on
    /// the CPU.
    pub multipliers: bool,
    /// The dotted keys in which the scenes differ.
    pub changed: Vec<String>,
}

impl Parent {
    /// That of the run in a folder; none if the run began with its scene's own bodies.
    ///
    /// # Errors
    /// A file that cannot be read or is damaged.
    pub fn of(folder: &Folder) -> Result<Option<Parent>, RecordError> {
        let path = folder.parent();
        if !path.exists() {
            return Ok(None);
        }
        let bytes = std::fs::read(&path).map_err(RecordError::io(&path, "read it"))?;
        serde_json::from_slice(&bytes).map(Some).map_err(|error| RecordError::Mangled { path, what: error.to_string() })
    }
}
