//! The rules that place bodies, as a scene file has them.

use super::lengths::Lengths;
use super::patterns::{Chain, Fence, Lattice, Repeat};
use crate::shape::Shape;
use crate::walls::Wall;
#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};

/// Bodies placed by rule.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum Generate {
    /// `count` bodies at random positions and isotropic random orientations, without overlap: wholly inside of
    /// `region`; or in a cube about `center` whose volume is theirs over `volume_fraction`, with centres in the cube
    /// and ends that may stick out; or, without both keys, anywhere inside of the walls and the periods. Each body
    /// keeps clear of the bounding capsules of all earlier ones, so rings do not interlock by chance. In a planar scene
    /// they are in the square of z = 0 whose area is that of their sections over `volume_fraction`, and their axes,
    /// body z, lie in uniform directions of the plane, with body x across it, as by `bodies[].angle`. In a periodic
    /// scene centres are spread over the whole period along each periodic axis, and bodies keep clear of images too;
    /// where all axes are periodic, `volume_fraction` is what `count` bodies are of the cell.
    Isotropic {
        /// Their number.
        #[cfg_attr(feature = "files", schemars(range(min = 1)))]
        count: u64,
        /// Their shape.
        shape: Shape,
        /// Lengths of spherocylinders that differ, in place of their shape's.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        lengths: Option<Lengths>,
        /// Further components in the same space; `volume_fraction` is that of all together. Components with the largest
        /// bounding capsules are placed first; bodies are numbered as listed.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
        mixture: Vec<Component>,
        /// Their volume over the cube's; at most what random placement reaches, which depends on the shape (0.32 for
        /// spheres). Optional if all axes are periodic (in a planar scene x and y): the number and the cell determine
        /// it. Without it, where walls and periods leave no way out: bodies are anywhere inside. Not with `region`.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        volume_fraction: Option<f64>,
        /// The shape of a wall that the bodies are wholly inside of, without being one: a box, a sphere, a cylinder ...
        /// With the scene's walls and periods it leaves no way out. Bodies are inside of the walls too.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        region: Option<Wall>,
        /// The cube's centre; in a planar scene its z is 0. Along a periodic axis it makes no difference. Only with
        /// `volume_fraction`, or where all axes are periodic.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_origin"))]
        center: [f64; 3],
        /// Their group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
    },
    /// A sheet of interlaced rings on a square lattice in the x-y plane, centred on the origin, without overlap: the
    /// lattice's spacing is 1.6 major radii, and each ring is linked with its four neighbours. The minor radius is at
    /// most 0.12 of the major radius.
    Chainmail {
        /// Rings along x.
        #[cfg_attr(feature = "files", schemars(range(min = 1)))]
        columns: u64,
        /// Rings along y.
        #[cfg_attr(feature = "files", schemars(range(min = 1)))]
        rows: u64,
        /// Radius of each ring's centreline.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        major_radius: f64,
        /// Radius of each ring's tube.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        minor_radius: f64,
        /// Their group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
    },
    /// A cell, by default at the origin with its axis along x; or several.
    Founder {
        /// Its diameter.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        diameter: f64,
        /// Its tip-to-tip length.
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
        length: f64,
        /// Its centre; that of the row if there are several.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_origin"))]
        position: [f64; 3],
        /// Angle of its axis from x towards y, in degrees.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_zero"))]
        angle: f64,
        /// Their number: they lie side by side in the x-y plane, 1.2 diameters from axis to axis.
        #[cfg_attr(
            feature = "files",
            schemars(range(min = 1)),
            serde(default = "one", skip_serializing_if = "is_one")
        )]
        count: u64,
        /// Copies of the row elsewhere.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
        repeat: Vec<Repeat>,
        /// Its group.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        group: Option<String>,
    },
    /// Bodies of one shape on a lattice.
    Lattice(Lattice),
    /// Fixed rods along a line, tip in tip: the sides of trenches, chambers and funnels; or posts.
    Fence(Fence),
    /// Bodies bonded end to end.
    Chain(Chain),
}

/// Bodies of one shape in a mixture.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Component {
    /// Their number.
    #[cfg_attr(feature = "files", schemars(range(min = 1)))]
    pub count: u64,
    /// Their shape.
    pub shape: Shape,
    /// Lengths of spherocylinders that differ, in place of their shape's.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub lengths: Option<Lengths>,
    /// Their group.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub group: Option<String>,
}

impl Component {
    /// `count` bodies without a group.
    pub const fn new(count: u64, shape: Shape) -> Component {
        Component { count, shape, lengths: None, group: None }
    }
}

impl Generate {
    /// `count` bodies at random about the origin, without group and mixture.
    pub const fn isotropic(count: u64, shape: Shape, volume_fraction: Option<f64>) -> Generate {
        Generate::Isotropic {
            count,
            shape,
            lengths: None,
            mixture: Vec::new(),
            volume_fraction,
            region: None,
            center: [0.0; 3],
            group: None,
        }
    }

    /// One cell at the origin, its axis along x, without group.
    pub const fn founder(diameter: f64, length: f64) -> Generate {
        Generate::Founder {
            diameter,
            length,
            position: [0.0; 3],
            angle: 0.0,
            count: 1,
            repeat: Vec::new(),
            group: None,
        }
    }
}

#[cfg(feature = "files")]
pub(super) fn is_false(flag: &bool) -> bool {
    !*flag
}

#[cfg(feature = "files")]
pub(super) fn is_origin(position: &[f64; 3]) -> bool {
    *position == [0.0; 3]
}

#[cfg(feature = "files")]
fn is_zero(angle: &f64) -> bool {
    *angle == 0.0
}

#[cfg(feature = "files")]
fn one() -> u64 {
    1
}

#[cfg(feature = "files")]
fn is_one(count: &u64) -> bool {
    *count == 1
}
