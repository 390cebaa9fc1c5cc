//! A scene: everything that determines a run, as it stands in a scene file (JSON).
//!
//! The types below are the file's reference: the reader, the JSON Schema and the echoed `scene.json` are made from them.
//! Variants are externally tagged (`{"ellipsoid": {...}}`) and unknown keys are refused.

mod build;
mod built_in;
mod dump;
mod error;
mod generate;
mod growth;
mod key;
mod nearest;
mod orientation;
mod periodic;
mod place;
mod read;
mod reference;
mod set;
mod settings;
mod translate;
mod tree;
mod validate;
mod wall;
mod write;

pub use built_in::{BuiltIn, built_in};
pub use dump::{Dump, DumpWhen};
pub use error::{FaultKind, SceneError};
pub use growth::{Growth, OnNoRoom, Stop, StopReason};
pub use periodic::Periodic;
pub(crate) use read::Source;
pub use read::{MAX_FILE_BYTES, load, parse, read};
pub use reference::reference;
pub(crate) use set::Override;
pub use validate::{LARGEST_NUMBER, MAX_BODIES, MAX_STATES, MAX_STEPS, SMALLEST_NUMBER, SMALLEST_QUATERNION};
pub use wall::Wall;
pub use write::schema;

use crate::shape::Shape;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Everything that determines a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// A name for people; it stands in the summary and names the run's folder.
    pub name: String,
    /// Everything random is drawn from this.
    #[serde(default)]
    pub seed: u64,
    /// The law of motion.
    #[serde(default)]
    pub dynamics: Dynamics,
    /// Step size and duration.
    pub time: Time,
    /// How contacts are resolved, and how well.
    #[serde(default)]
    pub contact: Contact,
    /// The LCP solver.
    #[serde(default)]
    pub solver: Solver,
    /// Bodies move in the x-y plane and turn about z; no other unknowns are carried.
    #[serde(default)]
    pub planar: bool,
    /// External forces.
    #[serde(default)]
    pub forces: Vec<Force>,
    /// Fixed walls that bodies do not pass, and inside of which they start; one with a `lineage`, which a run wrote, may start past a wall.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<Wall>,
    /// Periods of space: bodies that leave through one side meet what is at the other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub periodic: Option<Periodic>,
    /// Growth and division of spherocylinders.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub growth: Option<Growth>,
    /// Bodies placed one by one.
    #[serde(default)]
    pub bodies: Vec<Body>,
    /// Bodies placed by rule, after `bodies`, drawn from `seed`, inside of all walls.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub generate: Vec<Generate>,
    /// What is recorded, and how often.
    #[serde(default)]
    pub output: Output,
}

/// The law of motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Dynamics {
    /// Inertia is negligible: `u = F / (drag L)`, `w = 12 T / (drag L^3)` with `L` the major axis length.
    Overdamped {
        /// Drag coefficient `xi`.
        #[schemars(extend("exclusiveMinimum" = 0))]
        drag: f64,
    },
    /// Newton's and Euler's equations with inelastic contact.
    Inertial {
        /// Mass per volume of every body.
        #[schemars(extend("exclusiveMinimum" = 0))]
        density: f64,
    },
}

impl Default for Dynamics {
    fn default() -> Self {
        Dynamics::Overdamped { drag: 1.0 }
    }
}

/// Step size and duration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// Step size.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub dt: f64,
    /// Time at which the run ends.
    pub end: f64,
    /// Time at which the run starts.
    #[serde(default)]
    pub start: f64,
    /// The stepping scheme.
    #[serde(default)]
    pub stepping: Stepping,
}

impl Time {
    /// How many steps the run takes. A last interval shorter than a millionth of `dt` is rounding, not a step.
    pub fn steps(&self) -> u64 {
        (((self.end - self.start) / self.dt) - 1e-6).ceil().max(0.0) as u64
    }

    /// The time after `step` steps.
    pub fn after(&self, step: u64) -> f64 {
        self.start + step as f64 * self.dt
    }
}

/// The stepping scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stepping {
    /// The first-order step of the paper.
    #[default]
    Euler,
    /// Second order: forces, mobilities and first rows are taken at the middle of the step, which half a step leads to. It costs about
    /// twice as much a step. Where bodies have inertia, contact falls to first order.
    Midpoint,
}

/// How contacts are resolved, and how well.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Contact {
    /// Which rows are made, and whether the recursion runs.
    pub method: Method,
    /// Largest overlap of smooth surfaces that an accepted step may leave, a length.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub overlap_tolerance: f64,
    /// Most recursions of one step.
    #[schemars(range(min = 1))]
    pub max_recursions: u32,
    /// How tightly the solves before a step's last one are made.
    #[schemars(extend("default" = "auto"))]
    #[serde(skip_serializing_if = "Recursion::is_default")]
    pub recursion: Recursion,
    /// How first rows are made and violations answered.
    #[schemars(extend("default" = "auto"))]
    #[serde(skip_serializing_if = "Rows::is_default")]
    pub rows: Rows,
    /// What follows a step of the method `relcp` that still misses a tolerance after it was cut into 64 pieces.
    #[schemars(extend("default" = "stop"))]
    #[serde(skip_serializing_if = "OnFailure::is_default")]
    pub on_failure: OnFailure,
    /// Pairs nearer than this at a step's start get a row (beside those that the free motion may bring into contact), a length.
    /// Without it: a tenth of the thinnest body's thickness.
    #[schemars(range(min = 0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutoff: Option<f64>,
}

