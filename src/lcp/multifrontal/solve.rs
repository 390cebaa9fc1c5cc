//! Solves with the factor of a task: forward with its columns, backward with their transposes.

use super::task::Task;
use crate::lcp::product::add;

/// Interleaved parts of a sum, which the compiler vectorizes.
const PARTS: usize = 8;

impl<const D: usize> Task<D> {
    /// Solves with the lower triangle. `children` are the roots of the subtrees below, solved before.
    pub fn forward<'a>(&mut self, right: &[[f64; D]], children: impl Iterator<Item = &'a Task<D>>) {
        let Task { fronts, factor, bodies, own, x, below, .. } = self;
        for (x, body) in x.iter_mut().zip(&bodies[..*own]) {
            *x = right[*body as usize];
        }
        x[*own..].fill([0.0; D]);
        for child in children {
            for (change, place) in child.x[child.own..].iter().zip(&child.above) {
                add(&mut x[*place as usize], 1.0, change);
            }
        }
        for front in fronts {
            let below = &mut below[..front.rows.len()];
            below.fill([0.0; D]);
            let own = x[front.first..][..front.columns].as_flattened_mut();
            let height = own.len() + D * below.len();
            let columns = factor[front.panel..].chunks_exact(height).take(own.len());
            for (j, column) in columns.enumerate() {
                let (diagonal, rest) = (column[j], &column[j + 1..]);
                own[j] /= diagonal;
                let y = own[j];
                let (inside, outside) = rest.split_at(own.len() - j - 1);
                subtract(&mut own[j + 1..], y, inside);
                subtract(below.as_flattened_mut(), y, outside);
            }
            for (change, row) in below.iter().zip(&front.rows) {
                add(&mut x[*row as usize], 1.0, change);
            }
        }
    }

    /// Solves with the transpose of the lower triangle.
    pub fn backward(&mut self) {
        let Task { fronts, factor, x, below, .. } = self;
        for front in fronts.iter().rev() {
            let below = &mut below[..front.rows.len()];
            for (below, row) in below.iter_mut().zip(&front.rows) {
                *below = x[*row as usize];
            }
            let own = x[front.first..][..front.columns].as_flattened_mut();
            let height = own.len() + D * below.len();
            for j in (0..own.len()).rev() {
                let column = &factor[front.panel + j * height..][..height];
                let (inside, outside) = column[j + 1..].split_at(own.len() - j - 1);
                let sum = dot(inside, &own[j + 1..]) + dot(outside, below.as_flattened());
                own[j] = (own[j] - sum) / column[j];
            }
        }
    }

    /// Takes the parts of the solution that the parent has.
    pub fn take_outside(&mut self, parent: &Task<D>) {
        let Task { x, own, above, .. } = self;
        for (x, place) in x[*own..].iter_mut().zip(above.iter()) {
            *x = parent.x[*place as usize];
        }
    }

    /// Writes the solution of the bodies that it eliminates.
    pub fn export(&self, out: &mut [[f64; D]]) {
        for (x, body) in self.x[..self.own].iter().zip(&self.bodies) {
            out[*body as usize] = *x;
        }
    }
}

fn subtract(x: &mut [f64], y: f64, column: &[f64]) {
    for (x, number) in x.iter_mut().zip(column) {
        *x -= y * number;
    }
}

/// For 3 to 30 entries, as most columns have, it takes two fifths to four fifths of the time of
/// [`crate::lcp::loops::dots`], which is for long chunks.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<PARTS>(), b.as_chunks::<PARTS>());
    let mut parts = [0.0; PARTS];
    for (a, b) in a.iter().zip(b) {
        for (part, (a, b)) in parts.iter_mut().zip(a.iter().zip(b)) {
            *part += a * b;
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    parts.into_iter().sum::<f64>() + rest
}
