//! Three capsules by one row a pair (LCP-SNSD) and by ReLCP: the overlap that each step leaves, and how the bodies
//! shake from step to step. The paper's toy problem (its Figure 2).
//!
//! Jitter is the root mean square over the six tips of the second difference `|x_k+1 - 2 x_k + x_k-1|` of their places.
//! Of a smooth motion it falls with `dt^2`, and its ratio to the displacement `|x_k+1 - x_k|` with `dt`; of one that
//! turns back at every step the ratio is 2.

mod page;
mod plot;
mod run;
mod shake;

pub use run::{Capsules, Case, Method, Run, Window, follow};
pub use shake::Shake;

use super::Target;
use crate::StudyError;
use crate::table::csv_table;
use relcp::figure::Figure;
use serde::Serialize;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Steps of the capsules that are left alone.
    pub alone: &'static [f64],
    /// How many of each are taken.
    pub steps_alone: u64,
    /// Steps of the capsules that are pressed together. With one of 0.1 a capsule is through the next after the first.
    pub pressed: &'static [f64],
    /// The time for which they are; after 3 they slide off each other with the longest of these steps.
    pub end: f64,
}

impl Size {
    /// Some seconds.
    pub const FULL: Size = Size { alone: &[1e-2, 1e-4], steps_alone: 40, pressed: &[2e-2, 1e-2, 1e-3, 1e-4], end: 2.0 };
    /// A second.
    pub const QUICK: Size = Size { alone: &[1e-2, 1e-4], steps_alone: 40, pressed: &[2e-2, 1e-2], end: 2.0 };

    /// All runs, in the order in which they are made.
    pub fn cases(&self) -> Vec<Case> {
        let capsules = [(Capsules::Alone, self.alone), (Capsules::Pressed, self.pressed)];
        let of = |(capsules, steps): (Capsules, &'static [f64])| {
            steps.iter().flat_map(move |dt| Method::BOTH.map(|method| Case { capsules, method, dt: *dt }))
        };
        capsules.into_iter().flat_map(of).collect()
    }

    /// The steps that a run takes.
    pub fn steps(&self, case: &Case) -> u64 {
        match case.capsules {
            Capsules::Alone => self.steps_alone,
            Capsules::Pressed => (self.end / case.dt).round() as u64,
        }
    }
}

/// What was measured so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    size: Size,
    runs: Vec<Run>,
}

impl Study {
    /// Nothing yet.
    pub fn begin(size: Size) -> Self {
        Study { size, runs: Vec::new() }
    }

    /// What it measures.
    pub fn size(&self) -> &Size {
        &self.size
    }

    /// The runs so far.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Makes one more run.
    ///
    /// # Errors
    /// [`StudyError`] where it cannot be made.
    pub fn run(&mut self, case: Case) -> Result<(), StudyError> {
        self.runs.push(follow(case, self.size.steps(&case))?);
        Ok(())
    }

    /// What it is to show, and whether it does.
    pub fn targets(&self) -> Vec<Target> {
        page::targets(&self.runs)
    }

    /// Whether ReLCP did not hold its overlap tolerance, or a solve its own.
    pub fn missed(&self) -> bool {
        let fails = |run: &Run| run.case.method == Method::Relcp && run.max_overlap > run.overlap_tolerance;
        self.runs.iter().any(|run| run.unconverged > 0 || fails(run))
    }

    /// The page, without its plot.
    pub fn page(&self) -> String {
        page::page(self)
    }

    /// What each run came to, as CSV.
    ///
    /// # Errors
    /// [`StudyError::Table`].
    pub fn csv(&self) -> Result<Vec<u8>, StudyError> {
        let rows: Vec<Summary> = self.runs.iter().map(Summary::new).collect();
        csv_table(rows.iter())
    }

    /// Overlap and jitter over time, as CSV.
    ///
    /// # Errors
    /// [`StudyError::Table`].
    pub fn steps_csv(&self) -> Result<Vec<u8>, StudyError> {
        csv_table(self.runs.iter().flat_map(|run| &run.windows))
    }

    /// The plot: overlap and jitter over time.
    ///
    /// # Errors
    /// [`StudyError::Plot`].
    pub fn plot(&self) -> Result<Figure, StudyError> {
        plot::plot(self)
    }
}

/// A line of the table.
#[derive(Serialize)]
struct Summary {
    capsules: Capsules,
    method: Method,
    dt: f64,
    steps: u64,
    first_overlap: f64,
    max_overlap: f64,
    late_overlap: f64,
    steps_over: u64,
    resolved_at: Option<u64>,
    jitter: f64,
    late_jitter: f64,
    late_displacement: f64,
    late_ratio: Option<f64>,
    recursions: u64,
    products: u64,
}

impl Summary {
    fn new(run: &Run) -> Self {
        Summary {
            capsules: run.case.capsules,
            method: run.case.method,
            dt: run.case.dt,
            steps: run.steps,
            first_overlap: run.first_overlap,
            max_overlap: run.max_overlap,
            late_overlap: run.late_overlap,
            steps_over: run.steps_over,
            resolved_at: run.resolved_at,
            jitter: run.whole.jitter(),
            late_jitter: run.late.jitter(),
            late_displacement: run.late.displacement(),
            late_ratio: run.late.ratio(),
            recursions: run.recursions,
            products: run.products,
        }
    }
}

#[cfg(test)]
mod tests;
