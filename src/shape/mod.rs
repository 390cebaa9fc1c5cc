//! Shapes: what a body looks like in its own axes, its size, drag length, volume and inertia, and its proxies.
//!
//! Shapes come in two families, and separations are written once per family (`separation`): a *centreline* (a point,
//! a segment or a circle) thickened by a radius, and a strictly convex body given by its *support function*.

mod code;
mod ellipsoid;
mod sphere;
mod spherocylinder;
mod torus;

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A rigid shape in body axes, centred on the origin. Lengths are in the scene's unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// All points within `radius` of the centre.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A cylinder with hemispherical ends; its axis is the body's z.
    Spherocylinder {
        /// Diameter of the cylinder and of the ends.
        diameter: f64,
        /// Length from tip to tip, so never less than the diameter.
        length: f64,
    },
    /// An ellipsoid with semi-axes along the body's x, y and z.
    Ellipsoid {
        /// The three semi-axes.
        radii: [f64; 3],
    },
    /// A ring: all points within `minor_radius` of a circle in the body's x-y plane.
    Torus {
        /// Radius of the circle.
        major_radius: f64,
        /// Radius of the tube, less than `major_radius`.
        minor_radius: f64,
    },
}

/// The curve that a shape of the centreline family is thickened around, in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

/// One sphere of a multi-sphere proxy, in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProxySphere {
    /// Centre in body axes.
    pub centre: DVec3,
    /// Radius.
    pub radius: f64,
}
