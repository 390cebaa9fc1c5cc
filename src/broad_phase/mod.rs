//! Broad phase: which pairs of bodies could be near, from their boxes alone.

use glam::DVec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lowest corner.
    pub min: DVec3,
    /// Highest corner.
    pub max: DVec3,
}

/// Finds all pairs of touching boxes.
pub trait BroadPhase {
    /// Replaces `pairs` by every pair `[a, b]` with `a < b` whose boxes touch (closed boxes), sorted ascending, each once.
    /// The result depends only on `boxes`, never on the number of threads.
    fn pairs(&mut self, boxes: &[Aabb], pairs: &mut Vec<[u32; 2]>);
}
