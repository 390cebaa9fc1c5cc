//! The LCPs of a run that its scene asks to be kept (`solver.dump`), with the start that each was solved from.

use super::Fault;
use crate::backend::Backend;
use crate::lcp::{Outcome, Status, Stored};
use crate::scene::Dump;

/// An LCP of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// The step that was being taken, from 1.
    pub step: u64,
    /// Recursions before this solve; the half step of a midpoint step counts as one.
    pub recursion: u32,
    /// How the solve ended.
    pub outcome: Outcome,
    /// The LCP, its start and what the solver made of it.
    pub lcp: Stored,
}

/// Solves the LCPs of steps, and keeps those that are asked for, never more than [`Dump::at_most`] in all.
#[derive(Debug, Default)]
pub struct Keep {
    dump: Option<Dump>,
    counted: usize,
    kept: Vec<Kept>,
}

impl Keep {
    /// Keeps what `dump` asks for; without it, nothing.
    pub fn new(dump: Option<Dump>) -> Self {
        Keep { dump, counted: 0, kept: Vec::new() }
    }

    /// Solves the present LCP of a step after so many recursions.
    pub(super) fn solve(&mut self, backend: &mut dyn Backend, recursion: u32) -> Result<Outcome, Fault> {
        let Some(dump) = self.dump.filter(|dump| self.counted < dump.at_most()) else { return backend.solve() };
        let start = backend.multipliers()?;
        let outcome = backend.solve()?;
        if dump.wants(outcome.status == Status::Solved, outcome.products) {
            self.counted += 1;
            let lcp = backend.stored_lcp(start)?;
            self.kept.push(Kept { step: backend.steps() + 1, recursion, outcome, lcp });
        }
        Ok(outcome)
    }

    /// Takes what is there.
    pub(super) fn take(&mut self) -> Vec<Kept> {
        std::mem::take(&mut self.kept)
    }

    /// Counts LCPs that were saved before.
    pub(super) fn count(&mut self, saved: usize) {
        self.counted += saved;
    }
}
