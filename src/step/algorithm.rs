//! One timestep: Algorithm 1 of the paper, and a step of second order made of two of its solves, each written once for
//! every backend.
//!
//! An attempt at a step holds where no overlap is over the tolerance, the velocities come from solves that are right to
//! it, and no body went through another. One that does not hold is never accepted: [`retry`] takes the step again.

use super::accuracy::Accuracy;
use super::surplus::{self, LEAST_ROWS};
use super::two_sided::{self, Caught, GAP, MOST_TILTS, Sides};
use super::{ContactSettings, Fault, Hindrance, Keep, Model, OnFailure, Rows, StepReport, Stepping, retry};
use crate::dynamics::{Cells, OnNoRoom, Strain};
use crate::lcp::{Outcome, Status};
use crate::step::{Guard, Overlap, Verbs};

/// Recursions of a midpoint step that may move the offsets of its rows, before it appends rows as the paper does. Two
/// ellipsoids at an overlap tolerance of 1e-9 fall to first order with one, and keep the second with two (at 1e-5 one
/// does). Each more costs nothing where it is not needed and a recursion where bodies are crowded: a colony to 32 cells
/// takes 7,219, 8,419, 8,377, 8,049 and 9,968 products with 1, 2, 3, 4 and 8.
const MOST_CORRECTIONS: u32 = 3;

/// The part of the overlap tolerance by which rows without a common solution may be violated, and over which the
/// residual of a solve that ended without success is worth another by [`Verbs::relax`]: what is left of the tolerance
/// is for the curvature of the motion.
const GIVEN_WAY: f64 = 0.5;

/// How many recursions of a scene's steps move offsets, before rows are appended. In space packed bodies slide along
/// each other, so that an old row is soon no bound any more: 1,000 packed rods take 1,094 products a step with three
/// such recursions, and 867 with none. The middle of a step leaves less to be found, and needs its rows' directions for
/// its order.
fn most_tightenings(model: &Model) -> u32 {
    let moves =
        model.time.stepping == Stepping::Midpoint || (model.planar && model.contact.rows_of_method() == Rows::Auto);
    if moves { MOST_CORRECTIONS } else { 0 }
}

/// What a step is to do.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scene's, with the cutoff that it leaves out.
    pub contact: ContactSettings,
    /// What the step's last LCP is solved to, a length.
    pub tolerance: f64,
    /// The stepping scheme.
    pub stepping: Stepping,
    /// What growing cells do where there is no room, in a scene whose space has an end; else none.
    pub on_no_room: Option<OnNoRoom>,
    /// Whether cells that lock by friction wait: all grow slower under pressure, and that of those that lock has no
    /// bound.
    pub(super) locked_wait: bool,
    /// Whether the walls and periods of such a scene leave no way out.
    pub(super) closed: bool,
    /// Whether bodies are parted before the step, in no time. Where bodies have inertia, a start that overlaps would
    /// become speed.
    pub parts_first: bool,
    /// The length of the next step, in parts of `dt`: see [`Time::span`](super::Time::span).
    pub span: f64,
    /// Whether contacts that push must touch.
    pub(super) two_sided: bool,
    /// Whether contacts may have friction.
    pub(super) frictional: bool,
    /// Whether rows may be loosened before nothing overlaps.
    pub(super) loosens_early: bool,
    /// Draws for rows that contradict each other.
    pub(super) most_tilts: u32,
    /// The draw by which the rows that push most are tilted although they have a common solution.
    pub(super) disturbed: Option<u32>,
    /// The gap that friction's law may be off by at a contact that pushes, a length.
    pub(super) friction_gap: f64,
    /// Recursions that may move the offsets of rows before rows are appended.
    pub(super) most_tightenings: u32,
    /// Whether rows of violations of a crowd ask for more than touching.
    pub(super) over_corrects: bool,
    /// Whether bonds or joints keep a length or an angle exactly.
    pub(super) has_rigid_bonds: bool,
    /// Whether bonds have a bending stiffness and a length that load may take from them.
    pub(super) has_bending_bonds: bool,
    /// Whether walls move or bear a load, or the cell shrinks.
    pub(super) may_squeeze: bool,
    /// Whether the least bad trial of an attempt is kept.
    pub(super) keeps_least_bad: bool,
    /// Whether the scene may ask that steps that do not hold are accepted.
    pub(super) may_accept_the_least_bad: bool,
}

