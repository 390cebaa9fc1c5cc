//! The section of a body with the plane of a planar scene.

use super::{Centreline, Convex, Geometry, Shape};
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

impl Shape {
    /// The area of the section of a body, turned by `orientation`, with the plane of constant z through its centre, in
    /// which it is symmetric.
    ///
    /// ```
    /// use relcp::glam::DQuat;
    /// use relcp::Shape;
    /// let ball = Shape::Sphere { radius: 2.0 };
    /// assert_eq!(ball.section(DQuat::IDENTITY), 4.0 * std::f64::consts::PI);
    /// ```
    pub fn section(&self, orientation: DQuat) -> f64 {
        let upright = (orientation * DVec3::Z).z.abs() > 0.5;
        match self.geometry() {
            Geometry::Centreline { curve: Centreline::Point, radius } => PI * radius * radius,
            Geometry::Centreline { curve: Centreline::Segment { half }, radius } => {
                let diameter = 2.0 * radius;
                let disc = 0.25 * PI * diameter * diameter;
                if upright { disc } else { disc + diameter * (2.0 * half) }
            }
            Geometry::Ellipsoid { radii } => {
                let across = DVec3::AXES.map(|axis| (orientation * axis).z.abs());
                let k = (0..3).max_by(|i, j| across[*i].total_cmp(&across[*j])).unwrap_or(2);
                PI * radii[(k + 1) % 3] * radii[(k + 2) % 3]
            }
            Geometry::Centreline { curve: Centreline::Circle { radius: ring }, radius } => {
                if upright {
                    4.0 * PI * ring * radius
                } else {
                    TAU * radius * radius
                }
            }
            Geometry::Convex(shape) => section_of_convex(shape, orientation),
        }
    }
}

/// The number of normals for the integral over a custom shape's section. The integrand is periodic: the area of an
/// ellipse of aspect ratio 50 is exact to 1e-6.
const NORMALS: usize = 1024;

/// The body is symmetric in the plane, so the points with normals in the plane are the outline of its section: with the
/// support function `h` of the angle the area is half the integral of `h^2 - h'^2`.
fn section_of_convex(shape: Convex, orientation: DQuat) -> f64 {
    let part = |k: usize| {
        let angle = TAU * k as f64 / NORMALS as f64;
        let normal = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let point = orientation * shape.point(orientation.inverse() * normal);
        point.dot(normal).powi(2) - point.dot(DVec3::new(-normal.y, normal.x, 0.0)).powi(2)
    };
    PI / NORMALS as f64 * (0..NORMALS).map(part).sum::<f64>()
}
