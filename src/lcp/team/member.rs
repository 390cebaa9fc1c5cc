//! The vector verbs on one of several threads, which has some of the rows. All threads take the same solver through the
//! same steps; they meet where a number of all rows is needed.

use super::shared::{SUMS, Shared};
use crate::lcp::cpu::{Diagonals, Whole};
use crate::lcp::incidence::Incidence;
use crate::lcp::loops::{Chunks, add_up, dots, fold, map, update};
use crate::lcp::pair_blocks;
use crate::lcp::product::{add, row};
use crate::lcp::residual::{of_row, worse};
use crate::lcp::verbs::{Metric, Verbs};
use std::ops::Range;

/// One thread's share of a problem.
pub(super) struct Member<'a, const D: usize> {
    shared: &'a Shared,
    pub rows: Range<usize>,
    bodies: Range<usize>,
    /// Its chunks, by its own rows, the number of the first of them, and how many there are in all.
    chunks: Chunks,
    first_chunk: usize,
    all_chunks: usize,
    diagonals: Diagonals<'a>,
    q: &'a [f64],
    compliance: f64,
    pair: &'a [[u32; 2]],
    jacobian: &'a [[[f64; D]; 2]],
    incidence: &'a Incidence,
    gathered: &'a [[f64; D]],
    blocks: pair_blocks::Part<'a>,
    /// The sums that are written next.
    turn: usize,
    products: u64,
    looks: Vec<f64>,
}

impl<'a, const D: usize> Member<'a, D> {
    /// Shares a problem out: to each member some chunks of rows, and bodies with about as many rows.
    pub fn of_all(whole: Whole<'a, D>, shared: &'a Shared, members: usize) -> Vec<Self> {
        let Whole { diagonals, q, compliance, pair, jacobian, incidence, gathered, chunks, products, looks, .. } =
            whole;
        let mut blocks = Some(whole.blocks);
        let entries = incidence.entries.len();
        let body = |member: usize| {
            let before = |start: &u32| *start as usize * members < member * entries;
            incidence.start.partition_point(before).min(incidence.start.len() - 1)
        };
        let last = |member: usize| if member == members { incidence.start.len() - 1 } else { body(member) };
        let share = |(member, of): (usize, Range<usize>)| {
            let (own, rows) = chunks.share(&of);
            let (part, rest) = blocks.take()?.split_at(rows.len());
            blocks = Some(rest);
            Some(Member {
                shared,
                bodies: body(member)..last(member + 1),
                chunks: own,
                first_chunk: of.start,
                all_chunks: chunks.len(),
                diagonals: diagonals.of(rows.clone()),
                q: &q[rows.clone()],
                compliance,
                pair: &pair[rows.clone()],
                jacobian: &jacobian[rows.clone()],
                incidence,
                gathered,
                blocks: part,
                turn: 0,
                products,
                looks: looks.clone(),
                rows,
            })
        };
        chunks.shares(members).into_iter().enumerate().map_while(share).collect()
    }

    /// What the chunks of all members come to, each by `chunk`.
    fn of_chunks<const N: usize>(
        &mut self,
        chunk: impl Fn(Range<usize>) -> [f64; N],
    ) -> impl Iterator<Item = [f64; N]> {
        const { assert!(N <= SUMS) };
        let sums = &self.shared.sums[self.turn];
        self.turn = 1 - self.turn;
        for (k, rows) in self.chunks.ranges().enumerate() {
            sums.put(N * (self.first_chunk + k), &chunk(rows));
        }
        self.shared.meet();
        (0..self.all_chunks).map(|k| sums.block(N * k))
    }

    fn fold<const N: usize>(
        &mut self,
        inputs: [&[f64]; N],
        start: f64,
        join: impl Fn(f64, f64) -> f64,
        value: impl Fn([f64; N]) -> f64,
    ) -> f64 {
        let chunks = self.of_chunks(|rows| [fold(rows, inputs, start, &join, &value)]);
        chunks.fold(start, |all, [chunk]| join(all, chunk))
    }

