//! The small problem of one pair, `argmin over y >= 0 of slope . (y - x) + 1/2 (y - x) . B (y - x)`, for pairs of one
//! to eight rows: in registers, without branches in the common case.
//!
//! In the common case of a projected step, the same rows are free as in the last step: so it is in 99 of 100 blocks of
//! three or more rows in the solves of the stored systems (in 93 to 99 the free rows are those with `x > 0`). This case
//! is computed first and checked. If it does not hold, block pivoting and the active set method follow.

use super::REGULARIZATION;
use crate::lcp::cone;

/// Rounds of pivoting before the active set method.
const PIVOTS: usize = 4;

/// A symmetric positive definite matrix of `M` rows. Zero rows of `A` have the diagonal entry 1 and no slope.
pub(super) trait Block<const M: usize> {
    /// The solution `y` of the small problem for `x >= 0`.
    fn proximal(&mut self, x: [f64; M], slope: [f64; M]) -> [f64; M];
    /// The solution without a slope, for `x` outside the cone.
    fn project(&self, x: [f64; M]) -> [f64; M];
}

/// One row: `1 / B`, zero for zero rows of `A`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Single(pub f64);

impl Block<1> for Single {
    #[inline]
    fn proximal(&mut self, [x]: [f64; 1], [slope]: [f64; 1]) -> [f64; 1] {
        [cone::project(x - slope * self.0)]
    }

    #[inline]
    fn project(&self, x: [f64; 1]) -> [f64; 1] {
        x.map(cone::project)
    }
}

/// Two rows, with precomputed inverses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Double {
    /// `B_00`, `B_01`, `B_11`.
    matrix: [f64; 3],
    /// `1 / B_00`, `1 / B_11`.
    inverse: [f64; 2],
    inverse_determinant: f64,
}

impl Double {
    pub fn new([a, b, c]: [f64; 3]) -> Self {
        Double { matrix: [a, b, c], inverse: [1.0 / a, 1.0 / c], inverse_determinant: 1.0 / (a * c - b * b) }
    }

    /// Computes all four cases and selects one. It solves for `y - x`, because a nearly singular `B` would amplify the
    /// rounding of large multipliers.
    #[inline]
    fn minimize(&self, x: [f64; 2], slope: [f64; 2]) -> [f64; 2] {
        let [a, b, c] = self.matrix;
        let both = [
            x[0] + (b * slope[1] - c * slope[0]) * self.inverse_determinant,
            x[1] + (b * slope[0] - a * slope[1]) * self.inverse_determinant,
        ];
        let first = cone::project(x[0] + (b * x[1] - slope[0]) * self.inverse[0]);
        let second = cone::project(x[1] + (b * x[0] - slope[1]) * self.inverse[1]);
        let rising = cone::contains(slope[0] - a * x[0] + b * (second - x[1]));
        let one = [if rising { 0.0 } else { first }, if rising { second } else { 0.0 }];
        let inside = cone::contains(both[0]) & cone::contains(both[1]);
        [if inside { both[0] } else { one[0] }, if inside { both[1] } else { one[1] }]
    }
}

impl Block<2> for Double {
    #[inline]
    fn proximal(&mut self, x: [f64; 2], slope: [f64; 2]) -> [f64; 2] {
        self.minimize(x, slope)
    }

    #[inline]
    fn project(&self, x: [f64; 2]) -> [f64; 2] {
        self.minimize(x, [0.0; 2])
    }
}

/// `M` rows. Matrices have the lower half by rows, `K = M (M + 1) / 2` entries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packed<const M: usize, const K: usize> {
    matrix: [f64; K],
    /// The rows that were free in the last solution of a projected step, marked by one.
    free: [f64; M],
    /// With `F` these rows and `C` the others: `B_FF^-1`, `B_CF B_FF^-1` and zeros, which are not read. Factors for the
    /// slopes of free rows.
    pivoted: [f64; K],
}

