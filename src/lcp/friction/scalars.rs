//! A pair whose units are single rows, of contacts without friction and of bonds: its block of `A`, and a few sweeps of
//! Gauss-Seidel over its rows, as of `pairs` over units.

use super::pairs::{REGULARIZATION, SETTLED, SWEEPS};
use super::unit::Unit;
use std::ops::Range;

/// The rows of a pair, which stand together.
pub(super) struct Scalars<'a> {
    units: &'a [Unit],
    /// `A` of these rows, row by row.
    matrix: &'a [f64],
}

impl<'a> Scalars<'a> {
    /// Adds the block of a pair to those of the pairs before. `entry` is that of `A`.
    pub fn add_block(units: &[Unit], entry: impl Fn(usize, usize) -> f64, compliance: &[f64], entries: &mut Vec<f64>) {
        let rows = || units.iter().map(|unit| unit.rows().start);
        for i in rows() {
            entries.extend(rows().map(|j| match i == j {
                true => entry(i, i) * (1.0 + REGULARIZATION) + compliance[i],
                false => entry(i, j),
            }));
        }
    }

    /// Those of a pair; the blocks of pairs are taken in their order.
    pub fn of(units: &'a [Unit], entries: &'a [f64], taken: &mut usize) -> Self {
        let first = *taken;
        *taken += units.len() * units.len();
        Scalars { units, matrix: &entries[first..*taken] }
    }

    fn rows(&self) -> Range<usize> {
        let first = self.units[0].rows().start;
        first..first + self.units.len()
    }

    /// Takes `y` in `K`, where the gradients of all rows are `g`, to the solution.
    pub fn descend(&self, g: &[f64], rise: &mut Vec<f64>, y: &mut [f64]) {
        rise.clear();
        rise.extend_from_slice(&g[self.rows()]);
        self.settle(rise, &mut y[self.rows()]);
    }

    /// `y = argmin over y in K of (y - w) . A (y - w)`.
    pub fn project(&self, w: &[f64], rise: &mut Vec<f64>, y: &mut [f64]) {
        let (w, y) = (&w[self.rows()], &mut y[self.rows()]);
        let mut inside = true;
        for ((unit, w), y) in self.units.iter().zip(w).zip(y.iter_mut()) {
            *y = unit.nearest(*w);
            inside &= *y == *w;
        }
        if !inside {
            let slope = |row: &[f64]| row.iter().zip(y.iter().zip(w)).map(|(a, (y, w))| a * (y - w)).sum::<f64>();
            rise.clear();
            rise.extend(self.matrix.chunks_exact(w.len()).map(slope));
            self.settle(rise, y);
        }
    }

    /// The same for these rows alone, exactly for one.
    fn settle(&self, rise: &mut [f64], y: &mut [f64]) {
        let count = self.units.len();
        let sweeps = if count == 1 { 1 } else { SWEEPS };
        let mut most = 0.0;
        for _ in 0..sweeps {
            let mut farthest = 0.0;
            for (u, unit) in self.units.iter().enumerate().filter(|(_, unit)| unit.live) {
                // The block is symmetric: this is the row's column too.
                let row = &self.matrix[u * count..(u + 1) * count];
                let to = unit.nearest(y[u] - rise[u] / row[u]);
                let change = to - y[u];
                y[u] = to;
                if change != 0.0 {
                    rise.iter_mut().zip(row).for_each(|(rise, a)| *rise += a * change);
                }
                farthest = f64::max(farthest, unit.scale * change.abs());
            }
            most = f64::max(most, farthest);
            if farthest <= SETTLED * most {
                return;
            }
        }
    }
}
