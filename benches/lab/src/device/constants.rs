//! Measurements of tuning constants that can be set: each is tried with several values on a device.
//!
//! There is one such constant: the largest number of rows of an LCP that a single workgroup solves
//! ([`Solver::set_largest_small`]). A further constant gets a function here, an item and a table.

use crate::StudyError;
use crate::solvers::built_in;
use relcp::gpu::{Gpu, Precision};
use relcp::internals::freedom::{PLANAR, SPATIAL};
use relcp::internals::lcp::gpu::{DeviceProblem, Solver};
use relcp::lcp::{Settings, Stored};
use relcp::scene::SolverKind;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Numbers of rows of the parts of stored LCPs that are tried. One workgroup is certainly faster for the smallest and
/// certainly slower for the largest.
const ROWS: [usize; 6] = [32, 64, 128, 256, 512, 1024];

/// The same for a quick study.
const QUICK_ROWS: [usize; 2] = [32, 256];
const QUICK_PROBLEMS: usize = 2;

/// The tolerance of the solves. Only the time of iterations matters here, not their result.
const TOLERANCE: f64 = 1e-5;
const MOST_ITERATIONS: u64 = 500;

/// Number of timed solves. The shortest counts.
const REPEATS: usize = 3;

/// The time of an iteration with one workgroup and with many.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SmallRow {
    pub lcp: String,
    pub constraints: usize,
    pub precision: String,
    /// Microseconds of an iteration, with its part of the waits.
    pub one_workgroup_us: f64,
    pub many_workgroups_us: f64,
}

/// Solves parts of stored LCPs in both ways.
pub fn small(gpu: &Gpu, precision: Precision, quick: bool) -> Result<Vec<SmallRow>, StudyError> {
    let (counts, most): (&[usize], usize) = if quick { (&QUICK_ROWS, QUICK_PROBLEMS) } else { (&ROWS, usize::MAX) };
    let mut rows = Vec::new();
    for named in built_in()?.iter().filter(|named| named.name.ends_with("last")).take(most) {
        for count in counts.iter().copied().filter(|count| *count <= named.lcp.q.len()) {
            let part = first_rows(&named.lcp, count);
            let us = |largest| iteration_us(gpu, precision, &part, largest);
            rows.push(SmallRow {
                lcp: named.name.clone(),
                constraints: count,
                precision: precision.name().into(),
                one_workgroup_us: us(u64::MAX)?,
                many_workgroups_us: us(0)?,
            });
        }
    }
    Ok(rows)
}

/// The LCP of the first rows only, with the bodies of these rows.
fn first_rows(lcp: &Stored, count: usize) -> Stored {
    let mut places = std::collections::BTreeMap::new();
    let pair: Vec<[u32; 2]> = lcp.pair[..count]
        .iter()
        .map(|pair| {
            pair.map(|body| {
                let next = places.len() as u32;
                *places.entry(body).or_insert(next)
            })
        })
        .collect();
    let side = |side: usize| lcp.rows[side][..count * lcp.unknowns].to_vec();
    Stored {
        unknowns: lcp.unknowns,
        bodies: places.len(),
        pair,
        rows: [side(0), side(1)],
        q: lcp.q[..count].to_vec(),
        start: lcp.start[..count].to_vec(),
        gamma: Vec::new(),
        velocity: Vec::new(),
    }
}

fn iteration_us(gpu: &Gpu, precision: Precision, lcp: &Stored, largest: u64) -> Result<f64, StudyError> {
    if lcp.unknowns == PLANAR {
        solve::<PLANAR>(gpu, precision, lcp, largest)
    } else {
        solve::<SPATIAL>(gpu, precision, lcp, largest)
    }
}

fn solve<const D: usize>(gpu: &Gpu, precision: Precision, lcp: &Stored, largest: u64) -> Result<f64, StudyError> {
    let Some(problem) = lcp.problem::<D>() else { return Ok(f64::MAX) };
    let settings = Settings { tolerance: TOLERANCE, max_iterations: MOST_ITERATIONS };
    let mut solver = Solver::new(gpu, precision, D == PLANAR, SolverKind::Auto, settings)?;
    solver.set_largest_small(largest);
    let mut best = f64::MAX;
    // The first solve compiles kernels.
    for repeat in 0..=REPEATS {
        let (mut device, _) = DeviceProblem::upload(gpu, precision, &problem, &[])?;
        gpu.wait()?;
        let begun = Instant::now();
        let outcome = solver.solve(gpu, &mut device)?;
        gpu.wait()?;
        let us = 1e6 * begun.elapsed().as_secs_f64() / outcome.iterations.max(1) as f64;
        if repeat > 0 {
            best = best.min(us);
        }
    }
    Ok(best)
}
