//! The warm start of a pair, from one step to the next.

use glam::DVec3;

/// The warm start that a step leaves for a near pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warm {
    /// The pair, `a < b`; or a body and a surface of a wall by its number ([`crate::walls::surface_of`]).
    pub pair: [u32; 2],
    /// The index of the contact, if the pair has several.
    pub feature: u32,
    /// The sum of its rows' multipliers.
    pub gamma: f64,
    /// Its last normal; zero if none was found.
    pub normal: DVec3,
}
