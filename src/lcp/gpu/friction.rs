//! Problems over friction cones on the device: `pair_block_cg` with corrections that follow, as on the CPU
//! (`lcp::friction`). An element of a vector is a contact: its normal row and its tangent rows.

use super::layout::{Slots, Variant, rows_of_contact};
use super::machine::Machine;
use super::number::Number;
use super::problem::DeviceProblem;
use super::verbs::{Device, Slot};
use crate::gpu::{Gpu, GpuError, Precision};
use crate::lcp::drive::{Drive, Method, Point, Progress};
use crate::lcp::friction::packed::PackedContacts;
use crate::lcp::friction::{ITERATIONS_TO_HALVE, PACE_OF_PAIRS, Pace};
use crate::lcp::pair_block_cg::PairBlockCg;
use crate::lcp::verbs::{Scalar, Verbs};
use crate::lcp::{Cone, Outcome, Problem, Settings};

/// A residual greater than any other.
const BEYOND: f64 = 1e30;

/// A solver of problems with friction on a device. It keeps its buffers from one problem to the next.
pub struct FrictionSolver {
    machine: Machine,
    settings: Settings,
}

/// A contact of two bodies that are pushed together and slide.
fn pressed<const D: usize>() -> Problem<D> {
    let block = |along: usize, sign: f64| std::array::from_fn(|k| if k == along { sign } else { 0.0 });
    let rows = rows_of_contact(D == 3) as usize;
    Problem {
        bodies: 2,
        pair: vec![[0, 1]; rows],
        jacobian: (0..rows).map(|row| [block(row, 1.0), block(row, -1.0)]).collect(),
        q: (0..rows).map(|row| if row == 0 { -1.0 } else { 2.0 }).collect(),
        cones: (0..rows).map(|row| if row == 0 { Cone::Friction(0.5) } else { Cone::Tangent }).collect(),
        ..Problem::default()
    }
}

/// `pair_block_cg` whose corrections follow.
pub(super) struct Following {
    inner: PairBlockCg<Slot, Number>,
    pace: Option<Pace<Number>>,
    least: Number,
}

impl FrictionSolver {
    /// A solver of planar or spatial problems.
    ///
    /// # Errors
    /// [`GpuError::NoF64`], [`GpuError::Limit`].
    pub fn new(gpu: &Gpu, precision: Precision, planar: bool, settings: Settings) -> Result<Self, GpuError> {
        let variant = Variant::of(gpu, precision, planar, Slots::of_friction());
        Ok(FrictionSolver { machine: Machine::new(gpu, variant)?, settings })
    }

    /// Compiles the kernels by iterations on a small problem, so that no solve waits for a compiler.
    ///
    /// # Errors
    /// As [`FrictionSolver::solve`].
    pub fn compile(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        match self.machine.planar() {
            true => self.iterate_on(gpu, &pressed::<3>()),
            false => self.iterate_on(gpu, &pressed::<6>()),
        }
    }

    /// Iterates for more than two batches. No residual is negative.
    fn iterate_on<const D: usize>(&mut self, gpu: &Gpu, problem: &Problem<D>) -> Result<(), GpuError> {
        let normal = Problem {
            bodies: problem.bodies,
            pair: problem.pair[..1].to_vec(),
            jacobian: problem.jacobian[..1].to_vec(),
            q: problem.q[..1].to_vec(),
            ..Problem::default()
        };
        let (uploaded, _) = DeviceProblem::upload(gpu, self.machine.precision(), &normal, &[])?;
        let mut contacts = PackedContacts::default();
        contacts.push(problem, &[], 0);
        let iterations = self.machine.looks.iter().sum::<usize>() as u64 + 1;
        let settings = Settings { tolerance: -1.0, max_iterations: iterations };
        let settings = std::mem::replace(&mut self.settings, settings);
        let solved = self.solve(gpu, &uploaded, &contacts);
        self.settings = settings;
        solved.map(|_| ())
    }

    /// Sets the stopping criteria for subsequent problems.
    pub fn set_settings(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// The stopping criteria.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Solves a problem whose rows are the normal rows of contacts, from their multipliers. Returns those found, four
    /// numbers a contact; the problem's `velocity` is computed from them.
    ///
    /// # Errors
    /// The fault that the device reported; [`GpuError::Limit`] if the problem is too large for it.
    pub fn solve(
        &mut self,
        gpu: &Gpu,
        problem: &DeviceProblem,
        contacts: &PackedContacts,
    ) -> Result<(Outcome, Vec<f64>), GpuError> {
        let FrictionSolver { machine, settings } = self;
        machine.write_contacts(gpu, contacts)?;
        machine.tolerance = settings.tolerance;
        let mut device = Device::new(gpu, machine, problem);
        device.prepare();
        let mut drive = Drive::default();
        drive.at.x = device.start();
        let mut method = Following::new();
        let mut halved = (0, f64::INFINITY);
        let goes_on = |_: &Device<'_>, _: &Point<Slot>, Progress { iterations, least, .. }: Progress| {
            if least <= 0.5 * halved.1 {
                halved = (iterations, least);
            }
            iterations - halved.0 < ITERATIONS_TO_HALVE
        };
        let (status, iterations, residual) = drive.run_while(&mut device, &mut method, settings, 1, goes_on);
        device.finish(&drive.at.x)?;
        let products = device.products();
        let gammas = machine.read_gammas(gpu, problem)?;
        Ok((Outcome { status, iterations, products, factorizations: 0, fallback: false, residual }, gammas))
    }
}

impl Following {
    pub fn new() -> Self {
        Following { inner: PairBlockCg::new(), pace: None, least: Number::Known(BEYOND) }
    }
}

impl<'a> Method<Device<'a>> for Following {
    fn begin(&mut self, device: &mut Device<'a>, at: &Point<Slot>) {
        self.inner.begin(device, at);
        // Scalars of iterations that were dropped have no values.
        self.pace = Some(Pace::new(PACE_OF_PAIRS, true, |x| device.number(x)));
        self.least = device.number(BEYOND);
    }

    fn step(&mut self, device: &mut Device<'a>, at: &mut Point<Slot>) {
        if let (Some(pace), Some((law, measured))) = (&mut self.pace, device.measured()) {
            self.least = self.least.min(law);
            let due = pace.turn(measured, self.least, Number::Tolerance);
            device.follow(due, &mut at.g);
        }
        self.inner.step(device, at);
    }

    fn refresh(&mut self, device: &mut Device<'a>, at: &mut Point<Slot>) -> bool {
        self.inner.refresh(device, at)
    }
}
