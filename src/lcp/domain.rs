//! A process's domain of a problem that several share: the rows of its bodies.
//!
//! A row between bodies of two processes is with both of them, so that each has all rows of its own bodies, and their
//! velocities `J^T x` are whole. A product takes one exchange: the velocities of bodies at the border go to the
//! processes that have rows with them. A number of all rows is what each process's rows come to, every row counted by
//! the owner of its first body, joined along the tree of all blocks: one exchange among all.
//!
//! The order of rows is that of all of them, restricted to the domain, so that every number has the bits that one
//! process alone would come to.

use super::loops::{Tree, branches};
use super::pair_blocks::sorted;
use super::product::Product;
use crate::processes::{Parcel, Processes};
use std::ops::Range;
use std::sync::Arc;

/// The bodies of a process, and those of others that it has rows with.
#[derive(Clone, Debug)]
pub struct Domain {
    /// The processes that share the problem.
    pub processes: Processes,
    /// The blocks of every process, one after the other.
    pub blocks: Vec<Range<usize>>,
    /// Where its own bodies stand among those that it knows.
    pub own: Range<usize>,
    /// Whose the body at each place is; those of walls are everybody's.
    pub owner: Vec<u32>,
    /// The place of each of them among all bodies.
    pub among_all: Vec<u32>,
    /// How many bodies there are, with the surfaces of walls, and the edges of the blocks, among all.
    pub bodies: usize,
    pub edges: Vec<u32>,
}

/// Numbers of bodies or rows that go to other processes, or come from them: for each the places.
pub(crate) type Route = Vec<(usize, Vec<u32>)>;

/// The rows of a domain.
#[derive(Clone, Debug)]
pub(super) struct Border {
    pub domain: Arc<Domain>,
    /// The rows that are counted here, all but the first ones.
    pub rows: Range<usize>,
    /// The number of the first of these among all, and how many there are.
    pub first: usize,
    pub all: usize,
    /// The numbers among all of the rows before.
    copies: Vec<u32>,
    /// Own bodies whose velocities others need, and others' bodies.
    pub out: Route,
    pub into: Route,
    /// The rows with bodies of others.
    pub across: Vec<u32>,
    /// The branches of the tree of sums that each process has whole.
    branches: Vec<Vec<u32>>,
}

/// From pairs of a process and a place, in any order.
pub(crate) fn route(mut places: Vec<(usize, u32)>) -> Route {
    places.sort_unstable();
    places.dedup();
    places.chunk_by(|a, b| a.0 == b.0).map(|of| (of[0].0, of.iter().map(|(_, place)| *place).collect())).collect()
}

impl Border {
    /// Of rows with these pairs of places, in their order.
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

    /// Learns the numbers of the rows that others count.
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

    /// The place here of a row that has this number among all, if it is here.
    pub fn row(&self, number: u32) -> Option<usize> {
        match (number as usize).checked_sub(self.first) {
            Some(row) if row < self.rows.len() => Some(self.rows.start + row),
            _ => self.copies.binary_search(&number).ok(),
        }
    }

    /// The number among all of a row.
    pub fn number(&self, row: usize) -> u32 {
        match row.checked_sub(self.rows.start) {
            Some(row) => (self.first + row) as u32,
            None => self.copies[row],
        }
    }

    /// Sends numbers of places to other processes, and takes theirs.
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

    /// `out = A x`. The rows of own bodies are made while the velocities of others are on their way.
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
        product.rows_anew(&self.across, out);
    }

    /// What the chunks of all processes come to, those of this one by `chunk`; `chunks` has one for each block of all.
    pub fn join_chunks<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl Fn(Range<usize>) -> [f64; N],
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

    /// What the counts of all processes come to.
    pub fn sum(&self, count: usize) -> usize {
        let mut all = vec![0_u64; self.domain.processes.size()];
        self.domain.processes.all_gather_even(&[count as u64], &mut all);
        all.into_iter().sum::<u64>() as usize
    }

    /// The numbers of all rows, from those of the rows that each process counts.
    pub fn all_gather(&self, own: &[u64]) -> Vec<u64> {
        self.domain.processes.all_gather(own)
    }
}
