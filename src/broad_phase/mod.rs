//! Broad phase: the pairs of bodies that may be near, by their boxes alone.
//!
//! [`Grid`] is the standard search, and [`BruteForce`] the oracle for its tests. [`Candidates`] keeps a list over
//! several configurations, and searches again only when a body has left its stored box. [`Periodic`] extends any search
//! to periodic space.

mod brute_force;
mod candidates;
#[cfg(feature = "gpu")]
pub mod gpu;
mod grid;
mod levels;
mod pair_order;
mod periodic;

pub use crate::motion::Aabb;
pub use brute_force::BruteForce;
pub use candidates::Candidates;
pub use grid::Grid;
pub use periodic::{Periodic, PeriodicBruteForce};

use rayon::prelude::*;

/// Finds all pairs of touching boxes.
pub trait BroadPhase {
    /// Replaces `pairs` by every pair `[a, b]` with `a < b` whose boxes touch (closed boxes), sorted ascending, each
    /// once. The result depends only on `boxes`, never on the number of threads.
    ///
    /// A box that is not [proper](Aabb::is_proper) touches nothing. Indices are 32 bits wide: at most `u32::MAX` boxes.
    fn pairs(&mut self, boxes: &[Aabb], pairs: &mut Vec<[u32; 2]>);
}

/// Calls `work(k, part k)` for every part, on rayon's threads if `parallel`.
fn each<T: Send>(parallel: bool, parts: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
    if parallel {
        parts.par_iter_mut().enumerate().for_each(|(k, part)| work(k, part));
    } else {
        parts.iter_mut().enumerate().for_each(|(k, part)| work(k, part));
    }
}
