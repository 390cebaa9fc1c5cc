//! Broad phase: which pairs of bodies could be near, from their boxes alone.
//!
//! [`Grid`] is the search to use, [`BruteForce`] the oracle it is tested against, and [`Candidates`] keeps a list over
//! several configurations, searching again only when a body has left its stored box. [`Periodic`] makes any of them a search of periodic space.

mod brute_force;
mod candidates;
pub mod gpu;
mod grid;
mod levels;
mod pair_order;
mod periodic;

pub use brute_force::BruteForce;
pub use candidates::Candidates;
pub use grid::Grid;
pub use periodic::{Periodic, PeriodicBruteForce};

use glam::DVec3;
use rayon::prelude::*;

/// An axis-aligned box, closed: it holds its faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lowest corner.
    pub min: DVec3,
    /// Highest corner.
    pub max: DVec3,
}

impl Aabb {
    /// The box of centre `centre` that reaches `half` to each side.
    pub fn from_centre(centre: DVec3, half: DVec3) -> Self {
        Aabb { min: centre - half, max: centre + half }
    }

    /// Whether both corners are finite and no edge is negative. A box that is not proper touches nothing.
    pub fn is_proper(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }

    /// Whether two proper boxes share a point, faces counted.
    pub fn touches(&self, other: &Aabb) -> bool {
        // No early way out: which of the six fails is hard to foresee.
        let (a, b) = (self, other);
        ((a.min.x <= b.max.x) & (a.min.y <= b.max.y) & (a.min.z <= b.max.z))
            & ((b.min.x <= a.max.x) & (b.min.y <= a.max.y) & (b.min.z <= a.max.z))
    }

    /// Whether `other` lies inside this box, faces counted.
    pub fn contains(&self, other: &Aabb) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// The box pushed out by `margin` on every side.
    pub fn inflated(&self, margin: f64) -> Self {
        Aabb { min: self.min - margin, max: self.max + margin }
    }
}

/// Finds all pairs of touching boxes.
pub trait BroadPhase {
    /// Replaces `pairs` by every pair `[a, b]` with `a < b` whose boxes touch (closed boxes), sorted ascending, each once.
    /// The result depends only on `boxes`, never on the number of threads.
    ///
    /// A box that is not [proper](Aabb::is_proper) touches nothing. Indices are 32 bits wide: at most `u32::MAX` boxes.
    fn pairs(&mut self, boxes: &[Aabb], pairs: &mut Vec<[u32; 2]>);
}

/// Calls `work(k, part k)` for every part, on rayon's threads where `parallel` says so.
fn each<T: Send>(parallel: bool, parts: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
    if parallel {
        parts.par_iter_mut().enumerate().for_each(|(k, part)| work(k, part));
    } else {
        parts.iter_mut().enumerate().for_each(|(k, part)| work(k, part));
    }
}
