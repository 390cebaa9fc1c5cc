//! Loops over vectors with one entry per row, and sums in chunks.
//!
//! A sum combines the partial sums of chunks along a binary tree over the chunks. So its bits do not depend on which
//! thread or process computes which chunks, and one that has all chunks of a branch contributes a single value. A
//! partial sum has eight interleaved parts, which the compiler vectorizes.

use std::ops::Range;

/// Interleaved parts of a sum.
pub(super) const PARTS: usize = 8;

/// This many entries of each of six vectors fit together into the first-level cache, 24 KiB.
const CACHED: usize = 512;

/// Passes over fewer rows than this run on one thread while a problem is loaded: a row takes some 5 ns.
pub(super) const LEAST_ROWS_A_TASK: usize = 4_096;

/// Consecutive ranges of rows.
#[derive(Clone, Debug, Default)]
pub struct Chunks {
    /// The first row of each chunk, and the number of rows.
    edges: Vec<usize>,
}

impl Chunks {
    /// Chunks of `size` rows; the last one has the remaining rows.
    pub fn of_rows(rows: usize, size: usize) -> Self {
        Chunks { edges: (0..rows).step_by(size).chain([rows]).collect() }
    }

    /// Chunks between these edges: 0, where one ends and the next begins, and the number of rows.
    pub fn between(edges: Vec<usize>) -> Self {
        Chunks { edges }
    }

    /// The number of chunks.
    pub fn len(&self) -> usize {
        self.edges.len().saturating_sub(1)
    }

    /// The rows of each chunk.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.edges.windows(2).map(|edges| edges[0]..edges[1])
    }

    /// Divides the chunks in order into shares with about as many rows each: the chunks of every share.
    pub fn shares(&self, shares: usize) -> Vec<Range<usize>> {
        let rows = self.edges.last().copied().unwrap_or(0);
        let edge = |share: usize| self.edges.partition_point(|edge| edge * shares < share * rows).min(self.len());
        (0..shares).map(|share| edge(share)..edge(share + 1)).collect()
    }

    /// The chunks of a share, with rows counted from its first one, and the range of all its rows.
    pub fn share(&self, chunks: &Range<usize>) -> (Chunks, Range<usize>) {
        let edges = &self.edges[chunks.start..=chunks.end];
        let (first, last) = (edges[0], edges[edges.len() - 1]);
        (Chunks { edges: edges.iter().map(|edge| edge - first).collect() }, first..last)
    }
}

/// `out[i] = value(inputs[..][i])`, by slices of equal length, so that the loop has no checks.
pub(crate) fn map<const N: usize>(out: &mut [f64], inputs: [&[f64]; N], value: impl Fn([f64; N]) -> f64) {
    update(out, inputs, |_, numbers| value(numbers));
}

/// `out[i] = value(out[i], inputs[..][i])`.
pub(crate) fn update<const N: usize>(out: &mut [f64], inputs: [&[f64]; N], value: impl Fn(f64, [f64; N]) -> f64) {
    let inputs = inputs.map(|input| &input[..out.len()]);
    for (i, out) in out.iter_mut().enumerate() {
        *out = value(*out, std::array::from_fn(|k| inputs[k][i]));
    }
}

/// `x . y` of each pair on a chunk, in one pass: a vector in several pairs is loaded into the first-level cache once.
pub(crate) fn dots<const N: usize>(chunk: Range<usize>, pairs: [[&[f64]; 2]; N]) -> [f64; N] {
    let mut parts = [[0.0; PARTS]; N];
    for first in chunk.clone().step_by(CACHED) {
        let range = first..(first + CACHED).min(chunk.end);
        for ([x, y], parts) in pairs.iter().zip(&mut parts) {
            let (x, y) = (x[range.clone()].as_chunks::<PARTS>(), y[range.clone()].as_chunks::<PARTS>());
            let mut sums = *parts;
            for (x, y) in x.0.iter().zip(y.0) {
                for (k, sum) in sums.iter_mut().enumerate() {
                    *sum += x[k] * y[k];
                }
            }
            for (sum, (x, y)) in sums.iter_mut().zip(x.1.iter().zip(y.1)) {
                *sum += x * y;
            }
            *parts = sums;
        }
    }
    parts.map(|parts| parts.into_iter().fold(0.0, |a, b| a + b))
}

/// Folds `value(inputs[..][i])` over a chunk with `join`.
pub(crate) fn fold<const N: usize>(
    chunk: Range<usize>,
    inputs: [&[f64]; N],
    start: f64,
    join: impl Fn(f64, f64) -> f64,
    value: impl Fn([f64; N]) -> f64,
) -> f64 {
    let rows = chunk.len();
    let chunks = inputs.map(|input| input[chunk.clone()].as_chunks::<PARTS>());
    let mut parts = [start; PARTS];
    for c in 0..rows / PARTS {
        let chunk = chunks.map(|(whole, _)| whole[c]);
        for (k, part) in parts.iter_mut().enumerate() {
            *part = join(*part, value(std::array::from_fn(|n| chunk[n][k])));
        }
    }
    for (k, part) in parts.iter_mut().enumerate().take(rows % PARTS) {
        *part = join(*part, value(std::array::from_fn(|n| chunks[n].1[k])));
    }
    parts.into_iter().fold(start, &join)
}

/// The largest number of branches that wait for their other half: enough for any number of chunks.
const DEEPEST: usize = 32;

