//! One door to the solvers on the device.

use super::kernels::Variant;
use super::layout::{LOOKS, Slots};
use super::machine::Machine;
use super::problem::DeviceProblem;
use super::verbs::Device;
use crate::gpu::{Gpu, GpuError, Precision};
use crate::lcp::apgd::Apgd;
use crate::lcp::bbpgd::Bbpgd;
use crate::lcp::cluster_cg::ClusterCg;
use crate::lcp::drive::{Drive, Method};
use crate::lcp::pair_block_cg::PairBlockCg;
use crate::lcp::projected_jacobi::ProjectedJacobi;
use crate::lcp::verbs::Verbs;
use crate::lcp::{Outcome, Settings, SolverKind, Status};

/// A solver of LCPs on a device. It keeps its buffers from one problem to the next.
pub struct Solver {
    kind: SolverKind,
    settings: Settings,
    machine: Machine,
}

impl Solver {
    /// Whether there is a solver of a kind here.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for kinds that look at the rows one by one.
    pub fn check(kind: SolverKind) -> Result<(), GpuError> {
        let what = match kind {
            SolverKind::ProjectedGaussSeidel => "solver projected_gauss_seidel",
            SolverKind::Dense => "solver dense",
            SolverKind::InteriorPoint => "solver interior_point",
            SolverKind::Auto
            | SolverKind::ProjectedJacobi
            | SolverKind::Apgd
            | SolverKind::Bbpgd
            | SolverKind::PairBlockCg
            | SolverKind::ClusterCg => return Ok(()),
        };
        Err(GpuError::Unsupported { what: what.into() })
    }

    /// A solver of a kind; [`SolverKind::Auto`] is as on the CPU. It solves planar problems, or others.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for kinds that look at the rows one by one, [`GpuError::NoF64`], [`GpuError::Kernel`].
    pub fn new(
        gpu: &Gpu,
        precision: Precision,
        planar: bool,
        kind: SolverKind,
        settings: Settings,
    ) -> Result<Self, GpuError> {
        Solver::check(kind)?;
        let machine = Machine::new(gpu, Variant { precision, planar, slots: Slots::of(kind, precision) })?;
        Ok(Solver { kind, settings, machine })
    }

    /// When the solver stops.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Stops elsewhere from the next problem on.
    pub fn set_settings(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Problems with at most so many rows, pairs and bodies are solved by one workgroup from now on.
    pub fn set_largest_small(&mut self, largest: u64) {
        self.machine.largest_small = largest;
    }

    /// Reads the residuals of so many iterations at once from now on: first, and later in a solve. The bits of a result do
    /// not depend on it.
    pub fn set_looks(&mut self, looks: [usize; 2]) {
        self.machine.looks = looks.map(|looks| looks.clamp(1, LOOKS as usize - 1));
    }

    /// Solves a problem: `gamma` becomes the solution, or the best iterate found, never worse than the start, and
    /// `velocity` belongs to it.
    ///
    /// # Errors
    /// The fault that the device reported; [`GpuError::Limit`] where the problem is too large for it.
    pub fn solve(&mut self, gpu: &Gpu, problem: &mut DeviceProblem) -> Result<Outcome, GpuError> {
        match self.kind {
            SolverKind::ProjectedJacobi => self.solve_by(gpu, problem, ProjectedJacobi::default()),
            SolverKind::Apgd => self.solve_by(gpu, problem, Apgd::new()),
            SolverKind::Bbpgd => self.solve_by(gpu, problem, Bbpgd::new()),
            SolverKind::Auto | SolverKind::PairBlockCg => self.solve_by(gpu, problem, PairBlockCg::new()),
            SolverKind::ClusterCg => self.solve_by(gpu, problem, ClusterCg::to(self.settings.tolerance)),
            kind @ (SolverKind::ProjectedGaussSeidel | SolverKind::Dense | SolverKind::InteriorPoint) => {
                Err(Solver::check(kind).err().unwrap_or(GpuError::Unsupported { what: "such solver".into() }))
            }
        }
    }

    fn solve_by<'a>(
        &'a mut self,
        gpu: &'a Gpu,
        problem: &'a DeviceProblem,
        mut method: impl Method<Device<'a>>,
    ) -> Result<Outcome, GpuError> {
        check(problem, self.machine.planar())?;
        let settings = self.settings;
        let mut device = Device::new(gpu, &mut self.machine, problem);
        device.prepare();
        let mut drive = Drive::default();
        drive.at.x = device.start();
        let (status, iterations, mut residual) = drive.run(&mut device, &mut method, &settings, 1);
        device.finish(&drive.at.x)?;
        if status == Status::NotFinite && iterations == 0 {
            residual = f64::INFINITY;
        }
        Ok(Outcome { status, iterations, products: device.products(), factorizations: 0, fallback: false, residual })
    }

    /// Computes `velocity` from `gamma`, of which what is not finite or negative counts as zero.
    ///
    /// # Errors
    /// As [`Solver::solve`].
    pub fn velocity(&mut self, gpu: &Gpu, problem: &mut DeviceProblem) -> Result<(), GpuError> {
        check(problem, self.machine.planar())?;
        let mut device = Device::new(gpu, &mut self.machine, problem);
        device.prepare();
        let x = device.start();
        device.finish(&x)
    }
}

/// The dimension must be the kernels', and numbers of rows must fit an entry.
fn check(problem: &DeviceProblem, planar: bool) -> Result<(), GpuError> {
    if problem.planar != planar {
        return Err(GpuError::Unsupported { what: "solver for both planar and spatial problems".into() });
    }
    if [2 * problem.rows, problem.pairs, problem.bodies].iter().any(|n| *n >= u64::from(u32::MAX)) {
        return Err(GpuError::Unsupported { what: format!("problem of {} rows", problem.rows) });
    }
    Ok(())
}