    /// `out = A x`.
    fn multiply(&mut self, x: &[f64], out: &mut [f64]) {
        self.products += 1;
        let shared = self.shared;
        shared.x.put(self.rows.start, x);
        shared.meet();
        for body in self.bodies.clone() {
            let range = self.incidence.start[body] as usize..self.incidence.start[body + 1] as usize;
            let mut sum = [0.0; D];
            for (entry, block) in self.incidence.entries[range.clone()].iter().zip(&self.gathered[range]) {
                add(&mut sum, shared.x.get((*entry / 2) as usize), block);
            }
            shared.velocity.put(D * body, &sum);
        }
        shared.meet();
        for (out, ([a, b], blocks)) in out.iter_mut().zip(self.pair.iter().zip(self.jacobian)) {
            let [va, vb] = [*a, *b].map(|body| shared.velocity.block(D * body as usize));
            *out = row(blocks, &va, &vb);
        }
    }

    fn give_way(&self, x: &[f64], ax: &mut [f64]) {
        if self.compliance > 0.0 {
            let part = self.compliance;
            update(ax, [x, self.diagonals.plain()], |ax, [x, s]| ax + part * s * x);
        }
    }
}

impl<const D: usize> Verbs for Member<'_, D> {
    type Vector = Vec<f64>;
    type Scalar = f64;

    fn clear(&mut self, x: &mut Vec<f64>) {
        x.clear();
        x.resize(self.q.len(), 0.0);
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
        self.give_way(x, ax);
    }

    fn gradient(&mut self, x: &Vec<f64>, g: &mut Vec<f64>) {
        self.multiply(x, g);
        g.iter_mut().zip(self.q).for_each(|(g, q)| *g += q);
        self.give_way(x, g);
    }

    fn dot(&mut self, x: &Vec<f64>, y: &Vec<f64>) -> f64 {
        self.fold([x, y], 0.0, |a, b| a + b, |[x, y]| x * y)
    }

    fn dots<const N: usize>(&mut self, pairs: [[&Vec<f64>; 2]; N]) -> [f64; N] {
        let pairs = pairs.map(|pair| pair.map(Vec::as_slice));
        add_up(self.of_chunks(|rows| dots(rows, pairs)))
    }

    fn twice_objective(&mut self, x: &Vec<f64>, g: &Vec<f64>) -> f64 {
        self.fold([x, self.q, g], 0.0, |a, b| a + b, |[x, q, g]| x * (q + g))
    }

    fn combine(&mut self, a: f64, x: &Vec<f64>, b: f64, y: &Vec<f64>, out: &mut Vec<f64>) {
        map(out, [x, y], |[x, y]| a * x + b * y);
    }

    fn add(&mut self, a: f64, x: &Vec<f64>, y: &mut Vec<f64>) {
        update(y, [x], |y, [x]| y + a * x);
    }

    fn proximal(&mut self, metric: Metric, x: &Vec<f64>, step: f64, g: &Vec<f64>, out: &mut Vec<f64>) {
        if metric == Metric::PairBlocks {
            return self.blocks.proximal(x, step, g, out);
        }
        let (_, inverse) = self.diagonals.of_metric(metric);
        map(out, [x, g, inverse], |[x, g, inverse]| (x - step * g * inverse).max(0.0));
    }

    fn project(&mut self, metric: Metric, x: &Vec<f64>, out: &mut Vec<f64>) {
        if metric == Metric::PairBlocks {
            return self.blocks.project(x, out);
        }
        map(out, [x], |[x]| x.max(0.0));
    }

    fn square(&mut self, metric: Metric, x: &Vec<f64>) -> f64 {
        let (diagonal, _) = self.diagonals.of_metric(metric);
        self.fold([diagonal, x], 0.0, |a, b| a + b, |[s, x]| s * x * x)
    }

    fn inverse_square(&mut self, metric: Metric, x: &Vec<f64>) -> f64 {
        let (_, inverse) = self.diagonals.of_metric(metric);
        self.fold([inverse, x], 0.0, |a, b| a + b, |[s, x]| s * x * x)
    }

    fn ratio_test(&mut self, x: &Vec<f64>, d: &Vec<f64>) -> f64 {
        // As on one thread.
        let row = |[x, d]: [f64; 2]| if d < 0.0 { x / -d } else { f64::INFINITY };
        self.fold([x, d], f64::INFINITY, |a, b| if b < a { b } else { a }, row)
    }

    fn residual(&mut self, x: &Vec<f64>, g: &Vec<f64>) -> f64 {
        self.fold([g, self.diagonals.plain(), x], 0.0, worse, |[g, s, x]| of_row(g, s, x))
    }

    fn read(&mut self, scalar: f64) -> f64 {
        scalar
    }

    fn look(&mut self, residual: f64, _: f64) {
        self.looks.push(residual);
    }

    fn looks(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.looks)
    }

    fn products(&self) -> u64 {
        self.products
    }
}
