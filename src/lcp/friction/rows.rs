//! The vector verbs for rows with friction cones, in f64, on one thread: what a projection on `gamma >= 0` is for rows
//! alone is one on `K` for the rows of a cone. A free row is not projected.
//!
//! Rows are sorted by pair, bodies being numbered by shared rows (`lcp::numbering`), so the units of a pair stand
//! together, each with its rows in their order. Sums run over all rows in this order.

use super::cone;
use super::follow::Follow;
use super::pace::Measured;
use super::pairs::Pairs;
use super::unit::Unit;
use crate::lcp::cone::worse;
use crate::lcp::loops::{dots, map, update};
use crate::lcp::product::{Product, ZERO_ROW};
use crate::lcp::verbs::{Checks, Metric, Verbs};
use crate::lcp::{Cone, Problem, numbering, pair_blocks};

/// A problem with cones, prepared for the solvers. Its buffers are reused for the next problem.
#[derive(Default)]
pub(crate) struct Frictional<const D: usize> {
    /// Each row's index in the problem.
    order: Vec<u32>,
    /// With the corrections on normal rows.
    q: Vec<f64>,
    /// What is added to the diagonal of `A`.
    compliance: Vec<f64>,
    /// The largest diagonal entry of each row's unit, and its inverse, zero for what is not live.
    metric: Vec<f64>,
    inverse: Vec<f64>,
    product: Product<D>,
    units: Vec<Unit>,
    pairs: Pairs,
    follow: Follow,
    /// The law without corrections: the convex relaxation of Anitescu and Tasora, for comparison.
    pub(super) relaxed: bool,
    /// Whether the corrections stay as they are: the problem is convex.
    pub(super) held: bool,
    /// At the last residual.
    pub(super) measured: Measured,
    delta: Vec<f64>,
    products: u64,
    noted: Vec<f64>,
    finite: bool,
}

impl<const D: usize> Frictional<D> {
    /// Loads a problem that [`Problem::check`] approves of.
    pub fn rebuild(&mut self, problem: &Problem<D>) {
        let mut place = Vec::new();
        numbering::rebuild(problem.bodies, &problem.pair, &problem.jacobian, &mut place);
        let numbered: Vec<[u32; 2]> = problem.pair.iter().map(|pair| pair.map(|body| place[body as usize])).collect();
        pair_blocks::by_pair(&numbered, &mut self.order);
        let of_rows = |numbers: &[f64]| self.order.iter().map(|row| numbers[*row as usize]).collect();
        self.q = of_rows(&problem.q);
        self.compliance =
            if problem.compliance.is_empty() { vec![0.0; self.q.len()] } else { of_rows(&problem.compliance) };
        self.product.rebuild(problem.bodies, &numbered, &problem.jacobian, &self.order);
        self.find_units(&problem.cones);
        self.pairs.rebuild(&self.product, &self.units, &self.compliance);
        self.follow.restart(self.units.len());
        self.held = false;
        self.delta.clear();
        self.delta.resize(self.q.len(), 0.0);
        self.products = 0;
        self.noted.clear();
    }

    /// Makes the units of rows in order, and what belongs to their diagonals.
    fn find_units(&mut self, cones: &[Cone]) {
        let plain = self.product.diagonal();
        let diagonal: Vec<f64> = plain.iter().zip(&self.compliance).map(|(s, k)| s + k).collect();
        let zero = ZERO_ROW * plain.iter().fold(0.0, |largest: f64, s| largest.max(*s));
        self.finite = self.q.iter().chain(&diagonal).all(|number| number.is_finite());
        self.units.clear();
        self.metric.clear();
        self.inverse.clear();
        for (row, at) in self.order.iter().enumerate() {
            let (count, mu) = match cones[*at as usize] {
                Cone::Ray => (1, 0.0),
                Cone::Friction(mu) => (1 + super::tangents::<D>(), mu),
                Cone::Free | Cone::Linked => (1, 0.0),
                Cone::Tangent => continue,
            };
            let cone = cones[*at as usize];
            let is_free = cone.is_free();
            let mut unit = if is_free { Unit::free(row) } else { Unit::new(row, count, mu) };
            unit.linked = cone == Cone::Linked;
            let own = &diagonal[unit.rows()];
            // A free row with a compliance feels its multiplier in any case.
            let live = plain[row] > zero || (is_free && self.compliance[row] > 0.0);
            (unit.live, unit.scale) = (live, own.iter().sum::<f64>() / count as f64);
            unit.most = 1.0 + mu * mu * own[1..].iter().fold(0.0, |largest: f64, s| largest.max(*s)) / own[0];
            let largest = own.iter().fold(0.0, |largest: f64, s| largest.max(*s));
            self.metric.resize(row + count, largest);
            self.inverse.resize(row + count, if unit.live { 1.0 / largest } else { 0.0 });
            self.units.push(unit);
        }
    }

    /// Whether every number of the problem is finite, and so is the diagonal.
    pub fn is_finite(&self) -> bool {
        self.finite
    }

