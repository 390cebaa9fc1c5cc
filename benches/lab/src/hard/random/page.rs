//! The page and the table of drawn scenes.

use super::{From, Row};
use crate::StudyError;
use crate::hard::Verdict;
use crate::machine::machine;
use crate::table::csv_table;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The page of some scenes of a seed, computed by what `computed_by` names. With `flags` the program draws them again.
pub fn page(rows: &[Row], seed: u64, flags: &str, computed_by: &str) -> String {
    let mut out = format!(
        "# Drawn scenes\n\n\
         Scenes that seed {seed} draws, of every shape, law, force, wall and start that the program has. After every step the overlaps of bodies with each other and with walls are \
         computed afresh from the accepted bodies alone. A run ends at its end, where a typed error stops it, or at the first step that leaves more overlap than the tolerance.\n\n\
         * **holds**: every step is within the tolerance, and every solve within its own.\n\
         * **reported**: the program says what is wrong: it stops with a typed error, names bodies that went through each other, or a solve that ended early.\n\
         * **fails**: an accepted step is over the tolerance, a state is not finite, a panic, more overlap than the step reports, a solve that claims what it missed, a body that is \
         thrown (of pressed bodies: that contact moves by its length in a step), or energy from nowhere.\n\n\
         {}. Computed by {computed_by}.\n",
        machine()
    );
    for from in [From::Random, From::Confined, From::Pressed] {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.from == from).collect();
        write_group(&mut out, from, flags, &rows);
    }
    out
}

fn write_group(out: &mut String, from: From, flags: &str, rows: &[&Row]) {
    if rows.is_empty() {
        return;
    }
    let (title, again) = match from {
        From::Random => ("Random scenes", "random"),
        From::Confined => ("Confined colonies", "confined"),
        From::Pressed => ("Pressed bodies", "pressed"),
    };
    let count = |verdict: Verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    let steps: u64 = rows.iter().map(|row| row.figures.steps).sum();
    let _ = write!(
        out,
        "\n## {title}\n\n{} scenes, {steps} steps: {} hold, {} are reported, {} fail. Made by `cargo run --release -p relcp-lab -- hard --{again} {} {flags}`.\n",
        rows.len(),
        count(Verdict::Holds),
        count(Verdict::Reported),
        count(Verdict::Fails),
        rows.len()
    );
    let cut = rows.iter().map(|row| row.figures.steps_cut);
    let (cut, of) = (cut.clone().sum::<u64>(), cut.filter(|cut| *cut > 0).count());
    let pieces = rows.iter().map(|row| row.figures.most_pieces).max().unwrap_or(0);
    let _ = writeln!(out, "{cut} steps of {of} scenes were taken in pieces, {pieces} at most.");
    let ends = counted(rows.iter().map(|row| row.ended.as_str()));
    write_counts(out, "ended at", &ends);
    for (verdict, heading) in [(Verdict::Fails, "fails by"), (Verdict::Reported, "reported for")] {
        let of = rows.iter().filter(|row| row.verdict == verdict);
        write_counts(out, heading, &counted(of.flat_map(|row| row.why.iter().map(|against| against.kind))));
    }
    for measure in ["way of", "move of", "energy from"] {
        write_worst(out, measure, rows);
    }
    write_rows(out, rows);
}

fn counted<'a>(kinds: impl Iterator<Item = &'a str>) -> Vec<(&'a str, usize)> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    kinds.for_each(|kind| *counts.entry(kind).or_default() += 1);
    let mut counts: Vec<(&str, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts
}

fn write_counts(out: &mut String, heading: &str, counts: &[(&str, usize)]) {
    if counts.is_empty() {
        return;
    }
    let _ = write!(out, "\n| {heading} | scenes |\n| --- | ---: |\n");
    for (kind, count) in counts {
        let _ = writeln!(out, "| {kind} | {count} |");
    }
}

/// The largest value of a measure, and of which scene.
fn write_worst(out: &mut String, what: &str, rows: &[&Row]) {
    let of = |row: &&&Row| {
        row.measures.iter().find(|measure| measure.what.starts_with(what)).map(|m| (m.clone(), row.name.clone()))
    };
    let measured: Vec<_> = rows.iter().filter_map(|row| of(&row)).collect();
    let worst = measured.iter().max_by(|a, b| a.0.value.total_cmp(&b.0.value));
    if let Some((measure, name)) = worst {
        let _ = write!(
            out,
            "\nLargest {}: {:.2e}, of {name}; {} scenes measured.\n",
            measure.what,
            measure.value,
            measured.len()
        );
    }
}

/// The scenes that do not hold, with why.
fn write_rows(out: &mut String, rows: &[&Row]) {
    let lines: Vec<&&Row> = rows.iter().filter(|row| row.verdict != Verdict::Holds).collect();
    if lines.is_empty() {
        return;
    }
    out.push_str("\n| scene | what | bodies | steps | largest overlap | verdict | why |\n| --- | --- | ---: | ---: | ---: | --- | --- |\n");
    for row in lines {
        let why: Vec<&str> = row.why.iter().map(|against| against.words.as_str()).collect();
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {:.1e} | {} | {} |",
            row.name,
            row.what,
            row.figures.bodies,
            row.figures.steps,
            row.figures.max_overlap,
            row.verdict.name(),
            why.join("; ")
        );
    }
}

#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    what: &'a str,
    bodies: usize,
    steps: u64,
    overlap_tolerance: f64,
    max_overlap: f64,
    recursions_mean: f64,
    recursions_max: u32,
    worst_residual: f64,
    unconverged: u64,
    steps_passed: u64,
    steps_cut: u64,
    most_pieces: u32,
    ended: &'a str,
    thrown: Option<f64>,
    jumped: Option<f64>,
    energy: Option<f64>,
    verdict: Verdict,
    why: String,
}

/// The rows as CSV.
///
/// # Errors
/// [`StudyError::Table`].
pub fn csv(rows: &[Row]) -> Result<Vec<u8>, StudyError> {
    let measured = |row: &Row, what: &str| row.measures.iter().find(|m| m.what.starts_with(what)).map(|m| m.value);
    let lines = rows.iter().map(|row| Line {
        scene: &row.name,
        what: &row.what,
        bodies: row.figures.bodies,
        steps: row.figures.steps,
        overlap_tolerance: row.figures.overlap_tolerance,
        max_overlap: row.figures.max_overlap,
        recursions_mean: row.figures.recursions_mean,
        recursions_max: row.figures.recursions_max,
        worst_residual: row.figures.worst_residual,
        unconverged: row.figures.unconverged,
        steps_passed: row.figures.steps_passed,
        steps_cut: row.figures.steps_cut,
        most_pieces: row.figures.most_pieces,
        ended: &row.ended,
        thrown: measured(row, "way of"),
        jumped: measured(row, "move of"),
        energy: measured(row, "energy from"),
        verdict: row.verdict,
        why: row.why.iter().map(|against| against.words.as_str()).collect::<Vec<&str>>().join("; "),
    });
    let lines: Vec<Line> = lines.collect();
    csv_table(lines.iter())
}
