//! `steps.csv`: one row a recorded step.

use super::durable;
use super::error::RecordError;
use super::rows::Rows;
use crate::step::{StepReport, step_figures};
use serde::{Deserialize, Serialize};
use std::path::Path;

macro_rules! rows {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $before:expr, $joins:ident, {
        $(column($column:ty $(= $absent:literal)?))?
        $(counts($($count:tt)*))? $(retried($($again:tt)*))? $(largest($($largest:tt)*))? $(total($($total:tt)*))?
    };)*) => {
        /// The columns, in their order.
        pub const COLUMNS: &[&str] = &[$($(column!($name $column),)?)* "wall_seconds"];

        /// The types of the columns.
        pub(super) const TYPES: &[(&str, &str)] =
            &[$($((stringify!($name), stringify!($column)),)?)* ("wall_seconds", "f64")];

        /// The columns that files of earlier versions lack, the newest last, and what their rows have there.
        const ADDED: &[(&str, &str)] = &[$($($((stringify!($name), $absent),)?)?)*];

        /// A row: what one step did, as [`StepReport`] has it. Files of earlier versions do not have all.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        pub struct StepRow {
            $($(
                #[doc = concat!("[`StepReport::", stringify!($name), "`].")]
                pub $name: $column,
            )?)*
            /// Wall time of this step, without its output.
            pub wall_seconds: f64,
        }

        impl StepRow {
            fn new(report: &StepReport, wall_seconds: f64) -> Self {
                StepRow { $($($name: <$column>::from(report.$name),)?)* wall_seconds }
            }
        }
    };
}

/// The name of a figure that is a column.
macro_rules! column {
    ($name:ident $column:ty) => {
        stringify!($name)
    };
}

step_figures!(rows);

/// Gives a file of an earlier version the columns that it lacks.
fn add_columns(path: &Path) -> Result<(), RecordError> {
    // A device may have no end.
    if !std::fs::metadata(path).is_ok_and(|metadata| metadata.is_file()) {
        return Ok(());
    }
    let Ok(text) = std::fs::read_to_string(path) else { return Ok(()) };
    let mut lines = text.split_inclusive('\n');
    let Some(header) = lines.next().map(str::trim_end) else { return Ok(()) };
    let has = |count: usize| {
        let before = COLUMNS.iter().filter(|column| !ADDED[count..].iter().any(|(added, _)| added == *column));
        before.copied().collect::<Vec<_>>().join(",") == header
    };
    let Some(count) = (0..ADDED.len()).find(|count| has(*count)) else { return Ok(()) };
    let added: String = ADDED[count..].iter().map(|(_, value)| format!(",{value}")).collect();
    let mut longer = COLUMNS.join(",") + "\n";
    for line in lines {
        // A truncated row stays: it is cut off when the run continues.
        match line.rsplit_once(',').filter(|_| line.ends_with('\n')) {
            Some((row, wall)) => longer += &format!("{row}{added},{wall}"),
            None => longer += line,
        }
    }
    durable::write(path, longer.as_bytes())
}

/// The file, open for writing.
#[derive(Debug)]
pub(crate) struct Steps(Rows);

impl Steps {
    /// Starts the file.
    pub(crate) fn create(path: &Path) -> Result<Self, RecordError> {
        Rows::create(path, COLUMNS).map(Steps)
    }

    /// Takes the file up again as it was after step `last`: see [`Rows::reopen`].
    pub(crate) fn reopen(path: &Path, last: Option<u64>) -> Result<Self, RecordError> {
        add_columns(path)?;
        Rows::reopen(path, COLUMNS, last).map(Steps)
    }

    /// Adds a row.
    pub(crate) fn push(&mut self, report: &StepReport, wall_seconds: f64) -> Result<(), RecordError> {
        self.0.push(StepRow::new(report, wall_seconds))
    }

    /// Hands the rows so far to the system.
    pub(crate) fn flush(&mut self) -> Result<(), RecordError> {
        self.0.flush()
    }

    /// Makes the rows so far last.
    pub(crate) fn sync(&mut self) -> Result<(), RecordError> {
        self.0.sync()
    }
}
