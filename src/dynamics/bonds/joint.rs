//! Joints of two bodies, as a scene has them: a point that they share, and what they keep beside it.

use super::Bond;
use super::turning::{Resists, Turning};
use glam::{DQuat, DVec3};

/// A joint between two bodies. Only with `"euler"` steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Joint {
    /// A point of one body stays at a point of the other; all turns about it are free.
    Ball {
        /// The indices of its two bodies, from 0: those of `bodies` in order, then those that `generate` places.
        bodies: [usize; 2],
        /// The point on each body, in body axes; it may be outside the body.
        at: [[f64; 3]; 2],
        /// The force over the distance between the points; `"rigid"` by default.
        #[cfg_attr(feature = "files", serde(default = "rigid", with = "super::stiffness"))]
        #[cfg_attr(feature = "files", schemars(with = "super::stiffness::Stiffness"))]
        stiffness: f64,
        /// Whether both bodies collide with each other.
        #[cfg_attr(feature = "files", serde(default = "super::collides", skip_serializing_if = "super::is_true"))]
        contact: bool,
    },
    /// As a ball, and only turns about an axis of both bodies are free. In a planar scene the axis is z.
    Hinge {
        /// The indices of its two bodies, from 0: those of `bodies` in order, then those that `generate` places.
        bodies: [usize; 2],
        /// The point on each body, in body axes; it may be outside the body.
        at: [[f64; 3]; 2],
        /// The axis, in the axes of the first body, of any length. Required in space.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        axis: Option<[f64; 3]>,
        /// The force over the distance between the points; `"rigid"` by default.
        #[cfg_attr(feature = "files", serde(default = "rigid", with = "super::stiffness"))]
        #[cfg_attr(feature = "files", schemars(with = "super::stiffness::Stiffness"))]
        stiffness: f64,
        /// The torque over the angle between the axes of both bodies, in radians; `"rigid"` by default.
        #[cfg_attr(feature = "files", serde(default = "rigid", with = "super::stiffness"))]
        #[cfg_attr(feature = "files", schemars(with = "super::stiffness::Stiffness"))]
        bending: f64,
        /// The orientation of the second body in the axes of the first one, `[w, x, y, z]`, which gives the second
        /// one's axis; up to a turn about the axis. Without it: as both start.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        rest: Option<[f64; 4]>,
        /// Whether both bodies collide with each other.
        #[cfg_attr(feature = "files", serde(default = "super::collides", skip_serializing_if = "super::is_true"))]
        contact: bool,
    },
    /// Both bodies move as one.
    Weld {
        /// The indices of its two bodies, from 0: those of `bodies` in order, then those that `generate` places.
        bodies: [usize; 2],
        /// The point on each body, in body axes; it may be outside the body.
        at: [[f64; 3]; 2],
        /// The force over the distance between the points; `"rigid"` by default.
        #[cfg_attr(feature = "files", serde(default = "rigid", with = "super::stiffness"))]
        #[cfg_attr(feature = "files", schemars(with = "super::stiffness::Stiffness"))]
        stiffness: f64,
        /// The torque over the angle of the turn from rest, in radians; `"rigid"` by default.
        #[cfg_attr(feature = "files", serde(default = "rigid", with = "super::stiffness"))]
        #[cfg_attr(feature = "files", schemars(with = "super::stiffness::Stiffness"))]
        bending: f64,
        /// The orientation of the second body in the axes of the first one at rest, `[w, x, y, z]`. Without it: as
        /// both start.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        rest: Option<[f64; 4]>,
        /// Whether both bodies collide with each other.
        #[cfg_attr(feature = "files", serde(default = "super::collides", skip_serializing_if = "super::is_true"))]
        contact: bool,
    },
}

#[cfg(feature = "files")]
const fn rigid() -> f64 {
    f64::INFINITY
}

impl Joint {
    /// A rigid ball joint of points of two bodies, body axes.
    pub const fn ball(bodies: [usize; 2], at: [[f64; 3]; 2]) -> Joint {
        Joint::Ball { bodies, at, stiffness: f64::INFINITY, contact: true }
    }

