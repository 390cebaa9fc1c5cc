//! The diagonal blocks of `A` that belong to one pair of bodies, as a metric: small exact projected steps.
//!
//! All rows of a pair act between the same two bodies, so they span at most `D` directions of relative motion, and rows of nearly
//! the same contact are nearly parallel. Solving a block exactly takes that ill-conditioning out of the way of an iteration; what is
//! left couples different pairs. Blocks get a relative regularization, which makes a block of parallel rows positive definite.

use super::product::{dot, fill};
use rayon::prelude::*;
use std::ops::Range;

/// Relative addition to the diagonal of a block. On the stored systems 1e-6, 1e-7 and 1e-8 cost the same products within a quarter, the
/// largest of them the least where a pair has many rows; it keeps most digits of the Cholesky factor of a block with repeated rows.
const REGULARIZATION: f64 = 1e-6;

/// How many blocks one parallel task takes.
const TASK: usize = 2_048;

/// The blocks of rows that stand in the order of [`order`].
#[derive(Clone, Debug, Default)]
pub struct PairBlocks {
    /// Pairs with one row: `1 / B`, zero for zero rows of `A`.
    singles: Vec<f64>,
    /// Pairs with two rows.
    doubles: Vec<Double>,
    /// Where the rows of each larger block begin; one more at the end.
    rows: Vec<u32>,
    /// Where the matrix of each larger block begins; one more at the end.
    offsets: Vec<usize>,
    /// The matrices of the larger blocks, by rows. Zero rows of `A` have an entry 1 on the diagonal.
    matrices: Vec<f64>,
    /// 1 for rows of `A` that are not zero, else 0.
    live: Vec<f64>,
    parallel: bool,
}

/// A symmetric matrix of two rows, and what its solutions need.
#[derive(Clone, Copy, Debug)]
struct Double {
    /// `B_00`, `B_01`, `B_11`.
    matrix: [f64; 3],
    /// `1 / B_00`, `1 / B_11`.
    inverse: [f64; 2],
    inverse_determinant: f64,
}

/// What a small problem needs beside its data.
#[derive(Default)]
struct Scratch {
    slope: Vec<f64>,
    change: Vec<f64>,
    target: Vec<f64>,
    free: Vec<bool>,
    index: Vec<usize>,
    factor: Vec<f64>,
}

/// Orders rows so that those of a pair stand together: pairs with one row first, then those with two, then the others, each by
/// pair; the rows of a pair in their own order.
pub fn order(pair: &[[u32; 2]], order: &mut Vec<u32>) {
    order.clear();
    order.extend(0..pair.len() as u32);
    order.sort_by_key(|row| sorted(pair[*row as usize]));
    let mut class = vec![0_u8; pair.len()];
    for block in order.chunk_by(|i, j| sorted(pair[*i as usize]) == sorted(pair[*j as usize])) {
        for row in block {
            class[*row as usize] = block.len().min(3) as u8;
        }
    }
    order.sort_by_key(|row| class[*row as usize]);
}

impl PairBlocks {
    /// Makes the blocks of rows that stand in the order of [`order`]; `live` says which rows of `A` are not zero.
    pub fn rebuild<const D: usize>(
        &mut self,
        pair: &[[u32; 2]],
        jacobian: &[[[f64; D]; 2]],
        live: &[bool],
        parallel: bool,
    ) {
        self.parallel = parallel;
        self.live.clear();
        self.live.extend(live.iter().map(|live| f64::from(u8::from(*live))));
        self.singles.clear();
        self.doubles.clear();
        self.rows.clear();
        self.offsets.clear();
        self.matrices.clear();
        let matrix = |i: usize, j: usize| match (i == j, live[i]) {
            (true, true) => entry(pair, jacobian, i, j) * (1.0 + REGULARIZATION),
            (true, false) => 1.0,
            (false, _) => entry(pair, jacobian, i, j),
        };
        let mut first = 0;
        for block in pair.chunk_by(|p, q| sorted(*p) == sorted(*q)) {
            let last = first + block.len();
            match block.len() {
                1 => self.singles.push(self.live[first] / matrix(first, first)),
                2 => self.doubles.push(Double::new(
                    matrix(first, first),
                    matrix(first, last - 1),
                    matrix(last - 1, last - 1),
                )),
                _ => {
                    self.rows.push(first as u32);
                    self.offsets.push(self.matrices.len());
                    let entries = (first..last).flat_map(|i| (first..last).map(move |j| (i, j)));
                    self.matrices.extend(entries.map(|(i, j)| matrix(i, j)));
                }
            }
            first = last;
        }
        self.rows.push(first as u32);
        self.offsets.push(self.matrices.len());
    }

