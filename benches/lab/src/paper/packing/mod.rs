//! Spherocylinders drawn into a ball: time of a step and true overlap by step size, compared with public engines. This
//! study is not in the paper.
//!
//! The engines' figures are those of `benches/peers/run`; none is a dependency, and none is run here.

mod engines;
mod lattice;
mod page;
mod plot;

pub use engines::{Engine, engines};
pub use lattice::scene;

use super::columns::measure_columns;
use super::measured::value;
use super::{COMPUTED_BY, Measured, RunSummary, Target, follow};
use crate::StudyError;
use crate::table::csv_table;
use relcp::figure::Figure;
use serde::Serialize;
use serde_json::{Value, json};

/// Most lines of a run's course over time.
const WINDOWS: u64 = 150;

/// The extent of the measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Rods along an edge of the lattice.
    pub sides: &'static [u32],
    /// Steps, from coarse to fine.
    pub steps: &'static [f64],
}

impl Size {
    /// 1,000 and 8,000 rods: most of an hour.
    pub const FULL: Size = Size { sides: &[10, 20], steps: &[0.1, 0.02, 0.005] };
    /// 216 rods: some seconds.
    pub const QUICK: Size = Size { sides: &[6], steps: &[0.1, 0.02] };

    fn cases(&self) -> impl Iterator<Item = (u32, f64)> + use<> {
        let steps = self.steps;
        self.sides.iter().flat_map(move |side| steps.iter().map(move |dt| (*side, *dt)))
    }
}

/// A run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// The summary of its steps.
    #[serde(rename = "course")]
    pub summary: RunSummary,
    /// The radius of gyration of the centres at the end.
    pub gyration: Option<f64>,
}

/// The results so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    size: Size,
    runs: Vec<Run>,
    engines: Vec<Engine>,
}

impl Study {
    /// Begins without runs; reads the measurements of engines.
    ///
    /// # Errors
    /// [`StudyError::Damaged`] if that is no table.
    pub fn begin(size: Size) -> Result<Self, StudyError> {
        Ok(Study { size, runs: Vec::new(), engines: engines()? })
    }

    /// Returns the measurements of engines with 1,000 rods, and of this program in the same call.
    pub fn engines(&self) -> &[Engine] {
        &self.engines
    }

    /// The extent of the measurements.
    pub fn size(&self) -> &Size {
        &self.size
    }

    /// The runs so far.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Returns its targets, and whether it reaches them.
    pub fn targets(&self) -> Vec<Target> {
        page::targets(&self.runs, &self.engines)
    }

    fn rows(&self) -> impl Iterator<Item = Row> {
        self.runs.iter().map(|Run { summary, gyration }| Row {
            bodies: summary.bodies,
            dt: summary.dt,
            steps: summary.steps,
            cpu_milliseconds_a_step: summary.step_milliseconds(),
            wall_milliseconds_a_step: summary.wall_milliseconds / summary.steps.max(1) as f64,
            max_overlap: summary.max_overlap,
            last_overlap: summary.last_overlap,
            gyration: *gyration,
            recursions: summary.recursions,
            products: summary.products,
            constraints: summary.constraints,
            last_constraints: summary.last_constraints,
        })
    }
}

impl Measured for Study {
    fn name(&self) -> &'static str {
        "packing"
    }

    fn next_run(&mut self) -> Result<Option<String>, StudyError> {
        let Some((side, dt)) = self.size.cases().nth(self.runs.len()) else { return Ok(None) };
        let run = run(side, dt)?;
        let RunSummary { bodies, max_overlap, .. } = run.summary;
        let milliseconds = run.summary.step_milliseconds();
        let said = format!("{bodies} rods, dt {dt}: {milliseconds:.2} ms a step, overlap {max_overlap:.1e} at most");
        self.runs.push(run);
        Ok(Some(said))
    }

    fn missed(&self) -> bool {
        self.runs.iter().any(|run| run.summary.missed())
    }

    fn page(&self) -> String {
        page::page(self)
    }

    fn numbers(&self) -> Result<Value, StudyError> {
        Ok(json!({
            "computed_by": COMPUTED_BY,
            "size": value(&self.size)?,
            "runs": value(&self.runs)?,
            "engines": value(&self.engines)?,
            "targets": value(&self.targets())?,
        }))
    }

    /// The scenes too, so that an engine can be given them.
    fn files(&self) -> Result<Vec<(String, Vec<u8>)>, StudyError> {
        let rows: Vec<Row> = self.rows().collect();
        let steps = self.runs.iter().flat_map(|run| &run.summary.windows);
        let mut files =
            vec![("packing.csv".into(), csv_table(rows.iter())?), ("packing-steps.csv".into(), csv_table(steps)?)];
        for side in self.size.sides {
            let scene = scene(*side, self.size.steps.last().copied().unwrap_or(1.0))?;
            files.push((format!("{}-scene.json", scene.name), value(&scene)?.to_string().into_bytes()));
        }
        Ok(files)
    }

    fn plots(&self) -> Result<Vec<(&'static str, Figure)>, StudyError> {
        Ok(vec![("packing", plot::plot(self)?)])
    }
}

fn run(side: u32, dt: f64) -> Result<Run, StudyError> {
    let scene = scene(side, dt)?;
    let width = scene.time.steps().div_ceil(WINDOWS);
    let (summary, simulation) = follow(scene, None, width)?;
    let [gyration] = measure_columns(&simulation, ["radius_gyration"])?;
    Ok(Run { summary, gyration })
}

/// A line of the table.
#[derive(Serialize)]
struct Row {
    bodies: usize,
    dt: f64,
    steps: u64,
    cpu_milliseconds_a_step: f64,
    wall_milliseconds_a_step: f64,
    max_overlap: f64,
    last_overlap: f64,
    gyration: Option<f64>,
    recursions: u64,
    products: u64,
    constraints: f64,
    last_constraints: usize,
}

#[cfg(test)]
mod tests;
