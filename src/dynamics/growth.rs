//! Growth and division: prescribed motion, done at a step's start.
//!
//! Every cell at its division length divides into two of half its actual length that exactly fill it, each turned by a small
//! random angle; then every cell takes its end-of-step length `length e^(rate dt)`. The step's separations, mobilities and
//! trials all use that length. Against extrapolating `Phi + dt dPhi/dlength length'` from the old one, this is equal to first
//! order and exact in the length; and every accepted state has been through a solve with the lengths and bodies that it holds.

use crate::bodies::{Bodies, Lineage};
use crate::scene::Growth;
use crate::separation::Placed;
use crate::shape::Shape;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Divides and grows all cells over the step of `dt` that begins at `time`. `next_id` is the id of the next cell born.
///
/// Random angles are drawn from a stream of `seed` that belongs to the dividing cell's id, so they depend on nothing else.
pub fn grow(bodies: &mut Bodies, growth: &Growth, planar: bool, seed: u64, time: f64, dt: f64, next_id: &mut u64) {
    for mother in 0..bodies.len() {
        if bodies.shape[mother].growing_length().is_some_and(|length| length >= growth.division_length) {
            divide(bodies, mother, growth, planar, seed, time, next_id);
        }
    }
    lengthen(bodies, growth, dt);
}

/// Grows all cells over `dt`; none divides.
pub fn lengthen(bodies: &mut Bodies, growth: &Growth, dt: f64) {
    let factor = (growth.rate * dt).exp();
    for shape in &mut bodies.shape {
        if let Some(grown) = shape.growing_length().and_then(|length| shape.grown(length * factor)) {
            *shape = grown;
        }
    }
}

/// How far the surface of `placed` moves where `lever` touches it with the outward normal `normal`, as the body grows to the shape `to`.
///
/// Between its middle and a tip a point of the axis moves in proportion to its place. As the separation is an extremum over all points of the axis, this
/// displacement along the normal is the exact derivative of the separation with respect to the length.
pub fn stretch(placed: &Placed, to: &Shape, lever: DVec3, normal: DVec3) -> DVec3 {
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
fn divide(bodies: &mut Bodies, mother: usize, growth: &Growth, planar: bool, seed: u64, time: f64, next_id: &mut u64) {
    let placed = bodies.placed(mother);
    let Some(length) = placed.shape.growing_length() else { return };
    let Some(shape) = placed.shape.grown(0.5 * length) else { return };
    let mut offset = placed.orientation * DVec3::Z * (0.25 * length);
    if planar {
        offset.z = 0.0; // the axis lies in the plane up to rounding, the centres exactly
    }
    let line = bodies.lineage[mother];
    let mut random = Turn::stream(seed, line.id);
    let (velocity, angular_velocity) = (bodies.velocity[mother], bodies.angular_velocity[mother]);
    let upper = bodies.push(placed, bodies.group[mother]);
    let lines = daughters(&line, time, next_id);
    for ((daughter, shift), line) in [(mother, -offset), (upper, offset)].into_iter().zip(lines) {
        bodies.shape[daughter] = shape;
        bodies.position[daughter] = placed.position + shift;
        let turn = Turn::draw(&mut random, growth.reorientation_degrees, planar);
        bodies.orientation[daughter] = (turn.in_space(planar, placed.orientation) * placed.orientation).normalize();
        bodies.velocity[daughter] = velocity + angular_velocity.cross(shift);
        bodies.angular_velocity[daughter] = angular_velocity;
        bodies.lineage[daughter] = line;
    }
}

/// The lines of both daughters of a cell that divides at `time`.
pub(crate) fn daughters(mother: &Lineage, time: f64, next_id: &mut u64) -> [Lineage; 2] {
    [(); 2].map(|()| {
        let id = *next_id;
        *next_id += 1;
        Lineage { id, parent: Some(mother.id), birth: time, generation: mother.generation + 1 }
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

    /// The turn in space axes: it comes after the mother's orientation.
    fn in_space(self, planar: bool, orientation: DQuat) -> DQuat {
        if planar {
            return DQuat::from_rotation_z(self.angle);
        }
        DQuat::from_axis_angle(orientation * DVec3::new(self.across.0, self.across.1, 0.0), self.angle)
    }

    /// The turn in body axes, which comes before the mother's orientation; in a planar scene the one in space.
    pub(crate) fn in_body(self, planar: bool) -> DQuat {
        self.in_space(planar, DQuat::IDENTITY)
    }
}
