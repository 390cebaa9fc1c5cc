//! What whole steps cost by the number of bodies, and one iteration of the solver by its stages.

use crate::StudyError;
use crate::throughput::{self, Kind};
use relcp::gpu::{Gpu, Precision, Profile};
use relcp::simulation::{Compute, Simulation};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Steps taken before those that are timed, in which drivers compile kernels and multipliers are remembered, and steps
/// timed.
const STEPS: [usize; 2] = [3, 5];
const QUICK_STEPS: [usize; 2] = [1, 2];

/// Steps that are profiled.
const PROFILED: usize = 3;

/// The cost of steps of one problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedRow {
    pub kind: Kind,
    pub bodies: usize,
    pub precision: String,
    /// Rows of the last LCP.
    pub constraints: usize,
    /// Steps timed.
    pub steps: usize,
    pub step_ms: f64,
    /// Broad phase, narrow phase, solve, integrate, growth.
    pub stages_ms: [f64; 5],
    pub recursions: f64,
    /// Iterations of the solver a step.
    pub iterations: f64,
    pub iteration_us: f64,
    /// Bytes that an iteration must move, at least, a second; over what the device copies a second.
    pub part_of_copy: Option<f64>,
    pub dispatches: f64,
    pub reads: f64,
    pub max_overlap: f64,
    pub unconverged: u32,
}

/// A stage of the solver, by one iteration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IterationRow {
    pub kind: Kind,
    pub bodies: usize,
    pub precision: String,
    pub stage: String,
    /// Milliseconds a step on the device; none where the adapter has no timestamps.
    pub step_ms: Option<f64>,
    /// Microseconds an iteration of the solver, where the stage is the solver's.
    pub iteration_us: Option<f64>,
    pub dispatches: f64,
    pub reads: f64,
    pub wait_ms: f64,
    pub bytes_read: f64,
    pub bytes_written: f64,
}

/// Steps this number of bodies.
pub fn measure(
    (kind, bodies): (Kind, usize),
    (gpu, precision): (&Arc<Gpu>, Precision),
    bandwidth: Option<f64>,
    quick: bool,
) -> Result<SpeedRow, StudyError> {
    let compute = Compute::Gpu { gpu: gpu.clone(), precision };
    let row = throughput::measure_with(kind, bodies, if quick { QUICK_STEPS } else { STEPS }, &compute, bandwidth)?;
    Ok(SpeedRow {
        kind,
        bodies: row.bodies,
        precision: precision.name().into(),
        constraints: row.constraints,
        steps: row.steps,
        step_ms: row.step_ms,
        stages_ms: row.stages_ms,
        recursions: row.recursions,
        iterations: row.iterations,
        iteration_us: row.iteration_us,
        part_of_copy: (row.bandwidth_floor > 0.0).then(|| 1.0 / row.bandwidth_floor),
        dispatches: row.dispatches,
        reads: row.reads,
        max_overlap: row.max_overlap,
        unconverged: row.unconverged,
    })
}

/// Profiles a few steps of this number of bodies: every stage, and those of the solver also by iteration.
pub fn iteration(
    (kind, bodies): (Kind, usize),
    (gpu, precision): (&Arc<Gpu>, Precision),
    quick: bool,
) -> Result<Vec<IterationRow>, StudyError> {
    let compute = Compute::Gpu { gpu: gpu.clone(), precision };
    let (scene, start) = throughput::start(kind, bodies)?;
    let mut simulation = Simulation::builder(scene).bodies(start).on(&compute).build()?;
    for _ in 0..if quick { QUICK_STEPS } else { STEPS }[0] {
        simulation.step()?;
    }
    gpu.start_timing();
    let iterations = (0..PROFILED).try_fold(0, |sum, _| Ok(sum + simulation.step()?.iterations));
    let profile = Profile::of(gpu, PROFILED as u64);
    gpu.stop_timing();
    let iterations: u64 = iterations.map_err(|fault: relcp::step::Fault| StudyError::from(fault))?;
    let a_step = |x: f64| x / PROFILED as f64;
    let row = |used: &relcp::gpu::StageUse| {
        let (c, of_solver) = (&used.counters, used.stage.starts_with("lcp"));
        IterationRow {
            kind,
            bodies,
            precision: precision.name().into(),
            stage: used.stage.into(),
            step_ms: used.seconds.map(|seconds| a_step(1e3 * seconds)),
            iteration_us: used
                .seconds
                .filter(|_| of_solver && iterations > 0)
                .map(|seconds| 1e6 * seconds / iterations as f64),
            dispatches: a_step(c.dispatches as f64),
            reads: a_step(c.reads as f64),
            wait_ms: a_step(1e3 * c.wait_seconds),
            bytes_read: a_step(c.bytes_read as f64),
            bytes_written: a_step(c.bytes_written as f64),
        }
    };
    Ok(profile.stages.iter().map(row).collect())
}
