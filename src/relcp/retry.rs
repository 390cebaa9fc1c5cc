//! A step that fails, taken again.
//!
//! The step is cut into halves, and those that fail into halves, down to a 64th. The pieces are steps like any other, so that all together are a step with a smaller
//! `dt`. Where a 64th fails too, there are three ends: growing cells that have no room wait or end the run (`growth.on_no_room`), and what fails for
//! another reason ends the run with the state before the step, or is accepted as it is least bad (`contact.on_failure`).
//!
//! Nothing here depends on earlier steps, so that a run that goes on from a state takes the same pieces.

use super::step::{Attempt, Plan, attempt};
use super::{Crowd, Fault, Keep, Piece, StepReport, Unresolved, Waiting};
use crate::backend::{Again, Backend, Overlap};
use crate::scene::OnNoRoom;

/// Where steps that do not hold are accepted, one that began with more overlap than the tolerance is not cut into pieces if it leaves at most this many times
/// as much: it has no solution, nor have its pieces. A disc that its colony has filled gains a part of a percent a step.
const NO_WORSE: f64 = 1.5;

/// What the CPU leaves of the overlap tolerance for a device's poses, which are rounded when it goes on: its numbers differ by some 1e-9 of a body.
const LEFT_FOR_ROUNDING: f64 = 0.99;

/// Takes the step that failed as `failed` says again, and accepts it.
pub(super) fn take_again(
    backend: &mut dyn Backend,
    plan: &Plan,
    keep: &mut Keep,
    failed: Result<Attempt, Fault>,
) -> Result<(StepReport, Overlap), Fault> {
    let mut plan = *plan;
    let by_cpu = backend.device().is_some();
    let mut report = StepReport::default();
    let mut failed = Some(failed);
    if by_cpu {
        plan.contact.overlap_tolerance *= LEFT_FOR_ROUNDING;
        // What the device came to says nothing of what the CPU would.
        if let Some(Ok(tried)) = failed.take() {
            report.add_cost(&tried.report);
            report.first_violation = tried.report.first_violation;
        }
    }
    let mut overlap = Overlap::default();
    backend.take_again(&mut |again| {
        let before = again.backend().state()?.clone();
        let mut taken = Taking { plan: &plan, keep, report: &mut report, waiting: Waiting::None };
        let result = taken.step(again, failed.take());
        if result.is_err() {
            again.restore(&before);
        }
        overlap = result?;
        Ok(())
    })?;
    report.by_cpu = by_cpu;
    Ok((report, overlap))
}

/// A step that is being taken in pieces.
struct Taking<'a> {
    plan: &'a Plan,
    keep: &'a mut Keep,
    /// Of the pieces accepted so far, and the cost of all.
    report: &'a mut StepReport,
    waiting: Waiting,
}

