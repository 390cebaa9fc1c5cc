//! The product `A x = J (J^T x)`: `v = J^T x` body by body, then the rows of `J v`.
//!
//! Large problems gather `v` through lists of each body's rows, in parallel; small ones scatter row by row. Either way
//! a body's terms are added in ascending order of the rows, so both give the same bits, for any number of threads.

use super::incidence::Incidence;
use rayon::prelude::*;

/// From this many rows on loops are parallel. `benches/lcp.rs`: a sequential product takes some 300 microseconds there,
/// against 10 to 20 for each of its two forks. Where both cores were busy with other programs, two threads lost up to a
/// third up to 100,000 rows and drew level at 400,000.
pub(crate) const PARALLEL_ROWS: usize = 32_768;

/// How many rows or bodies one task takes: some 30 microseconds of work.
const TASK: usize = 4_096;

/// Interleaved parts of a sum: independent, so that the compiler can make vectors of them.
const PARTS: usize = 8;

/// So many numbers of each of six vectors fit the nearest cache together, 24 KiB.
const CACHED: usize = 512;

/// The rows of `J`, kept ready for products.
#[derive(Clone, Debug, Default)]
pub struct Product<const D: usize> {
    pair: Vec<[u32; 2]>,
    jacobian: Vec<[[f64; D]; 2]>,
    incidence: Incidence,
    /// The blocks of `J` in the order of the incidence lists. Filled for parallel products only.
    gathered: Vec<[f64; D]>,
    velocity: Vec<[f64; D]>,
    parallel: bool,
}

impl<const D: usize> Product<D> {
    /// Takes the rows of a problem in the given order of rows.
    pub fn rebuild(&mut self, bodies: usize, pair: &[[u32; 2]], jacobian: &[[[f64; D]; 2]], order: &[u32]) {
        self.pair.clear();
        self.pair.extend(order.iter().map(|row| pair[*row as usize]));
        self.jacobian.clear();
        self.jacobian.extend(order.iter().map(|row| jacobian[*row as usize]));
        self.velocity.clear();
        self.velocity.resize(bodies, [0.0; D]);
        self.incidence.rebuild(bodies, &self.pair);
        self.parallel = order.len() >= PARALLEL_ROWS && rayon::current_num_threads() > 1;
        self.gathered.clear();
        if self.parallel {
            let blocks = self.jacobian.as_flattened();
            self.gathered.extend(self.incidence.entries.iter().map(|entry| blocks[*entry as usize]));
        }
    }

    /// The bodies of each row.
    pub fn pair(&self) -> &[[u32; 2]] {
        &self.pair
    }

    /// Which rows a body takes part in.
    pub fn incidence(&self) -> &Incidence {
        &self.incidence
    }

    /// The two blocks of each row.
    pub fn jacobian(&self) -> &[[[f64; D]; 2]] {
        &self.jacobian
    }

    /// `out = offset + A x`, or `A x` without an offset.
    pub fn apply(&mut self, x: &[f64], offset: Option<&[f64]>, out: &mut [f64]) {
        if self.parallel {
            self.gather(x);
        } else {
            scatter(&self.pair, &self.jacobian, x, &mut self.velocity);
        }
        let (pair, jacobian, velocity) = (&self.pair, &self.jacobian, &self.velocity);
        let task = |first: usize, out: &mut [f64]| {
            let range = first..first + out.len();
            for (out, ([a, b], blocks)) in out.iter_mut().zip(pair[range.clone()].iter().zip(&jacobian[range.clone()]))
            {
                *out = row(blocks, &velocity[*a as usize], &velocity[*b as usize]);
            }
            if let Some(q) = offset {
                out.iter_mut().zip(&q[range]).for_each(|(out, q)| *out += q);
            }
        };
        if self.parallel {
            out.par_chunks_mut(TASK).enumerate().for_each(|(k, out)| task(k * TASK, out));
        } else {
            task(0, out);
        }
    }

    fn gather(&mut self, x: &[f64]) {
        let (incidence, gathered) = (&self.incidence, &self.gathered);
        fill(self.parallel, &mut self.velocity, |body| {
            let range = incidence.start[body] as usize..incidence.start[body + 1] as usize;
            let mut sum = [0.0; D];
            for (entry, block) in incidence.entries[range.clone()].iter().zip(&gathered[range]) {
                add(&mut sum, x[(*entry / 2) as usize], block);
            }
            sum
        });
    }

    /// The diagonal of `A`.
    pub fn diagonal(&self) -> Vec<f64> {
        self.jacobian.iter().map(|[ja, jb]| dot(ja, ja) + dot(jb, jb)).collect()
    }

    /// A diagonal `W` with `x . A x <= x . W x`: `w_i = sum over the row's bodies b of c_b |J_ib|^2` with `c_b` the
    /// number of rows of body `b`, since by Cauchy and Schwarz `|sum_i J_ib x_i|^2 <= c_b sum_i |J_ib|^2 x_i^2`.
    pub fn majorant(&self) -> Vec<f64> {
        let count = |body: u32| self.incidence.of(body as usize).len() as f64;
        let row = |([a, b], [ja, jb]): (&[u32; 2], &[[f64; D]; 2])| count(*a) * dot(ja, ja) + count(*b) * dot(jb, jb);
        self.pair.iter().zip(&self.jacobian).map(row).collect()
    }
}

/// `out = J^T x`, one block a body, row by row.
pub(crate) fn scatter<const D: usize>(pair: &[[u32; 2]], jacobian: &[[[f64; D]; 2]], x: &[f64], out: &mut [[f64; D]]) {
    out.fill([0.0; D]);
    for (([a, b], [ja, jb]), x) in pair.iter().zip(jacobian).zip(x) {
        add(&mut out[*a as usize], *x, ja);
        add(&mut out[*b as usize], *x, jb);
    }
}

