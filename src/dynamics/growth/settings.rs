//! How cells grow and divide, and what ends their growth.

use crate::dynamics::DaughterBond;
use crate::fields::Nutrient;
use crate::shape::Shape;
#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};

/// Growth and division of spherocylinders or ellipsoids: `length' = rate * length` between divisions.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Growth {
    /// The group of bodies that grow so, and of their daughters. Without it: all bodies without another entry of the
    /// list.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub group: Option<String>,
    /// The shape of the bodies that grow so; other bodies do not. An ellipsoid grows along its z, its longest axis, and
    /// keeps the radii of curvature of its tips: its other radii grow as the root of its length.
    #[cfg_attr(feature = "files", schemars(extend("default" = "spherocylinder")))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "GrowingShape::is_default"))]
    pub shape: GrowingShape,
    /// Relative growth rate.
    #[cfg_attr(feature = "files", schemars(range(min = 0)))]
    pub rate: f64,
    /// When a cell divides: at a length (`"sizer"`), after an added length (`"adder"`), or after a time since birth
    /// (`"timer"`).
    #[cfg_attr(feature = "files", schemars(extend("default" = "sizer")))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "DivisionRule::is_default"))]
    pub rule: DivisionRule,
    /// Required for a sizer: the tip-to-tip length at which a cell divides into two of half its length.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub division_length: Option<f64>,
    /// Required for an adder: a cell divides when it has grown by this length since birth.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub added_length: Option<f64>,
    /// Required for a timer: a cell divides this long after birth, as soon as its halves are not shorter than thick.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub division_time: Option<f64>,
    /// Each daughter turns by an angle drawn uniformly from plus and minus this, in degrees; one without room to
    /// turn so far turns less.
    #[cfg_attr(feature = "files", schemars(range(min = 0, max = 180)), serde(default))]
    pub reorientation_degrees: f64,
    /// Each cell has a division length of its own, drawn uniformly from `division_length` plus and minus this part of
    /// it.
    #[cfg_attr(feature = "files", schemars(range(min = 0), extend("exclusiveMaximum" = MOST_LENGTH_NOISE)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_zero"))]
    pub division_length_noise: f64,
    /// Each cell adds a length of its own, drawn uniformly from `added_length` plus and minus this part of it.
    #[cfg_attr(feature = "files", schemars(range(min = 0), extend("exclusiveMaximum" = 1)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_zero"))]
    pub added_length_noise: f64,
    /// Each cell has a time of its own, drawn uniformly from `division_time` plus and minus this part of it.
    #[cfg_attr(feature = "files", schemars(range(min = 0), extend("exclusiveMaximum" = 1)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_zero"))]
    pub division_time_noise: f64,
    /// Each cell has a rate of its own, drawn uniformly from `rate` plus and minus this part of it.
    #[cfg_attr(feature = "files", schemars(range(min = 0), extend("exclusiveMaximum" = 1)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_zero"))]
    pub rate_noise: f64,
    /// Growth slows under pressure: the rate of each cell is multiplied by `exp(-stress_sensitivity * pressure)`, with
    /// the pressure of the last step's contact forces on it. One over a pressure: force over area, in a planar scene
    /// over length. On a GPU the state is read back for it after every step.
    #[cfg_attr(feature = "files", schemars(range(min = 0)), serde(default, skip_serializing_if = "is_zero"))]
    pub stress_sensitivity: f64,
    /// Growth by what a field has at the cell: the rate of each cell is multiplied by `c / (half + c)`. Without it:
    /// cells have plenty.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub nutrient: Option<Nutrient>,
    /// The bond between the two daughters of a division; a daughter keeps the bond of her mother at her other end, so
    /// that cells form chains. Only with `"euler"` steps. Without it: daughters are free.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub bond_daughters: Option<DaughterBond>,
    /// What happens to cells without room to grow, in a container of walls or periods. All entries of a list must
    /// agree.
    #[cfg_attr(feature = "files", schemars(extend("default" = "stop")))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "OnNoRoom::is_default"))]
    pub on_no_room: OnNoRoom,
    /// Ends the run before `time.end`. Without it: the run goes to `time.end`. At most one entry of a list may have it.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub stop: Option<Stop>,
}

/// Which shape grows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum GrowingShape {
    /// Spherocylinders.
    #[default]
    Spherocylinder,
    /// Ellipsoids.
    Ellipsoid,
}

impl GrowingShape {
    #[cfg(feature = "files")]
    fn is_default(&self) -> bool {
        *self == GrowingShape::default()
    }

    /// Its name, as a scene has it.
    pub fn name(self) -> &'static str {
        match self {
            GrowingShape::Spherocylinder => "spherocylinder",
            GrowingShape::Ellipsoid => "ellipsoid",
        }
    }

    /// The name of such bodies.
    pub(crate) fn plural(self) -> &'static str {
        match self {
            GrowingShape::Spherocylinder => "spherocylinders",
            GrowingShape::Ellipsoid => "ellipsoids",
        }
    }
}

/// When a cell divides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum DivisionRule {
    /// At a length: `division_length`.
    #[default]
    Sizer,
    /// After an added length since birth: `added_length`.
    Adder,
    /// After a time since birth: `division_time`.
    Timer,
}

impl DivisionRule {
    #[cfg(feature = "files")]
    fn is_default(&self) -> bool {
        *self == DivisionRule::default()
    }

    /// Its name, as a scene has it.
    pub fn name(self) -> &'static str {
        match self {
            DivisionRule::Sizer => "sizer",
            DivisionRule::Adder => "adder",
            DivisionRule::Timer => "timer",
        }
    }
}

