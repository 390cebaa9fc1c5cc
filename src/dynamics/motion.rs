//! What a law gives for each body.

#[cfg(doc)]
use super::Spin;
use super::along::Root;
use super::damping::Parts;
use super::{Load, Twist};
use crate::bodies::Bodies;
use glam::{DMat3, DQuat, DVec3};

/// The symmetric square root `L` of a body's effective mobility, `L L = E`.
///
/// It is symmetric so that, where the z axis is an axis of the mobility (every planar scene), it maps z onto z and the
/// planar unknowns stay closed under it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor {
    /// Root of the translational mobility.
    pub translation: Root,
    /// Root of the rotational mobility, space axes.
    pub rotation: DMat3,
}

/// One body's motion over the coming step, contact left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The velocity that it would have.
    pub free: Twist,
    /// How readily contact moves it.
    pub factor: Factor,
    /// What it would end with.
    pub ending: Ending,
}

/// What the velocity at a step's end is made of, contact left out; zero where a law has no inertia.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ending {
    /// What the velocity changes by after the move.
    pub linear: DVec3,
    /// The angular momentum, space axes, over the first principal moment of inertia (as `Spin` has it).
    pub momentum: DVec3,
    /// What drag and the forces still do after the move of a midpoint step, where there is drag.
    pub after: Option<After>,
}

/// The half of drag and forces that comes after a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct After {
    /// What drag leaves of the velocities.
    pub kept: Parts,
    /// The momentum that torques add, as [`Ending::momentum`].
    pub momentum: DVec3,
}

/// A law of motion.
pub trait Law: Send + Sync {
    /// Body `i`'s motion over a step of `dt` from its present state under `load`.
    fn motion(&self, bodies: &Bodies, i: usize, load: Load, dt: f64) -> Motion;

    /// Body `i`'s motion over a midpoint step of `dt` that begins in `start`, under a `load` found in its `middle`.
    fn motion_by_middle(&self, _start: &Bodies, middle: &Bodies, i: usize, load: Load, dt: f64) -> Motion {
        self.motion(middle, i, load, dt)
    }

    /// The velocity that body `i` ends the step with in `orientation`, after it `moved` with contact in it. Its
    /// `motion` was found in `here`.
    fn arrived(&self, _here: &Bodies, _i: usize, _motion: &Motion, moved: Twist, _orientation: DQuat) -> Twist {
        moved
    }
}
