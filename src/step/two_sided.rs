//! Steps whose pushing contacts touch: rows are rebuilt if they push bodies that no longer touch.

use super::algorithm::{Attempt, Plan};
use super::{Fault, Model, Rows};
use crate::step::Verbs;

/// The largest final separation of a pushing contact, as a part of the thinner body's thickness.
pub(crate) const GAP: f64 = 0.02;

/// The same for bodies with rows that were tilted or caught in the attempt: these were made at a different
/// configuration than the final one, so their gap is not a slide. Otherwise two balls that a wall presses around in a
/// ball that just contains them, 1e-2 out of line, run ahead of the wall by 0.07. For all bodies it would cost a crowd
/// dozens of solves: five steps of a colony in which 2,048 cells divide take 80 s in place of 39.
const GAP_OF_REBUILT: f64 = 1e-3;

/// A step fails if a pushing contact remains this part of the thinner body's thickness apart. Loosening leaves more
/// than [`GAP`] if the objective no longer falls: of 1,200 steps of cells that fill a trap 15 do, at most 0.11 apart.
pub(crate) const TORN: f64 = 0.5;

/// A pushing contact that is this part of the thinner body's thickness apart throws its bodies: its row is rebuilt
/// before the violations of the trial are handled.
const THROW_GAP: f64 = 0.25;

/// The number of rounds in which rows that throw bodies are rebuilt a short way towards the trial; later rounds rebuild
/// them at the trial.
const MOST_CATCHES: u32 = 8;

/// The largest number of rounds in which rows that contradict each other after others were appended are rebuilt a short
/// way towards the last trial. Two balls that a wall presses around in a ball that just contains them then need no
/// random tilt in most steps. Of 25 random chambers five then end differently, with the same or smaller largest moves,
/// four with fewer products.
const MOST_FOLLOWS: u32 = 4;

/// The largest number of rounds of loosening in an attempt.
const MOST_ROUNDS: u32 = 40;

/// The last recursion that may loosen rows although bodies overlap. With 6 in place of 20, the division of 2,048 cells
/// takes a tenth more products.
const LAST_EARLY: u32 = 20;

/// Another round of loosening follows if the objective falls by at least this part of the share that the bodies of the
/// loosened rows have of it.
const LEAST_FALL: f64 = 1e-3;

/// The number of random tilts of contradictory rows.
pub(super) const MOST_TILTS: u32 = 4;
/// The largest and the smallest tilt, angles at a ball. A row that is violated by `v` between balls of radius `R` is
/// satisfied by a slide of `sqrt(2 v R)`, so the tilt is `sqrt(2 v / R)`. Each later draw assumes a violation
/// [`MORE_A_DRAW`] times larger.
const TILT: f64 = 0.15;
const LEAST_TILT: f64 = 0.01;
const MORE_A_DRAW: f64 = 4.0;

/// Whether steps of a scene loosen rows while bodies still overlap. With inertia a row of another configuration may add
/// energy; friction acts where its contacts are.
pub(super) fn loosens_early(model: &Model) -> bool {
    model.contact.rows_of_method() == Rows::Auto && !model.dynamics.has_inertia() && model.friction.is_none()
}

/// Side effects of contact on the way to a trial, beyond separating bodies. All should be small.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effect {
    /// The largest displacement of a body's centre by contact from its free motion, a length, and the body.
    pub largest_move: f64,
    /// See [`Effect::largest_move`].
    pub moved: Option<usize>,
    /// The largest separation of a pushing contact, a length, and its pair; the second may be a wall's surface. The CPU
    /// checks pairs that contact may have separated by more than 0.005 of the thinner one's thickness.
    pub push_gap: f64,
    /// See [`Effect::push_gap`].
    pub push_pair: Option<[u32; 2]>,
    /// The number of pushing contacts that are farther apart than allowed.
    pub apart: usize,
    /// The number of these that are so far apart that the step is wrong.
    pub torn: usize,
    /// The number of pushing contacts that move their bodies farther against each other than allowed.
    pub thrown: usize,
    /// The energy that contact adds, if bodies have inertia, and the part of it that the tolerances explain.
    pub energy: f64,
    /// See [`Effect::energy`].
    pub energy_allowed: f64,
    /// The largest angle by which contact turns a body of revolution about its own axis; zero in a step with friction.
    pub axial_spin: f64,
    /// What friction does; none in a step without.
    pub friction: Option<FrictionReport>,
}

