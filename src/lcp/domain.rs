//! A process's domain of a distributed problem: the rows of its bodies.
//!
//! Both processes have a row between their bodies. So each has all rows of its own bodies and can compute their
//! velocities `J^T x`. A product takes one exchange: the velocities of bodies at the border go to the processes that
//! have rows with them. A reduction over all rows combines the partial results of processes along the tree of all
//! blocks in one gather; the owner of a row's first body counts the row.
//!
//! Rows have the global order, restricted to the domain, so every number has the bits of a run on one process.

use super::loops::{Tree, branches};
use super::pair_blocks::sorted;
use super::product::Product;
use crate::processes::{Parcel, Processes};
use std::ops::Range;
use std::sync::Arc;

/// The bodies of a process and of the others that it has rows with.
#[derive(Clone, Debug)]
pub struct Domain {
    /// The processes that share the problem.
    pub processes: Processes,
    /// The blocks of every process, one after the other.
    pub blocks: Vec<Range<usize>>,
    /// The positions of its own bodies among the local ones.
    pub own: Range<usize>,
    /// The process that owns the body at each position; walls belong to all.
    pub owner: Vec<u32>,
    /// The global position of each of them.
    pub among_all: Vec<u32>,
    /// How many bodies there are, with the surfaces of walls, and the edges of the blocks, among all.
    pub bodies: usize,
    pub edges: Vec<u32>,
}

/// Data of bodies or rows that is sent to other processes, or received from them: for each process the positions.
pub(crate) type Route = Vec<(usize, Vec<u32>)>;

/// The rows of a domain.
#[derive(Clone, Debug)]
pub(super) struct Border {
    pub domain: Arc<Domain>,
    /// The rows that are counted here, all but the first ones.
    pub rows: Range<usize>,
    /// The global index of the first of these, and the number of all rows.
    pub first: usize,
    pub all: usize,
    /// The global indices of the rows before.
    copies: Vec<u32>,
    /// Own bodies whose velocities others need, and others' bodies.
    pub out: Route,
    pub into: Route,
    /// The rows with bodies of others.
    pub across: Vec<u32>,
    /// For each process, the complete branches of the tree of sums that it has.
    branches: Vec<Vec<u32>>,
}

/// A route from pairs of a process and a position, in any order.
pub(crate) fn route(mut places: Vec<(usize, u32)>) -> Route {
    places.sort_unstable();
    places.dedup();
    places.chunk_by(|a, b| a.0 == b.0).map(|of| (of[0].0, of.iter().map(|(_, place)| *place).collect())).collect()
}

