//! The matrix `I + J^T H J` of a step, in blocks by body, and its sparse LU factors: `H` has one block per unit, which
//! is not symmetric.
//!
//! Columns hold a block for the body itself and for each body with which it shares a unit, by ascending index. The
//! pattern, and what is derived from it, is computed once per problem.

use super::scaled::{NONE, Scaled};
use crate::lcp::friction::cone::Triple;
use faer::MatMut;
use faer::prelude::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

/// The matrix and its factors.
#[derive(Default)]
pub(super) struct NormalMatrix<const D: usize> {
    /// The offset of each body's neighbours, itself among them, and the end.
    first: Vec<u32>,
    neighbour: Vec<u32>,
    /// The offset of each column, and the end; the row of each entry, and its value.
    column: Vec<u32>,
    entry: Vec<u32>,
    value: Vec<f64>,
    symbolic: Option<SymbolicLu<u32>>,
    factors: Option<Lu<u32, f64>>,
}

impl<const D: usize> NormalMatrix<D> {
    /// Computes the pattern for some units between bodies; says whether the matrix can be factorized.
    pub fn analyse(&mut self, units: &[Scaled<D>], bodies: usize) -> bool {
        let mut links: Vec<[u32; 2]> = (0..bodies as u32).map(|body| [body; 2]).collect();
        let moves = |pair: &[u32; 2]| !pair.contains(&NONE);
        links.extend(units.iter().map(|unit| unit.pair).filter(moves).flat_map(|[a, b]| [[a, b], [b, a]]));
        links.sort_unstable();
        links.dedup();
        (self.symbolic, self.factors) = (None, None);
        self.first.clear();
        self.first.resize(bodies + 1, 0);
        for [body, _] in &links {
            self.first[*body as usize + 1] += 1;
        }
        for body in 0..bodies {
            self.first[body + 1] += self.first[body];
        }
        self.neighbour.clear();
        self.neighbour.extend(links.iter().map(|[_, other]| *other));
        self.lay_out(bodies);
        let n = D * bodies;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.column, None, &self.entry);
        self.symbolic = SymbolicLu::try_new(pattern).ok();
        self.symbolic.is_some()
    }

    fn lay_out(&mut self, bodies: usize) {
        self.column.clear();
        self.entry.clear();
        for body in 0..bodies {
            let near = &self.neighbour[self.first[body] as usize..self.first[body + 1] as usize];
            for _ in 0..D {
                self.column.push(self.entry.len() as u32);
                self.entry.extend(near.iter().flat_map(|other| D as u32 * other..D as u32 * (other + 1)));
            }
        }
        self.column.push(self.entry.len() as u32);
        self.value.clear();
        self.value.resize(self.entry.len(), 0.0);
    }

    /// Factorizes for the block `H` of each unit; says whether it could.
    pub fn factorize(&mut self, units: &[Scaled<D>], weight: &[[Triple; 3]]) -> bool {
        self.value.fill(0.0);
        let bodies = self.first.len() - 1;
        for body in 0..bodies {
            let start = self.block(body as u32, body as u32);
            for (k, start) in start.into_iter().enumerate() {
                self.value[start + k] = 1.0;
            }
        }
        for (unit, weight) in units.iter().zip(weight) {
            for (side, other) in unit.bodies().flat_map(|(side, _)| unit.bodies().map(move |(other, _)| (side, other)))
            {
                self.add(unit, weight, side, other);
            }
        }
        let n = D * bodies;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &self.column, None, &self.entry);
        let matrix = SparseColMatRef::new(pattern, &self.value);
        let finite = self.value.iter().all(|value| value.is_finite());
        let factors =
            self.symbolic.clone().filter(|_| finite).map(|symbolic| Lu::try_new_with_symbolic(symbolic, matrix));
        self.factors = factors.and_then(Result::ok);
        self.factors.is_some()
    }

    /// Adds `J_side^T H J_other` of a unit.
    fn add(&mut self, unit: &Scaled<D>, weight: &[Triple; 3], side: usize, other: usize) {
        let start = self.block(unit.pair[side], unit.pair[other]);
        for (k, start) in start.iter().enumerate() {
            // `H J_other`, its column `k`.
            let along: Triple =
                std::array::from_fn(|i| (0..unit.count).map(|j| weight[i][j] * unit.rows[j][other][k]).sum());
            for i in 0..D {
                let part: f64 = (0..unit.count).map(|j| unit.rows[j][side][i] * along[j]).sum();
                self.value[start + i] += part;
            }
        }
    }

    /// Where the columns of the block of a row's and a column's body start.
    fn block(&self, row: u32, column: u32) -> [usize; D] {
        let near = &self.neighbour[self.first[column as usize] as usize..self.first[column as usize + 1] as usize];
        let place = near.partition_point(|body| *body < row);
        std::array::from_fn(|k| self.column[D * column as usize + k] as usize + D * place)
    }

    /// Solves with the last factors.
    pub fn solve(&self, v: &mut [[f64; D]]) {
        let Some(factors) = &self.factors else { return };
        let n = D * v.len();
        factors.solve_in_place(MatMut::from_column_major_slice_mut(v.as_flattened_mut(), n, 1));
    }
}
