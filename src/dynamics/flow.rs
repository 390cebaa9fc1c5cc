//! A background flow: it carries bodies with the fluid at their centres and turns them as the fluid turns a body of
//! their shape.
//!
//! Steady simple shear is `u(x) = g (x . e) d` with unit vectors `d` along the flow and `e` along its gradient. Half of
//! its vorticity is `Omega = g/2 e x d`, its strain rate `D = g/2 (d e^T + e d^T)`. A free ellipsoid of semi-axes `a`,
//! `b`, `c` turns about its own axes with
//!
//! ```text
//! w_x = Omega_x + B_x D_yz,   B_x = (b^2 - c^2) / (b^2 + c^2),   and cyclically
//! ```
//!
//! (G. B. Jeffery, Proc. R. Soc. Lond. A 102, 161 (1922), for vanishing Reynolds numbers and a fluid without bounds).
//! Other bodies of revolution turn likewise with a constant `B` of their shape (F. P. Bretherton, J. Fluid Mech. 14,
//! 284 (1962)): [`Drag::bretherton`].
//!
//! Drag acts on what a body's motion differs by from this: `xi L (u - u(x))` and `xi L^3 / 12 (w - w_J)`, or with the
//! resistances of other [drag](Drag). So the flow is a load of the resistance times the velocities of the flow, for the
//! overdamped law and beside inertia alike.

use super::{Drag, Dynamics, ForceField, Load};
use crate::bodies::Bodies;
use crate::motion::Twist;
use crate::periodic::CellShear;
use crate::separation::Placed;
use crate::shape::Shape;
use glam::{DQuat, DVec3};

/// A background flow that carries and turns bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Flow {
    /// Steady simple shear: `u(x) = rate (x . gradient) direction`, zero at the origin.
    Shear {
        /// The velocity gradient along `gradient`, one over time; of either sign.
        rate: f64,
        /// The direction of the flow, a unit vector.
        direction: [f64; 3],
        /// The direction in which the velocity grows, a unit vector perpendicular to `direction`.
        gradient: [f64; 3],
    },
}

/// The flow of a scene and the resistance to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stream {
    /// What the velocity grows by over the distance along the gradient.
    pub rate: f64,
    /// Along the flow.
    pub direction: DVec3,
    /// Along its gradient, at right angles.
    pub gradient: DVec3,
    /// The law's drag.
    drag: Drag,
    /// Whether bodies move in the x-y plane.
    planar: bool,
}

impl Stream {
    /// The flow, under a law that has drag; none under one without.
    pub fn new(flow: &Flow, dynamics: &Dynamics, planar: bool) -> Option<Stream> {
        let drag = dynamics.any_drag()?;
        let Flow::Shear { rate, direction, gradient } = *flow;
        // A scene gives them to six digits.
        let direction = DVec3::from(direction).normalize_or_zero();
        let gradient = DVec3::from(gradient).reject_from(direction).normalize_or_zero();
        Some(Stream { rate, direction, gradient, drag, planar })
    }

    /// The flow of a sheared cell, under a law that has drag; none under one without.
    pub fn of_cell(shear: &CellShear, dynamics: &Dynamics, planar: bool) -> Option<Stream> {
        let (direction, gradient) = (shear.direction.unit().to_array(), shear.gradient.unit().to_array());
        Stream::new(&Flow::Shear { rate: shear.rate, direction, gradient }, dynamics, planar)
    }

    /// Half of the vorticity.
    pub fn turning(&self) -> DVec3 {
        0.5 * self.rate * self.gradient.cross(self.direction)
    }

    /// The power that drag takes from a body that moves otherwise than the flow carries it, which turns in the plane
    /// or in space.
    pub fn power(&self, at: &Placed, twist: Twist) -> f64 {
        let carried = self.carries(&at.shape, at.position, at.orientation);
        let resistance = self.drag.resistance(&at.shape);
        let apart = twist.angular - carried.angular;
        let apart = if self.planar { DVec3::new(0.0, 0.0, apart.z) } else { apart };
        resistance.linear.square(at.orientation, twist.linear - carried.linear)
            + resistance.turning.square(at.orientation, apart)
    }

    /// How the flow moves a body that nothing else drives.
    pub fn carries(&self, shape: &Shape, position: DVec3, orientation: DQuat) -> Twist {
        let back = orientation.conjugate();
        let (d, e) = (back * self.direction, back * self.gradient);
        // D_yz, D_zx and D_xy of the body's axes.
        let strain = 0.5 * self.rate * (yzx(d) * zxy(e) + yzx(e) * zxy(d));
        Twist {
            linear: self.rate * position.dot(self.gradient) * self.direction,
            // Validation refuses shapes without the constants.
            angular: self.turning() + orientation * (self.drag.bretherton(shape).unwrap_or_default() * strain),
        }
    }
}

pub(super) fn yzx(v: DVec3) -> DVec3 {
    DVec3::new(v.y, v.z, v.x)
}

pub(super) fn zxy(v: DVec3) -> DVec3 {
    DVec3::new(v.z, v.x, v.y)
}

impl ForceField for Stream {
    fn load(&self, bodies: &Bodies, i: usize, _time: f64) -> Load {
        let (shape, orientation) = (&bodies.shape[i], bodies.orientation[i]);
        let carried = self.carries(shape, bodies.position[i], orientation);
        let resistance = self.drag.resistance(shape);
        let force = resistance.linear.of(orientation, carried.linear);
        let load = Load { force, torque: resistance.turning.of(orientation, carried.angular) };
        if self.planar { load.in_plane() } else { load }
    }
}
