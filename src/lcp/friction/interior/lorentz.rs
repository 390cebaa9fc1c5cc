//! The algebra of the Lorentz cone `L = { |t| <= n }` in up to three numbers `(n, t)`; a ray is one without `t`.
//!
//! Source: L. Vandenberghe, The CVXOPT linear and quadratic cone program solvers, 2010 (scalings of Nesterov and Todd).

use crate::lcp::friction::cone::{Triple, dot};

/// `n^2 - |t|^2`.
pub(super) fn form(x: Triple) -> f64 {
    // As a product, which keeps digits near the boundary.
    let t = tangential(x);
    (x[0] - t) * (x[0] + t)
}

pub(super) fn tangential(x: Triple) -> f64 {
    x[1].hypot(x[2])
}

/// The product `(x . y, x_n y_t + y_n x_t)`.
pub(super) fn product(x: Triple, y: Triple) -> Triple {
    [dot(x, y), x[0] * y[1] + y[0] * x[1], x[0] * y[2] + y[0] * x[2]]
}

/// The `z` with `product(x, z) = y`, for `x` inside of `L`.
pub(super) fn quotient(x: Triple, y: Triple) -> Triple {
    let n = (x[0] * y[0] - x[1] * y[1] - x[2] * y[2]) / form(x);
    [n, (y[1] - n * x[1]) / x[0], (y[2] - n * x[2]) / x[0]]
}

/// The largest `a` for which `x + a d` is in `L`, for `x` inside of it.
pub(super) fn room(x: Triple, d: Triple) -> f64 {
    let (c, b, a) = (form(x), x[0] * d[0] - x[1] * d[1] - x[2] * d[2], form(d));
    let apex = if d[0] < 0.0 { x[0] / -d[0] } else { f64::INFINITY };
    let discriminant = b * b - a * c;
    let root = match (b < 0.0, discriminant >= 0.0) {
        (true, true) => c / (discriminant.sqrt() - b),
        (false, true) if a < 0.0 => (discriminant.sqrt() + b) / -a,
        _ => f64::INFINITY,
    };
    root.min(apex)
}

/// The symmetric `W` with `W x = W^-1 y`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scaling {
    /// The point of the hyperboloid `form = 1` that `W / factor` is made of.
    axis: Triple,
    factor: f64,
}

impl Scaling {
    /// For two points inside of `L`.
    pub fn new(x: Triple, y: Triple) -> Scaling {
        let (of_x, of_y) = (form(x), form(y));
        let (x, y) = (x.map(|x| x / of_x.sqrt()), y.map(|y| y / of_y.sqrt()));
        let twice = 2.0 * (0.5 * (1.0 + dot(x, y))).sqrt();
        let axis = [(y[0] + x[0]) / twice, (y[1] - x[1]) / twice, (y[2] - x[2]) / twice];
        Scaling { axis, factor: (of_y / of_x).sqrt().sqrt() }
    }

    /// `W x`.
    pub fn apply(&self, x: Triple) -> Triple {
        Scaling::along(self.axis, self.factor, x)
    }

    /// `W^-1 x`.
    pub fn invert(&self, x: Triple) -> Triple {
        let [n, t, u] = self.axis;
        Scaling::along([n, -t, -u], 1.0 / self.factor, x)
    }

    fn along(axis: Triple, factor: f64, x: Triple) -> Triple {
        let inner = axis[1] * x[1] + axis[2] * x[2];
        let part = x[0] + inner / (1.0 + axis[0]);
        [factor * (axis[0] * x[0] + inner), factor * (x[1] + part * axis[1]), factor * (x[2] + part * axis[2])]
    }

    /// `W^2`, by rows.
    pub fn square(&self) -> [Triple; 3] {
        let (sign, square) = ([1.0, -1.0, -1.0], self.factor * self.factor);
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let own = if i == j { sign[i] } else { 0.0 };
                square * (2.0 * self.axis[i] * self.axis[j] - own)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn inside(rng: &mut ChaCha8Rng) -> Triple {
        let t = [rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5];
        [t[0].hypot(t[1]) + 10f64.powf(-4.0 * rng.random::<f64>()), t[0], t[1]]
    }

    fn apart(x: Triple, y: Triple) -> f64 {
        (0..3).map(|i| (x[i] - y[i]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_scaling_takes_both_points_to_one() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..1_000 {
            let (x, y) = (inside(&mut rng), inside(&mut rng));
            let w = Scaling::new(x, y);
            let (one, other) = (w.apply(x), w.invert(y));
            assert!(apart(one, other) < 1e-9 * one[0], "{x:?} {y:?}: {one:?} {other:?}");
            let square = w.square().map(|row| dot(row, x));
            assert!(apart(square, y) < 1e-8 * y[0], "{x:?} {y:?}: {square:?}");
            let back = product(x, quotient(x, y));
            assert!(apart(back, y) < 1e-9 * (1.0 + y[0] / form(x)), "{x:?} {y:?}: {back:?}");
        }
    }

    #[test]
    fn the_room_along_a_direction_ends_at_the_boundary() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut bounded = 0;
        for _ in 0..1_000 {
            let x = inside(&mut rng);
            let d: Triple = std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0);
            let room = room(x, d);
            let at = |a: f64| -> Triple { std::array::from_fn(|i| x[i] + a * d[i]) };
            let is_inside = |x: Triple| tangential(x) < x[0];
            if room.is_finite() {
                bounded += 1;
                assert!(is_inside(at(room * (1.0 - 1e-6))) && !is_inside(at(room * (1.0 + 1e-6))), "{x:?} {d:?}");
            } else {
                assert!(is_inside(at(1e6)), "{x:?} {d:?}");
            }
        }
        assert!(bounded > 500 && bounded < 1_000, "{bounded}");
    }
}