impl Border {
    /// The border of rows with these pairs of positions, in their order.
    pub fn new(domain: &Arc<Domain>, pair: &[[u32; 2]]) -> Self {
        let Domain { processes, own, owner, blocks, .. } = &**domain;
        let rank = processes.rank();
        let begin = pair.partition_point(|pair| (sorted(*pair)[0] as usize) < own.start);
        let counts = processes.all_gather(&[(pair.len() - begin) as u64]);
        let first = counts[..rank].iter().sum::<u64>() as usize;
        let all = counts.iter().sum::<u64>() as usize;
        let is_own = |place: u32| own.contains(&(place as usize));
        let is_body = |place: u32| owner[place as usize] != u32::MAX;
        let (mut out, mut into, mut across) = (Vec::new(), Vec::new(), Vec::new());
        for (row, pair) in (0..).zip(pair) {
            let (near, far) = if is_own(pair[0]) { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
            if is_body(far) && !is_own(far) {
                let other = owner[far as usize] as usize;
                out.push((other, near));
                into.push((other, far));
                across.push(row);
            }
        }
        let branches = blocks.iter().map(|blocks| branches(blocks.clone())).collect();
        let (out, into) = (route(out), route(into));
        let mut border = Border {
            domain: domain.clone(),
            rows: begin..pair.len(),
            first,
            all,
            copies: Vec::new(),
            out,
            into,
            across,
            branches,
        };
        border.number_copies(pair);
        border
    }

    /// Receives the global indices of the rows that others count.
    fn number_copies(&mut self, pair: &[[u32; 2]]) {
        let owner = &self.domain.owner;
        let other = |row: &u32, side: usize| owner[sorted(pair[*row as usize])[side] as usize] as usize;
        let counted = |row: &&u32| **row as usize >= self.rows.start;
        let out = route(self.across.iter().filter(counted).map(|row| (other(row, 1), *row)).collect());
        let into = route((0..self.rows.start as u32).map(|row| (other(&row, 0), row)).collect());
        let mut copies = vec![0; self.rows.start];
        let number = |row: u32| [f64::from((self.first + row as usize - self.rows.start) as u32)];
        self.exchange(&out, &into, number, |row, [number]| copies[row as usize] = number as u32);
        self.copies = copies;
    }

    /// The local row with this global index, if there is one.
    pub fn row(&self, number: u32) -> Option<usize> {
        match (number as usize).checked_sub(self.first) {
            Some(row) if row < self.rows.len() => Some(self.rows.start + row),
            _ => self.copies.binary_search(&number).ok(),
        }
    }

    /// The global index of a row.
    pub fn number(&self, row: usize) -> u32 {
        match row.checked_sub(self.rows.start) {
            Some(row) => (self.first + row) as u32,
            None => self.copies[row],
        }
    }

    /// Exchanges values of bodies or rows with other processes.
    pub fn exchange<const N: usize>(
        &self,
        out: &Route,
        into: &Route,
        get: impl Fn(u32) -> [f64; N],
        mut put: impl FnMut(u32, [f64; N]),
    ) {
        let pack = |(to, places): &(usize, Vec<u32>)| (*to, places.iter().flat_map(|place| get(*place)).collect());
        let sent: Vec<Parcel> = out.iter().map(pack).collect();
        let room = |(from, places): &(usize, Vec<u32>)| (*from, vec![0.0; N * places.len()]);
        let mut taken: Vec<Parcel> = into.iter().map(room).collect();
        self.domain.processes.exchange(&sent, &mut taken, || {});
        for ((_, places), (_, numbers)) in into.iter().zip(&taken) {
            places.iter().zip(numbers.as_chunks::<N>().0).for_each(|(place, numbers)| put(*place, *numbers));
        }
    }

    /// `out = A x`. The rows of own bodies are computed while the velocities of others are in transit.
    pub fn multiply<const D: usize>(&self, product: &mut Product<D>, x: &[f64], out: &mut [f64]) {
        let velocity = product.velocities(x);
        let pack = |places: &[u32]| places.iter().flat_map(|place| velocity[*place as usize]).collect();
        let sent: Vec<Parcel> = self.out.iter().map(|(to, places)| (*to, pack(places))).collect();
        let room = |(from, places): &(usize, Vec<u32>)| (*from, vec![0.0; D * places.len()]);
        let mut taken: Vec<Parcel> = self.into.iter().map(room).collect();
        self.domain.processes.exchange(&sent, &mut taken, || product.rows(out));
        let velocity = product.last_velocities();
        for ((_, places), (_, numbers)) in self.into.iter().zip(&taken) {
            let numbers = numbers.as_chunks::<D>().0;
            places.iter().zip(numbers).for_each(|(place, numbers)| velocity[*place as usize] = *numbers);
        }
        product.recompute_rows(&self.across, out);
    }

    /// Reduces the chunks of all processes; `chunk` computes those of this one, and `chunks` has one for each block.
    pub fn join_chunks<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        mut chunk: impl FnMut(Range<usize>) -> [f64; N],
        chunks: impl Iterator<Item = Range<usize>>,
    ) -> [f64; N] {
        let Domain { processes, blocks, .. } = &*self.domain;
        let mut chunks = chunks.skip(blocks[processes.rank()].start);
        let most = self.branches.iter().map(Vec::len).max().unwrap_or(0);
        let mut own = vec![0.0; N * most];
        for (level, value) in self.branches[processes.rank()].iter().zip(own.as_chunks_mut::<N>().0) {
            let mut branch = Tree::new(&join);
            chunks.by_ref().take(1 << level).for_each(|rows| branch.add(chunk(rows), 0));
            *value = branch.end(start);
        }
        let mut all = vec![0.0; N * most * processes.size()];
        processes.all_gather_even(&own, &mut all);
        let mut tree = Tree::new(join);
        for (levels, values) in self.branches.iter().zip(all.chunks(N * most)) {
            levels.iter().zip(values.as_chunks::<N>().0).for_each(|(level, value)| tree.add(*value, *level));
        }
        tree.end(start)
    }

    /// The sum of the counts of all processes.
    pub fn sum(&self, count: usize) -> usize {
        let mut all = vec![0_u64; self.domain.processes.size()];
        self.domain.processes.all_gather_even(&[count as u64], &mut all);
        all.into_iter().sum::<u64>() as usize
    }

    /// Gathers the values of all rows from those that each process counts.
    pub fn all_gather(&self, own: &[u64]) -> Vec<u64> {
        self.domain.processes.all_gather(own)
    }
}
