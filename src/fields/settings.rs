//! The settings of fields.

use crate::walls::Wall;

/// A concentration on a grid of cubic cells, which diffuses and decays, and which bodies take up and secrete. In a
/// planar scene it is an amount over an area, else over a volume. Where a body is outside of the grid, the nearest cell
/// counts.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Field {
    /// The numbers of cells along x, y and z; in a planar scene 1 along z. Along an axis with one cell nothing diffuses
    /// but through the two borders.
    #[cfg_attr(feature = "files", schemars(inner(range(min = 1))))]
    pub cells: [u32; 3],
    /// The edge of a cell.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub spacing: f64,
    /// The middle of the grid. Without it: the origin. Along a periodic axis the grid is as long as the period.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_origin"))]
    pub center: [f64; 3],
    /// The diffusion coefficient, area over time.
    #[cfg_attr(feature = "files", schemars(range(min = 0)))]
    pub diffusion: f64,
    /// The part that decays in a time, over that time.
    #[cfg_attr(feature = "files", schemars(range(min = 0)), serde(default, skip_serializing_if = "is_zero"))]
    pub decay: f64,
    /// The concentration at the start.
    #[cfg_attr(feature = "files", schemars(range(min = 0)), serde(default, skip_serializing_if = "is_zero"))]
    pub initial: f64,
    /// That of each cell instead, x fastest, then y, then z. A run writes it into `final.json`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub values: Vec<f64>,
    /// What happens at the borders of the grid. Without it nothing passes them.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Borders::is_default"))]
    pub boundary: Borders,
    /// Regions in which the concentration is held, such as a channel that medium flows through.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub held: Vec<Held>,
    /// What bodies take up and secrete.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub exchange: Vec<Exchange>,
}

/// A region in which a field's concentration is held: in the grid cells whose centres are inside of it. Where regions
/// overlap, the last one counts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Held {
    /// The region: the inside of a shape, which is written like a wall and is none.
    pub inside: Wall,
    /// The concentration there.
    #[cfg_attr(feature = "files", schemars(range(min = 0)))]
    pub value: f64,
}

/// The borders of a field's grid: along each axis the low and the high one. Along a periodic axis there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Borders {
    /// Across x.
    pub x: [Border; 2],
    /// Across y.
    pub y: [Border; 2],
    /// Across z.
    pub z: [Border; 2],
}

/// A border of a field's grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Border {
    /// Nothing passes.
    #[default]
    Closed,
    /// The concentration there is this.
    Value(f64),
}

/// What bodies exchange with a field, per time and volume of the body; in a planar scene per area of its section with
/// the plane. `uptake` with `half`, or `secretion`.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Exchange {
    /// The group of bodies. Without it: all.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub group: Option<String>,
    /// The amount that is taken up where there is plenty: at the concentration `c` it is `uptake c / (half + c)`.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub uptake: Option<f64>,
    /// The concentration at which half of that is taken up.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub half: Option<f64>,
    /// The amount that is secreted.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub secretion: Option<f64>,
}

/// What cells grow by: their rate is multiplied by `c / (half + c)`, with the concentration `c` of a field at the cell
/// (J. Monod, Annu. Rev. Microbiol. 3, 371 (1949)). On a GPU the state is read back for it after every step.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Nutrient {
    /// The name of the field.
    pub field: String,
    /// The concentration at which a cell grows at half of its rate.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub half: f64,
}

#[cfg(feature = "files")]
fn is_origin(center: &[f64; 3]) -> bool {
    *center == [0.0; 3]
}

#[cfg(feature = "files")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Field {
    /// A field without anything in it, closed on all sides, about the origin.
    pub const fn new(cells: [u32; 3], spacing: f64, diffusion: f64) -> Field {
        Field {
            cells,
            spacing,
            center: [0.0; 3],
            diffusion,
            decay: 0.0,
            initial: 0.0,
            values: Vec::new(),
            boundary: Borders { x: [Border::Closed; 2], y: [Border::Closed; 2], z: [Border::Closed; 2] },
            held: Vec::new(),
            exchange: Vec::new(),
        }
    }

    /// The number of cells of the grid.
    pub fn count(&self) -> u64 {
        self.cells.iter().map(|count| u64::from(*count)).product()
    }
}

impl Borders {
    /// Those across each axis.
    pub fn each(&self) -> [[Border; 2]; 3] {
        [self.x, self.y, self.z]
    }

    #[cfg(feature = "files")]
    fn is_default(&self) -> bool {
        *self == Borders::default()
    }
}

impl Held {
    /// This concentration inside of a shape.
    pub const fn inside(shape: Wall, value: f64) -> Held {
        Held { inside: shape, value }
    }
}

impl Nutrient {
    /// Growth by the field of this name.
    pub fn new(field: impl Into<String>, half: f64) -> Nutrient {
        Nutrient { field: field.into(), half }
    }
}
