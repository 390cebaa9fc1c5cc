//! `summary.json`: the summary of a run, for other programs.

use super::memory::peak_bytes;
use super::way;
use crate::gpu::Precision;
use crate::record::{
    Leg, OverStep, PassedStep, Retried, Totals, UnconvergedStep, UnsettledStep, WallSeconds, state_hash,
};
use crate::scene::{Method, SolverKind, Stepping, StopReason};
use crate::simulation::Simulation;
use crate::step::Fault;
use serde::{Deserialize, Serialize};

/// The status of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RunStatus {
    /// It reached its end, and every step met its tolerances.
    Done,
    /// It reached its end; some step, or the final state measured again, did not meet its tolerances.
    OutOfTolerance,
    /// It was stopped before its end and can be resumed.
    Interrupted,
    /// A step could not meet its tolerances; the run ended with the state before it.
    Stopped,
    /// A step failed, in a run of an earlier version.
    Fault,
}

impl RunStatus {
    /// Whether a step failed: the run does not continue by itself.
    pub fn is_stopped(self) -> bool {
        matches!(self, RunStatus::Stopped | RunStatus::Fault)
    }
}

/// Sum, mean and largest of a count over the steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Recursions {
    /// The mean per step.
    pub mean: f64,
    /// The largest of a step.
    pub max: u32,
    /// The sum over all steps.
    pub total: u64,
}

/// Rows of the steps' last LCPs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Constraints {
    /// Those of the last step.
    #[serde(rename = "final")]
    pub last: u64,
    /// The mean per step.
    pub mean: f64,
    /// The largest of a step.
    pub max: u64,
}

/// The work of the LCP solver.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SolverSummary {
    /// The solver that the scene selects.
    pub kind: SolverKind,
    /// Iterations over all solves.
    pub iterations: u64,
    /// Applications of `A` over all solves.
    pub products: u64,
    /// Solves that used the safeguard of `auto`.
    pub fallbacks: u64,
    /// The largest final residual of a solve, a length; null if it was not finite.
    pub worst_residual: f64,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u64,
    /// The first steps with such a solve.
    pub unconverged_steps: Vec<UnconvergedStep>,
}

/// What friction did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrictionSummary {
    /// How far a mean contact slips elastically before it slides, a length.
    pub elastic_slip: f64,
    /// The energy that it took over all steps, with what the springs of stick took up.
    pub work: f64,
    /// Solves in which its law was not met to the solver's tolerance, so that its corrections were held.
    pub held_solves: u64,
    /// The largest gap that it left at a contact that pushes, a length.
    pub largest_gap: f64,
}

/// The peak memory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PeakBytes {
    /// By this process, before it draws the picture; null if the system does not report it.
    pub host: Option<u64>,
    /// On a device; null without one.
    pub device: Option<u64>,
}

