//! Growth and division: prescribed motion, done at a step's start.
//!
//! Every cell at its division length divides into two of half its actual length that lie in it, tip to tip, each turned
//! by a small random angle; then every cell takes its end-of-step length `length e^(rate dt)`. The step's separations,
//! mobilities and trials all use that length. Against extrapolating `Phi + dt dPhi/dlength length'` from the old one,
//! this is equal to first order and exact in the length; and every accepted state has been through a solve with the
//! lengths and bodies that it holds.
//!
//! A scene has one species or several, each the bodies of a group with settings of its own ([`Cells`]). Three rules say
//! when a cell divides ([`DivisionRule`]): at a length, at a length added since its birth, at a time since its birth.
//! Their distributions of lengths: A. Amir, Phys. Rev. Lett. 112, 208102 (2014); S. Taheri-Araghi et al., Curr. Biol.
//! 25, 385 (2015).
//!
//! A cell's rate may differ from the mean by a draw of its own, and fall with the pressure on it as `e^(-lambda
//! pressure)`, the law of S. Weady, B. Palmer, A. Lamson, T. Kim, R. Farhadifar, M. J. Shelley (arXiv:2405.10158) with
//! [another stress](crate::dynamics::pressures) than theirs; and it may follow the concentration of a
//! [field](crate::fields) at the cell.

mod bounds;
mod cells;
#[cfg(feature = "files")]
pub(crate) mod one_or_list;
mod settings;

#[cfg(feature = "gpu")]
pub(crate) use cells::Due;
pub use cells::{Cells, Species};
pub(crate) use settings::MOST_LENGTH_NOISE;
pub use settings::{DivisionRule, GrowingShape, Growth, OnNoRoom, Stop, StopReason};

use crate::bodies::{Bodies, Lineage};
use crate::dynamics::Waiting;
use crate::dynamics::bonds::daughters::join;
use crate::separation::Placed;
use crate::shape::Shape;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A loop over fewer cells than this runs on one thread.
const LEAST_CELLS_A_TASK: usize = 512;

impl Cells {
    /// Divides and grows all cells over the step of `dt` that begins at `time`. `next_id` is the id of the next cell
    /// born; `slowing` is [that](Cells::slowing) of the bodies before, to which daughters are added with their
    /// mother's. Cells that wait neither divide nor grow.
    pub fn grow(
        &self,
        bodies: &mut Bodies,
        (time, dt): (f64, f64),
        next_id: &mut u64,
        slowing: &mut Vec<f64>,
        waiting: &Waiting,
    ) {
        self.divide(bodies, (time, 1.0), next_id, slowing, waiting);
        self.lengthen(bodies, dt, slowing, waiting);
    }

    /// Divides the cells that are due at `time`, and names them, ascending. Each leaves her place to one daughter;
    /// the others are added in the order of their mothers. Daughters turn by the part `turn` of what they draw.
    pub fn divide(
        &self,
        bodies: &mut Bodies,
        (time, turn): (f64, f64),
        next_id: &mut u64,
        slowing: &mut Vec<f64>,
        waiting: &Waiting,
    ) -> Vec<usize> {
        let due = |i: &usize| {
            let (shape, line) = (&bodies.shape[*i], &bodies.lineage[*i]);
            let Some((species, length)) = self.of_body(bodies.group[*i], shape) else { return false };
            species.due(line, shape, bodies.columns.growth(*i)).reached(length, time) && !waiting.holds(line.id)
        };
        let due: Vec<usize> = (0..bodies.len()).into_par_iter().with_min_len(LEAST_CELLS_A_TASK).filter(due).collect();
        let divides = |mother: &usize| {
            let before = bodies.len();
            divide(bodies, *mother, self, (time, turn), next_id);
            if let Some(own) = slowing.get(*mother).copied() {
                slowing.resize(slowing.len() + bodies.len() - before, own);
            }
            bodies.len() > before
        };
        due.into_iter().filter(divides).collect()
    }

    /// Grows all cells over `dt` but those that wait; none divides.
    pub fn lengthen(&self, bodies: &mut Bodies, dt: f64, slowing: &[f64], waiting: &Waiting) {
        let columns = &bodies.columns;
        let lengthen = |(i, ((shape, line), group)): (usize, ((&mut Shape, &Lineage), &u32))| {
            let own = self.of_body(*group, shape).filter(|_| !waiting.holds(line.id));
            let Some((species, length)) = own else { return };
            let rate = species.rate_of(line.id, columns.growth(i), slowing.get(i).copied().unwrap_or(0.0));
            if let Some(grown) = shape.grown(length * (rate * dt).exp()) {
                *shape = grown;
            }
        };
        let shapes = bodies.shape.par_iter_mut().zip(&bodies.lineage).zip(&bodies.group).enumerate();
        shapes.with_min_len(LEAST_CELLS_A_TASK).for_each(lengthen);
    }
}

/// As [`Cells::grow`], of cells that are not pressed and all of one species.
pub fn grow(bodies: &mut Bodies, growth: &Growth, planar: bool, seed: u64, time: f64, dt: f64, next_id: &mut u64) {
    let cells = Cells::new(&[Growth { group: None, ..growth.clone() }], &[], planar, seed);
    cells.settle(bodies);
    cells.grow(bodies, (time, dt), next_id, &mut Vec::new(), &Waiting::None);
}

