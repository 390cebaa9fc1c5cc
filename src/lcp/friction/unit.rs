//! The units of a problem: rows alone, whose multipliers are free or not negative, and cones of a normal row and its
//! tangents.

use super::cone::{self, Triple};

/// The rows of a cone, or one row alone, which is a cone without tangents and friction unless its multiplier is free.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unit {
    first: usize,
    count: usize,
    pub mu: f64,
    /// Whether its multiplier may be any number.
    pub free: bool,
    /// Whether it is free and solved together with all others that are.
    pub linked: bool,
    /// The mean diagonal entry of `A` of its rows, by which a force becomes a length.
    pub scale: f64,
    /// Whether its normal row feels its multiplier. What does not stays as it is.
    pub live: bool,
    /// The most that its correction moves by, as a part of what it is off (`follow`).
    pub most: f64,
}

impl Unit {
    pub fn new(first: usize, count: usize, mu: f64) -> Self {
        Unit { first, count, mu, free: false, linked: false, scale: 0.0, live: false, most: 1.0 }
    }

    /// A row whose multiplier is free.
    pub fn free(row: usize) -> Self {
        Unit { free: true, ..Unit::new(row, 1, 0.0) }
    }

    /// Its rows.
    pub fn rows(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.count
    }

    /// Whether it is one row.
    #[inline]
    pub fn is_scalar(&self) -> bool {
        self.count == 1
    }

    /// The nearest multiplier of one row.
    #[inline]
    pub fn nearest(&self, x: f64) -> f64 {
        if self.free { x } else { x.max(0.0) }
    }

    /// Its numbers.
    #[inline]
    pub fn get(&self, x: &[f64]) -> Triple {
        let x = &x[self.first..self.first + self.count];
        match *x {
            [n] => [n, 0.0, 0.0],
            [n, t] => [n, t, 0.0],
            [n, t, u] => [n, t, u],
            _ => unreachable!("a unit has one to three rows"),
        }
    }

    #[inline]
    pub fn put(&self, y: Triple, x: &mut [f64]) {
        let x = &mut x[self.first..self.first + self.count];
        // One by one: a copy of a few numbers is a call.
        x[0] = y[0];
        if let [_, tangents @ ..] = x {
            tangents.iter_mut().zip(&y[1..]).for_each(|(x, y)| *x = *y);
        }
    }

    /// The nearest multipliers.
    #[inline]
    pub fn project(&self, x: Triple) -> Triple {
        if self.free { x } else { cone::project(x, self.mu) }
    }

    /// Numbers from elsewhere as multipliers: zeros where one is not finite.
    pub fn admit(&self, x: Triple) -> Triple {
        if self.free && x[0].is_finite() { x } else { cone::admit(x, self.mu) }
    }

    /// `y - x` of two multipliers.
    #[inline]
    pub fn displacement(&self, x: Triple, y: Triple) -> Triple {
        if self.free { [y[0] - x[0], 0.0, 0.0] } else { cone::displacement(x, y, self.mu) }
    }

    /// The largest `t` for which `x + t d` are multipliers.
    #[inline]
    pub fn room(&self, x: Triple, d: Triple) -> f64 {
        if self.free {
            f64::INFINITY
        } else if self.is_scalar() {
            cone::room_of_ray(x[0], d[0])
        } else {
            cone::room(x, d, self.mu)
        }
    }

    /// The residual of the multipliers `x` with the gaps and slips `g`, a length: zero at a solution. That of a free
    /// row is its gap.
    #[inline]
    pub fn residual(&self, x: Triple, g: Triple) -> f64 {
        if self.free { g[0].abs() } else { cone::residual(x, g, self.mu, self.scale) }
    }
}

/// `a + f b`.
#[inline]
pub(super) fn plus(a: Triple, f: f64, b: Triple) -> Triple {
    std::array::from_fn(|i| a[i] + f * b[i])
}
