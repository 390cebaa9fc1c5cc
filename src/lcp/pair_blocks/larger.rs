//! The small problems of pairs with many rows, solved by the active set method alone.

use super::{REGULARIZATION, Step};
use crate::lcp::cone;

/// The blocks; `rows` and `offsets` have the offsets of the rows and the matrix of each.
#[derive(Clone, Debug, Default)]
pub(super) struct Larger {
    /// The first row of each block, from zero, and the end if there is a block.
    rows: Vec<u32>,
    /// The offset of each matrix, and the end if there is a block.
    offsets: Vec<usize>,
    /// The matrices, by rows. Zero rows of `A` have an entry 1 on the diagonal.
    matrices: Vec<f64>,
}

/// Scratch space of a small problem.
#[derive(Default)]
pub(super) struct Scratch {
    pub slope: Vec<f64>,
    pub change: Vec<f64>,
    target: Vec<f64>,
    free: Vec<bool>,
    index: Vec<usize>,
    factor: Vec<f64>,
}

impl Larger {
    pub fn clear(&mut self) {
        self.rows.clear();
        self.offsets.clear();
        self.matrices.clear();
    }

    /// Adds a block of `m` rows.
    pub fn push(&mut self, m: usize, entry: impl Fn(usize, usize) -> f64) {
        if self.rows.is_empty() {
            self.rows.push(0);
            self.offsets.push(0);
        }
        self.rows.push(self.rows[self.rows.len() - 1] + m as u32);
        self.matrices.extend((0..m).flat_map(|i| (0..m).map(move |j| (i, j))).map(|(i, j)| entry(i, j)));
        self.offsets.push(self.matrices.len());
    }

    /// Solves all blocks.
    pub fn minimize(&self, step: Step, out: &mut [f64]) {
        let scratch = &mut Scratch::default();
        for block in 0..self.rows.len().saturating_sub(1) {
            let rows = self.rows[block] as usize..self.rows[block + 1] as usize;
            let (x, live) = (&step.x[rows.clone()], &step.live[rows.clone()]);
            let out = &mut out[rows.clone()];
            scratch.slope.clear();
            match step.slope {
                Some((length, g)) => {
                    scratch.slope.extend(g[rows].iter().zip(live).map(|(g, live)| length * g * live));
                }
                None if x.iter().all(|x| cone::contains(*x)) => {
                    out.copy_from_slice(x);
                    continue;
                }
                None => scratch.slope.resize(x.len(), 0.0),
            }
            active_set(&self.matrices[self.offsets[block]..self.offsets[block + 1]], x, scratch);
            let y = x.iter().zip(&scratch.change).map(|(x, change)| cone::project(x + change));
            out.iter_mut().zip(y).for_each(|(out, y)| *out = y);
        }
    }
}

/// `change = y - x` for `y = argmin over y >= 0 of slope . (y - x) + 1/2 (y - x) . B (y - x)`, by the active set method
/// of Lawson and Hanson (Solving least squares problems, 1974, chapter 23) started at the projection of `x`. The
/// objective never rises; the limit on rounds matters only with rounding errors.
pub(super) fn active_set(b: &[f64], x: &[f64], scratch: &mut Scratch) {
    let Scratch { slope, change, target, free, index, factor } = scratch;
    let m = x.len();
    change.clear();
    change.extend(x.iter().map(|x| cone::lack(*x)));
    free.clear();
    free.extend(x.iter().map(|x| cone::is_free(*x)));
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
        let bound = index.iter().zip(&*target).filter(|(i, t)| cone::is_bound(x[**i] + **t));
        let part = |i: usize, t: f64| {
            let y = x[i] + change[i];
            if cone::is_free(y) { cone::room(y, t - change[i]) } else { 0.0 }
        };
        let bound = bound.map(|(i, t)| (part(*i, *t), *i));
        if let Some((part, first)) = bound.reduce(|best, next| if next.0 < best.0 { next } else { best }) {
            for (i, t) in index.iter().zip(&*target) {
                change[*i] += part * (t - change[*i]);
                free[*i] = cone::is_free(x[*i] + change[*i]);
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
