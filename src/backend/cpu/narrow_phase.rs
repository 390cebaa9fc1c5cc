//! Narrow phase: the separations of candidate pairs that are within a limit, with every far pair left out as cheaply as
//! it can be.

use super::pairs::{Pairs, Record};
use crate::constraint::FEATURE_OF_SURFACES;
use crate::separation::{Placed, Separation, bound};
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

/// The separations of all `pairs` (sorted), placed as `placed(a, b)`, that are at most `limit(a, b)`; sorted by pair.
/// Searches start from the normals that are `known`.
pub fn within(
    pairs: &[[u32; 2]],
    known: &Pairs,
    separate: Separate,
    placed: impl Fn(usize, usize) -> [Placed; 2] + Sync,
    limit: impl Fn(usize, usize) -> f64 + Sync,
) -> Vec<Near> {
    let of_chunk = |chunk: &[[u32; 2]]| {
        let mut out = Vec::new();
        let mut cursor = known.from(chunk.first().copied().unwrap_or_default());
        for &pair in chunk {
            let warm = cursor.find(pair).and_then(Record::normal);
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
