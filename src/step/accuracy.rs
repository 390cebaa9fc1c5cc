//! How tightly the LCPs of a step are solved, and which overlaps of a trial get a row.
//!
//! In an exact recursion every solve meets the solver's tolerance, and every overlap above the overlap tolerance gets a
//! row, as in the paper. An adaptive one is exact until a trial overlaps grossly, and inexact from there on, in the
//! pieces of the step too. The rest of this is about an inexact one. A solve that others will follow need only show
//! where the smooth surfaces will overlap. What it has left undone, its residual, moves the trial by about as much:
//! overlaps well above it are real and get rows, smaller ones wait for a tighter solve, so no row is spent on them.
//! Each solve is as tight as the overlap seen last warrants. The last one meets the solver's own tolerance, and from
//! there on the recursion is the paper's: rows for what overlaps, at the full tolerance, until nothing does; so its end
//! and its guarantees are the paper's too. No row is ever taken back.

use super::{ContactSettings, Recursion, StepReport};
use crate::step::Overlap;

/// Residual of the first solve, in overlap tolerances. Rods packed in space (1,000, at dt 0.02 and 0.1, whose first
/// trials overlap by 2,000 and 10,000 tolerances) take the same iterations from 100 to 300 within 5 %, and 10 % more
/// from 10; 1,024 crowded cells, whose first trials overlap by some tens, a tenth fewer with 100 than with 10. It is
/// the cutoff at most: a trial that is off by more than the distance of near pairs lets bodies sink into each other,
/// and rows made there may contradict each other. With a tolerance of 0.02 and cells of diameter 0.5 a colony of 32,768
/// stalled on such a step.
const FIRST: f64 = 100.0;

/// An adaptive recursion is inexact from a trial on that overlaps by more than this many tolerances: rows made there
/// are far from the last ones however exact the trial is. Five steps in which 4,096 cells divide take 53 s exactly,
/// 33 s with 1,000, 36 s inexactly; a colony to 1,024 cells takes 234 products a step exactly and adaptively, 245
/// inexactly. In chambers it does not pay: `two-strains` takes 5,735 products a step exactly, 8,161 adaptively.
const GROSS: f64 = 1e3;

/// Residual of the next solve, in parts of the overlap seen last: its rows leave about a tenth of that. Between 0.001
/// and 0.01 the packed rods take the same iterations within a tenth; 0.03 costs them more, as recursions.
const NEXT: f64 = 0.005;

/// The same where rows ask for a part of an overlap more ([`Surplus`](super::surplus::Surplus)): the packed rods take
/// 1,521, 1,366, 1,318 products a step at dt 0.1 with 0.02, 0.005, 0.002; and with [`REAL_OF_CROWDS`] 1,287 with 0.002
/// and 1,310 with 0.001.
const NEXT_OF_CROWDS: f64 = 0.002;

/// The least of these residuals, in overlap tolerances: overlaps of one tolerance then stand out of what is left
/// undone.
const LEAST: f64 = 0.5;

/// A solve of the same rows is at least so much tighter than the one before.
const STRIDE: f64 = 0.1;

/// An overlap is real above so many residuals. The packed rods take 530, 560 and 590 iterations a step at dt 0.02 with
/// 1.5, 2 and 3, and 1,660, 1,800 and 1,850 at 0.1.
const REAL: f64 = 1.5;

/// The same where rows ask for more: 1,320, 1,366 and 2,283 products a step at dt 0.1 with 1.1, 1.5 and 3.
const REAL_OF_CROWDS: f64 = 1.1;

/// Once a trial overlaps by more than the tolerance, so do all pairs from this part of it on get rows: a recursion
/// costs more than a few rows. Without it, the last recursions of a step of the packed rods add one row each.
const ALMOST: f64 = 0.5;

/// Makes the pieces of a step inexact from the start if the step's first trial overlapped grossly.
pub(super) fn expect(contact: &mut ContactSettings, step: &StepReport) {
    if contact.recursion == Recursion::Adaptive && step.first_violation > GROSS * contact.overlap_tolerance {
        contact.recursion = Recursion::Inexact;
    }
}

/// The accuracy of a step's present solve.
pub(super) struct Accuracy {
    exact: bool,
    /// Whether it becomes inexact with the first gross overlap.
    adapts: bool,
    overlap_tolerance: f64,
    /// The solver's own.
    tolerance: f64,
    /// The loosest.
    first: f64,
    residual: f64,
    next: f64,
    real: f64,
}

