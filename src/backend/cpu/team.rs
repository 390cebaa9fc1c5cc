//! The processes that take a step together, each with some of the bodies.

use super::setup::Setup;
use super::start::Start;
use super::trouble::Trouble;
use crate::bisection::bisect;
use crate::bodies::{Bodies, Lineage};
use crate::broad_phase::{Aabb, Candidates};
use crate::dynamics::{Twist, Waiting};
use crate::lcp::{Alone, Places, Portion};
use crate::periodic::CellShear;
use crate::step::{Divided, Effect, Fault, LIFE_WORDS, Lives, Overlap, Piece, State, StepReport};
use crate::walls::Walls;
use crate::warm::Warm;
use std::borrow::Cow;

/// The pair that overlaps most, and its separation.
pub type Worst = ([u32; 2], f64);

/// A process's part of a step: the order of its rows, its part of the LCP, and the warm start of its pairs.
pub struct LocalProblem<'a, P> {
    pub(super) places: Places,
    pub(super) portion: P,
    pub(super) warm: Cow<'a, [Warm]>,
}

/// The processes that take steps together. All of them take the same decisions from the same numbers. Methods that
/// exchange data are collective: all processes call them together.
pub trait Team: Send {
    /// A process's part of an LCP.
    type Portion<const D: usize>: Portion<D>;

    /// Tells the other processes to take a step.
    fn announce_step(&mut self);
    /// Checks that all processes computed the same step.
    fn check_agreement(&mut self, stepped: Result<StepReport, Fault>) -> Result<StepReport, Fault>;
    /// Whether to retry the failed attempt with a larger halo.
    fn needs_retry(&self) -> bool;
    /// From now on each process has the whole state and takes pieces of a step alone. Returns whether the present
    /// attempt was distributed.
    fn work_alone(&mut self, state: &mut State) -> bool;
    /// Takes steps together again.
    fn work_together(&mut self);

    /// Begins a piece of a step with this process's bodies of `state`, and divides the cells that are due.
    fn begin(&mut self, setup: &Setup, start: &mut Start, state: &mut State, taken: (Piece, Waiting));
    /// Distributes the grown bodies of `start`: it keeps those of this process's domain and halo.
    fn distribute<'a, const D: usize>(
        &mut self,
        setup: &Setup,
        start: &mut Start,
        state: &'a State,
    ) -> LocalProblem<'a, Self::Portion<D>>;
    /// Whether the present step is distributed over processes.
    fn is_distributed(&self) -> bool;
    /// The pairs that may be near, from the boxes of all bodies.
    ///
    /// # Errors
    /// A body left its halo: see [`Team::needs_retry`].
    fn candidates<'a>(&'a mut self, all: &'a mut Candidates, boxes: &[Aabb]) -> Result<&'a [[u32; 2]], Fault>;
    /// Sends the values of own bodies that are in other halos, and receives those of this process's halo.
    fn exchange<const N: usize>(&self, of_body: &mut [[f64; N]]);
    /// The first trouble of all processes.
    fn first_trouble(&self, own: Option<Trouble>) -> Option<Trouble>;
    /// The largest value of all processes.
    fn max(&self, own: f64) -> f64;
    /// Whether it is true on any process.
    fn any(&self, own: bool) -> bool;
    /// The overlap of all processes' pairs; `worst` is the largest one of this process.
    fn all_overlaps(&self, own: Overlap, worst: impl FnOnce() -> Option<Worst>, walls: &Walls) -> Overlap;
    /// The effect of contact, summed over processes.
    fn all_effects(&self, own: Effect) -> Effect;
    /// All bodies and their velocities; none if no body is fast enough to pass another.
    fn moving_bodies<'a>(
        &self,
        bodies: &'a Bodies,
        twist: &'a [Twist],
        interval_and_shear: (f64, Option<CellShear>),
    ) -> Option<(Cow<'a, Bodies>, Cow<'a, [Twist]>)>;
    /// The warm start that a step leaves, with the global indices of bodies.
    fn with_global_indices(&self, warm: Vec<Warm>) -> Vec<Warm>;
    /// Ends a step. `end` are the bodies after it; `rows` are the first bodies of its rows.
    fn finish_step(&mut self, setup: &Setup, end: &mut Bodies, rows: impl Iterator<Item = u32>);

    /// The number of bodies of all processes; `local` is that of this one.
    fn body_count(&self, local: usize) -> usize;
    /// The whole state, on rank 0.
    fn whole_state<'a>(&'a self, setup: &Setup, state: &'a State) -> &'a State;
    /// All bodies.
    fn all_bodies<'a>(&'a self, local: &'a Bodies) -> &'a Bodies;
    /// All bodies, if this process has them.
    fn known_bodies<'a>(&self, local: &'a Bodies) -> Option<&'a Bodies>;
    /// The lives of this process's bodies.
    fn lives<'a>(&self, local: &'a Bodies) -> Lives<'a>;
    /// Gathers the records of all processes, sorted.
    fn all_gather(&self, own: Vec<[u64; LIFE_WORDS]>) -> Vec<[u64; LIFE_WORDS]>;
    /// The mothers that divided in the last step, of this process's bodies; `before` are their lineages before it.
    fn divided(&mut self, local: &Bodies, before: &[Lineage]) -> Vec<Divided>;
    /// Drops all knowledge of the state: it was replaced, and every process has the whole new one.
    fn reset(&mut self);
    /// Removes some of this process's bodies.
    fn remove(&mut self, state: &mut State, keep: &[bool], removed: &[u64]);
}

