//! One cell that grows into a colony, by ReLCP and by rows of sub-spheres (LCP-MS): rows, time, and the alignment of
//! cells; the paper's Table 3 and Figure 5.
//!
//! All cells divide in the same step, and the daughters exactly fill their parents: the colony is measured after each
//! of these steps, which end a generation. Rows and times are averages over windows of steps, and their statistics are
//! over windows.

mod morphology;
mod page;
mod plot;
mod rows;

pub use morphology::{Generation, Morphology};
pub use rows::{ByGeneration, Row, Spread};

use super::columns::measure_columns;
use super::measured::value;
use super::{COMPUTED_BY, Census, Measured, RunSummary, Target, follow_with};
use crate::StudyError;
use crate::table::csv_table;
use relcp::figure::Figure;
use relcp::internals::render::png;
use relcp::internals::scene::thinnest;
use relcp::render::{View, picture};
use relcp::scene::{Method, Rows, Scene};
use relcp::step::Fault;
use serde::Serialize;
use serde_json::{Value, json};
use std::f64::consts::LN_2;

/// Steps of a window. The paper's averages are over 100.
const WIDTH: u64 = 50;

/// Steps from one count of near pairs to the next: three or four in a generation.
const COUNTED_EVERY: u64 = 200;

/// The step, the built-in scene's.
const DT: f64 = 1e-3;

/// Rows are made of pairs within this part of a cell's diameter. The paper does not give its distance; of those up to
/// this one it is the one that has most nearly as many rows of sub-spheres over those of surfaces as the paper (the
/// table of rows by distance on the page).
pub(super) const CUTOFF_PER_THICKNESS: f64 = 2.5;

/// Steps after the last division: the last generation is measured, but does not grow further.
const AFTER: f64 = 10.0;

/// Pixels of a picture's sides.
const PICTURE: u32 = 900;

/// The sub-spheres whose colony the paper shows beside ReLCP's.
pub(super) const SHOWN: u32 = 7;

/// Runs by one method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Runs {
    /// Sub-spheres of a cell; none by ReLCP.
    pub spheres: Option<u32>,
    /// Generations after the founder: two to this power are the cells at the end.
    pub generations: u32,
    /// How many, from seed 1 on.
    pub seeds: u64,
}

const fn runs(spheres: Option<u32>, generations: u32, seeds: u64) -> Runs {
    Runs { spheres, generations, seeds }
}

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// The runs; those by ReLCP come first, as the others are compared with it.
    pub runs: &'static [Runs],
}

impl Size {
    /// 1,024 cells, with sub-spheres fewer: an hour or two.
    pub const FULL: Size = Size {
        runs: &[
            runs(None, 10, 3),
            runs(Some(5), 9, 1),
            runs(Some(SHOWN), 9, 3),
            runs(Some(17), 7, 1),
            runs(Some(27), 6, 1),
        ],
    };
    /// 128 cells, with sub-spheres fewer: under a minute.
    pub const QUICK: Size = Size {
        runs: &[
            runs(None, 7, 2),
            runs(Some(5), 6, 1),
            runs(Some(SHOWN), 6, 2),
            runs(Some(17), 4, 1),
            runs(Some(27), 3, 1),
        ],
    };

    /// All runs, in the order in which they are made.
    pub fn cases(&self) -> Vec<Case> {
        let of = |Runs { spheres, generations, seeds }: &Runs| {
            let (method, generations) =
                (spheres.map_or(Method::Relcp, |count| Method::Multisphere { count }), *generations);
            (1..=*seeds).map(move |seed| Case { method, generations, seed }).collect::<Vec<Case>>()
        };
        self.runs.iter().flat_map(of).collect()
    }
}

/// A planned run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Case {
    /// The contact method.
    pub method: Method,
    /// Generations after the founder.
    pub generations: u32,
    /// The seed of the daughters' turns.
    pub seed: u64,
}

impl Case {
    fn scene(&self) -> Result<Scene, StudyError> {
        let end = DT * ((f64::from(self.generations) * LN_2 / DT).ceil() + AFTER);
        let sets = [format!("time.dt={DT}"), format!("time.end={end}"), format!("seed={}", self.seed)];
        let mut scene = Scene::load("colony", &sets)?;
        scene.contact.method = self.method;
        scene.contact.rows = Rows::Paper;
        scene.contact.cutoff = Some(CUTOFF_PER_THICKNESS * thinnest(&scene));
        Ok(scene)
    }
}

/// A run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// The plan of the run.
    pub case: Case,
    /// The summary of its steps.
    #[serde(rename = "course")]
    pub summary: RunSummary,
    /// The alignment of the cells after each division.
    pub generations: Vec<Generation>,
    /// The colony at the end, as PNG.
    #[serde(skip)]
    picture: Vec<u8>,
}

