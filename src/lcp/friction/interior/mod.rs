//! A primal-dual interior-point method for the exact law, where iterations over cones do not converge: large
//! coefficients of friction, and wedges.
//!
//! With its normal numbers scaled by `mu` a friction cone is the Lorentz cone `L = { |t| <= n }`, and the law is
//!
//! ```text
//! L contains x  _|_  y in L,   y_n = g_n + |y_t|,   y_t = g_t,   g = q + A x
//! ```
//!
//! `|y_t|` is De Saxce's correction. Steps are Newton's on these equations with `x o y = centre` in the scaling of
//! Nesterov and Todd, with the derivative of the correction: the correction converges with the multipliers, while a
//! method that holds it and substitutes may cycle. With `P = [1, -y_t / |y_t|; 0, 1]` for each unit,
//!
//! ```text
//! P dy = A dx + r,   dy = W c - W^2 dx,   (A + P W^2) dx = P W c - r
//! ```
//!
//! `A = J J^T + k`, so that a step factorizes one matrix `I + J^T (P W^2 + k)^-1 J`, with a block per body; it is not
//! symmetric. Predictor and centring are Mehrotra's. The law is not monotone, and a path may end at a point that is no
//! solution: the method then starts again from elsewhere.
//!
//! Sources: V. Acary, P. Armand, H. M. Nguyen, O. Shpakovych, Second-order cone programming for frictional contact
//! mechanics using interior point algorithm, Optimization Methods and Software, 2024 (the law with held corrections);
//! `lorentz` for the scaling.

mod lorentz;
mod normal;
mod scaled;

use super::cone::{Triple, dot};
use super::rows::Frictional;
use super::unit::plus;
use crate::lcp::Settings;
use crate::lcp::verbs::Verbs;
use lorentz::Scaling;
use nalgebra::Matrix3;
use normal::NormalMatrix;
use scaled::Scaled;

/// The largest number of moving bodies, in the plane and in space. Factors of planar crowds stay sparse; those in space
/// are nearly dense.
const MOST_BODIES: [usize; 2] = [1_000, 150];

/// Steps of a start.
const MOST_STEPS: u64 = 50;

/// The scale of the first multipliers and gaps in units of the deepest violation, and the least centring, of each
/// start.
const STARTS: [(f64, f64); 4] = [(1.0, 0.0), (0.01, 0.0), (0.1, 0.1), (0.001, 0.1)];

/// What is added to the diagonal of `A`, whose rows have length one.
const REGULARIZATION: f64 = 1e-12;

/// The part of the way to the boundary that a step leaves, at least and at most.
const SHORTEST_OF: f64 = 1e-6;
const LONGEST_OF: f64 = 3e-2;

/// So many steps in a row that are shorter than this end a start. Starts of a wedge take up to 15 steps of 1e-4 to 1e-2
/// in which its multipliers grow, and then converge.
const SHORT: f64 = 1e-6;
const MOST_SHORT: u32 = 4;

/// The state of a unit: multipliers and slacks, both inside of the cone, and what a step needs.
#[derive(Clone, Copy, Debug, Default)]
struct Inner {
    x: Triple,
    y: Triple,
    /// What the equations are off by.
    off: Triple,
    scaling: Scaling,
    /// `W x = W^-1 y`.
    middle: Triple,
}

impl Inner {
    /// `P z`; `z` where corrections are held.
    fn corrected(&self, z: Triple, held: bool) -> Triple {
        let t = lorentz::tangential(self.y);
        if t > 0.0 && !held { [z[0] - (self.y[1] * z[1] + self.y[2] * z[2]) / t, z[1], z[2]] } else { z }
    }
}

/// A direction of a unit.
type Change = (Triple, Triple);

/// The solver. Its buffers are reused for the next problem.
#[derive(Default)]
pub(super) struct Interior<const D: usize> {
    units: Vec<Scaled<D>>,
    inner: Vec<Inner>,
    weight: Vec<[Triple; 3]>,
    matrix: NormalMatrix<D>,
    velocity: Vec<[f64; D]>,
    predicted: Vec<Change>,
    change: Vec<Change>,
    right: Vec<Change>,
    deepest: f64,
    /// Whether corrections are held: the problem is convex.
    held: bool,
    /// Factorizations of the present problem.
    pub factorizations: u64,
}

