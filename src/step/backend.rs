//! What computes a simulation answers three questions, a trait each: how a stage of a step is carried out ([`Verbs`]),
//! what the state is between two steps ([`Keeper`]), and how a step is taken ([`Stepper`]).

use super::{Crowd, Effect, Fault, Keep, Passed, Phases, Piece, Plan, Shake, State, StepReport, TwoSided, Wedge};
use crate::bodies::{Bodies, Lineage};
use crate::dynamics::{BondName, ForceField, Waiting};
use crate::fields::Concentration;
use crate::gpu::{Gpu, Precision};
use crate::lcp::{Outcome, Stored};

/// Overlaps of a trial configuration, over all pairs of bodies and all bodies with walls, including pairs that were not
/// near at the step's start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overlap {
    /// The largest overlap of two smooth surfaces, or of one with a wall, zero where none do; a length.
    pub worst: f64,
    /// The pair that overlaps most, if it is one of two bodies.
    pub pair: Option<[usize; 2]>,
    /// The body and the wall that overlap most, if it is these.
    pub wall: Option<[usize; 2]>,
    /// Pairs that overlap by more than the given limit.
    pub violations: usize,
    /// The largest overlap of two sub-spheres, where rows are made from them.
    pub proxy: Option<f64>,
    /// By how much the worst implicit bond is off its length and its direction, a length.
    pub stretch: f64,
    /// The name of that bond, and its bodies.
    pub bond: Option<(BondName, [usize; 2])>,
}

impl Overlap {
    /// The larger of the overlap and of what bonds are off by, a length.
    pub fn error(&self) -> f64 {
        self.worst.max(self.stretch)
    }
}

/// Words of a life that ended, in messages between processes.
pub const LIFE_WORDS: usize = 10;

/// A mother that divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Divided {
    /// Her index, which one of her daughters has now.
    pub number: u32,
    /// Her lineage.
    pub line: Lineage,
    /// Her group.
    pub group: u32,
    /// When.
    pub time: f64,
}

impl Divided {
    /// Those between the lines of all bodies `before` a step and after it.
    pub fn between(before: &[Lineage], after: &[Lineage], group: &[u32]) -> Vec<Divided> {
        let all = (0..).zip(before).zip(after).zip(group);
        let divided = all.filter(|(((_, mother), daughter), _)| daughter.id != mother.id);
        // A daughter takes her mother's index.
        divided
            .map(|(((number, mother), daughter), group)| Divided {
                number,
                line: *mother,
                group: *group,
                time: daughter.birth,
            })
            .collect()
    }
}

/// Lines and groups of the bodies that a process has.
pub struct Lives<'a> {
    /// Their lines.
    pub lineage: &'a [Lineage],
    /// Their groups.
    pub group: &'a [u32],
    /// Their global indices, none for a copy of another process's body; without it, these are all bodies.
    numbers: Option<Vec<Option<usize>>>,
}

impl<'a> Lives<'a> {
    /// Of all bodies.
    pub fn of_all(lineage: &'a [Lineage], group: &'a [u32]) -> Self {
        Lives { lineage, group, numbers: None }
    }

    /// Of bodies with these global indices, none for a copy.
    #[cfg(feature = "mpi")]
    pub fn of_some(lineage: &'a [Lineage], group: &'a [u32], numbers: Vec<Option<usize>>) -> Self {
        Lives { lineage, group, numbers: Some(numbers) }
    }

    /// The number among all of a body here; none of a copy.
    pub fn number(&self, i: usize) -> Option<usize> {
        self.numbers.as_ref().map_or(Some(i), |numbers| numbers[i])
    }
}