    /// `out = argmin over y >= 0 of step g . (y - x) + 1/2 (y - x) . B (y - x)`. Zero rows of `A` keep `x`.
    pub fn proximal(&self, x: &[f64], step: f64, g: &[f64], out: &mut [f64]) {
        self.minimize(x, |i| step * g[i], out);
    }

    /// `out = argmin over y >= 0 of (y - x) . B (y - x)`.
    pub fn project(&self, x: &[f64], out: &mut [f64]) {
        self.minimize(x, |_| 0.0, out);
    }

    fn minimize(&self, x: &[f64], slope: impl Fn(usize) -> f64 + Sync, out: &mut [f64]) {
        let (singles, rest) = out.split_at_mut(self.singles.len());
        let (doubles, larger) = rest.split_at_mut(2 * self.doubles.len());
        fill(self.parallel, singles, |i| (x[i] - slope(i) * self.singles[i]).max(0.0));

        let first = self.singles.len();
        let double = |(k, out): (usize, &mut [f64])| {
            let (double, i) = (&self.doubles[k], first + 2 * k);
            let slopes = [slope(i) * self.live[i], slope(i + 1) * self.live[i + 1]];
            out.copy_from_slice(&double.minimize([x[i], x[i + 1]], slopes));
        };
        if self.parallel {
            doubles.par_chunks_mut(2).with_min_len(TASK).enumerate().for_each(double);
        } else {
            doubles.chunks_mut(2).enumerate().for_each(double);
        }

        let blocks = self.rows.len().saturating_sub(1);
        let size = if self.parallel { TASK } else { blocks.max(1) };
        let mut tasks = Vec::with_capacity(blocks / size + 1);
        let mut rest = larger;
        for first in (0..blocks).step_by(size) {
            let range = first..(first + size).min(blocks);
            let (rows, after) = rest.split_at_mut((self.rows[range.end] - self.rows[first]) as usize);
            tasks.push((range, rows));
            rest = after;
        }
        let task = |scratch: &mut Scratch, (range, out)| self.minimize_larger(range, x, &slope, out, scratch);
        if self.parallel {
            tasks.into_par_iter().for_each_init(Scratch::default, task);
        } else {
            tasks.into_iter().for_each(|part| task(&mut Scratch::default(), part));
        }
    }

    fn minimize_larger(
        &self,
        blocks: Range<usize>,
        x: &[f64],
        slope: &impl Fn(usize) -> f64,
        out: &mut [f64],
        scratch: &mut Scratch,
    ) {
        let base = self.rows[blocks.start] as usize;
        for block in blocks {
            let rows = self.rows[block] as usize..self.rows[block + 1] as usize;
            let matrix = &self.matrices[self.offsets[block]..self.offsets[block + 1]];
            let x = &x[rows.clone()];
            scratch.slope.clear();
            scratch.slope.extend(rows.clone().map(|row| slope(row) * self.live[row]));
            active_set(matrix, x, scratch);
            let y = x.iter().zip(&scratch.change).map(|(x, change)| (x + change).max(0.0));
            out[rows.start - base..rows.end - base].iter_mut().zip(y).for_each(|(out, y)| *out = y);
        }
    }
}

impl Double {
    fn new(a: f64, b: f64, c: f64) -> Self {
        Double { matrix: [a, b, c], inverse: [1.0 / a, 1.0 / c], inverse_determinant: 1.0 / (a * c - b * b) }
    }

