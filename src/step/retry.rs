//! Repeats a failed step.
//!
//! The step is halved, and failed pieces are halved again, down to a 64th. The pieces are ordinary steps, so together
//! they are a step with a smaller `dt`. If a 64th fails too, daughters that are born in it turn by less than their
//! drawn angle. If that fails as well, growing cells without room wait or end the run (`growth.on_no_room`). A failure
//! for another reason ends the run with the state before the step, or the best attempt is accepted
//! (`contact.on_failure`). A piece in which bodies lock under forces without bound is not halved.
//!
//! Nothing here depends on earlier steps, so a resumed run takes the same pieces.

use super::accuracy;
use super::algorithm::{Attempt, Plan, attempt};
use super::{Crowd, Fault, Guard, Keep, Piece, State, StepReport, Stepping, Unresolved};
use crate::dynamics::{OnNoRoom, Waiting};
use crate::lcp::Status;
use crate::step::{Failed, Overlap, RetryBackend, Verbs};

/// The compliances of rows if a step without a solution is accepted. With the first, bodies move by a tenth less than
/// needed to separate a pair; with the last, by the needed distance to a millionth.
const COMPLIANCES_OF_SPREADING: [f64; 4] = [1e-1, 1e-2, 1e-4, 1e-6];

/// The largest number of rounds in which such a step's overlap is spread, and the largest part of it that a worthwhile
/// round may leave.
const MOST_ROUNDS_OF_SPREADING: u32 = 4;
const WORTH_A_ROUND: f64 = 0.8;

/// A piece without growth nearly holds if its error is at most this many overlap tolerances, and with growth at least
/// this many times larger. In a full disc of eight cells the error is 5 tolerances, with growth 180.
const NEARLY_HOLDS: f64 = 10.0;

/// The parts of their drawn angle by which daughters turn, tried in this order, if the shortest piece fails.
const LESSER_TURNS: [f64; 3] = [0.5, 0.25, 0.0];

/// The largest number of wedges whose cells wait, one after the other, before all pressed cells wait.
const MOST_WEDGES: usize = 6;

/// The part of the overlap tolerance that the CPU uses, to leave room for the rounding of a device's poses, some 1e-9
/// of a body.
const LEFT_FOR_ROUNDING: f64 = 0.99;

/// Repeats the step that `failed` describes and accepts it; also takes steps that first separate bodies, or that are
/// shorter than the others.
pub(super) fn take_again(
    backend: &mut dyn Verbs,
    plan: &Plan,
    keep: &mut Keep,
    mut failed: Option<Result<Attempt, Fault>>,
) -> Result<(StepReport, Overlap), Fault> {
    let mut plan = plan.clone();
    let (mut report, mut overlap, mut by_cpu) = (StepReport::default(), Overlap::default(), false);
    backend.take_again(&mut |again, by| {
        by_cpu = by == Failed::OnDevice;
        if by_cpu {
            plan.contact.overlap_tolerance *= LEFT_FOR_ROUNDING;
        }
        // If a device or several processes made the attempt, the CPU or each process first repeats it alone, as it
        // would begin itself.
        let by_other = failed.is_some() && by != Failed::Itself;
        let before = again.state()?.clone();
        let first = match failed.take() {
            Some(tried) if by_other => {
                // The device's outcome does not predict the CPU's.
                if let (true, Ok(tried)) = (by_cpu, &tried) {
                    report.add_cost(&tried.report);
                    report.first_violation = tried.report.first_violation;
                }
                Some(attempt(again, &plan, keep))
            }
            tried => tried,
        };
        // An attempt that holds counts too: the one before may have ended before its first trial.
        if let (true, Some(Ok(tried))) = (by_other, &first) {
            report.first_violation = tried.report.first_violation;
        }
        // Pieces are the paper's.
        plan.over_corrects = false;
        if let Some(Ok(tried)) = &first {
            accuracy::expect(&mut plan.contact, &tried.report);
        }
        let bounces = !plan.contact.restitution.is_none();
        let mut taken = Taking { plan: &plan, keep, report: &mut report, waiting: Waiting::None, bounces };
        let result = taken.step(again, first, &before);
        if result.is_err() {
            again.restore(&before)?;
        }
        overlap = result?;
        Ok(())
    })?;
    report.by_cpu = by_cpu;
    Ok((report, overlap))
}

