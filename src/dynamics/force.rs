//! External forces: those that a scene may name and any that a library user plugs in.

mod field;

pub use crate::window::Window;
pub use field::force_fields;

use super::Dynamics;
use crate::bodies::Bodies;
use crate::shape::Shape;
use glam::{DQuat, DVec3};
use std::ops::{Add, AddAssign, Mul};

/// A force on a body's centre and a torque about it, space axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Force.
    pub force: DVec3,
    /// Torque.
    pub torque: DVec3,
}

impl Load {
    /// What of it moves and turns a body in the x-y plane.
    pub(crate) fn in_plane(self) -> Load {
        Load { force: self.force.with_z(0.0), torque: DVec3::new(0.0, 0.0, self.torque.z) }
    }
}

impl Add for Load {
    type Output = Load;
    fn add(self, other: Load) -> Load {
        Load { force: self.force + other.force, torque: self.torque + other.torque }
    }
}

impl Mul<Load> for f64 {
    type Output = Load;
    fn mul(self, load: Load) -> Load {
        Load { force: self * load.force, torque: self * load.torque }
    }
}

impl AddAssign for Load {
    fn add_assign(&mut self, other: Load) {
        *self = *self + other;
    }
}

/// An external force field. A function `Fn(&Bodies, usize, f64) -> Load` is one.
///
/// ```
/// use relcp::dynamics::{ForceField, Load};
/// use glam::DVec3;
/// let pull = |x: DVec3| Load { force: -x, torque: DVec3::ZERO };
/// let spring = move |bodies: &relcp::bodies::Bodies, i: usize, _time: f64| pull(bodies.position[i]);
/// let _boxed: Box<dyn ForceField> = Box::new(spring);
/// ```
pub trait ForceField: Send + Sync {
    /// The load on body `i` in the present state at `time`. It must depend on nothing else, or a run cannot be
    /// repeated. In periodic space positions are not wrapped ([`Periods::wrapped`](crate::periodic::Periods::wrapped)
    /// does), and a field must have the space's periods.
    fn load(&self, bodies: &Bodies, i: usize, time: f64) -> Load;

    /// Called on one thread before the loads of a state are computed: at the start of a step or of a piece of a
    /// repeated one, and in the middle of a midpoint step. A field that computes all loads together does it here. An
    /// error ends the step with the state before it.
    ///
    /// # Errors
    /// A message.
    fn prepare(&self, _bodies: &Bodies, _time: f64) -> Result<(), String> {
        Ok(())
    }

    /// The part of the time from `span[0]` to `span[1]`, a step or a part of one, in which it acts, from 0 to 1: its
    /// loads count by so much.
    fn share(&self, _span: [f64; 2]) -> f64 {
        1.0
    }
}

impl<F: Fn(&Bodies, usize, f64) -> Load + Send + Sync> ForceField for F {
    fn load(&self, bodies: &Bodies, i: usize, time: f64) -> Load {
        self(bodies, i, time)
    }
}

