//! One timestep: Algorithm 1 of the paper, and a step of second order made of two of its solves, each written once for every backend.

use super::{Fault, Keep, StepReport};
use crate::backend::{Backend, Overlap};
use crate::lcp::{Outcome, Status};
use crate::scene::{Contact, Stepping};

/// Recursions of a midpoint step that may move the offsets of its rows, before it appends rows as the paper does. Two ellipsoids at an overlap
/// tolerance of 1e-9 fall to first order with one, and keep the second with two (at 1e-5 one does). Each more costs nothing where it is not needed and a
/// recursion where bodies are crowded: a colony to 32 cells takes 7,219, 8,419, 8,377, 8,049 and 9,968 products with 1, 2, 3, 4 and 8.
const MOST_CORRECTIONS: u32 = 3;

/// Takes one step and says what it did. A fault leaves the last accepted state. LCPs that `keep` wants are kept there.
pub fn step(
    backend: &mut dyn Backend,
    contact: &Contact,
    stepping: Stepping,
    keep: &mut Keep,
) -> Result<StepReport, Fault> {
    let mut report = StepReport::default();
    let overlap = match stepping {
        Stepping::Euler => euler(backend, contact, keep, &mut report)?,
        Stepping::Midpoint => midpoint(backend, contact, keep, &mut report)?,
    };
    report.constraints = backend.constraints();
    report.phases = backend.accept()?; // C^k+1
    report.measure(&overlap, backend.steps(), backend.bodies());
    Ok(report)
}

/// The paper's step.
fn euler(
    backend: &mut dyn Backend,
    contact: &Contact,
    keep: &mut Keep,
    report: &mut StepReport,
) -> Result<Overlap, Fault> {
    backend.begin()?; // growth, forces, effective mobility, free velocity at C^k
    backend.append_near()?; // A_0: one row a near pair
    report.count(keep.solve(backend, 0)?); // gamma_0, U_0
    let mut overlap = backend.trial()?; // C_1 = C(U_0), every pair looked at
    while report.goes_on(&overlap, contact) {
        backend.append_violations()?; // A_n+1: one more row a violating pair, linearised at C_n+1
        report.count(keep.solve(backend, report.recursions + 1)?); // gamma_n+1 from gamma_n, U_n+1
        overlap = backend.trial()?; // C_n+2 = C(U_n+1), from C^k with the total velocity
        report.recursions += 1;
    }
    Ok(overlap)
}

/// The midpoint rule: contact forces act along the normals in the middle of the step, `C_h = C(U_h)` after `dt/2`.
///
/// A trial that still overlaps first moves the offsets of rows that keep their direction: always inwards, so no retained row is lost, and the
/// order with it. Rows appended at a trial, along its own normals, end the recursion where that does not.
fn midpoint(
    backend: &mut dyn Backend,
    contact: &Contact,
    keep: &mut Keep,
    report: &mut StepReport,
) -> Result<Overlap, Fault> {
    backend.begin()?; // as a step of dt/2
    backend.append_near()?;
    report.count(keep.solve(backend, 0)?); // U_h
    backend.middle()?; // C_h; forces, effective mobility there, free velocity of the whole step
    backend.append_near()?; // one row a near pair of C_h, linearised there
    report.count(keep.solve(backend, 1)?); // the half step's was the first
    let mut overlap = backend.trial()?; // C_1 = C(U_0) after dt, from C^k
    while report.goes_on(&overlap, contact) {
        if report.recursions < MOST_CORRECTIONS {
            backend.tighten_violations()?;
        } else {
            backend.append_violations()?;
        }
        report.count(keep.solve(backend, report.recursions + 2)?);
        overlap = backend.trial()?;
        report.recursions += 1;
    }
    Ok(overlap)
}

impl StepReport {
    /// Whether a trial asks for one more recursion, and may have it.
    fn goes_on(&self, overlap: &Overlap, contact: &Contact) -> bool {
        overlap.violations > 0
            && self.recursions < contact.method.most_recursions(contact.max_recursions)
            && !self.contradicted(contact.overlap_tolerance)
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
        self.residual = self.residual.max(outcome.residual);
        if outcome.status != Status::Solved {
            self.unconverged += 1;
            self.status = outcome.status;
        }
    }
}
