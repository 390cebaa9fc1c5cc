//! Every solver on one stored LCP.

use super::{Named, Size, TOLERANCES};
use relcp::gpu::GpuError;
use relcp::internals::freedom::{PLANAR, SPATIAL};
use relcp::internals::lcp::gpu::{self as on_device, DeviceProblem};
use relcp::lcp::{Outcome, ResidualSample, Settings, Solver, Status, Stored};
use relcp::scene::SolverKind;
use relcp::simulation::Compute;
use serde::Serialize;
use std::time::{Duration, Instant};

/// The stored velocity is the reference if the residual of its multipliers is at most this; otherwise a reference is
/// computed. The value is a hundredth of the tightest tolerance of the study.
const REFERENCE: f64 = 1e-8;

/// The tolerance of a reference that is computed here, if it can be reached.
const MADE_TO: f64 = 1e-10;

/// The largest number of iterations of a reference.
const MADE_WITHIN: u64 = 200_000;

/// A solve is repeated until this total time or this number of repeats. The shortest time counts.
const REPEAT_WITHIN: Duration = Duration::from_millis(50);
const REPEATS: usize = 3;

/// The number of points of a curve. More points are indistinguishable in a plot.
const MOST_POINTS: usize = 300;

/// The start of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// From zero multipliers.
    Cold,
    /// From the start that is stored with the LCP.
    Warm,
}

impl Start {
    /// Both.
    pub const BOTH: [Start; 2] = [Start::Cold, Start::Warm];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Start::Cold => "cold",
            Start::Warm => "warm",
        }
    }
}

/// The reference of the velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reference {
    /// The stored velocity.
    Stored,
    /// A velocity that was computed here, because the stored multipliers are not a solution.
    Made,
    /// None: no reference was found.
    None,
}

/// One solve of a stored LCP.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attempt {
    /// The LCP.
    pub lcp: String,
    /// The solver's name in a scene.
    pub solver: String,
    /// The device, or the CPU.
    pub computed_by: String,
    /// Its start.
    pub start: Start,
    /// The tolerance of the residual, a length.
    pub tolerance: f64,
    /// The outcome: `solved`, the reason of a failure, or `refused`.
    pub status: String,
    /// The reason of a refusal.
    pub refused: Option<String>,
    /// Iterations.
    pub iterations: u64,
    /// Applications of `A`.
    pub products: u64,
    /// Milliseconds, including all preparation.
    pub milliseconds: f64,
    /// The recomputed residual of the result, a length.
    pub residual: Option<f64>,
    /// `|v - reference| / |reference|` of the velocities.
    pub velocity_error: Option<f64>,
}

/// Residuals over the products of one solve on the CPU.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// The solver.
    pub solver: String,
    /// Its start.
    pub start: Start,
    /// Numbers of products, and the smallest residual up to each.
    pub points: Vec<(u64, f64)>,
}

/// All results of one LCP.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Instance {
    /// Its name.
    pub lcp: String,
    /// Unknowns per body.
    pub unknowns: usize,
    /// Bodies.
    pub bodies: usize,
    /// Rows.
    pub rows: usize,
    /// Pairs of bodies that have rows.
    pub pairs: usize,
    /// The residual of the stored multipliers.
    pub stored_residual: Option<f64>,
    /// That of the stored start.
    pub start_residual: Option<f64>,
    /// What velocities are compared with.
    pub reference: Reference,
    /// The solves.
    pub attempts: Vec<Attempt>,
    /// Their histories.
    #[serde(skip)]
    pub curves: Vec<Curve>,
}

/// The result of a solver for an LCP.
struct Solved {
    outcome: Outcome,
    gamma: Vec<f64>,
    time: Duration,
    history: Vec<ResidualSample>,
}

