//! Shapes: what a body looks like in its own axes, its size, drag length, volume and inertia, and its proxies.
//!
//! Shapes come in two families, and separations are written once per family (`separation`): a *centreline* (a point,
//! a segment or a circle) thickened by a radius, and a strictly convex body given by its *support function*.

mod code;
mod convex;
mod ellipsoid;
mod error;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
mod section;
mod sphere;
mod spherocylinder;
mod superellipsoid;
mod torus;

#[cfg(any(feature = "gpu", feature = "files"))]
pub(crate) use code::Tag;
pub use convex::{Convex, ConvexError, SupportFunction};
pub use error::{ProxyError, ShapeError};
pub use superellipsoid::Superellipsoid;
#[cfg(feature = "files")]
pub(crate) use superellipsoid::{EXPONENTS, Norm};

use glam::{DQuat, DVec3};

/// A rigid shape in body axes, centred on the origin. Lengths are in the scene's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Shape {
    /// All points within `radius` of the centre.
    Sphere {
        /// Radius.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        radius: f64,
    },
    /// A cylinder with hemispherical ends; its axis is the body's z.
    Spherocylinder {
        /// Diameter of the cylinder and of the ends.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        diameter: f64,
        /// Length from tip to tip, so never less than the diameter.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        length: f64,
    },
    /// An ellipsoid with semi-axes along the body's x, y and z.
    Ellipsoid {
        /// The three semi-axes.
        #[cfg_attr(feature = "files", schemars(extend("items" = {"type": "number", "format": "double", "exclusiveMinimum": 0})))]
        radii: [f64; 3],
    },
    /// A ring: all points within `minor_radius` of a circle in the body's x-y plane.
    Torus {
        /// Radius of the circle.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        major_radius: f64,
        /// Radius of the tube, less than `major_radius`.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        minor_radius: f64,
    },
    /// A box with rounded edges and corners: `(|x / a|^n2 + |y / b|^n2)^(n1 / n2) + |z / c|^n1 <= 1`.
    Superellipsoid(Superellipsoid),
    /// A shape of one's own, made in code by [`Convex::new`]: no file holds one, and only the CPU computes with it.
    #[cfg_attr(feature = "files", serde(skip), schemars(skip))]
    Convex(Convex),
}

/// The curve that a shape of the centreline family is thickened around, in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub enum Centreline {
    /// The centre.
    Point,
    /// The segment from `-half` to `half` on the body's z.
    Segment {
        /// Half the segment's length.
        half: f64,
    },
    /// The circle of this radius in the body's x-y plane.
    Circle {
        /// The circle's radius.
        radius: f64,
    },
}

/// What a separation needs to know of a shape: its family and that family's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub enum Geometry {
    /// A curve thickened by `radius`.
    Centreline {
        /// The curve.
        curve: Centreline,
        /// The distance from the curve to the surface.
        radius: f64,
    },
    /// An ellipsoid with these semi-axes: support function `h(n) = |diag(radii) n|` in body axes.
    Ellipsoid {
        /// The three semi-axes.
        radii: DVec3,
    },
    /// A support function of the user's own.
    Convex(Convex),
}

/// One sphere of a multi-sphere proxy, in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProxySphere {
    /// Centre in body axes.
    pub centre: DVec3,
    /// Radius.
    pub radius: f64,
}

/// The largest ratio of a shape's largest to its smallest size that is supported.
///
/// Random poses of ellipsoids and rods up to it, 1000:1 and 1:1000 among them, were searched for a normal with a larger
/// bound: none beats the separation by more than 1e-15 of the size, and the contact points lie along the normal to
/// 1e-12 of the size.
pub const MAX_ASPECT: f64 = 1000.0;

/// The smallest size: its fifth power, as in a moment of inertia, is still a normal number.
pub const SMALLEST_SIZE: f64 = 1e-60;

