//! Steps whose pushing contacts touch: rows that push bodies that no longer touch are rebuilt.

use super::Fault;
use super::algorithm::{Attempt, Plan};
use crate::step::Verbs;

/// A contact that pushes may end this part of the thinner body's thickness apart.
pub(crate) const GAP: f64 = 0.02;

/// The same where rows were tilted or caught in the attempt: they were made at another place than where bodies end, and
/// a gap of theirs is no slide. Two balls that a wall presses around in a ball that just holds them, 1e-2 out of line,
/// otherwise run ahead of the wall by 0.07.
const GAP_OF_REBUILT: f64 = 1e-3;

/// A contact that pushes may not stay this part of the thinner body's thickness apart. Loosening leaves more where the
/// objective no longer falls: of 1,200 steps of cells that fill a trap 15 end over [`GAP`], at most 0.11 apart.
pub(crate) const TORN: f64 = 0.5;

/// A contact that pushes and is this part of the thinner body's thickness apart throws its bodies: its row is rebuilt
/// before the violations of the trial are answered.
const THROW_GAP: f64 = 0.25;

/// Rounds in which rows that throw bodies are rebuilt a short way towards the trial; after these they are rebuilt at
/// the trial.
const MOST_CATCHES: u32 = 8;

/// Rounds in which rows that contradict each other since some were appended are rebuilt a short way towards the last
/// trial. Two balls that a wall presses around in a ball that just holds them then need no draw in most steps. Of 25
/// drawn chambers five then end otherwise, with the same largest moves or smaller ones, four with fewer products.
const MOST_FOLLOWS: u32 = 4;

/// Rounds of loosening in an attempt, in all.
const MOST_ROUNDS: u32 = 40;

/// A round of loosening is worth another if the objective falls by this part of what the bodies of the loosened rows
/// have of it.
const LEAST_FALL: f64 = 1e-3;

/// Draws for rows that contradict each other, and by how much they are tilted: the angle at a ball.
pub(super) const MOST_TILTS: u32 = 4;
/// No more than what mends them asks for: a row that is violated by `v` between balls of radius `R` is mended by a
/// slide of `sqrt(2 v R)`. Each draw is for so many times more.
const TILT: f64 = 0.15;
const LEAST_TILT: f64 = 0.01;
const MORE_A_DRAW: f64 = 4.0;

/// What contact does on the way to a trial, beside parting bodies. All of it is to be little.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effect {
    /// The farthest that contact moves a body's centre from where its free motion leads, a length, and the body.
    pub largest_move: f64,
    /// See [`Effect::largest_move`].
    pub moved: Option<usize>,
    /// The largest separation of a contact that pushes, a length, and its pair; the second may be a wall's surface. The
    /// CPU looks where contact may have parted bodies by more than 0.005 of the thinner one's thickness.
    pub push_gap: f64,
    /// See [`Effect::push_gap`].
    pub push_pair: Option<[u32; 2]>,
    /// How many contacts that push are farther apart than may be.
    pub apart: usize,
    /// How many of them are so far apart that the step cannot be right.
    pub torn: usize,
    /// How many contacts that push move their bodies farther against each other than may be.
    pub thrown: usize,
    /// The energy that contact adds, where bodies have inertia, and how much of it what it may leave undone explains.
    pub energy: f64,
    /// See [`Effect::energy`].
    pub energy_allowed: f64,
    /// The largest angle by which contact turns a body of revolution about its own axis.
    pub axial_spin: f64,
}

/// An angle by which contact may turn a body of revolution about its own axis: in 64-bit numbers rounding makes some
/// 1e-15, in 32 bits some 1e-7.
const MOST_SPIN: f64 = 1e-5;

/// A promise about what contact does that an attempt breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// Contacts push bodies that are apart: by far, or on a backend that cannot rebuild their rows.
    Apart,
    /// Contact throws a body.
    Thrown,
    /// Contact adds energy.
    Energy,
    /// Contact spins a body of revolution about its own axis.
    Spin,
}

