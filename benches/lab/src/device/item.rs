//! The items to measure, in order, and the expected time of each.

use super::results::{Finding, Results};
use crate::throughput::Kind;
use relcp::gpu::Precision;
use std::time::Duration;

/// The fraction of a call's time until which items of a kind may begin. Checks of correctness may always begin. The
/// growth of a colony, which takes all the time that it gets, uses the rest.
const UNTIL_SPEEDS: f64 = 0.55;
const UNTIL_CONSTANTS: f64 = 0.7;

/// The expected time per body of a size, divided by that of the previous size, which has at most half as many bodies.
const GROWTH_OF_COST: f64 = 1.2;

/// The minimum time for a colony, on a device and on the CPU. Without it, a colony that grew only briefly would count
/// as measured.
const LEAST_GROWTH: [Duration; 2] = [Duration::from_secs(30), Duration::from_secs(10)];

/// A check against the CPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    Separations,
    Rows,
    Solves,
    Steps,
}

/// An item to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Item {
    Parity(Parity, Precision),
    Bandwidth,
    Speed(Kind, usize, Precision),
    Iteration(Precision),
    Small(Precision),
    Clusters(usize, Precision),
    GrowthOnDevice(Precision),
    GrowthOnCpu,
}

impl Item {
    /// Returns all items, in order.
    pub fn all(sizes: &[usize], precisions: &[Precision]) -> Vec<Item> {
        let parities = [Parity::Separations, Parity::Rows, Parity::Solves, Parity::Steps];
        let each = |of: fn(Precision) -> Item| precisions.iter().map(move |precision| of(*precision));
        let mut all: Vec<Item> =
            precisions.iter().flat_map(|precision| parities.map(|parity| Item::Parity(parity, *precision))).collect();
        all.push(Item::Bandwidth);
        for size in sizes {
            for kind in Kind::ALL {
                all.extend(precisions.iter().map(|precision| Item::Speed(kind, *size, *precision)));
            }
        }
        all.extend(each(Item::Iteration));
        all.extend(each(Item::Small));
        for size in sizes {
            all.extend(precisions.iter().map(|precision| Item::Clusters(*size, *precision)));
        }
        all.extend(precisions.first().map(|precision| Item::GrowthOnDevice(*precision)));
        all.push(Item::GrowthOnCpu);
        all
    }

    /// Returns the item's name in the file of results.
    pub fn name(&self) -> String {
        match self {
            Item::Parity(parity, precision) => {
                let what = match parity {
                    Parity::Separations => "separations",
                    Parity::Rows => "rows",
                    Parity::Solves => "solves",
                    Parity::Steps => "steps",
                };
                format!("parity/{what}/{}", precision.name())
            }
            Item::Bandwidth => "bandwidth".into(),
            Item::Speed(kind, size, precision) => format!("speed/{}/{size}/{}", kind.name(), precision.name()),
            Item::Iteration(precision) => format!("iteration/{}", precision.name()),
            Item::Small(precision) => format!("small/{}", precision.name()),
            Item::Clusters(size, precision) => format!("clusters/{size}/{}", precision.name()),
            Item::GrowthOnDevice(precision) => format!("growth/{}", precision.name()),
            Item::GrowthOnCpu => "growth/cpu".into(),
        }
    }

    /// Returns the time within a call of `budget` until which the item may run.
    pub fn until(&self, budget: Duration) -> Duration {
        match self {
            Item::Parity(..) | Item::Bandwidth | Item::GrowthOnDevice(_) | Item::GrowthOnCpu => budget,
            Item::Speed(..) => budget.mul_f64(UNTIL_SPEEDS),
            Item::Iteration(_) | Item::Small(_) | Item::Clusters(..) => budget.mul_f64(UNTIL_CONSTANTS),
        }
    }

    /// Returns the expected time, from the results for its size or for the previous size, or the reason why the item
    /// cannot run.
    pub fn expected(&self, sizes: &[usize], results: &Results) -> Result<Duration, String> {
        let with_size = |size| match *self {
            Item::Speed(kind, _, precision) => Item::Speed(kind, size, precision),
            Item::Clusters(_, precision) => Item::Clusters(size, precision),
            other => other,
        };
        let size = match *self {
            Item::Speed(_, size, _) | Item::Clusters(size, _) => size,
            Item::Iteration(precision) => {
                let Some(bodies) = iteration_bodies(sizes, precision, results) else {
                    return Err("steps of no size were measured".into());
                };
                let seconds = Kind::ALL.map(|kind| {
                    results
                        .items
                        .get(&Item::Speed(kind, bodies, precision).name())
                        .map_or(0.0, |entry| entry.wall_seconds)
                });
                return Ok(duration(seconds.into_iter().sum()));
            }
            Item::GrowthOnDevice(_) => return Ok(LEAST_GROWTH[0]),
            Item::GrowthOnCpu => return Ok(LEAST_GROWTH[1]),
            _ => return Ok(Duration::ZERO),
        };
        let Some(before) = sizes.iter().copied().filter(|other| *other < size).max() else { return Ok(Duration::ZERO) };
        match results.items.get(&with_size(before).name()) {
            Some(entry) if matches!(entry.finding, Finding::Failed { .. }) => Err(format!("{before} bodies failed")),
            Some(entry) => Ok(duration(GROWTH_OF_COST * size as f64 / before as f64 * entry.wall_seconds)),
            None => Err(format!("{before} bodies were left out")),
        }
    }
}

fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}

/// The largest number of bodies whose iteration is measured by stages: enough to keep the device busy, few enough for a
/// software adapter.
const ITERATION_BODIES: usize = 1 << 16;

/// Returns the number of bodies whose iteration is measured by stages: the largest size within the limit whose steps
/// were measured.
pub fn iteration_bodies(sizes: &[usize], precision: Precision, results: &Results) -> Option<usize> {
    let measured = |size: usize| {
        Kind::ALL.into_iter().all(|kind| results.finding(&Item::Speed(kind, size, precision).name()).is_some())
    };
    let near = sizes.iter().copied().filter(|size| *size <= ITERATION_BODIES && measured(*size));
    near.max().or_else(|| sizes.iter().copied().filter(|size| measured(*size)).min())
}
