//! How steps are taken: their size and scheme, which rows are made, and how well contacts are resolved.

use crate::constraint::RowSource;
use crate::constraint::friction::{Friction, Restitution};
use crate::shape::Shape;
#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};

/// The default cutoff is this part of the thinnest body's thickness. It only decides which pairs get a row before the
/// first trial shows that they need one, beside those that the free motion may bring into contact. Between 1/4 and
/// 1/400 neither the recursions nor the products of a packed compaction (1,000 ellipsoids, dt = 0.1) or of a colony
/// change by more than 3 %, while the rows fall by 15 % and 8 %; two thirds of that are had at 1/10.
const CUTOFF_PER_THICKNESS: f64 = 0.1;

/// A part of a step that is rounding of the run's time, not a step.
const ROUNDING_OF_STEPS: f64 = 1e-6;

/// Step size and duration. If `dt` does not divide the time from start to end, the last step is shorter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Time {
    /// Step size.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub dt: f64,
    /// Time at which the run ends.
    pub end: f64,
    /// Time at which the run starts.
    #[cfg_attr(feature = "files", serde(default))]
    pub start: f64,
    /// The stepping scheme.
    #[cfg_attr(feature = "files", serde(default))]
    pub stepping: Stepping,
}

impl Time {
    /// Euler steps of `dt` from time 0 to `end`.
    pub const fn new(dt: f64, end: f64) -> Time {
        Time { dt, end, start: 0.0, stepping: Stepping::Euler }
    }

    /// How many steps the run takes. A last interval shorter than a millionth of `dt` is rounding, not a step.
    pub fn steps(&self) -> u64 {
        (((self.end - self.start) / self.dt) - ROUNDING_OF_STEPS).ceil().max(0.0) as u64
    }

    /// The length of step number `step`, from 1, in parts of `dt`: 1, and less for the last step where `dt` does not
    /// divide the run's time.
    pub fn span(&self, step: u64) -> f64 {
        let left = (self.end - self.start) / self.dt - (self.steps() as f64 - 1.0);
        if step == self.steps() && left < 1.0 - ROUNDING_OF_STEPS { left } else { 1.0 }
    }

    /// The time after `step` steps: multiples of `dt`, and `end` after the last one. Steps beyond the last are of `dt`
    /// each, from `end` on.
    ///
    /// ```
    /// let time = relcp::step::Time::new(0.3, 1.0);
    /// let times: Vec<f64> = (0..=time.steps()).map(|step| time.after(step)).collect();
    /// assert_eq!(times, [0.0, 0.3, 0.6, 0.3 * 3.0, 1.0]);
    /// ```
    pub fn after(&self, step: u64) -> f64 {
        let steps = self.steps();
        if step < steps || self.span(steps) == 1.0 {
            return self.start + step as f64 * self.dt;
        }
        self.end + (step - steps) as f64 * self.dt
    }
}

/// The stepping scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Stepping {
    /// The first-order step of the paper.
    #[default]
    Euler,
    /// Second order: forces, mobilities and first rows are evaluated at the middle of the step, which a half step
    /// predicts. A step costs about twice as much. With inertia, contact is of first order.
    Midpoint,
}

/// How contacts are resolved, their tolerances, and their friction.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields, default), schemars(rename = "Contact"))]
#[non_exhaustive]
pub struct ContactSettings {
    /// Which rows a step makes, and whether it recurses.
    pub method: Method,
    /// Largest overlap of smooth surfaces that an accepted step may leave, a length.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub overlap_tolerance: f64,
    /// The limit on recursions of a step.
    #[cfg_attr(feature = "files", schemars(range(min = 1)))]
    pub max_recursions: u32,
    /// The tolerance of the solves before a step's last one.
    #[cfg_attr(feature = "files", schemars(extend("default" = "auto")))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Recursion::is_default"))]
    pub recursion: Recursion,
    /// How first rows are made and violations answered.
    #[cfg_attr(feature = "files", schemars(extend("default" = "auto")))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Rows::is_default"))]
    pub rows: Rows,
    /// What to do with a step of the method `relcp` that still misses a tolerance in 64 pieces.
    #[cfg_attr(feature = "files", schemars(extend("default" = "stop")))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "OnFailure::is_default"))]
    pub on_failure: OnFailure,
    /// Pairs nearer than this at a step's start get a row (beside those that the free motion may bring into contact), a
    /// length. Without it: a tenth of the thinnest body's thickness.
    #[cfg_attr(feature = "files", schemars(range(min = 0)), serde(skip_serializing_if = "Option::is_none"))]
    pub cutoff: Option<f64>,
    /// Coulomb friction: a coefficient for all contacts, or an object with `bodies`, `walls` and `groups`. Without it:
    /// none. Static and sliding friction have the same coefficient.
    #[cfg_attr(feature = "files", serde(with = "crate::constraint::friction::number_or_object"))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Friction::is_none"))]
    #[cfg_attr(
        feature = "files",
        schemars(with = "crate::constraint::friction::number_or_object::NumberOr<Friction>")
    )]
    pub friction: Friction,
    /// How far a mean contact with friction slips elastically before it slides, a length; 0 for rigid stick, with which
    /// piles may collapse. Without it: 100 times `solver.tolerance`.
    #[cfg_attr(feature = "files", schemars(range(min = 0)), serde(skip_serializing_if = "Option::is_none"))]
    pub elastic_slip: Option<f64>,
    /// Restitution under the inertial law: a coefficient for all contacts, or an object with `bodies` and `walls`.
    /// Without it: none, contact takes the speed of approach.
    #[cfg_attr(feature = "files", serde(with = "crate::constraint::friction::number_or_object"))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Restitution::is_none"))]
    #[cfg_attr(
        feature = "files",
        schemars(with = "crate::constraint::friction::number_or_object::NumberOr<Restitution>")
    )]
    pub restitution: Restitution,
}

