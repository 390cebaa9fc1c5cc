//! How cells grow and divide, and what ends their growth.

#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};

/// Growth and division of spherocylinders: `length' = rate * length` between divisions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Growth {
    /// Relative growth per time.
    #[cfg_attr(feature = "files", schemars(range(min = 0)))]
    pub rate: f64,
    /// Tip-to-tip length at which a cell divides into two of half its length.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub division_length: f64,
    /// Each daughter turns by an angle drawn uniformly from plus and minus this, in degrees.
    #[cfg_attr(feature = "files", schemars(range(min = 0, max = 180)))]
    #[cfg_attr(feature = "files", serde(default))]
    pub reorientation_degrees: f64,
    /// Each cell has a division length of its own, drawn uniformly from `division_length` plus and minus this part of
    /// it.
    #[cfg_attr(feature = "files", schemars(range(min = 0), extend("exclusiveMaximum" = MOST_LENGTH_NOISE)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_zero"))]
    pub division_length_noise: f64,
    /// Each cell has a rate of its own, drawn uniformly from `rate` plus and minus this part of it.
    #[cfg_attr(feature = "files", schemars(range(min = 0), extend("exclusiveMaximum" = 1)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_zero"))]
    pub rate_noise: f64,
    /// Growth slows under pressure: the rate of each cell is multiplied by `exp(-stress_sensitivity * pressure)`, with
    /// the pressure of the last step's contact forces on it. One over a pressure: force over area, in a planar scene
    /// over length. On a GPU the state is read back for it after every step.
    #[cfg_attr(feature = "files", schemars(range(min = 0)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_zero"))]
    pub stress_sensitivity: f64,
    /// What happens to cells without room to grow, in a container of walls or periods.
    #[cfg_attr(feature = "files", schemars(extend("default" = "stop")))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "OnNoRoom::is_default"))]
    pub on_no_room: OnNoRoom,
    /// Ends the run before `time.end`. Without it: the run goes to `time.end`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub stop: Option<Stop>,
}

/// What growth does where a container is full.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum OnNoRoom {
    /// The run ends with the state before the step, and says so; with `contact.on_failure` `"continue"` cells overlap
    /// instead.
    #[default]
    Stop,
    /// Cells that have no room neither grow nor divide in that step. A GPU leaves such steps to the CPU.
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
        Growth {
            rate,
            division_length,
            reorientation_degrees: 0.0,
            division_length_noise: 0.0,
            rate_noise: 0.0,
            stress_sensitivity: 0.0,
            on_no_room: OnNoRoom::Stop,
            stop: None,
        }
    }

    /// The fastest that a cell grows.
    pub fn fastest_rate(&self) -> f64 {
        self.rate * (1.0 + self.rate_noise)
    }

    /// The least and the greatest length at which a cell divides.
    pub fn division_lengths(&self) -> [f64; 2] {
        [1.0 - self.division_length_noise, 1.0 + self.division_length_noise].map(|part| part * self.division_length)
    }
}

/// What ends a run before `time.end`: the first of these that is reached, looked for at the start and after every step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Stop {
    /// So many bodies, or more: a step may divide several cells.
    #[cfg_attr(feature = "files", schemars(range(min = 1)))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub population: Option<u64>,
    /// This time.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub time: Option<f64>,
    /// Radius: distance from the mean of the centres to the farthest point of a body. On a GPU, costs a read-back of
    /// the state per step.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub radius: Option<f64>,
}

/// What ended a run before `time.end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum StopReason {
    /// [`Stop::population`].
    Population,
    /// [`Stop::time`].
    Time,
    /// [`Stop::radius`].
    Radius,
}

impl StopReason {
    /// Its name, as the scene has it.
    pub fn name(self) -> &'static str {
        match self {
            StopReason::Population => "population",
            StopReason::Time => "time",
            StopReason::Radius => "radius",
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
