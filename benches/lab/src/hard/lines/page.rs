//! The page and the table of pressed rows.

use super::{Line, Row};
use crate::StudyError;
use crate::machine::machine;
use crate::table::csv_table;
use serde::Serialize;
use std::fmt::Write as _;

/// The page.
pub fn page(rows: &[Row]) -> String {
    let well = rows.iter().filter(|row| row.is_well()).count();
    let mut out = format!(
        "# Bodies in line\n\n\
         Rows of bodies between walls, of which one closes with the speed 1 by half of a body's length, which is 2. \"Offset\": the largest distance of two centres across the row at the \
         end. The error is that of the offset where it has a closed form (two balls, overdamped); of other rows that are not exactly in line it is the largest difference between the distances of \
         two points, centres and ends, from those of a run with a hundredth of a step of 0.005 (in a quick study, a tenth of one of 0.02). The largest move is how far contact moved a centre in one step, in thicknesses. \
         With inertia the walls hit the row, and no shorter step gives a limit: its offsets are there to be seen, not to be judged.\n\n\
         {} runs: {well} end with moves of at most half a thickness and, where there is a closed form, within 0.01 of it; {} do not. Made by `cargo run --release -p relcp-lab -- hard --lines`. {}. Computed by CPU f64.\n",
        rows.len(),
        rows.len() - well,
        machine()
    );
    for group in rows.chunk_by(|a, b| a.line.what() == b.line.what()) {
        write_group(&mut out, group);
    }
    out
}

/// One line for all steps of a row.
fn write_group(out: &mut String, rows: &[Row]) {
    let Some(first) = rows.first() else { return };
    let right = first.right_offset.map_or(String::new(), |right| format!(" Right: an offset of {right:.4}."));
    let _ = write!(
        out,
        "\n## {}\n\n{} steps, from {} to {}.{right}\n\n\
         | space | law | out of line | offset | largest error | largest move | solves a step, most | in pieces | stopped | well |\n\
         | --- | --- | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n",
        first.line.what(),
        rows.chunk_by(|a, b| a.line == b.line).next().map_or(0, <[Row]>::len),
        rows.iter().map(|row| row.dt).fold(f64::INFINITY, f64::min),
        rows.iter().map(|row| row.dt).fold(0.0, f64::max),
    );
    for of_line in rows.chunk_by(|a, b| a.line == b.line) {
        write_line(out, of_line);
    }
}

fn write_line(out: &mut String, rows: &[Row]) {
    let Some(Row { line: Line { planar, inertial, misalignment, .. }, .. }) = rows.first() else { return };
    let most = |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).fold(0.0, f64::max);
    let offsets = rows.iter().map(|row| row.offset);
    let [low, high] = [offsets.clone().fold(f64::INFINITY, f64::min), offsets.fold(0.0, f64::max)];
    let errors = rows.iter().filter_map(|row| row.error);
    let error = errors.reduce(f64::max).map_or("-".into(), |error| format!("{error:.1e}"));
    let count = |is: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| is(row)).count();
    let _ = writeln!(
        out,
        "| {} | {} | {misalignment:.0e} | {low:.4} to {high:.4} | {error} | {:.2} | {:.2} | {} | {} | {} of {} |",
        if *planar { "plane" } else { "space" },
        if *inertial { "inertial" } else { "overdamped" },
        most(&|row| row.largest_move),
        most(&|row| row.solves),
        rows.iter().map(|row| row.steps_cut).sum::<u64>(),
        count(&|row| row.fault.is_some()),
        count(&Row::is_well),
        rows.len()
    );
}

#[derive(Serialize)]
struct Record<'a> {
    what: String,
    space: &'static str,
    law: &'static str,
    misalignment: f64,
    dt: f64,
    steps: u64,
    offset: f64,
    right_offset: Option<f64>,
    error: Option<f64>,
    largest_move: f64,
    solves: f64,
    steps_cut: u64,
    max_overlap: f64,
    well: bool,
    fault: &'a str,
}

/// The rows as CSV.
///
/// # Errors
/// [`StudyError::Table`].
pub fn csv(rows: &[Row]) -> Result<Vec<u8>, StudyError> {
    let records = rows.iter().map(|row| Record {
        what: row.line.what(),
        space: if row.line.planar { "plane" } else { "space" },
        law: if row.line.inertial { "inertial" } else { "overdamped" },
        misalignment: row.line.misalignment,
        dt: row.dt,
        steps: row.steps,
        offset: row.offset,
        right_offset: row.right_offset,
        error: row.error,
        largest_move: row.largest_move,
        solves: row.solves,
        steps_cut: row.steps_cut,
        max_overlap: row.max_overlap,
        well: row.is_well(),
        fault: row.fault.as_deref().unwrap_or(""),
    });
    let records: Vec<Record> = records.collect();
    csv_table(records.iter())
}
