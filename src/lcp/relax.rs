//! Regularized LCPs, for contradictory rows: the least overlap.
//!
//! `0 <= q + A gamma  _|_  gamma >= 0` is replaced by `0 <= q + (A + c S) gamma  _|_  gamma >= 0` with `S` the diagonal
//! of `A`: a compliance `c` relative to each row's own. The solution minimizes `|v|^2 / 2 + sum (violation of row i)^2
//! / (2 c S_ii)` over all velocities `v`, a quadratic penalty. It always exists, its `v` is unique, and no multiplier
//! exceeds its row's violation over `c S_ii` (regularization: R. W. Cottle, J.-S. Pang, R. E. Stone, "The Linear
//! Complementarity Problem", 1992, section 5.6).
//!
//! Consistent rows are violated by `c` times the length by which forces move them, so a small enough `c` satisfies any
//! tolerance. Contradictory rows are violated in the least-squares sense, which a smaller `c` changes little. So `c` is
//! reduced until the violation is allowed, or no longer falls.
//!
//! With bonds, whose rows are equations, the same is solved by the iterations of problems with cones: the
//! interior-point method has no free rows. Their own compliance stays.
//!
//! With friction the exact law may fail to converge where the convex problem with the corrections held does not, and
//! normal rows that contradict each other are shown soonest without friction.

use super::cone::{lack, worse};
use super::engine::Task;
use super::interior_point::{InteriorPoint, MOST_ITERATIONS, Manner};
use super::pair_block_cg::PairBlockCg;
use super::portion::Portion;
use super::solver::Solver;
use super::{Cone, Outcome, Problem, Settings, Status};

/// The compliances `c` to try. In a colony forces move rows by lengths of about 1, so the first leaves about the
/// overlap tolerance of 1e-5 and the second a hundredth of it. For a stack of rods that is too tall by 1e-6, the second
/// leaves 1e-6 to three digits, with ten times the forces of the first.
const COMPLIANCES: [f64; 3] = [1e-5, 1e-7, 1e-9];

/// Before the first solve.
const NOTHING: Outcome = Outcome {
    status: Status::NotFinite,
    iterations: 0,
    products: 0,
    factorizations: 0,
    fallback: false,
    residual: f64::INFINITY,
};

/// Most iterations with corrections held: where normal rows have a common solution, 130 to 1,900 sufficed in crowds.
const MOST_HELD: u64 = 2_000;

/// With friction these solves go on to this part of what is allowed, so that something is left for the compliance.
const OF_ALLOWED: f64 = 0.25;

/// A violation above this part of the last one counts as no longer falling.
const GAIN: f64 = 0.5;

impl<const D: usize, P: Portion<D>> Solver<D, P> {
    /// Solves a problem with the least overlap, from the start `gamma`, which it replaces. If no row is violated by
    /// more than `allowed`, a length, the status is [`Status::LeastOverlap`] and the residual is the largest violation;
    /// otherwise the status is that of the best solve.
    ///
    /// A problem with cones is first solved with De Saxce's corrections held at those of `gamma`: the status is
    /// [`Status::HeldFriction`]. Where that fails too, it is solved without friction: the status is
    /// [`Status::WithoutFriction`] where that succeeds, as friction then is what has no solution.
    ///
    /// # Panics
    /// As [`Solver::solve`].
    pub fn relax(&mut self, problem: &Problem<D>, gamma: &mut Vec<f64>, allowed: f64) -> Outcome {
        gamma.resize(problem.q.len(), 0.0);
        if !problem.cones.is_empty() {
            return self.relax_cones(problem, gamma, allowed);
        }
        self.task.cpu.rebuild(problem);
        P::relax(self, gamma, allowed)
    }

    /// Relaxes the last problem.
    pub(super) fn relax_here(&mut self, gamma: &mut Vec<f64>, allowed: f64) -> Outcome {
        if !self.task.cpu.is_finite() {
            return NOTHING;
        }
        let (mut best, mut found) = (NOTHING, gamma.clone());
        let mut method = InteriorPoint::default();
        for compliance in COMPLIANCES {
            self.task.cpu.set_compliance(compliance);
            let outcome = self.relaxed(&mut method, gamma, allowed);
            log::trace!("compliance {compliance:e}: {outcome:?}");
            best.iterations += outcome.iterations;
            best.factorizations += outcome.factorizations;
            best.products = outcome.products;
            let falls = outcome.residual < GAIN * best.residual;
            if falls {
                (best.status, best.residual) = (outcome.status, outcome.residual);
                self.task.cpu.export(&self.task.drive.at.x, &mut found);
            }
            if !falls || outcome.residual <= allowed {
                break;
            }
        }
        *gamma = found;
        best
    }