impl Default for Contact {
    fn default() -> Self {
        let (method, recursion) = (Method::default(), Recursion::default());
        Contact {
            method,
            overlap_tolerance: 1e-5,
            max_recursions: 64,
            recursion,
            rows: Rows::default(),
            on_failure: OnFailure::default(),
            cutoff: None,
        }
    }
}

/// How the rows of smooth surfaces are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rows {
    /// One row for each smooth branch of a pair's separation that may become active in the step, linearised where the last velocities lead. A
    /// violation first moves its own row.
    #[default]
    Auto,
    /// The paper's: one row a pair, linearised at the step's start. Each violation appends one.
    Paper,
}

impl Rows {
    fn is_default(&self) -> bool {
        *self == Rows::default()
    }
}

/// What follows a step that cannot be taken within its tolerances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnFailure {
    /// The run ends with the state before the step, and says why.
    #[default]
    Stop,
    /// The least bad of what was tried is accepted and counted: overlaps are spread over all contacts, and no body is thrown.
    Continue,
}

impl OnFailure {
    fn is_default(&self) -> bool {
        *self == OnFailure::default()
    }
}

/// How tightly the solves before a step's last one are made. The last one always meets `solver.tolerance`, and no step ends with
/// an overlap above `overlap_tolerance` either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Recursion {
    /// Inexact in space, where packed bodies recurse several times a step; exact in the plane, with the paper's rows, in midpoint steps, and where
    /// `solver.tolerance` is given.
    #[default]
    Auto,
    /// As the last one: the trials, and so the rows made there, are those of exact solutions.
    Exact,
    /// Only as tight as the overlaps seen warrant: a fifth to two fifths fewer iterations in crowded scenes. Rows are then made at trials that are a
    /// little off, and depend a little on the solver. Midpoint steps stay exact.
    Inexact,
}

impl Recursion {
    fn is_default(&self) -> bool {
        *self == Recursion::default()
    }
}

/// Which rows a step makes, and whether it recurs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Method {
    /// One row a near pair of smooth surfaces, more where the trial still overlaps.
    #[default]
    Relcp,
    /// One row a near pair of smooth surfaces, no recursion.
    Snsd,
    /// One row a near pair of sub-spheres, no recursion.
    Multisphere {
        /// Spheres a body: odd on a major axis; on a ring, enough to leave no gap.
        #[schemars(range(min = 1))]
        count: u32,
    },
}

/// The LCP solver and when it stops.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Solver {
    /// Which solver.
    pub kind: SolverKind,
    /// Largest natural residual that counts as solved, a length. Without it: a tenth of the overlap tolerance.
    #[schemars(extend("exclusiveMinimum" = 0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Most iterations of one solve. Without it: 100,000.
    #[schemars(range(min = 1))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_iterations: Option<u64>,
    /// Which LCPs are saved into the run's folder `lcps`. Without it: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dump: Option<Dump>,
}

/// The LCP solvers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SolverKind {
    /// The program's choice: `pair_block_cg`. Where it ends without reaching the tolerance, `interior_point` goes on; not on a GPU.
    #[default]
    Auto,
    /// Projected Jacobi with a safe step.
    ProjectedJacobi,
    /// Projected Gauss-Seidel, sequential.
    ProjectedGaussSeidel,
    /// Accelerated projected gradient descent with restart.
    Apgd,
    /// Projected gradient descent with safeguarded Barzilai-Borwein steps.
    Bbpgd,
    /// Projected nonlinear conjugate gradients, preconditioned by the blocks of the pairs.
    PairBlockCg,
    /// Dense pivoting, for tests and small systems.
    Dense,
    /// Primal-dual interior point with a sparse factorization: few iterations, whatever the conditioning. Not on a GPU.
    InteriorPoint,
}

impl SolverKind {
    /// The one that public codes for contacts of rigid bodies solve their LCPs with: what measurements set the default beside.
    pub(crate) const OF_PUBLIC_CODES: SolverKind = SolverKind::Bbpgd;

    /// All solvers that a scene may name but `auto`, which is one of them, with their names there. They are those of the schema, so
    /// that a new one is among them.
    ///
    /// ```
    /// # use relcp::scene::SolverKind;
    /// assert!(SolverKind::named().contains(&("bbpgd".into(), SolverKind::Bbpgd)));
    /// ```
    pub fn named() -> Vec<(String, SolverKind)> {
        let schema = schemars::schema_for!(SolverKind).to_value();
        let variants = schema["oneOf"].as_array().map(Vec::as_slice).unwrap_or_default();
        let names = variants.iter().filter_map(|variant| variant["const"].as_str());
        names
            .filter_map(|name| Some((name.to_owned(), serde_json::from_value(name.into()).ok()?)))
            .filter(|(_, kind)| *kind != SolverKind::Auto)
            .collect()
    }
}

