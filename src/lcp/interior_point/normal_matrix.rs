//! The matrix `I + J^T W J` of an iteration, in blocks by body, and its sparse Cholesky factor.
//!
//! Its pattern is that of the pairs, so the ordering (approximate minimum degree) and the pattern of the factor are
//! computed once per solve. It has a block for each body, and one for each pair of bodies that share a row.

use super::rows::{UnitRows, fill};
use crate::lcp::multifrontal::{Blocks, Multifrontal, elimination_order};
use crate::lcp::sparse_cholesky::Pattern;

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
    /// The offset of each link's rows, and the end; and these rows, ascending.
    first_row: Vec<u32>,
    rows: Vec<u32>,
    /// The blocks of the bodies and of the links. The columns of a link's block are the unknowns of its smaller body.
    own: Vec<[[f64; D]; D]>,
    linked: Vec<[[f64; D]; D]>,
    cholesky: Multifrontal<D>,
    /// The number of factorizations; the owner resets it.
    pub factorizations: u64,
}

impl<const D: usize> NormalMatrix<D> {
    /// Computes the patterns for some rows. Neither the matrix nor the factor may have more than `largest` entries.
    pub fn analyse(&mut self, rows: &mut UnitRows<D>, largest: usize) -> Result<(), Refused> {
        self.cholesky.forget();
        self.find_links(rows);
        self.order(rows)?;
        let entries = D * D * (rows.bodies + self.links.len());
        if entries > largest {
            return Err(Refused::TooLarge);
        }
        self.sort_rows();
        let later = self.later();
        let graph = Pattern { column: &self.first_link, entry: &later };
        if self.cholesky.analyse(graph, largest) { Ok(()) } else { Err(Refused::TooLarge) }
    }

    /// Numbers the bodies in an order of elimination with little fill. A body's unknowns stay together, so the order is
    /// that of a graph of bodies, and the factorization need not permute the matrix again.
    fn order(&mut self, rows: &mut UnitRows<D>) -> Result<(), Refused> {
        let later = self.later();
        let graph = Pattern { column: &self.first_link, entry: &later };
        rows.renumber(&elimination_order(graph).ok_or(Refused::TooLarge)?);
        self.find_links(rows);
        Ok(())
    }

    /// The later body of each link.
    fn later(&self) -> Vec<u32> {
        self.links.iter().map(|[_, high]| *high).collect()
    }

    /// Whether there is a factor's pattern.
    pub fn is_analysed(&self) -> bool {
        self.cholesky.is_analysed()
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

    /// Lists the rows of each link.
    fn sort_rows(&mut self) {
        self.first_row.clear();
        self.first_row.resize(self.links.len() + 1, 0);
        let linked = |link: &&u32| **link != NONE;
        for link in self.link.iter().filter(linked) {
            self.first_row[*link as usize + 1] += 1;
        }
        for link in 0..self.links.len() {
            self.first_row[link + 1] += self.first_row[link];
        }
        let mut next = self.first_row.clone();
        self.rows.clear();
        self.rows.resize(next.last().map_or(0, |rows| *rows as usize), 0);
        for (row, link) in self.link.iter().enumerate().filter(|(_, link)| **link != NONE) {
            let next = &mut next[*link as usize];
            self.rows[*next as usize] = row as u32;
            *next += 1;
        }
    }

    /// An estimate of the multiplications of a factorization. Zero before the analysis.
    pub fn work(&self) -> f64 {
        self.cholesky.work()
    }

    /// Factorizes for some weights of the rows.
    pub fn factorize(&mut self, rows: &UnitRows<D>, weight: &[f64]) -> Result<(), Refused> {
        if !self.cholesky.is_analysed() {
            return Err(Refused::TooLarge);
        }
        self.fill(rows, weight);
        self.factorizations += 1;
        let blocks = Blocks { own: &self.own, first_link: &self.first_link, linked: &self.linked };
        if self.cholesky.factorize(blocks) { Ok(()) } else { Err(Refused::NotPositive) }
    }

    fn fill(&mut self, rows: &UnitRows<D>, weight: &[f64]) {
        fill(&mut self.own, rows.bodies, |body| {
            let mut block = std::array::from_fn(|k| std::array::from_fn(|l| if k == l { 1.0 } else { 0.0 }));
            for entry in rows.incidence.of(body) {
                let (row, side) = ((entry / 2) as usize, (entry % 2) as usize);
                let jacobian = &rows.jacobian[row][side];
                add_outer(&mut block, weight[row], jacobian, jacobian);
            }
            block
        });
        let NormalMatrix { links, first_row, rows: sorted, linked, .. } = self;
        fill(linked, links.len(), |link| {
            let mut block = [[0.0; D]; D];
            for row in &sorted[first_row[link] as usize..first_row[link + 1] as usize] {
                let row = *row as usize;
                let ([a, b], [ja, jb]) = (rows.pair[row], &rows.jacobian[row]);
                let (low, high) = if a < b { (ja, jb) } else { (jb, ja) };
                add_outer(&mut block, weight[row], low, high);
            }
            block
        });
    }

    /// Solves with the last factor.
    pub fn solve(&mut self, v: &mut [[f64; D]]) {
        self.cholesky.solve(v);
    }
}

/// `block += weight a b^T`, with a column for each entry of `a`.
fn add_outer<const D: usize>(block: &mut [[f64; D]; D], weight: f64, a: &[f64; D], b: &[f64; D]) {
    for (column, a) in block.iter_mut().zip(a) {
        let scaled = weight * a;
        for (value, b) in column.iter_mut().zip(b) {
            *value += scaled * b;
        }
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
