//! Rows and times, over the run and by generation.

use super::Run;
use super::morphology::{deviation, mean};
use crate::paper::{RunSummary, Window, method_name};
use relcp::scene::Method;
use serde::Serialize;

/// A mean over windows and its standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// The mean.
    pub mean: f64,
    /// The standard deviation; zero of one window.
    pub deviation: f64,
}

impl Spread {
    fn of(values: &[f64]) -> Option<Spread> {
        Some(Spread { mean: mean(values)?, deviation: deviation(values).unwrap_or(0.0) })
    }
}

/// A line of the table: the first run of a method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// How contacts are resolved.
    pub method: String,
    /// Sub-spheres of a cell.
    pub spheres: Option<u32>,
    /// Cells at the end.
    pub bodies: usize,
    /// Rows over those of ReLCP.
    pub relative_constraints: Option<f64>,
    /// Its standard deviation.
    pub relative_constraints_deviation: Option<f64>,
    /// Microseconds a row.
    pub row_microseconds: Option<f64>,
    /// Its standard deviation.
    pub row_microseconds_deviation: Option<f64>,
    /// Milliseconds of all steps.
    pub milliseconds: f64,
    /// The same over those of ReLCP's same steps.
    pub relative_time: Option<f64>,
    /// Milliseconds of a step over ReLCP's, in the last window.
    pub relative_time_at_the_end: Option<f64>,
    /// Rows of the last LCP of the last step.
    pub last_constraints: usize,
    /// Applications of `A` of a step.
    pub products: f64,
    /// The largest overlap of smooth surfaces.
    pub max_overlap: f64,
    /// The largest overlap of sub-spheres.
    pub proxy_overlap: Option<f64>,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u64,
    /// Steps that left more than the tolerance between smooth surfaces.
    pub steps_over: u64,
    /// Steps taken.
    pub steps: u64,
}

/// The first run of ReLCP.
fn relcp(runs: &[Run]) -> Option<&RunSummary> {
    runs.iter().find(|run| run.case.method == Method::Relcp && run.case.seed == 1).map(|run| &run.summary)
}

/// The first runs of all methods.
pub(super) fn rows(runs: &[Run]) -> Vec<Row> {
    let relcp = relcp(runs);
    runs.iter().filter(|run| run.case.seed == 1).map(|run| row(&run.summary, relcp)).collect()
}

fn row(summary: &RunSummary, relcp: Option<&RunSummary>) -> Row {
    let pairs: Vec<(&Window, &Window)> = relcp.map_or(Vec::new(), |relcp| summary.beside(relcp).collect());
    // A founder has no neighbour, so no row: such windows say nothing.
    let has_rows = |window: &Window| window.constraints > 0.0;
    let touching = pairs.iter().filter(|(own, other)| has_rows(own) && has_rows(other));
    let relative: Vec<f64> = touching.map(|(own, other)| own.constraints / other.constraints).collect();
    let each: Vec<f64> =
        summary.windows.iter().filter(|w| has_rows(w)).map(|w| 1e3 * w.milliseconds / w.constraints).collect();
    let (relative, each) = (Spread::of(&relative), Spread::of(&each));
    let own: f64 = pairs.iter().map(|(own, _)| own.milliseconds * own.steps as f64).sum();
    let other: f64 = pairs.iter().map(|(_, other)| other.milliseconds * other.steps as f64).sum();
    Row {
        method: summary.method.clone(),
        spheres: summary.spheres,
        bodies: summary.bodies,
        relative_constraints: relative.map(|spread| spread.mean),
        relative_constraints_deviation: relative.map(|spread| spread.deviation),
        row_microseconds: each.map(|spread| spread.mean),
        row_microseconds_deviation: each.map(|spread| spread.deviation),
        milliseconds: summary.milliseconds,
        relative_time: (other > 0.0).then(|| own / other),
        relative_time_at_the_end: pairs.last().map(|(own, other)| own.milliseconds / other.milliseconds),
        last_constraints: summary.last_constraints,
        products: summary.products as f64 / summary.steps.max(1) as f64,
        max_overlap: summary.max_overlap,
        proxy_overlap: summary.proxy_overlap,
        unconverged: summary.unconverged,
        steps_over: summary.steps_over,
        steps: summary.steps,
    }
}

/// Rows and time of a step at a number of cells.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ByGeneration {
    /// How contacts are resolved.
    pub method: String,
    /// Cells.
    pub bodies: usize,
    /// Steps.
    pub steps: u64,
    /// Rows of a step.
    pub constraints: f64,
    /// Milliseconds of a step.
    pub milliseconds: f64,
    /// Rows over ReLCP's.
    pub relative_constraints: Option<f64>,
    /// Milliseconds over ReLCP's.
    pub relative_time: Option<f64>,
}

/// The first runs of all methods, by the cells at the end of each window. After the last division there is no whole
/// window: it is left out.
pub(super) fn by_generation(runs: &[Run]) -> Vec<ByGeneration> {
    let mut lines: Vec<ByGeneration> = Vec::new();
    for run in runs.iter().filter(|run| run.case.seed == 1) {
        let windows = run.summary.windows.iter().filter(|window| window.bodies < run.summary.bodies);
        let windows: Vec<&Window> = windows.collect();
        for same in windows.chunk_by(|a, b| a.bodies == b.bodies) {
            let steps: u64 = same.iter().map(|window| window.steps).sum();
            let average = |of: fn(&Window) -> f64| {
                same.iter().map(|window| of(window) * window.steps as f64).sum::<f64>() / steps.max(1) as f64
            };
            let (constraints, milliseconds) = (average(|w| w.constraints), average(|w| w.milliseconds));
            let bodies = same.first().map_or(0, |window| window.bodies);
            // ReLCP's run comes first; its own lines are compared with themselves.
            let found = lines.iter().find(|line| line.bodies == bodies && line.method == method_name(Method::Relcp));
            let other = found.map(|line| [line.constraints, line.milliseconds]);
            let other = other.or(run.summary.is_relcp().then_some([constraints, milliseconds]));
            let over = |own: f64, at: usize| other.map(|other| own / other[at]).filter(|ratio| ratio.is_finite());
            let (relative_constraints, relative_time) = (over(constraints, 0), over(milliseconds, 1));
            let method = run.summary.method.clone();
            lines.push(ByGeneration {
                method,
                bodies,
                steps,
                constraints,
                milliseconds,
                relative_constraints,
                relative_time,
            });
        }
    }
    lines
}
