//! A body and a fixed surface on one side of which it must stay: the gap at the body's point that reaches farthest
//! towards the surface.
//!
//! Towards a plane this follows from the support function at the plane's outward normal. Inside a sphere or a cylinder
//! it is the body's point farthest from the centre or the axis: for a segment an end; for a circle the point opposite
//! to the centre; for an ellipsoid the root of a secular equation (`point_ellipsoid`); for a custom shape a search
//! (`farthest`). Across a cylinder's axis, ellipsoids and circles project to ellipses. At the farthest point the body's
//! normal is the surface's, so to first order the gap changes with the body's motion like that point's.
//!
//! A body can touch in several places at once. Segments, and circles towards planes and in spheres, have several
//! (`places`), each with its own exact gap; the smallest is the body's separation.
//!
//! Degenerate cases, each up to rounding: a point at the centre or on the axis (a fixed direction, across the axis);
//! several farthest points (`point_ellipsoid`, the first direction of a circle); a circle parallel to a plane, which
//! touches everywhere (its first direction); a circle coaxial with a cylinder (a fixed direction across).

#[cfg(feature = "gpu")]
pub(super) mod gpu;

use super::circles::Circle;
use super::convex::Posed;
use super::direction::{ROUNDING_SINE, across, normal_to, perpendicular};
use super::peak::Supporting;
use super::point_ellipsoid::farthest_normal;
use super::segments::Segment;
use super::support::Support;
use super::{Family, Placed, Separation, farthest};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A fixed surface with the side on which bodies stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// The side of a plane to which `normal` points.
    Plane {
        /// A point of the plane.
        point: DVec3,
        /// Unit normal, towards the bodies.
        normal: DVec3,
    },
    /// The inside of a sphere.
    Sphere {
        /// Its centre.
        centre: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// The inside of an infinite cylinder.
    Cylinder {
        /// A point of its axis.
        centre: DVec3,
        /// Unit vector along its axis.
        axis: DVec3,
        /// Its radius.
        radius: f64,
    },
}

/// The places of a circle towards a plane or in a sphere: the farthest, and those a third of the circle to either side,
/// so that a flat ring rests on three points. With the farthest alone, six rings that fall onto a floor take 69
/// recursions in 120 steps instead of 1, in a sphere 170 instead of 40; in a tube further places save none. Six rods
/// with only one end take 91 instead of 15.
const PLACES_OF_CIRCLE: u32 = 3;

impl Surface {
    /// A lower bound of the separation of a body, from its bounding sphere.
    #[inline]
    pub fn bound(&self, body: &Placed) -> f64 {
        self.gap(body.position).0 - body.shape.bounding_radius()
    }

    /// The distance of a point from the surface, positive on the side of the bodies, negative beyond it.
    #[inline]
    pub fn height(&self, at: DVec3) -> f64 {
        self.gap(at).0
    }

    /// The separation of a body: its smallest gap, where it is attained, and the normal from the body to the surface.
    /// `lever_b` is zero.
    ///
    /// ```
    /// use glam::{DQuat, DVec3};
    /// use relcp::internals::separation::Surface;
    /// use relcp::separation::Placed;
    /// use relcp::shape::Shape;
    /// let shape = Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] };
    /// let body = Placed { shape, position: DVec3::Z * 2.5, orientation: DQuat::IDENTITY };
    /// let floor = Surface::Plane { point: DVec3::ZERO, normal: DVec3::Z };
    /// assert_eq!(floor.separation(&body).separation, 0.5);
    /// let around = Surface::Sphere { centre: DVec3::ZERO, radius: 5.0 };
    /// assert_eq!((around.separation(&body).separation, around.separation(&body).normal), (0.5, DVec3::Z));
    /// ```
    pub fn separation(&self, body: &Placed) -> Separation {
        let mut least =
            Separation { separation: f64::INFINITY, normal: DVec3::ZERO, lever_a: DVec3::ZERO, lever_b: DVec3::ZERO };
        self.places(body, |_, found| {
            if found.separation < least.separation {
                least = found;
            }
        });
        least
    }

