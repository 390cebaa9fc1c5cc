//! Changes of a simulation's state between two steps: values of bodies, bodies that come and go.
//!
//! A [`Change`] is a list of edits. [`Simulation::change`] applies all of them or none. Multipliers of the last step
//! stay with the pairs of bodies that were neither moved, turned nor lengthened; those of all others are dropped, and
//! the next step solves for them from zero. Overlaps that a change makes are handled as those of a scene's start: the
//! next step parts the bodies, under the inertial law before time goes on.

mod apply;
mod error;
mod limits;
mod rules;
mod share;
#[cfg(feature = "files")]
#[cfg(test)]
mod tests;

pub use error::ChangeError;
pub use rules::{Cell, CellState, CellValues, Rules};

use super::initial_region::InitialRegion;
use super::leaving::{Leaving, taken_out};
use super::{Simulation, parts_first};
use crate::bodies::Bodies;
use crate::scene::Body;
use crate::step::{Fault, Plan, State};
use apply::Applied;
use glam::{DQuat, DVec3};
pub(super) use limits::Limits;
use share::Share;
use std::collections::HashMap;

/// Some bodies of a simulation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Which {
    /// All, in their order.
    All,
    /// Those with these indices, each once.
    Indices(Vec<usize>),
    /// Those with these ids, each once. Ids stay with bodies when others leave.
    Ids(Vec<u64>),
}

/// New values of one quantity, one for each of the chosen bodies.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Values {
    /// Centres.
    Position(Vec<DVec3>),
    /// Rotations from body axes to space, of any norm but zero; they are normalized.
    Orientation(Vec<DQuat>),
    /// Velocities, under the inertial law.
    Velocity(Vec<DVec3>),
    /// Angular velocities in space axes, under the inertial law.
    AngularVelocity(Vec<DVec3>),
    /// Tip-to-tip lengths of spherocylinders and of ellipsoids that grow.
    Length(Vec<f64>),
    /// Relative growth rates without pressure, of cells that grow, in place of their species'.
    Rate(Vec<f64>),
    /// Tip-to-tip lengths at which cells that grow divide, in place of the rule of their species. A cell divides at the
    /// start of the first step that it begins with this length, as soon as its halves are not shorter than thick;
    /// infinite: never.
    DivisionLength(Vec<f64>),
    /// Indices into the scene's group names, or [`NO_GROUP`](crate::bodies::NO_GROUP).
    Group(Vec<u32>),
    /// A named column of numbers that the simulation keeps for its user: daughters inherit those of their mother,
    /// states hold them. A new column is zero for all other bodies.
    Column(String, Vec<f64>),
}

impl Values {
    /// The name of the quantity.
    fn name(&self) -> &str {
        match self {
            Values::Position(_) => "position",
            Values::Orientation(_) => "orientation",
            Values::Velocity(_) => "velocity",
            Values::AngularVelocity(_) => "angular_velocity",
            Values::Length(_) => "length",
            Values::Rate(_) => "rate",
            Values::DivisionLength(_) => "division_length",
            Values::Group(_) => "group",
            Values::Column(name, _) => name,
        }
    }

    fn len(&self) -> usize {
        match self {
            Values::Position(of) | Values::Velocity(of) | Values::AngularVelocity(of) => of.len(),
            Values::Orientation(of) => of.len(),
            Values::Length(of) | Values::Rate(of) | Values::DivisionLength(of) | Values::Column(_, of) => of.len(),
            Values::Group(of) => of.len(),
        }
    }
}

#[derive(Clone, Debug)]
enum Edit {
    Set(Which, Values),
    Add(Vec<Body>),
    Remove(Which),
    Share(Share),
}

/// What changes of a simulation's state, in order: indices are those after the edits before.
///
/// ```
/// use relcp::simulation::{Change, Values, Which};
/// use relcp::{Simulation, glam::DVec3};
/// # #[cfg(feature = "files")] {
/// let mut simulation = Simulation::new(relcp::Scene::built_in("three-capsules")?)?;
/// let up = simulation.state()?.bodies.position[0] + DVec3::new(0.0, 0.1, 0.0);
/// simulation.change(&Change::new().set(Which::Indices(vec![0]), Values::Position(vec![up])))?;
/// assert_eq!(simulation.state()?.bodies.position[0], up);
/// simulation.change(&Change::new().remove_bodies(Which::Ids(vec![2])))?;
/// assert_eq!(simulation.bodies(), 2);
/// simulation.step()?;
/// # }
/// # Ok::<(), relcp::Error>(())
/// ```
#[must_use = "a change does nothing before `Simulation::change`"]
#[derive(Clone, Debug, Default)]
pub struct Change {
    edits: Vec<Edit>,
}