impl Plan {
    /// Of steps of bodies that have this cutoff.
    pub fn new(model: &Model, cutoff: f64) -> Plan {
        Plan {
            contact: ContactSettings { cutoff: Some(cutoff), ..model.contact.clone() },
            tolerance: model.lcp.tolerance,
            stepping: model.time.stepping,
            on_no_room: model.cells.as_ref().filter(|_| model.confined).map(Cells::on_no_room),
            locked_wait: model.cells.as_ref().is_some_and(Cells::all_stop_under_pressure),
            closed: model.cells.is_some() && model.walls.are_closed(&model.periods, model.planar),
            parts_first: false,
            span: 1.0,
            two_sided: model.contact.rows_of_method() == Rows::Auto,
            frictional: !model.friction.is_none(),
            loosens_early: two_sided::loosens_early(model),
            most_tilts: MOST_TILTS,
            disturbed: None,
            friction_gap: model.contact.overlap_tolerance.max(model.friction.elastic_slip),
            most_tightenings: most_tightenings(model),
            over_corrects: surplus::over_corrects(model),
            has_rigid_bonds: model.bonds.keep_something(),
            has_bending_bonds: model.bonds.bend_softly(),
            may_squeeze: model.walls.move_in_time() || model.strain.as_ref().is_some_and(Strain::shrinks),
            keeps_least_bad: model.contact.on_failure == OnFailure::Continue,
            may_accept_the_least_bad: model.friction.is_none() && model.bonds.first_implicit().is_none(),
        }
    }

    /// What may keep bodies from parting: first walls that close, then bonds that bend, then rigid bonds.
    pub(super) fn hindrance(&self) -> Hindrance {
        match self {
            Plan { may_squeeze: true, .. } => Hindrance::Walls,
            Plan { has_bending_bonds: true, .. } => Hindrance::BendingBonds,
            Plan { has_rigid_bonds: true, .. } => Hindrance::RigidBonds,
            _ => Hindrance::Nothing,
        }
    }

    /// Whether the method promises that steps hold the overlap tolerance: those without recursion do not, and are never
    /// taken again.
    pub(crate) fn promises(&self) -> bool {
        self.contact.method.most_recursions(self.contact.max_recursions) > 0
    }

    /// Whether steps that do not hold are accepted after all.
    pub(super) fn accepts_the_least_bad(&self) -> bool {
        self.contact.on_failure == OnFailure::Continue
    }
}

/// Takes one step and reports it. A fault leaves the last accepted state. `keep` stores the LCPs that it selects.
pub fn step(backend: &mut dyn Verbs, plan: &Plan, keep: &mut Keep) -> Result<StepReport, Fault> {
    let first = if plan.parts_first || plan.span < 1.0 { None } else { Some(attempt(backend, plan, keep)) };
    let (mut report, overlap) = match first {
        Some(Ok(mut tried)) if !plan.promises() || tried.holds(plan) => {
            tried.report.phases = backend.accept()?; // C^k+1
            tried.report.broken_bonds = backend.broken_bonds();
            (tried.report, tried.overlap)
        }
        Some(Err(fault)) if !fault.may_pass_with_smaller_steps() => return Err(fault),
        failed => retry::take_again(backend, plan, keep, failed)?,
    };
    report.measure(&overlap, backend.steps(), backend.bodies());
    Ok(report)
}

