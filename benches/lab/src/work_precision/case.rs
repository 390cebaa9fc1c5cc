//! The runs of the study and their results.

use super::pose::{Apart, poses};
use super::problem::Problem;
use super::reference::Reference;
use crate::StudyError;
use crate::machine::processor;
use crate::paper::method_name;
use relcp::scene::{Method, Scene, Stepping};
use relcp::simulation::{Compute, Simulation};
use relcp::step::StepReport;
use serde::Serialize;
use std::time::{Duration, Instant};

/// The overlap tolerance if only steps are refined: that of the paper, which is also the default of scenes.
pub const OVERLAP_TOLERANCE: f64 = 1e-5;

/// Tolerances of the sweep, from coarse to fine.
const TOLERANCES: [f64; 6] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];

/// The tightest tolerance for 32-bit numbers: a unit in the last place of a coordinate of 8 is 1e-6.
const TIGHTEST_F32: f64 = 1e-5;

/// The coarsest tolerance of runs that refine it with their steps.
const COARSEST_TOLERANCE: f64 = 1e-3;

/// The largest number of halvings of the coarsest step: to a thousandth of it, 50,000 to 100,000 steps.
const MOST_HALVINGS: u32 = 10;

/// A short run is repeated until this total time or this number of repeats. The shortest time counts.
const REPEAT_WITHIN: Duration = Duration::from_millis(100);
const REPEATS: usize = 5;

/// The parameter that differs between the runs of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sweep {
    /// The step, at one overlap tolerance.
    Step,
    /// The step, and the overlap tolerance at the rate at which the scheme's error falls.
    Both,
    /// The overlap tolerance, at one step.
    Tolerance,
}

/// A planned run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// The contact method.
    pub method: Method,
    /// The scheme.
    pub stepping: Stepping,
    /// What it is one of.
    pub sweep: Sweep,
    /// Steps.
    pub steps: u64,
    /// The overlap tolerance.
    pub overlap_tolerance: f64,
}

/// The number of runs of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Steps of ReLCP by the paper's step, each half of the last.
    pub euler: u32,
    /// The same by midpoint steps.
    pub midpoint: u32,
    /// Steps of LCP-SNSD by either.
    pub snsd: u32,
    /// Steps of LCP-MS, of each count of sub-spheres.
    pub multisphere: u32,
    /// Counts of sub-spheres.
    pub spheres: usize,
    /// Tolerances of the sweep.
    pub tolerances: u32,
    /// Halvings of the coarsest step at which that is made.
    pub tolerances_at: u32,
    /// Runs that refine steps and tolerances together, by either step.
    pub both: u32,
}

impl Size {
    /// All runs of a problem.
    pub fn cases(&self, problem: &Problem) -> Vec<Case> {
        let steps = move |halvings: u32| problem.coarsest << halvings;
        let refined = |method: Method, stepping: Stepping, count: u32| {
            (0..count).map(move |k| Case {
                method,
                stepping,
                sweep: Sweep::Step,
                steps: steps(k),
                overlap_tolerance: OVERLAP_TOLERANCE,
            })
        };
        let both = |stepping: Stepping| {
            // An error of first order needs four times the steps where one of second order needs twice.
            let halvings = if stepping == Stepping::Euler { 2 } else { 1 };
            (0..self.both).take_while(move |k| halvings * k <= MOST_HALVINGS).map(move |k| Case {
                method: Method::Relcp,
                stepping,
                sweep: Sweep::Both,
                steps: steps(halvings * k),
                overlap_tolerance: COARSEST_TOLERANCE * 0.25f64.powi(k.cast_signed()),
            })
        };
        let tolerances = |stepping: Stepping| {
            TOLERANCES.iter().take(self.tolerances as usize).map(move |tolerance| Case {
                method: Method::Relcp,
                stepping,
                sweep: Sweep::Tolerance,
                steps: steps(self.tolerances_at),
                overlap_tolerance: *tolerance,
            })
        };
        let mut cases: Vec<Case> = refined(Method::Relcp, Stepping::Euler, self.euler).collect();
        cases.extend(refined(Method::Relcp, Stepping::Midpoint, self.midpoint));
        for stepping in [Stepping::Euler, Stepping::Midpoint] {
            cases.extend(both(stepping));
        }
        for stepping in [Stepping::Euler, Stepping::Midpoint] {
            cases.extend(tolerances(stepping));
        }
        for stepping in [Stepping::Euler, Stepping::Midpoint] {
            cases.extend(refined(Method::Snsd, stepping, self.snsd));
        }
        for count in problem.spheres.iter().take(self.spheres) {
            cases.extend(refined(Method::Multisphere { count: *count }, Stepping::Euler, self.multisphere));
        }
        cases
    }
}

impl Case {
    /// Returns whether a device can perform it with this precision.
    ///
    /// # Errors
    /// As [`Problem::scene`].
    pub fn suits(&self, problem: &Problem, compute: &Compute) -> Result<bool, StudyError> {
        let Compute::Gpu { precision, .. } = compute else { return Ok(true) };
        let tight = precision.bytes() == 4 && self.overlap_tolerance < TIGHTEST_F32;
        Ok(!tight && Compute::check(&self.scene(problem)?).is_ok())
    }

    /// The curve that it is on.
    pub fn curve(&self) -> String {
        let stepping = if self.stepping == Stepping::Midpoint { ", midpoint" } else { "" };
        let sweep = match self.sweep {
            Sweep::Step => String::new(),
            Sweep::Both => ", tolerance with dt".into(),
            Sweep::Tolerance => format!(", tolerance at {} steps", self.steps),
        };
        format!("{}{stepping}{sweep}", method_name(self.method))
    }