impl<const D: usize> Interior<D> {
    /// Whether a problem is not too large. Its bodies are those that rows refer to, walls among them.
    pub fn suits(&self, rows: &Frictional<D>) -> bool {
        rows.product().bodies() <= if D > 3 { MOST_BODIES[1] } else { MOST_BODIES[0] }
    }

    /// Searches for multipliers of the exact law, or of the problem with corrections held. `x` becomes the best ones
    /// found, where they are better than those of residual `least`; the residual that they have is returned.
    ///
    /// Takes at most `max_iterations` steps in all.
    pub fn run(&mut self, rows: &mut Frictional<D>, x: &mut Vec<f64>, settings: &Settings, mut least: f64) -> f64 {
        self.factorizations = 0;
        self.held = rows.held || rows.relaxed;
        self.load(rows);
        if !self.matrix.analyse(&self.units, self.velocity.len()) {
            return least;
        }
        let (mut tried, mut g) = (x.clone(), Vec::new());
        rows.clear(&mut g);
        for (size, centring) in STARTS {
            self.start(size);
            let mut short = 0;
            for _ in 0..=MOST_STEPS {
                self.export(&mut tried);
                rows.gradient(&tried, &mut g);
                let residual = rows.residual(&tried, &g);
                if residual < least {
                    least = residual;
                    x.clone_from(&tried);
                }
                if residual <= settings.tolerance {
                    return least;
                }
                if self.factorizations >= settings.max_iterations || !residual.is_finite() {
                    break;
                }
                let Some(length) = self.step(centring) else { break };
                short = if length < SHORT { short + 1 } else { 0 };
                if short >= MOST_SHORT {
                    break;
                }
            }
            log::trace!("interior point from {size}: {} factorizations, residual {least:.2e}", self.factorizations);
        }
        least
    }

    /// Takes the units that feel their multipliers.
    fn load(&mut self, rows: &Frictional<D>) {
        let bodies = scaled::rebuild(rows, self.held, &mut self.units);
        self.velocity.clear();
        self.velocity.resize(bodies, [0.0; D]);
        let deep = |most: f64, unit: &Scaled<D>| most.max(-unit.q[0]);
        self.deepest = self.units.iter().filter(|unit| !unit.unit.free).fold(0.0, deep);
        if self.deepest == 0.0 {
            let any = |most: f64, unit: &Scaled<D>| unit.q.iter().fold(most, |most, q| most.max(q.abs()));
            self.deepest = self.units.iter().fold(f64::MIN_POSITIVE, any);
        }
    }

    /// A start on the axes of all cones.
    fn start(&mut self, size: f64) {
        let size = size * self.deepest;
        self.inner.clear();
        self.inner.extend(self.units.iter().map(|unit| match unit.unit.free {
            true => Inner::default(),
            false => Inner { x: [size, 0.0, 0.0], y: [size + unit.q[0].max(0.0), 0.0, 0.0], ..Inner::default() },
        }));
    }

    /// The multipliers of the problem's rows.
    fn export(&self, x: &mut [f64]) {
        for (unit, inner) in self.units.iter().zip(&self.inner) {
            let own = std::array::from_fn(|i| unit.scale[i] * inner.x[i]);
            unit.unit.put(unit.unit.project(own), x);
        }
    }

    /// Takes a step and returns its part of Newton's; none if numbers do not allow one.
    fn step(&mut self, least_centring: f64) -> Option<f64> {
        self.prepare()?;
        let (mut predicted, mut change) = (std::mem::take(&mut self.predicted), std::mem::take(&mut self.change));
        self.newton(|_, inner| lorentz::product(inner.middle, inner.middle).map(|z| -z), &mut predicted);
        let part = self.room(&predicted).min(1.0);
        let cones = self.units.iter().filter(|unit| !unit.unit.free).count().max(1) as f64;
        let gap = |part: f64, predicted: &[Change]| {
            let of = |(inner, (dx, dy)): (&Inner, &Change)| dot(plus(inner.x, part, *dx), plus(inner.y, part, *dy));
            self.inner.iter().zip(predicted).map(of).sum::<f64>() / cones
        };
        let now = gap(0.0, &predicted);
        let centre = (gap(part, &predicted) / now).powi(3).clamp(least_centring, 1.0) * now;
        let pull = |at: usize, inner: &Inner| {
            let (dx, dy) = predicted[at];
            let second = lorentz::product(inner.scaling.invert(dy), inner.scaling.apply(dx));
            let now = lorentz::product(inner.middle, inner.middle);
            [centre - now[0] - second[0], -now[1] - second[1], -now[2] - second[2]]
        };
        self.newton(pull, &mut change);
        let short = (1.0 - part).clamp(SHORTEST_OF, LONGEST_OF);
        let length = ((1.0 - short) * self.room(&change)).min(1.0);
        for (inner, (dx, dy)) in self.inner.iter_mut().zip(&change) {
            (inner.x, inner.y) = (plus(inner.x, length, *dx), plus(inner.y, length, *dy));
        }
        (self.predicted, self.change) = (predicted, change);
        length.is_finite().then_some(length)
    }

