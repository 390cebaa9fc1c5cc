//! Sorts pairs in ascending order, in time linear in their number: first into buckets by the lower index, then within
//! each bucket, whose size does not grow with the scene (about half the time of comparison sorts of the buckets).

use super::each;

/// The lower indices of a bucket, as a power of two: with about ten pairs per body, a bucket stays in a core's cache.
const BUCKET_BITS: u32 = 10;

/// A pair as one integer with the same order.
pub(super) fn pack(one: u32, other: u32) -> u64 {
    (u64::from(one.min(other)) << 32) | u64::from(one.max(other))
}

fn unpack(packed: u64) -> [u32; 2] {
    [(packed >> 32) as u32, packed as u32]
}

/// Replaces `pairs` by all pairs of `found`, ascending. Indices are below `bodies`.
pub(super) fn order(found: &[Vec<u64>], bodies: usize, parallel: bool, pairs: &mut Vec<[u32; 2]>) {
    let bucket = |packed: u64| (packed >> (32 + BUCKET_BITS)) as usize;
    let mut end = vec![0usize; (bodies >> BUCKET_BITS) + 1];
    let total = found.iter().map(Vec::len).sum();
    for &packed in found.iter().flatten() {
        end[bucket(packed)] += 1;
    }
    let mut sum = 0;
    for count in &mut end {
        sum += std::mem::replace(count, sum);
    }
    pairs.clear();
    pairs.resize(total, [0, 0]);
    for &packed in found.iter().flatten() {
        let next = &mut end[bucket(packed)];
        pairs[*next] = unpack(packed);
        *next += 1;
    }
    let mut rest = pairs.as_mut_slice();
    let mut begin = 0;
    let mut buckets = Vec::with_capacity(end.len());
    for end in end {
        let (head, tail) = rest.split_at_mut(end - begin);
        buckets.push(head);
        (rest, begin) = (tail, end);
    }
    each(parallel, &mut buckets, |_, bucket| order_bucket(bucket));
}

/// Counting sort by the lower index, then a sort of every body's few partners.
fn order_bucket(bucket: &mut [[u32; 2]]) {
    const SIZE: usize = 1 << BUCKET_BITS;
    let mut end = [0usize; SIZE];
    for [a, _] in bucket.iter() {
        end[*a as usize % SIZE] += 1;
    }
    let mut sum = 0;
    for count in &mut end {
        sum += std::mem::replace(count, sum);
    }
    let unordered = bucket.to_vec();
    for [a, b] in unordered {
        let next = &mut end[a as usize % SIZE];
        bucket[*next] = [a, b];
        *next += 1;
    }
    let mut begin = 0;
    for end in end {
        bucket[begin..end].sort_unstable_by_key(|[_, b]| *b);
        begin = end;
    }
}