#[inline]
pub(crate) fn dot<const D: usize>(x: &[f64; D], y: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for k in 0..D {
        sum += x[k] * y[k];
    }
    sum
}

/// A row of `J v`, from its blocks and the velocities of its bodies, in two interleaved sums of which the compiler
/// makes one vector.
#[inline]
fn row<const D: usize>([ja, jb]: &[[f64; D]; 2], va: &[f64; D], vb: &[f64; D]) -> f64 {
    let mut sum = [0.0; 2];
    for k in (0..D / 2 * 2).step_by(2) {
        for (lane, sum) in sum.iter_mut().enumerate() {
            *sum += ja[k + lane] * va[k + lane] + jb[k + lane] * vb[k + lane];
        }
    }
    if D % 2 == 1 {
        sum[0] += ja[D - 1] * va[D - 1];
        sum[1] += jb[D - 1] * vb[D - 1];
    }
    sum[0] + sum[1]
}

/// `y += a x`.
#[inline]
pub(crate) fn add<const D: usize>(y: &mut [f64; D], a: f64, x: &[f64; D]) {
    for k in 0..D {
        y[k] += a * x[k];
    }
}

/// `out[i] = value(i)`.
pub(crate) fn fill<T: Send>(parallel: bool, out: &mut [T], value: impl Fn(usize) -> T + Sync) {
    if parallel {
        out.par_chunks_mut(TASK).enumerate().for_each(|(task, out)| {
            for (k, out) in out.iter_mut().enumerate() {
                *out = value(task * TASK + k);
            }
        });
    } else {
        for (i, out) in out.iter_mut().enumerate() {
            *out = value(i);
        }
    }
}

/// `out[i] = value(inputs[..][i])`, by slices of equal length, so that the loop has no checks and the compiler can make
/// vectors of it.
pub(crate) fn map<const N: usize>(
    parallel: bool,
    out: &mut [f64],
    inputs: [&[f64]; N],
    value: impl Fn([f64; N]) -> f64 + Sync,
) {
    update(parallel, out, inputs, |_, numbers| value(numbers));
}

/// `out[i] = value(out[i], inputs[..][i])`.
pub(crate) fn update<const N: usize>(
    parallel: bool,
    out: &mut [f64],
    inputs: [&[f64]; N],
    value: impl Fn(f64, [f64; N]) -> f64 + Sync,
) {
    let task = |first: usize, out: &mut [f64]| {
        let inputs = inputs.map(|input| &input[first..][..out.len()]);
        for (i, out) in out.iter_mut().enumerate() {
            *out = value(*out, std::array::from_fn(|k| inputs[k][i]));
        }
    };
    if parallel {
        out.par_chunks_mut(TASK).enumerate().for_each(|(k, out)| task(k * TASK, out));
    } else {
        task(0, out);
    }
}

/// `x . y` of each pair, with the bits of [`fold`], in one pass: a vector that stands in several pairs is brought to
/// the nearest cache once.
pub(crate) fn dots<const N: usize>(parallel: bool, pairs: [[&[f64]; 2]; N]) -> [f64; N] {
    let n = pairs.first().map_or(0, |[x, _]| x.len());
    let task = |task: usize| {
        let range = task * TASK..((task + 1) * TASK).min(n);
        let mut parts = [[0.0; PARTS]; N];
        for first in range.clone().step_by(CACHED) {
            let range = first..(first + CACHED).min(range.end);
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
    };
    let join = |sum: [f64; N], part: [f64; N]| std::array::from_fn(|k| sum[k] + part[k]);
    let tasks = n.div_ceil(TASK);
    if parallel {
        let partial: Vec<[f64; N]> = (0..tasks).into_par_iter().map(task).collect();
        partial.into_iter().fold([0.0; N], join)
    } else {
        (0..tasks).map(task).fold([0.0; N], join)
    }
}

/// Folds `value(inputs[..][i])` over all `i` with `join`: within a task by eight interleaved parts, then the tasks in
/// order, so that the bits do not depend on threads. The parts are independent, so the compiler can make vectors of
/// them.
pub(crate) fn fold<const N: usize>(
    parallel: bool,
    inputs: [&[f64]; N],
    start: f64,
    join: impl Fn(f64, f64) -> f64 + Sync,
    value: impl Fn([f64; N]) -> f64 + Sync,
) -> f64 {
    let n = inputs[0].len();
    let task = |task: usize| {
        let range = task * TASK..((task + 1) * TASK).min(n);
        let chunks = inputs.map(|input| input[range.clone()].as_chunks::<PARTS>());
        let mut parts = [start; PARTS];
        for c in 0..range.len() / PARTS {
            let chunk = chunks.map(|(whole, _)| whole[c]);
            for (k, part) in parts.iter_mut().enumerate() {
                *part = join(*part, value(std::array::from_fn(|n| chunk[n][k])));
            }
        }
        for (k, part) in parts.iter_mut().enumerate().take(range.len() % PARTS) {
            *part = join(*part, value(std::array::from_fn(|n| chunks[n].1[k])));
        }
        parts.into_iter().fold(start, &join)
    };
    let tasks = n.div_ceil(TASK);
    if parallel {
        let partial: Vec<f64> = (0..tasks).into_par_iter().map(task).collect();
        partial.into_iter().fold(start, &join)
    } else {
        (0..tasks).map(task).fold(start, &join)
    }
}
