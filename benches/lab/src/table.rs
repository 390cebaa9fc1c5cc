//! Rows as CSV.

use super::StudyError;
use serde::Serialize;

/// Returns a table with one line per row, under the names of its fields.
pub(super) fn csv_table<'a, T: Serialize + 'a>(rows: impl Iterator<Item = &'a T>) -> Result<Vec<u8>, StudyError> {
    let fault = |e: csv::Error| StudyError::Table(e.to_string());
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(fault)?;
    }
    writer.into_inner().map_err(|e| StudyError::Table(e.to_string()))
}
