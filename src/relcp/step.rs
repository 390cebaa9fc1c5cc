//! One timestep: Algorithm 1 of the paper, written once for every backend.

use super::{Fault, StepReport};
use crate::backend::Backend;
use crate::lcp::{Outcome, Status};
use crate::scene::Contact;

/// Takes one step and says what it did. A fault leaves the last accepted state.
pub fn step(backend: &mut dyn Backend, contact: &Contact) -> Result<StepReport, Fault> {
    let mut report = StepReport::default();
    backend.begin()?; // growth, forces, effective mobility, free velocity at C^k
    backend.append_near()?; // A_0: one row a near pair
    report.count(backend.solve()?); // gamma_0, U_0
    let mut overlap = backend.trial()?; // C_1 = C(U_0), every pair looked at
    while overlap.violations > 0
        && report.recursions < contact.method.most_recursions(contact.max_recursions)
        && !report.contradicted(contact.overlap_tolerance)
    {
        backend.append_violations()?; // A_n+1: one more row a violating pair, linearised at C_n+1
        report.count(backend.solve()?); // gamma_n+1 from gamma_n, U_n+1
        overlap = backend.trial()?; // C_n+2 = C(U_n+1), from C^k with the total velocity
        report.recursions += 1;
    }
    report.constraints = backend.constraints();
    report.phases = backend.accept()?; // C^k+1
    report.measure(&overlap, backend.steps(), backend.bodies());
    Ok(report)
}

impl StepReport {
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
