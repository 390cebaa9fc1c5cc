//! A scene: everything that determines a run, as in a scene file (JSON).
//!
//! The types below are the file's reference: the reader, the JSON Schema and the written `scene.json` derive from them.
//! Variants are externally tagged (`{"ellipsoid": {...}}`) and unknown keys are refused.

#[cfg(feature = "files")]
mod adjustable;
mod build;
#[cfg(feature = "files")]
mod built_in;
#[cfg(feature = "files")]
pub(crate) mod changes;
#[cfg(feature = "files")]
mod comments;
mod drive;
mod error;
#[cfg(feature = "files")]
mod excerpt;
#[cfg(feature = "files")]
mod foreign;
mod generate;
mod key;
mod nearest;
mod orientation;
#[cfg(feature = "files")]
mod place;
#[cfg(feature = "files")]
mod read;
#[cfg(feature = "files")]
mod reference;
pub(crate) mod remarks;
#[cfg(feature = "files")]
mod set;
mod settings;
#[cfg(feature = "files")]
mod translate;
#[cfg(feature = "files")]
mod tree;
mod validate;
#[cfg(feature = "files")]
mod write;

pub use crate::constraint::friction::{Friction, GroupFriction, Restitution};
pub use crate::dynamics::{
    Bending, Bond, DaughterBond, DivisionRule, Drag, Dynamics, Flow, Force, Frame, GrowingShape, Growth, Joint,
    OnNoRoom, Stop, StopReason, Thermal, Window,
};
pub use crate::fields::{Border, Borders, Exchange, Field, Held, Nutrient};
pub use crate::lcp::SolverKind;
pub use crate::periodic::{Axis, CellShear, Periodic};
pub use crate::removal::Removal;
pub use crate::step::{ContactSettings, Dump, DumpWhen, Method, OnFailure, Recursion, Rows, Stepping, Time};
pub use crate::walls::{Wall, WallLoad, WallMotion};
#[cfg(feature = "files")]
pub use built_in::BuiltIn;
#[cfg(feature = "files")]
pub use changes::KeyChange;
pub use error::{FaultKind, SceneError};
pub use generate::{Chain, ChainPath, Component, Fence, Generate, Lattice, LatticeKind, Lengths, Repeat};
#[doc(hidden)]
pub use nearest::nearest;
pub(crate) use orientation::{norm as quaternion_norm, unit as unit_quaternion};
#[cfg(feature = "files")]
pub use read::{MAX_FILE_BYTES, NO_OVERRIDES};
#[cfg(feature = "files")]
pub(crate) use read::{Source, is_bare};
#[cfg(feature = "files")]
pub use reference::reference;
#[cfg(feature = "files")]
pub(crate) use set::Override;
#[cfg(feature = "files")]
pub use tree::parse_json;
pub use validate::{LARGEST_NUMBER, MAX_BODIES, MAX_STATES, MAX_STEPS, SMALLEST_NUMBER, SMALLEST_QUATERNION};
#[cfg(feature = "files")]
pub use write::schema;

