//! The diagonal blocks of `A`, one per pair of bodies, as a metric: small exact projected steps.
//!
//! All rows of a pair act between the same two bodies, so they span at most `D` directions of relative motion, and rows
//! of nearly the same contact are nearly parallel. Solving each block exactly removes this ill-conditioning from the
//! iteration; only the coupling of different pairs is left. A relative regularization makes a block of parallel rows
//! positive definite.

mod larger;
mod small;

use super::cone;
use super::loops::Chunks;
use super::product::dot;
use larger::Larger;
use rayon::prelude::*;
use small::{Block, Double, Packed, Single};

/// Relative addition to the diagonal of a block. On the stored systems 1e-6, 1e-7 and 1e-8 cost the same products
/// within a quarter; 1e-6 costs the least if pairs have many rows, and keeps most digits of the Cholesky factor of a
/// block with repeated rows.
const REGULARIZATION: f64 = 1e-6;

/// Blocks of fewer chunks than this are built by one thread: a chunk of some 300 rows takes some 10 microseconds.
const LEAST_CHUNKS_A_TASK: usize = 8;

/// The largest number of rows of a block with a specialized type.
const SMALL: usize = 8;

/// The blocks of rows in the order of [`order`], chunk by chunk.
#[derive(Clone, Debug, Default)]
pub struct PairBlocks {
    chunks: Vec<Blocks>,
}

/// The blocks of consecutive chunks, for one thread.
pub(crate) struct Part<'a> {
    chunks: &'a mut [Blocks],
}

/// The blocks of a chunk.
#[derive(Clone, Debug, Default)]
pub(crate) struct Blocks {
    singles: Vec<Single>,
    doubles: Vec<Double>,
    triples: Vec<Packed<3, 6>>,
    fours: Vec<Packed<4, 10>>,
    fives: Vec<Packed<5, 15>>,
    sixes: Vec<Packed<6, 21>>,
    sevens: Vec<Packed<7, 28>>,
    eights: Vec<Packed<8, 36>>,
    larger: Larger,
    /// 1 for nonzero rows of `A`, else 0.
    live: Vec<f64>,
}

/// The function to minimize, over adjacent rows.
#[derive(Clone, Copy)]
struct Step<'a> {
    x: &'a [f64],
    /// The step and the gradient. Without them the point is projected.
    slope: Option<(f64, &'a [f64])>,
    live: &'a [f64],
}

/// Orders rows so that those of a pair are adjacent: pairs with one row first, then those with two, up to eight, then
/// all others, each class by pair; the rows of a pair keep their order.
pub fn order(pair: &[[u32; 2]], order: &mut Vec<u32>) {
    by_pair(pair, order);
    let class = classes(pair, order);
    order.sort_by_key(|row| class[*row as usize]);
}

/// The same within chunks of about `size` rows, each with all pairs whose smaller bodies are in a range.
pub(crate) fn order_in_chunks(pair: &[[u32; 2]], size: usize, order: &mut Vec<u32>) -> Chunks {
    by_pair(pair, order);
    let body = |row: u32| sorted(pair[row as usize])[0];
    let mut edges = vec![0];
    let mut last = 0;
    for bodies in order.chunk_by(|i, j| body(*i) == body(*j)) {
        last += bodies.len();
        if last - edges[edges.len() - 1] >= size {
            edges.push(last);
        }
    }
    if last > edges[edges.len() - 1] {
        edges.push(last);
    }
    by_class(pair, Chunks::between(edges), order)
}

/// The same within one chunk per block of bodies, with all pairs whose smaller bodies are in it; `blocks` has the first
/// body of each block, and the end.
pub(crate) fn order_in_blocks(pair: &[[u32; 2]], blocks: &[u32], order: &mut Vec<u32>) -> Chunks {
    by_pair(pair, order);
    let body = |row: &u32| sorted(pair[*row as usize])[0];
    let mut edges: Vec<usize> = blocks.iter().map(|first| order.partition_point(|row| body(row) < *first)).collect();
    if let Some(last) = edges.last_mut() {
        *last = order.len();
    }
    by_class(pair, Chunks::between(edges), order)
}

