//! The page and the table of chambers.

use super::Row;
use crate::StudyError;
use crate::machine::machine;
use crate::table::csv_table;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The page of the chambers of a seed.
pub fn page(rows: &[Row], seed: u64, stalls: bool) -> String {
    let stall = if stalls { " --stall" } else { "" };
    let mut out = format!(
        "# Growth chambers\n\n\
         {} chambers that seed {seed} draws: planar, cells of diameter 1, 5 to 20 wide (half of them a whole number), 10 to 20 high, the floor flat in half of them and tilted by up to \
         15 degrees in the others, open above. Cells grow at the rate 1, add a length of 2 before they divide, and leave above. A run ends when its chamber has overflowed for two generations. \
         {}Made by `cargo run --release -p relcp-lab -- hard --chambers {}{stall}`. {}. Computed by CPU f64.\n",
        rows.len(),
        if stalls { "Cells without room wait (`growth.on_no_room: \"stall\"`). " } else { "" },
        rows.len(),
        machine()
    );
    write_ends(&mut out, rows);
    write_spread(&mut out, rows);
    write_stopped(&mut out, rows);
    out
}

fn write_ends(out: &mut String, rows: &[Row]) {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    rows.iter().for_each(|row| *counts.entry(row.end.name()).or_default() += 1);
    out.push_str("\n| ended | chambers |\n| --- | ---: |\n");
    for (name, count) in counts {
        let _ = writeln!(out, "| {name} | {count} |");
    }
}

/// Writes the median, the 90th percentile and the maximum of each figure.
fn write_spread(out: &mut String, rows: &[Row]) {
    type Figure = (&'static str, fn(&Row) -> Option<f64>);
    let figures: [Figure; 12] = [
        ("steps", |row| Some(row.steps as f64)),
        ("cells at the end", |row| Some(row.cells as f64)),
        ("cells that left", |row| Some(row.removed as f64)),
        ("most cells that left in a step", |row| Some(row.most_leaving as f64)),
        ("largest move in a step, diameters", |row| Some(row.largest_move)),
        ("recursions a step", |row| Some(row.recursions)),
        ("solves a step", |row| Some(row.solves)),
        ("steps in pieces", |row| Some(row.steps_cut as f64)),
        ("steps with cells that wait", |row| Some(row.steps_waiting as f64)),
        ("ms a step, 60 cells", |row| row.seconds_at_60.map(|s| 1e3 * s)),
        ("ms a step, 120 cells", |row| row.seconds_at_120.map(|s| 1e3 * s)),
        ("ms a step, 300 cells", |row| row.seconds_at_300.map(|s| 1e3 * s)),
    ];
    out.push_str("\n| figure | chambers | median | nine in ten | largest |\n| --- | ---: | ---: | ---: | ---: |\n");
    for (name, of) in figures {
        let mut values: Vec<f64> = rows.iter().filter_map(of).collect();
        values.sort_by(f64::total_cmp);
        let at = |part: f64| values.get((part * (values.len() as f64 - 1.0)).ceil() as usize).copied();
        let [middle, most, last] = [0.5, 0.9, 1.0].map(|part| at(part).map_or("-".into(), |x| format!("{x:.3}")));
        let _ = writeln!(out, "| {name} | {} | {middle} | {most} | {last} |", values.len());
    }
}

/// Writes the chambers whose run ended with a fault, and the chambers with the largest moves.
fn write_stopped(out: &mut String, rows: &[Row]) {
    const MOST: usize = 20;
    let mut worst: Vec<&Row> = rows.iter().filter(|row| !row.is_well()).collect();
    let _ = write!(
        out,
        "\n{} chambers overflowed, or grew to as many cells as a run may have, with moves of at most half a diameter and at most 4 cells that left in a step; {} did not.\n",
        rows.len() - worst.len(),
        worst.len()
    );
    if worst.is_empty() {
        return;
    }
    worst.sort_by(|a, b| b.largest_move.total_cmp(&a.largest_move));
    out.push_str("\n| chamber | wide | high | tilt | dt | ended | time | cells | left in a step | largest move |\n| ---: | ---: | ---: | ---: | ---: | --- | ---: | ---: | ---: | ---: |\n");
    for row in worst.iter().take(MOST) {
        let _ = writeln!(
            out,
            "| {} | {:.2} | {:.2} | {:.1} | {:.1e} | {} | {:.2} | {} | {} | {:.2} |",
            row.number,
            row.width,
            row.height,
            row.tilt,
            row.dt,
            row.end.name(),
            row.time,
            row.cells,
            row.most_leaving,
            row.largest_move
        );
    }
}

#[derive(Serialize)]
struct Line<'a> {
    chamber: u64,
    width: f64,
    height: f64,
    tilt: f64,
    dt: f64,
    ended: &'a str,
    time: f64,
    steps: u64,
    cells: usize,
    most_cells: usize,
    removed: u64,
    most_leaving: usize,
    largest_move: f64,
    moved_in_step: u64,
    recursions: f64,
    solves: f64,
    steps_cut: u64,
    steps_waiting: u64,
    no_room: u32,
    max_overlap: f64,
    seconds_at_60: Option<f64>,
    seconds_at_120: Option<f64>,
    seconds_at_300: Option<f64>,
    seconds: f64,
}

/// The rows as CSV.
///
/// # Errors
/// [`StudyError::Table`].
pub fn csv(rows: &[Row]) -> Result<Vec<u8>, StudyError> {
    let lines = rows.iter().map(|row| Line {
        chamber: row.number,
        width: row.width,
        height: row.height,
        tilt: row.tilt,
        dt: row.dt,
        ended: row.end.name(),
        time: row.time,
        steps: row.steps,
        cells: row.cells,
        most_cells: row.most_cells,
        removed: row.removed,
        most_leaving: row.most_leaving,
        largest_move: row.largest_move,
        moved_in_step: row.moved_in_step,
        recursions: row.recursions,
        solves: row.solves,
        steps_cut: row.steps_cut,
        steps_waiting: row.steps_waiting,
        no_room: row.no_room,
        max_overlap: row.max_overlap,
        seconds_at_60: row.seconds_at_60,
        seconds_at_120: row.seconds_at_120,
        seconds_at_300: row.seconds_at_300,
        seconds: row.seconds,
    });
    let lines: Vec<Line> = lines.collect();
    csv_table(lines.iter())
}
