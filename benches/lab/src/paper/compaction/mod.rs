//! A suspension of ellipsoids that is drawn into a dense ball, by ReLCP and by rows of sub-spheres (LCP-MS): rows and
//! time, the paper's Table 2 and Figure 4.
//!
//! With few sub-spheres, runs are complete. With many, and also with few for comparison, a short run begins at the
//! dense state that ReLCP reached. In its first half, the sub-spheres come into contact; the second half is measured.
//! Short runs use the default solver and the solver of public codes.

mod page;
mod plot;
mod targets;

use super::columns::measure_columns;
use super::measured::value;
use super::{COMPUTED_BY, Census, Measured, RunSummary, Target, Window, follow};
use crate::StudyError;
use crate::table::csv_table;
use relcp::figure::Figure;
use relcp::internals::scene::thinnest;
use relcp::scene::{Method, Rows, Scene, SolverKind};
use relcp::step::{Fault, State};
use serde::Serialize;
use serde_json::{Value, json};

/// The solver that public codes for contacts of rigid bodies solve their LCPs with: what measurements set the default
/// beside.
const OF_PUBLIC_CODES: SolverKind = SolverKind::Bbpgd;

/// Most lines of a whole run's course over time. With the full size these are windows of 60 and 600 steps; the paper's
/// averages are over 100.
const WINDOWS: u64 = 100;

/// Rows are made of pairs within this part of a body's thickness. The paper does not give its distance; this one has as
/// many rows of sub-spheres over those of surfaces as the paper, within 8 % for 7, 13, 17 and 23 of them (the table of
/// rows by distance on the page).
pub(super) const CUTOFF_PER_THICKNESS: f64 = 0.2;

/// The extent of the measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Ellipsoids.
    pub bodies: u64,
    /// Their volume fraction at the start.
    pub volume_fraction: f64,
    /// The end of whole runs.
    pub end: f64,
    /// Steps, each with the numbers of sub-spheres that whole runs are made with.
    pub steps: &'static [(f64, &'static [u32])],
    /// The numbers of sub-spheres in short runs from the dense state.
    pub dense: &'static [u32],
    /// Those of them that are made by the solver of public codes as well.
    pub public: &'static [u32],
    /// How long these are.
    pub dense_time: f64,
}

impl Size {
    /// The built-in scene `compaction`, a tenth of the paper's bodies: some hours.
    pub const FULL: Size = Size {
        bodies: 1000,
        volume_fraction: 0.0025,
        end: 600.0,
        steps: &[(0.1, &[3]), (0.01, &[3])],
        dense: &[3, 7, 13, 17, 23],
        // With 13, one step of the ten took five minutes.
        public: &[7],
        dense_time: 1.0,
    };
    /// Few bodies, which begin closer: under a minute.
    pub const QUICK: Size = Size {
        bodies: 50,
        volume_fraction: 0.05,
        end: 80.0,
        steps: &[(0.1, &[3, 7]), (0.01, &[3])],
        dense: &[3, 7, 13],
        public: &[7, 13],
        dense_time: 1.0,
    };

    /// All runs, in the order in which they are made: ReLCP first of each step and part, as the others are compared
    /// with it.
    pub fn cases(&self) -> Vec<Case> {
        let of = |dt: f64, part: Part, counts: &[u32]| -> Vec<Case> {
            let spheres = counts.iter().map(|count| Method::Multisphere { count: *count });
            std::iter::once(Method::Relcp).chain(spheres).map(|method| Case { dt, part, method }).collect()
        };
        self.steps
            .iter()
            .flat_map(|(dt, whole)| {
                [of(*dt, Part::Whole, whole), of(*dt, Part::Dense, self.dense), of(*dt, Part::Public, self.public)]
            })
            .flatten()
            .collect()
    }

