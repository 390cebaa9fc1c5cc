//! Narrow phase: the separations of candidate pairs that are within a limit, with every far pair left out as cheaply as
//! it can be.

use super::pairs::{Pairs, Record};
use crate::constraint::FEATURE_OF_SURFACES;
use crate::separation::{Placed, Separation, bound};
use glam::DVec3;
use rayon::prelude::*;
use std::iter::Peekable;
use std::slice::Iter;

/// How a pair's separation is computed: in space or in the plane.
pub type Separate = fn(&Placed, &Placed, Option<DVec3>) -> Option<Separation>;

/// Candidate pairs a task: about 0.1 ms of work, long against handing it out.
const PAIRS_A_TASK: usize = 512;

/// A pair and its separation. The second of a pair may be a surface of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    pub pair: [u32; 2],
    /// Which of the pair's contacts.
    pub feature: u32,
    pub found: Separation,
}

/// What an earlier search with the same limits and bodies found, sorted by pair, and which bodies rest since. Two that
/// do and were beyond the limit still are, to the bit. What was found is found again, from the normal found then.
#[derive(Clone, Copy, Default)]
pub struct Earlier<'a> {
    pub found: &'a [Near],
    /// Empty if all bodies have moved.
    pub rests: &'a [bool],
}

impl Earlier<'_> {
    fn rest(&self, [a, b]: [usize; 2]) -> bool {
        !self.rests.is_empty() && self.rests[a] && self.rests[b]
    }

    /// What was found from `pair` on.
    fn from(&self, pair: [u32; 2]) -> Peekable<Iter<'_, Near>> {
        let first = if self.rests.is_empty() { 0 } else { self.found.partition_point(|near| near.pair < pair) };
        self.found[first..].iter().peekable()
    }
}

/// The separations of all `pairs` (sorted), placed as `placed(a, b)`, that are at most `limit(a, b)`; sorted by pair.
/// Searches start from the normals that are `known`; pairs that rest since `earlier` and were not found are left out.
pub fn within(
    pairs: &[[u32; 2]],
    (known, earlier): (&Pairs, Earlier<'_>),
    separate: Separate,
    placed: impl Fn(usize, usize) -> [Placed; 2] + Sync,
    limit: impl Fn(usize, usize) -> f64 + Sync,
) -> Vec<Near> {
    let of_chunk = |chunk: &[[u32; 2]]| {
        let mut out = Vec::new();
        let first = chunk.first().copied().unwrap_or_default();
        let (mut cursor, mut earlier_from) = (known.from(first), earlier.from(first));
        for &pair in chunk {
            let [a, b] = pair.map(|i| i as usize);
            if earlier.rest([a, b]) {
                while earlier_from.next_if(|near| near.pair < pair).is_some() {}
                if earlier_from.next_if(|near| near.pair == pair).is_none() {
                    continue;
                }
            }
            let warm = cursor.find(pair).and_then(Record::normal);
            if let Some(found) = pair_within(separate, &placed(a, b), warm, limit(a, b)) {
                out.push(Near { pair, feature: FEATURE_OF_SURFACES, found });
            }
        }
        out
    };
    if pairs.len() <= PAIRS_A_TASK {
        return of_chunk(pairs);
    }
    pairs.par_chunks(PAIRS_A_TASK).map(of_chunk).collect::<Vec<_>>().concat()
}

/// The pair's separation if it is at most `limit`; tests that only bound it from below come first.
fn pair_within(separate: Separate, [a, b]: &[Placed; 2], warm: Option<DVec3>, limit: f64) -> Option<Separation> {
    let delta = b.position - a.position;
    let reach = a.shape.bounding_radius() + b.shape.bounding_radius() + limit;
    let distance = delta.length();
    if distance > reach {
        return None;
    }
    // Concentric bodies have no direction to look along first.
    let direction = warm.unwrap_or(if distance > 0.0 { delta / distance } else { DVec3::Z });
    if bound(a, b, direction) > limit {
        return None;
    }
    separate(a, b, warm).filter(|found| found.separation <= limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::separation::separation;
    use crate::shape::Shape;
    use glam::DQuat;

    /// Balls in a row, each but the first `step` after the one before; the more the later.
    fn row(steps: impl Fn(usize) -> f64, count: usize) -> Vec<DVec3> {
        (0..count).scan(0.0, |x, i| (*x += steps(i), Some(DVec3::new(*x, 0.0, 0.0))).1).collect()
    }

    #[test]
    fn pairs_that_rest_are_not_looked_at_again_and_others_are() {
        let (shape, count) = (Shape::Sphere { radius: 0.5 }, 2_000);
        let all: Vec<[u32; 2]> = (1..count as u32).map(|i| [i - 1, i]).collect();
        let search = |places: &[DVec3], earlier: Earlier<'_>| {
            let placed = |i: usize| Placed { shape, position: places[i], orientation: DQuat::IDENTITY };
            within(&all, (&Pairs::default(), earlier), separation, |a, b| [placed(a), placed(b)], |_, _| 0.0)
        };
        let before = row(|i| if i % 3 == 0 { 1.5 } else { 0.9 }, count);
        let moved = |i: usize| (500..900).contains(&i) || i == 1_500;
        let after: Vec<DVec3> =
            before.iter().enumerate().map(|(i, x)| if moved(i) { *x * 1.001 } else { *x }).collect();
        let rests: Vec<bool> = (0..count).map(|i| !moved(i)).collect();
        let found = search(&before, Earlier::default());
        let again = search(&after, Earlier { found: &found, rests: &rests });
        assert_eq!(again, search(&after, Earlier::default()));
        assert!(again != found);
        // Those that rest and were not found are not looked at.
        let none = search(&after, Earlier { found: &[], rests: &rests });
        let rest = |near: &Near| near.pair.iter().all(|i| rests[*i as usize]);
        assert!(!none.is_empty() && none.iter().all(|near| !rest(near)) && again.iter().any(rest));
    }
}
