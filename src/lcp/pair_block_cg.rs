//! Projected nonlinear conjugate gradients, preconditioned by the blocks of the pairs.
//!
//! Each iteration needs one product. Let `z` be the projected gradient step of the blocks (each block's small problem
//! solved exactly, see [`super::pair_blocks`]) and `d`, `e` the last two displacements, whose products are known. The
//! direction is `z + a d + b e` with the `a` and `b` that minimize the objective: `H (a, b) = -(g + A z) . (d, e)` with
//! `H` the `A`-products of `d` and `e`. Without bounds this is the method of Hestenes and Stiefel (1952), `b = 0` and
//! `a = -z . A d / d . A d`; with bounds, `g . d` is the remainder of a clipped line search, and `e` corrects the loss
//! of conjugacy by projections.
//!
//! The trial point is projected in the metric of the blocks. Along the displacement to it the objective is minimized
//! exactly, clipped at the first bound, so it never rises. A displacement that descends much less than `z` is replaced
//! by `z`, or by the `z` of the pairs if another `z` may lead to negative multipliers. The length of the next trial
//! step is the last optimum.

use super::drive::{Method, Point};
use super::verbs::{Past, Scalar, Verbs};
use std::ops::Range;

/// Bounds of the remembered trial length. On the stored systems an upper bound of 1 costs up to a fifth more products
/// if pairs have several rows; 2 to 64 cost the same.
pub(crate) const SHORTEST: f64 = 0.05;
pub(crate) const LONGEST: f64 = 8.0;

/// A displacement must descend by at least this part of the descent of `z`.
pub(crate) const DESCENT: f64 = 1e-3;

/// Relative addition to the diagonal of `H`: two displacements that are parallel to eight digits count as one.
pub(crate) const REGULARIZATION: f64 = 1e-8;

/// The same in units of rounding, if that is more: the entries of `H` are long sums.
pub(crate) const ROUNDING: f64 = 64.0;

/// How `z` is computed.
pub(crate) trait Descent<V: Verbs> {
    /// The shortest trial length that is remembered.
    const SHORTEST: f64;
    /// Restarts.
    fn begin(&mut self, verbs: &mut V);
    /// Computes `z` at a point; the objective falls along it. Returns what [`Verbs::descend_beside`] does.
    fn make(
        &mut self,
        verbs: &mut V,
        at: &Point<V::Vector>,
        past: [Past<V::Vector>; 2],
        z: &mut V::Vector,
    ) -> [V::Scalar; 6];
    /// For the last `z`, a displacement that keeps all multipliers admissible, along which the objective falls too.
    fn feasible<'a>(&'a self, z: &'a V::Vector) -> &'a V::Vector;
}

/// `z` by the blocks of the pairs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ByPairs;

impl<V: Verbs> Descent<V> for ByPairs {
    const SHORTEST: f64 = SHORTEST;

    fn begin(&mut self, _: &mut V) {}

    fn make(
        &mut self,
        verbs: &mut V,
        at: &Point<V::Vector>,
        past: [Past<V::Vector>; 2],
        z: &mut V::Vector,
    ) -> [V::Scalar; 6] {
        verbs.descend_beside([&at.x, &at.g], past, z)
    }

    fn feasible<'a>(&'a self, z: &'a V::Vector) -> &'a V::Vector {
        z
    }
}

/// A past displacement and its product.
#[derive(Clone, Debug)]
struct Direction<T> {
    displacement: T,
    product: T,
}

impl<T: Default> Direction<T> {
    fn none() -> Self {
        Direction { displacement: T::default(), product: T::default() }
    }
}

/// The method, over vectors `T` and scalars `S`, with `z` computed by `B`.
#[derive(Clone, Debug)]
pub(crate) struct PairBlockCg<T, S, B = ByPairs> {
    /// How `z` is computed.
    pub(super) descent: B,
    /// `z`.
    gradient_step: T,
    /// Scratch space; its content between two iterations is undefined.
    room: T,
    /// `d`, `e`, and the next displacement.
    made: [Direction<T>; 3],
    /// `d . A d` and `e . A e`, zero when there is none.
    curvature: [S; 2],
    length: S,
    /// The residual after the last iteration, if it is known.
    residual: Option<S>,
    /// Whether the next solve keeps the displacements.
    goes_on: bool,
}

impl<T: Default, S: Scalar> PairBlockCg<T, S> {
    pub fn new() -> Self {
        PairBlockCg::with(ByPairs)
    }
}

impl<T: Default, S: Scalar, B> PairBlockCg<T, S, B> {
    /// Whether the next solve continues the last one at its last iterate: it then keeps the displacements.
    pub fn keep_displacements(&mut self, same: bool) {
        self.goes_on = same;
    }

