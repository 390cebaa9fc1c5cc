//! What is known of a pair from one step to the next: a warm start.

use glam::DVec3;

/// What a step remembers of a near pair, to start the next step from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warm {
    /// The pair, `a < b`; or a body and a surface of a wall by its number ([`crate::walls::surface_of`]).
    pub pair: [u32; 2],
    /// Which of the pair's contacts, where several are made at once.
    pub feature: u32,
    /// The sum of its rows' multipliers.
    pub gamma: f64,
    /// Its last normal; zero where none was found.
    pub normal: DVec3,
}
