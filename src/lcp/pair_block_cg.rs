//! Projected nonlinear conjugate gradients, preconditioned by the blocks of the pairs.
//!
//! One product an iteration. With `z` the projected gradient step of the blocks (each block's small problem solved exactly, see
//! [`super::pair_blocks`]) and `d` the displacement made last, the direction is `z + beta d` with `beta = -z . A d / d . A d`, which
//! makes it conjugate to `d` (Hestenes and Stiefel 1952). The trial point is projected in the metric of the blocks; along the
//! displacement to it the objective is minimized exactly, clipped at the first bound. A displacement that does not descend is
//! replaced by `z`, which does. The length of the trial step remembers the last optimum.

use super::drive::{Method, Point};
use super::verbs::{Metric, Scalar, Verbs};

/// Bounds of the remembered trial length.
const SHORTEST: f64 = 0.05;
const LONGEST: f64 = 2.0;

pub(crate) struct PairBlockCg<V: Verbs> {
    /// `z`.
    gradient_step: V::Vector,
    /// `d` and `A d`.
    made: V::Vector,
    made_product: V::Vector,
    trial: V::Vector,
    displacement: V::Vector,
    product: V::Vector,
    /// `d . A d`.
    bend: V::Scalar,
    length: V::Scalar,
}

impl<V: Verbs> PairBlockCg<V> {
    pub fn new() -> Self {
        PairBlockCg {
            gradient_step: V::Vector::default(),
            made: V::Vector::default(),
            made_product: V::Vector::default(),
            trial: V::Vector::default(),
            displacement: V::Vector::default(),
            product: V::Vector::default(),
            bend: 0.0.into(),
            length: 1.0.into(),
        }
    }
}

impl<V: Verbs> Method<V> for PairBlockCg<V> {
    fn begin(&mut self, verbs: &mut V, _: &Point<V::Vector>) {
        for vector in [
            &mut self.gradient_step,
            &mut self.made,
            &mut self.made_product,
            &mut self.trial,
            &mut self.displacement,
            &mut self.product,
        ] {
            verbs.clear(vector);
        }
        (self.bend, self.length) = (0.0.into(), 1.0.into());
    }

    fn step(&mut self, verbs: &mut V, at: &mut Point<V::Vector>) {
        let (zero, one) = (V::Scalar::from(0.0), V::Scalar::from(1.0));
        let metric = Metric::PairBlocks;

        verbs.proximal(metric, &at.x, self.length, &at.g, &mut self.trial);
        verbs.combine(one, &self.trial, -one, &at.x, &mut self.gradient_step);
        let coupled = verbs.dot(&self.gradient_step, &self.made_product);
        let beta = self.bend.if_positive(-coupled / self.bend, zero);

        verbs.combine(one, &self.gradient_step, beta, &self.made, &mut self.displacement);
        verbs.add(one, &at.x, &mut self.displacement);
        verbs.project(metric, &self.displacement, &mut self.trial);
        verbs.combine(one, &self.trial, -one, &at.x, &mut self.displacement);
        let slope = verbs.dot(&at.g, &self.displacement);
        verbs.copy_if_positive(slope, &self.gradient_step, &mut self.displacement);

        verbs.product(&self.displacement, &mut self.product);
        let slope = verbs.dot(&at.g, &self.displacement);
        let bend = verbs.dot(&self.displacement, &self.product);
        let room = verbs.room(&at.x, &self.displacement);
        let best = bend.if_positive(-slope / bend, one);
        let part = best.max(zero).min(room);
        verbs.add(part, &self.displacement, &mut at.x);
        verbs.project(Metric::Diagonal, &at.x, &mut self.trial);
        verbs.copy(&self.trial, &mut at.x);
        verbs.add(part, &self.product, &mut at.g);
        verbs.combine(part, &self.displacement, zero, &self.displacement, &mut self.made);
        verbs.combine(part, &self.product, zero, &self.product, &mut self.made_product);
        self.bend = part * part * bend;
        self.length = (self.length * best).max(SHORTEST.into()).min(LONGEST.into());
    }

    fn refresh(&mut self, _: &mut V, _: &mut Point<V::Vector>) -> bool {
        false
    }
}
