//! The shared-normal signed distance (SNSD) of a pair of bodies, with its normal and levers.
//!
//! For convex pairs `Phi = max over unit n of n . (x_b - x_a) - h_a(n) - h_b(-n)`; for centreline pairs the distance
//! between the two centrelines minus the two radii. `Phi > 0` apart, `Phi < 0` overlap. The two definitions agree where
//! both apply. After Palmer, Aktulga and Gao (2026), section 2.
//!
//! Everything is computed from `x_b - x_a`, so a result does not depend on how far from the origin a pair lies. The
//! pair is first put into a fixed order, so swapping the bodies flips the normal and changes no other bit, unless they
//! are equal bodies with equal poses: then no side is preferred.

pub(crate) mod branches;
mod circle_convex;
mod circle_segment;
mod circles;
mod convex;
mod direction;
mod ellipsoids;
mod farthest;
mod flat;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
mod meeting;
mod outermost;
mod peak;
pub(crate) mod planar;
mod point_ellipsoid;
mod segment_convex;
mod segment_ellipsoid;
mod segments;
mod support;
pub(crate) mod surface;

#[cfg(feature = "files")]
pub(crate) use branches::is_branch;
pub(crate) use branches::{branch, branch_slack, branches};
pub(crate) use outermost::farthest;
pub(crate) use planar::planar_separation;
pub(crate) use surface::Surface;
pub(crate) use surface::{reach_across, reach_of_place};

/// The distance of a point from a custom shape's surface, both in the body's axes, negative inside; and the outward
/// normal of the point nearest to it.
#[cfg(feature = "files")]
pub(crate) fn point_to_convex(shape: Convex, p: DVec3) -> (f64, DVec3) {
    let peak = segment_convex::of_point(p, Posed::new(shape, DQuat::IDENTITY));
    (peak.value, peak.normal)
}

/// The distance from a point to a custom shape's farthest point, in the body's axes.
pub(crate) fn farthest_of_convex(shape: Convex, from: DVec3) -> f64 {
    farthest::from_point(-from, Posed::new(shape, DQuat::IDENTITY)).1
}

use crate::shape::{Centreline, Convex, Geometry, Shape};
use circles::Circle;
use convex::{Body, Posed};
use glam::{DQuat, DVec3};
use segments::Segment;
use std::cmp::Ordering;
use support::Support;

/// A shape with its pose: the input of a separation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// The shape, in body axes.
    pub shape: Shape,
    /// Position of the centre.
    pub position: DVec3,
    /// Unit quaternion from body axes to space.
    pub orientation: DQuat,
}

/// The shared-normal signed distance of a pair (a, b) and where it is attained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// `Phi`: the distance between the surfaces along the normal, negative where they overlap.
    pub separation: f64,
    /// Unit normal, from a to b.
    pub normal: DVec3,
    /// From a's centre to the contact point on a's surface.
    pub lever_a: DVec3,
    /// From b's centre to the contact point on b's surface.
    pub lever_b: DVec3,
}

/// Nearest points of two centrelines, each from its own centre.
#[derive(Clone, Copy)]
struct Nearest {
    from: DVec3,
    to: DVec3,
    normal: DVec3,
    distance: f64,
}

/// A body by its family, with its directions in space.
#[derive(Clone, Copy)]
enum Family {
    /// A segment, or a point, thickened by a radius.
    Segment(Segment, f64),
    /// A circle thickened by a radius.
    Circle(Circle, f64),
    /// An ellipsoid's support function.
    Ellipsoid(Support),
    /// A support function of the user's own.
    Convex(Posed),
}

impl Family {
    #[inline]
    fn of(body: &Placed) -> Family {
        match body.shape.geometry() {
            Geometry::Centreline { curve: Centreline::Point, radius } => Family::Segment(Segment::POINT, radius),
            Geometry::Centreline { curve: Centreline::Segment { half }, radius } => {
                Family::Segment(Segment { axis: body.orientation * DVec3::Z, half }, radius)
            }
            Geometry::Centreline { curve: Centreline::Circle { radius: ring }, radius } => {
                Family::Circle(Circle::new(ring, body.orientation), radius)
            }
            Geometry::Ellipsoid { radii } => Family::Ellipsoid(Support::new(radii, body.orientation)),
            Geometry::Convex(shape) => Family::Convex(Posed::new(shape, body.orientation)),
        }
    }