impl<const M: usize, const K: usize> Block<M> for Packed<M, K> {
    /// With the free rows of the last step: `y_F = x_F - B_FF^-1 s_F` and the slope of the others there, `s_C - B_CF
    /// B_FF^-1 s_F`, where `s` is the slope after the others are set to zero.
    #[inline]
    fn proximal(&mut self, x: [f64; M], slope: [f64; M]) -> [f64; M] {
        let free = self.free;
        let held: [f64; M] = std::array::from_fn(|i| (free[i] - 1.0) * x[i]);
        // The common case: these rows stay at zero.
        let none = held.iter().fold(true, |none, held| none & (*held == 0.0));
        let correction = if none { [0.0; M] } else { times(&self.matrix, held) };
        let there: [f64; M] = std::array::from_fn(|i| slope[i] + correction[i]);
        let moved: [f64; M] = times(&self.pivoted, std::array::from_fn(|i| free[i] * there[i]));
        let right: [f64; M] = std::array::from_fn(|i| if free[i] > 0.0 { x[i] } else { there[i] } - moved[i]);
        if all_in_cone(right) { std::array::from_fn(|i| free[i] * right[i]) } else { self.change_rows(x, slope) }
    }

    #[inline]
    fn project(&self, x: [f64; M]) -> [f64; M] {
        self.pivot(x, [0.0; M]).1
    }
}

impl<const M: usize, const K: usize> Packed<M, K> {
    /// Takes the entries of the lower half.
    pub fn new(entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut entries = [0.0; K];
        let places = (0..M).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for (place, (i, j)) in entries.iter_mut().zip(places) {
            *place = entry(i, j);
        }
        Packed { matrix: entries, free: [0.0; M], pivoted: [0.0; K] }
    }

    /// The values that are in the cone for a solution: `y` of free rows, the slope of the others.
    #[inline]
    fn right(&self, free: [f64; M], x: [f64; M], change: [f64; M], slope: [f64; M]) -> [f64; M] {
        let correction = times(&self.matrix, change);
        std::array::from_fn(|i| if free[i] > 0.0 { x[i] + change[i] } else { slope[i] + correction[i] })
    }