/// Orders the rows of each chunk, already sorted by pair, by the number of rows of their pair.
fn by_class(pair: &[[u32; 2]], chunks: Chunks, order: &mut [u32]) -> Chunks {
    let class = classes(pair, order);
    for rows in chunks.ranges() {
        order[rows].sort_by_key(|row| class[*row as usize]);
    }
    chunks
}

/// Orders rows by pair, stably: by the smaller body in one pass over all rows, then within each body.
pub(crate) fn by_pair(pair: &[[u32; 2]], order: &mut Vec<u32>) {
    let bodies = pair.as_flattened().iter().map(|body| *body as usize + 1).max().unwrap_or(0);
    let mut next = vec![0_u32; bodies + 1];
    pair.iter().for_each(|pair| next[sorted(*pair)[0] as usize + 1] += 1);
    for body in 0..bodies {
        next[body + 1] += next[body];
    }
    order.clear();
    order.resize(pair.len(), 0);
    for (row, pair) in (0..).zip(pair) {
        let next = &mut next[sorted(*pair)[0] as usize];
        order[*next as usize] = row;
        *next += 1;
    }
    let other = |row: &u32| sorted(pair[*row as usize])[1];
    let mut first = 0;
    for end in next.into_iter().take(bodies).map(|end| end as usize) {
        order[first..end].sort_by_key(other);
        first = end;
    }
}

/// The class of each row: the number of rows of its pair, up to one above [`SMALL`]; `order` is by pair.
fn classes(pair: &[[u32; 2]], order: &[u32]) -> Vec<u8> {
    let mut class = vec![0_u8; pair.len()];
    for block in order.chunk_by(|i, j| sorted(pair[*i as usize]) == sorted(pair[*j as usize])) {
        for row in block {
            class[*row as usize] = block.len().min(SMALL + 1) as u8;
        }
    }
    class
}

impl PairBlocks {
    /// Builds the blocks of rows in the order of [`order`] in each chunk; `live` marks the nonzero rows of `A`.
    pub(crate) fn rebuild<const D: usize>(
        &mut self,
        pair: &[[u32; 2]],
        jacobian: &[[[f64; D]; 2]],
        live: &[bool],
        chunks: &Chunks,
    ) {
        self.chunks.resize_with(chunks.len(), Blocks::default);
        let ranges: Vec<_> = chunks.ranges().collect();
        let all = self.chunks.par_iter_mut().zip(ranges).with_min_len(LEAST_CHUNKS_A_TASK);
        all.for_each(|(blocks, rows)| blocks.rebuild(&pair[rows.clone()], &jacobian[rows.clone()], &live[rows]));
    }

    /// The blocks chunk by chunk.
    pub(crate) fn chunks(&mut self) -> impl Iterator<Item = &mut Blocks> {
        self.chunks.iter_mut()
    }

    /// All blocks.
    pub(crate) fn whole(&mut self) -> Part<'_> {
        Part { chunks: &mut self.chunks }
    }
}

impl Part<'_> {
    /// With a slope, a step and a gradient: `out = argmin over y >= 0 of step g . (y - x) + 1/2 (y - x) . B (y - x)`.
    /// Zero rows of `A` keep `x`, which is not negative there. Without a slope, the projection: `out = argmin over y >=
    /// 0 of (y - x) . B (y - x)`.
    pub fn minimize(&mut self, x: &[f64], slope: Option<(f64, &[f64])>, out: &mut [f64]) {
        let mut first = 0;
        for blocks in &mut *self.chunks {
            let rows = first..first + blocks.live.len();
            first = rows.end;
            let slope = slope.map(|(step, g)| (step, &g[rows.clone()]));
            blocks.minimize(&x[rows.clone()], slope, &mut out[rows]);
        }
    }
}

