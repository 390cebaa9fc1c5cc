//! A table that grows by a row for each recorded step and is cut back to a step when a run continues. Its first column
//! is the step's number.

use super::error::RecordError;
use serde::Serialize;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes of rows that are held back at most, so that a row costs no call of the system.
const HELD_BACK: usize = 1 << 13;

/// The file, open for writing and locked against other processes for as long. It ends with a whole row at any time: it
/// is written by whole rows, and what a full disk took of them is cut off again.
#[derive(Debug)]
pub(crate) struct Rows {
    path: PathBuf,
    file: File,
    /// Bytes of the file, all of whole rows.
    written: u64,
    /// Whole rows that are not in it yet.
    held: Vec<u8>,
}

impl Rows {
    /// Starts the file, with these columns.
    pub(crate) fn create(path: &Path, columns: &[&str]) -> Result<Self, RecordError> {
        let file = File::create_new(path).map_err(RecordError::io(path, "create it"))?;
        lock(&file, path)?;
        let mut rows = Rows { path: path.into(), file, written: 0, held: Vec::new() };
        rows.push(columns)?;
        rows.flush()?;
        Ok(rows)
    }

    /// Takes the file up again as it was after step `last`, which was its last row where any was written: what follows
    /// is cut off.
    pub(crate) fn reopen(path: &Path, columns: &[&str], last: Option<u64>) -> Result<Self, RecordError> {
        Rows::cut(path, |file| end_of(file, path, columns, last))
    }

    /// Takes the file up again as it was after step `last`, where a step has any number of rows: those of later steps
    /// are cut off.
    pub(crate) fn reopen_up_to(path: &Path, columns: &[&str], last: u64) -> Result<Self, RecordError> {
        Rows::cut(path, |file| end_up_to(file, path, columns, last))
    }

    fn cut(path: &Path, end: impl FnOnce(&File) -> Result<u64, RecordError>) -> Result<Self, RecordError> {
        let mut file =
            OpenOptions::new().read(true).write(true).open(path).map_err(RecordError::io(path, "open it"))?;
        lock(&file, path)?;
        // A device may have no end.
        if !file.metadata().map_err(RecordError::io(path, "open it"))?.is_file() {
            return Err(RecordError::Mangled { path: path.into(), what: "it is not a file".into() });
        }
        let end = end(&file)?;
        file.set_len(end).map_err(RecordError::io(path, "cut it"))?;
        file.seek(SeekFrom::End(0)).map_err(RecordError::io(path, "write it"))?;
        Ok(Rows { path: path.into(), file, written: end, held: Vec::new() })
    }

    /// Adds a row.
    pub(crate) fn push(&mut self, row: impl Serialize) -> Result<(), RecordError> {
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
        let whole = writer.serialize(row).map_err(|e| self.fault(e.into()));
        whole.and_then(|()| writer.into_inner().map_err(|e| self.fault(e.into_error()))).map(|row| {
            self.held.extend(row);
        })?;
        if self.held.len() < HELD_BACK { Ok(()) } else { self.flush() }
    }

    /// Hands the rows so far to the system; where it takes a part of them only, it gets none.
    pub(crate) fn flush(&mut self) -> Result<(), RecordError> {
        let held = std::mem::take(&mut self.held);
        if let Err(fault) = self.file.write_all(&held) {
            // Rows that cannot be cut off now are cut off when the run continues.
            let _ = self.file.set_len(self.written).and_then(|()| self.file.seek(SeekFrom::End(0)));
            return Err(self.fault(fault));
        }
        self.written += held.len() as u64;
        Ok(())
    }

    /// Makes the rows so far last.
    pub(crate) fn sync(&mut self) -> Result<(), RecordError> {
        self.flush()?;
        self.file.sync_data().map_err(|e| self.fault(e))
    }

    fn fault(&self, source: std::io::Error) -> RecordError {
        RecordError::io(&self.path, "write it")(source)
    }
}

impl Drop for Rows {
    /// A run that ends by a fault leaves the rows that it has.
    fn drop(&mut self) {
        let _ = self.flush();
    }
}

/// Takes the file for this process. A file system that knows no locks cannot refuse, and is not refused.
fn lock(file: &File, path: &Path) -> Result<(), RecordError> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(RecordError::InUse { path: path.parent().unwrap_or(path).into() }),
        _ => Ok(()),
    }
}

fn mangled(path: &Path, what: String) -> RecordError {
    RecordError::Mangled { path: path.into(), what }
}

/// A reader past the heading, which must be these columns.
fn reader<'a>(file: &'a File, path: &Path, columns: &[&str]) -> Result<csv::Reader<&'a File>, RecordError> {
    let mut reader = csv::ReaderBuilder::new().from_reader(file);
    let headings = reader.headers().map_err(|e| mangled(path, e.to_string()))?;
    if headings.iter().ne(columns.iter().copied()) {
        return Err(mangled(path, format!("its columns are not {}", columns.join(","))));
    }
    Ok(reader)
}

/// Where the first row of a step after `last` begins, or one that is not whole.
fn end_up_to(file: &File, path: &Path, columns: &[&str], last: u64) -> Result<u64, RecordError> {
    let mut reader = reader(file, path, columns)?;
    let mut row = csv::StringRecord::new();
    loop {
        let end = reader.position().byte();
        let found = reader.read_record(&mut row).unwrap_or(false);
        let step = row.get(0).and_then(|text| text.parse::<u64>().ok()).filter(|_| found);
        if step.is_none_or(|step| step > last) {
            return Ok(end);
        }
    }
}

/// Where the row of step `last` ends, or the heading where there is none.
fn end_of(file: &File, path: &Path, columns: &[&str], last: Option<u64>) -> Result<u64, RecordError> {
    let mut reader = reader(file, path, columns)?;
    let mut row = csv::StringRecord::new();
    loop {
        let end = reader.position().byte();
        let found = reader.read_record(&mut row).unwrap_or(false);
        let step = row.get(0).and_then(|text| text.parse::<u64>().ok()).filter(|_| found);
        match (step, last) {
            (_, None) => return Ok(end),
            (Some(step), Some(last)) if step == last => return Ok(reader.position().byte()),
            (Some(step), Some(last)) if step < last => {}
            (_, Some(last)) => return Err(mangled(path, format!("the row of step {last} is missing"))),
        }
    }
}
