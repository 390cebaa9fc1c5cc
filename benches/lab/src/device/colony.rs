//! A colony that grows from one cell until the time limit: the time of each doubling.

use crate::StudyError;
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// The scene: one growing founder.
const SCENE: &str = "colony-full";

/// End time of the scene, which is not reached: the scene would end with 2^23 cells.
const END: &str = "time.end=16";

/// The first time at which the number of cells had doubled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Doubling {
    pub cells: usize,
    pub steps: u64,
    /// Wall time since the start, including the compilation of kernels in the first steps.
    pub wall_seconds: f64,
    pub iterations: u64,
    pub constraints: usize,
    /// The largest overlap so far.
    pub max_overlap: f64,
}

/// The growth of a colony.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Growth {
    pub computed_by: String,
    pub dt: f64,
    pub doublings: Vec<Doubling>,
    /// Cells at the end.
    pub cells: usize,
    /// Whether it reached the requested size. Otherwise the time limit ended it.
    pub whole: bool,
    /// Steps that the CPU took for the device.
    pub steps_by_cpu: u64,
}

impl Growth {
    /// The largest number of cells at a doubling.
    pub fn largest(&self) -> usize {
        self.doublings.last().map_or(1, |doubling| doubling.cells)
    }
}

/// Grows a colony to `most` cells or until the time limit. Returns `None` if it is interrupted.
pub fn grow(
    compute: &Compute,
    (dt, most): (f64, usize),
    time: Duration,
    go_on: &dyn Fn() -> bool,
) -> Result<Option<Growth>, StudyError> {
    let scene = Scene::load(SCENE, [END.to_owned(), format!("time.dt={dt}")])?;
    let begun = Instant::now();
    let mut simulation = Simulation::builder(scene).on(compute).build()?;
    let computed_by = match simulation.device() {
        Some(gpu) => format!("{} {}", gpu.name(), simulation.precision().name()),
        None => format!("CPU f64, {} threads", rayon::current_num_threads()),
    };
    let mut growth = Growth { computed_by, dt, doublings: Vec::new(), cells: 1, whole: most <= 1, steps_by_cpu: 0 };
    let (mut iterations, mut max_overlap) = (0, 0.0f64);
    while !growth.whole && !simulation.done() && begun.elapsed() < time {
        if !go_on() {
            return Ok(None);
        }
        let report = simulation.step()?;
        iterations += report.iterations;
        max_overlap = max_overlap.max(report.max_overlap);
        growth.steps_by_cpu += u64::from(report.by_cpu);
        growth.cells = simulation.bodies();
        while growth.cells >= 2 * growth.largest() && !growth.whole {
            growth.doublings.push(Doubling {
                cells: 2 * growth.largest(),
                steps: report.step,
                wall_seconds: begun.elapsed().as_secs_f64(),
                iterations,
                constraints: report.constraints,
                max_overlap,
            });
            growth.whole = 2 * growth.largest() > most;
        }
    }
    Ok(Some(growth))
}