use crate::bodies::Lineage;
use crate::shape::Shape;
#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Everything that determines a run.
///
/// [`Scene::new`] makes one in code, and assignments change it. Later versions may add fields; their defaults leave a
/// scene unchanged.
///
/// ```
/// use relcp::scene::{Body, Time};
/// use relcp::{Scene, Shape};
/// let mut scene = Scene::new("ball", Time::new(0.1, 1.0));
/// scene.contact.overlap_tolerance = 1e-6;
/// scene.bodies.push(Body::new(Shape::Sphere { radius: 1.0 }, [0.0; 3]));
/// assert_eq!(scene.build()?.len(), 1);
/// # Ok::<(), relcp::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[cfg_attr(feature = "files", schemars(description = "Everything that determines a run."))]
#[non_exhaustive]
pub struct Scene {
    /// The scene's name, for the summary and the run's folder.
    pub name: String,
    /// Everything random is drawn from this.
    #[cfg_attr(feature = "files", serde(default))]
    pub seed: u64,
    /// The id of the next cell born. A run writes it into `final.json` if cells with larger ids have died. Without it:
    /// the one after the largest of `bodies[].lineage`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub next_id: Option<u64>,
    /// The law of motion.
    #[cfg_attr(feature = "files", serde(default))]
    pub dynamics: Dynamics,
    /// Step size and duration.
    pub time: Time,
    /// How contacts are resolved, and their tolerances.
    #[cfg_attr(feature = "files", serde(default))]
    pub contact: ContactSettings,
    /// The LCP solver.
    #[cfg_attr(feature = "files", serde(default))]
    pub solver: Solver,
    /// Bodies move in the x-y plane and turn about z; no other unknowns are carried.
    #[cfg_attr(feature = "files", serde(default))]
    pub planar: bool,
    /// External forces.
    #[cfg_attr(feature = "files", serde(default))]
    pub forces: Vec<Force>,
    /// Springs between points of bodies.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub bonds: Vec<Bond>,
    /// Ball joints, hinges and welds of two bodies.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub joints: Vec<Joint>,
    /// Brownian motion. With inertia it needs `dynamics.inertial.drag`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub thermal: Option<Thermal>,
    /// A background flow that carries and turns bodies. With inertia it needs `dynamics.inertial.drag`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub flow: Option<Flow>,
    /// Fixed or moving walls that bodies do not pass. Bodies start inside; one with a `lineage`, which a run wrote, may
    /// start past a wall.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub walls: Vec<Wall>,
    /// Periods of space: bodies that leave through one side meet those at the other side.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub periodic: Option<Periodic>,
    /// Growth and division of spherocylinders or ellipsoids: an object, or a list of objects, species of bodies that
    /// each belong to one `group`.
    #[cfg_attr(feature = "files", serde(default, with = "crate::dynamics::growth::one_or_list"))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Vec::is_empty"))]
    #[cfg_attr(feature = "files", schemars(with = "crate::dynamics::growth::one_or_list::GrowthSchema"))]
    pub growth: Vec<Growth>,
    /// Concentrations on grids, by their names: they diffuse and decay, bodies take them up and secrete them, and cells
    /// may grow by them.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "BTreeMap::is_empty"))]
    pub fields: BTreeMap<String, Field>,
    /// How bodies are removed: outside or inside a region, or by death. A run then writes `lineage.csv`.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub removal: Vec<Removal>,
    /// Bodies placed one by one.
    #[cfg_attr(feature = "files", serde(default))]
    pub bodies: Vec<Body>,
    /// Properties of the bodies of a group, by the group's name.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "BTreeMap::is_empty"))]
    pub groups: BTreeMap<String, Group>,
    /// Bodies placed by rule, after `bodies`, drawn from `seed`, inside all walls.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub generate: Vec<Generate>,
    /// Other values of keys from given times on, in order of time. A run with changes has the bits of one that went on
    /// with them by `--from`.
    #[cfg(feature = "files")]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<KeyChange>,
    /// What to record, and how often.
    #[cfg_attr(feature = "files", serde(default))]
    pub output: Output,
}

impl Scene {
    /// A scene without bodies, of this name, whose other settings are the defaults of a scene file.
    pub fn new(name: impl Into<String>, time: Time) -> Scene {
        Scene {
            name: name.into(),
            seed: u64::default(),
            next_id: None,
            dynamics: Dynamics::default(),
            time,
            contact: ContactSettings::default(),
            solver: Solver::default(),
            planar: bool::default(),
            forces: Vec::default(),
            bonds: Vec::default(),
            joints: Vec::default(),
            thermal: None,
            flow: None,
            walls: Vec::default(),
            periodic: None,
            growth: Vec::default(),
            fields: BTreeMap::default(),
            removal: Vec::default(),
            bodies: Vec::default(),
            groups: BTreeMap::default(),
            generate: Vec::default(),
            #[cfg(feature = "files")]
            changes: Vec::default(),
            output: Output::default(),
        }
    }
}

/// The LCP solver and when it stops.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Solver {
    /// The solver.
    pub kind: SolverKind,
    /// Largest natural residual that counts as solved, a length. Without it: the smaller of a tenth of the overlap
    /// tolerance and a thousandth of what forces, growth or walls move a body by in a step.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub tolerance: Option<f64>,
    /// The limit on iterations of a solve. Without it: 100,000.
    #[cfg_attr(feature = "files", schemars(range(min = 1)), serde(skip_serializing_if = "Option::is_none"))]
    pub max_iterations: Option<u64>,
    /// The LCPs to save into the run's folder `lcps`. Without it: none.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub dump: Option<Dump>,
}

/// Properties of the bodies of a group.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Group {
    /// Whether they are obstacles that do not move.
    pub fixed: bool,
}

