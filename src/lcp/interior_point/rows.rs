//! The nonzero rows of `J`, each scaled to length one, between bodies with consecutive indices.

use crate::lcp::cone::lack;
use crate::lcp::cpu::Rows;
use crate::lcp::incidence::Incidence;
use crate::lcp::product::{dot, gather};
use rayon::prelude::*;

/// No index.
const NONE: u32 = u32::MAX;

/// Loops over fewer rows or bodies than this run on one thread: one takes some 20 ns. With 1,024, two threads take a
/// tenth more time than one for a colony to 1,024 cells, whose systems have up to 3,600 rows.
const LEAST_A_TASK: usize = 2_048;

/// `out[i] = value(i)`, by several threads.
pub(super) fn fill<T: Send>(out: &mut Vec<T>, count: usize, value: impl Fn(usize) -> T + Sync + Send) {
    (0..count).into_par_iter().with_min_len(LEAST_A_TASK).map(value).collect_into_vec(out);
}

/// The sums of some values of each row, by several threads: chunk by chunk, so that the bits do not depend on these.
pub(super) fn sums<const N: usize>(rows: usize, values: impl Fn(usize) -> [f64; N] + Sync) -> [f64; N] {
    let plus = |a: [f64; N], b: [f64; N]| std::array::from_fn(|k| a[k] + b[k]);
    let of_chunk = |chunk: usize| {
        let rows = chunk * LEAST_A_TASK..rows.min((chunk + 1) * LEAST_A_TASK);
        rows.map(&values).fold([0.0; N], plus)
    };
    let parts: Vec<[f64; N]> = (0..rows.div_ceil(LEAST_A_TASK)).into_par_iter().map(of_chunk).collect();
    parts.into_iter().fold([0.0; N], plus)
}

/// Folds values of the rows with `join`, whose result must not depend on the order, by several threads.
pub(super) fn fold(
    rows: usize,
    start: f64,
    join: impl Fn(f64, f64) -> f64 + Sync + Send,
    value: impl Fn(usize) -> f64 + Sync + Send,
) -> f64 {
    (0..rows).into_par_iter().with_min_len(LEAST_A_TASK).map(value).reduce(|| start, join)
}

/// Rows of length one. Their multipliers are the problem's times the length of the row, and so are lengths.
#[derive(Default)]
pub(super) struct UnitRows<const D: usize> {
    /// Each row's index in the problem.
    pub row: Vec<u32>,
    /// The bodies of each row, by their consecutive indices.
    pub pair: Vec<[u32; 2]>,
    /// The blocks of each row.
    pub jacobian: Vec<[[f64; D]; 2]>,
    /// `1 / length` of each original row.
    pub inverse_length: Vec<f64>,
    /// `g` at zero.
    pub q: Vec<f64>,
    /// The number of bodies that rows refer to.
    pub bodies: usize,
    /// The deepest violation without multipliers, zero if there is none.
    pub deepest: f64,
    /// The length that is added to the gap of each row.
    pub relief: f64,
    /// The rows of each body.
    pub incidence: Incidence,
    place: Vec<u32>,
}

impl<const D: usize> UnitRows<D> {
    /// Takes the nonzero rows of a problem.
    pub fn rebuild(&mut self, rows: &Rows<D>) {
        let bodies = rows.pair.as_flattened().iter().max().map_or(0, |body| *body as usize + 1);
        self.place.clear();
        self.place.resize(bodies, NONE);
        (self.bodies, self.deepest, self.relief) = (0, 0.0, 0.0);
        self.row.clear();
        self.row.extend((0..rows.q.len() as u32).filter(|row| rows.inverse[*row as usize] > 0.0));
        self.pair.clear();
        self.jacobian.clear();
        self.inverse_length.clear();
        self.q.clear();
        for row in self.row.iter().map(|row| *row as usize) {
            let inverse_length = rows.inverse[row].sqrt();
            let place = |body: u32| {
                let place = &mut self.place[body as usize];
                if *place == NONE {
                    *place = self.bodies as u32;
                    self.bodies += 1;
                }
                *place
            };
            self.pair.push(rows.pair[row].map(place));
            self.jacobian.push(rows.jacobian[row].map(|block| block.map(|number| number * inverse_length)));
            self.inverse_length.push(inverse_length);
            self.q.push(rows.q[row] * inverse_length);
            self.deepest = self.deepest.max(lack(rows.q[row] * inverse_length));
        }
        self.incidence.rebuild(self.bodies, &self.pair);
    }

    /// Adds a length to the gap of each row, in place of the last one.
    pub fn relieve(&mut self, relief: f64) {
        let change = relief - std::mem::replace(&mut self.relief, relief);
        self.deepest = 0.0;
        for (q, inverse_length) in self.q.iter_mut().zip(&self.inverse_length) {
            *q += change * inverse_length;
            self.deepest = self.deepest.max(lack(*q));
        }
    }

    /// Gives the bodies other indices, again from zero on.
    pub fn renumber(&mut self, place: &[u32]) {
        self.pair.as_flattened_mut().iter_mut().for_each(|body| *body = place[*body as usize]);
        self.incidence.rebuild(self.bodies, &self.pair);
    }

    /// A multiplier and a gap of the problem as those of the row of length one.
    pub fn unit(&self, row: usize, x: &[f64], g: &[f64]) -> [f64; 2] {
        let (index, inverse_length) = (self.row[row] as usize, self.inverse_length[row]);
        [x[index] / inverse_length, (g[index] + self.relief) * inverse_length]
    }

    pub fn len(&self) -> usize {
        self.row.len()
    }

    /// `v = J^T x`.
    pub fn velocity(&self, x: &[f64], v: &mut Vec<[f64; D]>) {
        v.resize(self.bodies, [0.0; D]);
        gather(&self.incidence, &self.jacobian, x, v);
    }

    /// A row of `J v`.
    pub fn along(&self, row: usize, v: &[[f64; D]]) -> f64 {
        let ([a, b], [ja, jb]) = (self.pair[row], &self.jacobian[row]);
        dot(ja, &v[a as usize]) + dot(jb, &v[b as usize])
    }
}
