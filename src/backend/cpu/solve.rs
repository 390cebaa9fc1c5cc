//! The solves of a step.

use super::row_set::RowSet;
use crate::lcp::{Outcome, Places, Portion, Settings, Solver, Status};
use crate::step::{Model, Rows};

/// A solver, and what it has done in this step.
pub(super) struct Solve<const D: usize, P: Portion<D>> {
    solver: Solver<D, P>,
    /// The scene's.
    settings: Settings,
    rows: Rows,
    /// Whether there was a solve in this step, and the residual that the last one left.
    solved: bool,
    residual: f64,
    /// Solves with friction in this step that failed.
    failures: u32,
}

/// After this many failures with friction in a step, whose rows are then hard, a solve has only this many iterations
/// before its corrections are held.
const MOST_FAILURES: u32 = 3;
const ITERATIONS_OF_HARD_ROWS: u64 = 200;

impl<const D: usize, P: Portion<D>> Solve<D, P> {
    pub(super) fn new(model: &Model) -> Self {
        let solver = Solver::with_portions(model.solver, model.lcp);
        let rows = model.contact.rows_of_method();
        let solver = match rows {
            Rows::Auto => solver,
            Rows::Paper => solver.for_parallel_rows(),
        };
        let settings = solver.settings();
        Solve { solver, settings, rows, solved: false, residual: 0.0, failures: 0 }
    }

    /// Begins a step with this body order and this portion of the rows.
    pub(super) fn begin(&mut self, places: Places, portion: P) {
        (self.solved, self.failures) = (false, 0);
        if self.rows == Rows::Auto {
            self.solver.place(places, portion);
        }
    }

    /// The tolerance of the last solve, a length.
    pub(super) fn tolerance(&self) -> f64 {
        self.solver.settings().tolerance
    }

    /// The residual of the last solve, a length.
    pub(super) fn residual(&self) -> f64 {
        self.residual
    }

    /// The number of rows of the last problem, over all processes.
    pub(super) fn all_rows(&self) -> usize {
        self.solver.all_rows()
    }

    /// Solves from the present multipliers, continuing the last solve if nothing changed.
    pub(super) fn solve(&mut self, rows: &mut RowSet<D>, tolerance: f64) -> Outcome {
        let frictional = rows.is_frictional();
        let is_hard = frictional && self.failures >= MOST_FAILURES;
        let most = if is_hard { ITERATIONS_OF_HARD_ROWS } else { u64::MAX };
        let max_iterations = self.settings.max_iterations.min(most);
        self.solver.set_settings(Settings { tolerance, max_iterations });
        let first = !std::mem::replace(&mut self.solved, true);
        let same = !rows.take_changed() && self.rows == Rows::Auto;
        let outcome = match (first, same) {
            (true, _) => self.solver.solve(&rows.problem, &mut rows.gamma),
            (false, true) => self.solver.resume(&mut rows.gamma),
            (false, false) => self.solver.solve_next(&rows.problem, &mut rows.gamma),
        };
        self.residual = outcome.residual;
        // What follows a failure has all iterations.
        self.solver.set_settings(Settings { tolerance, ..self.settings });
        self.failures += u32::from(frictional && outcome.status != Status::Solved);
        outcome
    }

    /// Takes note of a solve by a device, to this tolerance.
    #[cfg(feature = "gpu")]
    pub(super) fn take_solved(&mut self, outcome: &Outcome, tolerance: f64) {
        self.solver.set_settings(Settings { tolerance, ..self.settings });
        (self.solved, self.residual) = (false, outcome.residual);
    }

    /// Solves the regularized LCP with violations up to `allowed`, if the result is better than that of the last solve.
    /// Where it is not, the multipliers stay.
    pub(super) fn relax(&mut self, rows: &mut RowSet<D>, allowed: f64) -> Option<Outcome> {
        let mut relaxed = rows.gamma.clone();
        let outcome = self.solver.relax(&rows.problem, &mut relaxed, allowed);
        let gamma = rows.change_gamma();
        if self.residual.is_finite() && outcome.residual >= self.residual {
            // Normal rows that contradict each other do so with friction too. Its solves are cut off before they show
            // it.
            let contradict = rows.is_frictional() && outcome.status == Status::Infeasible;
            return contradict.then_some(Outcome { residual: self.residual, ..outcome });
        }
        *gamma = relaxed;
        Some(outcome)
    }

    pub(super) fn relax_by(&mut self, rows: &mut RowSet<D>, compliance: f64) -> Outcome {
        rows.change_gamma();
        self.solver.relax_by(compliance, &rows.problem, &mut rows.gamma)
    }
}