    /// `argmin over y >= 0 of slope . (y - x) + 1/2 (y - x) . B (y - x)`, by its four cases. Solved for `y - x`: the rounding of
    /// large multipliers would otherwise be amplified by the near singularity of `B`.
    #[inline]
    fn minimize(&self, x: [f64; 2], slope: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.matrix;
        let both = [
            x[0] + (b * slope[1] - c * slope[0]) * self.inverse_determinant,
            x[1] + (b * slope[0] - a * slope[1]) * self.inverse_determinant,
        ];
        let first = (x[0] + (b * x[1] - slope[0]) * self.inverse[0]).max(0.0);
        let second = (x[1] + (b * x[0] - slope[1]) * self.inverse[1]).max(0.0);
        let rising = slope[0] - a * x[0] + b * (second - x[1]) >= 0.0;
        let one = if rising { [0.0, second] } else { [first, 0.0] };
        if both[0] >= 0.0 && both[1] >= 0.0 { both } else { one }
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

/// `change = y - x` for `y = argmin over y >= 0 of slope . (y - x) + 1/2 (y - x) . B (y - x)`, by the active set method of Lawson and Hanson
/// (Solving least squares problems, 1974, chapter 23) started at `max(x, 0)`. The objective never rises; the bound on rounds only
/// matters to rounding.
fn active_set(b: &[f64], x: &[f64], scratch: &mut Scratch) {
    let Scratch { slope, change, target, free, index, factor } = scratch;
    let m = x.len();
    change.clear();
    change.extend(x.iter().map(|x| (-x).max(0.0)));
    free.clear();
    free.extend(x.iter().map(|x| *x > 0.0));
    for _ in 0..4 * m + 4 {
        index.clear();
        index.extend((0..m).filter(|i| free[*i]));
        for i in (0..m).filter(|i| !free[*i]) {
            change[i] = -x[i];
        }
        let held = |i: usize| (0..m).filter(|j| !free[*j]).map(|j| b[i * m + j] * change[j]).sum::<f64>();
        target.clear();
        target.extend(index.iter().map(|i| -slope[*i] - held(*i)));
        solve_free(b, m, index, factor, target);
        let bound = index.iter().zip(&*target).filter(|(i, t)| x[**i] + **t <= 0.0);
        let part = |i: usize, t: f64| if x[i] + change[i] > 0.0 { (x[i] + change[i]) / (change[i] - t) } else { 0.0 };
        let bound = bound.map(|(i, t)| (part(*i, *t), *i));
        if let Some((part, first)) = bound.reduce(|best, next| if next.0 < best.0 { next } else { best }) {
            for (i, t) in index.iter().zip(&*target) {
                change[*i] += part * (t - change[*i]);
                free[*i] = x[*i] + change[*i] > 0.0;
            }
            free[first] = false;
            continue;
        }
        for (i, t) in index.iter().zip(&*target) {
            change[*i] = *t;
        }
        let rise = |i: usize| slope[i] + (0..m).map(|j| b[i * m + j] * change[j]).sum::<f64>();
        let steepest = (0..m)
            .filter(|i| !free[*i])
            .map(|i| (rise(i) / b[i * m + i].sqrt(), i))
            .fold((0.0, m), |best, next| if next.0 < best.0 { next } else { best });
        if steepest.1 == m {
            return;
        }
        free[steepest.1] = true;
    }
}

/// Solves `B_FF t = target` for the free rows `F = index` in place, by Cholesky.
fn solve_free(b: &[f64], m: usize, index: &[usize], factor: &mut Vec<f64>, target: &mut [f64]) {
    let n = index.len();
    factor.clear();
    factor.resize(n * n, 0.0);
    for i in 0..n {
        for j in 0..=i {
            let mut sum = b[index[i] * m + index[j]];
            for k in 0..j {
                sum -= factor[i * n + k] * factor[j * n + k];
            }
            // The regularization keeps pivots above a millionth of the diagonal, up to rounding.
            factor[i * n + j] = if i == j {
                sum.max(0.1 * REGULARIZATION * b[index[i] * m + index[i]]).sqrt()
            } else {
                sum / factor[j * n + j]
            };
        }
    }
    for i in 0..n {
        for k in 0..i {
            target[i] -= factor[i * n + k] * target[k];
        }
        target[i] /= factor[i * n + i];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            target[i] -= factor[k * n + i] * target[k];
        }
        target[i] /= factor[i * n + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// The conditions of the small problems, checked on pairs of 1 to 24 rows in mixed order, some rows repeated, one zero.
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
        blocks.rebuild(&pair, &jacobian, &live, false);

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
        let mut parallel = PairBlocks::default();
        parallel.rebuild(&pair, &jacobian, &live, true);
        let mut same = vec![0.0; x.len()];
        parallel.proximal(&x, 0.7, &g, &mut same);
        assert_eq!(same, y);
        blocks.project(&x, &mut y);
        assert_eq!(y, x);
    }
}
