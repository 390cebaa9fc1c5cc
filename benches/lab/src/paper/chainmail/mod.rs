//! A sheet of interlaced rings that is stretched, by ReLCP, by 32 sub-spheres a ring (LCP-MS) and without recursion
//! (LCP-SNSD): the largest violation over time, the paper's Figure 6.
//!
//! Two overlaps of sub-spheres are reported: between the smooth rings, and between the spheres themselves, which the
//! method constrains.

mod page;
mod plot;

use super::measured::value;
use super::{COMPUTED_BY, Measured, RunSummary, Target, Window, follow_with};
use crate::StudyError;
use crate::table::csv_table;
use glam::DQuat;
use relcp::bodies::Bodies;
use relcp::figure::Figure;
use relcp::scene::{Method, Rows, Scene};
use relcp::step::State;
use serde::Serialize;
use serde_json::{Value, json};

/// Most lines of a run's course over time.
const WINDOWS: u64 = 200;

/// Sub-spheres of a ring: the least number without gaps for the paper's rings.
pub(super) const SPHERES: u32 = 32;

/// The methods, in the order in which they are run.
pub(super) const METHODS: [Method; 3] = [Method::Relcp, Method::Snsd, Method::Multisphere { count: SPHERES }];

/// Radii of a ring's centreline and of its tube.
pub(super) const MAJOR_RADIUS: f64 = 1.0;
pub(super) const MINOR_RADIUS: f64 = 0.1;

/// Each ring is turned about its own axis by this more than the one before, the golden angle. A smooth ring does not
/// feel it; without it all rings' spheres would lie alike, and those of two linked rings meet as the sheet's symmetry
/// has it.
const TURN: f64 = 2.399_963_229_728_653;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Rings along an edge of the sheet.
    pub side: u32,
    /// The step.
    pub dt: f64,
    /// The end.
    pub end: f64,
    /// The drag, which decides how far a step goes. With 0.2 the largest sheet is, without recursion, about as far
    /// beyond its minor radius as the paper's; with 1 it comes to a fifth of it.
    pub drag: f64,
}

impl Size {
    /// A sheet four times as large as the built-in one, until it is taut and beyond: a minute or two.
    pub const FULL: Size = Size { side: 12, dt: 1e-3, end: 4.0, drag: 0.2 };
    /// A small sheet, until it is taut: some seconds.
    pub const QUICK: Size = Size { side: 8, dt: 1e-3, end: 0.8, drag: 0.13 };

    fn scene(&self, method: Method) -> Result<Scene, StudyError> {
        let Size { side, dt, end, drag } = self;
        let sets = [
            format!("time.dt={dt}"),
            format!("time.end={end}"),
            format!("dynamics.overdamped.drag={drag}"),
            format!("generate.0.chainmail.columns={side}"),
            format!("generate.0.chainmail.rows={side}"),
            format!("generate.0.chainmail.major_radius={MAJOR_RADIUS}"),
            format!("generate.0.chainmail.minor_radius={MINOR_RADIUS}"),
        ];
        let mut scene = Scene::load("chainmail", &sets)?;
        scene.contact.method = method;
        scene.contact.rows = Rows::Paper;
        Ok(scene)
    }
}

/// How far the sheet reaches along each axis: the root mean square of the rings' centres.
pub type Extent = [f64; 3];

/// A run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Run {
    /// The summary of its steps.
    #[serde(rename = "course")]
    pub summary: RunSummary,
    /// The sheet at the start.
    pub first: Extent,
    /// The sheet at the end.
    pub last: Extent,
    /// The sheet at the end of each window.
    #[serde(skip)]
    pub extents: Vec<Extent>,
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

    /// What it is to show, and whether it does.
    pub fn targets(&self) -> Vec<Target> {
        page::targets(&self.runs)
    }
}

impl Measured for Study {
    fn name(&self) -> &'static str {
        "chainmail"
    }

    fn next_run(&mut self) -> Result<Option<String>, StudyError> {
        let Some(method) = METHODS.get(self.runs.len()) else { return Ok(None) };
        let run = run(self.size.scene(*method)?)?;
        let RunSummary { method, steps, max_overlap, steps_over, .. } = &run.summary;
        let said = format!("{method}: overlap {max_overlap:.1e} at most, too much after {steps_over} of {steps} steps");
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
            "targets": value(&self.targets())?,
        }))
    }

    fn files(&self) -> Result<Vec<(String, Vec<u8>)>, StudyError> {
        let lines = self.runs.iter().flat_map(|run| run.summary.windows.iter().zip(&run.extents).map(Line::new));
        let lines: Vec<Line> = lines.collect();
        Ok(vec![
            ("chainmail.csv".into(), csv_table(self.runs.iter().map(|run| &run.summary))?),
            ("chainmail-steps.csv".into(), csv_table(lines.iter())?),
        ])
    }

    fn plots(&self) -> Result<Vec<(&'static str, Figure)>, StudyError> {
        Ok(vec![("chainmail", plot::plot(self)?)])
    }
}

fn run(scene: Scene) -> Result<Run, StudyError> {
    let width = scene.time.steps().div_ceil(WINDOWS).max(1);
    let mut bodies = scene.build()?;
    for (i, orientation) in bodies.orientation.iter_mut().enumerate() {
        *orientation *= DQuat::from_rotation_z(TURN * i as f64);
    }
    let first = extent(&bodies);
    let state = State { next_id: bodies.len() as u64, bodies, ..State::default() };
    let mut extents: Vec<Extent> = Vec::new();
    let (summary, simulation) = follow_with(scene, Some(state), width, |simulation, window| {
        extents.resize(window + 1, first);
        if let (Some(last), true) = (extents.last_mut(), simulation.done() || simulation.steps().is_multiple_of(width))
        {
            *last = extent(&simulation.state()?.bodies);
        }
        Ok(())
    })?;
    let last = extent(&simulation.state()?.bodies);
    Ok(Run { summary, first, last, extents })
}

fn extent(bodies: &Bodies) -> Extent {
    let count = bodies.len().max(1) as f64;
    let mean = bodies.position.iter().sum::<glam::DVec3>() / count;
    let square = bodies.position.iter().map(|x| (x - mean) * (x - mean)).sum::<glam::DVec3>() / count;
    square.to_array().map(f64::sqrt)
}

/// A line of the table over time.
#[derive(Serialize)]
struct Line<'a> {
    method: &'a str,
    step: u64,
    time: f64,
    max_overlap: f64,
    proxy_overlap: Option<f64>,
    constraints: f64,
    recursions: f64,
    milliseconds: f64,
    extent_x: f64,
    extent_y: f64,
    extent_z: f64,
}

impl<'a> Line<'a> {
    fn new((window, [extent_x, extent_y, extent_z]): (&'a Window, &Extent)) -> Self {
        Line {
            method: &window.method,
            step: window.step,
            time: window.time,
            max_overlap: window.max_overlap,
            proxy_overlap: window.proxy_overlap,
            constraints: window.constraints,
            recursions: window.recursions,
            milliseconds: window.milliseconds,
            extent_x: *extent_x,
            extent_y: *extent_y,
            extent_z: *extent_z,
        }
    }
}

#[cfg(test)]
mod tests;