/// The largest size: its fifth power is still finite.
pub const LARGEST_SIZE: f64 = 1e60;

/// How far a body may be from mirror-symmetric in its plane and still count as planar: 1e-9 of its size is below every
/// overlap tolerance in use and well above the 1e-16 that a quaternion is rounded to.
pub const PLANAR_TOLERANCE: f64 = 1e-9;

impl Shape {
    /// Checks that the sizes make a shape that separations support.
    ///
    /// # Errors
    /// Names the first size that is not finite, not positive or not between [`SMALLEST_SIZE`] and [`LARGEST_SIZE`],
    /// then what is wrong between sizes, then an aspect ratio over [`MAX_ASPECT`].
    ///
    /// ```
    /// use relcp::shape::{Shape, ShapeError};
    /// assert!(Shape::Sphere { radius: 0.5 }.validate().is_ok());
    /// let stub = Shape::Spherocylinder { diameter: 1.0, length: 0.5 };
    /// assert_eq!(stub.validate(), Err(ShapeError::ShorterThanDiameter { length: 0.5, diameter: 1.0 }));
    /// ```
    pub fn validate(&self) -> Result<(), ShapeError> {
        match *self {
            Shape::Sphere { radius } => sphere::validate(radius),
            Shape::Spherocylinder { diameter, length } => spherocylinder::validate(diameter, length),
            Shape::Ellipsoid { radii } => ellipsoid::validate(radii),
            Shape::Torus { major_radius, minor_radius } => torus::validate(major_radius, minor_radius),
            Shape::Superellipsoid(superellipsoid) => superellipsoid.validate(),
            // It was looked at when it was made.
            Shape::Convex(_) => Ok(()),
        }
    }