    fn scene(&self, case: &Case) -> Result<Scene, StudyError> {
        let end = if case.part == Part::Whole { self.end } else { self.end + self.dense_time };
        let sets = [
            format!("time.dt={}", case.dt),
            format!("time.end={end}"),
            format!("generate.0.isotropic.count={}", self.bodies),
            format!("generate.0.isotropic.volume_fraction={}", self.volume_fraction),
        ];
        let mut scene = Scene::load("compaction", &sets)?;
        scene.contact.method = case.method;
        scene.contact.rows = Rows::Paper;
        scene.contact.cutoff = Some(CUTOFF_PER_THICKNESS * thinnest(&scene));
        if case.part == Part::Public {
            scene.solver.kind = OF_PUBLIC_CODES;
        }
        Ok(scene)
    }
}

/// Which part of the compaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// All of it.
    Whole,
    /// Some steps from the dense state that ReLCP came to.
    Dense,
    /// The same steps by the solver of public codes.
    Public,
}

/// A planned run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Case {
    /// The step.
    pub dt: f64,
    /// Which part.
    pub part: Part,
    /// The contact method.
    pub method: Method,
}

/// A run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// The plan of the run.
    pub case: Case,
    /// The summary of its steps.
    #[serde(rename = "course")]
    pub summary: RunSummary,
    /// The radius of gyration of the centres at the end.
    pub gyration: Option<f64>,
}

/// A line of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Which part.
    pub part: Part,
    /// The step.
    pub dt: f64,
    /// The contact method.
    pub method: String,
    /// Sub-spheres of a body.
    pub spheres: Option<u32>,
    /// Steps taken.
    pub steps: u64,
    /// Rows of a step, on average of the last window.
    pub constraints: f64,
    /// Milliseconds of a step, on average of the last window.
    pub milliseconds: f64,
    /// Rows over those of ReLCP.
    pub relative_constraints: Option<f64>,
    /// Milliseconds over those of ReLCP.
    pub relative_time: Option<f64>,
    /// Milliseconds of all steps over those of ReLCP.
    pub relative_time_of_all: Option<f64>,
    /// Products of a step.
    pub products: f64,
    /// Recursions of all steps.
    pub recursions: u64,
    /// The largest overlap of smooth surfaces.
    pub max_overlap: f64,
    /// The largest overlap of sub-spheres.
    pub proxy_overlap: Option<f64>,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u64,
    /// The radius of gyration at the end.
    pub gyration: Option<f64>,
}

/// The results so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    size: Size,
    runs: Vec<Run>,
    /// The dense state of the step that is being measured.
    dense: Option<State>,
    /// Of the dense state of the first step.
    census: Census,
}

impl Study {
    /// Nothing yet.
    pub fn begin(size: Size) -> Self {
        Study { size, runs: Vec::new(), dense: None, census: Census::default() }
    }

    /// The extent of the measurements.
    pub fn size(&self) -> &Size {
        &self.size
    }

    /// The runs so far.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The table.
    pub fn rows(&self) -> Vec<Row> {
        self.runs.iter().map(|run| self.row(run)).collect()
    }

    /// The run of ReLCP that another is compared with, by the default solver.
    fn relcp(&self, case: &Case) -> Option<&Run> {
        let part = if case.part == Part::Whole { Part::Whole } else { Part::Dense };
        self.runs.iter().find(|run| run.case == Case { method: Method::Relcp, part, ..*case })
    }

    fn row(&self, run: &Run) -> Row {
        let Run { case, summary, gyration } = run;
        let last = summary.windows.last();
        let relcp = self.relcp(case).map(|run| &run.summary);
        let relative = |of: fn(&Window) -> f64| {
            let (own, other) = relcp.and_then(|relcp| summary.beside(relcp).last())?;
            Some(of(own) / of(other)).filter(|ratio| ratio.is_finite())
        };
        Row {
            part: case.part,
            dt: case.dt,
            method: summary.method.clone(),
            spheres: summary.spheres,
            steps: summary.steps,
            constraints: last.map_or(0.0, |window| window.constraints),
            milliseconds: last.map_or(0.0, |window| window.milliseconds),
            relative_constraints: relative(|window| window.constraints),
            relative_time: relative(|window| window.milliseconds),
            relative_time_of_all: relcp.map(|relcp| summary.milliseconds / relcp.milliseconds),
            products: summary.products as f64 / summary.steps.max(1) as f64,
            recursions: summary.recursions,
            max_overlap: summary.max_overlap,
            proxy_overlap: summary.proxy_overlap,
            unconverged: summary.unconverged,
            gyration: *gyration,
        }
    }