/// An external force.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Force {
    /// The same force on every body.
    Uniform {
        /// The force.
        force: [f64; 3],
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
        /// When it acts. Without it: always.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        window: Option<Window>,
    },
    /// Weight: the body's mass times an acceleration. It needs the inertial law, where bodies have mass.
    Gravity {
        /// The acceleration.
        acceleration: [f64; 3],
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
        /// When it acts. Without it: always.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        window: Option<Window>,
    },
    /// `F(x) = -x (|x| - sin |x|) / |x|^2`: the paper's compaction.
    RadialInward {
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
        /// When it acts. Without it: always.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        window: Option<Window>,
    },
    /// `F(x) = +x (|x| - sin |x|) / |x|^2`: the paper's chainmail.
    RadialOutward {
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
        /// When it acts. Without it: always.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        window: Option<Window>,
    },
    /// A force along an axis of the body itself, which turns with it: self-propulsion.
    Propulsion {
        /// The force along the axis; a negative one points the other way.
        force: f64,
        /// The axis in body axes, of any length but zero.
        #[cfg_attr(feature = "files", serde(default = "body_z"))]
        axis: [f64; 3],
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
        /// When it acts. Without it: always.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        window: Option<Window>,
    },
    /// The same torque on every body.
    Torque {
        /// The torque.
        torque: [f64; 3],
        /// The axes in which it is given.
        #[cfg_attr(feature = "files", serde(default))]
        frame: Frame,
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
        /// When it acts. Without it: always.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        window: Option<Window>,
    },
    /// A harmonic trap: `F(x) = -stiffness (x - center)`. Along a periodic axis it pulls to the nearest image of the
    /// centre.
    Trap {
        /// Its stiffness, force over distance.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        stiffness: f64,
        /// Its centre.
        center: [f64; 3],
        /// Whether it acts along x, y and z.
        #[cfg_attr(feature = "files", serde(default = "all_axes"))]
        axes: [bool; 3],
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
        /// When it acts. Without it: always.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        window: Option<Window>,
    },
    /// A spring from a point of one body to a place: `F = stiffness (target - point) - damping v`. In periodic space it
    /// pulls to the nearest image of the target. Without effect while no body has the id.
    Pull {
        /// The body's id, as states have it.
        body: u64,
        /// The place that the point is pulled to.
        target: [f64; 3],
        /// Force over distance.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        stiffness: f64,
        /// The point, in body axes from the centre.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_origin"))]
        point: [f64; 3],
        /// The largest force of the spring. Without it: none.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        most: Option<f64>,
        /// Force over the velocity of the body's centre. It needs the inertial law.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        damping: Option<f64>,
        /// When it acts. Without it: always.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        window: Option<Window>,
    },
}

#[cfg(feature = "files")]
fn is_origin(point: &[f64; 3]) -> bool {
    *point == [0.0; 3]
}

#[cfg(feature = "files")]
const fn body_z() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

#[cfg(feature = "files")]
const fn all_axes() -> [bool; 3] {
    [true; 3]
}

/// The axes of a torque.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case"))]
pub enum Frame {
    /// The axes of space.
    #[default]
    Space,
    /// The axes of each body, which turn with it.
    Body,
}