    /// The shape's name, which is its key in a scene file.
    pub fn name(&self) -> &'static str {
        match self {
            Shape::Sphere { .. } => "sphere",
            Shape::Spherocylinder { .. } => "spherocylinder",
            Shape::Ellipsoid { .. } => "ellipsoid",
            Shape::Torus { .. } => "torus",
            Shape::Superellipsoid(_) => "superellipsoid",
            Shape::Convex(_) => "custom shape",
        }
    }

    /// The shape's family and its numbers.
    #[inline]
    #[doc(hidden)]
    pub fn geometry(&self) -> Geometry {
        match *self {
            Shape::Sphere { radius } => Geometry::Centreline { curve: Centreline::Point, radius },
            Shape::Spherocylinder { diameter, length } => {
                Geometry::Centreline { curve: spherocylinder::centreline(diameter, length), radius: 0.5 * diameter }
            }
            Shape::Ellipsoid { radii } => Geometry::Ellipsoid { radii: DVec3::from_array(radii) },
            Shape::Torus { major_radius, minor_radius } => {
                Geometry::Centreline { curve: Centreline::Circle { radius: major_radius }, radius: minor_radius }
            }
            Shape::Superellipsoid(superellipsoid) => Geometry::Convex(superellipsoid.convex()),
            Shape::Convex(convex) => Geometry::Convex(convex),
        }
    }

    /// Whether it is known by its support function alone, as a superellipsoid and a shape of one's own.
    pub(crate) fn is_general(&self) -> bool {
        matches!(self.geometry(), Geometry::Convex(_))
    }

    /// Radius of the smallest sphere about the centre that holds the shape.
    #[inline]
    pub fn bounding_radius(&self) -> f64 {
        match *self {
            Shape::Sphere { radius } => radius,
            Shape::Spherocylinder { length, .. } => 0.5 * length,
            Shape::Ellipsoid { radii } => DVec3::from_array(radii).max_element(),
            Shape::Torus { major_radius, minor_radius } => major_radius + minor_radius,
            Shape::Superellipsoid(superellipsoid) => superellipsoid.convex().bounding_radius(),
            Shape::Convex(convex) => convex.bounding_radius(),
        }
    }

    /// The smallest diameter: of a torus, that of its tube.
    #[inline]
    pub fn thickness(&self) -> f64 {
        match *self {
            Shape::Sphere { radius } => 2.0 * radius,
            Shape::Spherocylinder { diameter, .. } => diameter,
            Shape::Ellipsoid { radii } => 2.0 * DVec3::from_array(radii).min_element(),
            Shape::Torus { minor_radius, .. } => 2.0 * minor_radius,
            Shape::Superellipsoid(superellipsoid) => superellipsoid.convex().thickness(),
            Shape::Convex(convex) => convex.thickness(),
        }
    }

    /// The radius of a ball that touches the surface at any point from inside and does not leave the body.
    pub(crate) fn inner_ball_radius(&self) -> f64 {
        match self.geometry() {
            Geometry::Centreline { radius, .. } => radius,
            Geometry::Ellipsoid { radii } => radii.min_element().powi(2) / radii.max_element(),
            Geometry::Convex(convex) => convex.roundness(),
        }
    }

    /// The length `L` of the local drag law: the largest extent, twice the bounding radius for every shape.
    #[inline]
    pub fn major_axis(&self) -> f64 {
        2.0 * self.bounding_radius()
    }

    /// Volume of the solid.
    pub fn volume(&self) -> f64 {
        match *self {
            Shape::Sphere { radius } => sphere::volume(radius),
            Shape::Spherocylinder { diameter, length } => spherocylinder::volume(diameter, length),
            Shape::Ellipsoid { radii } => ellipsoid::volume(radii),
            Shape::Torus { major_radius, minor_radius } => torus::volume(major_radius, minor_radius),
            Shape::Superellipsoid(superellipsoid) => superellipsoid.convex().volume(),
            Shape::Convex(convex) => convex.volume(),
        }
    }

    /// Principal moments of inertia of the solid about its centre, per unit density, along the body's x, y and z.
    ///
    /// ```
    /// use relcp::shape::Shape;
    /// let ball = Shape::Sphere { radius: 2.0 };
    /// assert!((ball.unit_inertia().x - 0.4 * ball.volume() * 4.0).abs() < 1e-12);
    /// ```
    pub fn unit_inertia(&self) -> DVec3 {
        match *self {
            Shape::Sphere { radius } => sphere::unit_inertia(radius),
            Shape::Spherocylinder { diameter, length } => spherocylinder::unit_inertia(diameter, length),
            Shape::Ellipsoid { radii } => ellipsoid::unit_inertia(radii),
            Shape::Torus { major_radius, minor_radius } => torus::unit_inertia(major_radius, minor_radius),
            Shape::Superellipsoid(superellipsoid) => superellipsoid.convex().unit_inertia(),
            Shape::Convex(convex) => convex.unit_inertia(),
        }
    }

    /// Bretherton's constants about the body's x, y and z: by which part of the strain rate across each axis a flow
    /// turns the body beyond the fluid's own turning, from -1 to 1 (G. B. Jeffery, Proc. R. Soc. Lond. A 102, 161
    /// (1922); F. P. Bretherton, J. Fluid Mech. 14, 284 (1962)).
    ///
    /// For an ellipsoid they are exact, `(b^2 - c^2) / (b^2 + c^2)` about x; a spherocylinder has the limit of a thin
    /// rod, as if it were endlessly long, and a ring that of a thin disc. `None` for a superellipsoid and a shape of
    /// one's own.
    pub fn bretherton(&self) -> Option<DVec3> {
        match *self {
            Shape::Sphere { .. } => Some(DVec3::ZERO),
            Shape::Spherocylinder { diameter, length } => Some(spherocylinder::bretherton(diameter, length)),
            Shape::Ellipsoid { radii } => Some(ellipsoid::bretherton(radii)),
            Shape::Torus { .. } => Some(torus::BRETHERTON),
            Shape::Superellipsoid(_) | Shape::Convex(_) => None,
        }
    }

    /// The axis that the shape is a body of revolution about, in body axes; of a sphere, which has all, and of a shape
    /// of one's own none.
    ///
    /// ```
    /// use relcp::shape::Shape;
    /// assert_eq!(Shape::Ellipsoid { radii: [2.0, 0.1, 2.0] }.axis_of_revolution(), Some(glam::DVec3::Y));
    /// assert_eq!(Shape::Ellipsoid { radii: [2.0, 0.1, 1.0] }.axis_of_revolution(), None);
    /// ```
    pub fn axis_of_revolution(&self) -> Option<DVec3> {
        match *self {
            Shape::Spherocylinder { .. } | Shape::Torus { .. } => Some(DVec3::Z),
            Shape::Ellipsoid { radii } => ellipsoid::axis_of_revolution(radii),
            Shape::Superellipsoid(superellipsoid) => superellipsoid.axis_of_revolution(),
            Shape::Sphere { .. } | Shape::Convex(_) => None,
        }
    }

    /// Half the sizes of the smallest box along the axes of space that holds the shape at this orientation.
    #[inline]
    pub fn half_extents(&self, orientation: DQuat) -> DVec3 {
        match *self {
            Shape::Sphere { radius } => DVec3::splat(radius),
            Shape::Spherocylinder { diameter, length } => spherocylinder::half_extents(diameter, length, orientation),
            Shape::Ellipsoid { radii } => ellipsoid::half_extents(radii, orientation),
            Shape::Torus { major_radius, minor_radius } => torus::half_extents(major_radius, minor_radius, orientation),
            Shape::Superellipsoid(superellipsoid) => superellipsoid.convex().half_extents(orientation),
            Shape::Convex(convex) => convex.half_extents(orientation),
        }
    }

    /// The length of a rod, tip to tip; `None` for other shapes.
    #[inline]
    pub fn rod_length(&self) -> Option<f64> {
        match *self {
            Shape::Spherocylinder { length, .. } => Some(length),
            _ => None,
        }
    }

    /// The length that growth changes: tip to tip along the body's z; `None` for a shape that cannot grow.
    #[inline]
    pub fn growing_length(&self) -> Option<f64> {
        match *self {
            Shape::Ellipsoid { radii: [.., z] } => Some(2.0 * z),
            _ => self.rod_length(),
        }
    }

    /// The same shape at another length, with the same tips: a spherocylinder keeps its diameter, an ellipsoid the
    /// radii of curvature `x^2 / z` and `y^2 / z` of its tips. `None` where the shape cannot grow, or would be shorter
    /// than wide.
    ///
    /// ```
    /// use relcp::shape::Shape;
    /// let cell = Shape::Spherocylinder { diameter: 0.5, length: 4.0 };
    /// assert_eq!(cell.grown(2.0), Some(Shape::Spherocylinder { diameter: 0.5, length: 2.0 }));
    /// assert_eq!(cell.grown(0.4), None);
    /// let cell = Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] };
    /// assert_eq!(cell.grown(1.0), Some(Shape::Ellipsoid { radii: [0.5, 0.5, 0.5] }));
    /// assert_eq!(cell.grown(0.9), None);
    /// assert_eq!(Shape::Sphere { radius: 1.0 }.grown(2.0), None);
    /// ```
    #[inline]
    pub fn grown(&self, length: f64) -> Option<Shape> {
        match *self {
            Shape::Spherocylinder { diameter, .. } if length >= diameter => {
                Some(Shape::Spherocylinder { diameter, length })
            }
            Shape::Ellipsoid { radii } => ellipsoid::grown(radii, 0.5 * length).map(|radii| Shape::Ellipsoid { radii }),
            _ => None,
        }
    }

    /// The radii of curvature of an ellipsoid's tips on z, along x and y.
    #[cfg(feature = "gpu")]
    pub(crate) fn tips(&self) -> Option<[f64; 2]> {
        if let Shape::Ellipsoid { radii } = *self { Some(ellipsoid::tips(radii)) } else { None }
    }

    /// The least length of a shape that grows, which growth does not change: the diameter of its tips. Of a shape that
    /// cannot grow its thickness.
    #[inline]
    pub fn shortest_length(&self) -> f64 {
        match *self {
            Shape::Ellipsoid { radii } => 2.0 * ellipsoid::tips(radii)[0].max(ellipsoid::tips(radii)[1]),
            _ => self.thickness(),
        }
    }

    /// A multi-sphere proxy: `count` overlapping spheres inside the surface and tangent to it, in order along the axis.
    ///
    /// After Markauskas, Kacianauskas, Dziugys and Navakas (2010), as far as Palmer, Aktulga and Gao (2026) describe
    /// it: an odd number of spheres on the major axis, the largest in the middle, the outermost touching the tips. How
    /// the spheres between are spaced is stated by neither; each shape's file says what is done here. A torus takes
    /// `count` equal spheres on its centreline, even or odd. A sphere is its own proxy, whatever the count.
    ///
    /// # Errors
    /// [`ProxyError::TooFew`] where the spheres could not reach both tips (fewer than three) or would leave gaps in a
    /// ring, [`ProxyError::Even`] for an even count on an axis, [`ProxyError::NoMajorAxis`] for an oblate ellipsoid.
    ///
    /// ```
    /// use relcp::shape::Shape;
    /// let proxy = Shape::Ellipsoid { radii: [1.0, 1.0, 2.0] }.proxy(7)?;
    /// assert_eq!(proxy.len(), 7);
    /// assert!((proxy[6].centre.z + proxy[6].radius - 2.0).abs() < 1e-15);
    /// # Ok::<(), relcp::shape::ProxyError>(())
    /// ```
    pub fn proxy(&self, count: usize) -> Result<Vec<ProxySphere>, ProxyError> {
        match *self {
            Shape::Sphere { radius } => sphere::proxy(radius, count),
            Shape::Spherocylinder { diameter, length } => spherocylinder::proxy(diameter, length, count),
            Shape::Ellipsoid { radii } => ellipsoid::proxy(radii, count),
            Shape::Torus { major_radius, minor_radius } => torus::proxy(major_radius, minor_radius, count),
            Shape::Superellipsoid(_) => Err(ProxyError::Superellipsoid),
            Shape::Convex(_) => Err(ProxyError::Custom),
        }
    }

    /// Whether there is a [proxy](Shape::proxy) of `count` spheres, without making it.
    ///
    /// # Errors
    /// Those of [`Shape::proxy`].
    pub fn check_proxy(&self, count: usize) -> Result<(), ProxyError> {
        match *self {
            Shape::Sphere { .. } => sphere::check_proxy(count),
            Shape::Spherocylinder { .. } => check_axis_count(count),
            Shape::Ellipsoid { radii } => ellipsoid::check_proxy(radii, count),
            Shape::Torus { major_radius, minor_radius } => torus::check_proxy(major_radius, minor_radius, count),
            Shape::Superellipsoid(_) => Err(ProxyError::Superellipsoid),
            Shape::Convex(_) => Err(ProxyError::Custom),
        }
    }

    /// Whether the plane through the centre at right angles to the z of space is a mirror plane of the body, to 1e-9
    /// of its size. Only such bodies stay in the plane of a planar scene.
    ///
    /// ```
    /// use glam::DQuat;
    /// use relcp::shape::Shape;
    /// let cell = Shape::Spherocylinder { diameter: 0.5, length: 2.0 };
    /// assert!(cell.is_planar_symmetric(DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2)));
    /// assert!(!cell.is_planar_symmetric(DQuat::from_rotation_y(1.0)));
    /// ```
    pub fn is_planar_symmetric(&self, orientation: DQuat) -> bool {
        match *self {
            Shape::Sphere { .. } => true,
            Shape::Spherocylinder { diameter, length } if length == diameter => true,
            Shape::Spherocylinder { .. } | Shape::Torus { .. } => {
                let axis = orientation * DVec3::Z;
                DVec3::new(axis.x, axis.y, 0.0).length() * axis.z.abs() <= PLANAR_TOLERANCE
            }
            Shape::Ellipsoid { radii } => ellipsoid::is_planar_symmetric(radii, orientation),
            Shape::Superellipsoid(superellipsoid) => superellipsoid.is_planar_symmetric(orientation),
            Shape::Convex(convex) => convex.is_planar_symmetric(orientation),
        }
    }
}

