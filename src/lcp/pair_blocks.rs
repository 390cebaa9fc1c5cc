//! The diagonal blocks of `A` that belong to one pair of bodies, as a metric: small exact projected steps.
//!
//! All rows of a pair act between the same two bodies, so they span at most `D` directions of relative motion, and rows
//! of nearly the same contact are nearly parallel. Solving a block exactly takes that ill-conditioning out of the way
//! of an iteration; what is left couples different pairs. Blocks get a relative regularization, which makes a block of
//! parallel rows positive definite.

mod larger;
mod small;

use super::product::dot;
use larger::Larger;
use small::{Block, Double, Packed, Single};

/// Relative addition to the diagonal of a block. On the stored systems 1e-6, 1e-7 and 1e-8 cost the same products
/// within a quarter, the largest of them the least where a pair has many rows; it keeps most digits of the Cholesky
/// factor of a block with repeated rows.
const REGULARIZATION: f64 = 1e-6;

/// The most rows of a block that has a type of its own.
const SMALL: usize = 8;

/// The blocks of rows that stand in the order of [`order`].
#[derive(Clone, Debug, Default)]
pub struct PairBlocks {
    singles: Vec<Single>,
    doubles: Vec<Double>,
    triples: Vec<Packed<3, 6>>,
    fours: Vec<Packed<4, 10>>,
    fives: Vec<Packed<5, 15>>,
    sixes: Vec<Packed<6, 21>>,
    sevens: Vec<Packed<7, 28>>,
    eights: Vec<Packed<8, 36>>,
    larger: Larger,
    /// 1 for rows of `A` that are not zero, else 0.
    live: Vec<f64>,
}

/// Consecutive blocks, for one thread.
pub(crate) struct Part<'a> {
    singles: &'a mut [Single],
    doubles: &'a mut [Double],
    triples: &'a mut [Packed<3, 6>],
    fours: &'a mut [Packed<4, 10>],
    fives: &'a mut [Packed<5, 15>],
    sixes: &'a mut [Packed<6, 21>],
    sevens: &'a mut [Packed<7, 28>],
    eights: &'a mut [Packed<8, 36>],
    larger: larger::Part<'a>,
    live: &'a [f64],
}

/// What is minimized, over rows that stand together.
#[derive(Clone, Copy)]
struct Step<'a> {
    x: &'a [f64],
    /// The step and the gradient. Without one the point is projected.
    slope: Option<(f64, &'a [f64])>,
    live: &'a [f64],
}

/// Orders rows so that those of a pair stand together: pairs with one row first, then those with two, up to eight, then
/// the others, each by pair; the rows of a pair in their own order.
pub fn order(pair: &[[u32; 2]], order: &mut Vec<u32>) {
    order.clear();
    order.extend(0..pair.len() as u32);
    order.sort_by_key(|row| sorted(pair[*row as usize]));
    let mut class = vec![0_u8; pair.len()];
    for block in order.chunk_by(|i, j| sorted(pair[*i as usize]) == sorted(pair[*j as usize])) {
        for row in block {
            class[*row as usize] = block.len().min(SMALL + 1) as u8;
        }
    }
    order.sort_by_key(|row| class[*row as usize]);
}

impl PairBlocks {
    /// Makes the blocks of rows that stand in the order of [`order`]; `live` says which rows of `A` are not zero.
    pub fn rebuild<const D: usize>(&mut self, pair: &[[u32; 2]], jacobian: &[[[f64; D]; 2]], live: &[bool]) {
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

    /// All blocks.
    pub(crate) fn whole(&mut self) -> Part<'_> {
        Part {
            singles: &mut self.singles,
            doubles: &mut self.doubles,
            triples: &mut self.triples,
            fours: &mut self.fours,
            fives: &mut self.fives,
            sixes: &mut self.sixes,
            sevens: &mut self.sevens,
            eights: &mut self.eights,
            larger: self.larger.whole(),
            live: &self.live,
        }
    }

    /// [`Part::proximal`] of all blocks.
    pub fn proximal(&mut self, x: &[f64], step: f64, g: &[f64], out: &mut [f64]) {
        self.whole().proximal(x, step, g, out);
    }

    /// [`Part::project`] of all blocks.
    pub fn project(&mut self, x: &[f64], out: &mut [f64]) {
        self.whole().project(x, out);
    }
}

impl<'a> Part<'a> {
    /// `out = argmin over y >= 0 of step g . (y - x) + 1/2 (y - x) . B (y - x)`. Zero rows of `A` keep `x`, which is
    /// not negative there.
    pub fn proximal(&mut self, x: &[f64], step: f64, g: &[f64], out: &mut [f64]) {
        self.minimize(x, Some((step, g)), out);
    }

    /// `out = argmin over y >= 0 of (y - x) . B (y - x)`.
    pub fn project(&mut self, x: &[f64], out: &mut [f64]) {
        self.minimize(x, None, out);
    }

