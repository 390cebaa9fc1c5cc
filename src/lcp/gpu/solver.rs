//! The common entry point to the solvers on the device.

use super::layout::{LOOKS, Slots, Variant};
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
use crate::lcp::{Outcome, Problem, Settings, SolverKind, Status};

/// A solver of LCPs on a device. It keeps its buffers from one problem to the next.
pub struct Solver {
    kind: SolverKind,
    settings: Settings,
    machine: Machine,
    /// Whether the kernels of small problems are compiled, and those of large ones.
    compiled: [bool; 2],
}

/// The fraction of the largest small problem from which a scene is expected to need the kernels of large problems too:
/// crowded bodies have about three rows each, and slots for more pairs.
const SOON_LARGE: u64 = 4;

impl Solver {
    /// Whether the device supports a solver.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for solvers that process the rows one by one.
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

    /// A solver of a kind, for planar or spatial problems; [`SolverKind::Auto`] is `pair_block_cg`, without a fallback.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for solvers that process the rows one by one, [`GpuError::NoF64`],
    /// [`GpuError::Kernel`].
    pub fn new(
        gpu: &Gpu,
        precision: Precision,
        planar: bool,
        kind: SolverKind,
        settings: Settings,
    ) -> Result<Self, GpuError> {
        Solver::check(kind)?;
        let machine = Machine::new(gpu, Variant::of(gpu, precision, planar, Slots::of(kind, precision)))?;
        Ok(Solver { kind, settings, machine, compiled: [false; 2] })
    }

    /// Compiles the kernels for this many bodies, unless this was done before, so that no solve waits for a compiler.
    /// It iterates on a small problem until no new kernels can occur.
    ///
    /// # Errors
    /// As [`Solver::solve`].
    pub fn compile(&mut self, gpu: &Gpu, bodies: u64) -> Result<(), GpuError> {
        let largest = self.machine.largest_small;
        for (large, needed) in [(false, largest > 0), (true, bodies.saturating_mul(SOON_LARGE) > largest)] {
            if needed && !std::mem::replace(&mut self.compiled[usize::from(large)], true) {
                self.machine.largest_small = if large { 0 } else { u64::MAX };
                let compiled = self.iterate_on_chain(gpu);
                self.machine.largest_small = largest;
                compiled?;
            }
        }
        Ok(())
    }

    /// Iterates on a chain of three bodies for more than two batches. It does not converge, because no residual is
    /// negative.
    fn iterate_on_chain(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let precision = self.machine.precision();
        let mut problem = match self.machine.planar() {
            true => DeviceProblem::upload(gpu, precision, &chain::<3>(), &[])?.0,
            false => DeviceProblem::upload(gpu, precision, &chain::<6>(), &[])?.0,
        };
        let iterations = self.machine.looks.iter().sum::<usize>() as u64 + 1;
        let settings = Settings { tolerance: -1.0, max_iterations: iterations };
        let settings = std::mem::replace(&mut self.settings, settings);
        let outcome = self.solve(gpu, &mut problem);
        self.settings = settings;
        outcome.map(|_| ())
    }

    /// The stopping criteria.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Sets the stopping criteria for subsequent problems.
    pub fn set_settings(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Sets the largest number of rows and bodies of a problem that one workgroup solves.
    pub fn set_largest_small(&mut self, largest: u64) {
        self.machine.largest_small = largest;
    }

    /// Sets how many residuals are read at once: in the first batch of a solve, and later. The bits of a result do not
    /// depend on it.
    pub fn set_looks(&mut self, looks: [usize; 2]) {
        self.machine.looks = looks.map(|looks| looks.clamp(1, LOOKS as usize - 1));
    }

    /// Solves a problem. `gamma` becomes the solution, or the best iterate found, which is never worse than the start;
    /// `velocity` is computed from it.
    ///
    /// # Errors
    /// The fault that the device reported; [`GpuError::Limit`] if the problem is too large for it.
    pub fn solve(&mut self, gpu: &Gpu, problem: &mut DeviceProblem) -> Result<Outcome, GpuError> {
        check(problem, self.machine.planar())?;
        if problem.rows == 0 {
            return without_rows(gpu, problem, self.machine.precision());
        }
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
}

/// The solution without rows: all velocities are zero. It requires no wait for the device.
fn without_rows(gpu: &Gpu, problem: &DeviceProblem, precision: Precision) -> Result<Outcome, GpuError> {
    let numbers = if problem.planar { 4 } else { 8 };
    let mut record = gpu.record();
    record.stage("lcp-no-rows");
    record.clear(&problem.velocity, 0..problem.bodies * numbers * precision.bytes() as u64);
    record.submit()?;
    let (status, residual) = (Status::Solved, 0.0);
    Ok(Outcome { status, iterations: 0, products: 0, factorizations: 0, fallback: false, residual })
}

/// Three bodies in a row that are pushed together, with two rows for the first pair.
fn chain<const D: usize>() -> Problem<D> {
    let row = |push: f64| {
        let block = |sign: f64| std::array::from_fn(|k| sign * push / (k + 1) as f64);
        [block(1.0), block(-1.0)]
    };
    Problem {
        bodies: 3,
        pair: vec![[0, 1], [0, 1], [1, 2]],
        jacobian: vec![row(1.0), row(0.9), row(1.1)],
        q: vec![-1.0, -0.8, -0.7],
        ..Problem::default()
    }
}

/// Checks that the dimension is that of the kernels, and that numbers of rows fit in an entry.
fn check(problem: &DeviceProblem, planar: bool) -> Result<(), GpuError> {
    if problem.planar != planar {
        return Err(GpuError::Unsupported { what: "solver for both planar and spatial problems".into() });
    }
    if [2 * problem.rows, problem.pairs, problem.bodies].iter().any(|n| *n >= u64::from(u32::MAX)) {
        return Err(GpuError::Unsupported { what: format!("problem of {} rows", problem.rows) });
    }
    Ok(())
}