/// What friction does in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionReport {
    /// Contacts that push and slide: their friction is at its limit.
    pub sliding: usize,
    /// Contacts that push and stick.
    pub sticking: usize,
    /// The energy that friction takes, `sum of -f . s` over all contacts with the slips `s`; with what the springs of
    /// stick take up.
    pub work: f64,
    /// What the law is off by, a length: the largest gap of a contact that pushes, by its rows, or slip of one that has
    /// friction left.
    pub gap: f64,
    /// Whether bodies lock: forces between them grow without bound, as they cannot slip.
    pub locked: bool,
}

/// The largest angle by which contact may turn a body of revolution about its own axis: rounding gives some 1e-15 in 64
/// bits, some 1e-7 in 32 bits.
const MOST_SPIN: f64 = 1e-5;

/// A guard on the effect of contact that an attempt breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// Contacts push bodies that are apart: far apart, or on a backend that cannot rebuild their rows.
    Apart,
    /// Contact throws a body.
    Thrown,
    /// Contact adds energy.
    Energy,
    /// Contact spins a body of revolution about its own axis.
    Spin,
    /// Bodies lock by friction.
    Locked,
}

impl Effect {
    /// Whether a guard is broken on a backend that cannot rebuild rows.
    #[cfg(feature = "gpu")]
    pub(crate) fn breaks_a_promise(&self) -> bool {
        self.broken(false).is_some()
    }

    /// The broken guard, if any. `mends`: whether the backend can rebuild rows and has done so.
    pub(super) fn broken(&self, mends: bool) -> Option<Guard> {
        // NaN breaks a guard.
        let within = |number: f64, most: f64| number <= most;
        if self.torn > 0 || (!mends && self.apart > 0) {
            Some(Guard::Apart)
        } else if self.thrown > 0 {
            Some(Guard::Thrown)
        } else if !within(self.energy, self.energy_allowed) {
            Some(Guard::Energy)
        } else if !within(self.axial_spin, MOST_SPIN) {
            Some(Guard::Spin)
        } else if self.friction.is_some_and(|friction| friction.locked) {
            Some(Guard::Locked)
        } else {
            None
        }
    }
}

/// The result of a round of loosening.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loosened {
    /// The number of rows rebuilt.
    pub rows: usize,
    /// The share of the objective of their bodies.
    pub share: f64,
}

