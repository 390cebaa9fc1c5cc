//! A custom shape with another, or with an ellipsoid: the largest `n . Delta - h_a(n) - h_b(-n)` over unit normals (see
//! `peak`).
//!
//! The second body is mirrored at its centre, so that its support function at `n` is the original one at `-n`. Newton
//! starts at the warm normal or at the direction between the centres. If the maximum is so deep that it may not be
//! unique, Newton also starts from the best of fixed normals: the directions to the sides, edges and corners of a cube
//! along the axes of either body, of two superellipsoids also those across an edge of each.
//!
//! Degenerate cases: concentric bodies (the start is the x of space); equal maxima (the first in the order of starts,
//! for every warm normal).

use super::peak::{Peak, Supporting, climb};
use super::support::Support;
use super::{Separation, segment_convex, segment_ellipsoid};
use crate::shape::Convex;
use glam::{DMat3, DQuat, DVec3};

/// The number of starts, those with the largest values. Of 4,500 random pairs of ellipsoids up to aspect
/// ratio 5, dice and eggs, their centres at most 0.8 of the smaller thickness apart, 100 found a smaller maximum than
/// the largest known with one start, 19 with two, one with four and none with this many.
const CLIMBED: usize = 8;
/// Maxima this close, as a fraction of the sizes, are equal: well above the rounding of a value, 1e-16 of the sizes.
pub(super) const TIE: f64 = 1e-13;

/// A custom shape about the origin, turned and perhaps mirrored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Posed {
    shape: Convex,
    axes: DMat3,
    /// -1 if the shape is mirrored at the origin, else 1.
    side: f64,
}

impl Posed {
    #[inline]
    pub fn new(shape: Convex, orientation: DQuat) -> Self {
        Posed { shape, axes: DMat3::from_quat(orientation), side: 1.0 }
    }

    #[inline]
    fn to_body(self, v: DVec3) -> DVec3 {
        DVec3::new(self.axes.x_axis.dot(v), self.axes.y_axis.dot(v), self.axes.z_axis.dot(v)) * self.side
    }

    /// The support function at `n`.
    #[inline]
    pub fn value(self, n: DVec3) -> f64 {
        self.shape.reach(self.to_body(n))
    }

    /// As [`Convex::roundness`].
    #[inline]
    pub fn roundness(self) -> f64 {
        self.shape.roundness()
    }

    /// The fixed starts.
    pub fn starts(self) -> impl Iterator<Item = DVec3> {
        around(self.axes).chain(self.edges())
    }

    /// The normals at the edges and corners of a superellipsoid that is not as wide along all axes.
    fn edges(self) -> impl Iterator<Item = DVec3> {
        let half_widths = self.shape.norm().map(|norm| norm.half_widths());
        let slender = half_widths.filter(|half| half.max_element() > half.min_element());
        slender.into_iter().flat_map(move |half| {
            let axes = self.axes;
            around(DMat3::IDENTITY).filter_map(move |u| (axes * (u / half)).try_normalize())
        })
    }
}

impl Supporting for Posed {
    #[inline]
    fn value_and_point(self, n: DVec3) -> (f64, DVec3) {
        let point = self.axes * self.shape.point(self.to_body(n)) * self.side;
        (n.dot(point), point)
    }

    #[inline]
    fn hessian(self, n: DVec3, _: f64, (e1, e2): (DVec3, DVec3)) -> (f64, f64, f64) {
        self.shape.hessian(self.to_body(n), (self.to_body(e1), self.to_body(e2)))
    }

    #[inline]
    fn size(self) -> f64 {
        self.shape.bounding_radius()
    }

    #[inline]
    fn aspect(self) -> f64 {
        self.shape.aspect()
    }

    fn gauge(self, point: DVec3) -> Option<(f64, DVec3)> {
        let (part, gradient) = self.shape.norm()?.gauge(self.to_body(point));
        Some((part, (self.axes * gradient * self.side).try_normalize()?))
    }

    fn is_flat(self) -> bool {
        self.has_edges()
    }

    fn has_edges(self) -> bool {
        self.shape.norm().is_some()
    }
}

/// A body of a pair: a custom shape or an ellipsoid.
#[derive(Clone, Copy)]
pub(super) enum Body {
    Ellipsoid(Support),
    Custom(Posed),
}

impl Body {
    fn mirrored(self) -> Body {
        match self {
            Body::Ellipsoid(_) => self,
            Body::Custom(posed) => Body::Custom(Posed { side: -posed.side, ..posed }),
        }
    }

    pub fn roundness(self) -> f64 {
        match self {
            Body::Ellipsoid(support) => support.least_curvature_radius(),
            Body::Custom(posed) => posed.roundness(),
        }
    }

    fn axes(self) -> DMat3 {
        match self {
            Body::Ellipsoid(support) => support.axes,
            Body::Custom(posed) => posed.axes,
        }
    }

    /// As [`Posed::edges`]; none of an ellipsoid.
    fn edges(self) -> impl Iterator<Item = DVec3> {
        let posed = if let Body::Custom(posed) = self { Some(posed) } else { None };
        posed.into_iter().flat_map(Posed::edges)
    }

