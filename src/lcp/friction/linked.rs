//! Free rows that are solved together ([`Cone::Linked`](super::Cone)): their block of `A`, with the compliances on its
//! diagonal, and its sparse Cholesky factor.
//!
//! A chain of bodies that resist bends is a beam, whose matrix has a condition number that grows with the fourth power
//! of the number of its bodies: iterations over pairs take thousands of products for 50 bodies, and do not converge in
//! f64 for many more. The factor of a chain is as sparse as the chain.

use super::unit::Unit;
use crate::lcp::product::{Product, dot};
use crate::lcp::sparse_cholesky::{Pattern, SparseCholesky};
use faer::sparse::linalg::cholesky::CholeskySymbolicParams;
use std::collections::BTreeMap;

/// All bodies that do not move, in place of an index.
const STILL: u32 = u32::MAX;

/// Addition to the diagonal, as a part of each entry: rows of a loop say the same twice, and their matrix alone has no
/// factor. The iterations correct it.
const REGULARIZATION: f64 = 1e-11;

/// The same where the bodies of rows form loops, whose rows may say the same twice. Of ten loops of rigid hinges and
/// welds none is solved with 1e-11, eight with 1e-7, nine with 1e-6 and all with 1e-5. A chain of 50 rigid rods, which
/// has no loop, takes 96, 129 and 558 products in 20 steps with 1e-11, 1e-7 and 1e-5.
const REGULARIZATION_OF_LOOPS: f64 = 1e-5;

/// The largest number of entries of the block and of its factor; with more, rows are solved pair by pair.
const MOST_ENTRIES: usize = 20_000_000;

/// The block of the rows that are solved together; none where there are no such rows, or it has no factor.
#[derive(Default)]
pub(super) struct Linked {
    /// The rows, by their places in the solver's order.
    rows: Vec<usize>,
    /// The lower triangle: the offset of each column and the end, the row of each entry, and its value.
    column: Vec<u32>,
    entry: Vec<u32>,
    value: Vec<f64>,
    cholesky: SparseCholesky,
    /// Whether there is a factor.
    is_factorized: bool,
    right: Vec<f64>,
}

impl Linked {
    /// Whether the rows of linked units are solved here.
    pub fn is_some(&self) -> bool {
        self.is_factorized
    }

    /// Takes the rows of a problem.
    pub fn rebuild<const D: usize>(&mut self, product: &Product<D>, units: &[Unit], compliance: &[f64]) {
        self.rows.clear();
        self.rows.extend(units.iter().filter(|unit| unit.linked && unit.live).map(|unit| unit.rows().start));
        // Without a factor the rows are solved pair by pair.
        self.is_factorized = !self.rows.is_empty() && self.fill(product, compliance) && self.factorize();
    }

    /// Makes the block; `false` where it is too large.
    fn fill<const D: usize>(&mut self, product: &Product<D>, compliance: &[f64]) -> bool {
        let (pair, jacobian) = (product.pair(), product.jacobian());
        let moves = |row: usize, side: usize| jacobian[row][side].iter().any(|number| *number != 0.0);
        // The rows of each body, by their places among those here.
        let mut of_body: Vec<(u32, u32)> = Vec::new();
        for (place, row) in (0..).zip(&self.rows) {
            of_body.extend((0..2).filter(|side| moves(*row, *side)).map(|side| (pair[*row][side], place)));
        }
        of_body.sort_unstable();
        let rows_of = |body: u32| {
            let (start, end) = (of_body.partition_point(|of| of.0 < body), of_body.partition_point(|of| of.0 <= body));
            &of_body[start..end]
        };
        self.column.clear();
        self.entry.clear();
        self.value.clear();
        let added = if self.has_loops(product) { REGULARIZATION_OF_LOOPS } else { REGULARIZATION };
        let mut below: Vec<u32> = Vec::new();
        for (place, row) in (0..).zip(&self.rows) {
            self.column.push(self.entry.len() as u32);
            below.clear();
            below.push(place);
            for side in (0..2).filter(|side| moves(*row, *side)) {
                below.extend(rows_of(pair[*row][side]).iter().map(|of| of.1).filter(|other| *other > place));
            }
            below.sort_unstable();
            below.dedup();
            if self.entry.len() + below.len() > MOST_ENTRIES {
                return false;
            }
            for other in &below {
                let with = self.rows[*other as usize];
                let sides = [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter();
                let shared = sides.filter(|(own, its)| pair[*row][*own] == pair[with][*its]);
                let mut value: f64 = shared.map(|(own, its)| dot(&jacobian[*row][own], &jacobian[with][its])).sum();
                if *other == place {
                    value = (value + compliance[*row]) * (1.0 + added);
                }
                self.entry.push(*other);
                self.value.push(value);
            }
        }
        self.column.push(self.entry.len() as u32);
        true
    }

    /// Whether rows join bodies that others join already, or two bodies have more rows than unknowns. Bodies that do
    /// not move count as one.
    fn has_loops<const D: usize>(&self, product: &Product<D>) -> bool {
        let (pair, jacobian) = (product.pair(), product.jacobian());
        let mut rows_of: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for row in &self.rows {
            let place = |side: usize| {
                let moves = jacobian[*row][side].iter().any(|number| *number != 0.0);
                if moves { pair[*row][side] } else { STILL }
            };
            let [a, b] = [place(0), place(1)];
            *rows_of.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
        // The bodies that are joined to each other, by one of them.
        let mut joined: BTreeMap<u32, u32> = BTreeMap::new();
        let root = |joined: &BTreeMap<u32, u32>, mut body: u32| {
            while let Some(next) = joined.get(&body) {
                body = *next;
            }
            body
        };
        rows_of.into_iter().any(|([a, b], rows)| {
            let (a, b) = (root(&joined, a), root(&joined, b));
            if a != b {
                joined.insert(a, b);
            }
            a == b || rows > D
        })
    }

    /// Computes the factor of the block; says whether it has one.
    fn factorize(&mut self) -> bool {
        let pattern = Pattern { column: &self.column, entry: &self.entry };
        self.cholesky.analyse(pattern, CholeskySymbolicParams::default(), MOST_ENTRIES)
            && self.cholesky.factorize(pattern, &self.value)
    }

    /// `out = x - B^-1 g` of its rows, with the block `B`.
    pub fn descend(&mut self, x: &[f64], g: &[f64], out: &mut [f64]) {
        if !self.is_factorized {
            return;
        }
        self.right.clear();
        self.right.extend(self.rows.iter().map(|row| g[*row]));
        self.cholesky.solve(&mut self.right);
        for (row, step) in self.rows.iter().zip(&self.right) {
            out[*row] = x[*row] - step;
        }
    }

    /// `out = w` of its rows: all numbers are multipliers.
    pub fn project(&self, w: &[f64], out: &mut [f64]) {
        self.rows.iter().for_each(|row| out[*row] = w[*row]);
    }
}