/// What happens when a container is full.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum OnNoRoom {
    /// The run ends with the state before the step and prints the reason; with `contact.on_failure` `"continue"` cells
    /// overlap instead.
    #[default]
    Stop,
    /// Cells without room neither grow nor divide in that step. The CPU takes such steps for a GPU.
    Stall,
}

#[cfg(feature = "files")]
impl OnNoRoom {
    fn is_default(&self) -> bool {
        *self == OnNoRoom::default()
    }
}

/// A cell of the least division length is not shorter than a daughter of the greatest where noise is below this.
pub(crate) const MOST_LENGTH_NOISE: f64 = 1.0 / 3.0;

#[cfg(feature = "files")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Growth {
    /// Growth at a rate per time, with division into halves at a tip-to-tip length; no noise, daughters along their
    /// mother.
    pub const fn new(rate: f64, division_length: f64) -> Growth {
        let mut growth = Growth::by(rate, DivisionRule::Sizer);
        growth.division_length = Some(division_length);
        growth
    }

    /// As [`Growth::new`], with division where a cell has grown by `added_length` since its birth.
    pub const fn adder(rate: f64, added_length: f64) -> Growth {
        let mut growth = Growth::by(rate, DivisionRule::Adder);
        growth.added_length = Some(added_length);
        growth
    }

    /// As [`Growth::new`], with division at a time since a cell's birth.
    pub const fn timer(rate: f64, division_time: f64) -> Growth {
        let mut growth = Growth::by(rate, DivisionRule::Timer);
        growth.division_time = Some(division_time);
        growth
    }

    const fn by(rate: f64, rule: DivisionRule) -> Growth {
        Growth {
            group: None,
            shape: GrowingShape::Spherocylinder,
            rate,
            rule,
            division_length: None,
            added_length: None,
            division_time: None,
            reorientation_degrees: 0.0,
            division_length_noise: 0.0,
            added_length_noise: 0.0,
            division_time_noise: 0.0,
            rate_noise: 0.0,
            stress_sensitivity: 0.0,
            nutrient: None,
            bond_daughters: None,
            on_no_room: OnNoRoom::Stop,
            stop: None,
        }
    }

    /// The length of a body of this shape, tip to tip, if such bodies grow.
    pub fn length_of(&self, shape: &Shape) -> Option<f64> {
        let grows = match self.shape {
            GrowingShape::Spherocylinder => matches!(shape, Shape::Spherocylinder { .. }),
            GrowingShape::Ellipsoid => matches!(shape, Shape::Ellipsoid { .. }),
        };
        shape.growing_length().filter(|_| grows)
    }

    /// The fastest that a cell grows.
    pub fn fastest_rate(&self) -> f64 {
        self.rate * (1.0 + self.rate_noise)
    }

    /// The key, the mean and the noise of what a cell divides at: a length, or of a timer a time. Not a number where
    /// the scene does not say; such a scene is refused.
    pub fn target(&self) -> (&'static str, f64, f64) {
        let (key, mean, noise) = match self.rule {
            DivisionRule::Sizer => ("division_length", self.division_length, self.division_length_noise),
            DivisionRule::Adder => ("added_length", self.added_length, self.added_length_noise),
            DivisionRule::Timer => ("division_time", self.division_time, self.division_time_noise),
        };
        (key, mean.unwrap_or(f64::NAN), noise)
    }

    /// Whether the scene does not say what cells divide at.
    pub(crate) fn has_no_target(&self) -> bool {
        let given = match self.rule {
            DivisionRule::Sizer => self.division_length,
            DivisionRule::Adder => self.added_length,
            DivisionRule::Timer => self.division_time,
        };
        given.is_none()
    }

    /// The least and the greatest of what cells divide at.
    pub fn targets(&self) -> [f64; 2] {
        let (_, mean, noise) = self.target();
        [1.0 - noise, 1.0 + noise].map(|part| part * mean)
    }
}

/// Ends a run before `time.end`, when the first of these is reached. Checked at the start and after every step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Stop {
    /// This many bodies or more: a step may divide several cells.
    #[cfg_attr(feature = "files", schemars(range(min = 1)), serde(skip_serializing_if = "Option::is_none"))]
    pub population: Option<u64>,
    /// This time is reached.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub time: Option<f64>,
    /// Radius: distance from the mean of the centres to the farthest point of a body. On a GPU this costs a read-back
    /// of the state per step.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub radius: Option<f64>,
}

/// What ended a run before `time.end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum StopReason {
    /// [`Stop::population`].
    Population,
    /// [`Stop::time`].
    Time,
    /// [`Stop::radius`].
    Radius,
    /// No body is left: all were removed.
    NoBodies,
}

impl StopReason {
    /// Its name, as the scene has it.
    pub fn name(self) -> &'static str {
        match self {
            StopReason::Population => "population",
            StopReason::Time => "time",
            StopReason::Radius => "radius",
            StopReason::NoBodies => "no_bodies",
        }
    }
}

/// How far under a time the end of a step may be and still count as it, as a part of the step: as for `time.end`.
const ROUNDING: f64 = 1e-6;

impl Stop {
    /// Which of them is reached by so many bodies at `time`, in steps of `dt`; `radius` is asked only where it decides.
    pub fn reached<E>(
        &self,
        bodies: usize,
        time: f64,
        dt: f64,
        radius: impl FnOnce() -> Result<f64, E>,
    ) -> Result<Option<StopReason>, E> {
        if self.population.is_some_and(|population| bodies as u64 >= population) {
            return Ok(Some(StopReason::Population));
        }
        if self.time.is_some_and(|end| time >= end - ROUNDING * dt) {
            return Ok(Some(StopReason::Time));
        }
        match self.radius {
            Some(most) if radius()? >= most => Ok(Some(StopReason::Radius)),
            _ => Ok(None),
        }
    }
}