    /// Rank in the fixed order of families.
    #[inline]
    fn rank(&self) -> u8 {
        match self {
            Family::Segment(..) => 0,
            Family::Circle(..) => 1,
            Family::Ellipsoid(..) => 2,
            Family::Convex(..) => 3,
        }
    }

    /// An ellipsoid or custom shape.
    fn convex(self) -> Option<Body> {
        match self {
            Family::Segment(..) | Family::Circle(..) => None,
            Family::Ellipsoid(support) => Some(Body::Ellipsoid(support)),
            Family::Convex(posed) => Some(Body::Custom(posed)),
        }
    }

    /// Support function of the convex hull, at a unit vector.
    #[inline]
    fn hull(&self, n: DVec3) -> f64 {
        match self {
            Family::Segment(segment, radius) => segment.half * segment.axis.dot(n).abs() + radius,
            Family::Circle(circle, radius) => circle.radius * circle.axis.cross(n).length() + radius,
            Family::Ellipsoid(support) => support.value(n),
            Family::Convex(posed) => posed.value(n),
        }
    }
}

/// The separation of a pair; `None` for no pair of the shapes that there are.
///
/// `warm` is a unit normal from a to b near the one sought, from an earlier configuration of the same pair. It saves
/// iterations for two ellipsoids or custom shapes and is not used otherwise. It changes the result by no more than
/// rounding.
///
/// Deep overlap. If convex bodies overlap by more than the sum of their least radii of curvature, the maximum need not
/// be unique: the result is the largest local maximum, and among equal ones always the same, for every `warm`. If
/// centrelines cross, coincide or are coaxial, the normal follows a fixed rule, documented where it is applied. No
/// finite pose gives a NaN.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relcp::separation::{Placed, separation};
/// use relcp::shape::Shape;
/// let shape = Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] };
/// let a = Placed { shape, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
/// let b = Placed { shape, position: DVec3::new(0.0, 0.0, 5.0), orientation: DQuat::IDENTITY };
/// let pair = separation(&a, &b, None).ok_or("unsupported pair")?;
/// assert!((pair.separation - 1.0).abs() < 1e-12);
/// assert!(pair.normal.abs_diff_eq(DVec3::Z, 1e-12));
/// assert!(pair.lever_a.abs_diff_eq(DVec3::Z * 2.0, 1e-12));
/// # Ok::<(), &str>(())
/// ```
pub fn separation(a: &Placed, b: &Placed, warm: Option<DVec3>) -> Option<Separation> {
    let delta = b.position - a.position;
    let (first, second) = (Family::of(a), Family::of(b));
    let swap = match first.rank().cmp(&second.rank()) {
        Ordering::Less => false,
        Ordering::Greater => true,
        Ordering::Equal => out_of_order(delta, a, b),
    };
    if swap {
        of_families(-delta, second, first, warm.map(|n| -n)).map(Separation::flipped)
    } else {
        of_families(delta, first, second, warm)
    }
}

/// The function that computes separations: [`separation`], or the planar one for bodies that cannot leave the plane.
pub(crate) fn separate_in(planar: bool) -> fn(&Placed, &Placed, Option<DVec3>) -> Option<Separation> {
    if planar { planar_separation } else { separation }
}

/// A lower bound of the separation from one unit normal: `n . (x_b - x_a) - h_a(n) - h_b(-n)`, of the convex hulls.
///
/// It holds for every pair of shapes and every unit `normal` from a to b, and is the separation itself at a convex
/// pair's own normal. A pair whose bound at an old normal exceeds the cutoff needs no separation.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relcp::separation::{Placed, bound};
/// use relcp::shape::Shape;
/// let ball = |x| Placed { shape: Shape::Sphere { radius: 1.0 }, position: DVec3::X * x, orientation: DQuat::IDENTITY };
/// assert_eq!(bound(&ball(0.0), &ball(3.0), DVec3::X), 1.0);
/// assert!(bound(&ball(0.0), &ball(3.0), DVec3::Y) <= 1.0);
/// ```
#[inline]
pub fn bound(a: &Placed, b: &Placed, normal: DVec3) -> f64 {
    normal.dot(b.position - a.position) - Family::of(a).hull(normal) - Family::of(b).hull(-normal)
}

