//! A sparse Cholesky factor in dense panels, left-looking: each panel takes from all before it what they share rows
//! with it for, then is factorized itself (E. G. Ng, B. W. Peyton, Block sparse Cholesky algorithms on advanced
//! uniprocessor computers, 1993).

use super::supernodes::{Pattern, Supernode};
use nalgebra::{DMatrixView, DMatrixViewMut};
use std::collections::TryReserveError;

/// Rows of a product that are summed together.
const ROWS: usize = 4;

/// From so many multiplications on, nalgebra's product of matrices is faster.
const LARGE: usize = 1 << 14;

/// The numbers of a factor, and room to find them. A panel has the rows of its supernode, column by column.
#[derive(Debug, Default)]
pub(super) struct Factor {
    pub value: Vec<f64>,
    /// Where the row of each place begins in the present panel.
    row: Vec<usize>,
    product: Vec<f64>,
    right: Vec<f64>,
}

/// A pivot is not positive, or not finite.
#[derive(Debug)]
pub(super) struct NotPositive;

impl Factor {
    /// Makes room for so many numbers.
    pub fn reserve(&mut self, numbers: usize) -> Result<(), TryReserveError> {
        self.value.clear();
        self.value.try_reserve_exact(numbers)?;
        self.value.resize(numbers, 0.0);
        Ok(())
    }

    /// Replaces the matrix in the panels by its factor.
    pub fn factorize<const D: usize>(&mut self, pattern: &Pattern) -> Result<(), NotPositive> {
        self.row.resize(pattern.place.len(), 0);
        for node in &pattern.nodes {
            let (before, panel) = self.value.split_at_mut(node.start);
            let rows = pattern.rows(node);
            let height = D * rows.len();
            let panel = &mut panel[..height * D * node.own.len()];
            for (row, place) in rows.iter().enumerate() {
                self.row[*place as usize] = D * row;
            }
            for update in &node.updates {
                let earlier = &pattern.nodes[update.from];
                let all = pattern.rows(earlier);
                let shared = &all[update.skipped..];
                let size = [D * shared.len(), D * update.columns];
                self.product.resize(self.product.len().max(size[0] * size[1]), 0.0);
                let product = &mut self.product[..size[0] * size[1]];
                let numbers = &before[earlier.start..][..D * all.len() * D * earlier.own.len()];
                multiply::<D>(numbers, D * all.len(), D * update.skipped, size, product);
                subtract::<D>(product, shared, &self.row, panel, height);
            }
            factorize_panel::<D>(panel, height)?;
        }
        Ok(())
    }

    /// Solves with the factor, in the order of bodies.
    pub fn solve<const D: usize>(&mut self, pattern: &Pattern, v: &mut [[f64; D]]) {
        let mut x = std::mem::take(&mut self.right);
        x.resize(D * v.len(), 0.0);
        for (v, place) in v.iter().zip(&pattern.place) {
            x[D * *place as usize..][..D].copy_from_slice(v);
        }
        for node in &pattern.nodes {
            self.forward::<D>(pattern, node, &mut x);
        }
        for node in pattern.nodes.iter().rev() {
            self.backward::<D>(pattern, node, &mut x);
        }
        for (v, place) in v.iter_mut().zip(&pattern.place) {
            v.copy_from_slice(&x[D * *place as usize..][..D]);
        }
        self.right = x;
    }

    /// Takes a panel's numbers of `x` to `product`.
    fn gather<const D: usize>(&mut self, rows: &[u32], x: &[f64]) {
        self.product.clear();
        for place in rows {
            self.product.extend_from_slice(&x[D * *place as usize..][..D]);
        }
    }

    fn forward<const D: usize>(&mut self, pattern: &Pattern, node: &Supernode, x: &mut [f64]) {
        let rows = pattern.rows(node);
        self.gather::<D>(rows, x);
        let columns = self.value[node.start..].chunks_exact(D * rows.len());
        for (k, column) in columns.take(D * node.own.len()).enumerate() {
            let solved = self.product[k] / column[k];
            self.product[k] = solved;
            for (x, number) in self.product[k + 1..].iter_mut().zip(&column[k + 1..]) {
                *x -= solved * number;
            }
        }
        for (place, solved) in rows.iter().zip(self.product.as_chunks::<D>().0) {
            x[D * *place as usize..][..D].copy_from_slice(solved);
        }
    }