impl<'a> Part<'a> {
    /// The blocks chunk by chunk.
    pub fn chunks(&mut self) -> impl Iterator<Item = &mut Blocks> {
        self.chunks.iter_mut()
    }

    /// Splits off the first `chunks` chunks.
    pub fn split_at(self, chunks: usize) -> (Part<'a>, Part<'a>) {
        let (first, others) = self.chunks.split_at_mut(chunks);
        (Part { chunks: first }, Part { chunks: others })
    }
}

impl Blocks {
    fn rebuild<const D: usize>(&mut self, pair: &[[u32; 2]], jacobian: &[[[f64; D]; 2]], live: &[bool]) {
        self.clear();
        self.live.extend(live.iter().map(|live| f64::from(u8::from(*live))));
        let matrix = |i: usize, j: usize| match (i == j, live[i]) {
            (true, true) => entry(pair, jacobian, i, j) * (1.0 + REGULARIZATION),
            (true, false) => 1.0,
            (false, _) => entry(pair, jacobian, i, j),
        };
        let mut first = 0;
        for block in pair.chunk_by(|p, q| sorted(*p) == sorted(*q)) {
            let entry = |i: usize, j: usize| matrix(first + i, first + j);
            match block.len() {
                1 => self.singles.push(Single(self.live[first] / entry(0, 0))),
                2 => self.doubles.push(Double::new([entry(0, 0), entry(1, 0), entry(1, 1)])),
                3 => self.triples.push(Packed::new(entry)),
                4 => self.fours.push(Packed::new(entry)),
                5 => self.fives.push(Packed::new(entry)),
                6 => self.sixes.push(Packed::new(entry)),
                7 => self.sevens.push(Packed::new(entry)),
                8 => self.eights.push(Packed::new(entry)),
                m => self.larger.push(m, entry),
            }
            first += block.len();
        }
    }

    fn clear(&mut self) {
        self.singles.clear();
        self.doubles.clear();
        self.triples.clear();
        self.fours.clear();
        self.fives.clear();
        self.sixes.clear();
        self.sevens.clear();
        self.eights.clear();
        self.larger.clear();
        self.live.clear();
    }

    /// [`Part::minimize`] of these rows.
    pub fn minimize(&mut self, x: &[f64], slope: Option<(f64, &[f64])>, out: &mut [f64]) {
        let mut rest = Rest { step: Step { x, slope, live: &self.live }, out };
        rest.each(&mut self.singles);
        rest.each(&mut self.doubles);
        rest.each(&mut self.triples);
        rest.each(&mut self.fours);
        rest.each(&mut self.fives);
        rest.each(&mut self.sixes);
        rest.each(&mut self.sevens);
        rest.each(&mut self.eights);
        self.larger.minimize(rest.step, rest.out);
    }
}

impl<'a> Step<'a> {
    fn split_at(self, n: usize) -> (Self, Self) {
        let ((x, x_rest), (live, live_rest)) = (self.x.split_at(n), self.live.split_at(n));
        let part = |(length, g): (f64, &'a [f64])| (length, &g[..n]);
        let rest = |(length, g): (f64, &'a [f64])| (length, &g[n..]);
        (
            Step { x, slope: self.slope.map(part), live },
            Step { x: x_rest, slope: self.slope.map(rest), live: live_rest },
        )
    }
}

/// The rows that are left.
struct Rest<'a> {
    step: Step<'a>,
    out: &'a mut [f64],
}

impl Rest<'_> {
    /// Solves the next blocks, of `M` rows each.
    fn each<const M: usize, B: Block<M>>(&mut self, blocks: &mut [B]) {
        if blocks.is_empty() {
            return;
        }
        let rows = M * blocks.len();
        let (step, rest) = self.step.split_at(rows);
        let (out, rest_out) = std::mem::take(&mut self.out).split_at_mut(rows);
        (self.step, self.out) = (rest, rest_out);
        solve(blocks, step, out);
    }
}

