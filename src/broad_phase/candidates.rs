//! A candidate list that is kept while it is proven complete: the neighbour list of L. Verlet, "Computer experiments on
//! classical fluids I", 1967, with boxes instead of distances.
//!
//! A search stores every body's box inflated by a margin (half the skin) and lists the pairs whose stored boxes touch.
//! As long as every body's box lies inside its stored box, two boxes that touch belong to stored boxes that touch, so
//! the list holds them: no bound on speeds, turns or growth is assumed. The first box found outside its stored box
//! causes a new search.

use super::{Aabb, BroadPhase, Grid, Periodic};
use crate::periodic::Periods;
use rayon::prelude::*;

/// The number of calls that a search's margin should last, at the measured pace. `benches/broad_phase.rs` measures the
/// cost by margin: for rods in a plane and ellipsoids in a heap that move by 1e-4 to 1e-2 of their length per call, 20
/// calls within the limits below cost at most about a fifth more than the best fixed margin, and a third to an eighth
/// of a search per call.
const TARGET_CALLS: f64 = 20.0;

/// The number of calls that a margin must last to be worthwhile.
const LEAST_CALLS: f64 = 2.0;

/// Largest margin, as a fraction of the median of the boxes' longest edges. The list is then two to five times as long
/// as needed; at twice the margin three to twelve times, which costs more than the saved searches up to a pace of 1e-2
/// lengths per call.
const MAX_FRACTION: f64 = 0.1;

/// Smallest margin, likewise: at this size it adds a hundredth to the list.
const MIN_FRACTION: f64 = 0.002;

/// The margin of a first search, likewise, while the pace is unknown.
const FIRST_FRACTION: f64 = 0.02;

/// Below this many bodies or pairs one thread does all: a test takes a few nanoseconds, dispatching work some
/// microseconds.
const PARALLEL_MIN: usize = 16384;

/// Keeps the pairs of a search with a margin over configurations that differ little.
///
/// As a [`BroadPhase`] it finds exactly the pairs of its search, independently of earlier calls.
/// [`Candidates::ensure`] gives the list itself.
///
/// ```
/// use glam::DVec3;
/// use relcp::internals::broad_phase::{Aabb, BroadPhase, Candidates, Grid};
///
/// let mut candidates = Candidates::new(Box::<Grid>::default());
/// let mut boxes = [0.0, 0.999, 5.0].map(|x| Aabb::from_centre(DVec3::new(x, 0.0, 0.0), DVec3::splat(0.5)));
/// assert_eq!(candidates.ensure(&boxes), [[0, 1]]);
/// boxes[1] = Aabb::from_centre(DVec3::new(1.001, 0.0, 0.0), DVec3::splat(0.5));
/// assert_eq!(candidates.ensure(&boxes), [[0, 1]]); // still near enough to be listed
/// assert_eq!((candidates.searches(), candidates.reuses()), (1, 1));
/// let mut touching = Vec::new();
/// candidates.pairs(&boxes, &mut touching);
/// assert!(touching.is_empty());
/// ```
pub struct Candidates {
    search: Box<dyn BroadPhase + Send + Sync>,
    periods: Periods,
    /// Boxes of the last search with its margin; empty if there is nothing to reuse.
    stored: Vec<Aabb>,
    listed: Vec<[u32; 2]>,
    margin: f64,
    fixed: Option<f64>,
    /// The margin used per call, as last measured.
    pace: Option<f64>,
    calls_since_search: u64,
    searches: u64,
    reuses: u64,
}

impl Default for Candidates {
    /// Candidates by the [`Grid`](super::Grid).
    fn default() -> Self {
        Candidates::new(Box::new(Grid::default()))
    }
}

impl Candidates {
    /// A list made by `search`, with a margin chosen by the measured motion of the boxes.
    pub fn new(search: Box<dyn BroadPhase + Send + Sync>) -> Self {
        Candidates {
            search,
            periods: Periods::NONE,
            stored: Vec::new(),
            listed: Vec::new(),
            margin: 0.0,
            fixed: None,
            pace: None,
            calls_since_search: 0,
            searches: 0,
            reuses: 0,
        }
    }

    /// A list made by `search` with the margin `margin`, a length, not below zero.
    pub fn with_margin(search: Box<dyn BroadPhase + Send + Sync>, margin: f64) -> Self {
        Candidates { fixed: Some(margin.max(0.0)), ..Candidates::new(search) }
    }

    /// A list made by the [`Grid`] in the space of `periods`, with the pairs that touch through any image. The boxes
    /// must not be wrapped, so that they do not jump.
    pub fn in_space(periods: Periods) -> Self {
        Candidates { periods, ..Candidates::new(Box::new(Periodic::new(Grid::default(), periods))) }
    }

    /// Sets other periods; the present list is not valid there.
    pub fn set_periods(&mut self, periods: Periods) {
        if periods != self.periods {
            *self = Candidates { searches: self.searches, reuses: self.reuses, ..Candidates::in_space(periods) };
        }
    }