    /// A projected step whose free rows differ from those of the last step.
    #[cold]
    #[inline(never)]
    fn change_rows(&mut self, x: [f64; M], slope: [f64; M]) -> [f64; M] {
        let (free, y) = self.pivot(x, slope);
        if free != self.free {
            self.free = free;
            for i in (0..M).filter(|i| free[*i] > 0.0) {
                let column = self.solve(free, std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
                let across: [f64; M] = times(&self.matrix, column);
                for j in 0..M {
                    self.pivoted[at(i, j)] = if free[j] > 0.0 { column[j] } else { across[j] };
                }
            }
        }
        y
    }

    /// Solves `B_FF t = target` for the free rows `F`, marked by one, by a factorization `L D L^T`; zero for the
    /// others, marked by zero.
    #[inline]
    fn solve(&self, free: [f64; M], target: [f64; M]) -> [f64; M] {
        let (mut lower, mut inverse, mut t) = ([[0.0; M]; M], [0.0; M], [0.0; M]);
        for i in 0..M {
            let (mut scaled, mut pivot, mut sum) = ([0.0; M], self.matrix[at(i, i)], free[i] * target[i]);
            // The regularization keeps pivots above a millionth of the diagonal, up to rounding.
            let least = 0.1 * REGULARIZATION * pivot;
            for j in 0..i {
                let mut entry = self.matrix[at(i, j)] * (free[i] * free[j]);
                for k in 0..j {
                    entry -= scaled[k] * lower[j][k];
                }
                scaled[j] = entry;
                lower[i][j] = entry * inverse[j];
                pivot -= entry * lower[i][j];
                sum -= lower[i][j] * t[j];
            }
            inverse[i] = 1.0 / if pivot > least { pivot } else { least };
            t[i] = sum;
        }
        for i in (0..M).rev() {
            t[i] *= inverse[i];
            for k in i + 1..M {
                t[i] -= lower[k][i] * t[k];
            }
        }
        t
    }

    /// The free rows and the solution by block principal pivoting (Portugal, Judice, Vicente: A comparison of block
    /// pivoting and interior-point algorithms for linear least squares problems with nonnegative variables, 1994), for
    /// a few rounds; the active set method completes it.
    #[cold]
    #[inline(never)]
    fn pivot(&self, x: [f64; M], slope: [f64; M]) -> ([f64; M], [f64; M]) {
        let mut free = x.map(mark);
        for _ in 0..PIVOTS {
            let held: [f64; M] = std::array::from_fn(|i| (free[i] - 1.0) * x[i]);
            let correction = times(&self.matrix, held);
            let t = self.solve(free, std::array::from_fn(|i| -slope[i] - correction[i]));
            let change = std::array::from_fn(|i| held[i] + t[i]);
            let right = self.right(free, x, change, slope);
            if all_in_cone(right) {
                return (free, std::array::from_fn(|i| free[i] * (x[i] + change[i])));
            }
            free = std::array::from_fn(|i| if cone::is_outside(right[i]) { 1.0 - free[i] } else { free[i] });
        }
        let y = self.active_set(x, slope);
        (y.map(mark), y)
    }

    /// The active set method of Lawson and Hanson (Solving least squares problems, 1974, chapter 23) started at the
    /// projection of `x`. The objective never rises; the bound on rounds only matters to rounding.
    #[cold]
    #[inline(never)]
    fn active_set(&self, x: [f64; M], slope: [f64; M]) -> [f64; M] {
        let mut change = x.map(cone::lack);
        let mut free = x.map(cone::is_free);
        for _ in 0..4 * M + 4 {
            for i in 0..M {
                change[i] = if free[i] { change[i] } else { -x[i] };
            }
            let held: [f64; M] = times(&self.matrix, std::array::from_fn(|i| if free[i] { 0.0 } else { change[i] }));
            let ones = free.map(|free| if free { 1.0 } else { 0.0 });
            let target = self.solve(ones, std::array::from_fn(|i| -slope[i] - held[i]));
            let (mut part, mut first) = (f64::INFINITY, M);
            for i in 0..M {
                if free[i] && cone::is_bound(x[i] + target[i]) {
                    let y = x[i] + change[i];
                    let here = if cone::is_free(y) { cone::room(y, target[i] - change[i]) } else { 0.0 };
                    (part, first) = if first == M || here < part { (here, i) } else { (part, first) };
                }
            }
            if first < M {
                for i in 0..M {
                    if free[i] {
                        change[i] += part * (target[i] - change[i]);
                        free[i] = cone::is_free(x[i] + change[i]);
                    }
                }
                free[first] = false;
                continue;
            }
            for i in 0..M {
                change[i] = if free[i] { target[i] } else { change[i] };
            }
            let correction = times(&self.matrix, change);
            let (mut least, mut steepest) = (0.0, M);
            for i in 0..M {
                let here = (slope[i] + correction[i]) / self.matrix[at(i, i)].sqrt();
                (least, steepest) = if !free[i] && here < least { (here, i) } else { (least, steepest) };
            }
            if steepest == M {
                break;
            }
            free[steepest] = true;
        }
        std::array::from_fn(|i| cone::project(x[i] + change[i]))
    }
}

/// The mark of a row: one if it is free, else zero.
#[inline]
fn mark(x: f64) -> f64 {
    if cone::is_free(x) { 1.0 } else { 0.0 }
}

#[inline]
fn all_in_cone<const M: usize>(numbers: [f64; M]) -> bool {
    numbers.iter().fold(true, |all, x| all & cone::contains(*x))
}

/// The index of an entry in a packed matrix.
#[inline]
fn at(i: usize, j: usize) -> usize {
    let (i, j) = if i < j { (j, i) } else { (i, j) };
    i * (i + 1) / 2 + j
}

#[inline]
fn times<const M: usize, const K: usize>(matrix: &[f64; K], t: [f64; M]) -> [f64; M] {
    std::array::from_fn(|i| {
        let mut sum = 0.0;
        for j in 0..M {
            sum += matrix[at(i, j)] * t[j];
        }
        sum
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lcp::pair_blocks::larger::{Scratch, active_set};
    use rand::{RngExt, SeedableRng};

    /// A block of `M` rows like those of `A`, `J J^T` with six unknowns; some rows are equal, one may be zero.
    fn rows<const M: usize>(uniform: &mut impl FnMut() -> f64) -> ([[f64; M]; M], [bool; M]) {
        let mut jacobian: [[f64; 6]; M] = std::array::from_fn(|_| std::array::from_fn(|_| uniform()));
        let mut live = [true; M];
        for i in 1..M {
            if uniform() < -0.2 {
                jacobian[i] = jacobian[i - 1];
            }
        }
        if uniform() < -0.3 {
            jacobian[M / 2] = [0.0; 6];
            live[M / 2] = false;
        }
        let entry = |i: usize, j: usize| {
            let dot: f64 = jacobian[i].iter().zip(&jacobian[j]).map(|(a, b)| a * b).sum();
            match (i == j, live[i]) {
                (true, true) => dot * (1.0 + REGULARIZATION),
                (true, false) => 1.0,
                (false, _) => dot,
            }
        };
        (std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))), live)
    }