impl Accuracy {
    /// Of the first solve of a step whose last one is to meet `tolerance`.
    pub fn first(contact: &ContactSettings, tolerance: f64) -> Self {
        let overlap_tolerance = contact.overlap_tolerance;
        let recursive = contact.method.most_recursions(contact.max_recursions) > 0;
        let exact = contact.recursion != Recursion::Inexact || !recursive;
        let first = contact.cutoff.unwrap_or(f64::INFINITY).min(FIRST * overlap_tolerance);
        let residual = if exact { tolerance } else { tolerance.max(first) };
        let adapts = contact.recursion == Recursion::Adaptive && recursive;
        Accuracy { exact, adapts, overlap_tolerance, tolerance, first, residual, next: NEXT, real: REAL }
    }

    /// The residual that the solve is to reach.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// Takes note of whether rows of violations ask for more than touching.
    pub fn over_correct(&mut self, over_corrects: bool) {
        (self.next, self.real) = if over_corrects { (NEXT_OF_CROWDS, REAL_OF_CROWDS) } else { (NEXT, REAL) };
    }

    /// Takes note of what the solve reached: it may have been the tolerance already.
    pub fn reached(&mut self, residual: f64) {
        if residual <= self.tolerance {
            self.residual = self.tolerance;
        }
    }

    /// Takes note of a trial: after a gross overlap the recursion is inexact.
    pub fn see(&mut self, overlap: &Overlap) {
        if self.adapts && overlap.worst > GROSS * self.overlap_tolerance {
            (self.adapts, self.exact) = (false, false);
            self.residual = (self.next * overlap.worst).min(self.first).max(self.tolerance);
        }
    }

    /// The overlap from which on a pair gets a row, if any does.
    pub fn of_rows(&self) -> f64 {
        if self.exact {
            self.overlap_tolerance
        } else {
            (ALMOST * self.overlap_tolerance).max(self.real * self.residual)
        }
    }

    /// Whether a trial shows an overlap that needs a row.
    pub fn shows(&self, overlap: &Overlap) -> bool {
        let real = if self.exact { 0.0 } else { self.real * self.residual };
        overlap.violations > 0 && overlap.worst > self.overlap_tolerance.max(real)
    }

    /// Whether a trial shows bonds that need other rows.
    pub fn shows_stretch(&self, overlap: &Overlap) -> bool {
        let real = if self.exact { 0.0 } else { self.real * self.residual };
        overlap.stretch > self.overlap_tolerance.max(real)
    }

    /// For the solve after rows were appended for the overlaps of a trial.
    pub fn follow(&mut self, overlap: &Overlap) {
        let warranted = (self.next * overlap.error()).max(LEAST * self.overlap_tolerance).max(self.tolerance);
        self.residual = self.residual.min(warranted);
    }

    /// For another solve of the same rows, where their trial shows no overlap that needs one. Says whether there is a
    /// tighter one.
    pub fn tighten(&mut self, overlap: &Overlap) -> bool {
        let least = self.tolerance.max(LEAST * self.overlap_tolerance);
        let last = overlap.error() <= self.overlap_tolerance || self.residual <= least;
        let next =
            if last { self.tolerance } else { least.max((self.next * overlap.error()).min(STRIDE * self.residual)) };
        let tighter = next < self.residual;
        self.residual = self.residual.min(next);
        tighter
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Method, Scene};

    fn overlap(worst: f64) -> Overlap {
        Overlap { worst, violations: usize::from(worst > 0.0), ..Overlap::default() }
    }

    fn contact() -> ContactSettings {
        let contact = Scene::built_in("three-capsules").unwrap().contact;
        ContactSettings { overlap_tolerance: 1e-5, recursion: Recursion::Inexact, ..contact }
    }

    #[test]
    fn every_way_through_a_step_ends_with_the_solvers_tolerance() {
        let tolerances = [1e-9, 1e-6, 8e-6, 1e-5, 1e-2].into_iter();
        for (tolerance, over_corrects) in tolerances.flat_map(|tolerance| [(tolerance, false), (tolerance, true)]) {
            for worst in [0.0, 1e-7, 9e-6, 1.1e-5, 1e-4, 1e-2, f64::INFINITY] {
                let mut accuracy = Accuracy::first(&contact(), tolerance);
                accuracy.over_correct(over_corrects);
                let mut solves = 1;
                while accuracy.tighten(&overlap(worst)) {
                    solves += 1;
                    assert!(accuracy.residual() >= tolerance);
                }
                assert_eq!(accuracy.residual(), tolerance, "{tolerance:e} {worst:e}");
                assert!(solves <= 5, "{tolerance:e} {worst:e}: {solves}");
            }
        }
    }

