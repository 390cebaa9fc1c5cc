//! The shared-normal signed distance (SNSD) of a pair of bodies, with its normal and levers.
//!
//! For convex pairs `Phi = max over unit n of n . (x_b - x_a) - h_a(n) - h_b(-n)`; for centreline pairs the distance of
//! the two centrelines less the two radii. `Phi > 0` apart, `Phi < 0` overlap.

use crate::shape::Shape;
use glam::{DQuat, DVec3};

/// A body's shape where it is: what a separation is computed from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// The shape, in body axes.
    pub shape: Shape,
    /// Position of the centre.
    pub position: DVec3,
    /// Unit quaternion taking body axes to space.
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