impl Default for ContactSettings {
    fn default() -> Self {
        let (method, recursion) = (Method::default(), Recursion::default());
        ContactSettings {
            method,
            overlap_tolerance: 1e-5,
            max_recursions: 64,
            recursion,
            rows: Rows::default(),
            on_failure: OnFailure::default(),
            cutoff: None,
            friction: Friction::default(),
            elastic_slip: None,
            restitution: Restitution::default(),
        }
    }
}

impl ContactSettings {
    /// How rows are made: methods without recursion have the paper's.
    pub fn rows_of_method(&self) -> Rows {
        if self.method == Method::Relcp { self.rows } else { Rows::Paper }
    }

    /// Distance within which bodies of these shapes are near at a step's start: as given, or a tenth of the thinnest
    /// one's thickness.
    pub fn cutoff_of(&self, shapes: impl Iterator<Item = Shape>) -> f64 {
        let default = || CUTOFF_PER_THICKNESS * shapes.map(|shape| shape.thickness()).reduce(f64::min).unwrap_or(0.0);
        self.cutoff.unwrap_or_else(default)
    }
}

/// Which rows smooth surfaces get.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Rows {
    /// One row for each smooth branch of a pair's separation that may become active in the step, linearised where the
    /// last velocities lead. A violation first moves its own row.
    #[default]
    Auto,
    /// The paper's: one row a pair, linearised at the step's start. Each violation appends one.
    Paper,
}

#[cfg(feature = "files")]
impl Rows {
    fn is_default(&self) -> bool {
        *self == Rows::default()
    }
}

/// What to do with a step that cannot meet its tolerances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum OnFailure {
    /// The run ends with the state before the step and prints the reason.
    #[default]
    Stop,
    /// The best attempt is accepted and counted: overlaps are spread over all contacts, and no body is thrown.
    Continue,
}

#[cfg(feature = "files")]
impl OnFailure {
    fn is_default(&self) -> bool {
        *self == OnFailure::default()
    }
}

/// The tolerance of the solves before a step's last one. The last one always meets `solver.tolerance`, and no step ends
/// with an overlap above `overlap_tolerance` either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Recursion {
    /// Inexact in space, where packed bodies recurse several times a step; adaptive for cells that grow in the open
    /// plane without friction; exact elsewhere, in midpoint steps, and if `solver.tolerance` is set.
    #[default]
    Auto,
    /// As the last one: trials, and so the rows made there, come from exact solutions.
    Exact,
    /// Exact, with the paper's rows, until a trial overlaps by more than a thousand tolerances; inexact for the rest of
    /// the step and its pieces, as where thousands of cells divide at once.
    Adaptive,
    /// As loose as the overlaps allow: a fifth to two fifths fewer iterations in crowded scenes. Rows then come from
    /// slightly inexact trials and depend slightly on the solver. Midpoint steps stay exact.
    Inexact,
}

#[cfg(feature = "files")]
impl Recursion {
    fn is_default(&self) -> bool {
        *self == Recursion::default()
    }
}

/// Which rows a step makes, and whether it recurses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Method {
    /// One row a near pair of smooth surfaces, more where the trial still overlaps.
    #[default]
    Relcp,
    /// One row a near pair of smooth surfaces, no recursion.
    Snsd,
    /// One row a near pair of sub-spheres, no recursion.
    Multisphere {
        /// Spheres a body: odd on a major axis; on a ring, enough to leave no gap.
        #[cfg_attr(feature = "files", schemars(range(min = 1)))]
        count: u32,
    },
}

impl Method {
    /// What its rows are made from.
    pub fn row_source(&self) -> RowSource {
        match *self {
            Method::Relcp | Method::Snsd => RowSource::Surfaces,
            Method::Multisphere { count } => RowSource::SubSpheres { count },
        }
    }

    /// Most recursions of a step, where a scene allows `allowed`.
    pub fn most_recursions(&self, allowed: u32) -> u32 {
        match self {
            Method::Relcp => allowed,
            Method::Snsd | Method::Multisphere { .. } => 0,
        }
    }
}
