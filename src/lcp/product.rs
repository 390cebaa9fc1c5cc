//! The product `A x = J (J^T x)`: `v = J^T x` body by body, then the rows of `J v`.
//!
//! A body's terms are added in ascending order of the rows.

use super::incidence::Incidence;
use super::loops::LEAST_ROWS_A_TASK;
use rayon::prelude::*;
use std::ops::Range;

/// A diagonal entry of `A` is a zero row's at or under this part of the largest: its square root, the length of the row
/// of `J`, is then below the rounding of the largest row's.
pub(super) const ZERO_ROW: f64 = f64::EPSILON * f64::EPSILON;

/// With fewer rows one thread computes a product outside of a team: it takes less than 0.1 ms.
const LEAST_ROWS_FOR_THREADS: usize = 16_384;

/// A sum over the rows of fewer bodies than this runs on one thread: a body takes some 20 ns.
const LEAST_BODIES_A_TASK: usize = 1_024;

/// The rows of `J`, kept ready for products.
#[derive(Clone, Debug, Default)]
pub struct Product<const D: usize> {
    pair: Vec<[u32; 2]>,
    jacobian: Vec<[[f64; D]; 2]>,
    incidence: Incidence,
    velocity: Vec<[f64; D]>,
}

impl<const D: usize> Product<D> {
    /// Takes the rows of a problem in the given order of rows.
    pub fn rebuild(&mut self, bodies: usize, pair: &[[u32; 2]], jacobian: &[[[f64; D]; 2]], order: &[u32]) {
        let order = order.par_iter().with_min_len(LEAST_ROWS_A_TASK);
        order.clone().map(|row| pair[*row as usize]).collect_into_vec(&mut self.pair);
        order.map(|row| jacobian[*row as usize]).collect_into_vec(&mut self.jacobian);
        self.velocity.clear();
        self.velocity.resize(bodies, [0.0; D]);
        self.incidence.rebuild(bodies, &self.pair);
    }

    /// The bodies of each row.
    pub fn pair(&self) -> &[[u32; 2]] {
        &self.pair
    }

    /// The number of bodies.
    pub fn bodies(&self) -> usize {
        self.velocity.len()
    }

    /// The rows of each body.
    pub fn incidence(&self) -> &Incidence {
        &self.incidence
    }

    /// The two blocks of each row.
    pub fn jacobian(&self) -> &[[[f64; D]; 2]] {
        &self.jacobian
    }

    /// `out = A x`, by several threads if there are many rows.
    pub fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        if self.pair.len() >= LEAST_ROWS_FOR_THREADS && rayon::current_num_threads() > 1 {
            return self.apply_together(x, out);
        }
        scatter(&self.pair, &self.jacobian, x, &mut self.velocity);
        along(&self.pair, &self.jacobian, &self.velocity, out);
    }

    /// The same, with the same bits: body by body, then row by row.
    fn apply_together(&mut self, x: &[f64], out: &mut [f64]) {
        let Product { pair, jacobian, incidence, velocity } = self;
        gather(incidence, jacobian, x, velocity);
        let rows = pair.par_chunks(LEAST_ROWS_A_TASK).zip(jacobian.par_chunks(LEAST_ROWS_A_TASK));
        let all = out.par_chunks_mut(LEAST_ROWS_A_TASK).zip(rows);
        all.for_each(|(out, (pair, jacobian))| along(pair, jacobian, velocity, out));
    }

    /// The diagonal of `A`.
    pub fn diagonal(&self) -> Vec<f64> {
        let rows = self.jacobian.par_iter().with_min_len(LEAST_ROWS_A_TASK);
        rows.map(|[ja, jb]| dot(ja, ja) + dot(jb, jb)).collect()
    }

    /// A diagonal `W` with `x . A x <= x . W x`: `w_i = sum over the row's bodies b of c_b |J_ib|^2` with `c_b` the
    /// number of rows of body `b`, since by Cauchy and Schwarz `|sum_i J_ib x_i|^2 <= c_b sum_i |J_ib|^2 x_i^2`.
    pub fn majorant(&self) -> Vec<f64> {
        let count = |body: u32| self.incidence.of(body as usize).len() as f64;
        let row = |([a, b], [ja, jb]): (&[u32; 2], &[[f64; D]; 2])| count(*a) * dot(ja, ja) + count(*b) * dot(jb, jb);
        self.pair.iter().zip(&self.jacobian).map(row).collect()
    }
}

/// A product in parts.
impl<const D: usize> Product<D> {
    /// `v = J^T x` of the local rows, one block per body.
    pub fn velocities(&mut self, x: &[f64]) -> &[[f64; D]] {
        scatter(&self.pair, &self.jacobian, x, &mut self.velocity);
        &self.velocity
    }

    /// `out = J v` of some rows.
    pub fn rows_of(&self, rows: Range<usize>, out: &mut [f64]) {
        along(&self.pair[rows.clone()], &self.jacobian[rows], &self.velocity, out);
    }
}