/// Refuses a size that is not a positive finite number.
fn check_size(name: &'static str, value: f64) -> Result<(), ShapeError> {
    if !value.is_finite() {
        Err(ShapeError::NotFinite { name, value })
    } else if value <= 0.0 {
        Err(ShapeError::NotPositive { name, value })
    } else if !(SMALLEST_SIZE..=LARGEST_SIZE).contains(&value) {
        Err(ShapeError::OutOfRange { name, value })
    } else {
        Ok(())
    }
}

/// Refuses a largest size too many times the smallest; `name` is the size to blame.
fn check_aspect(name: &'static str, largest: f64, smallest: f64) -> Result<(), ShapeError> {
    let aspect = largest / smallest;
    if aspect > MAX_ASPECT { Err(ShapeError::Aspect { name, aspect }) } else { Ok(()) }
}

/// Refuses a count that cannot stand on a major axis symmetrically and reach both tips.
fn check_axis_count(count: usize) -> Result<(), ProxyError> {
    if count < 3 {
        Err(ProxyError::TooFew { count, least: 3 })
    } else if count.is_multiple_of(2) {
        Err(ProxyError::Even { count })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::separation::{Placed, separation};
    use glam::EulerRot;
    use rand::{RngExt, SeedableRng};
    use std::f64::consts::PI;

    fn placed(shape: Shape, rng: &mut impl RngExt, reach: f64) -> Placed {
        let mut draw = |most: f64| rng.random_range(-most..most);
        let position = DVec3::new(draw(reach), draw(reach), draw(reach));
        Placed { shape, position, orientation: DQuat::from_euler(EulerRot::ZYZ, draw(PI), draw(PI), draw(PI)) }
    }

    #[test]
    fn bodies_are_no_farther_apart_than_the_inner_balls_of_an_earlier_contact() {
        let shapes = [
            Shape::Sphere { radius: 0.4 },
            Shape::Spherocylinder { diameter: 0.5, length: 2.0 },
            Shape::Ellipsoid { radii: [0.3, 0.5, 1.0] },
            Shape::Ellipsoid { radii: [1.0, 1.0, 0.05] },
        ];
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        for (first, second) in shapes.into_iter().flat_map(|first| shapes.map(|second| (first, second))) {
            for _ in 0..200 {
                let [a, b] = [placed(first, &mut rng, 2.0), placed(second, &mut rng, 2.0)];
                let found = separation(&a, &b, None).unwrap();
                if found.separation < 0.0 {
                    continue;
                }
                let moved = placed(second, &mut rng, 0.5);
                let moved = Placed { position: b.position + moved.position, ..moved };
                let [ball_a, ball_b] = [first, second].map(|shape| shape.inner_ball_radius());
                let centre_a = a.position + found.lever_a - found.normal * ball_a;
                let centre_b = b.orientation.inverse() * (found.lever_b + found.normal * ball_b);
                let balls = centre_a.distance(moved.position + moved.orientation * centre_b) - (ball_a + ball_b);
                let bodies = separation(&a, &moved, None).unwrap().separation;
                // Deep in each other the separation of bodies is not that of balls inside.
                assert!(balls < 0.0 || bodies <= balls + 1e-12, "{first:?} {second:?}: {bodies} > {balls}");
            }
        }
    }
}
