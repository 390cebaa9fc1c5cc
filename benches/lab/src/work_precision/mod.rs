//! Work and precision: the cost of errors at the end of a run, by stepping scheme, contact method, step, overlap
//! tolerance and floating-point precision.
//!
//! Two schemes agree on the end of every scene. Scenes of crowds, which amplify small differences, are short and small.
//! Its [reference](Reference) is stored with the estimate of its own error. Steps are swept at one overlap tolerance,
//! tolerances at one step, and both together; not their full product.

mod best;
mod case;
mod page;
mod plot;
mod pose;
mod problem;
mod reference;

pub use best::{Best, Cheapest, Cost, Curve, ERRORS, best, curves};
pub use case::{Case, OVERLAP_TOLERANCE, Row, Size, Sweep, run};
pub use pose::{Apart, Pose, apart, limit, poses};
pub use problem::{PROBLEMS, Problem};
pub use reference::{CERTAINTY, Making, Reference};

use super::StudyError;
use super::paper::{Measured, Target, order};
use super::table::csv_table;
use relcp::figure::Figure;
use relcp::simulation::Compute;
use serde_json::{Value, json};

impl Size {
    /// Some minutes.
    pub const FULL: Size =
        Size { euler: 8, midpoint: 8, snsd: 6, multisphere: 4, spheres: 2, tolerances: 6, tolerances_at: 4, both: 8 };
    /// Some seconds.
    pub const QUICK: Size =
        Size { euler: 4, midpoint: 4, snsd: 3, multisphere: 2, spheres: 1, tolerances: 4, tolerances_at: 2, both: 4 };
}

/// The results so far.
pub struct Study {
    size: Size,
    computes: Vec<Compute>,
    problems: Vec<(Problem, Reference)>,
    cases: Vec<(usize, Case, usize)>,
    rows: Vec<Row>,
}

impl Study {
    /// Reads the references.
    ///
    /// # Errors
    /// [`StudyError::Reference`]; tests check that it does not occur.
    pub fn begin(size: Size, computes: Vec<Compute>) -> Result<Self, StudyError> {
        let mut problems = Vec::new();
        let mut cases = Vec::new();
        for (p, problem) in PROBLEMS.into_iter().enumerate() {
            problems.push((problem, Reference::stored(&problem)?));
            for (c, compute) in computes.iter().enumerate() {
                for case in size.cases(&problem) {
                    if case.suits(&problem, compute)? {
                        cases.push((p, case, c));
                    }
                }
            }
        }
        Ok(Study { size, computes, problems, cases, rows: Vec::new() })
    }

    /// The extent of the measurements.
    pub fn size(&self) -> &Size {
        &self.size
    }

    /// The scenes, and the references for their ends.
    pub fn problems(&self) -> &[(Problem, Reference)] {
        &self.problems
    }

    /// The table.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    fn of<'a>(&'a self, problem: &Problem) -> Vec<&'a Row> {
        self.rows.iter().filter(|row| row.problem == problem.name).collect()
    }

    /// The cheapest ways to errors, for each scene.
    pub fn best(&self) -> Vec<Best> {
        let of = |(problem, reference): &(Problem, Reference)| best(problem.name, reference, &self.of(problem));
        self.problems.iter().flat_map(of).collect()
    }

    /// What it is to show, and whether it does.
    pub fn targets(&self) -> Vec<Target> {
        page::targets(self)
    }

    /// Adds a row, with the order at which the error fell from the row before on its curve.
    fn push(&mut self, mut row: Row) {
        let alike = |before: &&Row| before.problem == row.problem && before.computed_by == row.computed_by;
        let before =
            self.rows.last().filter(alike).filter(|before| before.curve == row.curve && row.sweep != Sweep::Tolerance);
        row.order = before.and_then(|before| order([before.dt, row.dt], [before.error?, row.error?]));
        self.rows.push(row);
    }
}

impl Measured for Study {
    fn name(&self) -> &'static str {
        "work-precision"
    }

    fn next_run(&mut self) -> Result<Option<String>, StudyError> {
        let Some((p, case, c)) = self.cases.get(self.rows.len()).copied() else { return Ok(None) };
        let (problem, reference) = &self.problems[p];
        let row = run(problem, reference, &case, &self.computes[c])?;
        let error = row.error.map_or("other bodies than the reference's".into(), |error| format!("error {error:.1e}"));
        let said = format!(
            "{}: {}, {} steps, tolerance {:.0e}: {error} in {:.0} ms",
            row.problem,
            row.curve,
            row.steps,
            row.overlap_tolerance,
            1e3 * row.wall_seconds
        );
        self.push(row);
        Ok(Some(said))
    }

    fn missed(&self) -> bool {
        self.rows.iter().any(Row::missed)
    }

    fn page(&self) -> String {
        page::page(self)
    }

    fn numbers(&self) -> Result<Value, StudyError> {
        let value = |of: Result<Value, serde_json::Error>| of.map_err(|fault| StudyError::Table(fault.to_string()));
        let about = |(problem, reference): &(Problem, Reference)| {
            let Reference { hash, length, made, estimate, .. } = reference;
            json!({
                "problem": problem.name, "scene": problem.scene, "sets": problem.sets, "end": problem.end,
                "reference": { "hash": hash, "length": length, "made": made, "estimate": estimate },
            })
        };
        Ok(json!({
            "size": value(serde_json::to_value(self.size))?,
            "problems": self.problems.iter().map(about).collect::<Vec<Value>>(),
            "rows": value(serde_json::to_value(&self.rows))?,
            "best": value(serde_json::to_value(self.best()))?,
            "targets": value(serde_json::to_value(self.targets()))?,
        }))
    }

    fn files(&self) -> Result<Vec<(String, Vec<u8>)>, StudyError> {
        Ok(vec![("work-precision.csv".into(), csv_table(self.rows.iter())?)])
    }

    fn plots(&self) -> Result<Vec<(&'static str, Figure)>, StudyError> {
        let plot = |(problem, reference): &(Problem, Reference)| {
            Ok((problem.plot, plot::plot(problem, reference, &self.of(problem))?))
        };
        self.problems.iter().map(plot).collect()
    }
}

#[cfg(test)]
mod tests;
