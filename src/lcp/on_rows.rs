//! The vector verbs for rows in memory, for a thread with the whole problem or with a share of it.
//!
//! The two cases differ in the product with `A` and in the chunks of a sum that they compute.

use super::cone::{project, residual, room, worse};
use super::loops::{dots, fold, map, update};
use super::pair_blocks::Blocks;
use super::passes;
use super::verbs::{At, Checks, Metric, Past, Term, Verbs, composed};
use std::ops::Range;

/// The diagonals of all or some rows of a problem.
#[derive(Clone, Copy)]
pub(super) struct Diagonals<'a> {
    pub plain: &'a [f64],
    pub inverse: &'a [f64],
    /// Empty if it is not used, as in a team.
    pub majorant: &'a [f64],
    pub inverse_majorant: &'a [f64],
}

impl<'a> Diagonals<'a> {
    /// The entries of some rows.
    pub fn of(self, rows: Range<usize>) -> Self {
        Diagonals { plain: &self.plain[rows.clone()], inverse: &self.inverse[rows], ..self }
    }

    /// The diagonal of `A`.
    pub fn plain(self) -> &'a [f64] {
        self.plain
    }

    /// The diagonal of a metric and its inverse.
    pub fn of_metric(self, metric: Metric) -> (&'a [f64], &'a [f64]) {
        match metric {
            Metric::Majorant => (self.majorant, self.inverse_majorant),
            Metric::Diagonal => (self.plain, self.inverse),
        }
    }
}

/// The data of a thread's rows.
pub(super) struct Numbers<'a> {
    pub diagonals: Diagonals<'a>,
    pub q: &'a [f64],
    /// `A` gets this part of its diagonal added.
    pub compliance: f64,
}

/// A thread's rows of a problem.
pub(super) trait OnRows {
    /// Their data.
    fn numbers(&self) -> Numbers<'_>;
    /// `out = A x` without compliance, counted as a product.
    fn multiply(&mut self, x: &[f64], out: &mut [f64]);
    /// [`pair_blocks::Part::minimize`](super::pair_blocks::Part::minimize) of the blocks of these rows.
    fn minimize_pairs(&mut self, x: &[f64], slope: Option<(f64, &[f64])>, out: &mut [f64]);
    /// Reduces all chunks of the whole problem along their tree ([`super::loops::Tree`]); `chunk` computes those of
    /// these rows. Without chunks: `start`.
    fn join_chunks<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl FnMut(Range<usize>) -> [f64; N],
    ) -> [f64; N];
    /// Whether every chunk has its own small problems, and all rows are here or with other threads: what the operations
    /// below need.
    fn has_small_chunks(&self) -> bool;
    /// [`OnRows::join_chunks`] with the small problems of each chunk.
    fn join_blocks<const N: usize>(
        &mut self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl FnMut(Range<usize>, &mut Blocks, &Numbers) -> [f64; N],
    ) -> [f64; N];
    /// [`OnRows::multiply`] that reduces all chunks; `chunk` gets the result of each.
    fn multiply_and_join<const N: usize>(
        &mut self,
        x: &[f64],
        out: &mut [f64],
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl FnMut(Range<usize>, &Numbers, &mut [f64]) -> [f64; N],
    ) -> [f64; N];
    /// The recorded residuals that were not read yet.
    fn noted(&mut self) -> &mut Vec<f64>;
    /// Products computed.
    fn made(&self) -> u64;
}

/// Folds `value(inputs[..][i])` over all rows of the problem with `join`, chunk by chunk.
fn over<const N: usize>(
    rows: &impl OnRows,
    inputs: [&[f64]; N],
    start: f64,
    join: impl Fn(f64, f64) -> f64,
    value: impl Fn([f64; N]) -> f64,
) -> f64 {
    let [all] = rows.join_chunks([start], |_, a, b| join(a, b), |rows| [fold(rows, inputs, start, &join, &value)]);
    all
}