    /// Pairs `[a, b]`, `a < b`, ascending, each once, among them every pair of touching boxes.
    ///
    /// `boxes` are the bodies' exact boxes, each inflated by the distance that the caller needs, such as half of a
    /// common cutoff. The list has further pairs that depend on earlier calls. A caller whose results must not depend
    /// on them must filter the list by an exact criterion, as [`Candidates::pairs`](BroadPhase::pairs) does with the
    /// boxes themselves.
    pub fn ensure(&mut self, boxes: &[Aabb]) -> &[[u32; 2]] {
        self.calls_since_search += 1;
        if self.holds(boxes) {
            self.reuses += 1;
        } else {
            self.renew(boxes);
        }
        &self.listed
    }

    /// Drops the list, so that the next call searches. Completeness never requires this: a changed number of boxes, or
    /// a box outside its stored box, is detected anyway, also if an index now means another body. It makes the list
    /// independent of the past.
    pub fn invalidate(&mut self) {
        self.stored.clear();
        self.listed.clear();
        self.pace = None;
    }

    /// The number of searches.
    pub fn searches(&self) -> u64 {
        self.searches
    }

    /// Calls answered without a search.
    pub fn reuses(&self) -> u64 {
        self.reuses
    }

    /// Whether the list is proven complete for `boxes`.
    fn holds(&self, boxes: &[Aabb]) -> bool {
        let inside = |(stored, aabb): (&Aabb, &Aabb)| stored.contains(aabb) && aabb.is_proper();
        self.stored.len() == boxes.len()
            && !boxes.is_empty()
            && if boxes.len() >= PARALLEL_MIN {
                self.stored.par_iter().zip(boxes).all(inside)
            } else {
                self.stored.iter().zip(boxes).all(inside)
            }
    }

    fn renew(&mut self, boxes: &[Aabb]) {
        self.measure_pace(boxes);
        self.margin = self.fixed.unwrap_or_else(|| self.next_margin(boxes));
        let margin = self.margin;
        // A box that would overflow with the margin keeps its own size. A box that is not proper touches nothing, but
        // may be proper next time: its stored box contains nothing.
        let store = |aabb: &Aabb| match aabb.inflated(margin) {
            inflated if inflated.is_proper() && aabb.is_proper() => inflated,
            _ if aabb.is_proper() => *aabb,
            _ => Aabb { min: glam::DVec3::NAN, max: glam::DVec3::NAN },
        };
        boxes.par_iter().with_min_len(PARALLEL_MIN).map(store).collect_into_vec(&mut self.stored);
        self.search.pairs(&self.stored, &mut self.listed);
        self.searches += 1;
        self.calls_since_search = 0;
    }

    /// The margin used per call since the last search, by the body that used most.
    fn measure_pace(&mut self, boxes: &[Aabb]) {
        if self.stored.len() != boxes.len() || boxes.is_empty() {
            return;
        }
        let beyond = |(stored, aabb): (&Aabb, &Aabb)| {
            (stored.min - aabb.min).max_element().max((aabb.max - stored.max).max_element())
        };
        let both = self.stored.par_iter().zip(boxes).with_min_len(PARALLEL_MIN);
        let worst = both.map(beyond).reduce(|| f64::NEG_INFINITY, f64::max);
        let used = self.margin + worst;
        if used.is_finite() {
            self.pace = Some(used / self.calls_since_search as f64);
        }
    }

    fn next_margin(&self, boxes: &[Aabb]) -> f64 {
        let mut edges: Vec<f64> =
            boxes.iter().filter(|aabb| aabb.is_proper()).map(|aabb| (aabb.max - aabb.min).max_element()).collect();
        if edges.is_empty() {
            return 0.0;
        }
        let middle = edges.len() / 2;
        let typical = *edges.select_nth_unstable_by(middle, f64::total_cmp).1;
        match self.pace {
            None => FIRST_FRACTION * typical,
            // A margin would last for hardly any call, and only lengthen the list.
            Some(pace) if pace * LEAST_CALLS > MAX_FRACTION * typical => 0.0,
            Some(pace) => (pace * TARGET_CALLS).clamp(MIN_FRACTION * typical, MAX_FRACTION * typical),
        }
    }
}

impl BroadPhase for Candidates {
    fn pairs(&mut self, boxes: &[Aabb], pairs: &mut Vec<[u32; 2]>) {
        self.ensure(boxes);
        let periods = self.periods;
        // All listed boxes are proper: a search lists no others, and a change of one would have caused a new search.
        let touching = |part: &[[u32; 2]], pairs: &mut Vec<[u32; 2]>| {
            pairs.extend(part.iter().filter(|[a, b]| periods.touches(&boxes[*a as usize], &boxes[*b as usize])));
        };
        pairs.clear();
        if self.listed.len() < PARALLEL_MIN {
            touching(&self.listed, pairs);
            return;
        }
        let parts: Vec<_> = self.listed.chunks(PARALLEL_MIN).collect();
        let kept = parts.par_iter().map(|part| {
            let mut kept = Vec::with_capacity(part.len());
            touching(part, &mut kept);
            kept
        });
        kept.collect::<Vec<_>>().iter().for_each(|part| pairs.extend(part));
    }
}
