//! Projected Jacobi with a step that is safe for every problem: `gamma <- max(0, gamma - w g / W)`, where `W` is a
//! diagonal majorant of `A` (see [`super::product::Product::majorant`]), so that every `0 < w < 2` descends (Cottle,
//! Pang, Stone: The linear complementarity problem, section 5.2).

use super::drive::{Method, PATIENCE_OF_SLOW_METHODS, Point};
use super::verbs::{Metric, Verbs};

/// Over-relaxation. The majorant is not sharp, so the largest safe steps are the fastest: 1.9 needs half the products
/// of 1.
const RELAXATION: f64 = 1.9;

#[derive(Default)]
pub(crate) struct ProjectedJacobi<T> {
    next: T,
}

impl<V: Verbs> Method<V> for ProjectedJacobi<V::Vector> {
    fn begin(&mut self, verbs: &mut V, _: &Point<V::Vector>) {
        verbs.clear(&mut self.next);
    }

    fn step(&mut self, verbs: &mut V, at: &mut Point<V::Vector>) {
        verbs.proximal(Metric::Majorant, &at.x, RELAXATION.into(), &at.g, &mut self.next);
        verbs.take(&mut self.next, &mut at.x);
        verbs.gradient(&at.x, &mut at.g);
    }

    fn refresh(&mut self, _: &mut V, _: &mut Point<V::Vector>) -> bool {
        true
    }

    fn patience(&self) -> u64 {
        PATIENCE_OF_SLOW_METHODS
    }
}
