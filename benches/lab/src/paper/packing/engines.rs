//! Public engines and this program with the same rods, as measured by `benches/peers/run`. The values are read from its
//! output.

use crate::StudyError;
use serde::{Deserialize, Serialize};

/// The measured lines, one a run.
const MEASURED: &str = include_str!("../../../../results/peers/packing.jsonl");

/// The scene of 1,000 rods, in those lines.
const SCENE: &str = "rods-1000";

/// How many rods it has.
pub(super) const RODS: usize = 1000;

/// This program, in those lines.
const OURS: &str = "relcp";

/// A radius of gyration with a larger relative difference from ours belongs to another problem.
pub(super) const GYRATION_WITHIN: f64 = 0.01;

/// A run of an engine, or of this program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Engine {
    scene: String,
    /// The program.
    pub engine: String,
    /// Its version.
    pub version: Option<String>,
    /// The name of its settings.
    pub settings_name: String,
    /// The step.
    pub dt: f64,
    /// Steps taken.
    pub steps: Option<u64>,
    /// The processor's seconds, on one core.
    pub cpu_s: Option<f64>,
    /// The largest true overlap that the checker found, a length.
    pub max_overlap: Option<f64>,
    /// The radius of gyration at the end.
    pub gyration: Option<f64>,
    /// The reason why it did not reach the end.
    pub ended: Option<String>,
    /// The day.
    pub date: String,
    /// The machine.
    pub machine: String,
}

impl Engine {
    /// Its program, version and settings.
    pub fn name(&self) -> String {
        format!("{} {}, {}", self.engine, self.version.as_deref().unwrap_or(""), self.settings_name)
    }

    /// Whether it is this program.
    pub fn is_ours(&self) -> bool {
        self.engine == OURS
    }

    /// Milliseconds of a step and the largest overlap, of a run that came to the end.
    pub fn cost(&self) -> Option<(f64, f64)> {
        let done = self.ended.is_none();
        done.then(|| Some((1e3 * self.cpu_s? / self.steps? as f64, self.max_overlap?))).flatten()
    }
}

/// All runs of 1,000 rods.
///
/// # Errors
/// [`StudyError::Damaged`] if the lines are no results.
pub fn engines() -> Result<Vec<Engine>, StudyError> {
    let damaged = |fault: serde_json::Error| StudyError::Damaged(format!("packing.jsonl of the engines: {fault}"));
    let lines = MEASURED.lines().map(serde_json::from_str);
    let all = lines.collect::<Result<Vec<Engine>, _>>().map_err(damaged)?;
    Ok(all.into_iter().filter(|run| run.scene == SCENE).collect())
}

/// The radius of gyration that our finest run had.
pub(super) fn gyration(engines: &[Engine]) -> Option<f64> {
    let ours = engines.iter().filter(|run| run.is_ours() && run.cost().is_some());
    ours.min_by(|a, b| a.dt.total_cmp(&b.dt)).and_then(|run| run.gyration)
}

/// The runs of engines that came to the end and packed the rods as ours did.
pub(super) fn beside(engines: &[Engine]) -> impl Iterator<Item = (&Engine, (f64, f64))> {
    let ours = gyration(engines);
    let same = move |run: &Engine| match (ours, run.gyration) {
        (Some(ours), Some(found)) => (found / ours - 1.0).abs() <= GYRATION_WITHIN,
        _ => false,
    };
    engines.iter().filter(move |run| !run.is_ours() && same(run)).filter_map(|run| Some((run, run.cost()?)))
}