/// How far the surface of `placed` moves where `lever` touches it with the outward normal `normal`, as the body grows
/// to the shape `to`.
///
/// Between its middle and a tip a point of a rod's axis moves in proportion to its place. As the separation is an
/// extremum over all points of the axis, this displacement along the normal is the exact derivative of the separation
/// with respect to the length. A point of an ellipsoid moves along each axis in proportion to its place.
pub fn stretch(placed: &Placed, to: &Shape, lever: DVec3, normal: DVec3) -> DVec3 {
    if let (Shape::Ellipsoid { radii }, Shape::Ellipsoid { radii: grown }) = (placed.shape, *to) {
        let growth = DVec3::from_array(grown) / DVec3::from_array(radii) - 1.0;
        return placed.orientation * (growth * (placed.orientation.inverse() * lever));
    }
    let (Some(length), Some(grown)) = (placed.shape.growing_length(), to.growing_length()) else { return DVec3::ZERO };
    let axis = placed.orientation * DVec3::Z;
    let half = 0.5 * (length - placed.shape.thickness());
    // A cell as long as it is thick has its whole axis in its middle: it grows to the side that is touched.
    let share = match half > 0.0 {
        true => (axis.dot(lever - 0.5 * placed.shape.thickness() * normal) / half).clamp(-1.0, 1.0),
        false => axis.dot(normal).signum(),
    };
    0.5 * (grown - length) * share * axis
}

/// Body `mother` becomes the daughter at its lower end; the one at its upper end is added last.
fn divide(bodies: &mut Bodies, mother: usize, cells: &Cells, (time, part): (f64, f64), next_id: &mut u64) {
    let placed = bodies.placed(mother);
    let Some((species, length)) = cells.of_body(bodies.group[mother], &placed.shape) else { return };
    let Some(shape) = placed.shape.grown(0.5 * length) else { return };
    let mut offset = placed.orientation * DVec3::Z * (0.25 * length);
    if cells.planar {
        offset.z = 0.0; // the axis lies in the plane up to rounding, the centres exactly
    }
    let line = bodies.lineage[mother];
    let mut random = Turn::stream(cells.seed, line.id);
    let (velocity, angular_velocity) = (bodies.velocity[mother], bodies.angular_velocity[mother]);
    let upper = bodies.push(placed, bodies.group[mother]);
    bodies.columns.copy(mother, upper);
    let lines = daughters(&line, time, next_id, species.birth_length(0.5 * length));
    for ((daughter, shift), line) in [(mother, -offset), (upper, offset)].into_iter().zip(lines) {
        bodies.shape[daughter] = shape;
        bodies.position[daughter] = placed.position + shift;
        let turn = Turn::draw(&mut random, species.growth.reorientation_degrees, cells.planar).scaled(part);
        let turned = turn.in_space(cells.planar, placed.orientation) * placed.orientation;
        bodies.orientation[daughter] = turned.normalize();
        bodies.velocity[daughter] = velocity + angular_velocity.cross(shift);
        bodies.angular_velocity[daughter] = angular_velocity;
        bodies.lineage[daughter] = line;
    }
    if species.growth.bond_daughters.is_some() {
        let count = bodies.len();
        join(&mut bodies.columns, count, line.id, [mother, upper]);
    }
}

/// The lines of both daughters of a cell that divides at `time`.
pub(crate) fn daughters(mother: &Lineage, time: f64, next_id: &mut u64, birth_length: Option<f64>) -> [Lineage; 2] {
    [(); 2].map(|()| {
        let id = *next_id;
        *next_id += 1;
        Lineage { id, parent: Some(mother.id), birth: time, generation: mother.generation + 1, birth_length }
    })
}

/// A daughter's small random turn: about z in a planar scene, else about a random direction across the axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    angle: f64,
    /// Cosine and sine of the direction across the axis.
    across: (f64, f64),
}

impl Turn {
    /// What a dividing cell's turns are drawn from.
    pub(crate) fn stream(seed: u64, id: u64) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(id);
        random
    }

    pub(crate) fn draw(random: &mut ChaCha8Rng, degrees: f64, planar: bool) -> Turn {
        let angle = degrees.to_radians() * (2.0 * random.random::<f64>() - 1.0);
        if planar {
            return Turn { angle, across: (0.0, 0.0) };
        }
        let (sin, cos) = (TAU * random.random::<f64>()).sin_cos();
        Turn { angle, across: (cos, sin) }
    }

    fn scaled(self, part: f64) -> Turn {
        Turn { angle: part * self.angle, ..self }
    }

    /// The turn in space axes: it comes after the mother's orientation.
    fn in_space(self, planar: bool, orientation: DQuat) -> DQuat {
        if planar {
            return DQuat::from_rotation_z(self.angle);
        }
        DQuat::from_axis_angle(orientation * DVec3::new(self.across.0, self.across.1, 0.0), self.angle)
    }

    /// The turn in body axes, which comes before the mother's orientation; in a planar scene the one in space.
    #[cfg(feature = "gpu")]
    pub(crate) fn in_body(self, planar: bool) -> DQuat {
        self.in_space(planar, DQuat::IDENTITY)
    }
}