/// Has the state after the last accepted step.
pub trait Keeper: Send {
    /// Steps accepted so far, those before a resumption too.
    fn steps(&self) -> u64;
    /// Bodies after the last accepted step.
    fn bodies(&self) -> usize;
    /// The state after the last accepted step. It is read from a device at the first call after a step. On several
    /// processes the call is collective, and rank 0 gets the state.
    fn state(&self) -> Result<&State, Fault>;
    /// Goes on from a state of the same scene that another has left, or this one before.
    fn restore(&mut self, state: &State) -> Result<(), Fault>;
    /// Adds an external force.
    fn add_force(&mut self, force: Box<dyn ForceField>);
    /// Takes out the forces that were added.
    fn take_forces(&mut self) -> Vec<Box<dyn ForceField>>;
    /// All bodies. Processes that share them must ask together.
    fn all_bodies(&self) -> Result<&Bodies, Fault>;
    /// All bodies, if they need not be gathered or read back.
    fn known_bodies(&self) -> Option<&Bodies>;
    /// The bodies here: all, or where processes share them those of this one and copies of some others.
    fn local_bodies(&self) -> Result<&Bodies, Fault>;
    /// The lives of the bodies [here](Keeper::local_bodies), in their order.
    fn lives(&self) -> Result<Lives<'_>, Fault>;
    /// The local mothers that divided in the last step; `before` are the lineages of all local bodies before it.
    fn divided(&mut self, before: &[Lineage]) -> Result<Vec<Divided>, Fault>;
    /// The lives that ended of all processes, in order, from those that ended here.
    fn all_gather(&self, own: Vec<[u64; LIFE_WORDS]>) -> Vec<[u64; LIFE_WORDS]>;
    /// Sets the concentrations of the scene's fields.
    fn set_fields(&mut self, fields: Vec<Concentration>);
    /// Removes those bodies [here](Keeper::local_bodies) that are not to be kept, as [`State::remove`] does.
    fn remove(&mut self, keep: &[bool], removed: &[u64]) -> Result<(), Fault>;
}

/// The verbs of an attempt at a step, in the order in which `step` uses them.
pub trait Verbs: Keeper {
    /// Growth and division, then forces, effective mobilities and free velocities at `C^k`: those of the whole step, or
    /// where it has a middle those of its first half.
    fn begin(&mut self) -> Result<(), Fault>;
    /// Makes `C(U)` of the first half the step's middle `C_h`: forces and effective mobilities there, the free velocity
    /// of the whole step from `C^k`. No row is left.
    fn middle(&mut self) -> Result<(), Fault>;
    /// Finds all near pairs at `C^k`, or at `C_h` where the middle is made, and makes their rows, with the multipliers
    /// that these pairs ended the last step or the first half with.
    fn append_near(&mut self) -> Result<(), Fault>;
    /// Solves the LCP of all rows to a residual, from the present multipliers, for the total velocity `U`.
    fn solve(&mut self, tolerance: f64) -> Result<Outcome, Fault>;
    /// Solves the LCP of all rows in the sense of the least overlap, where [`Verbs::solve`] failed: rows that
    /// contradict each other are violated as little as can be, by forces with a bound. A row is violated by up to
    /// `allowed` where that keeps forces small. None where the backend cannot: [`Verbs::take_again`] then has one
    /// that can.
    fn relax(&mut self, allowed: f64) -> Result<Option<Outcome>, Fault>;
    /// Moves to the trial `C(U)` and measures all overlaps there; those of more than `violating` are violations.
    fn trial(&mut self, violating: f64) -> Result<Overlap, Fault>;
    /// Makes one row for every violation of the trial, with multiplier zero. `over_corrects`: rows ask for the
    /// `Surplus` of the thinnest body.
    fn append_violations(&mut self, over_corrects: bool) -> Result<(), Fault>;
    /// For every violation of the trial: moves the offset of its first row so that it is exact there, where
    /// that row has the overlap's direction; else makes one more row, as [`Verbs::append_violations`].
    fn tighten_violations(&mut self) -> Result<(), Fault>;
    /// Makes the rows of all implicit bonds again at the trial. A backend without them does nothing.
    fn renew_bonds(&mut self) -> Result<(), Fault> {
        Ok(())
    }
    /// What contact does on the way to the trial. Contacts that push may end the part `gap` of their thinner body's
    /// thickness apart.
    fn effect(&mut self, gap: f64) -> Result<Effect, Fault>;
    /// The backend's [`TwoSided`] methods; none if it cannot rebuild rows.
    fn two_sided(&mut self) -> Option<&mut dyn TwoSided>;
    /// Whether a contact that pushes is farther apart at the trial than the part `gap` of its thinner body's thickness.
    /// For a backend that cannot rebuild rows: it leaves such a step to one that can.
    fn throws(&mut self, gap: f64) -> Result<bool, Fault>;
    /// The pairs that pass each other between the step's start and the trial.
    fn passed(&mut self) -> Result<Option<Passed>, Fault>;
    /// Makes the trial the state and returns the wall time by phase since the last acceptance.
    fn accept(&mut self) -> Result<Phases, Fault>;

