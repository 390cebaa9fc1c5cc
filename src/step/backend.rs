//! The verbs of a timestep. A backend holds the state and carries them out; `step::step` says in which order.

use super::{Crowd, Fault, Passed, Phases, Piece, State, TwoSided};
use crate::bodies::{Bodies, Lineage};
use crate::dynamics::Waiting;
use crate::lcp::{Outcome, Stored};
use crate::step::{Effect, Wedge};

/// Overlaps of a trial configuration, over all pairs of bodies and all bodies with walls, including pairs that were not
/// near at the step's start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overlap {
    /// The largest overlap of two smooth surfaces, or of one with a wall, zero where none do; a length.
    pub worst: f64,
    /// The pair that overlaps most, where it is one of two bodies.
    pub pair: Option<[usize; 2]>,
    /// The body and the wall that overlap most, where it is those.
    pub wall: Option<[usize; 2]>,
    /// Pairs that overlap by more than was asked about.
    pub violations: usize,
    /// The largest overlap of two sub-spheres, where rows are made from them.
    pub proxy: Option<f64>,
}

/// Words that processes tell each other of a life that ended.
pub const JOINED: usize = 10;

/// A mother that divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Divided {
    /// Her number, which one of her daughters has now.
    pub number: u32,
    /// Her line.
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
        // A daughter has her mother's place.
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

/// The verbs of a timestep, in the order in which a step uses them.
pub trait Backend: Send {
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
    /// Solves the LCP of all rows in the sense of the least overlap, where [`Backend::solve`] failed: rows that
    /// contradict each other are violated as little as can be, by forces with a bound. A row is violated by up to
    /// `allowed` where that keeps forces small. None where the backend cannot: [`Backend::take_again`] then has one
    /// that can.
    fn relax(&mut self, _allowed: f64) -> Result<Option<Outcome>, Fault> {
        Ok(None)
    }
    /// Moves to the trial `C(U)` and measures all overlaps there; those of more than `violating` are violations.
    fn trial(&mut self, violating: f64) -> Result<Overlap, Fault>;
    /// Makes one row for every violation of the trial, with multiplier zero.
    fn append_violations(&mut self) -> Result<(), Fault>;
    /// For every violation of the trial: moves the offset of its first row so that it is exact there, where
    /// that row has the overlap's direction; else makes one more row, as [`Backend::append_violations`].
    fn tighten_violations(&mut self) -> Result<(), Fault>;
    /// What contact does on the way to the trial. Contacts that push may end the part `gap` of their thinner body's
    /// thickness apart.
    fn effect(&mut self, gap: f64) -> Result<Effect, Fault>;
    /// What makes rows anew; none of a backend that cannot.
    fn two_sided(&mut self) -> Option<&mut dyn TwoSided> {
        None
    }
    /// Whether a contact that pushes is farther apart at the trial than the part `gap` of its thinner body's thickness.
    /// Asked only of a backend that cannot make rows anew: it leaves such a step to one that can.
    fn throws(&mut self, _gap: f64) -> Result<bool, Fault> {
        Ok(false)
    }
    /// The pairs that pass each other between the step's start and the trial.
    fn passed(&mut self) -> Result<Option<Passed>, Fault>;
    /// Makes the trial the state and returns the wall time by phase since the last acceptance.
    fn accept(&mut self) -> Result<Phases, Fault>;
    /// Calls `take` to repeat a failed step from the last accepted state. The CPU passes itself; a device passes a CPU
    /// backend and loads the state that `take` leaves. A fault of `take` leaves the last accepted state.
    fn take_again(&mut self, take: &mut dyn FnMut(&mut dyn RetryBackend) -> Result<(), Fault>) -> Result<(), Fault>;
    /// The present multipliers, a row each.
    fn multipliers(&self) -> Result<Vec<f64>, Fault>;
    /// The present LCP with its multipliers and the `start` that they came from, rows in the order of
    /// [`Backend::multipliers`].
    fn stored_lcp(&self, start: Vec<f64>) -> Result<Stored, Fault>;
    /// How many rows there are.
    fn constraints(&self) -> usize;
    /// Steps accepted so far, those before a resumption too.
    fn steps(&self) -> u64;
    /// Bodies after the last accepted step.
    fn bodies(&self) -> usize;
    /// The state after the last accepted step; from a device it is read at the first call after a step.
    fn state(&self) -> Result<&State, Fault>;
    /// Adds an external force.
    fn add_force(&mut self, force: Box<dyn crate::dynamics::ForceField>);
    /// Gives away the forces that were added.
    fn take_forces(&mut self) -> Vec<Box<dyn crate::dynamics::ForceField>>;
    /// Goes on from a state of the same scene that another backend left.
    fn go_on_from(&mut self, state: State) -> Result<(), Fault>;
    /// Whether to retry the attempt that failed, with a larger halo.
    fn begins_anew(&self) -> bool {
        false
    }
    /// Whether other processes have a part of the present attempt, so that nothing of it is of use where the step is
    /// taken again.
    fn is_shared_out(&self) -> bool {
        false
    }
    /// Whether other processes must be asked for the state, all of them together.
    fn is_partial(&self) -> bool {
        false
    }
    /// The bodies after the last accepted step, which need nobody else.
    fn placed(&self) -> Result<&Bodies, Fault> {
        Ok(&self.state()?.bodies)
    }
    /// The bodies after the last accepted step that this process has: all, or where processes share them its own and
    /// copies of some others.
    fn here(&self) -> Result<&Bodies, Fault> {
        self.placed()
    }
    /// Lines and groups of the bodies that are [here](Backend::here).
    fn identities(&self) -> Result<(&[Lineage], &[u32]), Fault> {
        let bodies = self.here()?;
        Ok((&bodies.lineage, &bodies.group))
    }
    /// The number among all of a body that is [here](Backend::here); none of a copy.
    fn number(&self, i: usize) -> Option<usize> {
        Some(i)
    }
    /// What all processes have, in order, where they share the bodies.
    fn join(&self, own: Vec<[u64; JOINED]>) -> Vec<[u64; JOINED]> {
        own
    }
    /// The mothers that divided in the last step, of this process's bodies; `before` are the lines of all bodies before
    /// it, where this process had them.
    fn divided(&mut self, before: &[Lineage]) -> Result<Vec<Divided>, Fault> {
        let (lineage, group) = self.identities()?;
        Ok(Divided::between(before, lineage, group))
    }
    /// Removes from the state after the last accepted step those bodies that are [here](Backend::here) and are not to
    /// be kept, as [`State::remove`] does.
    fn remove(&mut self, keep: &[bool], removed: &[u64]) -> Result<(), Fault>;
    /// The device that computes, where one does.
    fn device(&self) -> Option<&crate::gpu::Gpu> {
        None
    }
    /// The numbers that it computes with.
    fn precision(&self) -> crate::gpu::Precision {
        crate::gpu::Precision::F64
    }
}

