//! The state of a simulation between two steps.

use crate::bodies::Bodies;
use crate::warm::Warm;

/// Everything that a run needs, beside its scene, to go on to the same bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Steps taken.
    pub step: u64,
    /// The id that the next body born will get.
    pub next_id: u64,
    /// The bodies.
    pub bodies: Bodies,
    /// What the last step remembers of its near pairs, sorted by pair and feature.
    pub warm: Vec<Warm>,
}

impl State {
    /// The state that a simulation of these bodies starts from: no step taken, nothing remembered.
    pub fn new(bodies: Bodies) -> State {
        // A parent's id is taken too, although the parent is no more.
        let taken = bodies.lineage.iter().map(|l| l.id.max(l.parent.unwrap_or(0)));
        let next_id = taken.max().map_or(0, |id| id + 1);
        State { step: 0, next_id, bodies, warm: Vec::new() }
    }
}