    pub(super) fn scene(&self, problem: &Problem) -> Result<Scene, StudyError> {
        let mut scene = problem.scene()?;
        scene.time.dt = problem.end / self.steps as f64;
        scene.time.stepping = self.stepping;
        scene.contact.method = self.method;
        scene.contact.overlap_tolerance = self.overlap_tolerance;
        Ok(scene)
    }
}

/// A line of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The scene.
    pub problem: &'static str,
    /// The contact method.
    pub method: String,
    /// The scheme.
    pub stepping: Stepping,
    /// The parameter that differs between the runs of its curve.
    pub sweep: Sweep,
    /// Its curve.
    pub curve: String,
    /// The backend: the CPU and its threads, or a device, and the precision.
    pub computed_by: String,
    /// The processor or the device, by its name.
    pub machine: String,
    /// The step.
    pub dt: f64,
    /// Steps.
    pub steps: u64,
    /// The overlap tolerance.
    pub overlap_tolerance: f64,
    /// The larger of the next two; `None` if the run ends with other bodies than the reference.
    pub error: Option<f64>,
    /// Root mean square of the distances of the centres at the end to the reference's, over the scene's length.
    pub position_error: Option<f64>,
    /// Root mean square of the angles of the axes to the reference's, radians.
    pub angle_error: Option<f64>,
    /// Whether the error is so large that the error of the reference is negligible.
    pub certain: bool,
    /// The order at which the error fell from the run before on its curve.
    pub order: Option<f64>,
    /// The largest overlap of smooth surfaces after any step, a length.
    pub max_overlap: f64,
    /// Applications of `A`.
    pub products: u64,
    /// Iterations of the solver.
    pub iterations: u64,
    /// Recursions.
    pub recursions: u64,
    /// Rows of the last LCP of a step, on average.
    pub constraints: f64,
    /// Wall time of all steps, seconds.
    pub wall_seconds: f64,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u64,
}

impl Row {
    /// Whether ReLCP missed its overlap tolerance, or a solve missed its own.
    pub fn missed(&self) -> bool {
        self.unconverged > 0 || (self.method == method_name(Method::Relcp) && self.max_overlap > self.overlap_tolerance)
    }
}

/// Performs a run and measures its end. A short run is repeated for its time.
///
/// # Errors
/// [`StudyError`] where a step cannot be taken.
pub fn run(problem: &Problem, reference: &Reference, case: &Case, compute: &Compute) -> Result<Row, StudyError> {
    let begun = Instant::now();
    let (mut row, error) = once(problem, reference, case, compute)?;
    for _ in 1..REPEATS {
        if begun.elapsed() > REPEAT_WITHIN {
            break;
        }
        row.wall_seconds = row.wall_seconds.min(once(problem, reference, case, compute)?.0.wall_seconds);
    }
    row.error = error.map(|error| error.worst());
    (row.position_error, row.angle_error) = (error.map(|error| error.position), error.map(|error| error.angle));
    row.certain = row.error.is_none_or(|error| reference.settles(error));
    Ok(row)
}

fn once(
    problem: &Problem,
    reference: &Reference,
    case: &Case,
    compute: &Compute,
) -> Result<(Row, Option<Apart>), StudyError> {
    let scene = case.scene(problem)?;
    let (bodies, dt) = (scene.build()?, scene.time.dt);
    let begun = Instant::now();
    let mut simulation = Simulation::builder(scene).bodies(bodies).on(compute).build()?;
    let (computed_by, machine) = by(&simulation);
    let mut row = Row {
        problem: problem.name,
        method: method_name(case.method),
        stepping: case.stepping,
        sweep: case.sweep,
        curve: case.curve(),
        computed_by,
        machine,
        dt,
        steps: 0,
        overlap_tolerance: case.overlap_tolerance,
        error: None,
        position_error: None,
        angle_error: None,
        certain: false,
        order: None,
        max_overlap: 0.0,
        products: 0,
        iterations: 0,
        recursions: 0,
        constraints: 0.0,
        wall_seconds: 0.0,
        unconverged: 0,
    };
    while !simulation.done() {
        row.count(&simulation.step()?);
    }
    row.constraints /= row.steps.max(1) as f64;
    let end = poses(&simulation.state()?.bodies);
    row.wall_seconds = begun.elapsed().as_secs_f64();
    Ok((row, reference.error(&end)))
}

impl Row {
    fn count(&mut self, report: &StepReport) {
        self.steps += 1;
        self.max_overlap = self.max_overlap.max(report.max_overlap);
        self.products += report.products;
        self.iterations += report.iterations;
        self.recursions += u64::from(report.recursions);
        self.constraints += report.constraints as f64;
        self.unconverged += u64::from(report.unconverged);
    }
}

/// Returns the backend of a simulation and its name.
fn by(simulation: &Simulation) -> (String, String) {
    match simulation.device() {
        Some(gpu) => {
            let software = if gpu.is_software() { ", a software adapter" } else { "" };
            let kind = format!("GPU {}{software}", simulation.precision().name());
            (kind, gpu.name().to_owned())
        }
        None => {
            let threads = rayon::current_num_threads();
            let name = processor().unwrap_or_else(|| "a processor that does not say its name".into());
            (format!("CPU f64, {threads} threads"), name)
        }
    }
}
