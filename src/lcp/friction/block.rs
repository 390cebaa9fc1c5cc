//! The small problem of a friction cone, `argmin over y in K of y . B y / 2 + c . y`, solved exactly.
//!
//! The answer is zero if `c` lies in the dual cone, or `-B^-1 c` if that lies in `K`. Otherwise it lies on the
//! boundary, where `y . J y = 0` with `J = diag(mu^2, -1, -1)`, and `(B - l J) y = -c` for some `l > 0`. In a basis
//! with `V^T B V = 1` and `V^T J V = diag(p, -a1, -a2)`, which is made once, `z = V^-1 y` and `h = V^T c`,
//!
//! ```text
//! z+ = -h+ / (1 - l p),   zi = -hi / (1 + l ai),   p z+^2 = a1 z1^2 + a2 z2^2.
//! ```
//!
//! `y` lies in `K`, and not in `-K`, where `z+ > 0`. So `l < 1/p` if `h+ < 0`, else `l > 1/p`. The square root of the
//! last equation is then `sqrt(p) |h+| R(l) = |1 - l p|` with `R = 1 / sqrt(sum ai hi^2 / (1 + l ai)^2)`. `R` is
//! concave and rises, being a power mean of linear functions. On the first side the difference of both sides is
//! concave, rises and begins negative at `l = 0`; on the second it does so in `1/l`, from 0. So Newton's method from
//! there converges without a safeguard: no iterate passes the one root.

use super::cone::{Triple, contains, dot, dual_contains, project};

/// Most rounds of Newton's method, which takes 2 to 6. An inexact answer would do.
pub(in crate::lcp) const MOST_ROUNDS: usize = 30;

/// A round that changes the multiplier by a smaller part is the last. Rounds converge quadratically: about the square
/// of this part is left. A pile took 5.2 s with 1e-4, 6.1 s with 1e-8 and 5.1 s with 1e-2, and as many iterations.
pub(in crate::lcp) const CONVERGED: f64 = 1e-4;

/// Rounds of Jacobi's method for the eigenvectors, far more than it takes.
pub(in crate::lcp) const MOST_SWEEPS: usize = 20;

/// An entry off the diagonal that is this part of the rounding of those on it is zero.
pub(in crate::lcp) const NEGLIGIBLE: f64 = 1e-3;

type Matrix = [Triple; 3];

/// A cone's block `B`, positive definite, and what its solutions need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    mu: f64,
    pub matrix: Matrix,
    inverse: Matrix,
    /// The columns of `V`, that of `z+` first.
    basis: Matrix,
    /// `p`, `a1`, `a2`.
    spectrum: Triple,
}