impl Taking<'_> {
    fn step(&mut self, again: &mut dyn Again, first: Option<Result<Attempt, Fault>>) -> Result<Overlap, Fault> {
        let before = again.backend().state()?.clone();
        let taken = self.piece(again, Piece::WHOLE, first);
        match taken {
            Err(Fault::Unresolved(_)) if self.plan.accepts_the_least_bad() => {
                again.restore(&before);
                self.waiting = Waiting::None;
                *self.report = StepReport { failed_attempts: self.report.failed_attempts, ..self.cost() };
                let tried = self.attempt(again, Piece::WHOLE)?;
                self.accept_least_bad(again, tried)
            }
            taken => taken,
        }
    }

    /// What all attempts cost, without what they came to.
    fn cost(&self) -> StepReport {
        let StepReport { iterations, products, fallbacks, first_violation, phases, .. } = *self.report;
        StepReport { iterations, products, fallbacks, first_violation, phases, ..StepReport::default() }
    }

    /// Takes a piece, in halves where it fails at once. `first` is what an attempt at it came to, where one was made.
    fn piece(
        &mut self,
        again: &mut dyn Again,
        piece: Piece,
        first: Option<Result<Attempt, Fault>>,
    ) -> Result<Overlap, Fault> {
        let tried = match first {
            Some(tried) => tried,
            None => self.attempt(again, piece),
        };
        let failed = match tried {
            Ok(tried) if tried.holds(self.plan) => return self.accept(again, tried),
            Ok(tried) if piece == Piece::WHOLE && self.has_no_solution(again, &tried) => {
                return self.accept_least_bad(again, tried);
            }
            Err(fault) if !fault.may_pass_with_smaller_steps() => return Err(fault),
            failed => failed,
        };
        self.count_failure(&failed);
        if let Some(overlap) = self.wait(again, piece)? {
            return Ok(overlap);
        }
        match piece.halves() {
            Some([first, second]) => {
                self.piece(again, first, None)?;
                self.piece(again, second, None)
            }
            None => self.give_up(again, piece, failed),
        }
    }

    fn attempt(&mut self, again: &mut dyn Again, piece: Piece) -> Result<Attempt, Fault> {
        again.prepare(piece, &self.waiting);
        attempt(again.backend(), self.plan, self.keep)
    }

    fn count_failure(&mut self, failed: &Result<Attempt, Fault>) {
        match failed {
            Ok(tried) => {
                if self.report.failed_attempts == 0 {
                    self.report.first_violation = tried.report.first_violation;
                }
                self.report.add_cost(&tried.report);
            }
            Err(_) => self.report.failed_attempts += 1,
        }
    }

    fn accept(&mut self, again: &mut dyn Again, mut tried: Attempt) -> Result<Overlap, Fault> {
        tried.report.phases = again.backend().accept()?;
        self.report.add_piece(&tried.report);
        Ok(tried.overlap)
    }

    /// Accepts the least bad trial of an attempt, which is the last one that was made.
    fn accept_least_bad(&mut self, again: &mut dyn Again, mut tried: Attempt) -> Result<Overlap, Fault> {
        if let Some((badness, gamma)) = tried.least_bad.take()
            && badness < tried.badness()
        {
            again.set_multipliers(&gamma);
            tried.overlap = again.backend().trial(self.plan.contact.overlap_tolerance)?;
            tried.report.velocity_residual = badness;
            tried.report.passed = again.backend().passed()?;
        }
        self.accept(again, tried)
    }

    /// Whether a whole step that does not hold is accepted at once, as its start held no better.
    fn has_no_solution(&self, again: &dyn Again, tried: &Attempt) -> bool {
        let start = again.start_overlap();
        let over = start > self.plan.contact.overlap_tolerance;
        self.plan.accepts_the_least_bad() && over && tried.badness() <= NO_WORSE * start
    }

    /// Tries a piece with cells waiting that have no room, where the scene lets them: of a whole step first those that overlap, then those that are pressed, then
    /// all; of the shortest piece all.
    fn wait(&mut self, again: &mut dyn Again, piece: Piece) -> Result<Option<Overlap>, Fault> {
        let whole = piece == Piece::WHOLE;
        if self.plan.on_no_room != Some(OnNoRoom::Stall) || !(whole || piece.length <= Piece::SHORTEST) {
            return Ok(None);
        }
        let crowds = if whole { [Some(Crowd::Overlapping), Some(Crowd::Pressed), None].as_slice() } else { &[None] };
        let mut ids = Vec::new();
        for crowd in crowds {
            self.waiting = match crowd {
                Some(crowd) => {
                    ids.extend(again.crowded(*crowd));
                    ids.sort_unstable();
                    ids.dedup();
                    Waiting::Some(ids.clone())
                }
                None => Waiting::All,
            };
            let tried = self.attempt(again, piece);
            self.report.waiting = self.report.waiting.max(self.count_waiting(again));
            match tried {
                Ok(tried) if tried.holds(self.plan) => {
                    self.waiting = Waiting::None;
                    return self.accept(again, tried).map(Some);
                }
                failed => self.count_failure(&failed),
            }
        }
        self.waiting = Waiting::None;
        self.report.waiting = 0;
        Ok(None)
    }

    fn count_waiting(&self, again: &mut dyn Again) -> usize {
        match &self.waiting {
            Waiting::None => 0,
            Waiting::Some(ids) => ids.len(),
            Waiting::All => again.backend().bodies(),
        }
    }

    /// The end of a step whose shortest piece failed.
    fn give_up(
        &mut self,
        again: &mut dyn Again,
        piece: Piece,
        failed: Result<Attempt, Fault>,
    ) -> Result<Overlap, Fault> {
        let tried = failed?;
        let tolerance = self.plan.contact.overlap_tolerance;
        let only_passed = tried.overlap.worst <= tolerance && tried.report.settled(tolerance);
        if self.plan.accepts_the_least_bad() && only_passed {
            // What goes through others in short pieces is still less bad than what does in one.
            let tried = self.attempt(again, piece)?;
            return self.accept(again, tried);
        }
        let unresolved = Unresolved {
            step: again.backend().steps() + 1,
            overlap: tried.overlap.worst,
            pair: tried.overlap.pair.or(tried.report.passed.map(|passed| passed.pair)),
            wall: tried.overlap.wall,
            residual: tried.report.velocity_residual,
            passed: only_passed,
            tolerance: self.plan.contact.overlap_tolerance,
        };
        if self.plan.on_no_room == Some(OnNoRoom::Stop) && self.fails_by_growth(again, piece) {
            return Err(Fault::NoRoom { bodies: again.backend().bodies(), unresolved });
        }
        Err(Fault::Unresolved(unresolved))
    }

    /// Whether the piece can be taken if no cell grows or divides in it.
    fn fails_by_growth(&mut self, again: &mut dyn Again, piece: Piece) -> bool {
        self.waiting = Waiting::All;
        let tried = self.attempt(again, piece);
        self.waiting = Waiting::None;
        self.count_failure(&tried);
        tried.is_ok_and(|tried| tried.holds(self.plan))
    }
}
