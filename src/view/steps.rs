//! The columns of `steps.csv` and `measures.csv` for the plots of a page. A plot has one row per column of pixels.

use super::Pages;
use crate::record::{Folder, StepRow, Table, TableColumn};
use crate::render::inside;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The most rows of a plot.
const MOST: usize = 1200;

/// Columns of a plot. Of the steps that became one row, times and bodies are the last one's, the others the largest.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Steps {
    time: Vec<f64>,
    bodies: Vec<usize>,
    constraints: Vec<usize>,
    recursions: Vec<u32>,
    max_overlap: Vec<f64>,
    note: String,
}

/// The measures of a run: the time, and each column under its name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Measures {
    time: Vec<f64>,
    /// Name and title of each curve, in order.
    curves: Vec<(String, String)>,
    #[serde(flatten)]
    columns: BTreeMap<String, Vec<Option<f64>>>,
}

/// The tables of a run's folder.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Tables {
    pub steps: Option<Steps>,
    pub measures: Option<Measures>,
    /// What is to be said of them.
    pub notes: Vec<String>,
}

impl Tables {
    /// Those of a run's folder in the interval of time.
    pub fn read(source: &Path, pages: &Pages) -> Tables {
        let (steps, lost) = read(source, pages);
        let mut tables = Tables { steps, measures: None, notes: lost.into_iter().collect() };
        let path = Folder::view(source).measures();
        if path.is_file() {
            match Table::measures(&path) {
                Ok(table) => tables.measures = Measures::of(&table, pages),
                Err(why) => tables.notes.push(format!("{why}; they are not plotted")),
            }
        }
        tables
    }
}

impl Measures {
    /// The columns of numbers but the time and the step; none where there is no row.
    fn of(table: &Table, pages: &Pages) -> Option<Measures> {
        let numbers = |column: &TableColumn| match column {
            TableColumn::Integers(values) => Some(values.iter().map(|value| *value as f64).collect::<Vec<_>>()),
            TableColumn::Numbers(values) => Some(values.clone()),
            TableColumn::Words(_) => None,
        };
        let named =
            |wanted: &str| table.columns.iter().find(|(name, _)| name == wanted).and_then(|(_, of)| numbers(of));
        let times = named("time")?;
        let rows: Vec<usize> = (0..times.len()).filter(|row| inside(times[*row], pages.from, pages.to)).collect();
        let rows: Vec<usize> = rows.iter().copied().step_by(rows.len().div_ceil(MOST).max(1)).collect();
        let mut measures = Measures { time: rows.iter().map(|row| times[*row]).collect(), ..Measures::default() };
        let is_measure = |name: &str| !["time", "step"].contains(&name);
        for (name, column) in table.columns.iter().filter(|(name, _)| is_measure(name)) {
            let Some(values) = numbers(column) else { continue };
            let at = |row: &usize| Some(values[*row]).filter(|value| value.is_finite());
            measures.columns.insert(name.clone(), rows.iter().map(at).collect());
            measures.curves.push((name.clone(), name.replace('_', " ")));
        }
        (!rows.is_empty() && !measures.curves.is_empty()).then_some(measures)
    }
}

/// The steps of a run's folder in the interval of time, and what is to be said of a damaged file; none where there is
/// no file or no step.
fn read(source: &Path, pages: &Pages) -> (Option<Steps>, Option<String>) {
    let path = Folder::view(source).steps();
    if !path.is_file() {
        return (None, None);
    }
    let mut rows: Vec<StepRow> = Vec::new();
    let mut fault = None;
    match csv::Reader::from_path(&path) {
        Err(why) => fault = Some(why),
        Ok(mut reader) => {
            for row in reader.deserialize::<StepRow>() {
                match row {
                    Ok(row) => rows.push(row),
                    Err(why) => {
                        fault = Some(why);
                        break;
                    }
                }
            }
        }
    }
    rows.retain(|row| inside(row.time, pages.from, pages.to));
    let note = fault.map(|why| format!("{}: {}; the plot ends after {} steps", path.display(), why, rows.len()));
    ((!rows.is_empty()).then(|| Steps::of(&rows)), note)
}

impl Steps {
    fn of(rows: &[StepRow]) -> Steps {
        let each = rows.len().div_ceil(MOST);
        let mut steps = Steps {
            note: match each {
                1 => "Every step of the run. Click for the nearest state.".into(),
                _ => format!("A point is {each} steps: the largest of them. Click for the nearest state."),
            },
            ..Steps::default()
        };
        for part in rows.chunks(each) {
            let last = part[part.len() - 1];
            steps.time.push(last.time);
            steps.bodies.push(last.bodies);
            steps.constraints.push(part.iter().map(|row| row.constraints).max().unwrap_or(0));
            steps.recursions.push(part.iter().map(|row| row.recursions).max().unwrap_or(0));
            steps.max_overlap.push(part.iter().map(|row| row.max_overlap).fold(0.0, f64::max));
        }
        steps
    }
}