    fn backward<const D: usize>(&mut self, pattern: &Pattern, node: &Supernode, x: &mut [f64]) {
        let rows = pattern.rows(node);
        self.gather::<D>(rows, x);
        let (height, own) = (D * rows.len(), D * node.own.len());
        let panel = &self.value[node.start..][..height * own];
        for (block, columns) in panel.chunks_exact(D * height).enumerate().rev() {
            let from = D * (block + 1);
            let mut sum = [0.0; D];
            for (row, x) in self.product[from..].iter().enumerate() {
                for (k, sum) in sum.iter_mut().enumerate() {
                    *sum += columns[k * height + from + row] * x;
                }
            }
            for k in (0..D).rev() {
                let column = &columns[k * height + from - D..][..D];
                for (number, x) in column.iter().zip(&self.product[from - D..]).skip(k + 1) {
                    sum[k] += number * x;
                }
                self.product[from - D + k] = (self.product[from - D + k] - sum[k]) / column[k];
            }
        }
        x[D * node.own.start..D * node.own.end].copy_from_slice(&self.product[..own]);
    }
}

/// Factorizes a panel, whose numbers take part in the panels after it.
fn factorize_panel<const D: usize>(panel: &mut [f64], height: usize) -> Result<(), NotPositive> {
    for first in (0..panel.len() / height).step_by(D) {
        let (before, own) = panel.split_at_mut(first * height);
        let own = &mut own[..D * height];
        let mut row = first;
        while first > 0 && row < height {
            // The last sums hold rows that are finished.
            let at = row.min(height - ROWS);
            let sums = sums::<D>(before, height, at, first);
            for (k, sums) in sums.iter().enumerate() {
                for (own, sum) in own[k * height + row..].iter_mut().zip(&sums[row - at..]) {
                    *own -= sum;
                }
            }
            row = at + ROWS;
        }
        for k in 0..D {
            let (before, column) = own.split_at_mut(k * height);
            let column = &mut column[first + k..height];
            for other in before.chunks_exact(height) {
                let scale = other[first + k];
                for (number, other) in column.iter_mut().zip(&other[first + k..]) {
                    *number -= scale * other;
                }
            }
            let pivot = column[0];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(NotPositive);
            }
            let scale = 1.0 / pivot.sqrt();
            column.iter_mut().for_each(|number| *number *= scale);
        }
    }
    Ok(())
}

/// Subtracts a product of rows from a panel that shares them. Its columns are the first of the rows.
fn subtract<const D: usize>(product: &[f64], shared: &[u32], row: &[usize], panel: &mut [f64], height: usize) {
    for (k, product) in product.chunks_exact(D * shared.len()).enumerate() {
        let column = row[shared[k / D] as usize] + k % D;
        let column = &mut panel[column * height..][..height];
        for (place, product) in shared.iter().zip(product.as_chunks::<D>().0).skip(k / D) {
            for (number, product) in column[row[*place as usize]..][..D].iter_mut().zip(product) {
                *number -= product;
            }
        }
    }
}

/// The product of some rows of a panel, from one on, with the first of them; only where a row's block is not before the
/// column's.
fn multiply<const D: usize>(panel: &[f64], height: usize, from: usize, [rows, columns]: [usize; 2], out: &mut [f64]) {
    let width = panel.len() / height;
    if rows < ROWS || rows * columns * width >= LARGE {
        let of = |rows, columns, [down, right]: [usize; 2]| {
            DMatrixView::from_slice_with_strides(&panel[from..], rows, columns, down, right)
        };
        let (left, right) = (of(rows, width, [1, height]), of(width, columns, [height, 1]));
        DMatrixViewMut::from_slice(&mut out[..rows * columns], rows, columns).gemm(1.0, &left, &right, 0.0);
        return;
    }
    for column in (0..columns).step_by(D) {
        let mut row = column;
        while row < rows {
            // The last sums may be made twice.
            let at = row.min(rows - ROWS);
            let sums = sums::<D>(panel, height, from + at, from + column);
            for (k, sums) in sums.iter().enumerate() {
                out[(column + k) * rows + at..][..ROWS].copy_from_slice(sums);
            }
            row = at + ROWS;
        }
    }
}

