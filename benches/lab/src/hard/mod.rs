//! Numerical stability on hard cases: small scenes of the kinds that break contact codes, each run for some steps with
//! the default method on the CPU and audited from its accepted states only.
//!
//! The rules of a verdict are in [`judge`]: it fails if an accepted step exceeds its tolerance although the run should
//! stop there, if a state is not finite, if the program panics, if a step leaves more overlap than it reports, if a
//! solve reports a tolerance that it missed, or if a law or an invariance is violated beyond its bound. It is
//! "reported" if the program itself reports that a step or a solve missed its tolerance, rejects the scene, or stops
//! with a typed error.

mod cases;
pub mod chambers;
mod energy;
mod laws;
pub mod lines;
mod moves;
mod page;
pub mod random;
mod run;
mod same;
mod start;
mod threads;
mod verdict;

pub use cases::{Case, Test, all};
pub use laws::Law;
pub use run::{End, Figures, Run, follow, follow_on};
pub use same::Change;
pub use start::{Pull, Start};
pub use verdict::{Finding, Measure, Verdict, judge, weigh};

use super::StudyError;
use super::table::csv_table;
use serde::Serialize;

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Size {
    /// Steps of a case at most.
    pub most_steps: u64,
}

impl Size {
    /// All steps of each case.
    pub const FULL: Size = Size { most_steps: u64::MAX };
    /// A few.
    pub const QUICK: Size = Size { most_steps: 5 };
}

/// A case that was run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// What kind of hardness.
    pub group: &'static str,
    /// Its name.
    pub case: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The findings against it.
    pub why: Vec<String>,
    /// What the run came to.
    pub figures: Figures,
    /// What was measured beside contact.
    pub measure: Option<Measure>,
}

/// Runs a case.
pub fn measure(case: &Case, size: Size) -> Row {
    let steps = case.steps.min(size.most_steps);
    let (run, mut measure) = match case.test {
        Test::Contact => (follow(&case.start, steps, |_, _| {}), None),
        Test::Law(law) => {
            let mut watch = laws::Watch::new(law);
            let run = follow(&case.start, steps, |before, simulation| watch.see(before, simulation));
            (run, Some(watch.measure()))
        }
        Test::Same(change) => {
            let (run, measure) = same::compare(&case.start, change, steps);
            (run, Some(measure))
        }
    };
    // Nothing is measured of no step.
    if let (0, Some(measure)) = (run.figures.steps, &mut measure) {
        measure.value = f64::NAN;
    }
    let (verdict, why) = judge(&run.figures, measure.as_ref());
    Row { group: case.group, case: case.name.clone(), verdict, why, figures: run.figures, measure }
}

/// What was run so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    size: Size,
    rows: Vec<Row>,
}

impl Study {
    /// Nothing yet.
    pub fn begin(size: Size) -> Self {
        Study { size, rows: Vec::new() }
    }

    /// How much is run.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The rows so far.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Runs one more case.
    pub fn run(&mut self, case: &Case) {
        self.rows.push(measure(case, self.size));
    }

    /// Whether a case fails.
    pub fn missed(&self) -> bool {
        self.rows.iter().any(|row| row.verdict == Verdict::Fails)
    }

    /// The page.
    pub fn page(&self) -> String {
        page::page(self)
    }

    /// The rows as CSV.
    ///
    /// # Errors
    /// [`StudyError::Table`].
    pub fn csv(&self) -> Result<Vec<u8>, StudyError> {
        let lines: Vec<Line> = self.rows.iter().map(Line::new).collect();
        csv_table(lines.iter())
    }
}

/// A line of the table.
#[derive(Serialize)]
struct Line<'a> {
    group: &'a str,
    case: &'a str,
    bodies: usize,
    steps: u64,
    overlap_tolerance: f64,
    max_overlap: f64,
    steps_over: u64,
    recursions_mean: f64,
    recursions_max: u32,
    products: u64,
    worst_residual: f64,
    unconverged: u64,
    ended: String,
    measured: Option<&'a str>,
    value: Option<f64>,
    bound: Option<f64>,
    verdict: Verdict,
    why: String,
}

impl<'a> Line<'a> {
    fn new(row: &'a Row) -> Self {
        let Row { figures, measure, .. } = row;
        Line {
            group: row.group,
            case: &row.case,
            bodies: figures.bodies,
            steps: figures.steps,
            overlap_tolerance: figures.overlap_tolerance,
            max_overlap: figures.max_overlap,
            steps_over: figures.steps_over,
            recursions_mean: figures.recursions_mean,
            recursions_max: figures.recursions_max,
            products: figures.products,
            worst_residual: figures.worst_residual,
            unconverged: figures.unconverged,
            ended: figures.ended(),
            measured: measure.as_ref().map(|measure| measure.what),
            value: measure.as_ref().map(|measure| measure.value),
            bound: measure.as_ref().map(|measure| measure.bound),
            verdict: row.verdict,
            why: row.why.join("; "),
        }
    }
}

#[cfg(test)]
mod tests;
