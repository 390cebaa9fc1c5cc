//! The vector operations of the iterative solvers. A solver is written once over them, for every backend.
//!
//! A backend owns the problem. Its vectors have one entry per row; its scalars may live on a device, so a solver
//! combines them with arithmetic and [`Scalar::if_positive`] and never branches on one. Only the driver reads a scalar,
//! with [`Verbs::read`].

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A scalar of a backend, perhaps on a device.
pub trait Scalar:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The smaller one; the other one if one is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger one; the other one if one is NaN.
    fn max(self, other: Self) -> Self;
    /// `yes` if this number is positive, else (NaN too) `no`.
    fn if_positive(self, yes: Self, no: Self) -> Self;
}

impl Scalar for f64 {
    fn min(self, other: f64) -> f64 {
        f64::min(self, other)
    }
    fn max(self, other: f64) -> f64 {
        f64::max(self, other)
    }
    fn if_positive(self, yes: f64, no: f64) -> f64 {
        if self > 0.0 { yes } else { no }
    }
}

/// A diagonal matrix `B` near `A`, whose projections are cheap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// The diagonal of `A`.
    Diagonal,
    /// A diagonal `W` with `x . A x <= x . W x` for every `x` (see [`super::product::Product::majorant`]).
    Majorant,
}

/// Recorded residuals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checks {
    /// The residuals that have become known, oldest first.
    pub residuals: Vec<f64>,
    /// Whether all work after the last of them was skipped.
    pub ended: bool,
}

/// A point and its gradient.
pub type At<'a, T> = [&'a T; 2];

/// A displacement and its product.
pub type Past<'a, T> = [&'a T; 2];

/// A vector with a factor.
pub type Term<'a, S, T> = (S, &'a T);

/// The operations of conjugate gradients, one after the other.
pub(super) mod composed {
    use super::{At, Past, Term, Verbs};

    /// See [`Verbs::descend_beside`].
    pub fn descend_beside<V: Verbs + ?Sized>(
        verbs: &mut V,
        [x, g]: At<V::Vector>,
        [[d, ad], [e, ae]]: [Past<V::Vector>; 2],
        out: &mut V::Vector,
    ) -> [V::Scalar; 6] {
        verbs.descend(x, g, out);
        let z = &*out;
        verbs.dots([[g, d], [z, ad], [g, e], [z, ae], [d, ae], [g, z]])
    }

    /// See [`Verbs::displace_and_multiply`].
    pub fn displace_and_multiply<V: Verbs + ?Sized>(
        verbs: &mut V,
        [x, g]: At<V::Vector>,
        terms: [Term<V::Scalar, V::Vector>; 3],
        (most, safe): (V::Scalar, &V::Vector),
        [out, product]: [&mut V::Vector; 2],
        room: &mut V::Vector,
    ) -> ([V::Scalar; 2], V::Scalar) {
        verbs.displace(x, terms, out, room);
        let flat = verbs.dot(g, out) - most;
        verbs.copy_if_positive(flat, safe, out);
        verbs.product(out, product);
        verbs.dots_and_room([[g, out], [out, product]], x, out)
    }

    /// See [`Verbs::advance_along`].
    pub fn advance_along<V: Verbs + ?Sized>(
        verbs: &mut V,
        part: V::Scalar,
        [d, ad]: Past<V::Vector>,
        [x, g]: [&mut V::Vector; 2],
        room: &mut V::Vector,
    ) -> Option<V::Scalar> {
        // Only rounding errors are below zero.
        verbs.advance(part, d, x, room);
        verbs.add(part, ad, g);
        None
    }
}

/// Vector operations of a backend. A vector has one entry per row.
pub trait Verbs {
    /// A vector. The default is empty: [`Verbs::clear`] gives it its length.
    type Vector: Default;
    /// A scalar.
    type Scalar: Scalar;

