//! The vector verbs on the CPU, in f64, on one thread. Problems are loaded on all.
//!
//! Bodies are reordered: by position in space if a step sets it ([`Places`]), otherwise by shared rows
//! (`lcp::numbering`). Rows are reordered too: by [`pair_blocks::order`] within chunks of rows with near bodies. So the
//! rows of a pair are adjacent, adjacent rows share bodies, and each thread takes some chunks (`lcp::team`). The rows
//! of the paper's method keep the order of their bodies and form one chunk.
//!
//! If several processes solve a problem, each has a portion (`lcp::portion`).

use super::clusters::Clusters;
use super::cone::{admit, worse};
use super::incidence::Incidence;
use super::loops::{Chunks, LEAST_ROWS_A_TASK};
use super::numbering;
use super::on_rows::{Diagonals, Numbers, OnRows};
use super::pair_blocks::{self, Blocks, PairBlocks};
use super::portion::{Alone, Portion};
use super::product::{Product, ZERO_ROW};
use super::verbs::InClusters;
use super::{Places, Problem};
use rayon::prelude::*;
use std::ops::Range;

/// Rows per chunk of a sum: few enough that each of several threads has some chunks in a problem of a thousand rows.
const CHUNK: usize = 256;

/// The largest number of chunks: enough for the threads of any machine.
const MOST_CHUNKS: usize = 128;

/// Rows per chunk for the rows of the paper's method, whose sums keep their bits.
const CHUNK_OF_PARALLEL_ROWS: usize = 4_096;

/// The diagonals of a problem.
#[derive(Clone, Debug, Default)]
struct OwnDiagonals {
    plain: Vec<f64>,
    /// `1 / plain`, zero for zero rows.
    inverse: Vec<f64>,
    /// Empty until [`Cpu::find_majorant`].
    majorant: Vec<f64>,
    inverse_majorant: Vec<f64>,
}

impl OwnDiagonals {
    fn all(&self) -> Diagonals<'_> {
        let OwnDiagonals { plain, inverse, majorant, inverse_majorant } = self;
        Diagonals { plain, inverse, majorant, inverse_majorant }
    }
}

/// A problem prepared for the solvers. Its buffers are reused for the next problem.
#[derive(Clone, Debug, Default)]
pub struct Cpu<const D: usize, P = Alone> {
    /// Each row's index in the problem.
    pub(super) order: Vec<u32>,
    q: Vec<f64>,
    diagonals: OwnDiagonals,
    /// `A` gets this part of its diagonal added.
    compliance: f64,
    product: Product<D>,
    blocks: PairBlocks,
    chunks: Chunks,
    parallel_rows: bool,
    products: u64,
    noted: Vec<f64>,
    /// Computed on first use.
    clusters: Option<Clusters<D>>,
    /// The body order, if a step sets it.
    places: Option<Places>,
    finite: bool,
    /// The portion of the problem that these rows are.
    pub(super) portion: P,
}

impl<const D: usize, P: Portion<D>> Cpu<D, P> {
    /// A problem with many nearly parallel rows.
    pub(crate) fn for_parallel_rows() -> Self {
        Cpu { parallel_rows: true, ..Cpu::default() }
    }

    /// Loads a problem: sorts its rows by pair and copies them.
    pub fn rebuild(&mut self, problem: &Problem<D>) {
        let mut place = Vec::new();
        let numbered: Vec<[u32; 2]>;
        let (pair, blocks);
        if self.parallel_rows {
            pair_blocks::order(&problem.pair, &mut self.order);
            (pair, blocks) = (&problem.pair, Chunks::of_rows(problem.pair.len(), problem.pair.len().max(1)));
            self.chunks = Chunks::of_rows(problem.pair.len(), CHUNK_OF_PARALLEL_ROWS);
        } else {
            let given = self.places.as_ref().filter(|places| places.place.len() == problem.bodies);
            let place = match given {
                Some(places) => &places.place,
                None => {
                    numbering::rebuild(problem.bodies, &problem.pair, &problem.jacobian, &mut place);
                    &place
                }
            };
            let pairs = problem.pair.par_iter().with_min_len(LEAST_ROWS_A_TASK);
            numbered = pairs.map(|pair| pair.map(|body| place[body as usize])).collect();
            self.chunks = match given {
                Some(places) => pair_blocks::order_in_blocks(&numbered, &places.blocks, &mut self.order),
                None => {
                    let size = CHUNK.max(numbered.len().div_ceil(MOST_CHUNKS));
                    pair_blocks::order_in_chunks(&numbered, size, &mut self.order)
                }
            };
            (pair, blocks) = (&numbered, self.chunks.clone());
        }
        self.q.clear();
        self.q.extend(self.order.iter().map(|row| problem.q[*row as usize]));
        self.product.rebuild(problem.bodies, pair, &problem.jacobian, &self.order);
        self.diagonals.plain = self.product.diagonal();
        self.portion.take(self.product.pair(), problem.bodies);
        let (largest, finite) = self.survey();
        self.finite = finite;
        let zero = ZERO_ROW * largest;
        let live: Vec<bool> = self.diagonals.plain.iter().map(|s| *s > zero).collect();
        let inverse = |(s, live): (&f64, &bool)| if *live { 1.0 / s } else { 0.0 };
        self.diagonals.inverse = self.diagonals.plain.iter().zip(&live).map(inverse).collect();
        self.diagonals.majorant.clear();
        self.diagonals.inverse_majorant.clear();
        self.blocks.rebuild(self.product.pair(), self.product.jacobian(), &live, &blocks);
        self.compliance = 0.0;
        self.products = 0;
        self.noted.clear();
        self.clusters = None;
    }