    /// What the equations are off by, the scalings, and the factors of the matrix.
    fn prepare(&mut self) -> Option<()> {
        self.velocity.fill([0.0; D]);
        for (unit, inner) in self.units.iter().zip(&self.inner) {
            unit.add_to(inner.x, &mut self.velocity);
        }
        self.weight.clear();
        for (unit, inner) in self.units.iter().zip(&mut self.inner) {
            let along = unit.along(&self.velocity);
            let gap = |i: usize| along[i] + unit.q[i] + unit.compliance[i] * inner.x[i] - inner.y[i];
            inner.off = std::array::from_fn(|i| if i < unit.count { gap(i) } else { 0.0 });
            let mut block = [[0.0; 3]; 3];
            if !unit.unit.free {
                if !self.held {
                    inner.off[0] += lorentz::tangential(inner.y);
                }
                inner.scaling = Scaling::new(inner.x, inner.y);
                inner.middle = inner.scaling.apply(inner.x);
                let square = inner.scaling.square();
                // `P W^2`, by its columns.
                for k in 0..3 {
                    let column = inner.corrected([square[0][k], square[1][k], square[2][k]], self.held);
                    (0..3).for_each(|i| block[i][k] = column[i]);
                }
            }
            for (i, (row, compliance)) in block.iter_mut().zip(unit.compliance).enumerate() {
                row[i] += compliance + REGULARIZATION;
            }
            let block = Matrix3::from_fn(|i, k| block[i][k]);
            let inverse = block.full_piv_lu().try_inverse()?;
            self.weight.push(std::array::from_fn(|i| std::array::from_fn(|k| inverse[(i, k)])));
        }
        self.factorizations += 1;
        self.matrix.factorize(&self.units, &self.weight).then_some(())
    }

    /// Newton's direction towards equations that hold and products `x o y` that change by `pull`, in the scaling.
    fn newton(&mut self, pull: impl Fn(usize, &Inner) -> Triple, out: &mut Vec<Change>) {
        let weigh = |weight: &[Triple; 3], z: Triple| weight.map(|row| dot(row, z));
        self.velocity.fill([0.0; D]);
        self.right.clear();
        for (at, ((unit, inner), weight)) in self.units.iter().zip(&self.inner).zip(&self.weight).enumerate() {
            let moved = match unit.unit.free {
                true => [0.0; 3],
                false => lorentz::quotient(inner.middle, pull(at, inner)),
            };
            let right = if unit.unit.free { [0.0; 3] } else { inner.corrected(inner.scaling.apply(moved), self.held) };
            let right = plus(right, -1.0, inner.off);
            unit.add_to(weigh(weight, right), &mut self.velocity);
            self.right.push((right, moved));
        }
        self.matrix.solve(&mut self.velocity);
        out.clear();
        for (at, (right, moved)) in self.right.iter().enumerate() {
            let (unit, inner) = (&self.units[at], &self.inner[at]);
            let dx = weigh(&self.weight[at], plus(*right, -1.0, unit.along(&self.velocity)));
            let dy = match unit.unit.free {
                true => [0.0; 3],
                false => inner.scaling.apply(plus(*moved, -1.0, inner.scaling.apply(dx))),
            };
            out.push((dx, dy));
        }
    }

    /// The part of a direction up to the first boundary.
    fn room(&self, change: &[Change]) -> f64 {
        let of = |((unit, inner), (dx, dy)): ((&Scaled<D>, &Inner), &Change)| match unit.unit.free {
            true => f64::INFINITY,
            false => lorentz::room(inner.x, *dx).min(lorentz::room(inner.y, *dy)),
        };
        self.units.iter().zip(&self.inner).zip(change).map(of).fold(f64::INFINITY, f64::min)
    }
}