    fn minimize(&mut self, x: &[f64], slope: Option<(f64, &[f64])>, out: &mut [f64]) {
        let mut rest = Rest { step: Step { x, slope, live: self.live }, out };
        rest.each(self.singles);
        rest.each(self.doubles);
        rest.each(self.triples);
        rest.each(self.fours);
        rest.each(self.fives);
        rest.each(self.sixes);
        rest.each(self.sevens);
        rest.each(self.eights);
        self.larger.minimize(rest.step, rest.out);
    }

    /// Parts the blocks of the first so many rows from the others. No block may have rows on both sides.
    pub fn split_at(self, rows: usize) -> (Self, Self) {
        let mut left = rows;
        let (singles, more_singles) = split(self.singles, &mut left);
        let (doubles, more_doubles) = split(self.doubles, &mut left);
        let (triples, more_triples) = split(self.triples, &mut left);
        let (fours, more_fours) = split(self.fours, &mut left);
        let (fives, more_fives) = split(self.fives, &mut left);
        let (sixes, more_sixes) = split(self.sixes, &mut left);
        let (sevens, more_sevens) = split(self.sevens, &mut left);
        let (eights, more_eights) = split(self.eights, &mut left);
        let (larger, more_larger) = self.larger.split_at(left);
        let (live, more_live) = self.live.split_at(rows);
        (
            Part { singles, doubles, triples, fours, fives, sixes, sevens, eights, larger, live },
            Part {
                singles: more_singles,
                doubles: more_doubles,
                triples: more_triples,
                fours: more_fours,
                fives: more_fives,
                sixes: more_sixes,
                sevens: more_sevens,
                eights: more_eights,
                larger: more_larger,
                live: more_live,
            },
        )
    }
}

/// The blocks that the next `left` rows have among these, and the others; `left` becomes what is left of them.
fn split<'a, const M: usize, B: Block<M>>(blocks: &'a mut [B], left: &mut usize) -> (&'a mut [B], &'a mut [B]) {
    let first = blocks.len().min(*left / M);
    *left -= M * first;
    blocks.split_at_mut(first)
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

/// The rows that are not yet done.
struct Rest<'a> {
    step: Step<'a>,
    out: &'a mut [f64],
}

impl Rest<'_> {
    /// Solves blocks of `M` rows, which come next.
    fn each<const M: usize, B: Block<M>>(&mut self, blocks: &mut [B]) {
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
                // Blocks without a negative number, nearly all of them, are their own projection.
                let negative = x.iter().fold(false, |negative, x| negative | (*x < 0.0));
                *out = if negative { block.project(*x) } else { *x };
            }
        }
    }
}

/// A pair with its smaller body first.
pub(crate) fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// `A_ij` of two rows of the same pair, named in either order.
fn entry<const D: usize>(pair: &[[u32; 2]], jacobian: &[[[f64; D]; 2]], i: usize, j: usize) -> f64 {
    let ([ia, ib], [ja, jb]) = (&jacobian[i], &jacobian[j]);
    if pair[i] == pair[j] { dot(ia, ja) + dot(ib, jb) } else { dot(ia, jb) + dot(ib, ja) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// The conditions of the small problems, checked on pairs of 1 to 24 rows in mixed order, some rows repeated, one
    /// zero.
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
        order(&pair, &mut places);
        let pair: Vec<[u32; 2]> = places.iter().map(|row| pair[*row as usize]).collect();
        let mut jacobian: Vec<[[f64; 3]; 2]> = places.iter().map(|row| jacobian[*row as usize]).collect();
        for i in (1..pair.len()).step_by(4).filter(|i| pair[*i] == pair[i - 1]) {
            jacobian[i] = jacobian[i - 1];
        }
        let live: Vec<bool> = jacobian.iter().map(|blocks| *blocks != [[0.0; 3]; 2]).collect();
        assert!(live.contains(&false));
        let mut blocks = PairBlocks::default();
        blocks.rebuild(&pair, &jacobian, &live);

        let x: Vec<f64> = pair.iter().map(|_| uniform().max(0.0)).collect();
        let g: Vec<f64> = pair.iter().map(|_| uniform()).collect();
        let mut y = vec![0.0; x.len()];
        blocks.proximal(&x, 0.7, &g, &mut y);
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
        // In parts, at every edge between two pairs.
        for edge in (0..=x.len()).filter(|i| *i == 0 || *i == x.len() || sorted(pair[*i - 1]) != sorted(pair[*i])) {
            let mut parted = PairBlocks::default();
            parted.rebuild(&pair, &jacobian, &live);
            let mut same = vec![0.0; x.len()];
            let (mut first, mut second) = parted.whole().split_at(edge);
            let (low, high) = same.split_at_mut(edge);
            first.proximal(&x[..edge], 0.7, &g[..edge], low);
            second.proximal(&x[edge..], 0.7, &g[edge..], high);
            assert_eq!(same, y, "{edge}");
        }
        blocks.project(&x, &mut y);
        assert_eq!(y, x);
    }
}