    /// Computes [`Metric::Majorant`](super::verbs::Metric::Majorant) for this problem; only one solver needs it.
    pub fn find_majorant(&mut self) {
        self.diagonals.majorant = self.product.majorant();
        let inverse = |(w, inverse): (&f64, &f64)| if *inverse == 0.0 { 0.0 } else { 1.0 / w };
        self.diagonals.inverse_majorant =
            self.diagonals.majorant.iter().zip(&self.diagonals.inverse).map(inverse).collect();
    }

    /// Adds this part of its diagonal to `A`, until the next problem, so that contradictory rows have a solution. The
    /// small problems of pairs, which only guide an iteration, stay unchanged.
    pub fn set_compliance(&mut self, compliance: f64) {
        self.compliance = compliance;
    }

    /// The part of the diagonal that is added to `A`.
    pub fn compliance(&self) -> f64 {
        self.compliance
    }

    /// The largest violation that the compliance allows at these multipliers, a length.
    pub fn compliance_violation(&self, x: &[f64]) -> f64 {
        let moved = self.diagonals.plain.iter().zip(x).map(|(s, x)| s * x);
        self.compliance * moved.fold(0.0, worse)
    }

    /// Whether every number of the problem is finite, and so is the diagonal.
    pub fn is_finite(&self) -> bool {
        self.finite
    }

    /// Sets the body order and this process's portion for subsequent problems. It does not apply to problems with
    /// another number of bodies.
    pub(crate) fn place(&mut self, places: Places, portion: P) {
        (self.places, self.portion) = (Some(places), portion);
    }

    /// The position of each body in the order that a step sets, where this process has all rows.
    pub(super) fn positions(&self, bodies: usize) -> Option<&[u32]> {
        let given = self.places.as_ref().filter(|places| places.place.len() == bodies && self.portion.is_alone(bodies));
        given.map(|places| places.place.as_slice())
    }

    /// The largest entry of the diagonal, and whether it and all offsets are finite.
    fn survey(&self) -> (f64, bool) {
        let largest = self.diagonals.plain.iter().fold(0.0, |largest: f64, s| largest.max(*s));
        let finite = self.q.iter().chain(&self.diagonals.plain).all(|number| number.is_finite());
        self.portion.survey((largest, finite))
    }

    /// Each row's index in the problem.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Reorders multipliers from the problem's order to this one's; invalid ones become zero.
    pub fn import(&self, gamma: &[f64], x: &mut Vec<f64>) {
        x.clear();
        x.extend(self.order.iter().map(|row| admit(gamma[*row as usize])));
    }

    /// Reorders a vector to the problem's order of rows.
    pub fn export(&self, x: &[f64], gamma: &mut [f64]) {
        for (row, x) in self.order.iter().zip(x) {
            gamma[*row as usize] = *x;
        }
    }

    /// The rows, for solvers that visit them one by one.
    pub(crate) fn rows(&self) -> Rows<'_, D> {
        let (diagonal, inverse) = (&self.diagonals.plain, &self.diagonals.inverse);
        Rows { pair: self.product.pair(), jacobian: self.product.jacobian(), q: &self.q, diagonal, inverse }
    }

    /// The rows of each body.
    pub(crate) fn incidence(&self) -> &Incidence {
        self.product.incidence()
    }

    /// Counts products from zero.
    pub(crate) fn restart_count(&mut self) {
        self.products = 0;
    }

    /// Products computed since the problem was loaded.
    pub(crate) fn products_made(&self) -> u64 {
        self.products
    }

    /// Counts work like that of `n` products.
    pub(crate) fn count(&mut self, n: u64) {
        self.products += n;
    }

    /// The number of rows of the whole problem.
    pub(crate) fn all_rows(&self) -> usize {
        self.portion.all_rows(self.q.len())
    }

    /// The problem, to be shared by several threads.
    pub(super) fn whole(&mut self) -> Whole<'_, D> {
        Whole {
            diagonals: self.diagonals.all(),
            q: &self.q,
            compliance: self.compliance,
            pair: self.product.pair(),
            jacobian: self.product.jacobian(),
            incidence: self.product.incidence(),
            blocks: Some(self.blocks.whole()),
            chunks: &self.chunks,
            products: self.products,
            noted: std::mem::take(&mut self.noted),
        }
    }

    /// Restores the recorded residuals.
    pub(super) fn put_back(&mut self, noted: Vec<f64>) {
        self.noted = noted;
    }

    fn diagonals(&self) -> Diagonals<'_> {
        self.diagonals.all()
    }
}

