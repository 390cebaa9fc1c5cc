//! Loops over pairs that processes share: each takes a part of them, and all take the rows of all parts in their order.

use super::narrow_phase::Near;
use crate::processes::{Processes, parts};
use crate::separation::Separation;
use glam::DVec3;
use std::ops::Range;

/// Fewer pairs than this each process looks at by itself: a pair takes 50 to 500 ns, and an exchange some microseconds
/// and 100 bytes a row.
const LEAST_PAIRS: usize = 512;

/// Words of a row in a message.
const WORDS: usize = 12;

/// What `work` makes of the pairs at places `0..pairs`.
pub(super) fn shared(
    processes: Option<Processes>,
    pairs: usize,
    work: impl FnOnce(Range<usize>) -> Vec<Near>,
) -> Vec<Near> {
    let Some(processes) = processes.filter(|_| pairs >= LEAST_PAIRS) else { return work(0..pairs) };
    let own = work(parts(pairs, processes.size())[processes.rank()].clone());
    let words: Vec<u64> = own.iter().flat_map(pack).collect();
    processes.gather(&words).as_chunks::<WORDS>().0.iter().map(unpack).collect()
}

fn pack(near: &Near) -> [u64; WORDS] {
    let Near { pair: [a, b], feature, found: Separation { separation, normal, lever_a, lever_b } } = *near;
    let [n, p, q] = [normal, lever_a, lever_b].map(|v| v.to_array().map(f64::to_bits));
    let pair = u64::from(a) << 32 | u64::from(b);
    [pair, feature.into(), separation.to_bits(), n[0], n[1], n[2], p[0], p[1], p[2], q[0], q[1], q[2]]
}

fn unpack(words: &[u64; WORDS]) -> Near {
    let vector = |first: usize| DVec3::from_array(std::array::from_fn(|k| f64::from_bits(words[first + k])));
    Near {
        pair: [(words[0] >> 32) as u32, words[0] as u32],
        feature: words[1] as u32,
        found: Separation {
            separation: f64::from_bits(words[2]),
            normal: vector(3),
            lever_a: vector(6),
            lever_b: vector(9),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_the_same_bits_after_its_way() {
        let near = Near {
            pair: [7, u32::MAX - 3],
            feature: u32::MAX,
            found: Separation {
                separation: -0.0,
                normal: DVec3::new(1.0 / 3.0, f64::MIN_POSITIVE / 4.0, -0.0),
                lever_a: DVec3::new(1e300, 2.0, 3.0),
                lever_b: DVec3::new(4.0, 5.0, -6.0),
            },
        };
        assert_eq!(pack(&unpack(&pack(&near))), pack(&near));
        assert_eq!(unpack(&pack(&near)), near);
    }
}
