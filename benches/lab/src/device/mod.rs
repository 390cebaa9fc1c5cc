//! Measurements of one device: the agreement of its results with the CPU, its speed, and the best values of tuning
//! constants.
//!
//! Items are measured in a fixed order within a time limit. Results are written after each item, so that the next call
//! continues after an interruption or the time limit.

mod clusters;
mod colony;
mod constants;
mod item;
mod page;
mod parity;
mod plot;
mod results;
mod speed;
#[cfg(test)]
mod tests;

pub use clusters::ClusterRow;
pub use colony::{Doubling, Growth};
pub use constants::SmallRow;
pub use parity::Check;
pub use results::{Entry, FILE, Finding, Machine, Results};
pub use speed::{IterationRow, SpeedRow};

use super::throughput::Kind;
use super::{StudyError, copy_bandwidth};
use item::{Item, Parity, iteration_bodies};
use relcp::figure::Figure;
use relcp::gpu::{Gpu, Precision};
use relcp::simulation::Compute;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// The fraction of the remaining time that a colony on the device may take. The CPU gets the rest.
const GROWTH_ON_DEVICE: f64 = 0.6;

/// Step of a growing colony, as in the built-in scene, and a longer step for a quick study.
const GROWTH_DT: f64 = 1e-3;
const QUICK_GROWTH_DT: f64 = 1e-2;

/// The extent of the measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Numbers of bodies, ascending.
    pub sizes: Vec<usize>,
    /// The precisions.
    pub precisions: Vec<Precision>,
    /// The time limit of this call.
    pub time: Duration,
    /// Fewer steps, and longer steps of a colony.
    pub quick: bool,
    /// Number of cells at which the growth of a colony ends.
    pub cells: usize,
}

impl Options {
    /// The sizes of a whole study: 2^10 to 2^20, each four times the one before.
    pub fn sizes() -> Vec<usize> {
        (10..=20).step_by(2).map(|k| 1 << k).collect()
    }
}

/// A study of a device.
pub struct Study {
    gpu: Arc<Gpu>,
    options: Options,
    folder: PathBuf,
    results: Results,
    begun: Instant,
    /// Items that this call has tried.
    tried: Vec<String>,
}

impl Study {
    /// Begins a study, or continues the study in the folder.
    ///
    /// # Errors
    /// [`StudyError::Damaged`] and [`StudyError::Elsewhere`], which leave the folder as it is; what cannot be written.
    pub fn open(gpu: Arc<Gpu>, options: Options, folder: &Path) -> Result<Study, StudyError> {
        let results = Results::open(folder, &gpu)?;
        let study =
            Study { gpu, options, folder: folder.to_owned(), results, begun: Instant::now(), tried: Vec::new() };
        study.results.write(folder)?;
        Ok(study)
    }

    /// Returns the results so far.
    pub fn results(&self) -> &Results {
        &self.results
    }

    /// Measures the next item that fits into the time limit and returns a line about its result, or `None` if all items
    /// are complete. `go_on` is called from time to time. If it returns false, the remaining items are skipped.
    ///
    /// # Errors
    /// Errors that make the device unusable, and files that cannot be written.
    pub fn next_item(&mut self, go_on: &dyn Fn() -> bool) -> Result<Option<String>, StudyError> {
        self.results.skipped.clear();
        let mut chosen = None;
        for item in Item::all(&self.options.sizes, &self.options.precisions) {
            let name = item.name();
            if self.results.finding(&name).is_some() || self.tried.contains(&name) {
                continue;
            }
            match self.has_time(&item) {
                Ok(()) if chosen.is_none() => chosen = Some(item),
                Ok(()) => {
                    self.results.skipped.insert(name, "not yet begun".into());
                }
                Err(why) => {
                    self.results.skipped.insert(name, why);
                }
            }
        }
        let Some(item) = chosen.filter(|_| go_on()) else {
            if let Some(item) = chosen {
                self.results.skipped.insert(item.name(), "interrupted".into());
            }
            self.results.write(&self.folder)?;
            return Ok(None);
        };
        let (name, begun) = (item.name(), Instant::now());
        self.tried.push(name.clone());
        let finding = match self.measure(item, go_on) {
            Ok(Some(finding)) => finding,
            Ok(None) => {
                self.results.skipped.insert(name.clone(), "interrupted".into());
                self.results.write(&self.folder)?;
                return Ok(Some(format!("{name}: interrupted")));
            }
            Err(fault) => {
                self.gpu.health()?;
                Finding::Failed { why: fault.to_string() }
            }
        };
        let wall_seconds = begun.elapsed().as_secs_f64();
        let said = format!("{name}: {} ({wall_seconds:.1} s)", page::said(&finding));
        let ended = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let entry = Entry { wall_seconds, ended_unix_seconds: ended.as_secs(), finding };
        self.results.items.insert(name, entry);
        self.results.write(&self.folder)?;
        Ok(Some(said))
    }

