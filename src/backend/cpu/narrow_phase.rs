//! Narrow phase: the separations of candidate pairs that are within a limit, with every far pair left out as cheaply as
//! it can be.

use crate::constraint::FEATURE_OF_SURFACES;
use crate::separation::{Placed, Separation, bound};
use crate::warm::Warm;
use glam::DVec3;
use rayon::prelude::*;

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

/// A pair's normal, found before: where the next search starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    pub pair: [u32; 2],
    pub normal: DVec3,
}

impl From<&Near> for Known {
    fn from(near: &Near) -> Known {
        Known { pair: near.pair, normal: near.found.normal }
    }
}

/// The normals that the last step left, one a pair.
pub fn remembered(warm: &[Warm]) -> Vec<Known> {
    let found = warm.iter().filter(|w| w.normal != DVec3::ZERO);
    let mut known: Vec<Known> = found.map(|w| Known { pair: w.pair, normal: w.normal }).collect();
    known.dedup_by_key(|k| k.pair);
    known
}

/// The separations of all `pairs` (sorted), placed as `placed(a, b)`, that are at most `limit(a, b)`; sorted by pair.
/// `known` (sorted) are normals to start from.
pub fn within(
    pairs: &[[u32; 2]],
    known: &[Known],
    separate: Separate,
    placed: impl Fn(usize, usize) -> [Placed; 2] + Sync,
    limit: impl Fn(usize, usize) -> f64 + Sync,
) -> Vec<Near> {
    let of_chunk = |chunk: &[[u32; 2]]| {
        let mut out = Vec::new();
        let mut cursor = chunk.first().map_or(0, |first| known.partition_point(|k| k.pair < *first));
        for &pair in chunk {
            while known.get(cursor).is_some_and(|k| k.pair < pair) {
                cursor += 1;
            }
            let warm = known.get(cursor).filter(|k| k.pair == pair).map(|k| k.normal);
            let [a, b] = pair.map(|i| i as usize);
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

/// Puts the normals of `found` (sorted) into `known` (sorted), in place of older ones.
pub fn renew(known: &mut Vec<Known>, found: &[Near]) {
    let mut merged = Vec::with_capacity(known.len() + found.len());
    let mut old = known.iter().peekable();
    for near in found {
        while let Some(k) = old.next_if(|k| k.pair < near.pair) {
            merged.push(*k);
        }
        old.next_if(|k| k.pair == near.pair);
        merged.push(Known::from(near));
    }
    merged.extend(old);
    *known = merged;
}

/// Copies the normals of `known` (sorted) to the same pairs in `warm` (sorted).
pub fn copy_normals(known: &[Known], warm: &mut [Warm]) {
    let mut cursor = 0;
    for w in warm {
        while known.get(cursor).is_some_and(|k| k.pair < w.pair) {
            cursor += 1;
        }
        if let Some(k) = known.get(cursor).filter(|k| k.pair == w.pair) {
            w.normal = k.normal;
        }
    }
}