impl Force {
    /// The force's name, which is its key in a scene file.
    pub fn name(&self) -> &'static str {
        match self {
            Force::Uniform { .. } => "uniform",
            Force::Gravity { .. } => "gravity",
            Force::RadialInward { .. } => "radial_inward",
            Force::RadialOutward { .. } => "radial_outward",
            Force::Propulsion { .. } => "propulsion",
            Force::Torque { .. } => "torque",
            Force::Trap { .. } => "trap",
            Force::Pull { .. } => "pull",
        }
    }

    /// How strong it is on a body: the paper's radial forces far out, a trap at a distance of the body's thickness.
    pub(crate) fn magnitude(&self, dynamics: &Dynamics, shape: &Shape) -> f64 {
        match self {
            Force::Uniform { force, .. } => DVec3::from(*force).length(),
            Force::Gravity { acceleration, .. } => {
                DVec3::from(*acceleration).length() * dynamics.density().unwrap_or(0.0) * shape.volume()
            }
            Force::Propulsion { force, .. } => force.abs(),
            Force::Trap { stiffness, .. } => stiffness * shape.thickness(),
            Force::RadialInward { .. } | Force::RadialOutward { .. } => 1.0,
            // It turns, and what holds it bears other forces; one body among many says nothing of the others.
            Force::Torque { .. } | Force::Pull { .. } => 0.0,
        }
    }

    /// Whether it grows with the distance from a place.
    pub(crate) fn is_trap(&self) -> bool {
        matches!(self, Force::Trap { .. })
    }

    /// The group whose bodies it acts on; `None` for all bodies.
    pub fn group(&self) -> Option<&str> {
        match self {
            Force::Uniform { group, .. }
            | Force::Gravity { group, .. }
            | Force::RadialInward { group, .. }
            | Force::RadialOutward { group, .. }
            | Force::Propulsion { group, .. }
            | Force::Torque { group, .. }
            | Force::Trap { group, .. } => group.as_deref(),
            Force::Pull { .. } => None,
        }
    }

    /// When it acts; `None` for always.
    pub fn window(&self) -> Option<&Window> {
        match self {
            Force::Uniform { window, .. }
            | Force::Gravity { window, .. }
            | Force::RadialInward { window, .. }
            | Force::RadialOutward { window, .. }
            | Force::Propulsion { window, .. }
            | Force::Torque { window, .. }
            | Force::Trap { window, .. }
            | Force::Pull { window, .. } => window.as_ref(),
        }
    }

    /// Whether it is [radial](field::radial): it points to or from the origin.
    pub(crate) fn is_radial(&self) -> bool {
        matches!(self, Force::RadialInward { .. } | Force::RadialOutward { .. })
    }

    /// Its vector, under its key, where it has one.
    pub(crate) fn vector(&self) -> Option<(&'static str, &[f64; 3])> {
        match self {
            Force::Uniform { force, .. } => Some(("force", force)),
            Force::Gravity { acceleration, .. } => Some(("acceleration", acceleration)),
            Force::Propulsion { axis, .. } => Some(("axis", axis)),
            Force::Torque { torque, .. } => Some(("torque", torque)),
            Force::Trap { center, .. } => Some(("center", center)),
            Force::Pull { target, .. } => Some(("target", target)),
            Force::RadialInward { .. } | Force::RadialOutward { .. } => None,
        }
    }

    /// What must be positive of it, under its key.
    pub(crate) fn positive(&self) -> Option<(&'static str, f64)> {
        match self {
            Force::Trap { stiffness, .. } | Force::Pull { stiffness, .. } => Some(("stiffness", *stiffness)),
            _ => None,
        }
    }

    /// The strength of a propulsion.
    pub(crate) fn along_axis(&self) -> Option<f64> {
        match self {
            Force::Propulsion { force, .. } => Some(*force),
            _ => None,
        }
    }

    /// The load on a body in `orientation` where it is the same at every place, without its mass.
    pub(crate) fn everywhere(&self, orientation: DQuat) -> Option<Load> {
        match *self {
            Force::Uniform { force, .. } => Some(pushing(DVec3::from(force))),
            Force::Gravity { acceleration, .. } => Some(pushing(DVec3::from(acceleration))),
            Force::Propulsion { force, axis, .. } => Some(pushing(orientation * along(force, axis))),
            Force::Torque { torque, frame: Frame::Space, .. } => Some(turning(DVec3::from(torque))),
            Force::Torque { torque, frame: Frame::Body, .. } => Some(turning(orientation * DVec3::from(torque))),
            Force::RadialInward { .. } | Force::RadialOutward { .. } | Force::Trap { .. } | Force::Pull { .. } => None,
        }
    }

    /// Whether it follows the body's orientation.
    pub(crate) fn turns_with_body(&self) -> bool {
        matches!(self, Force::Propulsion { .. } | Force::Torque { frame: Frame::Body, .. })
    }

    /// The centre of a trap, and the axes that it acts along.
    pub(crate) fn trap(&self) -> Option<([f64; 3], [bool; 3])> {
        match *self {
            Force::Trap { center, axes, .. } => Some((center, axes)),
            _ => None,
        }
    }

    /// Whether it pulls a single body, which devices do not compute.
    #[cfg(feature = "gpu")]
    pub(crate) fn is_pull(&self) -> bool {
        matches!(self, Force::Pull { .. })
    }

    /// Whether it acts on mass, which bodies have with inertia only.
    pub(crate) fn needs_mass(&self) -> bool {
        matches!(self, Force::Gravity { .. })
    }
}

/// A force without a torque.
fn pushing(force: DVec3) -> Load {
    Load { force, torque: DVec3::ZERO }
}

/// A torque without a force.
fn turning(torque: DVec3) -> Load {
    Load { force: DVec3::ZERO, torque }
}

/// A propulsion in body axes.
pub(crate) fn along(force: f64, axis: [f64; 3]) -> DVec3 {
    force * DVec3::from(axis).normalize_or_zero()
}