    /// [`Solver::relax`] of a problem with cones: with the corrections held at those of `gamma`, else without friction.
    fn relax_cones(&mut self, problem: &Problem<D>, gamma: &mut Vec<f64>, allowed: f64) -> Outcome {
        let settings = self.settings();
        let tolerance = settings.tolerance.min(OF_ALLOWED * allowed);
        self.set_settings(Settings { tolerance, max_iterations: settings.max_iterations.min(MOST_HELD) });
        let mut found = gamma.clone();
        let held = self.solve_held(problem, &mut found);
        self.set_settings(settings);
        log::trace!("friction held: {held:?}");
        if held.residual <= allowed {
            *gamma = found;
            return Outcome { status: Status::HeldFriction, ..held };
        }
        let normal: Vec<usize> = (0..problem.q.len()).filter(|row| problem.cones[*row] != Cone::Tangent).collect();
        let mut smooth = Problem {
            bodies: problem.bodies,
            pair: normal.iter().map(|row| problem.pair[*row]).collect(),
            jacobian: normal.iter().map(|row| problem.jacobian[*row]).collect(),
            q: normal.iter().map(|row| problem.q[*row]).collect(),
            ..Problem::default()
        };
        let mut pushes: Vec<f64> = normal.iter().map(|row| gamma[*row]).collect();
        let mut outcome = if problem.cones.iter().any(|cone| cone.is_free()) {
            let cone = |row: &usize| if problem.cones[*row].is_free() { problem.cones[*row] } else { Cone::Ray };
            smooth.cones = normal.iter().map(cone).collect();
            smooth.compliance = normal.iter().map(|row| problem.compliance.get(*row).copied().unwrap_or(0.0)).collect();
            self.relax_bonded(&smooth, &mut pushes, allowed)
        } else {
            self.relax(&smooth, &mut pushes, allowed)
        };
        log::trace!("without friction: {outcome:?}");
        gamma.fill(0.0);
        normal.iter().zip(&pushes).for_each(|(row, push)| gamma[*row] = *push);
        outcome.iterations += held.iterations;
        outcome.products += held.products;
        if outcome.residual <= allowed && problem.cones.contains(&Cone::Tangent) {
            outcome.status = Status::WithoutFriction;
        }
        outcome
    }

    /// [`Solver::relax`] of a problem of rays and free rows.
    fn relax_bonded(&mut self, problem: &Problem<D>, gamma: &mut Vec<f64>, allowed: f64) -> Outcome {
        let settings = self.settings();
        let tolerance = settings.tolerance.min(OF_ALLOWED * allowed);
        let few = Settings { tolerance, max_iterations: settings.max_iterations.min(MOST_HELD) };
        let (mut best, mut found) = (NOTHING, gamma.clone());
        for compliance in COMPLIANCES {
            let own = |row: usize| problem.jacobian[row].as_flattened().iter().map(|j| j * j).sum::<f64>();
            let soft = |(row, k): (usize, &f64)| k + compliance * own(row);
            let softened =
                Problem { compliance: problem.compliance.iter().enumerate().map(soft).collect(), ..problem.clone() };
            let mut tried = gamma.clone();
            self.set_settings(few);
            let outcome = self.solve_next(&softened, &mut tried);
            self.set_settings(settings);
            let residual = worse(outcome.residual, violation(problem, &tried));
            log::trace!("bonded, compliance {compliance:e}: {residual:.2e}, {outcome:?}");
            let falls = residual < GAIN * best.residual;
            if falls {
                let status = if residual <= allowed { Status::LeastOverlap } else { Status::Infeasible };
                best = Outcome { status, iterations: best.iterations, products: best.products, residual, ..outcome };
                found = tried;
            }
            best.iterations += outcome.iterations;
            best.products += outcome.products;
            if !falls || residual <= allowed {
                break;
            }
        }
        *gamma = found;
        best
    }

    /// Solves a problem regularized with `compliance`, from zero multipliers. A larger compliance moves bodies less.
    ///
    /// # Panics
    /// As [`Solver::solve`], and if the problem has cones.
    pub fn relax_by(&mut self, compliance: f64, problem: &Problem<D>, gamma: &mut Vec<f64>) -> Outcome {
        assert!(problem.cones.is_empty(), "problems with cones are not relaxed");
        gamma.clear();
        gamma.resize(problem.q.len(), 0.0);
        self.task.cpu.rebuild(problem);
        self.task.cpu.set_compliance(compliance);
        let outcome = self.relaxed(&mut InteriorPoint::default(), gamma, f64::INFINITY);
        self.task.cpu.export(&self.task.drive.at.x, gamma);
        outcome
    }

