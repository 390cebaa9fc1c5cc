//! A scene's rules for removing bodies.

use crate::walls::Wall;

/// A rule that removes bodies at the end of a step: exactly one of `outside`, `inside` and `rate`.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Removal {
    /// Removes bodies whose centre is outside this shape: on the empty side of a wall of this kind. In a periodic scene
    /// the centre's image in the cell about the origin counts. On a GPU this costs a read-back of the state per step.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub outside: Option<Wall>,
    /// Removes bodies whose centre is inside this shape. See `outside`.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub inside: Option<Wall>,
    /// Death at this rate, per time: in each step with the probability `1 - exp(-rate dt)`, drawn by the seed, the
    /// body's id and the step's number.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub rate: Option<f64>,
    /// The group that it applies to. Without it: all bodies except fixed ones, which are never removed.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub group: Option<String>,
}

impl Removal {
    /// Of bodies whose centre is outside of a shape.
    pub fn outside(shape: Wall) -> Removal {
        Removal { outside: Some(shape), ..Removal::default() }
    }

    /// Of bodies whose centre is inside of a shape.
    pub fn inside(shape: Wall) -> Removal {
        Removal { inside: Some(shape), ..Removal::default() }
    }

    /// Death at a rate.
    pub fn rate(rate: f64) -> Removal {
        Removal { rate: Some(rate), ..Removal::default() }
    }
}
