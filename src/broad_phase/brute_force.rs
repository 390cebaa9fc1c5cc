//! Tests every pair: the oracle of the other searches, and fast enough for a few bodies.

use super::{Aabb, BroadPhase};

/// Tests all `n (n - 1) / 2` pairs.
///
/// ```
/// use glam::DVec3;
/// use relcp::internals::broad_phase::{Aabb, BroadPhase, BruteForce};
///
/// let at = |x| Aabb::from_centre(DVec3::new(x, 0.0, 0.0), DVec3::splat(0.5));
/// let mut pairs = Vec::new();
/// BruteForce.pairs(&[at(0.0), at(5.0), at(1.0)], &mut pairs);
/// assert_eq!(pairs, [[0, 2]]);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct BruteForce;

impl BroadPhase for BruteForce {
    fn pairs(&mut self, boxes: &[Aabb], pairs: &mut Vec<[u32; 2]>) {
        pairs.clear();
        for (a, first) in boxes.iter().enumerate().filter(|(_, first)| first.is_proper()) {
            for (b, second) in boxes.iter().enumerate().skip(a + 1) {
                if first.touches(second) && second.is_proper() {
                    pairs.push([a as u32, b as u32]);
                }
            }
        }
    }
}