    /// The body in its own axes, and these.
    pub fn in_own_axes(self) -> (Body, DMat3) {
        let turned = match self {
            Body::Ellipsoid(support) => Body::Ellipsoid(Support { axes: DMat3::IDENTITY, ..support }),
            Body::Custom(posed) => Body::Custom(Posed { axes: DMat3::IDENTITY, ..posed }),
        };
        (turned, self.axes())
    }

    /// The outward normal at the surface point nearest to `p`.
    pub fn normal_nearest_to(self, p: DVec3) -> DVec3 {
        match self {
            Body::Ellipsoid(support) => segment_ellipsoid::point_normal(p, support),
            Body::Custom(posed) => segment_convex::of_point(p, posed).normal,
        }
    }
}

impl Supporting for Body {
    #[inline]
    fn value_and_point(self, n: DVec3) -> (f64, DVec3) {
        match self {
            Body::Ellipsoid(support) => support.value_and_point(n),
            Body::Custom(posed) => posed.value_and_point(n),
        }
    }

    #[inline]
    fn hessian(self, n: DVec3, value: f64, basis: (DVec3, DVec3)) -> (f64, f64, f64) {
        match self {
            Body::Ellipsoid(support) => support.hessian(n, value, basis),
            Body::Custom(posed) => posed.hessian(n, value, basis),
        }
    }

    #[inline]
    fn size(self) -> f64 {
        match self {
            Body::Ellipsoid(support) => support.size(),
            Body::Custom(posed) => posed.size(),
        }
    }

    #[inline]
    fn aspect(self) -> f64 {
        match self {
            Body::Ellipsoid(support) => support.aspect(),
            Body::Custom(posed) => posed.aspect(),
        }
    }

    fn gauge(self, point: DVec3) -> Option<(f64, DVec3)> {
        match self {
            Body::Ellipsoid(_) => None,
            Body::Custom(posed) => posed.gauge(point),
        }
    }

    fn is_flat(self) -> bool {
        match self {
            Body::Ellipsoid(_) => false,
            Body::Custom(posed) => posed.is_flat(),
        }
    }

    fn has_edges(self) -> bool {
        self.is_flat()
    }
}

/// The separation of `a` about the origin and `b` about `delta`.
pub(super) fn separation(delta: DVec3, a: Body, b: Body, warm: Option<DVec3>) -> Separation {
    let bodies = [a, b.mirrored()];
    let between = delta.try_normalize().unwrap_or(DVec3::X);
    let mut peak = climb(delta, &bodies, warm.and_then(DVec3::try_normalize).unwrap_or(between));
    if peak.value <= -(a.roundness() + b.roundness()) {
        let starts = around(a.axes()).chain(around(b.axes())).chain([between]).chain(a.edges()).chain(b.edges());
        let starts = starts.chain(crossings(a, b));
        peak = highest(delta, &bodies, starts).filter(|best| !above(&peak, best, delta, &bodies)).unwrap_or(peak);
    }
    Separation { separation: peak.value, normal: peak.normal, lever_a: peak.points[0], lever_b: -peak.points[1] }
}

/// Whether a peak is higher than another by more than rounding.
fn above<const N: usize>(peak: &Peak<N>, other: &Peak<N>, delta: DVec3, bodies: &[impl Supporting; N]) -> bool {
    let size = delta.length() + bodies.iter().map(|b| b.size()).sum::<f64>();
    peak.value > other.value + TIE * size
}

/// The highest of the peaks from the best of some starts, of superellipsoids from all, the first among equals; none
/// without starts.
pub(super) fn highest<const N: usize>(
    delta: DVec3,
    bodies: &[impl Supporting; N],
    starts: impl Iterator<Item = DVec3>,
) -> Option<Peak<N>> {
    // With the best eight, one of 250 superellipsoids beside a thousand times slenderer ones missed the largest
    // maximum.
    let climbed = if bodies.iter().any(|body| body.has_edges()) { usize::MAX } else { CLIMBED };
    let mut tried: Vec<Peak<N>> = starts.map(|start| Peak::at(delta, bodies, start)).collect();
    tried.sort_by(|a, b| b.value.total_cmp(&a.value));
    let peaks = tried.iter().take(climbed).map(|start| climb(delta, bodies, start.normal));
    peaks.reduce(|best, peak| if above(&peak, &best, delta, bodies) { peak } else { best })
}

/// The normals across an axis of each of two superellipsoids. Boxes overlap least along one of these or a face's.
/// Without them one of some thousands of concentric pairs of exponent 8 was 2e-4 of the size too deep.
fn crossings(a: Body, b: Body) -> impl Iterator<Item = DVec3> {
    let both = a.has_edges() && b.has_edges();
    let crossing = move |k: usize| {
        let normal = a.axes().col(k % 3).cross(b.axes().col(k / 3 % 3)).try_normalize()?;
        Some(if k < 9 { normal } else { -normal })
    };
    (0..18).filter(move |_| both).filter_map(crossing)
}

/// The unit vectors to the sides, edges and corners of a cube along these axes.
fn around(axes: DMat3) -> impl Iterator<Item = DVec3> {
    let digit = |k: i32| f64::from(k % 3 - 1);
    (0..27).filter_map(move |k| (axes * DVec3::new(digit(k), digit(k / 3), digit(k / 9))).try_normalize())
}
