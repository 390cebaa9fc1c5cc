//! What `steps.csv` tells of the run, thinned to as many rows as a plot has columns of pixels.

use super::Pages;
use crate::record::{Folder, StepRow};
use crate::render::inside;
use serde::Serialize;
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

/// The steps of a run's folder in the interval of time, and what is to be said of a damaged file; none where there is
/// no file or no step.
pub(super) fn read(source: &Path, pages: &Pages) -> (Option<Steps>, Option<String>) {
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
