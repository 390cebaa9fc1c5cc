//! The warm start of a pair, from one step to the next.

use glam::DVec3;

/// The warm start that a step leaves for a near pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warm {
    /// The pair, `a < b`; or a body and a surface of a wall by its number ([`crate::walls::surface_of`]).
    pub pair: [u32; 2],
    /// The index of the contact, if the pair has several.
    pub feature: u32,
    /// The sum of the multipliers of its normal rows.
    pub gamma: f64,
    /// The friction force on the second body; zero without friction.
    pub tangent: DVec3,
    /// Its last normal; zero if none was found.
    pub normal: DVec3,
}

impl Warm {
    /// The force on the second body, where the contact has this normal.
    pub fn force(&self, normal: DVec3) -> DVec3 {
        self.gamma * normal + self.tangent
    }
}