/// Methods of a backend that can rebuild rows.
pub trait TwoSided {
    /// `1/2 |J^T gamma|^2` at the trial: half the square of the displacement by contact from the free motion, in the
    /// metric of the mobility.
    fn objective(&self) -> f64;
    /// Whether a pushing contact can be farther apart at the trial than the part `gap` of its thinner body's thickness,
    /// judged from the relative motion of its bodies.
    fn throws(&self, gap: f64) -> bool;
    /// Rebuilds the rows of each pushing branch that is farther apart at the trial than the part `gap` of its thinner
    /// body's thickness, a short way towards the trial: bodies move by at most the part `size` of half of their
    /// thickness. Returns the number of rows.
    fn catch(&mut self, gap: f64, size: f64) -> usize;
    /// Whether a pushing contact moves its bodies, which have no inertia, farther against each other at the trial than
    /// allowed.
    fn moves_too_far(&self) -> bool;
    /// Replaces the rows of each pushing branch that is farther apart at the trial than the part `gap` of its thinner
    /// body's thickness, or the part `of_rebuilt` if rows of one of its bodies were rebuilt elsewhere in this attempt,
    /// by one row made there.
    fn loosen(&mut self, gap: f64, of_rebuilt: f64) -> Loosened;
    /// The thickness of the thinnest body, a length.
    fn thinnest(&self) -> f64;
    /// Rebuilds the contradictory rows, identified by their multipliers, a short way towards the last trial, like
    /// [`TwoSided::catch`]. Returns their number.
    fn follow(&mut self, size: f64) -> usize;
    /// Rebuilds the contradictory rows, identified by their multipliers, at a random configuration near the start: a
    /// body of radius `R`, half of its thickness, moves sideways by the part `size(R)` of it. Returns their number.
    fn tilt(&mut self, draw: u32, size: &dyn Fn(f64) -> f64) -> usize;
    /// Saves the present rows and multipliers.
    fn keep_rows(&mut self);
    /// Restores the saved rows and multipliers.
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

/// The state of rebuilding rows in an attempt.
#[derive(Default)]
pub(super) struct Sides {
    /// The objective of the saved rows, and the share of it of the bodies whose rows were then loosened.
    kept: Option<[f64; 2]>,
    rounds: u32,
    tilts: u32,
    catches: u32,
    follows: u32,
    /// The smallest violation of contradictory rows before the first tilt.
    violation: Option<f64>,
}

impl Sides {
    /// Loosens rows that push bodies apart that no longer touch at the trial. Returns whether there is something to
    /// solve.
    pub fn loosen(&mut self, backend: &mut dyn Verbs, plan: &Plan, tried: &mut Attempt) -> Result<bool, Fault> {
        if !plan.two_sided {
            return Ok(false);
        }
        let holds = tried.overlap.error() <= plan.contact.overlap_tolerance
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
        let Loosened { rows, share } = two_sided.loosen(GAP, GAP_OF_REBUILT);
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

    /// Loosens rows of a trial that still overlaps, by less than the gap that a push may end with: it is near enough to
    /// the step's end to show which pushes come apart, and whether the step throws bodies. What that makes of the
    /// objective is not checked. Returns whether bodies are thrown: then the attempt ends, and shorter pieces follow.
    pub fn loosen_early(&self, backend: &mut dyn Verbs, plan: &Plan, tried: &mut Attempt) -> Result<bool, Fault> {
        if !plan.loosens_early || self.kept.is_some() || !(1..=LAST_EARLY).contains(&tried.report.recursions) {
            return Ok(false);
        }
        let Some(two_sided) = backend.two_sided() else { return Ok(false) };
        if tried.overlap.error() > GAP * two_sided.thinnest() {
            return Ok(false);
        }
        // Cells in a chamber that are thrown here often stay once rows are loosened: with this end `two-strains` takes
        // 290 pieces more than steps, without it 136.
        if plan.on_no_room.is_none() && two_sided.moves_too_far() {
            log::trace!("ends early: bodies are thrown");
            return Ok(true);
        }
        if !two_sided.throws(GAP) {
            return Ok(false);
        }
        let Loosened { rows, .. } = two_sided.loosen(GAP, GAP_OF_REBUILT);
        if rows > 0 {
            log::trace!("loosens {rows} rows early");
            tried.forget_least_bad();
        }
        tried.report.loosened += rows as u32;
        Ok(false)
    }

    /// Rebuilds rows that throw bodies, and returns how to continue. A backend that cannot rebuild rows leaves the step
    /// to one that can, so both give the same result.
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
        // Rows made far away have nearly equal normals; rows made a short way from the trial are good.
        let rows = if self.catches < MOST_CATCHES {
            two_sided.catch(THROW_GAP, TILT)
        } else {
            two_sided.loosen(THROW_GAP, THROW_GAP).rows
        };
        log::trace!("catches {rows} rows, objective {before:.3e}");
        if rows > 0 {
            tried.forget_least_bad();
        }
        // If no rows were rebuilt, all are where they were made, and a gap is a slide.
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
        // Rows that had a common solution until others were appended are rebuilt towards that solution.
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
