//! The files of a measurement: `measures.csv` with one row per state, `NAME.csv` with the rows of a profile by state,
//! `measures.json` with everything, and one file per plot.

use super::{Cell, Column, Frame, MeasureError, Measured, Settings, plot};
use crate::figure::Format;
use crate::record::{RecordError, durable};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The file of all values.
const TABLE: &str = "measures.csv";
/// The file of everything.
const DOCUMENT: &str = "measures.json";

/// All results, as in `measures.json`.
#[derive(Serialize)]
pub struct Document<'a> {
    frame: &'a Frame,
    settings: &'a Settings,
    notes: &'a [String],
    measures: Vec<About>,
    states: Vec<StateOf<'a>>,
}

#[derive(Serialize)]
struct About {
    name: &'static str,
    about: &'static str,
    columns: &'static [Column],
    profile: &'static [Column],
}

#[derive(Serialize)]
struct StateOf<'a> {
    step: u64,
    time: f64,
    bodies: usize,
    values: BTreeMap<&'static str, Cell>,
    /// By measure: the reason why it, or a part of it, is missing.
    remarks: BTreeMap<&'static str, &'a str>,
    /// By measure: the rows of its profile.
    profiles: BTreeMap<&'static str, &'a [Vec<Cell>]>,
}

impl<'a> Document<'a> {
    /// The document of a measurement.
    pub fn new(measured: &'a Measured) -> Self {
        let about = |measure: &&'static dyn super::Measure| About {
            name: measure.name(),
            about: measure.about().line,
            columns: measure.columns(),
            profile: measure.profile().map_or(&[], |profile| profile.columns),
        };
        Document {
            frame: &measured.frame,
            settings: &measured.settings,
            notes: &measured.notes,
            measures: measured.measures.iter().map(about).collect(),
            states: (0..measured.len()).map(|state| StateOf::new(measured, state)).collect(),
        }
    }
}

impl<'a> StateOf<'a> {
    fn new(measured: &'a Measured, state: usize) -> Self {
        let by_measure = || measured.measures.iter().enumerate();
        let rows = |at: usize| Some(measured.found[at][state].as_ref().ok()?.rows.as_slice());
        StateOf {
            step: measured.steps[state],
            time: measured.times[state],
            bodies: measured.bodies[state],
            values: measured.columns().map(|column| column.name).zip(measured.values(state)).collect(),
            remarks: by_measure().filter_map(|(at, m)| Some((m.name(), measured.remark(at, state)?))).collect(),
            profiles: by_measure()
                .filter(|(_, measure)| measure.profile().is_some())
                .filter_map(|(at, measure)| Some((measure.name(), rows(at)?)))
                .collect(),
        }
    }
}

/// Writes the files of a measurement into a folder, which is created if necessary, and returns their paths. Files of an
/// earlier measurement that this one does not write are removed.
///
/// # Errors
/// A file or a folder that cannot be written, a plot that cannot be made.
pub fn write(measured: &Measured, folder: &Path, formats: &[Format]) -> Result<Vec<PathBuf>, MeasureError> {
    fs::create_dir_all(folder).map_err(RecordError::io(folder, "create the folder"))?;
    let mut files: Vec<(String, Vec<u8>)> = vec![(TABLE.into(), table(measured, &folder.join(TABLE))?)];
    for (at, measure) in measured.measures.iter().enumerate() {
        if let Some(profile) = measure.profile() {
            let name = format!("{}.csv", measure.name());
            let rows = rows(measured, at, profile.columns, &folder.join(&name))?;
            files.extend(rows.map(|rows| (name, rows)));
        }
    }
    let unmade = |(name, what): (String, String)| MeasureError::Unmade { path: folder.join(name), what };
    for (name, figure) in plot::plots(measured).map_err(unmade)? {
        for format in formats {
            let file = format!("{name}.{}", format.extension());
            files.push((file.clone(), figure.file(*format).map_err(|what| unmade((file, what)))?));
        }
    }
    for (name, bytes) in &files {
        durable::place(&folder.join(name), bytes)?;
    }
    let document = folder.join(DOCUMENT);
    durable::write_json(&document, &Document::new(measured))?;
    let mut paths: Vec<PathBuf> = files.iter().map(|(name, _)| folder.join(name)).collect();
    paths.insert(1, document);
    remove_others(folder, &paths)?;
    Ok(paths)
}

/// Removes files with names of this program's measures that are not among `paths`.
fn remove_others(folder: &Path, paths: &[PathBuf]) -> Result<(), RecordError> {
    let tables = super::ALL.iter().map(|m| format!("{}.csv", m.name()));
    let profiles = super::ALL.iter().map(|m| plot::profile_name(m.name()));
    let over_time = super::ALL.iter().flat_map(|m| m.about().plots.iter().map(|columns| plot::time_name(columns)));
    let figures = profiles.chain(over_time).flat_map(|name| {
        [Format::Svg, Format::Pdf, Format::Png].map(|format| format!("{name}.{}", format.extension()))
    });
    for path in tables.chain(figures).map(|name| folder.join(name)) {
        if path.is_file() && !paths.contains(&path) {
            fs::remove_file(&path).map_err(RecordError::io(&path, "remove it"))?;
        }
    }
    Ok(())
}

/// A number as text.
pub(crate) fn field(cell: Cell) -> String {
    cell.map_or_else(String::new, |value| value.to_string())
}

/// Rows of text as CSV.
fn pack(header: Vec<String>, rows: impl Iterator<Item = Vec<String>>, path: &Path) -> Result<Vec<u8>, MeasureError> {
    let unmade = |e: &dyn std::fmt::Display| MeasureError::Unmade { path: path.into(), what: e.to_string() };
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header).map_err(|e| unmade(&e))?;
    for row in rows {
        writer.write_record(row).map_err(|e| unmade(&e))?;
    }
    writer.into_inner().map_err(|e| unmade(&e))
}

fn table(measured: &Measured, path: &Path) -> Result<Vec<u8>, MeasureError> {
    let header = ["step", "time", "bodies"].into_iter().chain(measured.columns().map(|column| column.name));
    let row = |state: usize| {
        let own =
            [measured.steps[state].to_string(), measured.times[state].to_string(), measured.bodies[state].to_string()];
        own.into_iter().chain(measured.values(state).map(field)).collect()
    };
    pack(header.map(String::from).collect(), (0..measured.len()).map(row), path)
}

/// The rows of a measure's profile by state; none if no state has any.
fn rows(measured: &Measured, at: usize, columns: &[Column], path: &Path) -> Result<Option<Vec<u8>>, MeasureError> {
    let found = &measured.found[at];
    if found.iter().all(|found| found.as_ref().map_or(true, |found| found.rows.is_empty())) {
        return Ok(None);
    }
    let header = ["step", "time"].into_iter().chain(columns.iter().map(|column| column.name));
    let rows = found.iter().enumerate().flat_map(|(state, found)| {
        let start = [measured.steps[state].to_string(), measured.times[state].to_string()];
        let rows = found.as_ref().map_or(&[][..], |found| found.rows.as_slice());
        rows.iter().map(move |row| start.iter().cloned().chain(row.iter().copied().map(field)).collect())
    });
    pack(header.map(String::from).collect(), rows, path).map(Some)
}