    /// The gaps of all places of a body, numbered: both ends of a rod, three places of a ring towards a plane or in a
    /// sphere, one for other bodies.
    pub fn places(&self, body: &Placed, mut found: impl FnMut(u32, Separation)) {
        match Family::of(body) {
            Family::Segment(Segment { half: 0.0, .. }, radius) => {
                found(0, self.at(body.position, DVec3::ZERO, radius));
            }
            Family::Segment(Segment { axis, half }, radius) => {
                found(0, self.at(body.position, -half * axis, radius));
                found(1, self.at(body.position, half * axis, radius));
            }
            Family::Circle(circle, radius) => {
                let farthest = self.farthest_of_circle(body.position, &circle);
                let places = if matches!(self, Surface::Cylinder { .. }) { 1 } else { PLACES_OF_CIRCLE };
                for place in 0..places {
                    let turn = DVec2::from_angle(TAU * f64::from(place) / f64::from(PLACES_OF_CIRCLE));
                    let DVec2 { x, y } = circle.radius * turn.rotate(farthest);
                    found(place, self.at(body.position, x * circle.first + y * circle.second, radius));
                }
            }
            Family::Ellipsoid(support) => {
                let normal = self.farthest_of_ellipsoid(body.position, &support);
                found(0, self.at(body.position, support.value_and_point(normal).1, 0.0));
            }
            Family::Convex(posed) => {
                let normal = self.farthest_of_convex(body.position, posed);
                found(0, self.at(body.position, posed.value_and_point(normal).1, 0.0));
            }
        }
    }

    /// The gap of a sphere of radius `radius` about `arm` from a body's centre.
    #[inline]
    pub(crate) fn at(&self, centre: DVec3, arm: DVec3, radius: f64) -> Separation {
        let (gap, normal) = self.gap(centre + arm);
        Separation { separation: gap - radius, normal, lever_a: arm + radius * normal, lever_b: DVec3::ZERO }
    }

    /// The distance of a point from the surface, negative on its far side, and the unit normal there, away from the
    /// bodies' side.
    #[inline]
    fn gap(&self, at: DVec3) -> (f64, DVec3) {
        match *self {
            Surface::Plane { point, normal } => (normal.dot(at - point), -normal),
            // At the centre all directions are equal. This one lies in the plane of a planar scene.
            Surface::Sphere { centre, radius } => out_of(at - centre, radius, || DVec3::X),
            Surface::Cylinder { centre, axis, radius } => {
                out_of(across(at - centre, axis).unwrap_or(DVec3::ZERO), radius, || perpendicular(axis))
            }
        }
    }

    /// The direction from a circle's centre to its point that reaches farthest, as a combination of the two directions
    /// of its plane: so the point is on the circle even if a circle nearly parallel to a plane determines the direction
    /// badly.
    fn farthest_of_circle(&self, position: DVec3, circle: &Circle) -> DVec2 {
        let along = |v: DVec3| {
            let seen = DVec2::new(v.dot(circle.first), v.dot(circle.second));
            if seen.length() > ROUNDING_SINE * v.length() { seen.normalize_or(DVec2::X) } else { DVec2::X }
        };
        match *self {
            Surface::Plane { normal, .. } => along(-normal),
            Surface::Sphere { centre, .. } => along(position - centre),
            Surface::Cylinder { centre, axis, .. } => {
                // Across the axis the circle projects to an ellipse: as wide as the circle, and as high as its tilt
                // towards the axis.
                let lean = circle.axis.dot(axis).abs();
                let wide = normal_to(axis, circle.axis).unwrap_or(perpendicular(axis));
                let high = axis.cross(wide);
                let p = centre - position;
                let [x, y] = farthest_normal([1.0, lean], [p.dot(wide), p.dot(high)].map(|c| c / circle.radius));
                along(x * wide + y * high)
            }
        }
    }

    /// The outward normal of an ellipsoid at its point that reaches farthest.
    fn farthest_of_ellipsoid(&self, position: DVec3, support: &Support) -> DVec3 {
        match *self {
            Surface::Plane { normal, .. } => -normal,
            Surface::Sphere { centre, .. } => {
                let p = support.to_body(centre - position);
                support.axes * DVec3::from_array(farthest_normal(support.radii.to_array(), p.to_array()))
            }
            Surface::Cylinder { centre, axis, .. } => {
                let (radii, first, second) = seen_along(support, axis);
                let p = centre - position;
                let [x, y] = farthest_normal(radii, [p.dot(first), p.dot(second)]);
                (x * first + y * second).normalize()
            }
        }
    }

