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
