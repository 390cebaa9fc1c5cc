//! The vector verbs on one of several threads, each with some of the rows. All threads run the same solver; they
//! synchronize wherever a value of all rows is needed.
//!
//! Rows are in the order of their pair's smaller body. So each member has the velocities of consecutive bodies, and
//! other rows of its bodies belong to earlier members. It reads their multipliers and adds their terms first, as one
//! thread would. It also reads the velocities of bodies after its own.

use super::shared::{SUMS, Shared};
use crate::lcp::cpu::Whole;
use crate::lcp::loops::{Chunks, Tree};
use crate::lcp::on_rows::{Diagonals, Numbers, OnRows};
use crate::lcp::pair_blocks::{self, Blocks, sorted};
use crate::lcp::product::{add, along, scatter_onto};
use std::cell::Cell;
use std::ops::Range;

/// One thread's share of a problem.
pub(super) struct Member<'a, const D: usize> {
    shared: &'a Shared,
    rows: Range<usize>,
    bodies: Range<usize>,
    links: Links<D>,
    sums: Sums<'a>,
    diagonals: Diagonals<'a>,
    q: &'a [f64],
    compliance: f64,
    pair: &'a [[u32; 2]],
    jacobian: &'a [[[f64; D]; 2]],
    blocks: pair_blocks::Part<'a>,
    products: u64,
    noted: Vec<f64>,
}

/// What connects a member's rows and bodies with those of other members.
pub(super) struct Links<const D: usize> {
    /// Rows of earlier members at its bodies, by body: the row, the body, the block.
    before: Vec<(u32, u32, [f64; D])>,
    /// The bodies of these rows: others need their velocities.
    given: Vec<u32>,
    /// Its rows with bodies of later members, by its own indices, and these bodies.
    across: Vec<u32>,
    taken: Vec<u32>,
    /// The velocities of all bodies; valid for its own, and after an exchange for those that it reads.
    velocity: Vec<[f64; D]>,
}

/// The distribution of a problem: for each member some chunks of rows, and bodies with about as many rows.
pub(super) struct Parts {
    pub chunks: Vec<Range<usize>>,
    pub rows: Vec<Range<usize>>,
    pub bodies: Vec<Range<usize>>,
}

impl Parts {
    /// For this many members.
    pub fn new<const D: usize>(whole: &Whole<'_, D>, members: usize) -> Self {
        let Whole { pair, chunks, .. } = whole;
        let all = whole.incidence.start.len() - 1;
        let first_body = |chunk: usize| {
            let rows = chunks.ranges().nth(chunk).unwrap_or(0..0);
            pair[rows].iter().map(|pair| sorted(*pair)[0] as usize).min().unwrap_or(all)
        };
        let shares = chunks.shares(members);
        let bodies = |of: &Range<usize>| if of.start == 0 { 0 } else { first_body(of.start) }..first_body(of.end);
        Parts {
            rows: shares.iter().map(|of| chunks.share(of).1).collect(),
            bodies: shares.iter().map(bodies).collect(),
            chunks: shares,
        }
    }
}

impl<const D: usize> Links<D> {
    /// Those of member `k`.
    pub fn new(whole: &Whole<'_, D>, parts: &Parts, k: usize) -> Self {
        let (rows, bodies) = (parts.rows[k].clone(), parts.bodies[k].clone());
        let Whole { pair, jacobian, incidence, .. } = *whole;
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
        Links { before, given, across, taken, velocity: vec![[0.0; D]; incidence.start.len() - 1] }
    }
}

impl<'a, const D: usize> Member<'a, D> {
    /// Member `k`, with the blocks of its rows.
    pub fn new(
        whole: &Whole<'a, D>,
        shared: &'a Shared,
        (parts, k): (&Parts, usize),
        blocks: pair_blocks::Part<'a>,
        links: Links<D>,
    ) -> Self {
        let (of, rows, bodies) = (parts.chunks[k].clone(), parts.rows[k].clone(), parts.bodies[k].clone());
        let Whole { diagonals, q, compliance, pair, jacobian, chunks, products, .. } = *whole;
        Member {
            shared,
            bodies,
            links,
            sums: Sums { shared, chunks: chunks.share(&of).0, first: of.start, all: chunks.len(), turn: Cell::new(0) },
            diagonals: diagonals.of(rows.clone()),
            q: &q[rows.clone()],
            compliance,
            pair: &pair[rows.clone()],
            jacobian: &jacobian[rows.clone()],
            blocks,
            products,
            noted: whole.noted.clone(),
            rows,
        }
    }

