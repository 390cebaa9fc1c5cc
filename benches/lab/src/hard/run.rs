//! The run of a case and its record. Each accepted state is audited from its bodies only.

use super::Start;
use relcp::bodies::Bodies;
use relcp::gpu::Precision;
use relcp::internals;
use relcp::scene::{Method, OnFailure, Scene, SceneError};
use relcp::simulation::{Compute, Simulation};
use relcp::step::{Fault, State, StepReport, contacts};
use relcp::walls::Walls;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// All steps were taken.
    Done,
    /// The scene was refused, with a reason.
    Refused(String),
    /// A step could not be taken, and the program said why.
    Fault(String),
    /// The program panicked.
    Panic(String),
}

/// The summary of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figures {
    /// Bodies at the end.
    pub bodies: usize,
    /// Steps taken.
    pub steps: u64,
    /// The overlap tolerance.
    pub overlap_tolerance: f64,
    /// The tolerance of a solve, a length.
    pub solver_tolerance: f64,
    /// Largest overlap of all accepted states, recomputed from their bodies.
    pub max_overlap: f64,
    /// Steps that left more than the tolerance, recomputed.
    pub steps_over: u64,
    /// Steps of which the program said less overlap than there was, or none of a state that is over the tolerance.
    pub steps_misreported: u64,
    /// Recursions a step.
    pub recursions_mean: f64,
    /// The most of a step.
    pub recursions_max: u32,
    /// Applications of `A`.
    pub products: u64,
    /// Largest residual of a solve, a length.
    pub worst_residual: f64,
    /// Solves that did not converge, as the program said.
    pub unconverged: u64,
    /// Steps whose velocities are not right to the overlap tolerance.
    pub steps_unsettled: u64,
    /// Steps whose solves are said to have converged with a residual over the tolerance. Steps with a relaxed
    /// solve are left out: the program counts these, and they may leave a part of the overlap tolerance.
    pub false_claims: u64,
    /// How the last unconverged solve ended.
    pub status: String,
    /// Steps in which bodies went through each other, as the program said.
    pub steps_passed: u64,
    /// The pair that it named first.
    pub passed: Option<[usize; 2]>,
    /// Steps that were taken in pieces.
    pub steps_cut: u64,
    /// The most pieces of a step.
    pub most_pieces: u32,
    /// Accepted states with a number that is not finite, or an orientation that is no rotation.
    pub states_not_finite: u64,
    /// Whether the run is to stop at a step that would leave more than the tolerance.
    pub binding: bool,
    /// What kind of typed error stopped it, where one did.
    pub stopped: Option<&'static str>,
    /// How it ended.
    pub end: End,
}

/// A run and its last state.
#[derive(Clone, Debug)]
pub struct Run {
    /// What it came to.
    pub figures: Figures,
    /// The bodies at its end.
    pub bodies: Bodies,
}

/// The reported and the recomputed overlap of a step may differ by this number of roundings of the largest
/// coordinate and size: both sum a few terms of that magnitude.
const ROUNDINGS: f64 = 64.0;

/// Takes `steps` steps on the CPU. `seen` is shown the bodies before each, and the simulation after it.
pub fn follow(start: &Start, steps: u64, seen: impl FnMut(&Bodies, &Simulation)) -> Run {
    follow_on(&Compute::Cpu, start, [steps, u64::MAX], seen)
}

/// As [`follow`], computed by what `compute` says, to the scene's end at most. A run ends at the step that leaves more
/// than the tolerance for the `over`th time.
pub fn follow_on(
    compute: &Compute,
    start: &Start,
    [steps, over]: [u64; 2],
    mut seen: impl FnMut(&Bodies, &Simulation),
) -> Run {
    let settings = start.scene.lcp_settings();
    let mut run = Run {
        figures: Figures {
            binding: binds(&start.scene),
            ..Figures::new(start.scene.contact.overlap_tolerance, settings.tolerance)
        },
        bodies: Bodies::default(),
    };
    let outcome = catch_unwind(AssertUnwindSafe(|| run.take(compute, start, [steps, over], &mut seen)));
    run.figures.end = match outcome {
        Ok(Ok(())) => End::Done,
        Ok(Err(Stopped::Scene(refused))) => End::Refused(refused.to_string()),
        Ok(Err(Stopped::Fault(fault))) => {
            run.figures.stopped = Some(fault.name());
            End::Fault(fault.to_string())
        }
        Err(panic) => End::Panic(words(panic.as_ref())),
    };
    run.figures.recursions_mean /= run.figures.steps.max(1) as f64;
    run
}

/// Whether a step that misses the overlap tolerance is to stop the run.
fn binds(scene: &Scene) -> bool {
    scene.contact.method == Method::Relcp && scene.contact.on_failure == OnFailure::Stop
}

enum Stopped {
    Scene(SceneError),
    Fault(Fault),
}

impl From<SceneError> for Stopped {
    fn from(error: SceneError) -> Self {
        Stopped::Scene(error)
    }
}

impl From<Fault> for Stopped {
    fn from(fault: Fault) -> Self {
        Stopped::Fault(fault)
    }
}

fn words(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no words".into())
}