    #[test]
    fn at_the_solvers_tolerance_every_overlap_above_the_tolerance_gets_a_row() {
        let mut accuracy = Accuracy::first(&contact(), 1e-6);
        assert!(!accuracy.shows(&overlap(1e-3)), "smaller than what the first solve left undone");
        assert!(accuracy.shows(&overlap(1e-2)));
        accuracy.reached(9e-7);
        assert_eq!(accuracy.residual(), 1e-6);
        assert!(accuracy.shows(&overlap(1.01e-5)) && !accuracy.shows(&overlap(1e-5)));
        assert!(accuracy.of_rows() < 1e-5);
    }

    #[test]
    fn an_adaptive_recursion_is_inexact_after_a_gross_overlap_and_so_are_the_pieces_of_its_step() {
        let mut contact = ContactSettings { recursion: Recursion::Adaptive, ..contact() };
        let mut accuracy = Accuracy::first(&contact, 1e-6);
        accuracy.see(&overlap(9e-3));
        assert_eq!((accuracy.residual(), accuracy.of_rows()), (1e-6, 1e-5));
        accuracy.see(&overlap(0.1));
        assert_eq!(accuracy.residual(), NEXT * 0.1);
        accuracy.see(&overlap(0.8));
        assert_eq!(accuracy.residual(), NEXT * 0.1, "a solve of the same rows is never looser");
        assert!(accuracy.tighten(&overlap(0.0)) && accuracy.residual() == 1e-6);
        expect(&mut contact, &StepReport { first_violation: 9e-3, ..StepReport::default() });
        assert_eq!(contact.recursion, Recursion::Adaptive);
        expect(&mut contact, &StepReport { first_violation: 0.8, ..StepReport::default() });
        assert_eq!(contact.recursion, Recursion::Inexact);
        contact.recursion = Recursion::Exact;
        expect(&mut contact, &StepReport { first_violation: 0.8, ..StepReport::default() });
        assert_eq!(contact.recursion, Recursion::Exact);
    }

    #[test]
    fn rows_make_the_next_solve_tighter_never_looser() {
        let mut accuracy = Accuracy::first(&contact(), 1e-6);
        let mut last = accuracy.residual();
        for worst in [1e-1, 1e-2, 1e-4, 1e-1, 1e-5] {
            accuracy.follow(&overlap(worst));
            assert!(accuracy.residual() <= last && accuracy.residual() >= 1e-6);
            last = accuracy.residual();
        }
        assert_eq!(last, LEAST * 1e-5);
    }

    #[test]
    fn a_coarse_overlap_tolerance_does_not_let_the_first_trial_go_through_bodies() {
        let coarse = ContactSettings { overlap_tolerance: 0.02, cutoff: Some(0.05), ..contact() };
        assert_eq!(Accuracy::first(&coarse, 2e-3).residual(), 0.05);
        assert_eq!(Accuracy::first(&coarse, 0.07).residual(), 0.07);
        assert_eq!(
            Accuracy::first(&ContactSettings { cutoff: Some(0.05), ..contact() }, 1e-6).residual(),
            FIRST * 1e-5
        );
    }

    #[test]
    fn an_exact_recursion_and_a_method_without_one_are_solved_tightly_at_once() {
        let exact = ContactSettings { recursion: Recursion::Exact, ..contact() };
        let alone = ContactSettings { method: Method::Snsd, ..contact() };
        for contact in [exact, alone] {
            // The solver's tolerance may be any: rows are for what overlaps by more than the other one.
            for tolerance in [1e-9, 1e-6, 1e-3] {
                let mut accuracy = Accuracy::first(&contact, tolerance);
                accuracy.follow(&overlap(1e-2));
                assert_eq!((accuracy.residual(), accuracy.of_rows()), (tolerance, 1e-5));
                assert!(accuracy.shows(&overlap(1.01e-5)) && !accuracy.shows(&overlap(1e-5)));
                assert!(!accuracy.tighten(&overlap(9e-6)));
            }
        }
    }
}
