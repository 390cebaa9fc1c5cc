//! Projected nonlinear conjugate gradients whose steps are the sum of the solutions of overlapping local LCPs.
//!
//! The method is that of [`super::pair_block_cg`]; only `z` is another one. The bodies are parted into clusters
//! ([`super::clusters`]), and each cluster with its neighbours has a local LCP over all rows `i` that touch it:
//!
//! ```text
//! minimize  g_i . d + 1/2 |J_i^T d|^2 + small |d|^2   over   x_i + d >= 0
//! ```
//!
//! A few steps of the same method from `d = 0` bring each local LCP near its solution, and the displacements are added
//! without weights: a self-stress of a cluster stays one, which weights would spoil. So the sum overshoots where
//! clusters overlap; the remembered length finds the factor. This is Schwarz's additive method for obstacle problems
//! (L. Badea, SIAM J. Numer. Anal. 41, 1052 (2003)) as the preconditioner of a descent method.
//!
//! The sum may lead to something negative, which the projection takes back. Where the projected direction hardly
//! descends, the step of the pairs takes its place.
//!
//! Strong steps leave a few rows just above the tolerance while the objective still falls, so the last iterations are
//! smoothed by steps of the pairs.

use super::drive::Point;
use super::pair_block_cg::{Descent, PairBlockCg};
use super::verbs::{InClusters, Scalar};

/// The shortest trial length that is remembered: where a row is in up to eight clusters, a sum without weights is up to
/// eight times too long, and less where it meets bounds.
const SHORTEST: f64 = 0.02;

/// Steps of the pairs begin where the residual is at most so many tolerances.
const NEARLY: f64 = 4.0;

/// So many steps of the pairs follow each other, and then at least so many of the clusters.
const SMOOTH: f64 = 3.0;
const BETWEEN: f64 = 2.0;

/// Steps by clusters, smoothed by steps of the pairs near the end.
#[derive(Clone, Debug)]
pub(crate) struct ByClusters<T, S> {
    tolerance: f64,
    /// The step of the pairs.
    by_pairs: T,
    /// Iterations until steps of the pairs may begin again: the first of them, beyond [`BETWEEN`], are such steps.
    busy: S,
}

/// The method.
pub(crate) type ClusterCg<T, S> = PairBlockCg<T, S, ByClusters<T, S>>;

impl<T: Default, S: Scalar> ClusterCg<T, S> {
    /// For solves to this tolerance.
    pub fn to(tolerance: f64) -> Self {
        PairBlockCg::with(ByClusters { tolerance, by_pairs: T::default(), busy: 0.0.into() })
    }

    /// Ends at another tolerance from the next solve on.
    pub fn aim_at(&mut self, tolerance: f64) {
        self.descent.tolerance = tolerance;
    }
}

impl<T, S: Scalar> ByClusters<T, S> {
    /// Goes on by an iteration at this residual. A positive number says that it is one of the clusters.
    fn next(&mut self, residual: S) -> S {
        let near = S::from(NEARLY * self.tolerance) - residual;
        let begun = near.if_positive((SMOOTH + BETWEEN).into(), 0.0.into());
        let busy = self.busy.if_positive(self.busy, begun);
        self.busy = (busy - 1.0.into()).max(0.0.into());
        // Whole numbers: a half is between them.
        S::from(BETWEEN + 0.5) - busy
    }
}

impl<V: InClusters> Descent<V> for ByClusters<V::Vector, V::Scalar> {
    const SHORTEST: f64 = SHORTEST;

    fn begin(&mut self, verbs: &mut V) {
        verbs.clear(&mut self.by_pairs);
        self.busy = verbs.number(0.0);
    }

    fn make(&mut self, verbs: &mut V, at: &Point<V::Vector>, z: &mut V::Vector) {
        let residual = verbs.residual(&at.x, &at.g);
        let in_clusters = self.next(residual);
        verbs.descend(&at.x, &at.g, &mut self.by_pairs);
        verbs.descend_in_clusters(in_clusters, [&at.x, &at.g], self.tolerance, &self.by_pairs, z);
    }

    fn feasible<'a>(&'a self, _: &'a V::Vector) -> &'a V::Vector {
        &self.by_pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_the_pairs_come_by_threes_and_not_too_often() {
        let mut steps = ByClusters { tolerance: 1e-6, by_pairs: (), busy: 0.0 };
        let mut kinds = |residual: f64, count: usize| -> String {
            (0..count).map(|_| if steps.next(residual) > 0.0 { 'c' } else { 'p' }).collect()
        };
        assert_eq!(kinds(1e-3, 3), "ccc");
        assert_eq!(kinds(3e-6, 11), "pppccpppccp");
        // What is begun is ended, whatever the residual.
        assert_eq!(kinds(1e-3, 6), "ppcccc");
        assert_eq!(kinds(f64::NAN, 2), "cc");
        assert_eq!(kinds(4e-6, 1), "c");
    }
}
