//! What steps are computed with.

use super::{ContactSettings, Time};
use crate::constraint::friction::Coefficients;
use crate::dynamics::{Bonds, Cells, Dynamics, Force, Heat, Strain, Stream};
use crate::fixed::Fixed;
use crate::lcp::{Settings, SolverKind};
use crate::periodic::Periods;
use crate::walls::Walls;

/// Everything that determines a step, beside the state that it begins in. [`Scene::model`](crate::Scene::model) makes
/// one.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The seed of all that is drawn.
    pub seed: u64,
    /// Whether bodies move in the x-y plane.
    pub planar: bool,
    /// Step size, duration and scheme.
    pub time: Time,
    /// The law of motion.
    pub dynamics: Dynamics,
    /// External forces.
    pub forces: Vec<Force>,
    /// The names of the groups that forces act on, by their number in [`Bodies::group`](crate::bodies::Bodies::group).
    pub groups: Vec<String>,
    /// Springs between bodies.
    pub bonds: Bonds,
    /// The random loads of Brownian motion, where there are any.
    pub heat: Option<Heat>,
    /// The background flow, where there is one.
    pub stream: Option<Stream>,
    /// The flow of a periodic cell whose lengths change, if they do.
    pub strain: Option<Strain>,
    /// The bodies that do not move.
    pub fixed: Fixed,
    /// The surfaces of walls.
    pub walls: Walls,
    /// The periods of space at the start.
    pub periods: Periods,
    /// Whether walls or periods leave bodies a limited space.
    pub confined: bool,
    /// How cells grow, where any do.
    pub cells: Option<Cells>,
    /// The least thickness that a body may have, where growth changes it.
    pub thinnest: Option<f64>,
    /// How contacts are resolved; `recursion` is not `Auto`.
    pub contact: ContactSettings,
    /// The friction of contacts.
    pub friction: Coefficients,
    /// The LCP solver.
    pub solver: SolverKind,
    /// When it stops.
    pub lcp: Settings,
}