/// The outcome of an attempt at a step or a piece of it.
#[derive(Default)]
pub(super) struct Attempt {
    pub report: StepReport,
    pub overlap: Overlap,
    /// The promise about what contact does that it breaks.
    pub broken: Option<Guard>,
    /// Whether it was left to a backend that can rebuild rows.
    pub left: bool,
    /// Whether friction's law is farther off than the plan allows.
    pub rough: bool,
    /// Whether the last solve found no friction forces, and left them out.
    pub without_friction: bool,
    /// The multipliers of the least bad trial and how bad it is, where steps that do not hold are accepted.
    pub least_bad: Option<(f64, Vec<f64>)>,
}

impl Attempt {
    /// Whether it may be accepted.
    pub fn holds(&self, plan: &Plan) -> bool {
        let tolerance = plan.contact.overlap_tolerance;
        self.overlap.error() <= tolerance
            && self.report.settled(tolerance)
            && self.report.passed.is_none()
            && self.broken.is_none()
            && !self.left
            && !self.rough
    }

    /// Whether contact throws bodies, or pushes apart what is far from touching.
    pub fn throws(&self) -> bool {
        matches!(self.broken, Some(Guard::Thrown | Guard::Apart))
    }

    /// Whether bodies lock by friction.
    pub fn locks(&self) -> bool {
        self.broken == Some(Guard::Locked)
    }

    /// How far it is from holding, a length: by what surfaces overlap, or the velocities are off. Overlap alone would
    /// call a trial good that throws all bodies far apart.
    pub fn badness(&self) -> f64 {
        badness(&self.overlap, self.report.velocity_residual)
    }
}

fn badness(overlap: &Overlap, residual: f64) -> f64 {
    // Not a number is as bad as can be.
    if overlap.error().is_nan() || residual.is_nan() { f64::INFINITY } else { overlap.error().max(residual) }
}

/// Makes one attempt at what the backend begins next; nothing is accepted.
pub(super) fn attempt(backend: &mut dyn Verbs, plan: &Plan, keep: &mut Keep) -> Result<Attempt, Fault> {
    let mut tried = Attempt { report: StepReport { pieces: 1, ..StepReport::default() }, ..Attempt::default() };
    match plan.stepping {
        Stepping::Euler => euler(backend, plan, keep, &mut tried)?,
        Stepping::Midpoint => midpoint(backend, plan, keep, &mut tried)?,
    }
    tried.report.constraints = backend.constraints();
    tried.report.passed = backend.passed()?;
    tried.take_effect(backend, plan)?;
    Ok(tried)
}

/// The paper's step.
fn euler(backend: &mut dyn Verbs, plan: &Plan, keep: &mut Keep, tried: &mut Attempt) -> Result<(), Fault> {
    let contact = &plan.contact;
    backend.begin()?; // growth, forces, effective mobility, free velocity at C^k
    backend.append_near()?; // A_0: one row a near pair
    let mut accuracy = Accuracy::first(contact, plan.tolerance);
    let mut first_violation = None;
    let mut sides = Sides::default();
    loop {
        let outcome = tried.solve_tilted(backend, plan, keep, accuracy.residual(), &mut sides)?; // gamma_n from gamma_n-1, U_n
        accuracy.reached(outcome.residual);
        let over_corrects = plan.over_corrects && backend.constraints() >= LEAST_ROWS;
        accuracy.over_correct(over_corrects);
        tried.report.velocity_residual = outcome.residual;
        let overlap = backend.trial(accuracy.of_rows())?; // C_n+1 = C(U_n), from C^k with the total velocity, every pair looked at
        tried.see(backend, plan, overlap)?;
        log::trace!("trial: {} overlap, by up to {:.2e}", overlap.violations, overlap.worst);
        tried.report.first_violation = *first_violation.get_or_insert(overlap.worst);
        accuracy.see(&overlap);
        if contradicted(&outcome, contact) {
            sides.loosen(backend, plan, tried)?;
            return Ok(());
        }
        // Rows that throw bodies are rebuilt before new contacts of these bodies are handled.
        match sides.catch(backend, plan, tried)? {
            Caught::Rows => continue,
            Caught::Left => return Ok(()),
            Caught::Nothing => {}
        }
        if accuracy.shows(&overlap) && tried.report.may_recurse(contact) {
            if sides.loosen_early(backend, plan, tried)? {
                return Ok(());
            }
            // A_n+1: one more row a violating pair, linearised at C_n+1; or the offsets of rows that are there, exact
            // at C_n+1
            if tried.report.recursions < plan.most_tightenings {
                backend.tighten_violations()?;
            } else {
                backend.append_violations(over_corrects)?;
            }
            if accuracy.shows_stretch(&overlap) {
                backend.renew_bonds()?;
            }
            accuracy.follow(&overlap);
            tried.report.recursions += 1;
        } else if accuracy.shows_stretch(&overlap) && tried.report.recursions < contact.max_recursions {
            // Bonds whose length or direction is another than that of their rows, linearised at C_n+1
            backend.renew_bonds()?;
            accuracy.follow(&overlap);
            tried.report.recursions += 1;
        } else if !accuracy.tighten(&overlap) && !sides.loosen(backend, plan, tried)? {
            return Ok(());
        }
    }
}