/// Sums over the columns of a panel of the products of [`ROWS`] rows with `D` rows.
fn sums<const D: usize>(panel: &[f64], height: usize, row: usize, column: usize) -> [[f64; ROWS]; D] {
    let mut sums = [[0.0; ROWS]; D];
    for numbers in panel.chunks_exact(height) {
        let (left, right) = (&numbers[row..row + ROWS], &numbers[column..column + D]);
        for (sums, right) in sums.iter_mut().zip(right) {
            for (sum, left) in sums.iter_mut().zip(left) {
                *sum += left * right;
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A positive definite matrix with blocks at these links, whole and in the panels of its factor.
    fn matrix<const D: usize>(bodies: usize, links: &[[u32; 2]], seed: u64) -> (DMatrix<f64>, Pattern, Factor) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut whole = DMatrix::identity(D * bodies, D * bodies);
        for link in links {
            let mut row = DVector::zeros(D * bodies);
            for body in link {
                (0..D).for_each(|k| row[D * *body as usize + k] = rng.random::<f64>() - 0.5);
            }
            whole += 3.0 * &row * row.transpose();
        }
        let pattern = Pattern::find(bodies, links, D, usize::MAX).unwrap();
        let mut factor = Factor::default();
        factor.reserve(pattern.numbers).unwrap();
        for link in (0..bodies as u32).map(|body| [body; 2]).chain(links.iter().copied()) {
            let [a, b] = link.map(|body| pattern.place[body as usize]);
            let (start, stride) = pattern.block::<D>([a, b]);
            let [row, column] = if a < b { [link[1], link[0]] } else { link };
            for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                factor.value[start + j * stride + i] = whole[(D * row as usize + i, D * column as usize + j)];
            }
        }
        (whole, pattern, factor)
    }

    fn solves<const D: usize>(bodies: usize, links: &[[u32; 2]], seed: u64) {
        let (whole, pattern, mut factor) = matrix::<D>(bodies, links, seed);
        let right = DVector::from_fn(D * bodies, |i, _| (i % 7) as f64 - 2.0);
        let expected = whole.cholesky().unwrap().solve(&right);
        factor.factorize::<D>(&pattern).unwrap();
        let mut v = right.as_slice().as_chunks::<D>().0.to_vec();
        factor.solve(&pattern, &mut v);
        let worst = v.as_flattened().iter().zip(&expected).map(|(v, e)| (v - e).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-12 * expected.amax().max(1.0), "{bodies} bodies, seed {seed}: {worst:e}");
    }

    fn random_links(bodies: u32, density: f64, seed: u64) -> Vec<[u32; 2]> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let all = (0..bodies).flat_map(|a| (a + 1..bodies).map(move |b| [a, b]));
        all.filter(|_| rng.random::<f64>() < density).collect()
    }

    #[test]
    fn solutions_are_those_of_a_dense_factor() {
        solves::<3>(1, &[], 0);
        solves::<3>(5, &[], 0);
        solves::<3>(2, &[[0, 1]], 0);
        // A body that all others touch, and bodies that all touch each other: panels that are cut, large products.
        solves::<3>(200, &(1..200).map(|body| [0, body]).collect::<Vec<_>>(), 1);
        solves::<6>(40, &random_links(40, 1.0, 0), 2);
        for seed in 0..40 {
            let (bodies, density) = (2 + 2 * seed as u32, [0.03, 0.1, 0.3][seed as usize % 3]);
            let links = random_links(bodies, density, seed);
            solves::<3>(bodies as usize, &links, seed);
            solves::<6>(bodies as usize, &links, seed);
        }
    }

    #[test]
    fn a_pivot_that_is_not_positive_or_not_finite_is_refused() {
        for wrong in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
            let (_, pattern, mut factor) = matrix::<3>(20, &random_links(20, 0.2, 3), 3);
            let (start, _) = pattern.block::<3>([11; 2]);
            factor.value[start] = wrong;
            assert!(factor.factorize::<3>(&pattern).is_err(), "{wrong}");
        }
    }
}