/// The rows of a problem sorted by pair.
pub(crate) struct Rows<'a, const D: usize> {
    pub pair: &'a [[u32; 2]],
    pub jacobian: &'a [[[f64; D]; 2]],
    pub q: &'a [f64],
    /// `A_ii`.
    pub diagonal: &'a [f64],
    /// `1 / A_ii`, zero for zero rows.
    pub inverse: &'a [f64],
}

/// A problem that several threads share: all read all of it, except the blocks, of which each has its own part.
pub(super) struct Whole<'a, const D: usize> {
    pub diagonals: Diagonals<'a>,
    pub q: &'a [f64],
    pub compliance: f64,
    pub pair: &'a [[u32; 2]],
    pub jacobian: &'a [[[f64; D]; 2]],
    pub incidence: &'a Incidence,
    /// The blocks that no member has taken.
    pub blocks: Option<pair_blocks::Part<'a>>,
    pub chunks: &'a Chunks,
    /// Products computed so far, and recorded residuals that were not read yet.
    pub products: u64,
    pub noted: Vec<f64>,
}

impl<const D: usize, P: Portion<D>> OnRows for Cpu<D, P> {
    fn numbers(&self) -> Numbers<'_> {
        Numbers { diagonals: self.diagonals(), q: &self.q, compliance: self.compliance }
    }

    fn multiply(&mut self, x: &[f64], out: &mut [f64]) {
        self.products += 1;
        self.portion.multiply(&mut self.product, x, out);
    }

    fn minimize_pairs(&mut self, x: &[f64], slope: Option<(f64, &[f64])>, out: &mut [f64]) {
        self.blocks.whole().minimize(x, slope, out);
    }

    fn join_chunks<const N: usize>(
        &self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        chunk: impl FnMut(Range<usize>) -> [f64; N],
    ) -> [f64; N] {
        self.portion.join_chunks(start, join, chunk, &self.chunks)
    }

    fn has_small_chunks(&self) -> bool {
        !self.parallel_rows && self.portion.has_threads()
    }

    fn join_blocks<const N: usize>(
        &mut self,
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        mut chunk: impl FnMut(Range<usize>, &mut Blocks, &Numbers) -> [f64; N],
    ) -> [f64; N] {
        let numbers = Numbers { diagonals: self.diagonals.all(), q: &self.q, compliance: self.compliance };
        let mut blocks = self.blocks.chunks();
        let chunk = |rows| blocks.next().map_or(start, |blocks| chunk(rows, blocks, &numbers));
        self.portion.join_chunks(start, join, chunk, &self.chunks)
    }

    fn multiply_and_join<const N: usize>(
        &mut self,
        x: &[f64],
        out: &mut [f64],
        start: [f64; N],
        join: impl Fn(usize, f64, f64) -> f64,
        mut chunk: impl FnMut(Range<usize>, &Numbers, &mut [f64]) -> [f64; N],
    ) -> [f64; N] {
        self.products += 1;
        let numbers = Numbers { diagonals: self.diagonals.all(), q: &self.q, compliance: self.compliance };
        self.product.velocities(x);
        let chunk = |rows: Range<usize>| {
            let out = &mut out[rows.clone()];
            self.product.rows_of(rows.clone(), out);
            chunk(rows, &numbers, out)
        };
        self.portion.join_chunks(start, join, chunk, &self.chunks)
    }

    fn noted(&mut self) -> &mut Vec<f64> {
        &mut self.noted
    }

    fn made(&self) -> u64 {
        self.products
    }
}

impl<const D: usize, P: Portion<D>> InClusters for Cpu<D, P> {
    fn descend_in_clusters(
        &mut self,
        condition: f64,
        [x, g]: [&Vec<f64>; 2],
        tolerance: f64,
        by_pairs: &Vec<f64>,
        out: &mut Vec<f64>,
    ) {
        out.clone_from(by_pairs);
        if condition > 0.0 {
            let bodies = self.incidence().start.len() - 1;
            let mut clusters = self.clusters.take().unwrap_or_else(|| Clusters::new(bodies, &self.rows()));
            clusters.descend(x, g, &self.diagonals.plain, tolerance, out);
            self.clusters = Some(clusters);
        }
    }
}