/// The midpoint rule: contact forces act along the normals in the middle of the step, `C_h = C(U_h)` after `dt/2`.
///
/// A trial that still overlaps first moves the offsets of rows that keep their direction: always inwards, so no
/// retained row is lost, and the order with it. Rows appended at a trial, along its own normals, end the recursion
/// where that does not.
fn midpoint(backend: &mut dyn Verbs, plan: &Plan, keep: &mut Keep, tried: &mut Attempt) -> Result<(), Fault> {
    let contact = &plan.contact;
    backend.begin()?; // as a step of dt/2
    backend.append_near()?;
    let mut sides = Sides::default();
    let half = tried.solve_tilted(backend, plan, keep, plan.tolerance, &mut sides)?; // U_h
    backend.middle()?; // C_h; forces, effective mobility there, free velocity of the whole step
    backend.append_near()?; // one row a near pair of C_h, linearised there
    let mut outcome = tried.solve_tilted(backend, plan, keep, plan.tolerance, &mut sides)?;
    tried.report.velocity_residual = half.residual.max(outcome.residual);
    let mut overlap = backend.trial(contact.overlap_tolerance)?; // C_1 = C(U_0) after dt, from C^k
    tried.report.first_violation = overlap.worst;
    tried.see(backend, plan, overlap)?;
    loop {
        let shows = overlap.violations > 0 && tried.report.may_recurse(contact);
        if contradicted(&outcome, contact) {
            sides.loosen(backend, plan, tried)?;
            break;
        }
        match sides.catch(backend, plan, tried)? {
            Caught::Left => break,
            Caught::Rows => {}
            Caught::Nothing if shows => {
                if tried.report.recursions < plan.most_tightenings {
                    backend.tighten_violations()?;
                } else {
                    backend.append_violations(false)?;
                }
                tried.report.recursions += 1;
            }
            Caught::Nothing => {
                if !sides.loosen(backend, plan, tried)? {
                    break;
                }
            }
        }
        outcome = tried.solve_tilted(backend, plan, keep, plan.tolerance, &mut sides)?;
        tried.report.velocity_residual = half.residual.max(outcome.residual);
        overlap = backend.trial(contact.overlap_tolerance)?;
        tried.see(backend, plan, overlap)?;
    }
    Ok(())
}

/// Whether a solve stalled with a row violated by more than the overlap tolerance: its rows have no common solution,
/// and as rows are never changed, more of them will not give them one. It happens where a body fits a hole nowhere.
fn contradicted(outcome: &Outcome, contact: &ContactSettings) -> bool {
    let stalled =
        matches!(outcome.status, Status::NoProgress | Status::RoundingFloor | Status::Infeasible | Status::NotFinite);
    stalled && outcome.residual > contact.overlap_tolerance
}

