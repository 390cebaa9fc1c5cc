//! The vector verbs on one of several threads, which has some of the rows. All threads take the same solver through the
//! same steps; they meet where a number of all rows is needed.
//!
//! Rows stand in the order of their pair's smaller body. So each member has the velocities of consecutive bodies, and
//! other rows of its bodies belong to members before it. It takes their multipliers and adds them first, as one thread
//! would. It also takes the velocities of bodies after its own.

use super::shared::{SUMS, Shared};
use crate::lcp::cpu::{Diagonals, Whole};
use crate::lcp::loops::{Chunks, add_up, dots, fold, map, update};
use crate::lcp::pair_blocks::{self, sorted};
use crate::lcp::product::{add, along, scatter_onto};
use crate::lcp::residual::{of_row, worse};
use crate::lcp::verbs::{Metric, Verbs};
use std::ops::Range;

/// One thread's share of a problem.
pub(super) struct Member<'a, const D: usize> {
    shared: &'a Shared,
    pub rows: Range<usize>,
    bodies: Range<usize>,
    /// Rows of members before it at its bodies, by body: the row, the body, the block.
    before: Vec<(u32, u32, [f64; D])>,
    /// The bodies of these rows: others need their velocities.
    given: Vec<u32>,
    /// Its rows with bodies of members after it, by its own numbers, and these bodies.
    across: Vec<u32>,
    taken: Vec<u32>,
    /// Of all bodies; right for its own, and after an exchange for those it takes.
    velocity: Vec<[f64; D]>,
    /// Its chunks, by its own rows, the number of the first of them, and how many there are in all.
    chunks: Chunks,
    first_chunk: usize,
    all_chunks: usize,
    diagonals: Diagonals<'a>,
    q: &'a [f64],
    compliance: f64,
    pair: &'a [[u32; 2]],
    jacobian: &'a [[[f64; D]; 2]],
    blocks: pair_blocks::Part<'a>,
    /// The sums that are written next.
    turn: usize,
    products: u64,
    looks: Vec<f64>,
}

impl<'a, const D: usize> Member<'a, D> {
    /// Shares a problem out: to each member some chunks of rows, and bodies with about as many rows.
    pub fn of_all(whole: Whole<'a, D>, shared: &'a Shared, members: usize) -> Vec<Self> {
        let Whole { diagonals, q, compliance, pair, jacobian, incidence, chunks, products, looks, .. } = whole;
        let mut blocks = Some(whole.blocks);
        let all = incidence.start.len() - 1;
        let first_body = |chunk: usize| {
            let rows = chunks.ranges().nth(chunk).unwrap_or(0..0);
            pair[rows].iter().map(|pair| sorted(*pair)[0] as usize).min().unwrap_or(all)
        };
        let share = |of: Range<usize>| {
            let (own, rows) = chunks.share(&of);
            let bodies = if of.start == 0 { 0 } else { first_body(of.start) }..first_body(of.end);
            let mut before = Vec::new();
            for body in bodies.clone() {
                let early = incidence.of(body).iter().take_while(|entry| ((**entry / 2) as usize) < rows.start);
                before.extend(early.map(|entry| {
                    let (row, side) = (*entry / 2, (*entry % 2) as usize);
                    (row, body as u32, jacobian[row as usize][side])
                }));
            }
            let mut given: Vec<u32> = before.iter().map(|(_, body, _)| *body).collect();
            given.dedup();
            let far = |row: &u32| sorted(pair[rows.start + *row as usize])[1] as usize >= bodies.end;
            let across: Vec<u32> = (0..rows.len() as u32).filter(far).collect();
            let mut taken: Vec<u32> = across.iter().map(|row| sorted(pair[rows.start + *row as usize])[1]).collect();
            taken.sort_unstable();
            taken.dedup();
            let (part, rest) = blocks.take()?.split_at(of.len());
            blocks = Some(rest);
            Some(Member {
                shared,
                bodies,
                before,
                given,
                across,
                taken,
                velocity: vec![[0.0; D]; all],
                chunks: own,
                first_chunk: of.start,
                all_chunks: chunks.len(),
                diagonals: diagonals.of(rows.clone()),
                q: &q[rows.clone()],
                compliance,
                pair: &pair[rows.clone()],
                jacobian: &jacobian[rows.clone()],
                blocks: part,
                turn: 0,
                products,
                looks: looks.clone(),
                rows,
            })
        };
        chunks.shares(members).into_iter().map_while(share).collect()
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
        for row in self.across.iter().map(|row| *row as usize) {
            shared.x.put(self.rows.start + row, &x[row..=row]);
        }
        shared.meet();
        self.velocity[self.bodies.clone()].fill([0.0; D]);
        for (row, body, block) in &self.before {
            add(&mut self.velocity[*body as usize], shared.x.get(*row as usize), block);
        }
        scatter_onto(self.pair, self.jacobian, x, &mut self.velocity);
        for body in self.given.iter().map(|body| *body as usize) {
            shared.velocity.put(D * body, &self.velocity[body]);
        }
        shared.meet();
        for body in self.taken.iter().map(|body| *body as usize) {
            self.velocity[body] = shared.velocity.block(D * body);
        }
        along(self.pair, self.jacobian, &self.velocity, out);
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
