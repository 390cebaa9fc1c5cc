//! `lineage.csv`: one row per life that ended, by division or by removal. With the bodies of the last state it gives
//! the ancestry of all bodies of a run. Without `removal` in the scene it has only bodies that changes removed.

use super::error::RecordError;
use super::rows::Rows;
use crate::removal::Ended;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The columns, in their order.
const COLUMNS: [&str; 9] = ["step", "time", "id", "parent", "birth", "generation", "group", "cause", "rule"];

/// A row: a life that ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LifeRow {
    /// The step that ended it, from 1.
    pub step: u64,
    /// The time: for a division and a change the step's start, else its end.
    pub time: f64,
    /// The id of the body.
    pub id: u64,
    /// The id that divided into it; empty for a founder.
    pub parent: Option<u64>,
    /// Time of its birth.
    pub birth: f64,
    /// Divisions since its founder.
    pub generation: u32,
    /// The name of its group; empty if it had none.
    pub group: String,
    /// `division`, `outside`, `inside`, `rate` or `change`.
    pub cause: String,
    /// The index in the scene's `removal` of the rule that removed it; empty if none did.
    pub rule: Option<usize>,
}

impl LifeRow {
    /// The row of a life, in a scene with these group names.
    pub fn new(ended: &Ended, groups: &[String]) -> LifeRow {
        LifeRow {
            step: ended.step,
            time: ended.time,
            id: ended.line.id,
            parent: ended.line.parent,
            birth: ended.line.birth,
            generation: ended.line.generation,
            group: groups.get(ended.group as usize).cloned().unwrap_or_default(),
            cause: ended.cause.name().into(),
            rule: ended.rule,
        }
    }
}

/// The file, open for writing; none as long as no body is removed that the scene has no `removal` for.
#[derive(Debug)]
pub(crate) struct Lives {
    rows: Rows,
    groups: Vec<String>,
}

impl Lives {
    /// Starts the file.
    pub(crate) fn create(path: &Path, groups: Vec<String>) -> Result<Self, RecordError> {
        Ok(Lives { rows: Rows::create(path, &COLUMNS)?, groups })
    }

    /// Whether a run without `removal` has begun the file. One that was killed as it did so has left an empty one:
    /// it goes.
    pub(crate) fn is_begun(path: &Path) -> Result<bool, RecordError> {
        let empty = std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() == 0);
        if empty {
            std::fs::remove_file(path).map_err(RecordError::io(path, "remove it"))?;
        }
        Ok(path.is_file())
    }

    /// Reopens the file as it was after step `last`: rows of later steps are removed.
    pub(crate) fn reopen(path: &Path, groups: Vec<String>, last: u64) -> Result<Self, RecordError> {
        Ok(Lives { rows: Rows::reopen_up_to(path, &COLUMNS, last)?, groups })
    }

    /// Adds the lives that a step ended.
    pub(crate) fn push(&mut self, ended: &[Ended]) -> Result<(), RecordError> {
        ended.iter().try_for_each(|life| self.rows.push(LifeRow::new(life, &self.groups)))
    }

    /// Flushes the rows to the system.
    pub(crate) fn flush(&mut self) -> Result<(), RecordError> {
        self.rows.flush()
    }

    /// Syncs the rows to the disk.
    pub(crate) fn sync(&mut self) -> Result<(), RecordError> {
        self.rows.sync()
    }
}