    /// The method with this way to compute `z`.
    pub fn with(descent: B) -> Self {
        PairBlockCg {
            descent,
            goes_on: false,
            gradient_step: T::default(),
            room: T::default(),
            made: [Direction::none(), Direction::none(), Direction::none()],
            curvature: [0.0.into(); 2],
            length: 1.0.into(),
            residual: None,
        }
    }

    /// Computes `z`. Returns the `a` and `b` of the direction, and `g . z`.
    fn parts<V: Verbs<Vector = T, Scalar = S>>(&mut self, verbs: &mut V, at: &Point<T>) -> ([S; 2], S)
    where
        B: Descent<V>,
    {
        let zero = S::from(0.0);
        let [d, e, _] = &self.made;
        let past = [[&d.displacement, &d.product], [&e.displacement, &e.product]];
        let dots = self.descent.make(verbs, at, past, &mut self.gradient_step);
        let [g_d, z_ad, g_e, z_ae, across, g_z] = dots;
        let right = [-g_d - z_ad, -g_e - z_ae];
        let shift = S::from(1.0 + (ROUNDING * verbs.rounding()).max(REGULARIZATION));
        let diagonal = [self.curvature[0] * shift, self.curvature[1] * shift];
        let det = diagonal[0] * diagonal[1] - across * across;
        let alone = self.curvature[0].if_positive(right[0] / diagonal[0], zero);
        let parts = [
            det.if_positive((right[0] * diagonal[1] - right[1] * across) / det, alone),
            det.if_positive((right[1] * diagonal[0] - right[0] * across) / det, zero),
        ];
        (parts, g_z)
    }
}

impl<S: Scalar> PairBlockCg<Vec<f64>, S> {
    /// The part of it that belongs to some of the rows.
    pub fn share(&self, rows: Range<usize>) -> Self {
        let of = |numbers: &[f64]| numbers[rows.clone()].to_vec();
        let made =
            |made: &Direction<Vec<f64>>| Direction { displacement: of(&made.displacement), product: of(&made.product) };
        let room = || vec![0.0; rows.len()];
        PairBlockCg {
            descent: ByPairs,
            gradient_step: room(),
            room: room(),
            made: [made(&self.made[0]), made(&self.made[1]), Direction { displacement: room(), product: room() }],
            curvature: self.curvature,
            length: self.length,
            residual: None,
            goes_on: self.goes_on,
        }
    }

    /// Merges back a part from [`PairBlockCg::share`].
    pub fn take_back(&mut self, rows: Range<usize>, share: &Self) {
        for (made, share) in self.made.iter_mut().zip(&share.made).take(2) {
            made.displacement[rows.clone()].copy_from_slice(&share.displacement);
            made.product[rows.clone()].copy_from_slice(&share.product);
        }
        (self.curvature, self.length, self.goes_on) = (share.curvature, share.length, share.goes_on);
    }
}

impl<V: Verbs, B: Descent<V>> Method<V> for PairBlockCg<V::Vector, V::Scalar, B> {
    fn begin(&mut self, verbs: &mut V, _: &Point<V::Vector>) {
        if std::mem::take(&mut self.goes_on) {
            return;
        }
        verbs.clear(&mut self.gradient_step);
        verbs.clear(&mut self.room);
        for made in &mut self.made {
            verbs.clear(&mut made.displacement);
            verbs.clear(&mut made.product);
        }
        (self.curvature, self.length) = ([verbs.number(0.0); 2], verbs.number(1.0));
        self.descent.begin(verbs);
    }

    fn step(&mut self, verbs: &mut V, at: &mut Point<V::Vector>) {
        let (zero, one) = (V::Scalar::from(0.0), V::Scalar::from(1.0));

        let ([a, b], descent) = self.parts(verbs, at);

        let [d, e, next] = &mut self.made;
        let terms = [
            (self.length, &self.gradient_step),
            (self.length * a, &d.displacement),
            (self.length * b, &e.displacement),
        ];
        let safe = (descent * V::Scalar::from(DESCENT), self.descent.feasible(&self.gradient_step));
        let made = [&mut next.displacement, &mut next.product];
        let ([slope, curvature], room) = verbs.displace_and_multiply([&at.x, &at.g], terms, safe, made, &mut self.room);
        let best = curvature.if_positive(-slope / curvature, one).max(zero);
        let part = best.min(room);
        let made = [&next.displacement, &next.product];
        self.residual = verbs.advance_along(part, made, [&mut at.x, &mut at.g], &mut self.room);

        // Kept without the factor `part`, which cancels in the direction.
        self.curvature = [curvature, self.curvature[0]];
        self.made.rotate_right(1);
        self.length = (self.length * best).max(B::SHORTEST.into()).min(LONGEST.into());
    }

    fn refresh(&mut self, _: &mut V, _: &mut Point<V::Vector>) -> bool {
        false
    }

    fn residual(&mut self, verbs: &mut V, at: &Point<V::Vector>) -> V::Scalar {
        self.residual.take().unwrap_or_else(|| verbs.residual(&at.x, &at.g))
    }
}
