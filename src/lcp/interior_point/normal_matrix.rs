//! The matrix `I + J^T W J` of an iteration, in blocks by body, and its sparse Cholesky factor.
//!
//! Its pattern is that of the pairs, so the ordering (approximate minimum degree) and the pattern of the factor are
//! computed once per solve. Columns hold the lower triangle: a body's own block, then one block for each later body
//! with which it shares a row.

use super::rows::UnitRows;
use crate::lcp::sparse_cholesky::{Pattern, SparseCholesky, minimum_degree};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw};

/// Marks a row with a zero block, which connects no bodies.
const NONE: u32 = u32::MAX;

/// Why there is no factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refused {
    /// The factor or the matrix would exceed its limit, or memory could not be allocated.
    TooLarge,
    /// A pivot was not positive: a number is not finite, or its magnitude is extreme.
    NotPositive,
}

/// The matrix, its factor, and scratch space for solves.
#[derive(Default)]
pub(super) struct NormalMatrix<const D: usize> {
    /// Distinct pairs of body indices, the smaller index first, ascending.
    links: Vec<[u32; 2]>,
    /// The offset of each body's links, and the end.
    first_link: Vec<u32>,
    /// Each row's link.
    link: Vec<u32>,
    /// The offset of each column, and the end.
    column: Vec<u32>,
    /// The row of each entry, and its value.
    entry: Vec<u32>,
    value: Vec<f64>,
    cholesky: SparseCholesky,
    /// The number of factorizations; the owner resets it.
    pub factorizations: u64,
}

impl<const D: usize> NormalMatrix<D> {
    /// Computes the patterns for some rows. Neither the matrix nor the factor may have more than `largest` entries.
    pub fn analyse(&mut self, rows: &mut UnitRows<D>, largest: usize) -> Result<(), Refused> {
        self.cholesky.forget();
        self.find_links(rows);
        self.order(rows)?;
        let entries = rows.bodies * (D * (D + 1) / 2) + self.links.len() * D * D;
        if entries > largest {
            return Err(Refused::TooLarge);
        }
        self.lay_out(rows.bodies, entries);
        // Blocks of D columns share a pattern: on 256 rods, 1,024 rods and 144 rings factors of dense panels take a
        // third of the time of others, and no more on larger systems.
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let pattern = Pattern { column: &self.column, entry: &self.entry };
        if self.cholesky.analyse_in_order(pattern, parameters, largest) { Ok(()) } else { Err(Refused::TooLarge) }
    }

    /// Numbers the bodies in an order of elimination with little fill. A body's unknowns stay together, so the order is
    /// that of a graph of bodies, and the factorization need not permute the matrix again.
    fn order(&mut self, rows: &mut UnitRows<D>) -> Result<(), Refused> {
        let neighbours: Vec<u32> = self.links.iter().map(|[_, high]| *high).collect();
        let graph = Pattern { column: &self.first_link, entry: &neighbours };
        rows.renumber(&minimum_degree(graph).ok_or(Refused::TooLarge)?);
        self.find_links(rows);
        Ok(())
    }

    /// Whether there is a factor's pattern.
    pub fn is_analysed(&self) -> bool {
        self.cholesky.symbolic().is_some()
    }

    fn find_links(&mut self, rows: &UnitRows<D>) {
        let joined = |row: usize| {
            let zero = |block: &[f64; D]| block.iter().all(|number| *number == 0.0);
            let [a, b] = rows.pair[row];
            (!rows.jacobian[row].iter().any(zero)).then_some([a.min(b), a.max(b)])
        };
        self.links.clear();
        self.links.extend((0..rows.len()).filter_map(joined));
        self.links.sort_unstable();
        self.links.dedup();
        self.link.clear();
        let find = |pair: [u32; 2]| self.links.binary_search(&pair).map_or(NONE, |link| link as u32);
        self.link.extend((0..rows.len()).map(|row| joined(row).map_or(NONE, find)));
        self.first_link.clear();
        self.first_link.resize(rows.bodies + 1, 0);
        for [low, _] in &self.links {
            self.first_link[*low as usize + 1] += 1;
        }
        for body in 0..rows.bodies {
            self.first_link[body + 1] += self.first_link[body];
        }
    }

    fn lay_out(&mut self, bodies: usize, entries: usize) {
        self.column.clear();
        self.entry.clear();
        self.value.clear();
        self.value.resize(entries, 0.0);
        for body in 0..bodies {
            let links = &self.links[self.first_link[body] as usize..self.first_link[body + 1] as usize];
            for k in 0..D {
                self.column.push(self.entry.len() as u32);
                self.entry.extend((D * body + k..D * (body + 1)).map(|entry| entry as u32));
                self.entry.extend(links.iter().flat_map(|[_, high]| D as u32 * high..D as u32 * (high + 1)));
            }
        }
        self.column.push(self.entry.len() as u32);
    }

    /// An estimate of the multiplications of a factorization: the squares of the factor's column lengths. Zero before
    /// the analysis.
    pub fn work(&self) -> f64 {
        let square = |length: usize| (length as f64).powi(2);
        match self.cholesky.symbolic().map(SymbolicCholesky::raw) {
            None => 0.0,
            Some(SymbolicCholeskyRaw::Simplicial(factor)) => {
                factor.col_ptr().windows(2).map(|bounds| square((bounds[1] - bounds[0]) as usize)).sum()
            }
            Some(SymbolicCholeskyRaw::Supernodal(factor)) => (0..factor.n_supernodes())
                .map(|node| {
                    let columns = (factor.supernode_end()[node] - factor.supernode_begin()[node]) as usize;
                    let bounds = &factor.col_ptr_for_row_idx()[node..node + 2];
                    let below = (bounds[1] - bounds[0]) as usize;
                    (1..=columns).map(|column| square(below + column)).sum::<f64>()
                })
                .sum(),
        }
    }

