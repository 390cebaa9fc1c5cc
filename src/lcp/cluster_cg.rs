//! Projected nonlinear conjugate gradients whose steps are the sum of the solutions of overlapping local LCPs.
//!
//! The method is that of [`super::pair_block_cg`] with a different `z`. The bodies are divided into clusters
//! ([`super::clusters`]), and each cluster with its neighbours has a local LCP over all rows `i` that touch it:
//!
//! ```text
//! minimize  g_i . d + 1/2 |J_i^T d|^2 + small |d|^2   over   x_i + d >= 0
//! ```
//!
//! A few steps of the same method from `d = 0` bring each local LCP near its solution. The displacements are added
//! without weights, because weights would destroy the self-stresses of clusters. So the sum overshoots where clusters
//! overlap; the remembered length corrects this factor. This is Schwarz's additive method for obstacle problems (L.
//! Badea, SIAM J. Numer. Anal. 41, 1052 (2003)) as the preconditioner of a descent method.
//!
//! The sum may lead to negative multipliers, which the projection sets to zero. If the projected direction hardly
//! descends, the step of the pairs replaces it.
//!
//! Near the end, steps of the clusters leave a few rows just above the tolerance while the objective still falls. Steps
//! of the pairs smooth these last iterations.

use super::drive::Point;
use super::pair_block_cg::{Descent, PairBlockCg};
use super::verbs::{InClusters, Past, Scalar};

/// The shortest trial length that is remembered: a row may be in up to eight clusters, so a sum without weights is up
/// to eight times too long, and bounds shorten the step further.
const SHORTEST: f64 = 0.02;

/// Steps of the pairs begin once the residual is at most this many tolerances.
const NEARLY: f64 = 4.0;

/// The number of consecutive steps of the pairs; then follow at least [`BETWEEN`] steps of the clusters.
const SMOOTH: f64 = 3.0;
const BETWEEN: f64 = 2.0;

/// Steps by clusters, smoothed by steps of the pairs near the end.
#[derive(Clone, Debug)]
pub(crate) struct ByClusters<T, S> {
    tolerance: f64,
    /// The step of the pairs.
    by_pairs: T,
    /// Iterations until steps of the pairs may begin again. Those beyond [`BETWEEN`] are still steps of the pairs.
    busy: S,
}

/// The method.
pub(crate) type ClusterCg<T, S> = PairBlockCg<T, S, ByClusters<T, S>>;

impl<T: Default, S: Scalar> ClusterCg<T, S> {
    /// For solves to this tolerance.
    pub fn to(tolerance: f64) -> Self {
        PairBlockCg::with(ByClusters { tolerance, by_pairs: T::default(), busy: 0.0.into() })
    }

    /// Sets the tolerance for subsequent solves.
    pub fn aim_at(&mut self, tolerance: f64) {
        self.descent.tolerance = tolerance;
    }
}

impl<T, S: Scalar> ByClusters<T, S> {
    /// Advances by an iteration at this residual. A positive result means that it is a step of the clusters.
    fn next(&mut self, residual: S) -> S {
        let near = S::from(NEARLY * self.tolerance) - residual;
        let begun = near.if_positive((SMOOTH + BETWEEN).into(), 0.0.into());
        let busy = self.busy.if_positive(self.busy, begun);
        self.busy = (busy - 1.0.into()).max(0.0.into());
        // Both are whole numbers, so a half separates them.
        S::from(BETWEEN + 0.5) - busy
    }
}

impl<V: InClusters> Descent<V> for ByClusters<V::Vector, V::Scalar> {
    const SHORTEST: f64 = SHORTEST;

    fn begin(&mut self, verbs: &mut V) {
        verbs.clear(&mut self.by_pairs);
        self.busy = verbs.number(0.0);
    }

    fn make(
        &mut self,
        verbs: &mut V,
        at: &Point<V::Vector>,
        [[d, ad], [e, ae]]: [Past<V::Vector>; 2],
        z: &mut V::Vector,
    ) -> [V::Scalar; 6] {
        let g = &at.g;
        let residual = verbs.residual(&at.x, &at.g);
        let in_clusters = self.next(residual);
        verbs.descend(&at.x, &at.g, &mut self.by_pairs);
        verbs.descend_in_clusters(in_clusters, [&at.x, g], self.tolerance, &self.by_pairs, z);
        verbs.dots([[g, d], [z, ad], [g, e], [z, ae], [d, ae], [g, z]])
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
        // A sequence that has begun is completed, whatever the residual.
        assert_eq!(kinds(1e-3, 6), "ppcccc");
        assert_eq!(kinds(f64::NAN, 2), "cc");
        assert_eq!(kinds(4e-6, 1), "c");
    }
}
