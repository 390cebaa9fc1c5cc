//! Separates bodies that overlap, without advancing time: those of a start that overlaps, and those that still overlap
//! a little at the end of the shortest piece of a step.

use super::algorithm::{Attempt, Plan, attempt};
use super::retry::{Taking, go_to_least_bad};
use super::{Fault, Phases, Piece, RetryBackend, StepReport, Stepping};
use crate::dynamics::Waiting;
use crate::step::Overlap;

/// The largest number of rounds of separation. Of 14 crowded starts that one solve could not separate, those that can
/// be separated take 2 to 9.
const MOST_ROUNDS_OF_PARTING: u32 = 32;

/// A round of separation that moves a body farther fails: in deepest overlaps per body of the scene. A row of `n`
/// bodies that overlap by `d` needs half of `n d` on either side.
const MOST_MOVE_OF_PARTING: f64 = 2.0;

impl Taking<'_> {
    /// Separates bodies that overlap by more than the tolerance, without advancing time, `at` this many `dt` after the
    /// last step. Returns the remaining overlap; none if they cannot be separated, and then they keep their positions.
    /// Each round starts from the best trial of the last one, with rows made there. `guarded`: no round may throw
    /// bodies or let them pass each other.
    pub(super) fn parted(
        &mut self,
        again: &mut dyn RetryBackend,
        at: f64,
        guarded: bool,
    ) -> Result<Option<Overlap>, Fault> {
        let before = again.state()?.clone();
        let plan = Plan { stepping: Stepping::Euler, keeps_least_bad: true, loosens_early: false, ..self.plan.clone() };
        again.part(true);
        let (mut left, mut moves) = (None, StepReport::default());
        for _ in 0..MOST_ROUNDS_OF_PARTING {
            again.prepare(Piece { start: at, ..Piece::WHOLE }, &Waiting::All);
            let Ok(mut tried) = attempt(again, &plan, self.keep) else { break };
            self.report.add_cost(&tried.report);
            go_to_least_bad(again, &plan, &mut tried)?;
            // If rows contradict each other, a trial without overlap may have thrown bodies far apart.
            let depth = again.start_overlap().max(plan.contact.overlap_tolerance);
            let is_within = tried.report.largest_move <= MOST_MOVE_OF_PARTING * depth * again.bodies() as f64;
            let passes = tried.report.passed.is_some();
            let flies = tried.throws() || passes;
            // A rigid bond off its length would draw its bodies through others.
            if !is_within || (guarded && flies) || (self.plan.has_rigid_bonds && passes) {
                break;
            }
            self.report.phases += again.accept()?;
            moves.add_parting(&tried.report);
            if tried.overlap.error() <= plan.contact.overlap_tolerance {
                left = Some(tried.overlap);
                break;
            }
        }
        again.part(false);
        match left {
            Some(_) => self.report.add_parting(&moves),
            None => again.restore(&before)?,
        }
        self.report.parted |= left.is_some();
        Ok(left)
    }

    /// Takes the best trial of the shortest piece and separates the bodies that still overlap. Daughters that turn at
    /// birth overlap by as much in the shortest piece as in the whole step. Rows made at the start may then contradict
    /// each other although there is room; rows made at the last trial do not. If it fails, `tried` is the best trial
    /// found.
    pub(super) fn squeeze(
        &mut self,
        again: &mut dyn RetryBackend,
        piece: Piece,
        tried: &mut Attempt,
    ) -> Result<Option<Overlap>, Fault> {
        let before = again.state()?.clone();
        let plan = Plan { keeps_least_bad: true, loosens_early: false, ..self.plan.clone() };
        again.prepare(piece, &self.waiting);
        *tried = attempt(again, &plan, self.keep)?;
        self.report.add_cost(&tried.report);
        go_to_least_bad(again, &plan, tried)?;
        // With a larger error, bodies may be separated to the wrong side.
        let near = plan.contact.cutoff.is_some_and(|cutoff| tried.badness() <= cutoff);
        if !near || tried.report.passed.is_some() || tried.throws() {
            return Ok(None);
        }
        self.report.phases += again.accept()?;
        // Walls are at their positions at the piece's end. After the last piece the step is over.
        let at = if piece.ends_step() { 0.0 } else { piece.span * (piece.start + piece.length) };
        let Some(overlap) = self.parted(again, at, true)? else {
            again.restore(&before)?;
            return Ok(None);
        };
        tried.report.squeezed = 1;
        // Separation has corrected the positions; the count of squeezed pieces records it.
        tried.report.velocity_residual = 0.0;
        tried.report.phases = Phases::default();
        self.report.add_piece(&tried.report);
        Ok(Some(overlap))
    }
}