impl Effect {
    /// Whether a promise is broken on a backend that cannot rebuild rows.
    #[cfg(feature = "gpu")]
    pub(crate) fn breaks_a_promise(&self) -> bool {
        self.broken(false).is_some()
    }

    /// The promise that is broken. `mends` is whether the backend can rebuild rows and has done so.
    pub(super) fn broken(&self, mends: bool) -> Option<Guard> {
        // Not a number breaks them.
        let within = |number: f64, most: f64| number <= most;
        if self.torn > 0 || (!mends && self.apart > 0) {
            Some(Guard::Apart)
        } else if self.thrown > 0 {
            Some(Guard::Thrown)
        } else if !within(self.energy, self.energy_allowed) {
            Some(Guard::Energy)
        } else if !within(self.axial_spin, MOST_SPIN) {
            Some(Guard::Spin)
        } else {
            None
        }
    }
}

/// What a round of loosening did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loosened {
    /// The number of rows rebuilt.
    pub rows: usize,
    /// The part of the objective that their bodies have.
    pub share: f64,
}

/// Methods of a backend that can rebuild rows.
pub trait TwoSided {
    /// `1/2 |J^T gamma|^2` at the trial: half the square of how far contact moves the bodies from their free motion.
    fn objective(&self) -> f64;
    /// Whether a contact that pushes can be farther apart at the trial than the part `gap` of its thinner body's
    /// thickness, by how far its bodies move against each other.
    fn throws(&self, gap: f64) -> bool;
    /// Rebuilds the rows of each branch that pushes and is farther apart at the trial than the part `gap` of its
    /// thinner body's thickness, a short way towards the trial: bodies move there by at most the part `size` of half of
    /// their thickness. Returns their number.
    fn catch(&mut self, gap: f64, size: f64) -> usize;
    /// Puts one row made at the trial in the place of the rows of each branch that pushes and is farther apart there
    /// than the part `gap` of its thinner body's thickness.
    fn loosen(&mut self, gap: f64) -> Loosened;
    /// Rebuilds the rows that contradict each other, by their multipliers, a short way towards the last trial, as
    /// [`TwoSided::catch`] does. Returns their number.
    fn follow(&mut self, size: f64) -> usize;
    /// Rebuilds the rows that contradict each other, by their multipliers, at a configuration drawn near the start: a
    /// body of radius `R`, half of its thickness, is moved sideways by the part `size(R)` of it. Returns their number.
    fn tilt(&mut self, draw: u32, size: &dyn Fn(f64) -> f64) -> usize;
    /// Keeps the present rows and multipliers.
    fn keep_rows(&mut self);
    /// Goes back to those kept.
    fn go_back(&mut self);
}

/// The outcome of a check for thrown bodies.
pub(super) enum Caught {
    Nothing,
    /// Rows were rebuilt: there is something to solve.
    Rows,
    /// The attempt ends here; a backend that can rebuild rows takes the step.
    Left,
}

/// What an attempt did on the second side.
#[derive(Default)]
pub(super) struct Sides {
    /// The objective of the rows that are kept, and the part of it that bodies of rows had that were then loosened.
    kept: Option<[f64; 2]>,
    rounds: u32,
    tilts: u32,
    catches: u32,
    follows: u32,
    /// By how much rows that contradict each other were violated at least, before the first tilt.
    violation: Option<f64>,
}

