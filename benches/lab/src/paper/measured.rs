//! What the program needs to know of a study that is made run by run.

use crate::StudyError;
use relcp::figure::Figure;
use serde::Serialize;
use serde_json::Value;

/// A study that is made run by run, and can be written after each.
pub trait Measured {
    /// What its files are called.
    fn name(&self) -> &'static str;

    /// Makes the next run and says in a line what it came to; `None` where all are made.
    ///
    /// # Errors
    /// [`StudyError`] where it cannot be made.
    fn next_run(&mut self) -> Result<Option<String>, StudyError>;

    /// Whether ReLCP did not hold its overlap tolerance, or a solve of it its own.
    fn missed(&self) -> bool;

    /// The page, without its plots.
    fn page(&self) -> String;

    /// All numbers.
    ///
    /// # Errors
    /// [`StudyError::Table`].
    fn numbers(&self) -> Result<Value, StudyError>;

    /// Tables and what else belongs to it, by the names of their files.
    ///
    /// # Errors
    /// [`StudyError::Table`].
    fn files(&self) -> Result<Vec<(String, Vec<u8>)>, StudyError>;

    /// The plots, by the names of their files without the end.
    ///
    /// # Errors
    /// [`StudyError::Plot`].
    fn plots(&self) -> Result<Vec<(&'static str, Figure)>, StudyError>;
}

/// Numbers as JSON.
pub(super) fn value<T: Serialize>(of: &T) -> Result<Value, StudyError> {
    serde_json::to_value(of).map_err(|fault| StudyError::Table(fault.to_string()))
}