impl Run {
    fn picture_name(&self) -> String {
        format!("colony-{}.png", self.summary.method.to_lowercase().replace(' ', "-"))
    }
}

/// The results so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    size: Size,
    runs: Vec<Run>,
    /// Of ReLCP's first run.
    census: Census,
}

impl Study {
    /// Nothing yet.
    pub fn begin(size: Size) -> Self {
        Study { size, runs: Vec::new(), census: Census::default() }
    }

    /// The extent of the measurements.
    pub fn size(&self) -> &Size {
        &self.size
    }

    /// The runs so far.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Rows and times by method.
    pub fn rows(&self) -> Vec<Row> {
        rows::rows(&self.runs)
    }

    /// Rows and times by method and generation.
    pub fn by_generation(&self) -> Vec<ByGeneration> {
        rows::by_generation(&self.runs)
    }

    /// How cells are aligned, by ReLCP and with the sub-spheres that the paper shows, after each division that both
    /// have.
    pub fn morphology(&self) -> Vec<Morphology> {
        morphology::morphology(&self.runs)
    }

    /// Returns its targets, and whether it reaches them.
    pub fn targets(&self) -> Vec<Target> {
        page::targets(self)
    }

    /// Separations of ReLCP's first colony over its last whole generation.
    pub fn census(&self) -> &Census {
        &self.census
    }

    /// The first run of each method.
    fn first_runs(&self) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(|run| run.case.seed == 1)
    }
}

impl Measured for Study {
    fn name(&self) -> &'static str {
        "colony"
    }

    fn next_run(&mut self) -> Result<Option<String>, StudyError> {
        let Some(case) = self.size.cases().get(self.runs.len()).copied() else { return Ok(None) };
        let run = make(case, &mut self.census)?;
        let RunSummary { method, bodies, milliseconds, max_overlap, .. } = &run.summary;
        let said = format!(
            "{method}, seed {}: {bodies} cells in {:.1} s, overlap {max_overlap:.1e} at most",
            case.seed,
            1e-3 * milliseconds
        );
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
            "rows": value(&self.rows())?,
            "by_generation": value(&self.by_generation())?,
            "morphology": value(&self.morphology())?,
            "near_rows": value(&self.census.counts(&page::PAPER_ROWS))?,
            "runs": value(&self.runs)?,
            "targets": value(&self.targets())?,
        }))
    }

    fn files(&self) -> Result<Vec<(String, Vec<u8>)>, StudyError> {
        let (rows, generations, morphology) = (self.rows(), self.by_generation(), self.morphology());
        let steps = self.first_runs().flat_map(|run| &run.summary.windows);
        let mut files = vec![
            ("colony.csv".into(), csv_table(rows.iter())?),
            ("colony-generations.csv".into(), csv_table(generations.iter())?),
            ("colony-morphology.csv".into(), csv_table(morphology.iter())?),
            ("colony-steps.csv".into(), csv_table(steps)?),
            ("colony-near-rows.csv".into(), csv_table(self.census.counts(&page::PAPER_ROWS).iter())?),
        ];
        files.extend(self.first_runs().map(|run| (run.picture_name(), run.picture.clone())));
        Ok(files)
    }

    fn plots(&self) -> Result<Vec<(&'static str, Figure)>, StudyError> {
        Ok(vec![("colony", plot::plot(self)?)])
    }
}

fn make(case: Case, census: &mut Census) -> Result<Run, StudyError> {
    let scene = case.scene()?;
    let mut generations: Vec<Generation> = Vec::new();
    let mut before = 1;
    let counted = (case.method, case.seed) == (Method::Relcp, 1);
    let (summary, simulation) = follow_with(scene, None, WIDTH, |simulation, _| {
        let last = 2 * simulation.bodies() == 1 << case.generations;
        if counted && last && simulation.steps().is_multiple_of(COUNTED_EVERY) {
            census
                .add(&simulation.state()?.bodies, &page::PAPER_ROWS.map(|(count, _)| count))
                .map_err(Fault::NoProxy)?;
        }
        if simulation.bodies() > before {
            before = simulation.bodies();
            let found = measure_columns(simulation, morphology::COLUMNS)?;
            generations.push(Generation::new(simulation, found));
        }
        Ok(())
    })?;
    let view = View { width: PICTURE, height: PICTURE, planar: true, ..View::default() };
    let drawn = png(&picture(&simulation.state()?.bodies, &view));
    let picture = drawn.map_err(|fault| StudyError::Plot(fault.to_string()))?;
    Ok(Run { case, summary, generations, picture })
}

#[cfg(test)]
mod tests;