    /// Returns an error with the reason if there is no time for an item.
    fn has_time(&self, item: &Item) -> Result<(), String> {
        let until = item.until(self.options.time);
        let left = until.saturating_sub(self.begun.elapsed());
        let expected = item.expected(&self.options.sizes, &self.results)?;
        if !left.is_zero() && expected <= left {
            return Ok(());
        }
        let (expected, left) = (expected.as_secs_f64(), left.as_secs_f64());
        Err(format!("no time: some {expected:.0} s, of {left:.0} s left for its kind"))
    }

    fn measure(&self, item: Item, go_on: &dyn Fn() -> bool) -> Result<Option<Finding>, StudyError> {
        let Study { gpu, options, .. } = self;
        let checks = |checks: Vec<Check>| Finding::Parity { checks };
        Ok(Some(match item {
            Item::Parity(Parity::Separations, precision) => checks(parity::separations(gpu, precision)?),
            Item::Parity(Parity::Rows, precision) => checks(parity::rows(gpu, precision)?),
            Item::Parity(Parity::Solves, precision) => checks(parity::solves(gpu, precision)?),
            Item::Parity(Parity::Steps, precision) => checks(parity::steps(gpu, precision)?),
            Item::Bandwidth => Finding::Bandwidth { bytes_a_second: copy_bandwidth(gpu)? },
            Item::Speed(kind, bodies, precision) => {
                let row = speed::measure((kind, bodies), (gpu, precision), self.bandwidth(), options.quick)?;
                Finding::Speed(Box::new(row))
            }
            Item::Iteration(precision) => {
                let bodies = iteration_bodies(&options.sizes, precision, &self.results).unwrap_or(1);
                let mut rows = Vec::new();
                for kind in Kind::ALL {
                    rows.extend(speed::iteration((kind, bodies), (gpu, precision), options.quick)?);
                }
                Finding::Iteration { rows }
            }
            Item::Small(precision) => Finding::Small { rows: constants::small(gpu, precision, options.quick)? },
            Item::Clusters(bodies, precision) => {
                Finding::Clusters(clusters::measure(gpu, precision, bodies, options.quick)?)
            }
            Item::GrowthOnDevice(precision) => {
                let compute = Compute::Gpu { gpu: gpu.clone(), precision };
                return self.grow(&compute, options.cells, self.left().mul_f64(GROWTH_ON_DEVICE), go_on);
            }
            Item::GrowthOnCpu => {
                let on_device = options.precisions.first().and_then(|precision| {
                    match self.results.finding(&Item::GrowthOnDevice(*precision).name()) {
                        Some(Finding::Growth(growth)) => Some(growth.largest()),
                        _ => None,
                    }
                });
                return self.grow(&Compute::Cpu, on_device.unwrap_or(options.cells), self.left(), go_on);
            }
        }))
    }

    fn grow(
        &self,
        compute: &Compute,
        cells: usize,
        time: Duration,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Option<Finding>, StudyError> {
        let dt = if self.options.quick { QUICK_GROWTH_DT } else { GROWTH_DT };
        Ok(colony::grow(compute, (dt, cells), time, go_on)?.map(Finding::Growth))
    }

    fn left(&self) -> Duration {
        self.options.time.saturating_sub(self.begun.elapsed())
    }

    fn bandwidth(&self) -> Option<f64> {
        match self.results.finding(&Item::Bandwidth.name()) {
            Some(Finding::Bandwidth { bytes_a_second }) => Some(*bytes_a_second),
            _ => None,
        }
    }

    /// Returns whether a result differed from the CPU by more than its bound, failed, or did not converge.
    pub fn missed(&self) -> bool {
        self.results.items.values().any(|entry| match &entry.finding {
            Finding::Parity { checks } => checks.iter().any(|check| !check.held),
            Finding::Speed(row) => row.unconverged > 0 || row.max_overlap > page::OVERLAP,
            Finding::Failed { .. } => true,
            _ => false,
        })
    }

    /// The page.
    pub fn page(&self) -> String {
        page::page(&self.results)
    }

    /// The plots, by name.
    ///
    /// # Errors
    /// [`StudyError::Plot`].
    pub fn plots(&self) -> Result<Vec<(&'static str, Figure)>, StudyError> {
        plot::plots(&self.results)
    }
}

/// Returns a name for the folder of a device.
pub fn folder_name(adapter: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let plain: String = adapter.chars().map(plain).collect();
    let words: Vec<&str> = plain.split('-').filter(|word| !word.is_empty()).collect();
    format!("device-{}", if words.is_empty() { "unnamed".into() } else { words.join("-") })
}
