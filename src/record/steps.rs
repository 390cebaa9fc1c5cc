//! `steps.csv`: one row a recorded step.

use super::durable;
use super::error::RecordError;
use super::rows::Rows;
use crate::step::StepReport;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The columns, in their order.
pub const COLUMNS: [&str; 16] = [
    "step",
    "time",
    "bodies",
    "constraints",
    "recursions",
    "iterations",
    "products",
    "residual",
    "first_violation",
    "max_overlap",
    "pieces",
    "largest_move",
    "largest_push_gap",
    "contact_energy",
    "axial_spin",
    "wall_seconds",
];

/// A row: what one step did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepRow {
    /// Its number, from 1.
    pub step: u64,
    /// Time after it.
    pub time: f64,
    /// Bodies after it.
    pub bodies: usize,
    /// Rows of its last LCP.
    pub constraints: usize,
    /// Recursions.
    pub recursions: u32,
    /// LCP iterations, over all its solves.
    pub iterations: u64,
    /// Applications of `A`, over all its solves.
    pub products: u64,
    /// Largest residual of its solves, a length.
    pub residual: f64,
    /// Largest overlap in the trial of its first solve, a length.
    pub first_violation: f64,
    /// Largest true overlap that it left, a length.
    pub max_overlap: f64,
    /// Into how many pieces it was cut; files of earlier versions do not say.
    #[serde(default = "one")]
    pub pieces: u32,
    /// The farthest that contact moved a body's centre from its free motion, a length; files of earlier versions do not
    /// say.
    pub largest_move: Option<f64>,
    /// The largest separation of a contact that pushes, a length.
    pub largest_push_gap: Option<f64>,
    /// The energy that contact added.
    pub contact_energy: Option<f64>,
    /// The largest angle by which contact turned a body of revolution about its own axis.
    pub axial_spin: Option<f64>,
    /// Wall time of this step, without its output.
    pub wall_seconds: f64,
}

fn one() -> u32 {
    1
}

impl StepRow {
    fn new(report: &StepReport, wall_seconds: f64) -> Self {
        StepRow {
            step: report.step,
            time: report.time,
            bodies: report.bodies,
            constraints: report.constraints,
            recursions: report.recursions,
            iterations: report.iterations,
            products: report.products,
            residual: report.residual,
            first_violation: report.first_violation,
            max_overlap: report.max_overlap,
            pieces: report.pieces,
            largest_move: Some(report.largest_move),
            largest_push_gap: Some(report.largest_push_gap),
            contact_energy: Some(report.contact_energy),
            axial_spin: Some(report.axial_spin),
            wall_seconds,
        }
    }
}

/// The columns that files of earlier versions lack, the newest first, and what their rows have there.
const ADDED: [(&str, &str); 5] =
    [("axial_spin", ""), ("contact_energy", ""), ("largest_push_gap", ""), ("largest_move", ""), ("pieces", "1")];

/// Gives a file of an earlier version the columns that it lacks.
fn add_columns(path: &Path) -> Result<(), RecordError> {
    // A device may have no end.
    if !std::fs::metadata(path).is_ok_and(|metadata| metadata.is_file()) {
        return Ok(());
    }
    let Ok(text) = std::fs::read_to_string(path) else { return Ok(()) };
    let mut lines = text.split_inclusive('\n');
    let Some(header) = lines.next().map(str::trim_end) else { return Ok(()) };
    let lacks = |count: usize| {
        let lacked = &ADDED[..count];
        let before = COLUMNS.into_iter().filter(|column| !lacked.iter().any(|(added, _)| added == column));
        before.collect::<Vec<_>>().join(",") == header
    };
    let Some(count) = (1..=ADDED.len()).find(|count| lacks(*count)) else { return Ok(()) };
    let added: String = ADDED[..count].iter().rev().map(|(_, value)| format!(",{value}")).collect();
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
        Rows::create(path, &COLUMNS).map(Steps)
    }

    /// Takes the file up again as it was after step `last`: see [`Rows::reopen`].
    pub(crate) fn reopen(path: &Path, last: Option<u64>) -> Result<Self, RecordError> {
        add_columns(path)?;
        Rows::reopen(path, &COLUMNS, last).map(Steps)
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
