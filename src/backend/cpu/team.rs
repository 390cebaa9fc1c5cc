//! The processes that take a step together, each with some of the bodies.

use super::setup::Setup;
use super::start::Start;
use crate::bisection::bisect;
use crate::bodies::{Bodies, Lineage};
use crate::broad_phase::{Aabb, Candidates};
use crate::dynamics::{Twist, Waiting};
use crate::lcp::{Alone, Places, Portion};
use crate::periodic::CellShear;
use crate::step::{Divided, Effect, Fault, JOINED, Lives, Overlap, Piece, State, StepReport};
use crate::walls::Walls;
use crate::warm::Warm;
use std::borrow::Cow;

/// A fault of a body, before it has a message: which of the faults that are looked for together, the body, and a
/// number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trouble {
    pub(super) kind: u8,
    pub(super) body: usize,
    pub(super) number: f64,
}

/// The pair that overlaps most, and its separation.
pub type Worst = ([u32; 2], f64);

/// What a process has of a step: how its rows are ordered, what of the whole problem they are, and what is remembered
/// of its pairs.
pub struct Shared<'a, P> {
    pub(super) places: Places,
    pub(super) portion: P,
    pub(super) warm: Cow<'a, [Warm]>,
}

/// The processes that take steps together. All of them take the same decisions from the same numbers; what a method
/// sends and receives, all send and receive together.
pub trait Team: Send {
    /// What of an LCP a process has.
    type Portion<const D: usize>: Portion<D>;

    /// Calls the others to a step.
    fn call(&mut self);
    /// Sees that all came to the same in a step.
    fn agree(&mut self, stepped: Result<StepReport, Fault>) -> Result<StepReport, Fault>;
    /// Whether the attempt that ended in a fault was begun with too little, and is to be made again.
    fn begins_anew(&self) -> bool;
    /// Takes pieces of a step alone from now on, each process with all of the state. Says whether others had a part of
    /// the present attempt.
    fn part(&mut self, state: &mut State) -> bool;
    /// Takes steps together again.
    fn meet(&mut self);

    /// Begins a piece of a step with the bodies of `state` that this process has, and divides the cells that are due.
    fn begin(&mut self, setup: &Setup, start: &mut Start, state: &mut State, taken: (Piece, Waiting));
    /// Leaves in `start`, whose bodies have grown, those of this process in the present step.
    fn share_out<'a, const D: usize>(
        &mut self,
        setup: &Setup,
        start: &mut Start,
        state: &'a State,
    ) -> Shared<'a, Self::Portion<D>>;
    /// Whether other processes have a part of the present step.
    fn is_shared(&self) -> bool;
    /// The pairs that may be near, where bodies have these boxes.
    ///
    /// # Errors
    /// Where a body went farther than the others know: see [`Team::begins_anew`].
    fn candidates<'a>(&'a mut self, all: &'a mut Candidates, boxes: &[Aabb]) -> Result<&'a [[u32; 2]], Fault>;
    /// Gives others the numbers of bodies that they need, and takes those that are needed of theirs.
    fn exchange<const N: usize>(&self, of_body: &mut [[f64; N]]);
    /// The first trouble of all, from this process's.
    fn first(&self, own: Option<Trouble>) -> Option<Trouble>;
    /// The largest number of all.
    fn largest(&self, own: f64) -> f64;
    /// Whether it is true of any process.
    fn any(&self, own: bool) -> bool;
    /// The overlap of all, from those of this process's pairs; `worst` is the largest of them.
    fn all_overlaps(&self, own: Overlap, worst: impl FnOnce() -> Option<Worst>, walls: &Walls) -> Overlap;
    /// What contact does in all.
    fn all_effects(&self, own: Effect) -> Effect;
    /// All bodies that move in a step, and their velocities; none where none may pass another.
    fn moving<'a>(
        &self,
        bodies: &'a Bodies,
        twist: &'a [Twist],
        course: (f64, Option<CellShear>),
    ) -> Option<(Cow<'a, Bodies>, Cow<'a, [Twist]>)>;
    /// What a step leaves of pairs, by the numbers of their bodies.
    fn by_number(&self, warm: Vec<Warm>) -> Vec<Warm>;
    /// Ends a step with the bodies where they arrive; `rows` are the first bodies of its rows.
    fn arrive(&mut self, setup: &Setup, end: &mut Bodies, rows: impl Iterator<Item = u32>);

    /// How many bodies there are, of which so many are here.
    fn bodies(&self, here: usize) -> usize;
    /// The whole state, on the process that leads.
    fn gathered<'a>(&'a self, state: &'a State) -> &'a State;
    /// All bodies.
    fn all_bodies<'a>(&'a self, here: &'a Bodies) -> &'a Bodies;
    /// All bodies, where they are here.
    fn known_bodies<'a>(&self, here: &'a Bodies) -> Option<&'a Bodies>;
    /// The lives of the bodies here.
    fn lives<'a>(&self, here: &'a Bodies) -> Lives<'a>;
    /// What all have, in order.
    fn all_gather(&self, own: Vec<[u64; JOINED]>) -> Vec<[u64; JOINED]>;
    /// The mothers that divided in the last step, of this process's bodies; `before` are the lines here before it.
    fn divided(&mut self, here: &Bodies, before: &[Lineage]) -> Vec<Divided>;
    /// Forgets what is known of a state: another has come, and all have all of it.
    fn forget(&mut self);
    /// Goes on without some of the bodies that are here.
    fn remove(&mut self, state: &mut State, keep: &[bool], removed: &[u64]);
}