    /// How many bonds broke when the last trial was accepted; zero where that is not counted.
    fn broken_bonds(&self) -> u32 {
        0
    }
    /// Calls `take` to repeat a failed step from the last accepted state. The CPU passes itself; a device passes a CPU
    /// backend and loads the state that `take` leaves. A fault of `take` leaves the last accepted state.
    fn take_again(&mut self, take: &mut Take<'_>) -> Result<(), Fault>;
    /// The present multipliers, a row each.
    fn multipliers(&self) -> Result<Vec<f64>, Fault>;
    /// The present LCP with its multipliers and the `start` that they came from, rows in the order of
    /// [`Verbs::multipliers`].
    fn stored_lcp(&self, start: Vec<f64>) -> Result<Stored, Fault>;
    /// How many rows there are, of all processes.
    fn constraints(&self) -> usize;
}

/// What made the failed attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failed {
    /// The backend that takes the step again.
    Itself,
    /// Several processes: nothing of the attempt helps one that takes the step alone.
    Together,
    /// A device; the CPU takes the step instead.
    OnDevice,
}

/// What takes a failed step again.
pub type Take<'a> = dyn FnMut(&mut dyn RetryBackend, Failed) -> Result<(), Fault> + 'a;

/// What the CPU can do beside the verbs to take a step that failed again, in pieces.
pub trait RetryBackend: Verbs {
    /// Sets the piece that the next [`Verbs::begin`] begins; by default the whole step with no cell waiting.
    fn prepare(&mut self, piece: Piece, waiting: &Waiting);
    /// Switches the separation of overlapping bodies on or off: then nothing drives bodies, they have drag and no
    /// inertia, and an accepted trial takes no time and keeps velocities.
    fn part(&mut self, parting: bool);
    /// Sets the draw that moves bodies while they are parted, or none.
    fn shake(&mut self, shake: Option<Shake>);
    /// Switches restitution on or off, in a scene that has some.
    fn bounce(&mut self, bouncing: bool);
    /// Sets the multipliers; further rows get zero.
    fn set_multipliers(&mut self, gamma: &[f64]);
    /// Solves the regularized LCP of all rows: `compliance` is relative to each row's diagonal entry.
    fn regularize(&mut self, compliance: f64) -> Result<Outcome, Fault>;
    /// The sorted ids of the bodies of a crowd at the last trial; for a daughter born in this piece, her mother's.
    fn crowded(&self, crowd: Crowd) -> Vec<u64>;
    /// The bodies without a way out at the last solve, from its multipliers.
    fn wedge(&self) -> Wedge;
    /// Whether cells divide in the present piece.
    fn has_births(&self) -> bool;
    /// The deepest overlap at the start of the present piece.
    fn start_overlap(&self) -> f64;
    /// The deepest overlap of the state before the step: cells do not grow or divide in it yet.
    fn rest_overlap(&self) -> f64;
}

/// Takes steps: a simulation's interface to its backend.
pub trait Stepper: Keeper {
    /// Takes one step and reports it. A fault leaves the last accepted state. `keep` stores the LCPs that it selects.
    fn step(&mut self, plan: &Plan, keep: &mut Keep) -> Result<StepReport, Fault>;
    /// The device that computes, if one does.
    fn device(&self) -> Option<&Gpu>;
    /// The precision that it computes in.
    fn precision(&self) -> Precision;
}