impl Change {
    /// No change.
    pub fn new() -> Self {
        Change::default()
    }

    /// Gives bodies new values.
    pub fn set(mut self, which: Which, values: Values) -> Self {
        self.edits.push(Edit::Set(which, values));
        self
    }

    /// Adds bodies after all others, founders that are born now, in groups of the scene.
    pub fn add_bodies(mut self, bodies: Vec<Body>) -> Self {
        self.edits.push(Edit::Add(bodies));
        self
    }

    /// Removes bodies. Bonds that they had are gone.
    pub fn remove_bodies(mut self, which: Which) -> Self {
        self.edits.push(Edit::Remove(which));
        self
    }
}

impl Change {
    fn share(mut self, share: Share) -> Self {
        self.edits.push(Edit::Share(share));
        self
    }
}

impl Which {
    /// Their indices.
    fn indices(&self, bodies: &Bodies) -> Result<Vec<usize>, ChangeError> {
        let count = bodies.len();
        let chosen = match self {
            Which::All => return Ok((0..count).collect()),
            Which::Indices(indices) => {
                if let Some(wrong) = indices.iter().find(|i| **i >= count) {
                    return Err(ChangeError::Which(format!("index {wrong}: there are {count} bodies, from 0")));
                }
                indices.clone()
            }
            Which::Ids(ids) => {
                let places: HashMap<u64, usize> = bodies.lineage.iter().map(|line| line.id).zip(0..).collect();
                let place = |id: &u64| {
                    let place = places.get(id).copied();
                    place.ok_or_else(|| ChangeError::Which(format!("id {id}: no body has it now")))
                };
                ids.iter().map(place).collect::<Result<_, _>>()?
            }
        };
        let mut seen = vec![false; count];
        match chosen.iter().find(|i| std::mem::replace(&mut seen[**i], true)) {
            Some(twice) => Err(ChangeError::Which(format!("body {twice} is named twice"))),
            None => Ok(chosen),
        }
    }
}

impl Simulation {
    /// Changes the state between two steps: all edits or, after an error, none. Returns the ids of added bodies.
    ///
    /// Values are checked as those of a scene: numbers finite, lengths allowed, bodies inside of all walls and in the
    /// plane of a planar scene. Writing the value that is there changes nothing, to the last bit. On a device the state
    /// is read back and written.
    ///
    /// A saved state holds the change, and a simulation that resumes it goes on to the same bits. The scene does not:
    /// another run of it does not repeat the change.
    ///
    /// # Errors
    /// [`ChangeError`] names the quantity, the row and the body.
    pub fn change(&mut self, change: &Change) -> Result<Vec<u64>, ChangeError> {
        if self.compute.is_shared() {
            return Err(Fault::Processes("the state of several processes cannot be changed".into()).into());
        }
        let applied = self.applied(change)?;
        let added = applied.added.clone();
        self.install(applied)?;
        Ok(added)
    }

    /// The state after a change.
    fn applied(&mut self, change: &Change) -> Result<Applied, ChangeError> {
        let limits = self.limits.get_or_insert_with(|| Box::new(Limits::of(&self.scene)));
        let state = self.backend.state()?;
        limits.apply(&self.scene, state, change)
    }

    /// Goes on from a changed state.
    fn install(&mut self, applied: Applied) -> Result<(), Fault> {
        let Applied { state, placed, counted, lengthened, differs, .. } = applied;
        if !differs {
            return Ok(());
        }
        if counted {
            let (step, time) = (self.steps() + 1, self.time());
            let gone = taken_out(&self.backend.state()?.bodies, &state.bodies, step, time);
            self.taken_out.extend(gone);
        }
        if counted || (lengthened && self.device().is_some()) {
            self.rebuild(&state)?;
        } else {
            self.backend.restore(&state)?;
        }
        self.plan.parts_first = parts_first(&self.scene, &self.scene.model(), &self.plan, &state);
        if placed || counted {
            self.region = InitialRegion::of(&state.bodies);
        }
        self.leaving = Leaving::of(&self.scene, self.backend.as_ref(), state.removed.iter().sum())?;
        self.stopped_by = None;
        self.check_stop()
    }

    /// A new backend, as other bodies may need other kernels and another cutoff.
    fn rebuild(&mut self, state: &State) -> Result<(), Fault> {
        let cutoff = self.scene.cutoff_of(state.bodies.shape.iter().copied());
        let mut backend = self.compute.backend(&self.scene, state.clone())?;
        self.backend.take_forces().into_iter().for_each(|force| backend.add_force(force));
        self.backend = backend;
        self.plan = Plan::new(&self.scene.model(), cutoff);
        Ok(())
    }
}