    /// Factorizes for some weights of the rows.
    pub fn factorize(&mut self, rows: &UnitRows<D>, weight: &[f64]) -> Result<(), Refused> {
        if self.cholesky.symbolic().is_none() {
            return Err(Refused::TooLarge);
        }
        self.fill(rows, weight);
        self.factorizations += 1;
        let pattern = Pattern { column: &self.column, entry: &self.entry };
        if self.cholesky.factorize(pattern, &self.value) { Ok(()) } else { Err(Refused::NotPositive) }
    }

    fn fill(&mut self, rows: &UnitRows<D>, weight: &[f64]) {
        self.value.fill(0.0);
        for body in 0..rows.bodies {
            for k in 0..D {
                self.value[self.column[D * body + k] as usize] = 1.0;
            }
        }
        for (row, weight) in weight.iter().enumerate() {
            let ([a, b], [ja, jb]) = (rows.pair[row], &rows.jacobian[row]);
            self.add_own(a as usize, ja, *weight);
            self.add_own(b as usize, jb, *weight);
            if self.link[row] != NONE {
                let (low, j_low, j_high) = if a < b { (a, ja, jb) } else { (b, jb, ja) };
                let below = D * (self.link[row] - self.first_link[low as usize]) as usize;
                for (k, number) in j_low.iter().enumerate() {
                    let start = self.column[D * low as usize + k] as usize + D - k + below;
                    let scaled = weight * number;
                    for (value, number) in self.value[start..start + D].iter_mut().zip(j_high) {
                        *value += scaled * number;
                    }
                }
            }
        }
    }

    fn add_own(&mut self, body: usize, block: &[f64; D], weight: f64) {
        for k in 0..D {
            let start = self.column[D * body + k] as usize;
            let scaled = weight * block[k];
            for (value, number) in self.value[start..start + D - k].iter_mut().zip(&block[k..]) {
                *value += scaled * number;
            }
        }
    }

    /// Solves with the last factor.
    pub fn solve(&mut self, v: &mut [[f64; D]]) {
        self.cholesky.solve(v.as_flattened_mut());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lcp::cpu::Cpu;
    use crate::lcp::{Problem, product::dot};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn rows<const D: usize>(bodies: u32, count: usize) -> UnitRows<D> {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut problem = Problem::<D> { bodies: bodies as usize, q: vec![0.0; count], ..Problem::default() };
        for row in 0..count {
            let a = rng.random_range(0..bodies);
            let b = (a + rng.random_range(1..bodies)) % bodies;
            problem.pair.push([a, b]);
            let mut block = || std::array::from_fn(|_| rng.random::<f64>() - 0.5);
            // Some bodies do not move.
            problem.jacobian.push([block(), if row % 5 == 0 { [0.0; D] } else { block() }]);
        }
        let mut cpu = Cpu::<D>::default();
        cpu.rebuild(&problem);
        let mut rows = UnitRows::default();
        rows.rebuild(&cpu.rows());
        rows
    }

    fn solutions_solve<const D: usize>(bodies: u32, count: usize) {
        let mut rows = rows::<D>(bodies, count);
        let weight: Vec<f64> = (0..count).map(|row| [1e-6, 1.0, 30.0][row % 3]).collect();
        let mut matrix = NormalMatrix::default();
        assert_eq!(matrix.analyse(&mut rows, 1 << 20), Ok(()));
        assert_eq!(matrix.factorize(&rows, &weight), Ok(()));
        let right: Vec<[f64; D]> = (0..rows.bodies).map(|i| std::array::from_fn(|k| (i * D + k) as f64)).collect();
        let mut v = right.clone();
        matrix.solve(&mut v);
        let mut back = Vec::new();
        let pull: Vec<f64> = (0..count).map(|row| weight[row] * rows.along(row, &v)).collect();
        rows.velocity(&pull, &mut back);
        let size = right.iter().map(|x| dot(x, x)).sum::<f64>().sqrt();
        for ((v, back), right) in v.iter().zip(&back).zip(&right) {
            for k in 0..D {
                assert!((v[k] + back[k] - right[k]).abs() < 1e-12 * size);
            }
        }
    }

    #[test]
    fn solutions_solve_the_matrix_of_the_rows() {
        solutions_solve::<3>(2, 1);
        solutions_solve::<3>(30, 100);
        solutions_solve::<6>(30, 100);
        solutions_solve::<6>(200, 1_500);
    }

    #[test]
    fn what_would_be_too_large_is_refused() {
        let mut rows = rows::<3>(30, 100);
        let mut matrix = NormalMatrix::default();
        for largest in [0, 100, 1_000] {
            assert_eq!(matrix.analyse(&mut rows, largest), Err(Refused::TooLarge), "{largest}");
            assert_eq!(matrix.factorize(&rows, &[1.0; 100]), Err(Refused::TooLarge));
        }
        assert_eq!(matrix.analyse(&mut rows, 10_000), Ok(()));
        assert_eq!(matrix.factorize(&rows, &[f64::NAN; 100]), Err(Refused::NotPositive));
    }
}