/// What a backend can do beside that to take a step that failed again, in pieces.
pub trait RetryBackend: Backend {
    /// Says what the next [`Backend::begin`] begins: without it, the whole step with no cell waiting.
    fn prepare(&mut self, piece: Piece, waiting: &Waiting);
    /// Says whether bodies are parted from now on: nothing drives them, they have drag and no inertia, and an accepted
    /// trial takes no time and leaves velocities as they are.
    fn part(&mut self, parting: bool);
    /// Goes back to an accepted state.
    fn restore(&mut self, state: &State);
    /// Takes these multipliers; rows beyond them have none.
    fn set_multipliers(&mut self, gamma: &[f64]);
    /// Solves the LCP of all rows, which give way by the part `compliance` of what their own multipliers move them by.
    fn give_way(&mut self, compliance: f64) -> Result<Outcome, Fault>;
    /// The ids of the bodies of a crowd at the last trial, sorted: of a daughter that was born in this piece, her
    /// mother's.
    fn crowded(&self, crowd: Crowd) -> Vec<u64>;
    /// The bodies that have no way out at the last solve, as its multipliers show.
    fn wedge(&self) -> Wedge;
    /// Whether cells divide in the present piece.
    fn has_births(&self) -> bool;
    /// The deepest overlap at the start of the present piece.
    fn start_overlap(&self) -> f64;
    /// This, as a backend.
    fn backend(&mut self) -> &mut dyn Backend;
}
