//! Laws of motion: what a body would do in the coming step without contact, and how readily contact moves it.
//!
//! A law gives two things per body, at the step's start `C^k`: the free velocity and the effective mobility.
//!
//! | law | free velocity | effective mobility `E` |
//! | --- | --- | --- |
//! | overdamped | `M F` | `M` |
//! | inertial | `u^k + dt F / m`, and the [mean angular velocity](Spin) of a free turn from `L^k + dt T` | `dt M^-1` |
//!
//! The velocity that the step moves with is then `U = U_free + E D gamma` for both, and the LCP matrix is `A = dt D^T E D`. With inertia the velocity that
//! it ends with is [another](Law::arrived). In a midpoint step forces and mobilities are those of the step's middle, and half of the forces' impulse comes
//! after the move.

mod force;
pub(crate) mod growth;
mod inertial;
mod law;
mod overdamped;
mod pressure;
mod spin;
mod waiting;

pub use crate::motion::{Pose, Twist, advance};
pub use force::{Force, ForceField, Load, force_fields};
pub(crate) use growth::MOST_LENGTH_NOISE;
pub use growth::{Cells, Growth, OnNoRoom, Stop, StopReason, grow, stretch};
pub use inertial::Inertial;
pub use law::{Dynamics, law};
pub use overdamped::Overdamped;
pub use pressure::pressures;
#[cfg(feature = "files")]
pub(crate) use pressure::virial_of_wall;
#[cfg(feature = "gpu")]
pub(crate) use spin::LAST_STEP;
pub use spin::Spin;
pub use waiting::Waiting;

use crate::bodies::Bodies;
use glam::{DMat3, DQuat, DVec3};

/// The symmetric square root `L` of a body's effective mobility, `L L = E`.
///
/// It is symmetric so that, where the z axis is an axis of the mobility (every planar scene), it maps z onto z and the
/// planar unknowns stay closed under it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor {
    /// Root of the translational mobility, the same in all directions.
    pub translation: f64,
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
    /// The angular momentum, space axes, over the first principal moment of inertia (as [`Spin`] has it).
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

    /// The velocity that body `i` ends the step with in `orientation`, after it `moved` with contact in it. Its `motion` was found in `here`.
    fn arrived(&self, _here: &Bodies, _i: usize, _motion: &Motion, moved: Twist, _orientation: DQuat) -> Twist {
        moved
    }

    /// Whether velocity is a part of the state.
    fn inertia(&self) -> bool {
        false
    }
}