    /// The same for a custom shape.
    fn farthest_of_convex(&self, position: DVec3, posed: Posed) -> DVec3 {
        match *self {
            Surface::Plane { normal, .. } => -normal,
            Surface::Sphere { centre, .. } => farthest::from_point(position - centre, posed).0,
            Surface::Cylinder { centre, axis, .. } => farthest::from_line(position - centre, posed, axis),
        }
    }
}

/// The reach of a body from its centre along `normal` at one of the [places](Surface::places) where it touches a
/// surface, whose normal there is `normal`.
pub(crate) fn reach_of_place(body: &Placed, place: u32, normal: DVec3) -> f64 {
    match Family::of(body) {
        Family::Segment(Segment { axis, half }, radius) => {
            let end = if place == 0 { -half } else { half };
            end * axis.dot(normal) + radius
        }
        // If places other than the farthest touch too, the circle is flat, and they reach as far as the farthest.
        Family::Circle(circle, radius) => circle.radius * circle.axis.cross(normal).length() + radius,
        Family::Ellipsoid(support) => support.value(normal),
        Family::Convex(posed) => posed.value(normal),
    }
}

/// How far the place of a body reaches from its centre along `force`, times it, for a force across the normal. A ring
/// that lies flat touches at places about its axis, and counts as touching in its middle.
pub(crate) fn reach_across(body: &Placed, place: u32, normal: DVec3, force: DVec3) -> f64 {
    match Family::of(body) {
        Family::Segment(Segment { axis, half }, _) => {
            let end = if place == 0 { -half } else { half };
            end * axis.dot(force)
        }
        Family::Circle(circle, _) => {
            let outwards = normal - circle.axis * circle.axis.dot(normal);
            circle.radius * outwards.normalize_or_zero().dot(force)
        }
        Family::Ellipsoid(support) => support.value_and_point(normal).1.dot(force),
        Family::Convex(posed) => posed.value_and_point(normal).1.dot(force),
    }
}

/// The gap of a point at the offset `from` from the centre inside `radius`, and the outward direction.
#[inline]
fn out_of(from: DVec3, radius: f64, otherwise: impl Fn() -> DVec3) -> (f64, DVec3) {
    let distance = from.length();
    (radius - distance, if distance > 0.0 { from / distance } else { otherwise() })
}

/// The semi-axes of the ellipse to which an ellipsoid projects along `axis`, and their directions.
///
/// With `M` the ellipsoid's axes times its radii, the ellipse's support function at `n` is `|M^T n|`: its axes are
/// those turned tangents whose images under `M^T` are at right angles (one step of Jacobi's method), so that a flat
/// ellipse keeps the digits of its small axis.
fn seen_along(support: &Support, axis: DVec3) -> ([f64; 2], DVec3, DVec3) {
    let (e1, e2) = (perpendicular(axis), axis.cross(perpendicular(axis)));
    let image = |n: DVec3| support.radii * support.to_body(n);
    let (m1, m2) = (image(e1), image(e2));
    let angle = 0.5 * (2.0 * m1.dot(m2)).atan2(m1.length_squared() - m2.length_squared());
    let turn = DVec2::from_angle(angle);
    let (first, second) = (turn.x * e1 + turn.y * e2, turn.x * e2 - turn.y * e1);
    ([image(first).length(), image(second).length()], first, second)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;
    use glam::DQuat;

    #[test]
    fn a_place_reaches_across_as_far_as_its_lever() {
        let floor = Surface::Plane { point: DVec3::ZERO, normal: DVec3::Z };
        let orientation = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.7, 1.3);
        for shape in [
            Shape::Sphere { radius: 0.5 },
            Shape::Spherocylinder { diameter: 1.0, length: 3.0 },
            Shape::Ellipsoid { radii: [0.5, 0.7, 1.2] },
            Shape::Torus { major_radius: 1.0, minor_radius: 0.2 },
        ] {
            let body = Placed { shape, position: DVec3::new(0.3, -0.2, 2.0), orientation };
            let force = DVec3::new(0.6, -1.1, 0.0);
            floor.places(&body, |place, found| {
                // The other places of a ring reach less far down.
                if place == 0 || matches!(shape, Shape::Spherocylinder { .. }) {
                    let reach = reach_across(&body, place, found.normal, force);
                    assert!((reach - found.lever_a.dot(force)).abs() < 1e-12, "{shape:?} {place}");
                }
            });
        }
    }
}
