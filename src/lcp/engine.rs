//! The solvers as engines: each solves a task from its present iterate.

use super::apgd::Apgd;
use super::auto::Auto;
use super::bbpgd::Bbpgd;
use super::cluster_cg::ClusterCg;
use super::cpu::Cpu;
use super::dense::Dense;
use super::drive::{Drive, Progress};
use super::interior_point::{InteriorPoint, Manner};
use super::pair_block_cg::PairBlockCg;
use super::portion::Portion;
use super::projected_gauss_seidel::ProjectedGaussSeidel;
use super::projected_jacobi::ProjectedJacobi;
use super::team::{self, Team};
use super::{Outcome, Settings, SolverKind, Status};

/// Gauss-Seidel sweeps between two checks of the residual; a check costs one more product.
const SWEEPS: u64 = 4;

/// The problem and iterate of an engine.
pub(super) struct Task<const D: usize, P> {
    /// The problem.
    pub cpu: Cpu<D, P>,
    /// The iterate.
    pub drive: Drive<Vec<f64>>,
    /// When to stop.
    pub settings: Settings,
}

/// A solver with its state.
pub(super) enum Engine<const D: usize, P: Portion<D>> {
    Auto(Box<Auto<D>>),
    ProjectedJacobi(ProjectedJacobi<Vec<f64>>),
    ProjectedGaussSeidel(ProjectedGaussSeidel<D>),
    Apgd(Apgd<Cpu<D, P>>),
    Bbpgd(Bbpgd<Cpu<D, P>>),
    /// With a team of threads, if its sums support them.
    PairBlockCg(PairBlockCg<Vec<f64>, f64>, Option<Team>),
    ClusterCg(ClusterCg<Vec<f64>, f64>),
    Dense(Dense),
    InteriorPoint(Box<InteriorPoint<D>>),
}

impl<const D: usize, P: Portion<D>> Engine<D, P> {
    pub fn new(kind: SolverKind, settings: &Settings) -> Self {
        match kind {
            SolverKind::Auto => Engine::Auto(Box::new(Auto::to(settings.tolerance))),
            SolverKind::ProjectedJacobi => Engine::ProjectedJacobi(ProjectedJacobi::default()),
            SolverKind::ProjectedGaussSeidel => Engine::ProjectedGaussSeidel(ProjectedGaussSeidel::default()),
            SolverKind::Apgd => Engine::Apgd(Apgd::new()),
            SolverKind::Bbpgd => Engine::Bbpgd(Bbpgd::new()),
            SolverKind::PairBlockCg => Engine::PairBlockCg(PairBlockCg::new(), Some(Team::default())),
            SolverKind::ClusterCg => Engine::ClusterCg(ClusterCg::to(settings.tolerance)),
            SolverKind::Dense => Engine::Dense(Dense::default()),
            SolverKind::InteriorPoint => Engine::InteriorPoint(Box::default()),
        }
    }

    /// Tunes it for problems with many nearly parallel rows.
    pub fn for_parallel_rows(&mut self) {
        match self {
            Engine::Auto(auto) => auto.for_parallel_rows(),
            Engine::PairBlockCg(_, team) => *team = None,
            _ => {}
        }
    }

    /// Drops the state from the last problem.
    pub fn forget(&mut self) {
        if let Engine::Auto(auto) = self {
            auto.forget();
        }
    }

    /// Solves the task. If it `goes_on`, the problem is the last one and continues from its last iterate.
    pub fn solve(&mut self, task: &mut Task<D, P>, goes_on: bool) -> Outcome {
        let Task { cpu, drive, settings } = &mut *task;
        let (status, iterations, residual) = match self {
            Engine::Auto(auto) if goes_on => return auto.resume(task),
            Engine::Auto(auto) => return auto.solve(task),
            _ if !cpu.is_finite() => (Status::NotFinite, 0, f64::INFINITY),
            Engine::ProjectedJacobi(method) => {
                cpu.find_majorant();
                drive.run(cpu, method, settings, 1)
            }
            Engine::ProjectedGaussSeidel(method) => drive.run(cpu, method, settings, SWEEPS),
            Engine::Apgd(method) => drive.run(cpu, method, settings, 1),
            Engine::Bbpgd(method) => drive.run(cpu, method, settings, 1),
            Engine::PairBlockCg(method, team) => {
                let pauses = |progress: Progress| progress.iterations.is_multiple_of(team::ROUND);
                team::run(team, cpu, drive, method, settings, &pauses, |_, _, _| true)
            }
            Engine::ClusterCg(method) => {
                method.aim_at(settings.tolerance);
                drive.run(cpu, method, settings, 1)
            }
            Engine::Dense(method) => method.run(cpu, &mut drive.at, settings),
            // As in the driver: small multipliers of the last step do not make a start a solution.
            Engine::InteriorPoint(method) => method.run(cpu, drive, settings, 0.0, Manner::Exact),
        };
        let factorizations = match self {
            Engine::InteriorPoint(method) => method.factorizations(),
            _ => 0,
        };
        let products = task.cpu.products_made();
        Outcome { status, iterations, products, factorizations, fallback: false, residual }
    }
}