/// The pair table. Families are in the order of their ranks.
#[inline]
fn of_families(delta: DVec3, a: Family, b: Family, warm: Option<DVec3>) -> Option<Separation> {
    match (a, b) {
        (Family::Segment(a, ra), Family::Segment(b, rb)) => Some(segments::nearest(delta, a, b).thickened(ra, rb)),
        (Family::Segment(a, ra), Family::Circle(b, rb)) => {
            Some(circle_segment::nearest(-delta, b, a).thickened(rb, ra).flipped())
        }
        (Family::Segment(a, ra), Family::Ellipsoid(b)) => {
            Some(segment_ellipsoid::separation(-delta, b, a, ra).flipped())
        }
        (Family::Circle(a, ra), Family::Circle(b, rb)) if a.radius < b.radius => {
            Some(circles::nearest(-delta, b, a).thickened(rb, ra).flipped())
        }
        (Family::Circle(a, ra), Family::Circle(b, rb)) => Some(circles::nearest(delta, a, b).thickened(ra, rb)),
        (Family::Circle(a, ra), Family::Ellipsoid(b)) => {
            Some(circle_convex::separation(delta, (a, ra), Body::Ellipsoid(b)))
        }
        (Family::Circle(a, ra), Family::Convex(b)) => Some(circle_convex::separation(delta, (a, ra), Body::Custom(b))),
        (Family::Ellipsoid(a), Family::Ellipsoid(b)) => Some(ellipsoids::separation(delta, a, b, warm)),
        (Family::Segment(a, ra), Family::Convex(b)) => Some(segment_convex::separation(-delta, b, a, ra).flipped()),
        (Family::Ellipsoid(a), Family::Convex(b)) => {
            Some(convex::separation(delta, Body::Ellipsoid(a), Body::Custom(b), warm))
        }
        (Family::Convex(a), Family::Convex(b)) => {
            Some(convex::separation(delta, Body::Custom(a), Body::Custom(b), warm))
        }
        _ => None,
    }
}

/// Whether b precedes a in the fixed order of a pair of one family: by position, and for equal positions by bounding
/// radius, orientation and thickness; finally for superellipsoids by their numbers, for custom shapes by the order in
/// which they were created.
fn out_of_order(delta: DVec3, a: &Placed, b: &Placed) -> bool {
    let key = |p: &Placed| {
        let [x, y, z, w] = p.orientation.to_array();
        let made = if let Shape::Convex(shape) = p.shape { shape.id() } else { 0 };
        let ([r, s, t], [m, n]) = p.shape.exponents().map_or(([0.0; 3], [0.0; 2]), |of| (p.shape.code().1, of));
        [p.shape.bounding_radius(), x, y, z, w, p.shape.thickness(), made as f64, r, s, t, m, n]
    };
    let order = |d: f64| d.partial_cmp(&0.0).unwrap_or(Ordering::Equal);
    let places = order(delta.x).then_with(|| order(delta.y)).then_with(|| order(delta.z));
    places.then_with(|| key(b).partial_cmp(&key(a)).unwrap_or(Ordering::Equal)) == Ordering::Less
}

impl Nearest {
    /// The separation of the two curves thickened by these radii.
    #[inline]
    fn thickened(self, radius_a: f64, radius_b: f64) -> Separation {
        Separation {
            separation: self.distance - (radius_a + radius_b),
            normal: self.normal,
            lever_a: self.from + self.normal * radius_a,
            lever_b: self.to - self.normal * radius_b,
        }
    }
}

impl Separation {
    /// The same for the pair (b, a).
    #[inline]
    fn flipped(self) -> Separation {
        Separation { normal: -self.normal, lever_a: self.lever_b, lever_b: self.lever_a, ..self }
    }
}