/// A product in parts, for a process with some of the rows.
#[cfg(feature = "mpi")]
impl<const D: usize> Product<D> {
    /// The last `v`, mutable.
    pub fn last_velocities(&mut self) -> &mut [[f64; D]] {
        &mut self.velocity
    }

    /// `out = J v`.
    pub fn rows(&self, out: &mut [f64]) {
        along(&self.pair, &self.jacobian, &self.velocity, out);
    }

    /// The same for some rows.
    pub fn recompute_rows(&self, rows: &[u32], out: &mut [f64]) {
        for at in rows.iter().map(|row| *row as usize) {
            let [a, b] = self.pair[at].map(|body| &self.velocity[body as usize]);
            out[at] = row(&self.jacobian[at], a, b);
        }
    }
}

/// `out = J^T x`, one block per body, row by row.
pub(crate) fn scatter<const D: usize>(pair: &[[u32; 2]], jacobian: &[[[f64; D]; 2]], x: &[f64], out: &mut [[f64; D]]) {
    out.fill([0.0; D]);
    scatter_onto(pair, jacobian, x, out);
}

/// `out = J^T x`, body by body, by several threads, with the bits of [`scatter`].
pub(crate) fn gather<const D: usize>(
    incidence: &Incidence,
    jacobian: &[[[f64; D]; 2]],
    x: &[f64],
    out: &mut [[f64; D]],
) {
    let of_body = |(body, out): (usize, &mut [f64; D])| {
        *out = [0.0; D];
        for entry in incidence.of(body) {
            let (row, side) = ((entry / 2) as usize, (entry % 2) as usize);
            add(out, x[row], &jacobian[row][side]);
        }
    };
    out.par_iter_mut().enumerate().with_min_len(LEAST_BODIES_A_TASK).for_each(of_body);
}

/// `out += J^T x`, row by row.
pub(crate) fn scatter_onto<const D: usize>(
    pair: &[[u32; 2]],
    jacobian: &[[[f64; D]; 2]],
    x: &[f64],
    out: &mut [[f64; D]],
) {
    let Some([first, _]) = pair.first() else { return };
    // The first body stays in registers while rows share it, as consecutive rows do.
    let (mut at, mut of_first) = (*first as usize, out[*first as usize]);
    for (([a, b], [ja, jb]), x) in pair.iter().zip(jacobian).zip(x) {
        if *a as usize != at {
            out[at] = of_first;
            at = *a as usize;
            of_first = out[at];
        }
        add(&mut of_first, *x, ja);
        add(&mut out[*b as usize], *x, jb);
    }
    out[at] = of_first;
}

#[inline]
pub(crate) fn dot<const D: usize>(x: &[f64; D], y: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for k in 0..D {
        sum += x[k] * y[k];
    }
    sum
}

/// `out = J v`.
pub(crate) fn along<const D: usize>(
    pair: &[[u32; 2]],
    jacobian: &[[[f64; D]; 2]],
    velocity: &[[f64; D]],
    out: &mut [f64],
) {
    let Some([first, _]) = pair.first() else { return };
    let (mut at, mut of_first) = (*first, velocity[*first as usize]);
    for (out, ([a, b], blocks)) in out.iter_mut().zip(pair.iter().zip(jacobian)) {
        if *a != at {
            (at, of_first) = (*a, velocity[*a as usize]);
        }
        *out = row(blocks, &of_first, &velocity[*b as usize]);
    }
}

/// A row of `J v`, from its blocks and the velocities of its bodies, in two interleaved sums, which the compiler
/// vectorizes.
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn several_threads_compute_the_bits_of_one() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(17);
        let bodies = 6_000_u32;
        let near = |a: u32| [1, 2, 77].map(|far| [a, (a + far) % bodies]);
        let pair: Vec<[u32; 2]> = (0..bodies).flat_map(near).collect();
        let mut block = || std::array::from_fn(|_| rng.random::<f64>() - 0.5);
        let jacobian: Vec<[[f64; 3]; 2]> = pair.iter().map(|_| [block(), block()]).collect();
        let x: Vec<f64> = pair.iter().map(|_| block()).map(|[x, _, _]: [f64; 3]| x).collect();
        assert!(pair.len() >= LEAST_ROWS_FOR_THREADS);
        let product = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut product = Product::<3>::default();
            let order: Vec<u32> = (0..pair.len() as u32).rev().collect();
            let mut out = vec![0.0; pair.len()];
            pool.install(|| {
                product.rebuild(bodies as usize, &pair, &jacobian, &order);
                product.apply(&x, &mut out);
            });
            (out, product.velocity)
        };
        let alone = product(1);
        assert!(alone.0.iter().all(|g| g.is_finite()) && [2, 3].map(product) == [alone.clone(), alone]);
    }
}