impl Sides {
    /// Loosens rows that push bodies that are apart at the trial. Returns whether there is something to solve.
    pub fn loosen(&mut self, backend: &mut dyn Verbs, plan: &Plan, tried: &mut Attempt) -> Result<bool, Fault> {
        if !plan.two_sided {
            return Ok(false);
        }
        let holds = tried.overlap.worst <= plan.contact.overlap_tolerance
            && tried.report.settled(plan.contact.overlap_tolerance);
        let Some(two_sided) = backend.two_sided() else { return Ok(false) };
        let now = two_sided.objective();
        if let Some([kept, share]) = self.kept {
            let falls = holds && now <= kept;
            log::trace!("loosened: objective {kept:.3e} -> {now:.3e} (share {share:.3e}), holds {holds}");
            if !falls {
                two_sided.go_back();
                tried.forget_least_bad();
                self.kept = None;
                self.rounds = MOST_ROUNDS;
                let overlap = backend.trial(plan.contact.overlap_tolerance)?;
                tried.report.velocity_residual = 0.0;
                tried.see(backend, plan, overlap)?;
                return Ok(false);
            }
            if now > kept - LEAST_FALL * share {
                return Ok(false);
            }
        }
        if !holds || self.rounds >= MOST_ROUNDS {
            return Ok(false);
        }
        two_sided.keep_rows();
        let gap = if self.tilts + self.catches > 0 { GAP_OF_REBUILT } else { GAP };
        let Loosened { rows, share } = two_sided.loosen(gap);
        if rows == 0 {
            return Ok(false);
        }
        log::trace!("loosens {rows} rows");
        self.kept = Some([now, share]);
        tried.forget_least_bad();
        self.rounds += 1;
        tried.report.loosened += rows as u32;
        Ok(true)
    }

    /// Rebuilds rows that throw bodies and returns what to do next. A backend that cannot leaves the step to one that
    /// can, so both give the same result.
    pub fn catch(&mut self, backend: &mut dyn Verbs, plan: &Plan, tried: &mut Attempt) -> Result<Caught, Fault> {
        if !plan.two_sided || self.rounds >= MOST_ROUNDS {
            return Ok(Caught::Nothing);
        }
        let Some(two_sided) = backend.two_sided() else {
            tried.left = backend.throws(THROW_GAP)?;
            return Ok(if tried.left { Caught::Left } else { Caught::Nothing });
        };
        if !two_sided.throws(THROW_GAP) {
            return Ok(Caught::Nothing);
        }
        let before = two_sided.objective();
        // From far away all directions look alike. Where a way back is short, what is made there is good.
        let rows = if self.catches < MOST_CATCHES {
            two_sided.catch(THROW_GAP, TILT)
        } else {
            two_sided.loosen(THROW_GAP).rows
        };
        log::trace!("catches {rows} rows, objective {before:.3e}");
        if rows > 0 {
            tried.forget_least_bad();
        }
        // Where none was, rows are where they were made, and a gap is a slide.
        self.catches += u32::from(rows > 0);
        self.rounds += u32::from(rows > 0);
        tried.report.loosened += rows as u32;
        Ok(if rows > 0 { Caught::Rows } else { Caught::Nothing })
    }

    /// Tilts the rows that push most once, if the plan requires it. Returns whether there is something to solve.
    pub fn disturb(&mut self, backend: &mut dyn Verbs, plan: &Plan, tried: &mut Attempt) -> bool {
        let (Some(draw), 0) = (plan.disturbed, self.tilts) else { return false };
        let Some(two_sided) = backend.two_sided() else { return false };
        let rows = two_sided.tilt(MOST_TILTS + draw, &|_| TILT);
        tried.forget_least_bad();
        self.tilts += 1;
        tried.report.tilts += 1;
        rows > 0
    }

    /// Tilts contradictory rows. Returns whether there is something to solve.
    pub fn tilt(&mut self, backend: &mut dyn Verbs, plan: &Plan, tried: &mut Attempt, violation: f64) -> bool {
        if !plan.two_sided || self.tilts >= plan.most_tilts {
            return false;
        }
        let Some(two_sided) = backend.two_sided() else { return false };
        // Rows that had a common solution until some were appended are rebuilt at that solution.
        if tried.report.recursions > 0 && self.follows < MOST_FOLLOWS {
            self.follows += 1;
            let rows = two_sided.follow(TILT);
            log::trace!("follows with {rows} rows");
            if rows > 0 {
                tried.forget_least_bad();
                self.catches += 1;
                return true;
            }
        }
        let violation = *self.violation.get_or_insert(violation) * MORE_A_DRAW.powi(self.tilts as i32);
        let rows = two_sided.tilt(self.tilts, &|radius| (2.0 * violation / radius).sqrt().clamp(LEAST_TILT, TILT));
        log::trace!("tilts {rows} rows");
        tried.forget_least_bad();
        self.tilts += 1;
        tried.report.tilts += 1;
        rows > 0
    }
}
