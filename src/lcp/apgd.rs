//! Accelerated projected gradient descent with adaptive restart (Nesterov 1983; O'Donoghue and Candes, Adaptive restart
//! for accelerated gradient schemes, 2015; for contact: Mazhar, Heyn, Negrut, Tasora 2015), in the metric of the
//! diagonal of `A`.
//!
//! With `y` the extrapolated point, `x+ = argmin_{x >= 0} g(y) . (x - y) + L/2 |x - y|^2`. One product per iteration:
//! the gradient at `y` is the same combination of gradients as `y` is of iterates. A step along which the curvature
//! exceeds `L` is rejected.

use super::drive::{Method, Point};
use super::loops::update;
use super::verbs::{Metric, Scalar, Verbs};

/// `L` shrinks by this factor per accepted step, so that it follows a falling curvature. On the stored systems, values
/// from 0.9 to 0.995 cost the same products within a third.
const RELAX: f64 = 0.98;

/// Margin over the curvature of a rejected step, so that the next step is accepted.
const MARGIN: f64 = 1.2;

/// A step is rejected if its curvature exceeds `L` by this part, or by this many roundings if that is more.
const SLACK: f64 = 1e-9;
const ROUNDING: f64 = 64.0;

pub(crate) struct Apgd<V: Verbs> {
    previous: Point<V::Vector>,
    ahead: Point<V::Vector>,
    next: Point<V::Vector>,
    step: V::Vector,
    rise: V::Vector,
    /// `L`, an estimate of the largest curvature in the metric.
    curvature: V::Scalar,
    /// Nesterov's `t`, from which the momentum comes.
    age: V::Scalar,
    momentum: V::Scalar,
}

impl<V: Verbs> Apgd<V> {
    pub fn new() -> Self {
        Apgd {
            previous: Point { x: V::Vector::default(), g: V::Vector::default() },
            ahead: Point { x: V::Vector::default(), g: V::Vector::default() },
            next: Point { x: V::Vector::default(), g: V::Vector::default() },
            step: V::Vector::default(),
            rise: V::Vector::default(),
            curvature: 1.0.into(),
            age: 1.0.into(),
            momentum: 0.0.into(),
        }
    }
}

impl<V: Verbs<Vector = Vec<f64>>> Apgd<V> {
    /// Moves the gradients that it keeps by `delta`, by which the offsets of the problem have moved.
    pub fn shift(&mut self, delta: &[f64]) {
        update(&mut self.previous.g, [delta], |g, [delta]| g + delta);
    }
}

impl<V: Verbs> Method<V> for Apgd<V> {
    fn begin(&mut self, verbs: &mut V, at: &Point<V::Vector>) {
        for point in [&mut self.previous, &mut self.ahead, &mut self.next] {
            verbs.clear(&mut point.x);
            verbs.clear(&mut point.g);
        }
        verbs.clear(&mut self.step);
        verbs.clear(&mut self.rise);
        verbs.copy(&at.x, &mut self.previous.x);
        verbs.copy(&at.g, &mut self.previous.g);
        (self.curvature, self.age, self.momentum) = (verbs.number(1.0), verbs.number(1.0), verbs.number(0.0));
    }

    fn step(&mut self, verbs: &mut V, at: &mut Point<V::Vector>) {
        let (zero, one) = (V::Scalar::from(0.0), V::Scalar::from(1.0));
        let (ahead, next) = (&mut self.ahead, &mut self.next);
        let beta = self.momentum;
        verbs.combine(one + beta, &at.x, -beta, &self.previous.x, &mut ahead.x);
        verbs.combine(one + beta, &at.g, -beta, &self.previous.g, &mut ahead.g);
        verbs.proximal(Metric::Diagonal, &ahead.x, one / self.curvature, &ahead.g, &mut next.x);
        verbs.gradient(&next.x, &mut next.g);

        verbs.combine(one, &next.x, -one, &ahead.x, &mut self.step);
        verbs.combine(one, &next.g, -one, &ahead.g, &mut self.rise);
        let length = verbs.square(Metric::Diagonal, &self.step);
        let bend = verbs.dot(&self.step, &self.rise);
        let slack = V::Scalar::from(1.0 + (ROUNDING * verbs.rounding()).max(SLACK));
        let refused = bend - self.curvature * length * slack;
        let accepted = refused.if_positive(zero, one);

        // Restart if the step points uphill for the gradient from which it was made.
        verbs.combine(one, &next.x, -one, &at.x, &mut self.step);
        let uphill = verbs.dot(&ahead.g, &self.step);
        verbs.copy_if_positive(accepted, &at.x, &mut self.previous.x);
        verbs.copy_if_positive(accepted, &at.g, &mut self.previous.g);
        verbs.copy_if_positive(accepted, &next.x, &mut at.x);
        verbs.copy_if_positive(accepted, &next.g, &mut at.g);

        // t+ = (1 + sqrt(1 + 4 t^2)) / 2, to within 2 % for t >= 1 and exact in the limit: t + 1/2 + 1/(8 t).
        let older = self.age + V::Scalar::from(0.5) + V::Scalar::from(0.125) / self.age;
        let age = uphill.if_positive(one, older);
        let momentum = uphill.if_positive(zero, (self.age - one) / age);
        self.age = refused.if_positive(self.age, age);
        self.momentum = refused.if_positive(self.momentum, momentum);
        let raised = (bend / length * V::Scalar::from(MARGIN)).max(self.curvature);
        self.curvature = refused.if_positive(raised, self.curvature * V::Scalar::from(RELAX));
    }

    fn refresh(&mut self, _: &mut V, _: &mut Point<V::Vector>) -> bool {
        true
    }
}