/// Solves an LCP by every solver from both starts to all residuals, on each of `computes`.
///
/// # Errors
/// Faults of a device. Unsupported solves are refused and listed.
pub fn measure(named: &Named, computes: &[Compute], size: &Size) -> Result<Instance, GpuError> {
    let lcp = &named.lcp;
    let (reference, velocity) = reference(lcp)?;
    let finite = |x: f64| x.is_finite().then_some(x);
    let mut pairs: Vec<[u32; 2]> = lcp.pair.iter().map(|[a, b]| [*a.min(b), *a.max(b)]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let mut instance = Instance {
        lcp: named.name.clone(),
        unknowns: lcp.unknowns,
        bodies: lcp.bodies,
        rows: lcp.q.len(),
        pairs: pairs.len(),
        stored_residual: finite(lcp.residual(&lcp.gamma)),
        start_residual: finite(lcp.residual(&lcp.start)),
        reference,
        attempts: Vec::new(),
        curves: Vec::new(),
    };
    for compute in computes {
        for (solver, kind) in super::solvers() {
            for start in Start::BOTH {
                let mut last: Option<Attempt> = None;
                for tolerance in TOLERANCES {
                    let settings = Settings { tolerance, max_iterations: size.iterations };
                    let attempt = match last.filter(|last| last.settles(tolerance)) {
                        Some(last) => Attempt { tolerance, ..last },
                        None => {
                            let large = kind == SolverKind::Dense && lcp.q.len() > size.rows_of_dense;
                            let solved = match large {
                                true => Err(format!("too large, it is given at most {} rows", size.rows_of_dense)),
                                false => solve(lcp, kind, start, settings, compute)?,
                            };
                            if let Ok(Solved { history, .. }) = &solved {
                                instance.draw(&solver, start, history);
                            }
                            let what = Attempt::new(&named.name, &solver, compute, start, tolerance);
                            match solved {
                                Ok(solved) => attempt(what, lcp, &solved, velocity.as_deref()),
                                Err(refused) => Attempt { refused: Some(refused), ..what },
                            }
                        }
                    };
                    last = Some(attempt.clone());
                    instance.attempts.push(attempt);
                }
            }
        }
    }
    Ok(instance)
}

impl Attempt {
    fn new(lcp: &str, solver: &str, compute: &Compute, start: Start, tolerance: f64) -> Self {
        Attempt {
            lcp: lcp.into(),
            solver: solver.into(),
            computed_by: computed_by(compute),
            start,
            tolerance,
            status: "refused".into(),
            refused: None,
            iterations: 0,
            products: 0,
            milliseconds: 0.0,
            residual: None,
            velocity_error: None,
        }
    }

    /// Returns whether a solve with this tighter tolerance would take the same iterations: if this solve did not reach
    /// its own tolerance, or has already reached the tighter one.
    fn settles(&self, tolerance: f64) -> bool {
        self.status != Status::Solved.name() || self.residual.is_some_and(|residual| residual <= tolerance)
    }
}

impl Instance {
    /// Stores a history. It replaces the history of a looser tolerance, which it continues.
    fn draw(&mut self, solver: &str, start: Start, history: &[ResidualSample]) {
        if !history.is_empty() {
            self.curves.retain(|curve| (curve.solver.as_str(), curve.start) != (solver, start));
            self.curves.push(Curve { solver: solver.into(), start, points: thinned(history) });
        }
    }
}

fn attempt(what: Attempt, lcp: &Stored, solved: &Solved, reference: Option<&[f64]>) -> Attempt {
    let finite = |x: f64| x.is_finite().then_some(x);
    let error = reference.and_then(|reference| finite(error(&velocity(lcp, &solved.gamma), reference)));
    Attempt {
        status: solved.outcome.status.name().into(),
        iterations: solved.outcome.iterations,
        products: solved.outcome.products,
        milliseconds: 1e3 * solved.time.as_secs_f64(),
        residual: finite(lcp.residual(&solved.gamma)),
        velocity_error: error,
        ..what
    }
}

/// Returns the name of the backend.
pub(super) fn computed_by(compute: &Compute) -> String {
    match compute {
        Compute::Gpu { gpu, precision } => format!("{} {}", gpu.name(), precision.name()),
        _ => "CPU f64".into(),
    }
}

fn solve(
    lcp: &Stored,
    kind: SolverKind,
    start: Start,
    settings: Settings,
    compute: &Compute,
) -> Result<Result<Solved, String>, GpuError> {
    match lcp.unknowns {
        PLANAR => solve_with::<PLANAR>(lcp, kind, start, settings, compute),
        _ => solve_with::<SPATIAL>(lcp, kind, start, settings, compute),
    }
}

fn solve_with<const D: usize>(
    lcp: &Stored,
    kind: SolverKind,
    start: Start,
    settings: Settings,
    compute: &Compute,
) -> Result<Result<Solved, String>, GpuError> {
    let Some(problem) = lcp.problem::<D>() else { return Ok(Err(format!("{} unknowns a body", lcp.unknowns))) };
    let start = match start {
        Start::Cold => vec![0.0; problem.q.len()],
        Start::Warm => lcp.start.clone(),
    };
    let begun = Instant::now();
    let mut best: Option<Solved> = None;
    for _ in 0..REPEATS {
        let solved = match compute {
            Compute::Gpu { gpu, precision } => {
                let solve = || {
                    let mut solver = on_device::Solver::new(gpu, *precision, D == PLANAR, kind, settings)?;
                    let (mut device, order) = DeviceProblem::upload(gpu, *precision, &problem, &start)?;
                    let begun = Instant::now();
                    let outcome = solver.solve(gpu, &mut device)?;
                    let time = begun.elapsed();
                    let gamma = device.download_gamma(gpu, *precision, &order)?;
                    Ok::<Solved, GpuError>(Solved { outcome, gamma, time, history: Vec::new() })
                };
                match solve() {
                    Ok(solved) => solved,
                    Err(fault @ GpuError::Unsupported { .. }) => return Ok(Err(fault.to_string())),
                    Err(fault) => return Err(fault),
                }
            }
            _ => {
                let mut solver = Solver::new(kind, settings);
                solver.keep_history();
                let mut gamma = start.clone();
                let begun = Instant::now();
                let outcome = solver.solve(&problem, &mut gamma);
                let time = begun.elapsed();
                Solved { outcome, gamma, time, history: solver.history().to_vec() }
            }
        };
        if best.as_ref().is_none_or(|best| solved.time < best.time) {
            best = Some(solved);
        }
        if begun.elapsed() > REPEAT_WITHIN {
            break;
        }
    }
    Ok(best.ok_or_else(|| "it was not run".into()))
}

/// Returns the reference velocity.
fn reference(lcp: &Stored) -> Result<(Reference, Option<Vec<f64>>), GpuError> {
    if lcp.residual(&lcp.gamma) <= REFERENCE {
        return Ok((Reference::Stored, Some(lcp.velocity.clone())));
    }
    let settings = Settings { tolerance: MADE_TO, max_iterations: MADE_WITHIN };
    Ok(match solve(lcp, SolverKind::Auto, Start::Warm, settings, &Compute::Cpu)? {
        Ok(made) if lcp.residual(&made.gamma) <= REFERENCE => (Reference::Made, Some(velocity(lcp, &made.gamma))),
        _ => (Reference::None, None),
    })
}

fn velocity(lcp: &Stored, gamma: &[f64]) -> Vec<f64> {
    let mut v = vec![0.0; lcp.bodies * lcp.unknowns];
    for (row, pair) in lcp.pair.iter().enumerate() {
        for (body, blocks) in pair.iter().zip(&lcp.rows) {
            let block = &blocks[row * lcp.unknowns..(row + 1) * lcp.unknowns];
            let v = &mut v[*body as usize * lcp.unknowns..];
            v.iter_mut().zip(block).for_each(|(v, j)| *v += j * gamma[row]);
        }
    }
    v
}

/// `|v - reference| / |reference|`; the plain difference where the reference is zero.
fn error(v: &[f64], reference: &[f64]) -> f64 {
    let norm = |numbers: &mut dyn Iterator<Item = f64>| numbers.map(|x| x * x).sum::<f64>().sqrt();
    let difference = norm(&mut v.iter().zip(reference).map(|(a, b)| a - b));
    let size = norm(&mut reference.iter().copied());
    if size > 0.0 { difference / size } else { difference }
}

/// Returns a history as the smallest residual so far, at points that are spaced about evenly in the logarithm of the
/// products.
fn thinned(history: &[ResidualSample]) -> Vec<(u64, f64)> {
    let mut points: Vec<(u64, f64)> = Vec::new();
    let last = history.last().map_or(1, |look| look.products.max(1)) as f64;
    let factor = last.powf(1.0 / MOST_POINTS as f64);
    let (mut best, mut next) = (f64::INFINITY, 0.0);
    for (i, look) in history.iter().enumerate() {
        best = best.min(look.residual);
        if look.products as f64 >= next || i + 1 == history.len() {
            points.push((look.products, best));
            next = look.products as f64 * factor;
        }
    }
    points.retain(|(_, residual)| residual.is_finite());
    points
}

#[cfg(test)]
mod tests;
