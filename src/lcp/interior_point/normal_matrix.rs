//! The matrix `I + J^T W J` of an iteration, body by body, and its sparse Cholesky factor.
//!
//! Its pattern is that of the pairs, so the order of elimination and the pattern of the factor are found once a solve.
//! The matrix is summed in the place of its factor, which then replaces it.

use super::factor::Factor;
use super::rows::UnitRows;
use super::supernodes::Pattern;

/// A row one of whose blocks is zero joins no two bodies.
const NONE: u32 = u32::MAX;

/// Why there is no factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refused {
    /// It, or the matrix, would be over the bound; or memory was refused.
    TooLarge,
    /// A pivot was not positive: a number is not finite, or out of all proportion.
    NotPositive,
}

/// The matrix, its factor, and what solving needs.
#[derive(Default)]
pub(super) struct NormalMatrix<const D: usize> {
    /// Distinct pairs of places, the smaller one first, ascending.
    links: Vec<[u32; 2]>,
    /// Each row's link.
    link: Vec<u32>,
    pattern: Option<Pattern>,
    factor: Factor,
    /// Where each body's own block is, and each link's.
    own: Vec<Block>,
    between: Vec<Block>,
    /// Factorizations made, for its owner to reset.
    pub factorizations: u64,
}

/// Where a block is among the numbers of the factor.
struct Block {
    start: usize,
    /// From a column to the next one.
    stride: usize,
    /// Whether its rows are those of the link's first body.
    of_first: bool,
}

impl<const D: usize> NormalMatrix<D> {
    /// Finds the patterns for some rows. The factor must not have more than `largest` numbers.
    pub fn analyse(&mut self, rows: &UnitRows<D>, largest: usize) -> Result<(), Refused> {
        self.pattern = None;
        self.find_links(rows);
        let pattern = Pattern::find(rows.bodies, &self.links, D, largest).ok_or(Refused::TooLarge)?;
        self.factor.reserve(pattern.numbers).map_err(|_| Refused::TooLarge)?;
        let place = |body: usize| pattern.place[body];
        self.own.clear();
        self.own.extend((0..rows.bodies).map(|body| Block::at::<D>(&pattern, [place(body); 2])));
        self.between.clear();
        let between = self.links.iter().map(|link| Block::at::<D>(&pattern, link.map(|body| place(body as usize))));
        self.between.extend(between);
        self.pattern = Some(pattern);
        Ok(())
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
    }

    /// Multiplications that a factorization takes, about: the squares of the factor's columns. Zero before the patterns
    /// are known.
    pub fn work(&self) -> f64 {
        self.pattern.as_ref().map_or(0.0, Pattern::work::<D>)
    }

    /// Factorizes for some weights of the rows.
    pub fn factorize(&mut self, rows: &UnitRows<D>, weight: &[f64]) -> Result<(), Refused> {
        if self.pattern.is_none() {
            return Err(Refused::TooLarge);
        }
        self.fill(rows, weight);
        self.factorizations += 1;
        let Some(pattern) = &self.pattern else { return Err(Refused::TooLarge) };
        self.factor.factorize::<D>(pattern).map_err(|_| Refused::NotPositive)
    }

    fn fill(&mut self, rows: &UnitRows<D>, weight: &[f64]) {
        self.factor.value.fill(0.0);
        for own in &self.own {
            for k in 0..D {
                self.factor.value[own.start + k * (own.stride + 1)] = 1.0;
            }
        }
        for (row, weight) in weight.iter().enumerate() {
            let ([a, b], [ja, jb]) = (rows.pair[row], &rows.jacobian[row]);
            self.own[a as usize].add(&mut self.factor.value, [ja, ja], *weight);
            self.own[b as usize].add(&mut self.factor.value, [jb, jb], *weight);
            if self.link[row] != NONE {
                let block = &self.between[self.link[row] as usize];
                let [down, right] = if (a < b) == block.of_first { [ja, jb] } else { [jb, ja] };
                block.add(&mut self.factor.value, [down, right], *weight);
            }
        }
    }

    /// Solves with the last factor.
    pub fn solve(&mut self, v: &mut [[f64; D]]) {
        if let Some(pattern) = &self.pattern {
            self.factor.solve(pattern, v);
        }
    }
}

impl Block {
    /// The one between two places, which may be the same.
    fn at<const D: usize>(pattern: &Pattern, [a, b]: [u32; 2]) -> Self {
        let (start, stride) = pattern.block::<D>([a, b]);
        Block { start, stride, of_first: a > b }
    }

    fn add<const D: usize>(&self, value: &mut [f64], [down, right]: [&[f64; D]; 2], weight: f64) {
        for (k, number) in right.iter().enumerate() {
            let scaled = weight * number;
            for (value, number) in value[self.start + k * self.stride..][..D].iter_mut().zip(down) {
                *value += scaled * number;
            }
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
        let rows = rows::<D>(bodies, count);
        let weight: Vec<f64> = (0..count).map(|row| [1e-6, 1.0, 30.0][row % 3]).collect();
        let mut matrix = NormalMatrix::default();
        assert_eq!(matrix.analyse(&rows, 1 << 20), Ok(()));
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
        let rows = rows::<3>(30, 100);
        let mut matrix = NormalMatrix::default();
        for largest in [0, 100, 1_000] {
            assert_eq!(matrix.analyse(&rows, largest), Err(Refused::TooLarge), "{largest}");
            assert_eq!(matrix.factorize(&rows, &[1.0; 100]), Err(Refused::TooLarge));
        }
        assert_eq!(matrix.analyse(&rows, 10_000), Ok(()));
        assert_eq!(matrix.factorize(&rows, &[f64::NAN; 100]), Err(Refused::NotPositive));
    }
}
