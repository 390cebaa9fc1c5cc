//! The units of a problem: rows alone, and cones of a normal row and its tangents.

use super::cone::{self, Triple};

/// The rows of a cone, or one row alone, which is a cone without tangents and friction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unit {
    first: usize,
    count: usize,
    pub mu: f64,
    /// The mean diagonal entry of `A` of its rows, by which a force becomes a length.
    pub scale: f64,
    /// Whether its normal row feels its multiplier. What does not stays as it is.
    pub live: bool,
    /// The most that its correction moves by, as a part of what it is off (`follow`).
    pub most: f64,
}

impl Unit {
    pub fn new(first: usize, count: usize, mu: f64) -> Self {
        Unit { first, count, mu, scale: 0.0, live: false, most: 1.0 }
    }

    /// Its rows.
    pub fn rows(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.count
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
        cone::project(x, self.mu)
    }
}

/// `a + f b`.
#[inline]
pub(super) fn plus(a: Triple, f: f64, b: Triple) -> Triple {
    std::array::from_fn(|i| a[i] + f * b[i])
}