    /// Solves with the present compliance. The residual is the larger of the solve's own and the largest violation.
    fn relaxed(&mut self, method: &mut InteriorPoint<D>, start: &[f64], allowed: f64) -> Outcome {
        let Task { cpu, drive, settings } = &mut self.task;
        cpu.import(start, &mut drive.at.x);
        method.forget();
        let few = Settings { max_iterations: settings.max_iterations.min(MOST_ITERATIONS), ..*settings };
        let (mut status, mut iterations, mut residual) = method.run(cpu, drive, &few, 0.0, Manner::Exact);
        if status == Status::TooLarge {
            (status, iterations, residual) = drive.run(cpu, &mut PairBlockCg::new(), settings, 1);
        }
        residual = residual.max(cpu.compliance_violation(&drive.at.x));
        if residual <= allowed {
            status = Status::LeastOverlap;
        } else if matches!(status, Status::Solved) {
            status = Status::Infeasible;
        }
        let (products, factorizations) = (cpu.products_made(), method.factorizations());
        Outcome { status, iterations, products, factorizations, fallback: false, residual }
    }
}

/// How far these multipliers violate rays and free rows, a length.
fn violation<const D: usize>(problem: &Problem<D>, gamma: &[f64]) -> f64 {
    let v = super::velocity(problem, gamma);
    let of = |row: usize| {
        let gap = problem.value(row, &v) + problem.compliance[row] * gamma[row];
        if problem.cones[row].is_free() { gap.abs() } else { lack(gap) }
    };
    (0..gamma.len()).map(of).fold(0.0, worse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lcp::SolverKind;

    const SETTINGS: Settings = Settings { tolerance: 1e-9, max_iterations: 10_000 };

    /// Bodies in a line between two walls (bodies with zero blocks), each too near the next by `depth`.
    fn squeezed(links: u32, depth: f64) -> Problem<3> {
        let along = |x: f64| [x, 0.0, 0.0];
        let mut problem = Problem { bodies: links as usize + 2, ..Problem::default() };
        for i in 0..=links {
            let block = |body: u32, x: f64| along(if body == 0 || body == links + 1 { 0.0 } else { x });
            problem.pair.push([i, i + 1]);
            problem.jacobian.push([block(i, -1.0), block(i + 1, 1.0)]);
            problem.q.push(-depth);
        }
        problem
    }

    fn relax(problem: &Problem<3>, allowed: f64) -> (Outcome, Vec<f64>) {
        let mut gamma = Vec::new();
        let outcome = Solver::new(SolverKind::Auto, SETTINGS).relax(problem, &mut gamma, allowed);
        (outcome, gamma)
    }

    #[test]
    fn a_stack_that_is_too_tall_shares_the_overlap_evenly_and_stays_where_it_is() {
        let problem = squeezed(7, 1e-6);
        let plain = Solver::new(SolverKind::Auto, SETTINGS).solve(&problem, &mut Vec::new());
        assert_ne!(plain.status, Status::Solved);
        let (outcome, gamma) = relax(&problem, 5e-6);
        assert_eq!(outcome.status, Status::LeastOverlap);
        // Rows between two bodies have twice the mobility of those at walls, and are violated more.
        assert!((outcome.residual - 1e-6).abs() < 2e-7, "{outcome:?}");
        let moved = crate::lcp::velocity(&problem, &gamma);
        assert!(moved.iter().flatten().all(|v| v.abs() < 1e-6), "{moved:?}");
    }

    #[test]
    fn a_stack_that_fits_nowhere_is_not_thrown_anywhere() {
        let problem = squeezed(7, 0.1);
        let (outcome, gamma) = relax(&problem, 5e-6);
        assert_eq!(outcome.status, Status::Infeasible);
        assert!((outcome.residual - 0.1).abs() < 0.02, "{outcome:?}");
        let moved = crate::lcp::velocity(&problem, &gamma);
        assert!(moved.iter().flatten().all(|v| v.abs() < 0.1), "{moved:?}");
        assert!(gamma.iter().all(|gamma| gamma.is_finite()));
    }

    #[test]
    fn rows_that_have_a_solution_are_solved_to_what_is_allowed() {
        let mut problem = squeezed(7, 0.1);
        problem.jacobian[7] = [[0.0; 3]; 2];
        problem.q[7] = 1.0;
        let (outcome, gamma) = relax(&problem, 5e-6);
        assert_eq!(outcome.status, Status::LeastOverlap);
        let mut exact = Vec::new();
        Solver::new(SolverKind::Auto, SETTINGS).solve(&problem, &mut exact);
        let [v, w] = [&gamma, &exact].map(|gamma| crate::lcp::velocity(&problem, gamma));
        let apart = v.iter().zip(&w).map(|(v, w)| (v[0] - w[0]).abs()).fold(0.0, f64::max);
        assert!(apart < 5e-5, "{apart:e}");
    }
}
