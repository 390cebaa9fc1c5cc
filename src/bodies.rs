//! The state of all bodies, one array a quantity: the configuration `C^k` of the method.

mod columns;
mod held;

pub use columns::{Columns, OwnGrowth};
pub use held::HeldBond;
pub(crate) use held::sorted_pairs;

use crate::motion::{Pose, Twist};
use crate::periodic::Periods;
use crate::separation::{Placed, farthest};
use crate::shape::Shape;
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::borrow::Cow;

/// Where a body comes from: enough to rebuild the lineage of a colony.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lineage {
    /// Unique over a whole run; a division ends one id and begins two.
    pub id: u64,
    /// The id that divided into this one.
    pub parent: Option<u64>,
    /// Time of birth.
    pub birth: f64,
    /// Divisions since the founder.
    pub generation: u32,
    /// Its length at birth, if its division rule needs it.
    pub birth_length: Option<f64>,
}

/// Flags in the word of a generation: the body has a parent, or a length at birth.
const PARENT: u64 = 1 << 32;
const LENGTH: u64 = 1 << 33;

impl Lineage {
    /// Packs it into words, for other processes.
    pub(crate) fn words(&self) -> [u64; 5] {
        let Lineage { id, parent, birth, generation, birth_length } = *self;
        let flag = |is: bool, flag: u64| if is { flag } else { 0 };
        let flags = flag(parent.is_some(), PARENT) | flag(birth_length.is_some(), LENGTH);
        let length = birth_length.unwrap_or(0.0).to_bits();
        [id, parent.unwrap_or(0), birth.to_bits(), u64::from(generation) | flags, length]
    }

    /// Unpacks it from words.
    pub(crate) fn of_words([id, parent, birth, generation, length]: [u64; 5]) -> Lineage {
        Lineage {
            id,
            parent: (generation & PARENT > 0).then_some(parent),
            birth: f64::from_bits(birth),
            generation: generation as u32,
            birth_length: (generation & LENGTH > 0).then(|| f64::from_bits(length)),
        }
    }
}

/// All bodies of a simulation, and the space that they are in. Arrays but those of bonds are indexed by body
/// and have the same length.
#[derive(Debug, Default, PartialEq)]
pub struct Bodies {
    /// Shapes, as they are now (a growing body's length changes).
    pub shape: Vec<Shape>,
    /// Centres; in periodic space as they went, not wrapped into a cell.
    pub position: Vec<DVec3>,
    /// Unit quaternions taking body axes to space.
    pub orientation: Vec<DQuat>,
    /// Linear velocities; the state of the inertial law, and the last step's outcome in the overdamped one.
    pub velocity: Vec<DVec3>,
    /// Angular velocities in space axes; as `velocity`.
    pub angular_velocity: Vec<DVec3>,
    /// Index into the scene's group names; `u32::MAX` if a body has none.
    pub group: Vec<u32>,
    /// Identity and ancestry.
    pub lineage: Vec<Lineage>,
    /// What single bodies have beside what their scene gives them.
    pub columns: Columns,
    /// The indices in the scene of broken bonds, ascending.
    pub broken_bonds: Vec<u32>,
    /// The bonds and joints that hold, by number, with what they do; empty on a process that has a part of the bodies.
    pub bonds: Vec<HeldBond>,
    /// Where walls under a load are, in order; empty without any.
    pub walls: Vec<WallState>,
    /// The periods of the space that they are in. Positions are not wrapped.
    pub periods: Periods,
    /// Whether they cannot leave the plane: then they are measured in it.
    pub planar: bool,
}

/// Where a wall under a load is: how far it has gone along its normal, and its velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct WallState {
    /// The way from where the scene has it.
    pub shift: f64,
    /// The velocity of the last step.
    pub velocity: f64,
}

/// Keeps the flagged entries of an array, in order.
pub(crate) fn kept<T>(array: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    array.retain(|_| flags.next().copied().unwrap_or(true));
}

/// The value of [`Bodies::group`] of a body that belongs to no group.
pub const NO_GROUP: u32 = u32::MAX;

impl Bodies {
    /// No bodies, with what belongs to none of these: the space that they are in, and the bonds that are broken.
    #[cfg(feature = "mpi")]
    pub(crate) fn none_like(&self) -> Bodies {
        Bodies {
            broken_bonds: self.broken_bonds.clone(),
            periods: self.periods,
            planar: self.planar,
            ..Bodies::default()
        }
    }

