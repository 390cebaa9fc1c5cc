//! The solves of a step.

use super::Setup;
use super::candidates::Candidates;
use super::row_set::RowSet;
use crate::gpu::{Gpu, GpuError};
use crate::lcp::gpu::{DeviceProblem, Solver};
use crate::lcp::{Outcome, Settings};
use crate::step::Model;

/// A solver on the device.
pub(super) struct Solve {
    /// None where the host solves.
    solver: Option<Solver>,
    /// The tolerance of the last solve, a length.
    pub tolerance: f64,
}

impl Solve {
    /// The solver of a scene with this many bodies; none if the host solves.
    pub fn new(gpu: &Gpu, setup: &Setup, model: &Model, (bodies, on_host): (u64, bool)) -> Result<Self, GpuError> {
        let solver = || Solver::new(gpu, setup.precision, setup.planar, model.solver, model.lcp);
        let solver = if on_host { None } else { Some(solver()?) };
        let mut solve = Solve { solver, tolerance: model.lcp.tolerance };
        solve.compile(gpu, bodies)?;
        Ok(solve)
    }

    /// Compiles the kernels for this many bodies, unless this was done before. All other kernels are compiled with the
    /// backend.
    pub fn compile(&mut self, gpu: &Gpu, bodies: u64) -> Result<(), GpuError> {
        self.solver.as_mut().map_or(Ok(()), |solver| solver.compile(gpu, bodies))
    }

    /// Solves from the present multipliers.
    pub fn solve(
        &mut self,
        gpu: &Gpu,
        candidates: &mut Candidates,
        rows: &mut RowSet,
        tolerance: f64,
    ) -> Result<Outcome, GpuError> {
        self.tolerance = tolerance;
        let Some(solver) = &mut self.solver else {
            return Err(GpuError::Refused { message: "the host solves in this scene".into() });
        };
        solver.set_settings(Settings { tolerance, ..solver.settings() });
        with_joined(gpu, candidates, &mut rows.problem, |problem| solver.solve(gpu, problem))
    }
}

/// Solves a problem in which a body's rows at all places of a surface are those of one pair.
pub(super) fn with_joined<T>(
    gpu: &Gpu,
    candidates: &mut Candidates,
    problem: &mut DeviceProblem,
    solve: impl FnOnce(&mut DeviceProblem) -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    let Some(surfaces) = &mut candidates.surfaces else { return solve(problem) };
    surfaces.join_places(gpu, &candidates.lists, &problem.block_start)?;
    surfaces.exchange_starts(&mut problem.block_start);
    let outcome = solve(problem);
    surfaces.exchange_starts(&mut problem.block_start);
    outcome
}