impl Block {
    pub fn new(matrix: Matrix, mu: f64) -> Self {
        let root = inverse_of_factor(&matrix);
        // `L^-1 J L^-T`, whose eigenvectors times `L^-T` are the basis.
        let form = |x: Triple, y: Triple| mu * mu * x[0] * y[0] - x[1] * y[1] - x[2] * y[2];
        let mut turned: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| form(root[i], root[j])));
        let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        diagonalize(&mut turned, &mut vectors);
        let at = |k: usize| turned[k][k];
        let plus = if at(0) >= at(1) && at(0) >= at(2) { 0 } else { 1 + usize::from(at(2) > at(1)) };
        let column = |k: usize| -> Triple {
            let vector: Triple = std::array::from_fn(|i| vectors[i][k]);
            std::array::from_fn(|j| (0..3).map(|i| root[i][j] * vector[i]).sum())
        };
        let places = [plus, (plus + 1) % 3, (plus + 2) % 3];
        let mut basis = places.map(column);
        if basis[0][0] < 0.0 {
            basis[0] = basis[0].map(|x| -x);
        }
        let spectrum = [at(places[0]), -at(places[1]), -at(places[2])].map(|x| x.max(0.0));
        let inverse = std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| root[k][i] * root[k][j]).sum()));
        Block { mu, matrix, inverse, basis, spectrum }
    }

    /// `B x`.
    #[inline]
    pub fn times(&self, x: Triple) -> Triple {
        self.matrix.map(|row| dot(row, x))
    }

    /// The `y` that minimizes the same without a bound, of a free row.
    #[inline]
    pub fn descend(&self, x: Triple, g: Triple) -> Triple {
        [x[0] - self.inverse[0][0] * g[0], 0.0, 0.0]
    }

    /// The `y` in `K` that minimizes `g . (y - x) + (y - x) . B (y - x) / 2`.
    #[inline]
    pub fn minimize(&self, x: Triple, g: Triple) -> Triple {
        let step = self.inverse.map(|row| dot(row, g));
        let free = std::array::from_fn(|i| x[i] - step[i]);
        if contains(free, self.mu) {
            return free;
        }
        let moved = self.times(x);
        let c = std::array::from_fn(|i| g[i] - moved[i]);
        if dual_contains(c, self.mu) {
            return [0.0; 3];
        }
        if self.mu == 0.0 {
            return [(-c[0] / self.matrix[0][0]).max(0.0), 0.0, 0.0];
        }
        self.on_boundary(c)
    }

    /// The solution where it lies on the boundary and is not zero.
    fn on_boundary(&self, c: Triple) -> Triple {
        let [p, a1, a2] = self.spectrum;
        let [h, h1, h2] = self.basis.map(|v| dot(v, c));
        let ([b1, b2], top) = ([a1 * h1 * h1, a2 * h2 * h2], p.sqrt() * h.abs());
        // The parts of `zi` are `inner / (1 + l ai)` in `l` on the first side, `l / (l + ai)` in `1/l` on the second.
        let first = h < 0.0;
        let (mut l, limit) = (0.0, if first { 1.0 } else { p });
        let slope_of_bound = if first { p } else { 1.0 };
        for _ in 0..MOST_ROUNDS {
            let (d1, d2) = if first { (1.0 + l * a1, 1.0 + l * a2) } else { (l + a1, l + a2) };
            let (e1, e2) = (d1.recip(), d2.recip());
            let (q1, q2) = (b1 * (e1 * e1), b2 * (e2 * e2));
            let root = (q1 + q2).sqrt().recip();
            let (r1, r2) = if first { (a1 * e1, a2 * e2) } else { (e1, e2) };
            let slope = top * root * root * root * (q1 * r1 + q2 * r2) + slope_of_bound;
            let step = (limit - l * slope_of_bound - top * root) / slope;
            l += step.max(0.0);
            if step.is_nan() || step <= CONVERGED * l {
                break;
            }
        }
        let part = |a: f64| if first { 1.0 / (1.0 + l * a) } else { l / (l + a) };
        let (z1, z2) = (-h1 * part(a1), -h2 * part(a2));
        let z = ((a1 * z1 * z1 + a2 * z2 * z2) / p).sqrt();
        let [v, v1, v2] = self.basis;
        let y: Triple = std::array::from_fn(|i| v[i] * z + v1[i] * z1 + v2[i] * z2);
        project(y, self.mu)
    }
}

/// `L^-1` of `B = L L^T` by Cholesky.
fn inverse_of_factor(b: &Matrix) -> Matrix {
    let l00 = b[0][0].sqrt();
    let (l10, l20) = (b[1][0] / l00, b[2][0] / l00);
    let l11 = (b[1][1] - l10 * l10).sqrt();
    let l21 = (b[2][1] - l20 * l10) / l11;
    let l22 = (b[2][2] - l20 * l20 - l21 * l21).sqrt();
    let (i0, i1, i2) = (l00.recip(), l11.recip(), l22.recip());
    let i10 = -l10 * i0 * i1;
    [[i0, 0.0, 0.0], [i10, i1, 0.0], [-(l20 * i0 + l21 * i10) * i2, -l21 * i1 * i2, i2]]
}

/// Makes a symmetric matrix diagonal by Jacobi's rotations, and turns the columns of `vectors` along.
fn diagonalize(m: &mut Matrix, vectors: &mut Matrix) {
    for _ in 0..MOST_SWEEPS {
        if m[0][1] == 0.0 && m[0][2] == 0.0 && m[1][2] == 0.0 {
            return;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(m, vectors, p, q);
        }
    }
}

