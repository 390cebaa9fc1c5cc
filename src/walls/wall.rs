//! The walls that a scene may have, and their surfaces.

use super::load::WallLoad;
use super::motion::{Moved, WallMotion};
use crate::separation::Surface;
use glam::DVec3;

/// A fixed or moving wall that bodies do not pass. In a planar scene walls are perpendicular to the plane; faces
/// parallel to it (of a box, the ends of a cylinder) are ignored.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Wall {
    /// A plane with the bodies on one side.
    HalfSpace {
        /// The direction from the plane towards the bodies, of any length.
        normal: [f64; 3],
        /// The distance of the plane from the origin along the normal.
        offset: f64,
        /// Its motion. Without it: none.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        motion: Option<WallMotion>,
        /// Its coefficient of friction. Without it: that of `contact.friction` for walls.
        #[cfg_attr(feature = "files", schemars(range(min = 0, max = 10)))]
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        friction: Option<f64>,
        /// A load that moves it along its normal, against a drag or a mass of its own. Without it: none.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        load: Option<WallLoad>,
    },
    /// Two parallel planes with the bodies between them.
    Channel {
        /// The direction across the planes, of any length.
        normal: [f64; 3],
        /// A point halfway between the planes.
        center: [f64; 3],
        /// The distance between the planes.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        width: f64,
        /// Its motion. Without it: none.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        motion: Option<WallMotion>,
        /// Its coefficient of friction. Without it: that of `contact.friction` for walls.
        #[cfg_attr(feature = "files", schemars(range(min = 0, max = 10)))]
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        friction: Option<f64>,
    },
    /// A box along the axes of space, with the bodies inside.
    Box {
        /// The corner with the smallest coordinates.
        minimum: [f64; 3],
        /// The corner with the largest coordinates.
        maximum: [f64; 3],
        /// Its motion. Without it: none.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        motion: Option<WallMotion>,
        /// Its coefficient of friction. Without it: that of `contact.friction` for walls.
        #[cfg_attr(feature = "files", schemars(range(min = 0, max = 10)))]
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        friction: Option<f64>,
    },
    /// A sphere, with the bodies inside.
    Sphere {
        /// Its centre.
        center: [f64; 3],
        /// Its radius.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        radius: f64,
        /// Its motion. Without it: none.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        motion: Option<WallMotion>,
        /// Its coefficient of friction. Without it: that of `contact.friction` for walls.
        #[cfg_attr(feature = "files", schemars(range(min = 0, max = 10)))]
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        friction: Option<f64>,
    },
    /// A cylinder, with the bodies inside.
    Cylinder {
        /// The middle of its axis.
        center: [f64; 3],
        /// The direction of its axis, of any length.
        axis: [f64; 3],
        /// Its radius.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        radius: f64,
        /// The distance between its flat ends. Without it: no ends.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        length: Option<f64>,
        /// Its motion. Without it: none.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        motion: Option<WallMotion>,
        /// Its coefficient of friction. Without it: that of `contact.friction` for walls.
        #[cfg_attr(feature = "files", schemars(range(min = 0, max = 10)))]
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        friction: Option<f64>,
    },
}

/// Two planes at `reach` from `centre` along `normal` and against it, facing each other.
fn facing(centre: DVec3, normal: DVec3, reach: f64) -> [Surface; 2] {
    [normal, -normal].map(|normal| Surface::Plane { point: centre - reach * normal, normal })
}

impl Wall {
    /// The wall's name, which is its key.
    pub fn name(&self) -> &'static str {
        match self {
            Wall::HalfSpace { .. } => "half_space",
            Wall::Channel { .. } => "channel",
            Wall::Box { .. } => "box",
            Wall::Sphere { .. } => "sphere",
            Wall::Cylinder { .. } => "cylinder",
        }
    }

    /// How it moves, where it does.
    pub fn motion(&self) -> Option<&WallMotion> {
        match self {
            Wall::HalfSpace { motion, .. }
            | Wall::Channel { motion, .. }
            | Wall::Box { motion, .. }
            | Wall::Sphere { motion, .. }
            | Wall::Cylinder { motion, .. } => motion.as_ref(),
        }
    }

    /// Its own coefficient of friction, where it has one.
    pub fn friction(&self) -> Option<f64> {
        match *self {
            Wall::HalfSpace { friction, .. }
            | Wall::Channel { friction, .. }
            | Wall::Box { friction, .. }
            | Wall::Sphere { friction, .. }
            | Wall::Cylinder { friction, .. } => friction,
        }
    }

    /// What it turns about, as the scene gives it.
    pub(crate) fn reference(&self) -> DVec3 {
        match *self {
            Wall::HalfSpace { normal, offset, .. } => offset * DVec3::from(normal).normalize_or(DVec3::X),
            Wall::Box { minimum, maximum, .. } => 0.5 * (DVec3::from(minimum) + DVec3::from(maximum)),
            Wall::Channel { center, .. } | Wall::Sphere { center, .. } | Wall::Cylinder { center, .. } => center.into(),
        }
    }

    /// Where it is at `time`; none where it never moves.
    pub(crate) fn moved(&self, time: f64) -> Option<Moved> {
        self.motion().map(|motion| motion.at(self.reference(), time))
    }

    /// The wall's surfaces at time 0; in a planar scene those that bodies can meet.
    pub fn surfaces(&self, planar: bool) -> Vec<Surface> {
        let unit = |v: [f64; 3]| DVec3::from(v).normalize_or(DVec3::X);
        let mut surfaces = match *self {
            Wall::HalfSpace { normal, offset, .. } => {
                let normal = unit(normal);
                vec![Surface::Plane { point: offset * normal, normal }]
            }
            Wall::Channel { normal, center, width, .. } => facing(center.into(), unit(normal), 0.5 * width).to_vec(),
            Wall::Box { minimum, maximum, .. } => {
                let (low, high) = (DVec3::from(minimum), DVec3::from(maximum));
                let faces = |normal: DVec3| {
                    [Surface::Plane { point: low, normal }, Surface::Plane { point: high, normal: -normal }]
                };
                DVec3::AXES.into_iter().flat_map(faces).collect()
            }
            Wall::Sphere { center, radius, .. } => vec![Surface::Sphere { centre: center.into(), radius }],
            Wall::Cylinder { center, axis, radius, length, .. } => {
                let (centre, axis) = (DVec3::from(center), unit(axis));
                let ends = length.into_iter().flat_map(|length| facing(centre, axis, 0.5 * length));
                [Surface::Cylinder { centre, axis, radius }].into_iter().chain(ends).collect()
            }
        };
        if planar {
            surfaces.retain(|surface| !matches!(surface, Surface::Plane { normal, .. } if across(*normal)));
        }
        surfaces
    }
}

/// Whether a unit vector is at right angles to the plane of a planar scene.
pub(crate) fn across(normal: DVec3) -> bool {
    normal.x == 0.0 && normal.y == 0.0
}