impl Attempt {
    /// Solves the present LCP to a residual; in the sense of the least overlap, where that fails and the method
    /// promises something.
    fn solve(
        &mut self,
        backend: &mut dyn Verbs,
        plan: &Plan,
        keep: &mut Keep,
        residual: f64,
    ) -> Result<Outcome, Fault> {
        let outcome = keep.solve(backend, residual)?;
        let allowed = GIVEN_WAY * plan.contact.overlap_tolerance;
        let failed = outcome.status != Status::Solved && (outcome.residual.is_nan() || outcome.residual > allowed);
        let relaxed = if failed && plan.promises() { backend.relax(allowed)? } else { None };
        if let Some(Outcome { status, iterations, residual, .. }) = &relaxed {
            log::trace!("least overlap: {status:?}, {iterations} iterations, residual {residual:.2e} of {allowed:.1e}");
        }
        self.report.count(&outcome, relaxed.as_ref());
        let outcome = relaxed.unwrap_or(outcome);
        self.without_friction = outcome.status == Status::WithoutFriction;
        Ok(outcome)
    }

    /// Solves the present LCP; where its rows contradict each other, tilted ones.
    fn solve_tilted(
        &mut self,
        backend: &mut dyn Verbs,
        plan: &Plan,
        keep: &mut Keep,
        residual: f64,
        sides: &mut Sides,
    ) -> Result<Outcome, Fault> {
        let before = self.report;
        let outcome = self.solve(backend, plan, keep, residual)?;
        if sides.disturb(backend, plan, self) {
            return self.solve_tilted(backend, plan, keep, residual, sides);
        }
        if !contradicted(&outcome, &plan.contact) || !sides.tilt(backend, plan, self, outcome.residual) {
            return Ok(outcome);
        }
        loop {
            // The multipliers of a solve that fails show the wedge too.
            let outcome = keep.solve(backend, residual)?;
            self.report.add_solve(&outcome);
            if !contradicted(&outcome, &plan.contact) {
                // What failed before is of no consequence.
                let StepReport { residual, unconverged, relaxed, status, .. } = before;
                self.report = StepReport { residual, unconverged, relaxed, status, ..self.report };
                self.report.judge(&outcome);
                return Ok(outcome);
            }
            if !sides.tilt(backend, plan, self, outcome.residual) {
                return self.solve(backend, plan, keep, residual);
            }
        }
    }

    /// Forgets the least bad trial: its multipliers are of rows that are no more.
    pub(super) fn forget_least_bad(&mut self) {
        self.least_bad = None;
    }

    /// Takes note of what contact does on the way to the trial.
    pub(super) fn take_effect<V: Verbs + ?Sized>(&mut self, backend: &mut V, plan: &Plan) -> Result<(), Fault> {
        let effect = backend.effect(GAP)?;
        self.report.take_effect(&effect);
        self.rough = self.report.friction_gap > plan.friction_gap;
        let locked = self.without_friction.then_some(Guard::Locked);
        self.broken = effect.broken(backend.two_sided().is_some()).filter(|_| plan.two_sided).or(locked);
        Ok(())
    }

    /// Takes note of a trial.
    pub(super) fn see(&mut self, backend: &dyn Verbs, plan: &Plan, overlap: Overlap) -> Result<(), Fault> {
        self.overlap = overlap;
        if plan.keeps_least_bad && plan.promises() {
            let now = self.badness();
            if self.least_bad.as_ref().is_none_or(|(least, _)| now < *least) {
                self.least_bad = Some((now, backend.multipliers()?));
            }
        }
        Ok(())
    }
}

impl StepReport {
    /// Whether the step may have one more recursion.
    fn may_recurse(&self, contact: &ContactSettings) -> bool {
        self.recursions < contact.method.most_recursions(contact.max_recursions)
    }
}
