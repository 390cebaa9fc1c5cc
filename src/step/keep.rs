//! The LCPs of a run that its scene selects (`solver.dump`), with the start of each.

use super::{Dump, Fault};
use crate::lcp::{Outcome, Status, Stored};
use crate::step::Verbs;

/// An LCP of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedLcp {
    /// The step that was being taken, from 1.
    pub step: u64,
    /// Solves of the step before this one: recursions, looser solves of the same rows, and the half step of a midpoint
    /// step.
    pub recursion: u32,
    /// The solver's tolerance, a length.
    pub tolerance: f64,
    /// How the solve ended.
    pub outcome: Outcome,
    /// The LCP, its start and its result.
    pub lcp: Stored,
}

/// Solves the LCPs of steps and keeps the selected ones, at most [`Dump::at_most`] in all.
#[derive(Debug, Default)]
pub struct Keep {
    dump: Option<Dump>,
    counted: usize,
    kept: Vec<SavedLcp>,
    /// The step that is being taken, and its solves so far.
    solves: (u64, u32),
}

impl Keep {
    /// Keeps the LCPs that `dump` selects; without it none.
    pub fn new(dump: Option<Dump>) -> Self {
        Keep { dump, ..Keep::default() }
    }

    /// Solves the present LCP of a step to a residual.
    pub(super) fn solve(&mut self, backend: &mut dyn Verbs, tolerance: f64) -> Result<Outcome, Fault> {
        let step = backend.steps() + 1;
        let recursion = if self.solves.0 == step { self.solves.1 } else { 0 };
        self.solves = (step, recursion + 1);
        let solve = |backend: &mut dyn Verbs| {
            let outcome = backend.solve(tolerance)?;
            let (rows, Outcome { status, iterations, products, residual, .. }) = (backend.constraints(), outcome);
            log::trace!(
                "step {step}, solve {recursion}: {rows} rows to {tolerance:.1e}: {status:?}, {iterations} iterations, {products} products, residual {residual:.2e}"
            );
            Ok::<_, Fault>(outcome)
        };
        let Some(dump) = self.dump.filter(|dump| self.counted < dump.at_most()) else { return solve(backend) };
        let start = backend.multipliers()?;
        let outcome = solve(backend)?;
        if dump.wants(outcome.status == Status::Solved, outcome.products) {
            self.counted += 1;
            let lcp = backend.stored_lcp(start)?;
            self.kept.push(SavedLcp { step, recursion, tolerance, outcome, lcp });
        }
        Ok(outcome)
    }

    /// Takes the kept LCPs.
    pub(crate) fn take(&mut self) -> Vec<SavedLcp> {
        std::mem::take(&mut self.kept)
    }

    /// Counts LCPs that were saved before.
    pub(crate) fn count(&mut self, saved: usize) {
        self.counted += saved;
    }
}
