//! Laws of motion: what a body would do in the coming step without contact, and how readily contact moves it.
//!
//! A law gives two things per body, at the step's start `C^k`: the free velocity and the effective mobility.
//!
//! | law | free velocity | effective mobility `E` |
//! | --- | --- | --- |
//! | overdamped | `M F` | `M` |
//! | inertial | `u^k + dt F / m`, and the mean angular velocity of a free turn from `L^k + dt T` | `dt M^-1` |
//!
//! The velocity that the step moves with is then `U = U_free + E D gamma` for both, and the LCP matrix is `A = dt D^T E
//! D`. With inertia and [drag](Dynamics::Inertial) the velocity relaxes exactly over the step, and `E` falls from `dt
//! M^-1` to the overdamped `M`. With inertia the velocity that it ends with is another. In a midpoint step forces and
//! mobilities are those of the step's middle, and half of the forces' impulse comes after the move.

pub(crate) mod along;
pub(crate) mod bonds;
mod damping;
pub(crate) mod drag;
pub(crate) mod flow;
pub(crate) mod force;
pub(crate) mod growth;
pub(crate) mod inertial;
pub(crate) mod law;
pub(crate) mod motion;
pub(crate) mod overdamped;
mod pressure;
pub(crate) mod spin;
mod stability;
pub(crate) mod strain;
pub(crate) mod thermal;
pub(crate) mod waiting;

pub(crate) use crate::motion::{Pose, Twist, advance};
pub use along::Along;
pub(crate) use along::Root;
pub use bonds::BondName;
pub(crate) use bonds::turning::{Between, Turn, least_way};
pub use bonds::{Bending, Bond, DaughterBond, Joint};
pub(crate) use bonds::{Bonds, Incidence, Member, Unstable, instability};
pub use drag::{Drag, Resistance};
pub use flow::Flow;
pub(crate) use flow::Stream;
#[cfg(feature = "gpu")]
pub(crate) use force::along;
pub(crate) use force::force_fields;
pub use force::{Force, ForceField, Frame, Load, Window};
pub(crate) use growth::{Cells, MOST_LENGTH_NOISE, Species, stretch};
pub use growth::{DivisionRule, GrowingShape, Growth, OnNoRoom, Stop, StopReason};
pub(crate) use inertial::Inertial;
pub use law::Dynamics;
pub(crate) use law::law;
pub(crate) use motion::{Ending, Factor, Law, Motion};
pub(crate) use overdamped::Overdamped;
pub use pressure::pressures;
#[cfg(feature = "files")]
pub(crate) use pressure::virial_of_wall;
#[cfg(feature = "gpu")]
pub(crate) use spin::LAST_STEP;
pub(crate) use spin::Spin;
pub(crate) use stability::longest_stable_step;
pub(crate) use strain::Strain;
pub(crate) use thermal::Heat;
pub use thermal::Thermal;
pub(crate) use thermal::draw;
pub(crate) use waiting::Waiting;