/// The summary of a run. Lengths are in the scene's unit; a length that was not finite is null.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The scene's name.
    pub name: String,
    /// The status of the run.
    pub status: RunStatus,
    /// Whether it reached its end.
    pub completed: bool,
    /// Which part of the scene's `growth.stop` ended it before `time.end`; null if none did.
    pub stopped_by: Option<StopReason>,
    /// Why it is out of tolerance or stopped, in one word; null if it is neither. [`Totals::reason`] and
    /// [`Fault::name`] list them; `final_overlap` if all steps met the tolerance and the final state does not.
    pub reason: Option<String>,
    /// The same in a sentence; null if no step was refused.
    pub message: Option<String>,
    /// Warnings about the scene and its steps.
    pub warnings: Vec<String>,
    /// `relcp`, `snsd` or `multisphere`.
    pub method: &'static str,
    /// `euler` or `midpoint`.
    pub stepping: Stepping,
    /// The backend of the last step: `cpu` or `gpu`.
    pub backend: &'static str,
    /// Its device; null on the CPU.
    pub adapter: Option<String>,
    /// The precision of the computation.
    pub precision: &'static str,
    /// Which backend computed which steps: one entry per start or resumption of the run.
    pub legs: Vec<Leg>,
    /// Threads of the run that wrote this file.
    pub threads: usize,
    /// The program's version.
    pub version: &'static str,
    /// [Hash](super::scene_hash) of the scene.
    pub scene_hash: String,
    /// [Hash](crate::record::state_hash) of the run's last state.
    pub state_hash: String,
    /// Bodies now.
    pub bodies: usize,
    /// The number of bodies that each rule of the scene's `removal` has removed, in order; absent without rules.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub removed: Vec<u64>,
    /// Accepted steps, including those before a resumption.
    pub steps: u64,
    /// Time after them.
    pub time: f64,
    /// Step size.
    pub dt: f64,
    /// The seed of all random numbers.
    pub seed: u64,
    /// Largest overlap that a step may leave.
    pub overlap_tolerance: f64,
    /// Largest overlap of the start.
    pub start_max_overlap: f64,
    /// Largest overlap of smooth surfaces that a step left.
    pub max_overlap: f64,
    /// Largest overlap of the run's last state, recomputed from it.
    pub final_max_overlap: f64,
    /// Largest overlap of sub-spheres that a step left; null if the method has none.
    pub proxy_max_overlap: Option<f64>,
    /// Steps that left more than the overlap tolerance.
    pub steps_over_tolerance: u64,
    /// The first of them.
    pub first_over_tolerance: Vec<OverStep>,
    /// Steps in which bodies tunnelled.
    pub steps_passed: u64,
    /// The first of them.
    pub first_passed: Vec<PassedStep>,
    /// Steps whose solves have a residual above the overlap tolerance.
    pub steps_unsettled: u64,
    /// The first of them.
    pub first_unsettled: Vec<UnsettledStep>,
    /// The largest displacement of a body's centre by contact from its free motion in a step.
    pub largest_move: f64,
    /// The largest displacement of a body in a step by its velocity, in its own thicknesses, over the recorded states.
    pub farthest_way: f64,
    /// The largest separation of a contact that pushed at the end of a step.
    pub largest_push_gap: f64,
    /// The most energy that contact added in a step; zero without inertia.
    pub largest_contact_energy: f64,
    /// The largest angle by which contact turned a body of revolution about its own axis in a step.
    pub largest_axial_spin: f64,
    /// Steps with rows that were rebuilt because they pushed bodies that no longer touched.
    pub steps_loosened: u64,
    /// Friction; absent in a scene without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionSummary>,
    /// Bonds that broke; absent without any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub broken_bonds: Option<u64>,
    /// Repeated steps.
    pub retried: Retried,
    /// Recursions per step after the first solve: mean, largest, total.
    pub recursions: Recursions,
    /// Rows.
    pub constraints: Constraints,
    /// The LCP solver.
    pub solver: SolverSummary,
    /// Wall time by phase, over all resumptions.
    pub wall_seconds: WallSeconds,
    /// The peak memory.
    pub peak_bytes: PeakBytes,
}

/// The name of a method in scenes.
fn method_name(method: Method) -> &'static str {
    match method {
        Method::Relcp => "relcp",
        Method::Snsd => "snsd",
        Method::Multisphere { .. } => "multisphere",
    }
}

/// The reason of a run whose steps all met the tolerance, but whose recomputed last state does not.
const FINAL_OVERLAP: &str = "final_overlap";

/// The largest difference of two ways to compute a separation in the run's precision: the bound of the tests of
/// separations on a device, relative to the sizes.
fn rounding(simulation: &Simulation) -> Result<f64, Fault> {
    let part = if simulation.precision() == Precision::F32 { 2e-6 } else { 1e-11 };
    let shapes = &simulation.state()?.bodies.shape;
    Ok(2.0 * part * shapes.iter().map(|shape| shape.bounding_radius()).fold(0.0, f64::max))
}

