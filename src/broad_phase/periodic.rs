//! Searches of periodic space: by any search without periods over boxes that are wrapped into one cell, with images of
//! those that reach beyond it; and by testing every pair.

use super::{Aabb, BroadPhase};
use crate::periodic::Periods;
use rayon::prelude::*;

/// Finds the pairs that touch through some image, by another search.
///
/// ```
/// use glam::DVec3;
/// use relcp::internals::broad_phase::{Aabb, BroadPhase, Grid, Periodic};
/// use relcp::periodic::Periods;
///
/// let at = |x| Aabb::from_centre(DVec3::new(x, 0.0, 0.0), DVec3::splat(0.5));
/// let mut pairs = Vec::new();
/// Periodic::new(Grid::default(), Periods::new([Some(8.0), None, None])).pairs(&[at(0.2), at(4.0), at(7.6)], &mut pairs);
/// assert_eq!(pairs, [[0, 2]]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Periodic<S> {
    search: S,
    periods: Periods,
    /// The boxes in one cell, then their images beyond it, and the body of each.
    boxes: Vec<Aabb>,
    body: Vec<u32>,
    found: Vec<[u32; 2]>,
}

impl<S> Periodic<S> {
    /// A search of the space of `periods` by `search`.
    pub fn new(search: S, periods: Periods) -> Self {
        Periodic { search, periods, boxes: Vec::new(), body: Vec::new(), found: Vec::new() }
    }

    fn unfold(&mut self, boxes: &[Aabb]) {
        self.boxes.clear();
        self.body.clear();
        let mut beyond = Vec::new();
        for (body, aabb) in (0u32..).zip(boxes).filter(|(_, aabb)| aabb.is_proper()) {
            let mut first = true;
            self.periods.unfold(aabb, |image| {
                if std::mem::take(&mut first) {
                    self.boxes.push(image);
                    self.body.push(body);
                } else {
                    beyond.push((image, body));
                }
            });
        }
        self.boxes.extend(beyond.iter().map(|(image, _)| image));
        self.body.extend(beyond.iter().map(|(_, body)| body));
    }
}

impl<S: BroadPhase> BroadPhase for Periodic<S> {
    fn pairs(&mut self, boxes: &[Aabb], pairs: &mut Vec<[u32; 2]>) {
        if self.periods.is_none() {
            return self.search.pairs(boxes, pairs);
        }
        self.unfold(boxes);
        self.search.pairs(&self.boxes, &mut self.found);
        pairs.clear();
        let of_bodies = self.found.iter().map(|pair| pair.map(|image| self.body[image as usize]));
        let ordered = of_bodies.filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]);
        pairs.extend(ordered.filter(|[a, b]| self.periods.touches(&boxes[*a as usize], &boxes[*b as usize])));
        pairs.par_sort_unstable();
        pairs.dedup();
    }
}

/// Tests every pair with all of its images: the oracle of the searches of periodic space.
#[derive(Clone, Copy, Debug, Default)]
pub struct PeriodicBruteForce {
    /// The periods.
    pub periods: Periods,
}

impl BroadPhase for PeriodicBruteForce {
    fn pairs(&mut self, boxes: &[Aabb], pairs: &mut Vec<[u32; 2]>) {
        pairs.clear();
        for (a, first) in boxes.iter().enumerate().filter(|(_, first)| first.is_proper()) {
            for (b, second) in boxes.iter().enumerate().skip(a + 1).filter(|(_, second)| second.is_proper()) {
                if self.periods.touches(first, second) {
                    pairs.push([a as u32, b as u32]);
                }
            }
        }
    }
}