/// Returns to the best trial of an attempt if the last one is worse.
pub(super) fn go_to_least_bad(again: &mut dyn RetryBackend, plan: &Plan, tried: &mut Attempt) -> Result<(), Fault> {
    if let Some((badness, gamma)) = tried.least_bad.take()
        && badness < tried.badness()
    {
        again.set_multipliers(&gamma);
        tried.overlap = again.trial(plan.contact.overlap_tolerance)?;
        tried.report.velocity_residual = badness;
        tried.report.passed = again.passed()?;
        tried.take_effect(again, plan)?;
    }
    Ok(())
}

/// A step in pieces.
pub(super) struct Taking<'a> {
    pub(super) plan: &'a Plan,
    pub(super) keep: &'a mut Keep,
    /// The report of the accepted pieces, with the cost of all attempts.
    pub(super) report: &'a mut StepReport,
    pub(super) waiting: Waiting,
    /// Whether contacts have restitution now.
    pub(super) bounces: bool,
}

impl Taking<'_> {
    fn step(
        &mut self,
        again: &mut dyn RetryBackend,
        first: Option<Result<Attempt, Fault>>,
        before: &State,
    ) -> Result<Overlap, Fault> {
        if self.plan.parts_first {
            self.parted(again, 0.0, false)?;
        }
        match self.piece(again, Piece::whole(self.plan.span), first) {
            Err(Fault::Unresolved(_)) if self.plan.accepts_the_least_bad() => {
                again.restore(before)?;
                self.waiting = Waiting::None;
                *self.report = StepReport { failed_attempts: self.report.failed_attempts, ..self.cost() };
                self.spread(again)
            }
            taken => taken,
        }
    }

    /// The cost of all attempts, without their outcomes.
    fn cost(&self) -> StepReport {
        let StepReport { iterations, products, fallbacks, first_violation, phases, .. } = *self.report;
        StepReport { iterations, products, fallbacks, first_violation, phases, ..StepReport::default() }
    }

    /// Takes a piece, in halves if it fails. `first` is the outcome of an earlier attempt, if there was one.
    fn piece(
        &mut self,
        again: &mut dyn RetryBackend,
        piece: Piece,
        first: Option<Result<Attempt, Fault>>,
    ) -> Result<Overlap, Fault> {
        let tried = match first {
            Some(tried) => tried,
            None => self.attempt(again, piece),
        };
        let failed = match tried {
            Ok(tried) if !self.plan.promises() || tried.holds(self.plan) => return self.accept(again, tried),
            Ok(tried) if piece.is_whole() && self.began_like_this(again) => {
                self.report.add_cost(&tried.report);
                return self.spread(again);
            }
            Err(fault) if !fault.may_pass_with_smaller_steps() => return Err(fault),
            failed => failed,
        };
        self.count_failure(&failed);
        if self.bounces && failed.as_ref().is_ok_and(|tried| tried.broken == Some(Guard::Energy)) {
            return self.without_bounces(again, piece);
        }
        let births = again.has_births();
        let tolerance = self.plan.contact.overlap_tolerance;
        // First rows are made where cells have divided, or ahead. With friction the whole step with rows of its start
        // shows whether bodies lock: shorter pieces let them grow under ever larger forces.
        let overlaps = |again: &dyn RetryBackend| {
            again.start_overlap() > tolerance && (self.plan.frictional || again.rest_overlap() > tolerance)
        };
        if piece.is_whole() && !self.report.parted && overlaps(again) && self.parted(again, 0.0, false)?.is_some() {
            return self.piece(again, piece, None);
        }
        if let Some(overlap) = self.turn_less(again, piece, births)? {
            return Ok(overlap);
        }
        let locks = failed.as_ref().is_ok_and(Attempt::locks);
        let locked = locks && failed.as_ref().is_ok_and(|tried| !tried.without_friction);
        let may_wait = self.plan.on_no_room == Some(OnNoRoom::Stall) || (locks && self.plan.locked_wait);
        if may_wait
            && (piece.is_whole() || piece.is_shortest() || locked)
            && let Some(overlap) = self.wait(again, piece)?
        {
            return Ok(overlap);
        }
        // Bodies that lock stay locked in shorter pieces, but forces need more of them to grow.
        match piece.halves().filter(|_| !locked) {
            Some([first, second]) => {
                self.piece(again, first, None)?;
                self.piece(again, second, None)
            }
            None => self.give_up(again, piece, failed),
        }
    }

    /// Takes a piece without restitution, which made energy.
    fn without_bounces(&mut self, again: &mut dyn RetryBackend, piece: Piece) -> Result<Overlap, Fault> {
        self.bounces = false;
        again.bounce(false);
        let taken = self.piece(again, piece, None);
        (self.bounces, self.report.restitution_dropped) = (true, self.report.restitution_dropped + 1);
        again.bounce(true);
        taken
    }

    pub(super) fn attempt(&mut self, again: &mut dyn RetryBackend, piece: Piece) -> Result<Attempt, Fault> {
        again.prepare(piece, &self.waiting);
        // Waiting cells do not press others, so cells in line need no random disturbance.
        let most_tilts = if matches!(self.waiting, Waiting::None) { self.plan.most_tilts } else { 0 };
        // The shortest pieces are as right as friction gets.
        let friction_gap = if piece.is_shortest() { f64::INFINITY } else { self.plan.friction_gap };
        // What the shortest piece cannot do decides between no room and another cause.
        let loosens_early = self.plan.loosens_early && !piece.is_shortest();
        attempt(again, &Plan { most_tilts, friction_gap, loosens_early, ..self.plan.clone() }, self.keep)
    }

    pub(super) fn count_failure(&mut self, failed: &Result<Attempt, Fault>) {
        match failed {
            Ok(tried) => {
                let (overlap, residual) = (tried.overlap.error(), tried.report.velocity_residual);
                log::trace!("fails: overlap {overlap:.2e}, residual {residual:.2e}, {:?}", tried.broken);
                if self.report.failed_attempts == 0 {
                    self.report.first_violation = tried.report.first_violation;
                }
                self.report.add_cost(&tried.report);
            }
            Err(_) => self.report.failed_attempts += 1,
        }
    }

    pub(super) fn accept(&mut self, again: &mut dyn RetryBackend, mut tried: Attempt) -> Result<Overlap, Fault> {
        tried.report.phases = again.accept()?;
        tried.report.broken_bonds = again.broken_bonds();
        self.report.add_piece(&tried.report);
        Ok(tried.overlap)
    }

    /// Whether failed steps are accepted and the last step was one: then neither the step nor its pieces have a
    /// solution.
    fn began_like_this(&self, again: &dyn RetryBackend) -> bool {
        self.plan.accepts_the_least_bad() && again.start_overlap() > self.plan.contact.overlap_tolerance
    }

    /// Accepts the step with the smallest overlap found, and spreads it over the contacts without advancing time: rows
    /// are compliant, and softer rows move bodies less, so that at least one of the trials throws none.
    fn spread(&mut self, again: &mut dyn RetryBackend) -> Result<Overlap, Fault> {
        again.prepare(Piece::whole(self.plan.span), &self.waiting);
        let mut taken = self.softened(again, self.plan.stepping)?;
        taken.report.phases = again.accept()?;
        for _ in 0..MOST_ROUNDS_OF_SPREADING {
            let before = again.state()?.clone();
            again.part(true);
            again.prepare(Piece::WHOLE, &Waiting::All);
            let spread = self.softened(again, Stepping::Euler)?;
            if spread.overlap.worst.is_nan() || spread.overlap.worst >= WORTH_A_ROUND * taken.overlap.worst {
                again.restore(&before)?;
                break;
            }
            taken.report.phases += again.accept()?;
            again.part(false);
            taken.overlap = spread.overlap;
        }
        taken.report.velocity_residual = taken.report.velocity_residual.max(taken.overlap.worst);
        self.report.add_piece(&taken.report);
        Ok(taken.overlap)
    }

    /// The trial of the first rows with the smallest overlap over all compliances; one in which bodies pass each other
    /// only if there is no other.
    fn softened(&mut self, again: &mut dyn RetryBackend, stepping: Stepping) -> Result<Attempt, Fault> {
        again.begin()?;
        again.append_near()?;
        if stepping == Stepping::Midpoint {
            again.regularize(COMPLIANCES_OF_SPREADING[0])?;
            again.middle()?;
            again.append_near()?;
        }
        let mut best: Option<((bool, f64), Vec<f64>)> = None;
        let mut report = StepReport { pieces: 1, unconverged: 1, status: Status::Infeasible, ..StepReport::default() };
        for compliance in COMPLIANCES_OF_SPREADING {
            let outcome = again.regularize(compliance)?;
            report.iterations += outcome.iterations;
            report.products += outcome.products;
            let overlap = again.trial(self.plan.contact.overlap_tolerance)?;
            let bad = (again.passed()?.is_some(), overlap.worst);
            if best.as_ref().is_none_or(|(least, _)| bad < *least) {
                report.residual = outcome.residual;
                report.velocity_residual = outcome.residual;
                best = Some((bad, again.multipliers()?));
            }
        }
        if let Some((_, gamma)) = &best {
            again.set_multipliers(gamma);
        }
        let overlap = again.trial(self.plan.contact.overlap_tolerance)?;
        (report.passed, report.constraints) = (again.passed()?, again.constraints());
        Ok(Attempt { report, overlap, ..Attempt::default() })
    }

    /// Takes the shortest piece with daughters that turn by less than their drawn angle, if cells divide in it. Cells
    /// side by side without room between them cannot turn, and if all cells of a crowd divide at once, the constraints
    /// of many turned ones may contradict each other. Daughters that do not turn fit where their mother was.
    fn turn_less(
        &mut self,
        again: &mut dyn RetryBackend,
        piece: Piece,
        births: bool,
    ) -> Result<Option<Overlap>, Fault> {
        if !births || !piece.is_shortest() {
            return Ok(None);
        }
        for turn in LESSER_TURNS {
            match self.attempt(again, piece.turning(turn)) {
                Ok(mut tried) if tried.holds(self.plan) => {
                    tried.report.turned_less = 1;
                    return self.accept(again, tried).map(Some);
                }
                failed => self.count_failure(&failed),
            }
        }
        Ok(None)
    }

    /// Tries a piece in which cells without room wait. In a whole step first those of the wedge wait, then those of the
    /// remaining wedge, then those that overlap, those that are pressed, and all; in a shorter piece all.
    fn wait(&mut self, again: &mut dyn RetryBackend, piece: Piece) -> Result<Option<Overlap>, Fault> {
        let whole = piece.is_whole();
        let wedges = [Some(Crowd::Wedged); MOST_WEDGES];
        let others = [Some(Crowd::Overlapping), Some(Crowd::Pressed), None];
        let crowds = if whole { [wedges.as_slice(), &others].concat() } else { vec![None] };
        let mut ids: Vec<u64> = Vec::new();
        for crowd in crowds {
            self.waiting = match crowd {
                Some(crowd) => {
                    let before = ids.len();
                    ids.extend(again.crowded(crowd));
                    ids.sort_unstable();
                    ids.dedup();
                    if ids.len() == before {
                        continue;
                    }
                    Waiting::Some(ids.clone())
                }
                None => Waiting::All,
            };
            let tried = self.attempt(again, piece);
            self.report.waiting = self.report.waiting.max(self.count_waiting(again));
            match tried {
                Ok(tried) if tried.holds(self.plan) => {
                    self.waiting = Waiting::None;
                    return self.accept(again, tried).map(Some);
                }
                failed => self.count_failure(&failed),
            }
        }
        self.waiting = Waiting::None;
        self.report.waiting = 0;
        Ok(None)
    }

    fn count_waiting(&self, again: &mut dyn RetryBackend) -> usize {
        match &self.waiting {
            Waiting::None => 0,
            Waiting::Some(ids) => ids.len(),
            Waiting::All => again.bodies(),
        }
    }

    /// Handles a step whose shortest piece failed, or one in which bodies lock.
    fn give_up(
        &mut self,
        again: &mut dyn RetryBackend,
        piece: Piece,
        failed: Result<Attempt, Fault>,
    ) -> Result<Overlap, Fault> {
        if let Some(overlap) = self.disturb(again, piece, &failed)? {
            return Ok(overlap);
        }
        let mut tried = failed?;
        // Parting has no friction and would unlock what is locked.
        let locked = tried.locks();
        if !locked && let Some(overlap) = self.squeeze(again, piece, &mut tried)? {
            return Ok(overlap);
        }
        if !locked
            && self.plan.on_no_room.is_some()
            && let Some(overlap) = self.shaken(again, piece)?
        {
            return Ok(overlap);
        }
        let tolerance = self.plan.contact.overlap_tolerance;
        let only_passed =
            tried.overlap.error() <= tolerance && tried.report.settled(tolerance) && tried.report.passed.is_some();
        let overlaps = again.start_overlap() > tolerance;
        if only_passed && (overlaps || self.plan.accepts_the_least_bad()) {
            // Overlap may be unavoidable. Bodies that pass each other in short pieces are still better than in one.
            let tried = self.attempt(again, piece)?;
            return self.accept(again, tried);
        }
        let bonds = tried.overlap.worst <= tolerance && tried.overlap.stretch > tolerance;
        let of_bond = tried.overlap.bond.filter(|_| bonds);
        let wedge = again.wedge();
        let [locked_pair, locked_wall] = if locked { wedge.first_two() } else { [None; 2] };
        let unresolved = Unresolved {
            step: again.steps() + 1,
            overlap: if bonds { tried.overlap.stretch } else { tried.overlap.worst },
            bond: of_bond.map(|(name, _)| name),
            pair: tried
                .report
                .passed
                .filter(|_| only_passed)
                .map(|passed| passed.pair)
                .or(locked_pair)
                .or(of_bond.map(|(_, pair)| pair))
                .or(tried.overlap.pair),
            moved: tried.report.moved.map(|body| (body, tried.report.largest_move)),
            wall: locked_wall.or(tried.overlap.wall.filter(|_| !only_passed)),
            residual: tried.report.velocity_residual,
            passed: only_passed,
            broken: tried.broken,
            tolerance: self.plan.contact.overlap_tolerance,
            may_be_accepted: self.plan.may_accept_the_least_bad,
            hindrance: self.plan.hindrance(),
        };
        let ends = !self.plan.accepts_the_least_bad();
        // In open space, rows that would throw bodies have room, but no path to it.
        let no_way_out = self.plan.closed || !tried.throws();
        let stops = ends && no_way_out && self.plan.on_no_room == Some(OnNoRoom::Stop);
        if stops && self.fails_by_growth(again, piece, tried.badness()) {
            let (wedge, unresolved) = (Box::new(wedge), Box::new(unresolved));
            return Err(Fault::NoRoom { bodies: again.bodies(), wedge, unresolved });
        }
        Err(Fault::Unresolved(unresolved))
    }

    /// Whether the piece holds, or nearly holds, if no cell grows or divides in it: cells that fill their container
    /// overlap by about the tolerance, and contact would separate them completely.
    fn fails_by_growth(&mut self, again: &mut dyn RetryBackend, piece: Piece, with_growth: f64) -> bool {
        self.waiting = Waiting::All;
        let tried = self.attempt(again, piece);
        self.waiting = Waiting::None;
        self.count_failure(&tried);
        let most = (NEARLY_HOLDS * self.plan.contact.overlap_tolerance).min(with_growth / NEARLY_HOLDS);
        tried.is_ok_and(|tried| {
            tried.holds(self.plan) || (self.plan.closed && !tried.throws() && tried.badness() <= most)
        })
    }
}
