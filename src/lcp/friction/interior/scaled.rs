//! Units in the scaling of the interior-point method: rows of length about one, normal ones divided by `mu`.

use crate::lcp::friction::cone::Triple;
use crate::lcp::friction::rows::Frictional;
use crate::lcp::friction::unit::Unit;
use crate::lcp::product;

/// The index of a body that does not move: its blocks are zero, and it connects no others.
pub(super) const NONE: u32 = u32::MAX;

/// A unit in the scaling of this method.
#[derive(Clone, Debug)]
pub(super) struct Scaled<const D: usize> {
    pub unit: Unit,
    /// Consecutive indices of its bodies.
    pub pair: [u32; 2],
    /// Its rows: the normal one alone without friction.
    pub count: usize,
    pub rows: [[[f64; D]; 2]; 3],
    pub q: Triple,
    pub compliance: Triple,
    /// What multiplies rows, gaps and slips, and divides multipliers.
    pub scale: Triple,
}

impl<const D: usize> Scaled<D> {
    /// Of unit number `at`, between bodies that are still to be numbered.
    fn new(rows: &Frictional<D>, at: usize, unit: &Unit, corrected: bool) -> Self {
        let first = unit.rows().start;
        let count = if unit.mu > 0.0 { unit.rows().len() } else { 1 };
        let jacobian = &rows.product().jacobian()[first..first + count];
        let compliance = &rows.compliance()[first..first + count];
        let factor = |i: usize| if i == 0 && unit.mu > 0.0 { 1.0 / unit.mu } else { 1.0 };
        let square = |i: usize| {
            let [a, b] = &jacobian[i];
            (product::dot(a, a) + product::dot(b, b) + compliance[i]) * factor(i).powi(2)
        };
        let length = ((0..count).map(square).sum::<f64>() / count as f64).sqrt();
        let (zero, pair) = ([0.0; 3], [NONE; 2]);
        let rows_of = [[[0.0; D]; 2]; 3];
        let mut scaled = Scaled { unit: *unit, pair, count, rows: rows_of, q: zero, compliance: zero, scale: zero };
        for i in 0..count {
            let scale = factor(i) / length;
            scaled.scale[i] = scale;
            scaled.rows[i] = jacobian[i].map(|block| block.map(|j| scale * j));
            scaled.q[i] = scale * rows.offset(at, first + i, corrected);
            scaled.compliance[i] = scale * scale * compliance[i];
        }
        scaled
    }

    /// The gaps and slips at body velocities.
    pub fn along(&self, v: &[[f64; D]]) -> Triple {
        let mut out = [0.0; 3];
        for (side, body) in self.bodies() {
            for (out, row) in out.iter_mut().zip(&self.rows[..self.count]) {
                *out += product::dot(&row[side], &v[body]);
            }
        }
        out
    }

    /// `v += J^T x`.
    pub fn add_to(&self, x: Triple, v: &mut [[f64; D]]) {
        for (side, body) in self.bodies() {
            for (row, x) in self.rows[..self.count].iter().zip(x) {
                v[body].iter_mut().zip(&row[side]).for_each(|(v, j)| *v += j * x);
            }
        }
    }

    /// The sides whose bodies move, and these bodies.
    pub fn bodies(&self) -> impl Iterator<Item = (usize, usize)> + use<D> {
        let moves = |(_, body): &(usize, u32)| *body != NONE;
        self.pair.into_iter().enumerate().filter(moves).map(|(side, body)| (side, body as usize))
    }
}

/// Takes the units that feel their multipliers, with corrections in their offsets or without; the number of bodies that
/// they refer to and that move.
pub(super) fn rebuild<const D: usize>(rows: &Frictional<D>, corrected: bool, units: &mut Vec<Scaled<D>>) -> usize {
    units.clear();
    let mut places = Places::default();
    for (at, unit) in rows.units().iter().enumerate().filter(|(_, unit)| unit.live) {
        let mut scaled = Scaled::new(rows, at, unit, corrected);
        let bodies = rows.product().pair()[unit.rows().start];
        for (side, body) in bodies.into_iter().enumerate() {
            let moves = scaled.rows[..scaled.count].iter().any(|row| row[side].iter().any(|j| *j != 0.0));
            scaled.pair[side] = if moves { places.of(body as usize) } else { NONE };
        }
        units.push(scaled);
    }
    places.count as usize
}

/// Consecutive indices of bodies, in the order of their first use.
#[derive(Default)]
struct Places {
    of_body: Vec<u32>,
    count: u32,
}

impl Places {
    fn of(&mut self, body: usize) -> u32 {
        if self.of_body.len() <= body {
            self.of_body.resize(body + 1, NONE);
        }
        let place = &mut self.of_body[body];
        if *place == NONE {
            *place = self.count;
            self.count += 1;
        }
        *place
    }
}