/// A team of one, which has nobody to ask.
impl Team for Alone {
    type Portion<const D: usize> = Alone;

    fn call(&mut self) {}

    fn agree(&mut self, stepped: Result<StepReport, Fault>) -> Result<StepReport, Fault> {
        stepped
    }

    fn begins_anew(&self) -> bool {
        false
    }

    fn part(&mut self, _state: &mut State) -> bool {
        false
    }

    fn meet(&mut self) {}

    fn begin(&mut self, setup: &Setup, start: &mut Start, state: &mut State, taken: (Piece, Waiting)) {
        start.begin(setup, state, &state.warm, taken);
        start.divide(setup);
    }

    fn share_out<'a, const D: usize>(
        &mut self,
        setup: &Setup,
        start: &mut Start,
        state: &'a State,
    ) -> Shared<'a, Self::Portion<D>> {
        Shared { places: all_places(setup, start), portion: Alone, warm: Cow::Borrowed(&state.warm) }
    }

    fn is_shared(&self) -> bool {
        false
    }

    fn candidates<'a>(&'a mut self, all: &'a mut Candidates, boxes: &[Aabb]) -> Result<&'a [[u32; 2]], Fault> {
        Ok(all.ensure(boxes))
    }

    fn exchange<const N: usize>(&self, _of_body: &mut [[f64; N]]) {}

    fn first(&self, own: Option<Trouble>) -> Option<Trouble> {
        own
    }

    fn largest(&self, own: f64) -> f64 {
        own
    }

    fn any(&self, own: bool) -> bool {
        own
    }

    fn all_overlaps(&self, own: Overlap, _worst: impl FnOnce() -> Option<Worst>, _walls: &Walls) -> Overlap {
        own
    }

    fn all_effects(&self, own: Effect) -> Effect {
        own
    }

    fn moving<'a>(
        &self,
        bodies: &'a Bodies,
        twist: &'a [Twist],
        _course: (f64, Option<CellShear>),
    ) -> Option<(Cow<'a, Bodies>, Cow<'a, [Twist]>)> {
        Some((Cow::Borrowed(bodies), Cow::Borrowed(twist)))
    }

    fn by_number(&self, warm: Vec<Warm>) -> Vec<Warm> {
        warm
    }

    fn arrive(&mut self, _setup: &Setup, _end: &mut Bodies, _rows: impl Iterator<Item = u32>) {}

    fn bodies(&self, here: usize) -> usize {
        here
    }

    fn gathered<'a>(&'a self, state: &'a State) -> &'a State {
        state
    }

    fn all_bodies<'a>(&'a self, here: &'a Bodies) -> &'a Bodies {
        here
    }

    fn known_bodies<'a>(&self, here: &'a Bodies) -> Option<&'a Bodies> {
        Some(here)
    }

    fn lives<'a>(&self, here: &'a Bodies) -> Lives<'a> {
        Lives::of_all(&here.lineage, &here.group)
    }

    fn all_gather(&self, own: Vec<[u64; JOINED]>) -> Vec<[u64; JOINED]> {
        own
    }

    fn divided(&mut self, here: &Bodies, before: &[Lineage]) -> Vec<Divided> {
        Divided::between(before, &here.lineage, &here.group)
    }

    fn forget(&mut self) {}

    fn remove(&mut self, state: &mut State, keep: &[bool], removed: &[u64]) {
        state.remove(keep, removed);
    }
}

/// Where all bodies of a step stand, for the order of rows.
pub(super) fn all_places(setup: &Setup, start: &Start) -> Places {
    let blocks = bisect(&start.bodies.position, start.periods);
    let walls = start.bodies.len()..start.bodies.len() + setup.walls.len();
    let place = blocks.places().into_iter().chain(walls.map(|wall| wall as u32)).collect();
    Places { place, blocks: blocks.edges }
}