/// Combines the values of chunks along the tree, in the order of the chunks.
pub(crate) struct Tree<F, const N: usize> {
    join: F,
    /// The values of the branches that wait for their other half, the largest first, each with its level: it has
    /// `2^level` chunks.
    waiting: [([f64; N], u32); DEEPEST],
    count: usize,
}

impl<F: Fn(usize, f64, f64) -> f64, const N: usize> Tree<F, N> {
    /// An empty tree. `join` combines two values of each of `N` kinds.
    pub fn new(join: F) -> Self {
        Tree { join, waiting: [([0.0; N], 0); DEEPEST], count: 0 }
    }

    /// Adds the value of the next `2^level` chunks. The number of chunks before them must be a multiple of that.
    #[inline]
    pub fn add(&mut self, mut value: [f64; N], mut level: u32) {
        while self.count > 0 && self.waiting[self.count - 1].1 == level {
            self.count -= 1;
            value = self.both(self.waiting[self.count].0, value);
            level += 1;
        }
        self.waiting[self.count] = (value, level);
        self.count += 1;
    }

    /// The value of all chunks; `start` if there were none.
    pub fn end(self, start: [f64; N]) -> [f64; N] {
        let branches = self.waiting[..self.count].iter().rev();
        branches.map(|(value, _)| *value).reduce(|later, value| self.both(value, later)).unwrap_or(start)
    }

    #[inline]
    fn both(&self, a: [f64; N], b: [f64; N]) -> [f64; N] {
        std::array::from_fn(|k| (self.join)(k, a[k], b[k]))
    }
}

/// Combines the values of consecutive chunks along the tree of all chunks.
pub(super) fn join_chunks<const N: usize>(
    start: [f64; N],
    join: impl Fn(usize, f64, f64) -> f64,
    mut chunk: impl FnMut(Range<usize>) -> [f64; N],
    chunks: &Chunks,
) -> [f64; N] {
    let mut tree = Tree::new(join);
    chunks.ranges().for_each(|rows| tree.add(chunk(rows), 0));
    tree.end(start)
}

/// The levels of the largest branches that make up consecutive chunks.
#[cfg(any(feature = "mpi", test))]
pub(crate) fn branches(chunks: Range<usize>) -> Vec<u32> {
    let (mut levels, mut at) = (Vec::new(), chunks.start);
    while at < chunks.end {
        let level = at.trailing_zeros().min((chunks.end - at).ilog2());
        levels.push(level);
        at += 1 << level;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_all_rows_once() {
        let chunks = Chunks::between(vec![0, 102, 201, 300, 420, 500, 1_000]);
        for shares in [1, 2, 3, 7, 16] {
            let rows: Vec<usize> = chunks.shares(shares).iter().flat_map(|share| chunks.share(share).1).collect();
            assert!(rows.into_iter().eq(0..1_000), "{shares}");
        }
        assert_eq!(Chunks::of_rows(250, 100).edges, [0, 100, 200, 250]);
        assert_eq!((Chunks::of_rows(0, 100).len(), Chunks::between(vec![0]).len()), (0, 0));
    }

    #[test]
    fn sums_are_those_of_a_plain_loop() {
        let x: Vec<f64> = (0..700).map(|i| f64::from(i % 13) - 6.0).collect();
        let y: Vec<f64> = (0..700).map(|i| f64::from(i % 7)).collect();
        let plain: f64 = x.iter().zip(&y).map(|(x, y)| x * y).sum();
        for size in [1, 5, 64, 600, 5_000] {
            let chunks = Chunks::of_rows(700, size);
            let mut tree = Tree::new(|_, a, b| a + b);
            chunks.ranges().for_each(|rows| tree.add(dots(rows, [[&x, &y]]), 0));
            assert_eq!(tree.end([0.0]), [plain]);
            let least = |rows| fold(rows, [&x], f64::INFINITY, f64::min, |[x]| x);
            assert_eq!(chunks.ranges().map(least).fold(f64::INFINITY, f64::min), -6.0);
        }
    }

    #[test]
    fn branches_of_some_and_of_all_come_to_the_same_bits() {
        let chunks: Vec<f64> = (0..37).map(|k| 1.0 / f64::from(k + 3)).collect();
        let add = |_: usize, a: f64, b: f64| a + b;
        let one_by_one = |chunks: &[f64]| {
            let mut tree = Tree::new(add);
            chunks.iter().for_each(|chunk| tree.add([*chunk], 0));
            tree.end([0.0])
        };
        let mut cuts: Vec<usize> = vec![0, 37];
        for cut in [16, 5, 6, 32, 33] {
            cuts.push(cut);
            cuts.sort_unstable();
            let mut tree = Tree::new(add);
            for ends in cuts.windows(2) {
                let mut at = ends[0];
                let mut levels = Vec::new();
                while at < ends[1] {
                    let level = (at as u64 | 1 << 40).trailing_zeros().min((ends[1] - at).ilog2());
                    tree.add(one_by_one(&chunks[at..at + (1 << level)]), level);
                    levels.push(level);
                    at += 1 << level;
                }
                assert_eq!(branches(ends[0]..ends[1]), levels);
            }
            assert_eq!(tree.end([0.0]), one_by_one(&chunks), "{cuts:?}");
        }
        assert_eq!(one_by_one(&[]), [0.0]);
    }
}
