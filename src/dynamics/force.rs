//! External forces: those that a scene may name and any that a library user plugs in.

use super::Dynamics;
use crate::bodies::Bodies;
use glam::DVec3;
#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign};

/// A force on a body's centre and a torque about it, space axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Force.
    pub force: DVec3,
    /// Torque.
    pub torque: DVec3,
}

impl Add for Load {
    type Output = Load;
    fn add(self, other: Load) -> Load {
        Load { force: self.force + other.force, torque: self.torque + other.torque }
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
/// let spring = |bodies: &relcp::bodies::Bodies, i: usize, _time: f64| Load { force: -bodies.position[i], torque: DVec3::ZERO };
/// let _boxed: Box<dyn ForceField> = Box::new(spring);
/// ```
pub trait ForceField: Send + Sync {
    /// The load on body `i` in the present state at `time`. It must depend on nothing else, or a run cannot be
    /// repeated. In periodic space positions are not wrapped ([`Periods::wrapped`](crate::periodic::Periods::wrapped)
    /// does), and a field must have the space's periods.
    fn load(&self, bodies: &Bodies, i: usize, time: f64) -> Load;
}

impl<F: Fn(&Bodies, usize, f64) -> Load + Send + Sync> ForceField for F {
    fn load(&self, bodies: &Bodies, i: usize, time: f64) -> Load {
        self(bodies, i, time)
    }
}

/// An external force.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
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
    },
    /// Weight: the body's mass times an acceleration. It needs the inertial law, where bodies have mass.
    Gravity {
        /// The acceleration.
        acceleration: [f64; 3],
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
    },
    /// `F(x) = -x (|x| - sin |x|) / |x|^2`: the paper's compaction.
    RadialInward {
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
    },
    /// `F(x) = +x (|x| - sin |x|) / |x|^2`: the paper's chainmail.
    RadialOutward {
        /// Only bodies of this group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
    },
}

impl Force {
    /// The force's name, which is its key in a scene file.
    pub fn name(&self) -> &'static str {
        match self {
            Force::Uniform { .. } => "uniform",
            Force::Gravity { .. } => "gravity",
            Force::RadialInward { .. } => "radial_inward",
            Force::RadialOutward { .. } => "radial_outward",
        }
    }

    /// The group whose bodies it acts on; `None` for all bodies.
    pub fn group(&self) -> Option<&str> {
        match self {
            Force::Uniform { group, .. }
            | Force::Gravity { group, .. }
            | Force::RadialInward { group }
            | Force::RadialOutward { group } => group.as_deref(),
        }
    }

    /// Whether it is [radial](radial): it points to or from the origin.
    pub(crate) fn is_radial(&self) -> bool {
        match self {
            Force::Uniform { .. } | Force::Gravity { .. } => false,
            Force::RadialInward { .. } | Force::RadialOutward { .. } => true,
        }
    }

    /// Its vector, under its key, where it is the same everywhere.
    pub(crate) fn vector(&self) -> Option<(&'static str, &[f64; 3])> {
        match self {
            Force::Uniform { force, .. } => Some(("force", force)),
            Force::Gravity { acceleration, .. } => Some(("acceleration", acceleration)),
            Force::RadialInward { .. } | Force::RadialOutward { .. } => None,
        }
    }

    /// Whether it acts on mass, which bodies have with inertia only.
    pub(crate) fn needs_mass(&self) -> bool {
        matches!(self, Force::Gravity { .. })
    }
}

/// These forces as fields. `groups` are the names of the groups, by index.
pub fn force_fields(forces: &[Force], groups: &[String], dynamics: &Dynamics) -> Vec<Box<dyn ForceField>> {
    forces.iter().map(|force| field(force, groups, dynamics)).collect()
}

fn field(force: &Force, groups: &[String], dynamics: &Dynamics) -> Box<dyn ForceField> {
    match *force {
        Force::Uniform { force, ref group } => on_group(group, groups, move |_, _| DVec3::from(force)),
        Force::Gravity { acceleration, ref group } => {
            // Without inertia bodies have no mass, and validation refuses such a scene.
            let density = dynamics.density().unwrap_or(0.0);
            on_group(group, groups, move |bodies, i| density * bodies.shape[i].volume() * DVec3::from(acceleration))
        }
        Force::RadialInward { ref group } => on_group(group, groups, |bodies, i| -radial(bodies.position[i])),
        Force::RadialOutward { ref group } => on_group(group, groups, |bodies, i| radial(bodies.position[i])),
    }
}

fn on_group(
    group: &Option<String>,
    groups: &[String],
    force: impl Fn(&Bodies, usize) -> DVec3 + Send + Sync + 'static,
) -> Box<dyn ForceField> {
    let only = group.as_ref().map(|name| groups.iter().position(|g| g == name));
    Box::new(move |bodies: &Bodies, i: usize, _time: f64| {
        let applies = only.is_none_or(|index| index == Some(bodies.group[i] as usize));
        Load { force: if applies { force(bodies, i) } else { DVec3::ZERO }, torque: DVec3::ZERO }
    })
}

/// Below this radius `(r - sin r) / r^2` is summed as its series, which the difference would lose: at 0.1 the first
/// term left out is 1e-12 of the value, and the difference keeps 13 digits.
const SERIES_RADIUS: f64 = 0.1;

/// `x (|x| - sin |x|) / |x|^2`, the paper's radial field; zero at the origin.
fn radial(x: DVec3) -> DVec3 {
    let r = x.length();
    if r < SERIES_RADIUS {
        let s = r * r;
        return x * r * (1.0 / 6.0 - s / 120.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)));
    }
    x * ((r - r.sin()) / (r * r))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radial_field_is_continuous_where_the_series_takes_over() {
        let below = radial(DVec3::X * (SERIES_RADIUS - 1e-13));
        let above = radial(DVec3::X * (SERIES_RADIUS + 1e-13));
        assert!((below - above).length() < 1e-13, "{below} {above}");
        assert_eq!(radial(DVec3::ZERO), DVec3::ZERO);
        let far = radial(DVec3::new(0.0, 0.0, 100.0));
        assert!((far.z - (100.0 - 100f64.sin()) / 100.0).abs() < 1e-15);
    }
}
