//! The targets of the study.

use super::page::{PAPER_LINEAR_DT, PAPER_ROWS, of_paper};
use super::{Part, Row, Run};
use crate::paper::{Census, Target};

pub(super) fn targets(rows: &[Row], runs: &[Run], census: &Census) -> Vec<Target> {
    let relcp: Vec<&Run> = runs.iter().filter(|run| run.case.part != Part::Public && run.summary.is_relcp()).collect();
    let settled = settled(rows);
    let public: Vec<&Row> = rows.iter().filter(|row| row.spheres.is_some() && row.part == Part::Public).collect();
    let mut targets = vec![tolerance_held(&relcp)];
    targets.extend(fewer_and_faster(&settled));
    targets.extend(beside_paper(&settled, &public));
    targets.push(census.target(&PAPER_ROWS));
    targets.push(accepted_at_once(&relcp));
    targets
}

/// Rows of sub-spheres by the default solver: of whole runs where there are, else from the dense state.
fn settled(rows: &[Row]) -> Vec<&Row> {
    let spheres = || rows.iter().filter(|row| row.spheres.is_some() && row.part != Part::Public);
    let of_whole =
        |row: &Row| spheres().any(|has| (has.part, has.dt, has.spheres) == (Part::Whole, row.dt, row.spheres));
    spheres().filter(|row| row.part == Part::Whole || !of_whole(row)).collect()
}

fn tolerance_held(relcp: &[&Run]) -> Target {
    let largest = relcp.iter().map(|run| run.summary.max_overlap).fold(0.0, f64::max);
    let over: u64 = relcp.iter().map(|run| run.summary.steps_over).sum();
    Target::new(
        "ReLCP holds the overlap tolerance after every step",
        format!("{largest:.3e} at most, {over} steps over"),
        (!relcp.is_empty()).then_some(over == 0),
    )
}

fn fewer_and_faster(settled: &[&Row]) -> [Target; 2] {
    let fine: Vec<&Row> = settled.iter().copied().filter(|row| row.spheres.is_some_and(|count| count > 3)).collect();
    [
        least("ReLCP has fewer rows than LCP-MS at the end, at every dt", settled, |row| {
            Some([row.relative_constraints?, 1.0])
        }),
        least("ReLCP takes less time a step at the end than LCP-MS with more than 3 sub-spheres", &fine, |row| {
            Some([row.relative_time?, 1.0])
        }),
    ]
}

fn beside_paper(settled: &[&Row], public: &[&Row]) -> [Target; 4] {
    let time = |row: &Row| Some([row.relative_time?, of_paper(row)?[1]]);
    let of_one_distance = |row: &&Row| PAPER_ROWS.iter().any(|(count, _)| Some(*count) == row.spheres);
    let ratio = |row: &Row| Some((label(row), row.relative_constraints? / of_paper(row)?[0]));
    let ratios: Vec<(String, f64)> = settled.iter().copied().filter(of_one_distance).filter_map(ratio).collect();
    [
        least("LCP-MS has as many rows over ReLCP's as in the paper at least", settled, |row| {
            Some([row.relative_constraints?, of_paper(row)?[0]])
        }),
        least("LCP-MS takes as much time over ReLCP's as in the paper at least", settled, time),
        least(
            "LCP-MS by the solver of public codes takes as much time over ReLCP's as in the paper at least",
            public,
            time,
        ),
        Target::near("rows over ReLCP's with more than 3 sub-spheres", &ratios),
    ]
}

fn accepted_at_once(relcp: &[&Run]) -> Target {
    let linear = relcp.iter().find(|run| run.case.dt == PAPER_LINEAR_DT && run.case.part == Part::Whole);
    let found = |run: &&Run| format!("{} recursions in {} steps", run.summary.recursions, run.summary.steps);
    Target::new(
        format!("at dt {PAPER_LINEAR_DT} ReLCP's first solve is accepted at every step, as in the paper"),
        linear.map_or(String::new(), found),
        linear.map(|run| run.summary.recursions == 0),
    )
}

fn label(row: &Row) -> String {
    let part = match row.part {
        Part::Whole => "",
        Part::Dense => ", dense",
        Part::Public => ", public",
    };
    format!("{} at {}{part}", row.method, row.dt)
}

/// Whether a number of each row is at least another.
fn least(wanted: &str, rows: &[&Row], of: impl Fn(&Row) -> Option<[f64; 2]>) -> Target {
    let found = rows.iter().filter_map(|row| Some((label(row), of(row)?)));
    Target::at_least(wanted, &found.collect::<Vec<_>>())
}
