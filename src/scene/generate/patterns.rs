//! The settings of rules that place bodies in a pattern: lattices, fences, chains, and copies of them.

#[cfg(feature = "files")]
use super::settings::{is_false, is_origin};
use crate::shape::Shape;
use crate::walls::Wall;
#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};

/// Copies of what a rule places. With several entries, each copies all that the entries before it make: two entries
/// make a table.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Repeat {
    /// Their number, the first included.
    #[cfg_attr(feature = "files", schemars(range(min = 1)))]
    pub count: u64,
    /// The way from each to the next.
    pub offset: [f64; 3],
}

impl Repeat {
    /// `count` copies, the first included, `offset` apart.
    pub const fn new(count: u64, offset: [f64; 3]) -> Repeat {
        Repeat { count, offset }
    }
}

/// The kind of a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum LatticeKind {
    /// A sheet of squares in the x-y plane, with rows along x.
    Square,
    /// A sheet of equal triangles in the x-y plane, with rows along x: six neighbours a body.
    Hexagonal,
    /// Cubes along the axes of space.
    Cubic,
}

/// Bodies of one shape on a lattice. They do not overlap each other; bodies of other rules and of `bodies` they may
/// overlap.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Lattice {
    /// The kind of lattice.
    pub kind: LatticeKind,
    /// Their shape.
    pub shape: Shape,
    /// The distance between the centres of neighbours.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub spacing: f64,
    /// The numbers of bodies along x, y and z; that along z is 1 in a sheet. Either this or `region`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", schemars(with = "Option<[std::num::NonZeroU64; 3]>"))]
    pub counts: Option<[u64; 3]>,
    /// The closed shape of a wall: every site of the lattice has a body where that is wholly inside. For a sheet, faces
    /// parallel to it are ignored.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub region: Option<Wall>,
    /// With `counts` the middle of the lattice, by default the origin; with `region` one of its sites, by default the
    /// middle of the region.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub center: Option<[f64; 3]>,
    /// The direction of all bodies' z. Without it, `angle` and `random`: z of space in a cubic lattice, x in a sheet.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub axis: Option<[f64; 3]>,
    /// Instead of `axis`, in a planar scene: the angle from x to the bodies' axis, degrees.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub angle: Option<f64>,
    /// Instead of `axis`: each body has an orientation of its own, drawn as those of `isotropic`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_false"))]
    pub random: bool,
    /// Their group.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub group: Option<String>,
}

impl Lattice {
    /// `counts` bodies about the origin, the axes of each those of space.
    pub const fn new(kind: LatticeKind, shape: Shape, spacing: f64, counts: [u64; 3]) -> Lattice {
        Lattice {
            kind,
            shape,
            spacing,
            counts: Some(counts),
            region: None,
            center: None,
            axis: None,
            angle: None,
            random: false,
            group: None,
        }
    }
}

/// Fixed rods along a line of points. Neighbours share the end of their axes. They are obstacles without a group that
/// says so: they do not move, may overlap walls and each other, and have no contact with these.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Fence {
    /// The line: a rod from each point to the next, its length from tip to tip their distance and a diameter. A single
    /// point is a post: a ball.
    pub points: Vec<[f64; 3]>,
    /// The diameter of the rods.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub diameter: f64,
    /// Whether a further rod joins the last point to the first.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_false"))]
    pub closed: bool,
    /// Copies of the fence: arrays of trenches, chambers or posts.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub repeat: Vec<Repeat>,
    /// Their group.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub group: Option<String>,
}

impl Fence {
    /// An open fence along these points, without group and copies.
    pub const fn new(points: Vec<[f64; 3]>, diameter: f64) -> Fence {
        Fence { points, diameter, closed: false, repeat: Vec::new(), group: None }
    }
}

/// Bodies of one shape joined end to end by bonds, as those of `bonds`. Balls are bonded at their centres, rods and
/// ellipsoids at the ends of their z axis. All bonds start at their rest length.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Chain {
    /// The number of bodies.
    #[cfg_attr(feature = "files", schemars(range(min = 2)))]
    pub count: u64,
    /// Their shape: a sphere, a spherocylinder, or an ellipsoid.
    pub shape: Shape,
    /// The stiffness of the bonds, force over distance; or `"rigid"`, which is an infinite one in code.
    #[cfg_attr(feature = "files", serde(with = "crate::dynamics::bonds::stiffness"))]
    #[cfg_attr(feature = "files", schemars(with = "crate::dynamics::bonds::stiffness::Stiffness"))]
    pub stiffness: f64,
    /// The distance between the surfaces of neighbours in a straight chain: between the tips of rods it is the bonds'
    /// rest length. Without it: a fifth of a body's thickness; then a joint of rods bends by 74 degrees before they
    /// touch.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", schemars(range(min = 0)))]
    pub gap: Option<f64>,
    /// The bending stiffness of the bonds, torque over angle; or `"rigid"`. Straight at rest, whatever the path; a
    /// chain with it has implicit bonds. Without it: bodies turn freely.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", serde(with = "crate::dynamics::bonds::stiffness::optional"))]
    #[cfg_attr(feature = "files", schemars(with = "crate::dynamics::bonds::stiffness::Stiffness"))]
    pub bending: Option<f64>,
    /// The tension above which a bond breaks. Without it: never.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    pub break_force: Option<f64>,
    /// Whether neighbours collide with each other.
    #[cfg_attr(feature = "files", serde(default = "crate::dynamics::bonds::collides"))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "crate::dynamics::bonds::is_true"))]
    pub contact: bool,
    /// How they start. Without it: straight along x, with the middle at the origin.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub path: Option<ChainPath>,
    /// Copies of the chain; each random walk is drawn separately.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub repeat: Vec<Repeat>,
    /// Their group.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub group: Option<String>,
}

impl Chain {
    /// A straight, unbreakable chain along x, with the middle at the origin.
    pub const fn new(count: u64, shape: Shape, stiffness: f64) -> Chain {
        Chain {
            count,
            shape,
            stiffness,
            gap: None,
            bending: None,
            break_force: None,
            contact: true,
            path: None,
            repeat: Vec::new(),
            group: None,
        }
    }
}

/// How a chain starts.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "files", serde(rename_all = "snake_case", deny_unknown_fields))]
#[non_exhaustive]
pub enum ChainPath {
    /// In a straight line.
    Straight {
        /// The middle of the chain.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_origin"))]
        center: [f64; 3],
        /// The direction of the chain, of any length.
        axis: [f64; 3],
    },
    /// A regular polygon in a plane parallel to the x-y plane; a further bond joins the last body to the first.
    Ring {
        /// The middle of the polygon.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_origin"))]
        center: [f64; 3],
    },
    /// Along a line: the ends of all bodies are on it.
    Along {
        /// The corners of the line, from the first end of the first body.
        points: Vec<[f64; 3]>,
    },
    /// A random walk that avoids itself, earlier bodies and walls.
    RandomWalk {
        /// The first end of the first body.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "is_origin"))]
        start: [f64; 3],
        /// The largest angle between a body's axis and the next one's, degrees. Directions within it are equally
        /// likely. Without it: 60.
        #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
        #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0), range(max = 180)))]
        largest_bend: Option<f64>,
    },
}

impl ChainPath {
    /// The path's name, which is its key.
    pub(in super::super) fn name(&self) -> &'static str {
        match self {
            ChainPath::Straight { .. } => "straight",
            ChainPath::Ring { .. } => "ring",
            ChainPath::Along { .. } => "along",
            ChainPath::RandomWalk { .. } => "random_walk",
        }
    }
}