    /// A rigid hinge about an axis in the axes of the first body.
    pub const fn hinge(bodies: [usize; 2], at: [[f64; 3]; 2], axis: [f64; 3]) -> Joint {
        Joint::Hinge {
            bodies,
            at,
            axis: Some(axis),
            stiffness: f64::INFINITY,
            bending: f64::INFINITY,
            rest: None,
            contact: true,
        }
    }

    /// A rigid weld of two bodies as they start.
    ///
    /// ```
    /// use relcp::scene::Joint;
    /// let weld = Joint::weld([0, 1], [[0.0, 0.0, 0.5], [0.0, 0.0, -0.5]]);
    /// assert_eq!((weld.name(), weld.bodies()), ("weld", [0, 1]));
    /// ```
    pub const fn weld(bodies: [usize; 2], at: [[f64; 3]; 2]) -> Joint {
        Joint::Weld { bodies, at, stiffness: f64::INFINITY, bending: f64::INFINITY, rest: None, contact: true }
    }

    /// Its name, as a scene has it.
    pub const fn name(&self) -> &'static str {
        match self {
            Joint::Ball { .. } => "ball",
            Joint::Hinge { .. } => "hinge",
            Joint::Weld { .. } => "weld",
        }
    }

    /// The indices of its bodies.
    pub const fn bodies(&self) -> [usize; 2] {
        match *self {
            Joint::Ball { bodies, .. } | Joint::Hinge { bodies, .. } | Joint::Weld { bodies, .. } => bodies,
        }
    }

    /// Its point on each body, body axes.
    pub const fn at(&self) -> [[f64; 3]; 2] {
        match *self {
            Joint::Ball { at, .. } | Joint::Hinge { at, .. } | Joint::Weld { at, .. } => at,
        }
    }

    /// Whether its bodies collide with each other.
    pub const fn has_contact(&self) -> bool {
        match *self {
            Joint::Ball { contact, .. } | Joint::Hinge { contact, .. } | Joint::Weld { contact, .. } => contact,
        }
    }

    /// The stiffness of its point, and of the turns that it resists.
    pub(crate) const fn stiffnesses(&self) -> (f64, Option<f64>) {
        match *self {
            Joint::Ball { stiffness, .. } => (stiffness, None),
            Joint::Hinge { stiffness, bending, .. } | Joint::Weld { stiffness, bending, .. } => {
                (stiffness, Some(bending))
            }
        }
    }

    /// The orientation of the second body in the axes of the first one at rest, where the joint depends on it.
    pub(crate) fn rest(&self) -> Option<Option<[f64; 4]>> {
        match *self {
            Joint::Ball { .. } => None,
            Joint::Hinge { rest, .. } | Joint::Weld { rest, .. } => Some(rest),
        }
    }

    /// The same joint of other bodies, which rest so where it depends on it.
    pub(crate) fn with(mut self, held: [usize; 2], at_rest: Option<[f64; 4]>) -> Joint {
        match &mut self {
            Joint::Ball { bodies, .. } => *bodies = held,
            Joint::Hinge { bodies, rest, .. } | Joint::Weld { bodies, rest, .. } => {
                *bodies = held;
                *rest = at_rest.or(*rest);
            }
        }
        self
    }

    /// The bond that keeps its point.
    pub(super) fn bond(&self) -> Bond {
        let contact = self.has_contact();
        Bond { implicit: Some(true), contact, ..Bond::new(self.bodies(), self.at(), self.stiffnesses().0) }
    }

    /// What it resists beside the motion of its point, of bodies that rest so.
    pub(super) fn turning(&self, rest: DQuat, planar: bool) -> Option<Turning> {
        match *self {
            Joint::Ball { .. } => None,
            Joint::Hinge { axis: Some(axis), bending, .. } if !planar => {
                let axis = DVec3::from(axis).normalize();
                Some(Turning { stiffness: bending, resists: Resists::Bend([axis, rest.inverse() * axis]) })
            }
            Joint::Hinge { .. } => None,
            Joint::Weld { bending, .. } => Some(Turning { stiffness: bending, resists: Resists::Turn(rest) }),
        }
    }
}
