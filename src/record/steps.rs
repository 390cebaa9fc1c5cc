//! `steps.csv`: one row a recorded step.

use super::error::RecordError;
use crate::relcp::StepReport;
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// The columns, in their order.
pub const COLUMNS: [&str; 10] = [
    "step",
    "time",
    "bodies",
    "constraints",
    "recursions",
    "iterations",
    "products",
    "residual",
    "max_overlap",
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
    /// Largest true overlap that it left, a length.
    pub max_overlap: f64,
    /// Wall time of this step, without its output.
    pub wall_seconds: f64,
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
            max_overlap: report.max_overlap,
            wall_seconds,
        }
    }
}

/// The file, open for writing and locked against other processes for as long.
#[derive(Debug)]
pub(super) struct Steps {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl Steps {
    /// Starts the file.
    pub(super) fn create(path: &Path) -> Result<Self, RecordError> {
        let file = File::create_new(path).map_err(RecordError::io(path, "create it"))?;
        lock(&file, path)?;
        let mut steps = Steps { path: path.into(), writer: writer(file) };
        steps.writer.write_record(COLUMNS).map_err(|e| steps.fault(e.into()))?;
        steps.flush()?;
        Ok(steps)
    }

    /// Takes the file up again as it was after step `last`, which was its last row where any was written: what follows
    /// is cut off.
    pub(super) fn reopen(path: &Path, last: Option<u64>) -> Result<Self, RecordError> {
        let mut file =
            OpenOptions::new().read(true).write(true).open(path).map_err(RecordError::io(path, "open it"))?;
        lock(&file, path)?;
        // A device may have no end.
        if !file.metadata().map_err(RecordError::io(path, "open it"))?.is_file() {
            return Err(RecordError::Mangled { path: path.into(), what: "it is not a file".into() });
        }
        let end = end_of(&file, path, last)?;
        file.set_len(end).map_err(RecordError::io(path, "cut it"))?;
        file.seek(SeekFrom::End(0)).map_err(RecordError::io(path, "write it"))?;
        Ok(Steps { path: path.into(), writer: writer(file) })
    }

    /// Adds a row.
    pub(super) fn push(&mut self, report: &StepReport, wall_seconds: f64) -> Result<(), RecordError> {
        self.writer.serialize(StepRow::new(report, wall_seconds)).map_err(|e| self.fault(e.into()))
    }

    /// Hands the rows so far to the system.
    pub(super) fn flush(&mut self) -> Result<(), RecordError> {
        self.writer.flush().map_err(|e| self.fault(e))
    }

    /// Makes the rows so far last.
    pub(super) fn sync(&mut self) -> Result<(), RecordError> {
        self.flush()?;
        self.writer.get_ref().sync_data().map_err(|e| self.fault(e))
    }

    fn fault(&self, source: std::io::Error) -> RecordError {
        RecordError::io(&self.path, "write it")(source)
    }
}

fn writer(file: File) -> csv::Writer<File> {
    csv::WriterBuilder::new().has_headers(false).from_writer(file)
}

/// Takes the file for this process. A file system that knows no locks cannot refuse, and is not refused.
fn lock(file: &File, path: &Path) -> Result<(), RecordError> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(RecordError::InUse { path: path.parent().unwrap_or(path).into() }),
        _ => Ok(()),
    }
}

/// Where the row of step `last` ends, or the heading where there is none.
fn end_of(file: &File, path: &Path, last: Option<u64>) -> Result<u64, RecordError> {
    let mangled = |what: String| RecordError::Mangled { path: path.into(), what };
    let mut reader = csv::ReaderBuilder::new().from_reader(file);
    let headings = reader.headers().map_err(|e| mangled(e.to_string()))?;
    if headings.iter().ne(COLUMNS) {
        return Err(mangled(format!("its columns are not {}", COLUMNS.join(","))));
    }
    let mut row = csv::StringRecord::new();
    loop {
        let end = reader.position().byte();
        let found = reader.read_record(&mut row).unwrap_or(false);
        let step = row.get(0).and_then(|text| text.parse::<u64>().ok()).filter(|_| found);
        match (step, last) {
            (_, None) => return Ok(end),
            (Some(step), Some(last)) if step == last => return Ok(reader.position().byte()),
            (Some(step), Some(last)) if step < last => {}
            (_, Some(last)) => return Err(mangled(format!("the row of step {last} is missing"))),
        }
    }
}