    /// Puts multipliers into `K`, in the order here. Units with a number that is not finite become zero.
    pub fn import(&self, gamma: &[f64], x: &mut Vec<f64>) {
        x.clear();
        x.extend(self.order.iter().map(|row| gamma[*row as usize]));
        for unit in &self.units {
            unit.put(unit.admit(unit.get(x)), x);
        }
    }

    /// Takes the multipliers of linked rows to the solution of their equations with those of all other rows as they
    /// are: from elsewhere contacts would push against motions that these rows do not allow.
    pub fn eliminate(&mut self, x: &mut Vec<f64>) {
        if self.finite && self.pairs.has_linked() {
            let g = self.gaps(x);
            self.pairs.eliminate(x, &g);
        }
    }

    /// Multipliers in the problem's order of rows.
    pub fn export(&self, x: &[f64], gamma: &mut [f64]) {
        for (row, x) in self.order.iter().zip(x) {
            gamma[*row as usize] = *x;
        }
    }

    /// The units, in the order of rows here.
    pub(super) fn units(&self) -> &[Unit] {
        &self.units
    }

    /// The rows of `J`.
    pub fn product(&self) -> &Product<D> {
        &self.product
    }

    /// What is added to the diagonal of `A`.
    pub fn compliance(&self) -> &[f64] {
        &self.compliance
    }

    /// The offset of a row of unit number `unit`, with its correction or without.
    pub fn offset(&self, unit: usize, row: usize, corrected: bool) -> f64 {
        let is_normal = row == self.units[unit].rows().start;
        let correction = if is_normal && !corrected { self.follow.offset(unit) } else { 0.0 };
        self.q[row] - correction
    }

    /// What the last residual is made of.
    #[cfg(all(test, feature = "gpu"))]
    pub fn measured(&self) -> Measured {
        self.measured
    }

    /// Counts products from zero.
    pub fn restart_count(&mut self) {
        self.products = 0;
    }

    /// Holds the corrections that belong to these multipliers.
    pub fn hold(&mut self, x: &Vec<f64>) {
        let mut g = self.gaps(x);
        self.follow(&mut g);
        self.held = true;
    }

    /// The largest overlap that held corrections leave at these multipliers. Those that leave some are lowered to what
    /// belongs to the slips, or all of them to nothing.
    pub fn lower(&mut self, x: &Vec<f64>, to_nothing: bool) -> f64 {
        let g = self.gaps(x);
        let overlap = |(at, unit): (usize, &Unit)| self.follow.offset(at) - unit.get(&g)[0];
        let contacts = self.units.iter().enumerate().filter(|(_, unit)| !unit.free);
        let worst = contacts.map(overlap).fold(0.0, worse);
        self.follow.lower(&self.units, if to_nothing { None } else { Some(&g) }, &mut self.delta);
        update(&mut self.q, [&self.delta], |q, [delta]| q + delta);
        worst
    }

    /// The gaps and slips, with corrections.
    fn gaps(&mut self, x: &Vec<f64>) -> Vec<f64> {
        let mut g = Vec::new();
        self.clear(&mut g);
        self.gradient(x, &mut g);
        g
    }

    /// Moves the corrections towards those of the gaps and slips `g`, and `g` along. Returns what its rows moved by.
    pub fn follow(&mut self, g: &mut [f64]) -> &[f64] {
        if !self.relaxed {
            self.follow.update(&self.units, g, &mut self.delta);
            update(g, [&self.delta], |g, [delta]| g + delta);
            update(&mut self.q, [&self.delta], |q, [delta]| q + delta);
        }
        &self.delta
    }
}

impl<const D: usize> Verbs for Frictional<D> {
    type Vector = Vec<f64>;
    type Scalar = f64;

    fn clear(&mut self, x: &mut Vec<f64>) {
        x.clear();
        x.resize(self.q.len(), 0.0);
    }

    fn copy(&mut self, from: &Vec<f64>, to: &mut Vec<f64>) {
        to.clone_from(from);
    }

    fn copy_if_positive(&mut self, condition: f64, from: &Vec<f64>, to: &mut Vec<f64>) {
        if condition > 0.0 {
            to.clone_from(from);
        }
    }

    fn take(&mut self, from: &mut Vec<f64>, to: &mut Vec<f64>) {
        std::mem::swap(from, to);
    }

    fn product(&mut self, x: &Vec<f64>, ax: &mut Vec<f64>) {
        self.products += 1;
        self.product.apply(x, ax);
        update(ax, [x, &self.compliance], |ax, [x, k]| ax + k * x);
    }

    fn gradient(&mut self, x: &Vec<f64>, g: &mut Vec<f64>) {
        self.product(x, g);
        update(g, [&self.q], |ax, [q]| ax + q);
    }

    fn dot(&mut self, x: &Vec<f64>, y: &Vec<f64>) -> f64 {
        let [sum] = self.dots([[x, y]]);
        sum
    }

