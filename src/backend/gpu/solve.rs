//! The solves of a step.

use super::Setup;
use super::candidates::Candidates;
use super::row_set::RowSet;
use crate::gpu::{Gpu, GpuError};
use crate::lcp::gpu::Solver;
use crate::lcp::{Outcome, Settings};
use crate::step::Model;

/// A solver on the device.
pub(super) struct Solve {
    solver: Solver,
}

impl Solve {
    /// The solver of a scene with this many bodies.
    pub fn new(gpu: &Gpu, setup: &Setup, model: &Model, bodies: u64) -> Result<Self, GpuError> {
        let solver = Solver::new(gpu, setup.precision, setup.planar, model.solver, model.lcp)?;
        let mut solve = Solve { solver };
        solve.compile(gpu, bodies)?;
        Ok(solve)
    }

    /// Compiles the kernels for this many bodies, unless this was done before. All other kernels are compiled with the
    /// backend.
    pub fn compile(&mut self, gpu: &Gpu, bodies: u64) -> Result<(), GpuError> {
        self.solver.compile(gpu, bodies)
    }

    /// The tolerance of the last solve, a length.
    pub fn tolerance(&self) -> f64 {
        self.solver.settings().tolerance
    }

    /// Solves from the present multipliers.
    pub fn solve(
        &mut self,
        gpu: &Gpu,
        candidates: &mut Candidates,
        rows: &mut RowSet,
        tolerance: f64,
    ) -> Result<Outcome, GpuError> {
        self.solver.set_settings(Settings { tolerance, ..self.solver.settings() });
        let problem = &mut rows.problem;
        let Some(surfaces) = &mut candidates.surfaces else { return self.solver.solve(gpu, problem) };
        surfaces.join_places(gpu, &candidates.lists, &problem.block_start)?;
        surfaces.exchange_starts(&mut problem.block_start);
        let outcome = self.solver.solve(gpu, problem);
        surfaces.exchange_starts(&mut problem.block_start);
        outcome
    }
}