    /// How many bodies there are.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Adds a body at rest, the founder of a lineage, and returns its index.
    pub fn push(&mut self, placed: Placed, group: u32) -> usize {
        let index = self.len();
        self.shape.push(placed.shape);
        self.position.push(placed.position);
        self.orientation.push(placed.orientation);
        self.velocity.push(DVec3::ZERO);
        self.angular_velocity.push(DVec3::ZERO);
        self.group.push(group);
        self.lineage.push(Lineage { id: index as u64, parent: None, birth: 0.0, generation: 0, birth_length: None });
        self.columns.push();
        index
    }

    /// Adds to the broken bonds.
    pub(crate) fn add_broken_bonds(&mut self, found: Vec<u32>) {
        if !found.is_empty() {
            self.broken_bonds.extend(found);
            self.broken_bonds.sort_unstable();
        }
    }

    /// Keeps the flagged bodies, in order.
    pub fn retain(&mut self, keep: &[bool]) {
        kept(&mut self.shape, keep);
        kept(&mut self.position, keep);
        kept(&mut self.orientation, keep);
        kept(&mut self.velocity, keep);
        kept(&mut self.angular_velocity, keep);
        kept(&mut self.group, keep);
        kept(&mut self.lineage, keep);
        self.columns.retain(keep);
        self.retain_bonds(keep);
    }

    /// The first body with a custom shape, which files and devices do not support.
    pub fn first_custom(&self) -> Option<usize> {
        self.shape.iter().position(|shape| matches!(shape, Shape::Convex(_)))
    }

    /// Body `i`'s velocity.
    pub fn twist(&self, i: usize) -> Twist {
        Twist { linear: self.velocity[i], angular: self.angular_velocity[i] }
    }

    /// Two bodies as their separation is computed from: b at its image nearest to a. Only the difference of the two
    /// positions has a meaning.
    pub fn pair(&self, a: usize, b: usize) -> [Placed; 2] {
        self.periods.pair(self.placed(a), self.placed(b))
    }

    /// These bodies with each centre at its image in the cell about the origin ([`Periods::wrapped`]): for pictures,
    /// not for simulation.
    pub fn wrapped(&self) -> Cow<'_, Bodies> {
        if self.periods.is_none() {
            return Cow::Borrowed(self);
        }
        let mut wrapped = self.clone();
        wrapped.position.iter_mut().for_each(|x| *x = self.periods.wrapped(*x).0);
        Cow::Owned(wrapped)
    }

    /// The mean of the centres; the origin where there is no body.
    pub fn centre(&self) -> DVec3 {
        self.position.iter().sum::<DVec3>() / self.len().max(1) as f64
    }

    /// The distance of the farthest point of a body from a point.
    pub fn outermost_from(&self, centre: DVec3) -> f64 {
        let distance = |i: usize| self.position[i].distance(centre);
        let reach = |i: usize| farthest(&self.shape[i], self.position[i], self.orientation[i], centre);
        let far = (0..self.len()).map(distance).fold(0.0, f64::max);
        // A body whose ball does not come up to the farthest centre cannot decide.
        (0..self.len())
            .into_par_iter()
            .filter(|&i| distance(i) + self.shape[i].bounding_radius() >= far)
            .map(reach)
            .reduce(|| 0.0, f64::max)
    }

    /// The distance of the farthest point of a body from the mean of the centres: the radius of a colony.
    pub fn radius(&self) -> f64 {
        self.outermost_from(self.centre())
    }

    /// Where body `i` is.
    pub(crate) fn pose(&self, i: usize) -> Pose {
        Pose { position: self.position[i], orientation: self.orientation[i] }
    }

    /// Body `i`'s shape at its pose.
    pub fn placed(&self, i: usize) -> Placed {
        Placed { shape: self.shape[i], position: self.position[i], orientation: self.orientation[i] }
    }
}

impl Clone for Bodies {
    fn clone(&self) -> Self {
        let mut copy = Bodies::default();
        copy.clone_from(self);
        copy
    }

    /// Copies into existing memory: a step does this once.
    fn clone_from(&mut self, from: &Self) {
        self.shape.clone_from(&from.shape);
        self.position.clone_from(&from.position);
        self.orientation.clone_from(&from.orientation);
        self.velocity.clone_from(&from.velocity);
        self.angular_velocity.clone_from(&from.angular_velocity);
        self.group.clone_from(&from.group);
        self.lineage.clone_from(&from.lineage);
        self.columns.clone_from(&from.columns);
        self.broken_bonds.clone_from(&from.broken_bonds);
        self.bonds.clone_from(&from.bonds);
        self.walls.clone_from(&from.walls);
        self.periods = from.periods;
        self.planar = from.planar;
    }
}
