//! The diagonal blocks of `A` that belong to one pair of bodies, as a metric: small exact projected steps.
//!
//! All rows of a pair act between the same two bodies, so they span at most `D` directions of relative motion, and rows of nearly
//! the same contact are nearly parallel. Solving a block exactly takes that ill-conditioning out of the way of an iteration; what is
//! left couples different pairs. Blocks get a relative regularization, which makes a block of parallel rows positive definite.

use super::product::dot;
use rayon::prelude::*;
use std::ops::Range;

/// Relative addition to the diagonal of a block. The rows of a colony of 1,024 rods are nearly as well solved with 1e-4 to 1e-8; far
/// below that the Cholesky factor of a block of repeated rows loses its digits, and far above parallel rows converge apart.
const REGULARIZATION: f64 = 1e-6;

/// How many blocks one parallel task takes.
const TASK: usize = 2_048;

/// The blocks of rows that stand sorted by pair.
#[derive(Clone, Debug, Default)]
pub struct PairBlocks {
    /// Where each block's rows begin; one more at the end.
    rows: Vec<u32>,
    /// Where each block's matrix begins; one more at the end.
    offsets: Vec<usize>,
    /// The regularized matrices, by rows. Zero rows of `A` have an entry 1 on the diagonal.
    matrices: Vec<f64>,
    /// Rows of `A` that are not zero.
    live: Vec<bool>,
    parallel: bool,
}

/// What a small problem needs beside its data.
#[derive(Default)]
struct Scratch {
    linear: Vec<f64>,
    solution: Vec<f64>,
    target: Vec<f64>,
    free: Vec<bool>,
    index: Vec<usize>,
    factor: Vec<f64>,
}

impl PairBlocks {
    /// Makes the blocks of rows that stand sorted by pair; `live` says which rows of `A` are not zero.
    pub fn rebuild<const D: usize>(
        &mut self,
        pair: &[[u32; 2]],
        jacobian: &[[[f64; D]; 2]],
        live: &[bool],
        parallel: bool,
    ) {
        self.parallel = parallel;
        self.live.clear();
        self.live.extend_from_slice(live);
        self.rows.clear();
        self.offsets.clear();
        self.matrices.clear();
        let mut first = 0;
        for block in pair.chunk_by(|p, q| sorted(*p) == sorted(*q)) {
            let last = first + block.len();
            self.rows.push(first as u32);
            self.offsets.push(self.matrices.len());
            for (i, live) in (first..last).zip(&live[first..last]) {
                for j in first..last {
                    let entry = entry(pair, jacobian, i, j);
                    self.matrices.push(match (i == j, *live) {
                        (true, true) => entry * (1.0 + REGULARIZATION),
                        (true, false) => 1.0,
                        (false, _) => entry,
                    });
                }
            }
            first = last;
        }
        self.rows.push(first as u32);
        self.offsets.push(self.matrices.len());
    }

    /// `out = argmin over y >= 0 of step g . (y - x) + 1/2 (y - x) . B (y - x)`; without `g` the projection of `x`.
    pub fn proximal(&self, x: &[f64], step: f64, g: Option<&[f64]>, out: &mut [f64]) {
        let blocks = self.rows.len().saturating_sub(1);
        if !self.parallel {
            return self.proximal_of(0..blocks, x, step, g, out, &mut Scratch::default());
        }
        let mut tasks = Vec::with_capacity(blocks / TASK + 1);
        let mut rest = out;
        for first in (0..blocks).step_by(TASK) {
            let range = first..(first + TASK).min(blocks);
            let (rows, after) = rest.split_at_mut((self.rows[range.end] - self.rows[first]) as usize);
            tasks.push((range, rows));
            rest = after;
        }
        tasks.into_par_iter().for_each_init(Scratch::default, |scratch, (range, out)| {
            self.proximal_of(range, x, step, g, out, scratch);
        });
    }

