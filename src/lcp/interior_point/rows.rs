//! The nonzero rows of `J`, each scaled to length one, between bodies with consecutive indices.

use crate::lcp::cone::lack;
use crate::lcp::cpu::Rows;
use crate::lcp::product::{dot, scatter};

/// No index.
const NONE: u32 = u32::MAX;

/// Rows of length one. Their multipliers are the problem's times the length of the row, and so are lengths.
#[derive(Default)]
pub(super) struct UnitRows<const D: usize> {
    /// Each row's index in the problem.
    pub row: Vec<u32>,
    /// The bodies of each row, by their consecutive indices.
    pub pair: Vec<[u32; 2]>,
    /// The blocks of each row.
    pub jacobian: Vec<[[f64; D]; 2]>,
    /// `1 / length` of each original row.
    pub inverse_length: Vec<f64>,
    /// `g` at zero.
    pub q: Vec<f64>,
    /// The number of bodies that rows refer to.
    pub bodies: usize,
    /// The deepest violation without multipliers, zero if there is none.
    pub deepest: f64,
    place: Vec<u32>,
}

impl<const D: usize> UnitRows<D> {
    /// Takes the nonzero rows of a problem.
    pub fn rebuild(&mut self, rows: &Rows<D>) {
        let bodies = rows.pair.as_flattened().iter().max().map_or(0, |body| *body as usize + 1);
        self.place.clear();
        self.place.resize(bodies, NONE);
        (self.bodies, self.deepest) = (0, 0.0);
        self.row.clear();
        self.row.extend((0..rows.q.len() as u32).filter(|row| rows.inverse[*row as usize] > 0.0));
        self.pair.clear();
        self.jacobian.clear();
        self.inverse_length.clear();
        self.q.clear();
        for row in self.row.iter().map(|row| *row as usize) {
            let inverse_length = rows.inverse[row].sqrt();
            let place = |body: u32| {
                let place = &mut self.place[body as usize];
                if *place == NONE {
                    *place = self.bodies as u32;
                    self.bodies += 1;
                }
                *place
            };
            self.pair.push(rows.pair[row].map(place));
            self.jacobian.push(rows.jacobian[row].map(|block| block.map(|number| number * inverse_length)));
            self.inverse_length.push(inverse_length);
            self.q.push(rows.q[row] * inverse_length);
            self.deepest = self.deepest.max(lack(rows.q[row] * inverse_length));
        }
    }

    pub fn len(&self) -> usize {
        self.row.len()
    }

    /// `v = J^T x`.
    pub fn velocity(&self, x: &[f64], v: &mut Vec<[f64; D]>) {
        v.resize(self.bodies, [0.0; D]);
        scatter(&self.pair, &self.jacobian, x, v);
    }

    /// A row of `J v`.
    pub fn along(&self, row: usize, v: &[[f64; D]]) -> f64 {
        let ([a, b], [ja, jb]) = (self.pair[row], &self.jacobian[row]);
        dot(ja, &v[a as usize]) + dot(jb, &v[b as usize])
    }
}
