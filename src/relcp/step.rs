//! One timestep: Algorithm 1 of the paper, and a step of second order made of two of its solves, each written once for every backend.

use super::accuracy::Accuracy;
use super::{Fault, Keep, StepReport};
use crate::backend::{Backend, Overlap};
use crate::lcp::{Outcome, Status};
use crate::scene::{Contact, Stepping};

/// Recursions of a midpoint step that may move the offsets of its rows, before it appends rows as the paper does. Two ellipsoids at an overlap
/// tolerance of 1e-9 fall to first order with one, and keep the second with two (at 1e-5 one does). Each more costs nothing where it is not needed and a
/// recursion where bodies are crowded: a colony to 32 cells takes 7,219, 8,419, 8,377, 8,049 and 9,968 products with 1, 2, 3, 4 and 8.
const MOST_CORRECTIONS: u32 = 3;

/// Takes one step and says what it did; its last LCP is solved to `tolerance`. A fault leaves the last accepted state. LCPs that `keep`
/// wants are kept there.
pub fn step(
    backend: &mut dyn Backend,
    contact: &Contact,
    tolerance: f64,
    stepping: Stepping,
    keep: &mut Keep,
) -> Result<StepReport, Fault> {
    let mut report = StepReport::default();
    let overlap = match stepping {
        Stepping::Euler => euler(backend, contact, tolerance, keep, &mut report)?,
        Stepping::Midpoint => midpoint(backend, contact, tolerance, keep, &mut report)?,
    };
    report.constraints = backend.constraints();
    report.passed = backend.passed()?;
    report.phases = backend.accept()?; // C^k+1
    report.measure(&overlap, backend.steps(), backend.bodies());
    Ok(report)
}

/// The paper's step.
fn euler(
    backend: &mut dyn Backend,
    contact: &Contact,
    tolerance: f64,
    keep: &mut Keep,
    report: &mut StepReport,
) -> Result<Overlap, Fault> {
    backend.begin()?; // growth, forces, effective mobility, free velocity at C^k
    backend.append_near()?; // A_0: one row a near pair
    let mut accuracy = Accuracy::first(contact, tolerance);
    let mut first_violation = None;
    loop {
        let outcome = keep.solve(backend, accuracy.residual())?; // gamma_n from gamma_n-1, U_n
        report.count(outcome);
        accuracy.reached(outcome.residual);
        let overlap = backend.trial(accuracy.of_rows())?; // C_n+1 = C(U_n), from C^k with the total velocity, every pair looked at
        report.first_violation = *first_violation.get_or_insert(overlap.worst);
        if report.contradicted(contact.overlap_tolerance) {
            return Ok(overlap);
        } else if accuracy.shows(&overlap) && report.may_recurse(contact) {
            backend.append_violations()?; // A_n+1: one more row a violating pair, linearised at C_n+1
            accuracy.follow(&overlap);
            report.recursions += 1;
        } else if !accuracy.tighten(&overlap) {
            return Ok(overlap);
        }
    }
}

/// The midpoint rule: contact forces act along the normals in the middle of the step, `C_h = C(U_h)` after `dt/2`.
///
/// A trial that still overlaps first moves the offsets of rows that keep their direction: always inwards, so no retained row is lost, and the
/// order with it. Rows appended at a trial, along its own normals, end the recursion where that does not.
fn midpoint(
    backend: &mut dyn Backend,
    contact: &Contact,
    tolerance: f64,
    keep: &mut Keep,
    report: &mut StepReport,
) -> Result<Overlap, Fault> {
    backend.begin()?; // as a step of dt/2
    backend.append_near()?;
    report.count(keep.solve(backend, tolerance)?); // U_h
    backend.middle()?; // C_h; forces, effective mobility there, free velocity of the whole step
    backend.append_near()?; // one row a near pair of C_h, linearised there
    report.count(keep.solve(backend, tolerance)?);
    let mut overlap = backend.trial(contact.overlap_tolerance)?; // C_1 = C(U_0) after dt, from C^k
    report.first_violation = overlap.worst;
    while overlap.violations > 0 && report.may_recurse(contact) && !report.contradicted(contact.overlap_tolerance) {
        if report.recursions < MOST_CORRECTIONS {
            backend.tighten_violations()?;
        } else {
            backend.append_violations()?;
        }
        report.count(keep.solve(backend, tolerance)?);
        overlap = backend.trial(contact.overlap_tolerance)?;
        report.recursions += 1;
    }
    Ok(overlap)
}

impl StepReport {
    /// Whether the step may have one more recursion.
    fn may_recurse(&self, contact: &Contact) -> bool {
        self.recursions < contact.method.most_recursions(contact.max_recursions)
    }

    /// Whether the last solve stalled with a row violated by more than `tolerance`: its rows have no common solution, and as rows
    /// are never changed, more of them will not give them one. It happens where a body fits a hole nowhere.
    fn contradicted(&self, tolerance: f64) -> bool {
        let stalled = matches!(self.status, Status::NoProgress | Status::Infeasible | Status::NotFinite);
        stalled && self.residual > tolerance
    }

    /// Adds one solve.
    fn count(&mut self, outcome: Outcome) {
        self.iterations += outcome.iterations;
        self.products += outcome.products;
        self.fallbacks += u32::from(outcome.fallback);
        if outcome.status != Status::Solved {
            self.residual = if self.unconverged > 0 { self.residual.max(outcome.residual) } else { outcome.residual };
            self.unconverged += 1;
            self.status = outcome.status;
        } else if self.unconverged == 0 {
            self.residual = outcome.residual;
        }
    }
}