/// Adds the part of compliance to `ax = A x` at some rows.
pub(super) fn regularize(numbers: &Numbers, rows: Range<usize>, x: &[f64], ax: &mut [f64]) {
    if numbers.compliance > 0.0 {
        let part = numbers.compliance;
        update(ax, [x, &numbers.diagonals.plain()[rows]], |ax, [x, s]| ax + part * s * x);
    }
}

/// The smaller number; NaN counts as no bound.
pub(super) fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

impl<R: OnRows> Verbs for R {
    type Vector = Vec<f64>;
    type Scalar = f64;

    fn clear(&mut self, x: &mut Vec<f64>) {
        x.clear();
        x.resize(self.numbers().q.len(), 0.0);
    }

    fn copy(&mut self, from: &Vec<f64>, to: &mut Vec<f64>) {
        to.clone_from(from);
    }

    fn copy_if_positive(&mut self, condition: f64, from: &Vec<f64>, to: &mut Vec<f64>) {
        if condition > 0.0 {
            to.clone_from(from);
        }
    }

    fn take(&mut self, from: &mut Vec<f64>, to: &mut Vec<f64>) {
        std::mem::swap(from, to);
    }

    fn product(&mut self, x: &Vec<f64>, ax: &mut Vec<f64>) {
        self.multiply(x, ax);
        regularize(&self.numbers(), 0..x.len(), x, ax);
    }

    fn gradient(&mut self, x: &Vec<f64>, g: &mut Vec<f64>) {
        self.multiply(x, g);
        let numbers = self.numbers();
        update(g, [numbers.q], |ax, [q]| ax + q);
        regularize(&numbers, 0..x.len(), x, g);
    }

    fn dot(&mut self, x: &Vec<f64>, y: &Vec<f64>) -> f64 {
        over(self, [x, y], 0.0, |a, b| a + b, |[x, y]| x * y)
    }

    fn dots<const N: usize>(&mut self, pairs: [[&Vec<f64>; 2]; N]) -> [f64; N] {
        let pairs = pairs.map(|pair| pair.map(Vec::as_slice));
        self.join_chunks([0.0; N], |_, a, b| a + b, |rows| dots(rows, pairs))
    }

    fn twice_objective(&mut self, x: &Vec<f64>, g: &Vec<f64>) -> f64 {
        over(self, [x, self.numbers().q, g], 0.0, |a, b| a + b, |[x, q, g]| x * (q + g))
    }

    fn combine(&mut self, a: f64, x: &Vec<f64>, b: f64, y: &Vec<f64>, out: &mut Vec<f64>) {
        map(out, [x, y], |[x, y]| a * x + b * y);
    }

    fn add(&mut self, a: f64, x: &Vec<f64>, y: &mut Vec<f64>) {
        update(y, [x], |y, [x]| y + a * x);
    }

    fn proximal(&mut self, metric: Metric, x: &Vec<f64>, step: f64, g: &Vec<f64>, out: &mut Vec<f64>) {
        let (_, inverse) = self.numbers().diagonals.of_metric(metric);
        map(out, [x, g, inverse], |[x, g, inverse]| project(x - step * g * inverse));
    }

    fn descend(&mut self, x: &Vec<f64>, g: &Vec<f64>, out: &mut Vec<f64>) {
        self.minimize_pairs(x, Some((1.0, g)), out);
        update(out, [x], |y, [x]| y - x);
    }

    fn displace(&mut self, x: &Vec<f64>, terms: [(f64, &Vec<f64>); 3], out: &mut Vec<f64>, room: &mut Vec<f64>) {
        let [(a, first), (b, second), (c, third)] = terms;
        map(room, [x, first, second, third], |[x, p, q, r]| x + a * p + b * q + c * r);
        self.minimize_pairs(room, None, out);
        update(out, [x], |y, [x]| y - x);
    }