    fn proximal_of(
        &self,
        blocks: Range<usize>,
        x: &[f64],
        step: f64,
        g: Option<&[f64]>,
        out: &mut [f64],
        scratch: &mut Scratch,
    ) {
        let base = self.rows[blocks.start] as usize;
        for block in blocks {
            let rows = self.rows[block] as usize..self.rows[block + 1] as usize;
            let matrix = &self.matrices[self.offsets[block]..self.offsets[block + 1]];
            let out = &mut out[rows.start - base..rows.end - base];
            let slope = |i: usize| if self.live[i] { g.map_or(0.0, |g| step * g[i]) } else { 0.0 };
            if rows.len() == 1 {
                out[0] = (x[rows.start] - slope(rows.start) / matrix[0]).max(0.0);
                continue;
            }
            let (m, first, x) = (rows.len(), rows.start, &x[rows]);
            let linear = |i: usize| {
                let row = &matrix[i * m..(i + 1) * m];
                slope(first + i) - row.iter().zip(x).map(|(b, x)| b * x).sum::<f64>()
            };
            if m == 2 {
                two(matrix, [linear(0), linear(1)], out);
                continue;
            }
            scratch.linear.clear();
            scratch.linear.extend((0..m).map(linear));
            scratch.solution.clear();
            scratch.solution.extend(x.iter().map(|x| x.max(0.0)));
            active_set(matrix, scratch);
            out.copy_from_slice(&scratch.solution);
        }
    }

    /// `x . B x`.
    pub fn square(&self, x: &[f64]) -> f64 {
        let mut sum = 0.0;
        for block in 0..self.rows.len().saturating_sub(1) {
            let x = &x[self.rows[block] as usize..self.rows[block + 1] as usize];
            let matrix = &self.matrices[self.offsets[block]..];
            for (i, xi) in x.iter().enumerate() {
                let row: f64 = x.iter().zip(&matrix[i * x.len()..]).map(|(x, b)| x * b).sum();
                sum += xi * row;
            }
        }
        sum
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

/// `argmin over y >= 0 of c . y + 1/2 y . B y` for two rows, by its four cases.
fn two(b: &[f64], c: [f64; 2], y: &mut [f64]) {
    let det = b[0] * b[3] - b[1] * b[2];
    let both = [(b[1] * c[1] - b[3] * c[0]) / det, (b[2] * c[0] - b[0] * c[1]) / det];
    if both[0] >= 0.0 && both[1] >= 0.0 {
        y.copy_from_slice(&both);
        return;
    }
    let second = (-c[1] / b[3]).max(0.0);
    if c[0] + b[1] * second >= 0.0 {
        (y[0], y[1]) = (0.0, second);
    } else {
        (y[0], y[1]) = ((-c[0] / b[0]).max(0.0), 0.0);
    }
}

/// `argmin over y >= 0 of c . y + 1/2 y . B y` by the active set method of Lawson and Hanson (Solving least squares problems, 1974,
/// chapter 23), started at `scratch.solution >= 0`. The objective never rises; the bound on rounds only matters to rounding.
fn active_set(b: &[f64], scratch: &mut Scratch) {
    let Scratch { linear: c, solution: y, target, free, index, factor } = scratch;
    let m = c.len();
    free.clear();
    free.extend(y.iter().map(|y| *y > 0.0));
    for _ in 0..4 * m + 4 {
        index.clear();
        index.extend((0..m).filter(|i| free[*i]));
        solve_free(b, m, c, index, factor, target);
        let bound = index.iter().zip(&*target).filter(|(_, z)| **z <= 0.0);
        let bound = bound.map(|(i, z)| (if y[*i] > 0.0 { y[*i] / (y[*i] - z) } else { 0.0 }, *i));
        if let Some((part, first)) = bound.reduce(|best, next| if next.0 < best.0 { next } else { best }) {
            for (i, z) in index.iter().zip(&*target) {
                y[*i] = (y[*i] + part * (z - y[*i])).max(0.0);
                free[*i] = y[*i] > 0.0;
            }
            (y[first], free[first]) = (0.0, false);
            continue;
        }
        for (i, z) in index.iter().zip(&*target) {
            y[*i] = *z;
        }
        let slope = |i: usize| c[i] + (0..m).map(|j| b[i * m + j] * y[j]).sum::<f64>();
        let steepest = (0..m)
            .filter(|i| !free[*i])
            .map(|i| (slope(i) / b[i * m + i].sqrt(), i))
            .fold((0.0, m), |best, next| if next.0 < best.0 { next } else { best });
        if steepest.1 == m {
            return;
        }
        free[steepest.1] = true;
    }
}

/// The free rows' minimizer with the others at zero, by Cholesky: `target = -B_FF^-1 c_F`.
fn solve_free(b: &[f64], m: usize, c: &[f64], index: &[usize], factor: &mut Vec<f64>, target: &mut Vec<f64>) {
    let n = index.len();
    factor.clear();
    factor.resize(n * n, 0.0);
    target.clear();
    target.extend(index.iter().map(|i| -c[*i]));
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