fn solve<const M: usize, B: Block<M>>(blocks: &mut [B], step: Step, out: &mut [f64]) {
    let (x, live, out) = (step.x.as_chunks::<M>().0, step.live.as_chunks::<M>().0, out.as_chunks_mut::<M>().0);
    match step.slope {
        Some((length, g)) => {
            let data = x.iter().zip(g.as_chunks::<M>().0).zip(live);
            for ((block, ((x, g), live)), out) in blocks.iter_mut().zip(data).zip(out) {
                *out = block.proximal(*x, std::array::from_fn(|i| length * g[i] * live[i]));
            }
        }
        None => {
            for ((block, x), out) in blocks.iter().zip(x).zip(out) {
                // A block in the cone, as nearly all are, is its own projection.
                let outside = x.iter().fold(false, |outside, x| outside | cone::is_outside(*x));
                *out = if outside { block.project(*x) } else { *x };
            }
        }
    }
}

/// A pair with its smaller body first.
pub(crate) fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// `A_ij` of two rows of the same pair, whose bodies may be in either order.
pub(crate) fn entry<const D: usize>(pair: &[[u32; 2]], jacobian: &[[[f64; D]; 2]], i: usize, j: usize) -> f64 {
    let ([ia, ib], [ja, jb]) = (&jacobian[i], &jacobian[j]);
    if pair[i] == pair[j] { dot(ia, ja) + dot(ib, jb) } else { dot(ia, jb) + dot(ib, ja) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Checks the optimality conditions of the small problems on pairs of 1 to 24 rows in mixed order, with some
    /// repeated rows and one zero row.
    #[test]
    fn proximal_steps_solve_their_blocks() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut uniform = || rng.random::<f64>() - 0.5;
        let (mut pair, mut jacobian) = (Vec::new(), Vec::<[[f64; 3]; 2]>::new());
        for row in 0..24 {
            for first in (row..24).step_by(3) {
                let turned = row % 2 == 1;
                pair.push(if turned { [first + 1, first] } else { [first, first + 1] });
                jacobian.push(std::array::from_fn(|_| std::array::from_fn(|_| uniform())));
            }
        }
        let last = jacobian.len() - 1;
        jacobian[last] = [[0.0; 3]; 2];
        let mut places = Vec::new();
        let chunks = order_in_chunks(&pair, 40, &mut places);
        assert!(chunks.len() > 2);
        let pair: Vec<[u32; 2]> = places.iter().map(|row| pair[*row as usize]).collect();
        let mut jacobian: Vec<[[f64; 3]; 2]> = places.iter().map(|row| jacobian[*row as usize]).collect();
        for i in (1..pair.len()).step_by(4).filter(|i| pair[*i] == pair[i - 1]) {
            jacobian[i] = jacobian[i - 1];
        }
        let live: Vec<bool> = jacobian.iter().map(|blocks| *blocks != [[0.0; 3]; 2]).collect();
        assert!(live.contains(&false));
        let mut blocks = PairBlocks::default();
        blocks.rebuild(&pair, &jacobian, &live, &chunks);

        let x: Vec<f64> = pair.iter().map(|_| uniform().max(0.0)).collect();
        let g: Vec<f64> = pair.iter().map(|_| uniform()).collect();
        let mut y = vec![0.0; x.len()];
        blocks.whole().minimize(&x, Some((0.7, &g)), &mut y);
        for i in 0..x.len() {
            if !live[i] {
                assert_eq!(y[i], x[i]);
                continue;
            }
            let mut rise = 0.7 * g[i];
            for j in (0..x.len()).filter(|j| sorted(pair[*j]) == sorted(pair[i])) {
                let shift = if i == j { 1.0 + REGULARIZATION } else { 1.0 };
                rise += shift * entry(&pair, &jacobian, i, j) * (y[j] - x[j]);
            }
            assert!(y[i] >= 0.0 && rise > -1e-8 && (y[i] == 0.0 || rise.abs() < 1e-8), "{i}: {} {rise:e}", y[i]);
        }
        blocks.whole().minimize(&x, None, &mut y);
        assert_eq!(y, x);
    }
}