    fn advance(&mut self, a: f64, d: &Vec<f64>, x: &mut Vec<f64>, _: &mut Vec<f64>) {
        update(x, [d], |x, [d]| project(x + a * d));
    }

    fn square(&mut self, metric: Metric, x: &Vec<f64>) -> f64 {
        let (diagonal, _) = self.numbers().diagonals.of_metric(metric);
        over(self, [diagonal, x], 0.0, |a, b| a + b, |[s, x]| s * x * x)
    }

    fn inverse_square(&mut self, metric: Metric, x: &Vec<f64>) -> f64 {
        let (_, inverse) = self.numbers().diagonals.of_metric(metric);
        over(self, [inverse, x], 0.0, |a, b| a + b, |[s, x]| s * x * x)
    }

    fn ratio_test(&mut self, x: &Vec<f64>, d: &Vec<f64>) -> f64 {
        over(self, [x, d], f64::INFINITY, smaller, |[x, d]| room(x, d))
    }

    fn dots_and_room(&mut self, pairs: [[&Vec<f64>; 2]; 2], x: &Vec<f64>, d: &Vec<f64>) -> ([f64; 2], f64) {
        let pairs = pairs.map(|pair| pair.map(Vec::as_slice));
        let join = |k: usize, a: f64, b: f64| if k < 2 { a + b } else { smaller(a, b) };
        let [a, b, least] = self.join_chunks([0.0, 0.0, f64::INFINITY], join, |rows| {
            let [a, b] = dots(rows.clone(), pairs);
            [a, b, fold(rows, [x, d], f64::INFINITY, smaller, |[x, d]| room(x, d))]
        });
        ([a, b], least)
    }

    fn descend_beside(&mut self, at: At<Vec<f64>>, past: [Past<Vec<f64>>; 2], out: &mut Vec<f64>) -> [f64; 6] {
        if !self.has_small_chunks() {
            return composed::descend_beside(self, at, past, out);
        }
        let (at, past) = (at.map(Vec::as_slice), past.map(|past| past.map(Vec::as_slice)));
        passes::descend(self, at, past, out)
    }

    fn displace_and_multiply(
        &mut self,
        at: At<Vec<f64>>,
        terms: [Term<f64, Vec<f64>>; 3],
        safe: (f64, &Vec<f64>),
        made: [&mut Vec<f64>; 2],
        room: &mut Vec<f64>,
    ) -> ([f64; 2], f64) {
        if !self.has_small_chunks() {
            return composed::displace_and_multiply(self, at, terms, safe, made, room);
        }
        let ([out, product], at) = (made, at.map(Vec::as_slice));
        let terms = terms.map(|(part, term)| (part, term.as_slice()));
        let [mut slope, mut least] = passes::displace(self, at, terms, out, room);
        if slope - safe.0 > 0.0 {
            out.clone_from(safe.1);
            [slope, least] = passes::along(self, at, out);
        }
        ([slope, passes::multiply(self, out, product)], least)
    }

    fn advance_along(
        &mut self,
        part: f64,
        made: Past<Vec<f64>>,
        [x, g]: [&mut Vec<f64>; 2],
        room: &mut Vec<f64>,
    ) -> Option<f64> {
        if !self.has_small_chunks() {
            return composed::advance_along(self, part, made, [x, g], room);
        }
        Some(passes::advance(self, part, made.map(Vec::as_slice), x, g))
    }

    fn residual(&mut self, x: &Vec<f64>, g: &Vec<f64>) -> f64 {
        over(self, [g, self.numbers().diagonals.plain(), x], 0.0, worse, |[g, s, x]| residual(g, s, x))
    }

    fn read(&mut self, scalar: f64) -> f64 {
        scalar
    }

    fn check(&mut self, residual: f64, _: f64) {
        self.noted().push(residual);
    }

    fn take_checks(&mut self) -> Checks {
        Checks { residuals: std::mem::take(self.noted()), ended: false }
    }

    fn products(&self) -> u64 {
        self.made()
    }
}