    /// Returns its targets, and whether it reaches them.
    pub fn targets(&self) -> Vec<Target> {
        targets::targets(&self.rows(), &self.runs, &self.census)
    }

    fn make(&mut self, case: Case) -> Result<Run, StudyError> {
        let scene = self.size.scene(&case)?;
        let (from, width) = match case.part {
            Part::Whole => (None, scene.time.steps().div_ceil(WINDOWS)),
            Part::Dense | Part::Public => {
                (self.dense.clone(), ((0.5 * self.size.dense_time / case.dt).round() as u64).max(1))
            }
        };
        let (summary, simulation) = follow(scene, from, width)?;
        let [gyration] = measure_columns(&simulation, ["radius_gyration"])?;
        if (case.part, case.method) == (Part::Whole, Method::Relcp) {
            // The stored multipliers of one method do not help another, so all methods start without them.
            if self.dense.is_none() {
                let counts = page::PAPER_ROWS.map(|(count, _)| count);
                self.census.add(&simulation.state()?.bodies, &counts).map_err(Fault::NoProxy)?;
            }
            self.dense = Some(State { warm: Vec::new(), ..simulation.state()?.clone() });
        }
        Ok(Run { case, summary, gyration })
    }
}

impl Measured for Study {
    fn name(&self) -> &'static str {
        "compaction"
    }

    fn next_run(&mut self) -> Result<Option<String>, StudyError> {
        let Some(case) = self.size.cases().get(self.runs.len()).copied() else { return Ok(None) };
        let run = self.make(case)?;
        let row = self.row(&run);
        let part = match case.part {
            Part::Whole => "",
            Part::Dense => " from the dense state",
            Part::Public => " from the dense state, by the solver of public codes",
        };
        let said = format!(
            "{}, dt {}{part}: {:.0} rows, {:.2} ms a step at the end",
            row.method, row.dt, row.constraints, row.milliseconds
        );
        self.runs.push(run);
        Ok(Some(said))
    }

    fn missed(&self) -> bool {
        self.runs.iter().any(|run| run.case.part != Part::Public && run.summary.missed())
    }

    fn page(&self) -> String {
        page::page(self)
    }

    fn numbers(&self) -> Result<Value, StudyError> {
        Ok(json!({
            "computed_by": COMPUTED_BY,
            "size": value(&self.size)?,
            "rows": value(&self.rows())?,
            "near_rows": value(&self.census.counts(&page::PAPER_ROWS))?,
            "runs": value(&self.runs)?,
            "targets": value(&self.targets())?,
        }))
    }

    fn files(&self) -> Result<Vec<(String, Vec<u8>)>, StudyError> {
        let rows = self.rows();
        let whole = self.runs.iter().filter(|run| run.case.part == Part::Whole);
        let steps = whole.flat_map(|run| &run.summary.windows);
        Ok(vec![
            ("compaction.csv".into(), csv_table(rows.iter())?),
            ("compaction-steps.csv".into(), csv_table(steps)?),
            ("compaction-near-rows.csv".into(), csv_table(self.census.counts(&page::PAPER_ROWS).iter())?),
        ])
    }

    fn plots(&self) -> Result<Vec<(&'static str, Figure)>, StudyError> {
        Ok(vec![("compaction", plot::plot(self)?)])
    }
}

#[cfg(test)]
mod tests;