/// The rotation that makes `m[p][q]` zero (G. H. Golub, C. F. Van Loan, Matrix Computations, section 8.5).
fn rotate(m: &mut Matrix, vectors: &mut Matrix, p: usize, q: usize) {
    let off = m[p][q];
    if off.abs() <= f64::MIN_POSITIVE + NEGLIGIBLE * f64::EPSILON * (m[p][p] * m[q][q]).abs().sqrt() {
        (m[p][q], m[q][p]) = (0.0, 0.0);
        return;
    }
    let half = (m[q][q] - m[p][p]) / (2.0 * off);
    let t = half.signum() / (half.abs() + (1.0 + half * half).sqrt());
    let c = (1.0 + t * t).sqrt().recip();
    let s = t * c;
    let r = 3 - p - q;
    let (mp, mq) = (m[r][p], m[r][q]);
    (m[p][p], m[q][q]) = (m[p][p] - t * off, m[q][q] + t * off);
    (m[p][q], m[q][p]) = (0.0, 0.0);
    (m[r][p], m[r][q]) = (c * mp - s * mq, s * mp + c * mq);
    (m[p][r], m[q][r]) = (m[r][p], m[r][q]);
    for row in vectors {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::cone::{residual, tangential};
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn triple(rng: &mut ChaCha8Rng) -> Triple {
        std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0)
    }

    /// `G G^T + shift`, with `G` of this rank.
    fn matrix(rng: &mut ChaCha8Rng, rank: usize, shift: f64) -> Matrix {
        let mut b = [[0.0; 3]; 3];
        for _ in 0..rank {
            let v = triple(rng);
            b = std::array::from_fn(|i| std::array::from_fn(|j| b[i][j] + v[i] * v[j]));
        }
        (0..3).for_each(|i| b[i][i] += shift);
        b
    }

    /// How far `y` is from the solution: how far `y` is outside of `K` and `g = B y + c` outside of `K*`, and `y . g`,
    /// as parts of the terms.
    fn error(b: &Matrix, mu: f64, c: Triple, y: Triple) -> f64 {
        let g: Triple = std::array::from_fn(|i| dot(b[i], y) + c[i]);
        let terms: f64 = dot(c, c).sqrt() + (0..3).map(|i| dot(b[i].map(f64::abs), y.map(f64::abs))).sum::<f64>();
        let length = dot(y, y).sqrt();
        let outside = (tangential(y) - mu * y[0]).max(0.0) / (length * (1.0 + mu)).max(f64::MIN_POSITIVE);
        let open = (mu * tangential(g) - g[0]).max(0.0) / (terms * (1.0 + mu));
        outside.max(open).max(dot(y, g).abs() / (terms * length).max(f64::MIN_POSITIVE))
    }

    #[test]
    fn random_problems_are_solved() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut counts, mut worst) = ([0; 3], 0.0_f64);
        for case in 0..100_000 {
            let mu = 10.0 * rng.random::<f64>() * if case % 4 == 0 { 1e-2 } else { 1.0 };
            let b = matrix(&mut rng, 3 + case % 2, 1e-6);
            let (block, c) = (Block::new(b, mu), triple(&mut rng));
            let y = block.minimize([0.0; 3], c);
            worst = worst.max(error(&b, mu, c, y));
            counts[if y == [0.0; 3] { 0 } else { 1 + usize::from(tangential(y) > mu * y[0] * (1.0 - 1e-9)) }] += 1;
        }
        assert!(worst < 1e-9, "{worst:e} {counts:?}");
        assert!(counts.iter().all(|count| *count > 5_000), "{counts:?}");
    }

    #[test]
    fn a_step_from_a_point_is_that_of_the_whole_problem() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for _ in 0..1_000 {
            let mu = rng.random::<f64>();
            let block = Block::new(matrix(&mut rng, 4, 1e-3), mu);
            let (x, g) = (project(triple(&mut rng), mu), triple(&mut rng));
            let moved = block.times(x);
            let whole = block.minimize([0.0; 3], std::array::from_fn(|i| g[i] - moved[i]));
            let step = block.minimize(x, g);
            (0..3).for_each(|i| assert!((whole[i] - step[i]).abs() < 1e-9, "{whole:?} {step:?}"));
            // A solution stays where it is.
            let rest = block.times(whole);
            let slope = std::array::from_fn(|i| rest[i] + g[i] - moved[i]);
            let again = block.minimize(whole, slope);
            (0..3).for_each(|i| assert!((whole[i] - again[i]).abs() < 1e-9, "{whole:?} {again:?}"));
        }
    }

    #[test]
    fn degenerate_problems_are_solved() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for case in 0..20_000 {
            let rank = case % 4;
            let b = matrix(&mut rng, rank, [1e-6, 1e-2][case % 2]);
            let mu = [0.0, 1e-6, 1e-3, 0.5, 10.0][case % 5];
            let mut c = triple(&mut rng);
            match case % 7 {
                // On the boundary of the dual cone, or of its negative.
                0 => c[0] = mu * tangential(c),
                1 => c[0] = -mu * tangential(c),
                // No tangential part, or no normal one.
                2 => (c[1], c[2]) = (0.0, 0.0),
                3 => c[0] = 0.0,
                _ => {}
            }
            let block = Block::new(b, mu);
            let y = block.minimize([0.0; 3], c);
            assert!(y.iter().all(|y| y.is_finite()), "{case}: {b:?} {mu} {c:?} {y:?}");
            let found = error(&b, mu, c, y);
            assert!(found < 1e-9, "{case}: {found:e} {b:?} {mu} {c:?} {y:?}");
        }
    }

    #[test]
    fn no_point_of_a_grid_is_better() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for case in 0..40 {
            let mu = 2.0 * rng.random::<f64>();
            let (b, c) = (matrix(&mut rng, 3, 0.05), triple(&mut rng));
            let value = |y: Triple| 0.5 * dot(y, std::array::from_fn(|i| dot(b[i], y))) + dot(c, y);
            let y = Block::new(b, mu).minimize([0.0; 3], c);
            assert!(residual(y, std::array::from_fn(|i| dot(b[i], y) + c[i]), mu, 1.0) < 1e-9);
            let least = value(y);
            for (n, part, angle) in (0..30).flat_map(|n| (0..=8).flat_map(move |t| (0..24).map(move |a| (n, t, a)))) {
                let (n, turn) = (0.1 * f64::from(n) * (1.0 + y[0]), f64::from(angle) * std::f64::consts::TAU / 24.0);
                let t = mu * n * f64::from(part) / 8.0;
                let other = value([n, t * turn.cos(), t * turn.sin()]);
                assert!(other >= least - 1e-12, "{case}: {other} {least} {y:?}");
            }
        }
    }

    #[test]
    fn planar_problems_stay_in_the_plane() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for _ in 0..1_000 {
            let mut b = matrix(&mut rng, 3, 0.01);
            (b[0][2], b[1][2], b[2][0], b[2][1], b[2][2]) = (0.0, 0.0, 0.0, 0.0, 1.0);
            let (mu, c) = (2.0 * rng.random::<f64>(), [rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5, 0.0]);
            let y = Block::new(b, mu).minimize([0.0; 3], c);
            assert_eq!(y[2], 0.0);
            // The best of the edges, the inside and the apex.
            let value = |y: Triple| 0.5 * dot(y, std::array::from_fn(|i| dot(b[i], y))) + dot(c, y);
            let edge = |w: Triple| {
                let part = -dot(c, w) / dot(w, std::array::from_fn(|i| dot(b[i], w)));
                value(w.map(|w| part.max(0.0) * w))
            };
            let least = edge([1.0, mu, 0.0]).min(edge([1.0, -mu, 0.0])).min(0.0);
            assert!(value(y) <= least + 1e-12, "{y:?}");
        }
    }
}
