//! What a run did so far: the sums and extremes of its steps' reports, which a checkpoint carries on.

use super::Leg;
use crate::simulation::Simulation;
use crate::step::{Passed, Phases, StepReport};
use serde::{Deserialize, Deserializer, Serialize};
use std::time::Duration;

/// How many of the steps that did not meet a tolerance are named; the others are counted.
const NAMED: usize = 10;

/// Wall time by phase, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WallSeconds {
    /// All of the run, over its resumptions.
    pub total: f64,
    /// Finding candidate pairs.
    pub broad_phase: f64,
    /// Separations, rows, violations.
    pub narrow_phase: f64,
    /// The LCPs.
    pub solve: f64,
    /// Forces, mobilities, trial configurations.
    pub integrate: f64,
    /// Growth and division.
    pub growth: f64,
    /// Writing files, the check of the final state, and its picture.
    pub output: f64,
    /// Placing the bodies, or reading the checkpoint.
    pub setup: f64,
}

impl WallSeconds {
    fn add(&mut self, phases: &Phases) {
        self.broad_phase += phases.broad_phase.as_secs_f64();
        self.narrow_phase += phases.narrow_phase.as_secs_f64();
        self.solve += phases.solve.as_secs_f64();
        self.integrate += phases.integrate.as_secs_f64();
        self.growth += phases.growth.as_secs_f64();
    }

    /// The phases by name, without the total.
    pub fn phases(&self) -> [(&'static str, f64); 7] {
        [
            ("broad phase", self.broad_phase),
            ("narrow phase", self.narrow_phase),
            ("solve", self.solve),
            ("integrate", self.integrate),
            ("growth", self.growth),
            ("output", self.output),
            ("setup", self.setup),
        ]
    }
}

/// A step that left a larger overlap than the scene tolerates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OverStep {
    /// Its number, from 1.
    pub step: u64,
    /// The overlap that it left, a length.
    #[serde(deserialize_with = "or_infinite")]
    pub max_overlap: f64,
    /// The pair of bodies that overlaps by it.
    pub pair: Option<[usize; 2]>,
    /// The body and the wall that overlap by it, if they do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall: Option<[usize; 2]>,
}

/// A step in which bodies went through each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassedStep {
    /// Its number, from 1.
    pub step: u64,
    /// How many pairs did.
    pub pairs: usize,
    /// The first of them.
    pub pair: [usize; 2],
}

/// A step with a solve that did not reach the solver's tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnconvergedStep {
    /// Its number, from 1.
    pub step: u64,
    /// Its largest residual, a length.
    #[serde(deserialize_with = "or_infinite")]
    pub residual: f64,
}

/// A step whose velocities come from a solve that is not right to the overlap tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnsettledStep {
    /// Its number, from 1.
    pub step: u64,
    /// What its velocities times `dt` may be off by, a length.
    #[serde(deserialize_with = "or_infinite")]
    pub residual: f64,
}

/// Steps that did not go at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Retried {
    /// Steps of which some attempt failed.
    pub steps: u64,
    /// Those that were cut into pieces.
    pub in_pieces: u64,
    /// Most pieces of a step.
    pub most_pieces: u32,
    /// Those that the CPU took for a device.
    pub by_cpu: u64,
    /// Those with a piece that was taken as well as it went, and then parted in no time.
    #[serde(default)]
    pub squeezed: u64,
    /// Those in which daughters turned less than they drew, as there was no room.
    #[serde(default)]
    pub turned_less: u64,
    /// Those in which cells had to wait for room.
    pub with_waiting_cells: u64,
    /// Attempts that failed, over all steps.
    pub failed_attempts: u64,
    /// Solves in the sense of the least overlap.
    pub relaxed_solves: u64,
    /// Steps whose rows that contradict each other were tilted.
    #[serde(default)]
    pub tilted: u64,
}

impl Retried {
    fn add(&mut self, report: &StepReport) {
        self.steps += u64::from(report.failed_attempts > 0);
        self.in_pieces += u64::from(report.pieces > 1);
        self.most_pieces = self.most_pieces.max(report.pieces);
        self.by_cpu += u64::from(report.by_cpu);
        self.squeezed += u64::from(report.squeezed > 0);
        self.turned_less += u64::from(report.turned_less > 0);
        self.with_waiting_cells += u64::from(report.waiting > 0);
        self.failed_attempts += u64::from(report.failed_attempts);
        self.relaxed_solves += u64::from(report.relaxed);
        self.tilted += u64::from(report.tilts > 0);
    }
}