    /// What the member of the next round is made from.
    pub fn into_links(self) -> Links<D> {
        self.links
    }
}

/// Sums over the chunks of all members.
struct Sums<'a> {
    shared: &'a Shared,
    /// This member's chunks with its own row indices, the index of the first one, and the number of all chunks.
    chunks: Chunks,
    first: usize,
    all: usize,
    /// Which buffer of sums is written next.
    turn: Cell<usize>,
}

impl Sums<'_> {
    /// See [`OnRows::join_chunks`].
    fn join<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        mut chunk: impl FnMut(Range<usize>) -> [f64; N],
    ) -> [f64; N] {
        const { assert!(N <= SUMS) };
        let turn = self.turn.replace(1 - self.turn.get());
        let sums = &self.shared.board.sums[turn];
        for (k, rows) in self.chunks.ranges().enumerate() {
            sums.put(N * (self.first + k), &chunk(rows));
        }
        self.shared.meet();
        let mut tree = Tree::new(join);
        (0..self.all).for_each(|k| tree.add(sums.block(N * k), 0));
        tree.end(start)
    }
}

impl<const D: usize> Member<'_, D> {
    /// The velocities `J^T x` of the bodies of its rows, counted as a product.
    fn find_velocities(&mut self, x: &[f64]) {
        self.products += 1;
        let (shared, board) = (self.shared, &self.shared.board);
        let Links { before, given, across, taken, velocity } = &mut self.links;
        for row in across.iter().map(|row| *row as usize) {
            board.x.put(self.rows.start + row, &x[row..=row]);
        }
        shared.meet();
        velocity[self.bodies.clone()].fill([0.0; D]);
        for (row, body, block) in &*before {
            add(&mut velocity[*body as usize], board.x.get(*row as usize), block);
        }
        scatter_onto(self.pair, self.jacobian, x, velocity);
        for body in given.iter().map(|body| *body as usize) {
            board.velocity.put(D * body, &velocity[body]);
        }
        shared.meet();
        for body in taken.iter().map(|body| *body as usize) {
            velocity[body] = board.velocity.block(D * body);
        }
    }
}

impl<const D: usize> OnRows for Member<'_, D> {
    fn numbers(&self) -> Numbers<'_> {
        Numbers { diagonals: self.diagonals, q: self.q, compliance: self.compliance }
    }

    fn multiply(&mut self, x: &[f64], out: &mut [f64]) {
        self.find_velocities(x);
        along(self.pair, self.jacobian, &self.links.velocity, out);
    }

    fn minimize_pairs(&mut self, x: &[f64], slope: Option<(f64, &[f64])>, out: &mut [f64]) {
        self.blocks.minimize(x, slope, out);
    }

    fn join_chunks<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl FnMut(Range<usize>) -> [f64; N],
    ) -> [f64; N] {
        self.sums.join(start, join, chunk)
    }

    fn has_small_chunks(&self) -> bool {
        true
    }

    fn join_blocks<const N: usize>(
        &mut self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        mut chunk: impl FnMut(Range<usize>, &mut Blocks, &Numbers) -> [f64; N],
    ) -> [f64; N] {
        let numbers = Numbers { diagonals: self.diagonals, q: self.q, compliance: self.compliance };
        let mut blocks = self.blocks.chunks();
        let chunk = |rows| blocks.next().map_or(start, |blocks| chunk(rows, blocks, &numbers));
        self.sums.join(start, join, chunk)
    }

    fn multiply_and_join<const N: usize>(
        &mut self,
        x: &[f64],
        out: &mut [f64],
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        mut chunk: impl FnMut(Range<usize>, &Numbers, &mut [f64]) -> [f64; N],
    ) -> [f64; N] {
        self.find_velocities(x);
        let numbers = self.numbers();
        self.sums.join(start, join, |rows| {
            let out = &mut out[rows.clone()];
            along(&self.pair[rows.clone()], &self.jacobian[rows.clone()], &self.links.velocity, out);
            chunk(rows, &numbers, out)
        })
    }

    fn noted(&mut self) -> &mut Vec<f64> {
        &mut self.noted
    }

    fn made(&self) -> u64 {
        self.products
    }
}