impl Run {
    fn take(
        &mut self,
        compute: &Compute,
        start: &Start,
        [steps, over]: [u64; 2],
        seen: &mut dyn FnMut(&Bodies, &Simulation),
    ) -> Result<(), Stopped> {
        self.bodies = start.scene.build()?;
        self.figures.bodies = self.bodies.len();
        let (walls, fixed) = (start.scene.walls(), start.scene.fixed());
        let mut simulation =
            internals::simulation::start(compute, start.scene.clone(), State::new(self.bodies.clone()))?;
        if let Some(pull) = start.pull {
            simulation.add_force(Box::new(pull));
        }
        while self.figures.steps < steps && self.figures.steps_over < over && !simulation.done() {
            let report = simulation.step()?;
            let after = &simulation.state()?.bodies;
            self.figures.count(&report);
            let walls = walls.at(simulation.time()).gone(&after.walls);
            self.figures.audit(&report, (after, &fixed.flags(after)), &walls, simulation.precision());
            seen(&self.bodies, &simulation);
            self.bodies.clone_from(after);
        }
        Ok(())
    }
}

impl Figures {
    /// Of no step.
    pub fn new(overlap_tolerance: f64, solver_tolerance: f64) -> Figures {
        Figures {
            bodies: 0,
            steps: 0,
            overlap_tolerance,
            solver_tolerance,
            max_overlap: 0.0,
            steps_over: 0,
            steps_misreported: 0,
            recursions_mean: 0.0,
            recursions_max: 0,
            products: 0,
            worst_residual: 0.0,
            unconverged: 0,
            steps_unsettled: 0,
            false_claims: 0,
            status: relcp::lcp::Status::Solved.name().into(),
            steps_passed: 0,
            passed: None,
            steps_cut: 0,
            most_pieces: 0,
            states_not_finite: 0,
            binding: false,
            stopped: None,
            end: End::Done,
        }
    }

    /// How the run ended, in words: an unconverged solve's status, where there was one.
    pub fn ended(&self) -> String {
        match &self.end {
            End::Done if self.unconverged == 0 => "done".into(),
            End::Done => format!("done, {}", self.status),
            End::Refused(_) => "refused".into(),
            End::Fault(_) => "typed error".into(),
            End::Panic(_) => "panic".into(),
        }
    }

    fn count(&mut self, report: &StepReport) {
        self.steps += 1;
        self.bodies = report.bodies;
        self.recursions_mean += f64::from(report.recursions);
        self.recursions_max = self.recursions_max.max(report.recursions);
        self.products += report.products;
        self.steps_cut += u64::from(report.pieces > 1);
        self.most_pieces = self.most_pieces.max(report.pieces);
        if let Some(passed) = report.passed {
            self.steps_passed += 1;
            self.passed = self.passed.or(Some(passed.pair));
        }
        if exceeds(report.residual, self.worst_residual) {
            self.worst_residual = report.residual;
        }
        self.unconverged += u64::from(report.unconverged);
        self.steps_unsettled += u64::from(!report.settled(self.overlap_tolerance));
        if report.unconverged > 0 {
            self.status = report.status.name().into();
        } else if report.relaxed == 0 && exceeds(report.residual, self.solver_tolerance) {
            self.false_claims += 1;
        }
    }

    /// Looks at an accepted state, and which of its bodies are fixed, without anything else that the step knows of it.
    /// Overlaps of fixed bodies with each other and with walls are allowed.
    pub(super) fn audit(
        &mut self,
        report: &StepReport,
        (after, fixed): (&Bodies, &[bool]),
        walls: &Walls,
        precision: Precision,
    ) {
        let is_fixed = |body: usize| fixed.get(body).copied().unwrap_or(false);
        let pairs = contacts(after, 0.0);
        let pairs = pairs.iter().filter(|contact| !contact.bodies.iter().all(|body| is_fixed(*body)));
        let at_walls = walls.contacts(after, 0.0);
        let at_walls = at_walls.iter().filter(|contact| !is_fixed(contact.body)).map(|contact| contact.separation);
        let found = pairs.map(|contact| contact.separation).chain(at_walls).fold(0.0, |most, gap| f64::max(most, -gap));
        self.states_not_finite += u64::from(!finite(after));
        self.max_overlap = self.max_overlap.max(found);
        let rounding = ROUNDINGS * epsilon(precision) * magnitude(after);
        let over = found > self.overlap_tolerance + rounding;
        self.steps_over += u64::from(over);
        // A body that left may have been the one that overlapped.
        let less = if report.removed > 0 { found <= report.max_overlap } else { false };
        let said = less || (found - report.max_overlap).abs() <= rounding;
        self.steps_misreported += u64::from(!said || (over && report.within(self.overlap_tolerance)));
    }
}

/// Whether a value is over a bound: one that is not a number is, of any bound that is one.
pub(super) fn exceeds(value: f64, bound: f64) -> bool {
    value > bound || (value.is_nan() && !bound.is_nan())
}

fn epsilon(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => f32::EPSILON.into(),
        Precision::F64 => f64::EPSILON,
    }
}

/// The largest coordinate or size.
fn magnitude(bodies: &Bodies) -> f64 {
    let places = bodies.position.iter().map(|x| x.abs().max_element());
    places.chain(bodies.shape.iter().map(|s| s.major_axis())).fold(0.0, f64::max)
}

fn finite(bodies: &Bodies) -> bool {
    (0..bodies.len()).all(|i| {
        let twist = bodies.twist(i);
        let pose = bodies.position[i].is_finite() && bodies.orientation[i].is_finite();
        pose && bodies.orientation[i].is_normalized() && twist.linear.is_finite() && twist.angular.is_finite()
    })
}