/// An external force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Force {
    /// The same force on every body.
    Uniform {
        /// The force.
        force: [f64; 3],
        /// Only bodies of this group.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        group: Option<String>,
    },
    /// Weight: the body's mass times an acceleration. It needs the inertial law, where bodies have mass.
    Gravity {
        /// The acceleration.
        acceleration: [f64; 3],
        /// Only bodies of this group.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        group: Option<String>,
    },
    /// `F(x) = -x (|x| - sin |x|) / |x|^2`: the paper's compaction.
    RadialInward {
        /// Only bodies of this group.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        group: Option<String>,
    },
    /// `F(x) = +x (|x| - sin |x|) / |x|^2`: the paper's chainmail.
    RadialOutward {
        /// Only bodies of this group.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        group: Option<String>,
    },
}

/// One body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Its shape.
    pub shape: Shape,
    /// Its centre.
    pub position: [f64; 3],
    /// `[w, x, y, z]`, body axes to space; normalized on reading.
    #[serde(default = "identity")]
    pub orientation: [f64; 4],
    /// Velocity, under the inertial law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
    /// Angular velocity in space axes, under the inertial law.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_velocity: Option<[f64; 3]>,
    /// The group it belongs to, for forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Identity and ancestry; given all together or not at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lineage: Option<BodyLineage>,
}

/// Identity and ancestry of a body, as a run writes it into `final.json`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyLineage {
    /// Unique over the run.
    pub id: u64,
    /// The id that divided into this one.
    pub parent: Option<u64>,
    /// Time of birth.
    pub birth: f64,
    /// Divisions since the founder.
    pub generation: u32,
}

fn identity() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

/// Bodies placed by rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Generate {
    /// `count` bodies at random positions and isotropic random orientations, without overlap, in a cube centred on the origin
    /// whose volume is theirs over `volume_fraction`. Centres are in the cube; the bodies' ends may stick out. Each body keeps clear of the
    /// bounding capsules of all earlier ones, so rings do not interlock by chance. In a planar scene spheres only, in the square of z = 0
    /// whose area is that of their discs over `volume_fraction`. In a periodic scene centres are spread over the whole period along each periodic axis, and
    /// bodies keep clear of images too; where all axes are periodic, `volume_fraction` is what `count` bodies are of the cell.
    Isotropic {
        /// How many.
        #[schemars(range(min = 1))]
        count: u64,
        /// Their shape.
        shape: Shape,
        /// Their volume over the cube's; at most what random placement reaches, which depends on the shape (0.32 for spheres).
        #[schemars(extend("exclusiveMinimum" = 0))]
        volume_fraction: f64,
        /// Their group.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        group: Option<String>,
    },
    /// A sheet of interlaced rings on a square lattice in the x-y plane, centred on the origin, without overlap: the lattice's spacing is 1.6
    /// major radii, and each ring is linked with its four neighbours. The minor radius is at most 0.12 of the major radius.
    Chainmail {
        /// Rings along x.
        #[schemars(range(min = 1))]
        columns: u64,
        /// Rings along y.
        #[schemars(range(min = 1))]
        rows: u64,
        /// Radius of each ring's centreline.
        #[schemars(extend("exclusiveMinimum" = 0))]
        major_radius: f64,
        /// Radius of each ring's tube.
        #[schemars(extend("exclusiveMinimum" = 0))]
        minor_radius: f64,
        /// Their group.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        group: Option<String>,
    },
    /// One cell at the origin, its axis along x.
    Founder {
        /// Its diameter.
        #[schemars(extend("exclusiveMinimum" = 0))]
        diameter: f64,
        /// Its tip-to-tip length.
        #[schemars(extend("exclusiveMinimum" = 0))]
        length: f64,
        /// Its group.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        group: Option<String>,
    },
}

/// What is recorded, and how often.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Time between recorded states. Without it: a hundredth of the run.
    #[schemars(extend("exclusiveMinimum" = 0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every: Option<f64>,
    /// Steps between rows of `steps.csv`.
    #[schemars(range(min = 1))]
    pub step_stride: u64,
    /// Whether recorded states hold the contact forces, as the checkpoint does. Without them `relcp measure` tells stresses of the last state only.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub forces: bool,
    /// What of `relcp measure` is measured while it runs, by its names: `measures.csv` has a row for each of `steps.csv`. What takes more than one
    /// state is left empty there. Each row costs what `relcp measure` takes for a state, and on a GPU the state is read back for it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<String>,
}

impl Default for Output {
    fn default() -> Self {
        Output { every: None, step_stride: 1, forces: false, measures: Vec::new() }
    }
}