    fn dots<const N: usize>(&mut self, pairs: [[&Vec<f64>; 2]; N]) -> [f64; N] {
        dots(0..self.q.len(), pairs.map(|pair| pair.map(Vec::as_slice)))
    }

    fn twice_objective(&mut self, x: &Vec<f64>, g: &Vec<f64>) -> f64 {
        let [linear, all] = dots(0..self.q.len(), [[x, &self.q], [x, g]]);
        linear + all
    }

    fn combine(&mut self, a: f64, x: &Vec<f64>, b: f64, y: &Vec<f64>, out: &mut Vec<f64>) {
        map(out, [x, y], |[x, y]| a * x + b * y);
    }

    fn add(&mut self, a: f64, x: &Vec<f64>, y: &mut Vec<f64>) {
        update(y, [x], |y, [x]| y + a * x);
    }

    /// In a metric that has one number a cone, so that the step is a projection.
    fn proximal(&mut self, metric: Metric, x: &Vec<f64>, step: f64, g: &Vec<f64>, out: &mut Vec<f64>) {
        map(out, [x, g, self.inverse_of(metric)], |[x, g, inverse]| x - step * g * inverse);
        self.project(out);
    }

    fn descend(&mut self, x: &Vec<f64>, g: &Vec<f64>, out: &mut Vec<f64>) {
        self.pairs.descend(&self.units, x, g, out);
        self.displace_from(x, out);
    }

    fn displace(&mut self, x: &Vec<f64>, terms: [(f64, &Vec<f64>); 3], out: &mut Vec<f64>, room: &mut Vec<f64>) {
        let [(a, first), (b, second), (c, third)] = terms;
        map(room, [x, first, second, third], |[x, p, q, r]| x + a * p + b * q + c * r);
        self.pairs.project(&self.units, room, out);
        self.displace_from(x, out);
    }

    fn advance(&mut self, a: f64, d: &Vec<f64>, x: &mut Vec<f64>, _: &mut Vec<f64>) {
        update(x, [d], |x, [d]| x + a * d);
        self.project(x);
    }

    fn square(&mut self, metric: Metric, x: &Vec<f64>) -> f64 {
        let _ = self.inverse_of(metric);
        self.metric.iter().zip(x).fold(0.0, |sum, (s, x)| sum + s * x * x)
    }

    fn inverse_square(&mut self, metric: Metric, x: &Vec<f64>) -> f64 {
        self.inverse_of(metric).iter().zip(x).fold(0.0, |sum, (s, x)| sum + s * x * x)
    }

    fn ratio_test(&mut self, x: &Vec<f64>, d: &Vec<f64>) -> f64 {
        let room = |unit: &Unit| unit.room(unit.get(x), unit.get(d));
        self.units.iter().map(room).fold(f64::INFINITY, f64::min)
    }

    /// That of the exact law: with `mu |s|` in place of the corrections.
    fn residual(&mut self, x: &Vec<f64>, g: &Vec<f64>) -> f64 {
        let (mut law, mut measured) = (0.0, Measured::default());
        for (at, unit) in self.units.iter().enumerate() {
            let (x, g) = (unit.get(x), unit.get(g));
            let of = |g| unit.residual(x, g);
            let cones = of(g);
            measured.cones = worse(measured.cones, cones);
            if self.relaxed || self.held || unit.mu == 0.0 {
                law = worse(law, cones);
                if !unit.free {
                    // Beside a multiplier that grows without end the residual of an overlap is lost to rounding.
                    law = worse(law, -g[0]);
                }
                continue;
            }
            let change = unit.mu * cone::tangential(g) - self.follow.offset(at);
            measured.change = worse(measured.change, change.abs());
            law = worse(law, of([g[0] + change, g[1], g[2]]));
            // A cone that is wide open shows little of an overlap.
            law = worse(law, self.follow.offset(at) - g[0]);
        }
        self.measured = measured;
        law
    }

    fn read(&mut self, scalar: f64) -> f64 {
        scalar
    }

    fn check(&mut self, residual: f64, _: f64) {
        self.noted.push(residual);
    }

    fn take_checks(&mut self) -> Checks {
        Checks { residuals: std::mem::take(&mut self.noted), ended: false }
    }

    fn products(&self) -> u64 {
        self.products
    }
}

impl<const D: usize> Frictional<D> {
    fn project(&self, x: &mut [f64]) {
        for unit in &self.units {
            unit.put(unit.project(unit.get(x)), x);
        }
    }

    /// Makes points displacements from others.
    fn displace_from(&self, x: &[f64], y: &mut [f64]) {
        for unit in &self.units {
            unit.put(unit.displacement(unit.get(x), unit.get(y)), y);
        }
    }

    /// The metric has no majorant: the solvers here do without.
    fn inverse_of(&self, metric: Metric) -> &[f64] {
        assert!(metric == Metric::Diagonal, "no majorant of cones");
        &self.inverse
    }
}