/// One body.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Body {
    /// Its shape.
    pub shape: Shape,
    /// Its centre.
    pub position: [f64; 3],
    /// `[w, x, y, z]`, body axes to space; normalized on reading. Without it, `axis` and `angle`: the axes of space.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub orientation: Option<[f64; 4]>,
    /// Instead of `orientation`: the direction of the body's z, the axis of rods and rings, of any length. The body's y
    /// stays in the x-y plane.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub axis: Option<[f64; 3]>,
    /// Instead of `orientation`, in a planar scene: the angle from x to the body's axis, degrees.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub angle: Option<f64>,
    /// Whether it is an obstacle that does not move.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "std::ops::Not::not"))]
    pub fixed: bool,
    /// Velocity, under the inertial law.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity in space axes, under the inertial law.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub angular_velocity: Option<[f64; 3]>,
    /// The group it belongs to, for forces.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub group: Option<String>,
    /// The numbers of the bonds at a cell's lower and upper end along its z, as a run with `growth.bond_daughters`
    /// writes them into `final.json`: an upper and a lower end with the same number are bonded, 0 is no bond.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub daughter_bonds: Option<[u64; 2]>,
    /// Identity and ancestry; all keys or none.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub lineage: Option<BodyLineage>,
}

impl Body {
    /// A body without group, at rest, its axes those of space.
    pub const fn new(shape: Shape, position: [f64; 3]) -> Body {
        Body {
            shape,
            position,
            orientation: None,
            axis: None,
            angle: None,
            fixed: false,
            velocity: None,
            angular_velocity: None,
            group: None,
            daughter_bonds: None,
            lineage: None,
        }
    }
}

/// Identity and ancestry of a body, as a run writes it into `final.json`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct BodyLineage {
    /// Unique over the run.
    pub id: u64,
    /// The id that divided into this one.
    pub parent: Option<u64>,
    /// Time of birth.
    pub birth: f64,
    /// Divisions since the founder.
    pub generation: u32,
    /// Length at birth, for an adder. Without it: the present length.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub birth_length: Option<f64>,
}

impl From<Lineage> for BodyLineage {
    fn from(line: Lineage) -> Self {
        let Lineage { id, parent, birth, generation, birth_length } = line;
        BodyLineage { id, parent, birth, generation, birth_length }
    }
}

impl From<BodyLineage> for Lineage {
    fn from(line: BodyLineage) -> Self {
        let BodyLineage { id, parent, birth, generation, birth_length } = line;
        Lineage { id, parent, birth, generation, birth_length }
    }
}

/// The measures that `output.measures` may name.
pub(crate) const MEASURES: [&str; 21] = [
    "nematic",
    "correlation",
    "radius",
    "packing",
    "density",
    "length",
    "contacts",
    "stress",
    "shear_stress",
    "force_chains",
    "friction",
    "walls",
    "fields",
    "bonds",
    "microdomains",
    "dissipation",
    "msd",
    "velocity_correlation",
    "groups",
    "segregation",
    "removal",
];

/// What to record, and how often.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields, default))]
#[non_exhaustive]
pub struct Output {
    /// Time between recorded states. Without it: a hundredth of the run.
    #[cfg_attr(feature = "files", schemars(extend("exclusiveMinimum" = 0)))]
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Option::is_none"))]
    pub every: Option<f64>,
    /// Steps between rows of `steps.csv`.
    #[cfg_attr(feature = "files", schemars(range(min = 1)))]
    pub step_stride: u64,
    /// Whether recorded states hold the contact forces, as the checkpoint does. Without them `relcp measure` computes
    /// stresses of the last state only.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "std::ops::Not::not"))]
    pub forces: bool,
    /// Whether the run draws a picture at its end, `final.png`.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "is_true"))]
    pub picture: bool,
    /// The measures of `relcp measure` to compute during the run: `measures.csv` has a row for each of `steps.csv`.
    /// Measures of more than one state stay empty. Each row costs as much as `relcp measure` for a state; on a GPU it
    /// reads the state back.
    #[cfg_attr(feature = "files", serde(skip_serializing_if = "Vec::is_empty"))]
    pub measures: Vec<String>,
}

#[cfg(feature = "files")]
fn is_true(value: &bool) -> bool {
    *value
}

impl Default for Output {
    fn default() -> Self {
        Output { every: None, step_stride: 1, forces: false, picture: true, measures: Vec::new() }
    }
}