impl Summary {
    /// The summary of a simulation and the totals of its steps; `final_max_overlap` is
    /// [`max_overlap`](crate::step::max_overlap) of its state.
    ///
    /// # Errors
    /// As [`Simulation::state`].
    pub(crate) fn new(
        simulation: &Simulation,
        totals: &Totals,
        scene_hash: &str,
        (status, stopped): (RunStatus, Option<&Fault>),
        final_max_overlap: f64,
    ) -> Result<Self, Fault> {
        let (scene, state) = (simulation.scene(), simulation.state()?);
        let device = simulation.device();
        let ends_over = totals.steps > 0 && final_max_overlap > scene.contact.overlap_tolerance + rounding(simulation)?;
        let status = if status == RunStatus::Done && ends_over { RunStatus::OutOfTolerance } else { status };
        let missed = || totals.reason().or(ends_over.then_some(FINAL_OVERLAP));
        let mean = |sum: u64| if totals.steps == 0 { 0.0 } else { sum as f64 / totals.steps as f64 };
        Ok(Summary {
            name: scene.name.clone(),
            status,
            completed: simulation.done(),
            stopped_by: simulation.stopped_by(),
            reason: stopped.map(Fault::name).or_else(missed).map(str::to_owned),
            message: stopped.map(Fault::to_string),
            warnings: way::warnings(scene, totals),
            method: method_name(scene.contact.method),
            stepping: scene.time.stepping,
            backend: simulation.machine(),
            adapter: device.map(|gpu| format!("{} ({})", gpu.name(), gpu.driver())),
            precision: simulation.precision().name(),
            legs: totals.legs.clone(),
            threads: rayon::current_num_threads(),
            version: env!("CARGO_PKG_VERSION"),
            scene_hash: scene_hash.into(),
            state_hash: state_hash(state),
            bodies: state.bodies.len(),
            removed: (0..scene.removal.len()).map(|i| state.removed.get(i).copied().unwrap_or(0)).collect(),
            steps: state.step,
            time: simulation.time(),
            dt: scene.time.dt,
            seed: scene.seed,
            overlap_tolerance: scene.contact.overlap_tolerance,
            start_max_overlap: totals.start_max_overlap,
            max_overlap: totals.max_overlap,
            final_max_overlap,
            proxy_max_overlap: totals.proxy_overlap,
            steps_over_tolerance: totals.steps_over_tolerance,
            first_over_tolerance: totals.over.clone(),
            steps_passed: totals.steps_passed,
            first_passed: totals.passed.clone(),
            steps_unsettled: totals.steps_unsettled,
            first_unsettled: totals.unsettled.clone(),
            largest_move: totals.largest_move,
            farthest_way: totals.farthest_way,
            largest_push_gap: totals.largest_push_gap,
            largest_contact_energy: totals.largest_contact_energy,
            largest_axial_spin: totals.largest_axial_spin,
            steps_loosened: totals.steps_loosened,
            friction: (!scene.friction().is_none()).then(|| FrictionSummary {
                elastic_slip: scene.elastic_slip_in(simulation.precision()),
                work: totals.friction_work,
                held_solves: totals.friction_held,
                largest_gap: totals.largest_friction_gap,
            }),
            broken_bonds: Some(totals.broken_bonds.max(state.bodies.broken_bonds.len() as u64))
                .filter(|broken| *broken > 0),
            retried: totals.retried,
            recursions: Recursions {
                mean: mean(totals.recursions),
                max: totals.max_recursions,
                total: totals.recursions,
            },
            constraints: Constraints {
                last: totals.final_constraints,
                mean: mean(totals.constraints),
                max: totals.max_constraints,
            },
            solver: SolverSummary::new(scene.solver.kind, totals),
            wall_seconds: totals.wall,
            peak_bytes: PeakBytes { host: peak_bytes(), device: device.map(crate::gpu::Gpu::peak_bytes) },
        })
    }
}

impl SolverSummary {
    fn new(kind: SolverKind, totals: &Totals) -> Self {
        SolverSummary {
            kind,
            iterations: totals.iterations,
            products: totals.products,
            fallbacks: totals.fallbacks,
            worst_residual: totals.worst_residual,
            unconverged: totals.unconverged,
            unconverged_steps: totals.unconverged_steps.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    /// Even if all steps met the tolerance, the last state, measured again, decides.
    #[test]
    fn a_run_whose_final_state_overlaps_is_out_of_tolerance() {
        let simulation = Simulation::new(Scene::built_in("three-capsules").unwrap()).unwrap();
        let totals = Totals { steps: 1, ..Totals::default() };
        assert!(totals.clean());
        let ended = |overlap: f64| {
            let summary = Summary::new(&simulation, &totals, "", (RunStatus::Done, None), overlap).unwrap();
            (summary.status, summary.reason)
        };
        let allowed = simulation.scene().contact.overlap_tolerance;
        assert_eq!(ended(0.5 * allowed), (RunStatus::Done, None));
        assert_eq!(ended(2.0 * allowed), (RunStatus::OutOfTolerance, Some("final_overlap".into())));
    }
}