    /// A scalar that varies between iterations, so that a backend does not compile it as a constant.
    fn number(&mut self, x: f64) -> Self::Scalar {
        x.into()
    }
    /// Sets `x` to zeros, one per row.
    fn clear(&mut self, x: &mut Self::Vector);
    /// `to = from`.
    fn copy(&mut self, from: &Self::Vector, to: &mut Self::Vector);
    /// `to = from` if `condition` is positive; otherwise `to` stays.
    fn copy_if_positive(&mut self, condition: Self::Scalar, from: &Self::Vector, to: &mut Self::Vector);
    /// `to = from`; `from` is undefined afterwards.
    fn take(&mut self, from: &mut Self::Vector, to: &mut Self::Vector);
    /// `ax = A x`: one product.
    fn product(&mut self, x: &Self::Vector, ax: &mut Self::Vector);
    /// `g = q + A x`: one product.
    fn gradient(&mut self, x: &Self::Vector, g: &mut Self::Vector);
    /// `x . y`.
    fn dot(&mut self, x: &Self::Vector, y: &Self::Vector) -> Self::Scalar;
    /// `x . y` of each pair.
    fn dots<const N: usize>(&mut self, pairs: [[&Self::Vector; 2]; N]) -> [Self::Scalar; N] {
        pairs.map(|[x, y]| self.dot(x, y))
    }
    /// `x . (q + g)`, which is twice the objective `1/2 x . A x + q . x` when `g = q + A x`.
    fn twice_objective(&mut self, x: &Self::Vector, g: &Self::Vector) -> Self::Scalar;
    /// `out = a x + b y`.
    fn combine(&mut self, a: Self::Scalar, x: &Self::Vector, b: Self::Scalar, y: &Self::Vector, out: &mut Self::Vector);
    /// `y += a x`.
    fn add(&mut self, a: Self::Scalar, x: &Self::Vector, y: &mut Self::Vector);
    /// The projected step `out = argmin over y >= 0 of g . (y - x) + 1/(2 step) (y - x) . B (y - x)`. Rows of `A` that
    /// are zero keep `x`.
    fn proximal(
        &mut self,
        metric: Metric,
        x: &Self::Vector,
        step: Self::Scalar,
        g: &Self::Vector,
        out: &mut Self::Vector,
    );
    /// `out = argmin over x + out >= 0 of g . out + 1/2 out . B out`, where `B` are the diagonal blocks of `A`, one for
    /// all rows of a pair (see `lcp::pair_blocks`). Zero rows of `A` stay.
    fn descend(&mut self, x: &Self::Vector, g: &Self::Vector, out: &mut Self::Vector);
    /// `out = argmin over x + out >= 0 of (out - w) . B (out - w)` with the same blocks, where `w` is the sum of the
    /// `terms`. `room` is scratch space.
    fn displace(
        &mut self,
        x: &Self::Vector,
        terms: [(Self::Scalar, &Self::Vector); 3],
        out: &mut Self::Vector,
        room: &mut Self::Vector,
    );
    /// `x = max(x + a d, 0)`. `room` is scratch space.
    fn advance(&mut self, a: Self::Scalar, d: &Self::Vector, x: &mut Self::Vector, room: &mut Self::Vector);
    /// `x . B x`.
    fn square(&mut self, metric: Metric, x: &Self::Vector) -> Self::Scalar;
    /// `x . B^-1 x` without the zero rows of `A`.
    fn inverse_square(&mut self, metric: Metric, x: &Self::Vector) -> Self::Scalar;
    /// The largest `t` with `x + t d >= 0`, infinite if there is none.
    fn ratio_test(&mut self, x: &Self::Vector, d: &Self::Vector) -> Self::Scalar;
    /// `x . y` of each pair and [`Verbs::ratio_test`], in one pass.
    fn dots_and_room(
        &mut self,
        pairs: [[&Self::Vector; 2]; 2],
        x: &Self::Vector,
        d: &Self::Vector,
    ) -> ([Self::Scalar; 2], Self::Scalar) {
        (self.dots(pairs), self.ratio_test(x, d))
    }
    /// [`Verbs::descend`] at `x` and `g`, and with `d`, `e` and their products `past`: `g . d`, `out . A d`, `g . e`,
    /// `out . A e`, `d . A e`, `g . out`.
    fn descend_beside(
        &mut self,
        at: At<Self::Vector>,
        past: [Past<Self::Vector>; 2],
        out: &mut Self::Vector,
    ) -> [Self::Scalar; 6] {
        composed::descend_beside(self, at, past, out)
    }
    /// [`Verbs::displace`] from `x` with the gradient `g`, replaced by another displacement where its product with `g`
    /// is above a number, and then its product with `A`: `made` becomes both. Returns `g . d` and `d . A d` for this
    /// displacement `d`, and [`Verbs::ratio_test`].
    fn displace_and_multiply(
        &mut self,
        at: At<Self::Vector>,
        terms: [Term<Self::Scalar, Self::Vector>; 3],
        safe: (Self::Scalar, &Self::Vector),
        made: [&mut Self::Vector; 2],
        room: &mut Self::Vector,
    ) -> ([Self::Scalar; 2], Self::Scalar) {
        composed::displace_and_multiply(self, at, terms, safe, made, room)
    }
    /// [`Verbs::advance`] of `x` by a part of a displacement, and its product added to `g`. Returns the residual there
    /// if it is known at no cost.
    fn advance_along(
        &mut self,
        part: Self::Scalar,
        made: Past<Self::Vector>,
        to: [&mut Self::Vector; 2],
        room: &mut Self::Vector,
    ) -> Option<Self::Scalar> {
        composed::advance_along(self, part, made, to, room)
    }
    /// The natural residual `max |min(g, s x)|`, NaN if an entry is NaN.
    fn residual(&mut self, x: &Self::Vector, g: &Self::Vector) -> Self::Scalar;
    /// Reads a scalar on the host, which waits for the device: for drivers, not for iterations.
    fn read(&mut self, scalar: Self::Scalar) -> f64;
    /// Records a residual for [`Verbs::take_checks`]. If it is at most `tolerance` or not finite, a backend may skip
    /// everything until then; the vectors of the residual then stay unchanged.
    fn check(&mut self, residual: Self::Scalar, tolerance: f64);
    /// The recorded residuals that are known: all of them if none was recorded since the last call. A device waits.
    fn take_checks(&mut self) -> Checks;
    /// Recomputes the gradient `g = q + A x` at the last check: one product. Returns the residual there.
    fn confirm(&mut self, x: &Self::Vector, g: &mut Self::Vector) -> (Self::Scalar, f64) {
        self.gradient(x, g);
        let residual = self.residual(x, g);
        (residual, self.read(residual))
    }
    /// The best number of residuals to record before [`Verbs::take_checks`].
    fn checks_at_once(&self) -> usize {
        1
    }
    /// Machine epsilon, for limits above rounding.
    fn rounding(&self) -> f64 {
        f64::EPSILON
    }
    /// The number of products computed.
    fn products(&self) -> u64;
}

/// Operations of a backend that divides bodies into clusters.
pub trait InClusters: Verbs {
    /// If `condition` is positive, `out` becomes the sum over all clusters of a displacement of the cluster's rows: a
    /// few steps of conjugate gradients towards the minimum of `g . d + 1/2 |J^T d|^2` over `x + d >= 0` (see
    /// `lcp::cluster_cg`), none where every row's residual is well within `tolerance`. Otherwise, and for rows in no
    /// cluster, it becomes `by_pairs`.
    fn descend_in_clusters(
        &mut self,
        condition: Self::Scalar,
        at: [&Self::Vector; 2],
        tolerance: f64,
        by_pairs: &Self::Vector,
        out: &mut Self::Vector,
    );
}