/// Sums and extremes over the steps of a run. JSON has no infinity: a length that is not finite is null.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Totals {
    /// Steps taken.
    pub steps: u64,
    /// Largest overlap of the start, a length.
    #[serde(deserialize_with = "or_infinite")]
    pub start_max_overlap: f64,
    /// Largest overlap that a step left, a length.
    #[serde(deserialize_with = "or_infinite")]
    pub max_overlap: f64,
    /// Largest overlap of sub-spheres that a step left, where the method has them.
    pub proxy_overlap: Option<f64>,
    /// Steps that left more than the overlap tolerance.
    pub steps_over_tolerance: u64,
    /// The first of them.
    pub over: Vec<OverStep>,
    /// Steps in which bodies went through each other.
    #[serde(default)]
    pub steps_passed: u64,
    /// The first of them.
    #[serde(default)]
    pub passed: Vec<PassedStep>,
    /// Steps whose velocities are not right to the overlap tolerance.
    #[serde(default)]
    pub steps_unsettled: u64,
    /// The first of them.
    #[serde(default)]
    pub unsettled: Vec<UnsettledStep>,
    /// Steps that did not go at once.
    #[serde(default)]
    pub retried: Retried,
    /// The farthest that contact moved a body's centre from its free motion in a step, a length.
    #[serde(default)]
    pub largest_move: f64,
    /// The farthest that a body's velocity carries it in a step, in thicknesses of its own, by the recorded states.
    #[serde(default)]
    pub farthest_way: f64,
    /// The largest separation of a contact that pushed at the end of a step, a length.
    #[serde(default)]
    pub largest_push_gap: f64,
    /// The most energy that contact added in a step.
    #[serde(default)]
    pub largest_contact_energy: f64,
    /// The largest angle by which contact turned a body of revolution about its own axis in a step.
    #[serde(default)]
    pub largest_axial_spin: f64,
    /// Steps with rows that were rebuilt because they pushed bodies that no longer touched.
    #[serde(default)]
    pub steps_loosened: u64,
    /// Recursions, summed.
    pub recursions: u64,
    /// Most recursions of a step.
    pub max_recursions: u32,
    /// Rows of the steps' last LCPs, summed.
    pub constraints: u64,
    /// Rows of the last step's last LCP.
    pub final_constraints: u64,
    /// Most rows of a step's last LCP.
    pub max_constraints: u64,
    /// LCP iterations, summed.
    pub iterations: u64,
    /// Applications of `A`, summed.
    pub products: u64,
    /// Solves that the safeguard of the solver `auto` went on with.
    #[serde(default)]
    pub fallbacks: u64,
    /// Largest residual that a solve ended with, a length.
    #[serde(deserialize_with = "or_infinite")]
    pub worst_residual: f64,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u64,
    /// The first steps that had one.
    pub unconverged_steps: Vec<UnconvergedStep>,
    /// What computed which steps: one entry for each time that the run was started or resumed.
    #[serde(default)]
    pub legs: Vec<Leg>,
    /// Wall time.
    pub wall: WallSeconds,
}

fn or_infinite<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
}

/// The larger of the two, and infinite where the new one is not a number: a maximum must not lose that.
fn worse(so_far: f64, new: f64) -> f64 {
    if new.is_nan() { f64::INFINITY } else { so_far.max(new) }
}

impl Totals {
    /// Adds a step that took `wall` in all.
    pub fn add(&mut self, report: &StepReport, overlap_tolerance: f64, wall: Duration) {
        self.steps += 1;
        self.max_overlap = worse(self.max_overlap, report.max_overlap);
        if let Some(proxy) = report.proxy_overlap {
            self.proxy_overlap = Some(worse(self.proxy_overlap.unwrap_or(0.0), proxy));
        }
        if !report.within(overlap_tolerance) {
            self.steps_over_tolerance += 1;
            if self.over.len() < NAMED {
                let (step, pair, wall) = (report.step, report.worst_pair, report.worst_wall);
                self.over.push(OverStep { step, max_overlap: report.max_overlap, pair, wall });
            }
        }
        if let Some(Passed { pairs, pair }) = report.passed {
            self.steps_passed += 1;
            if self.passed.len() < NAMED {
                self.passed.push(PassedStep { step: report.step, pairs, pair });
            }
        }
        if !report.settled(overlap_tolerance) {
            self.steps_unsettled += 1;
            if self.unsettled.len() < NAMED {
                self.unsettled.push(UnsettledStep { step: report.step, residual: report.velocity_residual });
            }
        }
        self.retried.add(report);
        self.largest_move = self.largest_move.max(report.largest_move);
        self.largest_push_gap = self.largest_push_gap.max(report.largest_push_gap);
        self.largest_contact_energy = self.largest_contact_energy.max(report.contact_energy);
        self.largest_axial_spin = self.largest_axial_spin.max(report.axial_spin);
        self.steps_loosened += u64::from(report.loosened > 0);
        self.recursions += u64::from(report.recursions);
        self.max_recursions = self.max_recursions.max(report.recursions);
        let constraints = report.constraints as u64;
        self.constraints += constraints;
        self.final_constraints = constraints;
        self.max_constraints = self.max_constraints.max(constraints);
        self.add_solves(report);
        self.wall.add(&report.phases);
        self.wall.total += wall.as_secs_f64();
    }

    /// Notes that a simulation takes the steps from here on.
    pub(crate) fn taken_up_by(&mut self, simulation: &Simulation) {
        let leg = Leg::of(simulation);
        log::info!("{leg}");
        self.legs.push(leg);
    }

    fn add_solves(&mut self, report: &StepReport) {
        self.iterations += report.iterations;
        self.products += report.products;
        self.fallbacks += u64::from(report.fallbacks);
        self.worst_residual = worse(self.worst_residual, report.residual);
        self.unconverged += u64::from(report.unconverged);
        if report.unconverged > 0 && self.unconverged_steps.len() < NAMED {
            self.unconverged_steps.push(UnconvergedStep { step: report.step, residual: report.residual });
        }
    }

    /// Whether every step met its tolerances, and no bodies went through each other.
    pub fn clean(&self) -> bool {
        self.reason().is_none()
    }

    /// What a run missed, in one word, the worst first: `overlap` where a step left more than the tolerance, `passed`
    /// where bodies went through each other, `residual` where velocities come from a solve that is not right to the
    /// overlap tolerance.
    pub fn reason(&self) -> Option<&'static str> {
        let missed =
            [("overlap", self.steps_over_tolerance), ("passed", self.steps_passed), ("residual", self.steps_unsettled)];
        missed.into_iter().find(|(_, steps)| *steps > 0).map(|(reason, _)| reason)
    }
}