/// A team of one process.
impl Team for Alone {
    type Portion<const D: usize> = Alone;

    fn announce_step(&mut self) {}

    fn check_agreement(&mut self, stepped: Result<StepReport, Fault>) -> Result<StepReport, Fault> {
        stepped
    }

    fn needs_retry(&self) -> bool {
        false
    }

    fn work_alone(&mut self, _state: &mut State) -> bool {
        false
    }

    fn work_together(&mut self) {}

    fn begin(&mut self, setup: &Setup, start: &mut Start, state: &mut State, taken: (Piece, Waiting)) {
        start.begin(setup, state, &state.warm, taken);
        start.divide(setup);
    }

    fn distribute<'a, const D: usize>(
        &mut self,
        setup: &Setup,
        start: &mut Start,
        state: &'a State,
    ) -> LocalProblem<'a, Self::Portion<D>> {
        LocalProblem { places: all_places(setup, start), portion: Alone, warm: Cow::Borrowed(&state.warm) }
    }

    fn is_distributed(&self) -> bool {
        false
    }

    fn candidates<'a>(&'a mut self, all: &'a mut Candidates, boxes: &[Aabb]) -> Result<&'a [[u32; 2]], Fault> {
        Ok(all.ensure(boxes))
    }

    fn exchange<const N: usize>(&self, _of_body: &mut [[f64; N]]) {}

    fn first_trouble(&self, own: Option<Trouble>) -> Option<Trouble> {
        own
    }

    fn max(&self, own: f64) -> f64 {
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

    fn moving_bodies<'a>(
        &self,
        bodies: &'a Bodies,
        twist: &'a [Twist],
        _interval_and_shear: (f64, Option<CellShear>),
    ) -> Option<(Cow<'a, Bodies>, Cow<'a, [Twist]>)> {
        Some((Cow::Borrowed(bodies), Cow::Borrowed(twist)))
    }

    fn with_global_indices(&self, warm: Vec<Warm>) -> Vec<Warm> {
        warm
    }

    fn finish_step(&mut self, _setup: &Setup, _end: &mut Bodies, _rows: impl Iterator<Item = u32>) {}

    fn body_count(&self, local: usize) -> usize {
        local
    }

    fn whole_state<'a>(&'a self, _: &Setup, state: &'a State) -> &'a State {
        state
    }

    fn all_bodies<'a>(&'a self, local: &'a Bodies) -> &'a Bodies {
        local
    }

    fn known_bodies<'a>(&self, local: &'a Bodies) -> Option<&'a Bodies> {
        Some(local)
    }

    fn lives<'a>(&self, local: &'a Bodies) -> Lives<'a> {
        Lives::of_all(&local.lineage, &local.group)
    }

    fn all_gather(&self, own: Vec<[u64; LIFE_WORDS]>) -> Vec<[u64; LIFE_WORDS]> {
        own
    }

    fn divided(&mut self, local: &Bodies, before: &[Lineage]) -> Vec<Divided> {
        Divided::between(before, &local.lineage, &local.group)
    }

    fn reset(&mut self) {}

    fn remove(&mut self, state: &mut State, keep: &[bool], removed: &[u64]) {
        state.remove(keep, removed);
    }
}

/// The position of every body in the block order, for the order of rows.
pub(super) fn all_places(setup: &Setup, start: &Start) -> Places {
    let blocks = bisect(&start.bodies.position, start.periods);
    let walls = start.bodies.len()..start.bodies.len() + setup.walls.len();
    let place = blocks.places().into_iter().chain(walls.map(|wall| wall as u32)).collect();
    Places { place, blocks: blocks.edges }
}