    /// `slope . (y - x) + 1/2 (y - x) . B (y - x)`, and the size of its terms.
    fn objective<const M: usize>(b: &[[f64; M]; M], x: [f64; M], slope: [f64; M], y: [f64; M]) -> (f64, f64) {
        let (mut sum, mut size) = (0.0, 0.0);
        for i in 0..M {
            let change = y[i] - x[i];
            let bend: f64 = (0..M).map(|j| b[i][j] * (y[j] - x[j])).sum();
            sum += change * (slope[i] + 0.5 * bend);
            size += (change * slope[i]).abs() + (change * bend).abs();
        }
        (sum, size)
    }

    /// Checks both minimizations against the active set method of the larger blocks, and that results are never
    /// negative. Steps follow each other as in a solve, with the free rows of the last step.
    fn agrees<const M: usize, B: Block<M>>(make: impl Fn(&dyn Fn(usize, usize) -> f64) -> B) {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(M as u64);
        let mut uniform = || rng.random::<f64>() - 0.5;
        for _ in 0..400 {
            let (matrix, live) = rows::<M>(&mut uniform);
            let mut block = make(&|i, j| matrix[i][j]);
            let mut x: [f64; M] = std::array::from_fn(|_| uniform().max(0.0));
            for _ in 0..4 {
                let slope: [f64; M] = std::array::from_fn(|i| if live[i] { uniform() } else { 0.0 });
                let y = block.proximal(x, slope);
                check(&matrix, x, slope, y);
                let away: [f64; M] = std::array::from_fn(|i| y[i] + 0.5 * uniform());
                if away.iter().any(|x| *x < 0.0) {
                    check(&matrix, away, [0.0; M], block.project(away));
                }
                x = y;
            }
        }
    }

    fn check<const M: usize>(matrix: &[[f64; M]; M], x: [f64; M], slope: [f64; M], y: [f64; M]) {
        assert!(y.iter().all(|y| *y >= 0.0), "{y:?}");
        let mut scratch = Scratch::default();
        scratch.slope.extend(slope);
        active_set(matrix.as_flattened(), &x, &mut scratch);
        let other = std::array::from_fn(|i| (x[i] + scratch.change[i]).max(0.0));
        let ((mine, size), (best, _)) = (objective(matrix, x, slope, y), objective(matrix, x, slope, other));
        assert!((mine - best).abs() <= 1e-9 * size, "{mine:e} {best:e} of {size:e}: {y:?} {other:?}");
        // The objective hardly determines how equal rows share a load; the regularization does, to fewer digits.
        let largest = y.iter().fold(1.0, |largest: f64, y| largest.max(*y));
        for (y, other) in y.iter().zip(other) {
            assert!((y - other).abs() <= 1e-7 * largest, "{y} {other} of {largest}");
        }
    }

    #[test]
    fn blocks_agree_with_the_active_set_method() {
        agrees::<1, Single>(|entry| Single(1.0 / entry(0, 0)));
        agrees::<2, Double>(|entry| Double::new([entry(0, 0), entry(1, 0), entry(1, 1)]));
        agrees::<3, Packed<3, 6>>(|entry| Packed::new(entry));
        agrees::<4, Packed<4, 10>>(|entry| Packed::new(entry));
        agrees::<5, Packed<5, 15>>(|entry| Packed::new(entry));
        agrees::<6, Packed<6, 21>>(|entry| Packed::new(entry));
        agrees::<7, Packed<7, 28>>(|entry| Packed::new(entry));
        agrees::<8, Packed<8, 36>>(|entry| Packed::new(entry));
    }

    /// Without pivoting: the method that completes it.
    #[test]
    fn the_active_set_method_alone_agrees_too() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(9);
        let mut uniform = || rng.random::<f64>() - 0.5;
        for _ in 0..400 {
            let (matrix, live) = rows::<5>(&mut uniform);
            let block = Packed::<5, 15>::new(|i, j| matrix[i][j]);
            let x: [f64; 5] = std::array::from_fn(|_| uniform());
            let slope = std::array::from_fn(|i| if live[i] { uniform() } else { 0.0 });
            check(&matrix, x, slope, block.active_set(x, slope));
        }
    }
}
