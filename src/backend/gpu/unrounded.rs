//! The coordinates of bodies in the device's format: conversion from bodies, and reading back.

use super::Setup;
use super::states::{Poses, Shapes};
use crate::bodies::Bodies;
use crate::dynamics::Spin;
use crate::gpu::{Buffer, Gpu, GpuError};
use crate::shape::Shape;
use crate::step::{State, Unrounded, UnroundedBody};
use glam::{DQuat, DVec3};

/// The pitch of orientations, as in `shaders/common/orientation.wgsl`: each component of a quaternion is a multiple of
/// it plus a remainder.
const TURN_PITCH: f64 = 1.0 / 1_048_576.0;

/// Poses and shapes as numbers.
#[derive(Default)]
pub(super) struct Downloaded {
    pub position: Vec<DVec3>,
    pub orientation: Vec<DQuat>,
    pub velocity: Vec<DVec3>,
    pub angular_velocity: Vec<DVec3>,
    pub shape: Vec<Shape>,
    pub unrounded: Unrounded,
}

/// An orientation as a coarse part, multiples of a pitch, and the remainder.
pub(super) fn coarse_and_fine(q: &DQuat) -> [[f64; 4]; 2] {
    let q = q.to_array();
    let coarse = q.map(|x| (x / TURN_PITCH).round() * TURN_PITCH);
    [coarse, std::array::from_fn(|i| q[i] - coarse[i])]
}

/// A length as a coarse part, a multiple of the pitch, and the remainder.
pub(super) fn split_length(length: f64, pitch: f64) -> [f64; 2] {
    let coarse = (length / pitch).round() * pitch;
    [coarse, length - coarse]
}

/// The device's numbers of a state: of each body the stored ones, or for a changed body those computed from it.
pub(super) fn unrounded(setup: &Setup, state: &State) -> Result<Unrounded, GpuError> {
    let bodies = &state.bodies;
    let fits = |had: &&Unrounded| had.kind == kind(setup) && had.bodies.len() == bodies.len();
    let had = state.unrounded.as_ref().filter(fits);
    let of = |i: usize| match had.map(|had| had.bodies[i]).filter(|own| is_of(setup, own, bodies, i)) {
        Some(own) => Ok(own),
        None => of_body(setup, bodies, i),
    };
    Ok(Unrounded { kind: kind(setup), bodies: (0..bodies.len()).map(of).collect::<Result<_, _>>()? })
}

fn kind(setup: &Setup) -> [f64; 3] {
    let length_pitch = if setup.growth.is_some() { setup.length_pitch } else { 0.0 };
    [setup.precision.bytes() as f64, setup.lattice.pitch(), length_pitch]
}

/// Whether body `i` is these numbers, rounded.
fn is_of(setup: &Setup, own: &UnroundedBody, bodies: &Bodies, i: usize) -> bool {
    let shape = own.shape(setup, &bodies.shape[i]);
    let held = (bodies.position[i], bodies.orientation[i], bodies.velocity[i], bodies.angular_velocity[i]);
    shape == bodies.shape[i] && own.pose(setup, &shape) == held
}

fn of_body(setup: &Setup, bodies: &Bodies, i: usize) -> Result<UnroundedBody, GpuError> {
    let mut body = UnroundedBody {
        orientation: coarse_and_fine(&bodies.orientation[i]),
        velocity: bodies.velocity[i].to_array(),
        turning: match setup.keeps_momentum() {
            true => {
                Spin::new(bodies.shape[i].unit_inertia()).momentum(bodies.orientation[i], bodies.angular_velocity[i])
            }
            false => bodies.angular_velocity[i],
        }
        .to_array(),
        ..UnroundedBody::default()
    };
    for (axis, x) in bodies.position[i].to_array().into_iter().enumerate() {
        (body.cell[axis], body.remainder[axis]) = setup.lattice.split(x)?;
    }
    if setup.growth.is_some() {
        let own = setup.growth.as_ref().and_then(|cells| cells.of_body(bodies.group[i], &bodies.shape[i]));
        let length = own.map_or_else(|| bodies.shape[i].rod_length(), |(_, length)| Some(length));
        body.prescribed = length.unwrap_or(0.0);
        body.length = split_length(body.prescribed, setup.length_pitch);
    }
    Ok(body)
}

impl Unrounded {
    /// The prescribed lengths of bodies.
    pub(super) fn prescribed(&self) -> impl Iterator<Item = f64> {
        self.bodies.iter().map(|body| body.prescribed)
    }

    /// Sets the prescribed lengths.
    pub(super) fn prescribe(&mut self, lengths: &[f64]) {
        for (body, length) in self.bodies.iter_mut().zip(lengths) {
            body.prescribed = *length;
        }
    }
}

impl UnroundedBody {
    /// The shape of the body: this shape with the stored length.
    fn shape(&self, setup: &Setup, shape: &Shape) -> Shape {
        let [coarse, fine] = self.length;
        let grown = setup.growth.as_ref().and_then(|_| shape.grown(coarse + fine));
        grown.unwrap_or(*shape)
    }

    /// Position, orientation, velocity and angular velocity.
    fn pose(&self, setup: &Setup, shape: &Shape) -> (DVec3, DQuat, DVec3, DVec3) {
        let axis = |k: usize| setup.lattice.join(self.cell[k], self.remainder[k]);
        let [coarse, fine] = self.orientation;
        let orientation = DQuat::from_array(std::array::from_fn(|k| coarse[k] + fine[k])).normalize();
        let turning = DVec3::from_array(self.turning);
        let angular = match setup.keeps_momentum() {
            true => Spin::new(shape.unit_inertia()).velocity(orientation, turning),
            false => turning,
        };
        (DVec3::from_array(std::array::from_fn(axis)), orientation, DVec3::from_array(self.velocity), angular)
    }
}

/// Reads bodies back, with one wait.
pub(super) fn download(
    gpu: &Gpu,
    setup: &Setup,
    poses: &Poses,
    shapes: &Shapes,
    bodies: u64,
) -> Result<Downloaded, GpuError> {
    let (precision, growing) = (setup.precision, setup.growth.is_some());
    let whole = |buffer| {
        let buffer: &Buffer = buffer;
        0..bodies * buffer.element() as u64
    };
    let lengths = if growing { whole(&shapes.lengths) } else { 0..0 };
    let [cells, remainders, orientations, twists] = poses.all();
    let read = gpu.record().read(&[
        (cells, whole(cells)),
        (remainders, whole(remainders)),
        (orientations, whole(orientations)),
        (twists, whole(twists)),
        (&shapes.shapes, whole(&shapes.shapes)),
        (&shapes.lengths, lengths),
    ])?;
    let cells: Vec<[i32; 4]> = bytemuck::pod_collect_to_vec(&read[0]);
    let [remainders, orientations, twists, sizes, lengths] = [1, 2, 3, 4, 5].map(|i| precision.decode(&read[i]));
    let vectors = |numbers: &[f64]| numbers.as_chunks::<4>().0.to_vec();
    let [remainders, orientations, twists] = [remainders, orientations, twists].map(|numbers| vectors(&numbers));
    let body = |i: usize| {
        let three = |[x, y, z, _]: [f64; 4]| [x, y, z];
        let [x, y, z, _] = cells[i];
        UnroundedBody {
            cell: [x, y, z],
            remainder: three(remainders[i]),
            orientation: [orientations[2 * i], orientations[2 * i + 1]],
            velocity: three(twists[2 * i]),
            turning: three(twists[2 * i + 1]),
            length: if growing { [lengths[2 * i], lengths[2 * i + 1]] } else { [0.0; 2] },
            prescribed: 0.0,
        }
    };
    let n = bodies as usize;
    let unrounded = Unrounded { kind: kind(setup), bodies: (0..n).map(body).collect() };
    let shape = |i: usize| {
        let s = &sizes[4 * i..4 * i + 4];
        let shape = setup.exponents.shape([s[0], s[1], s[2], s[3]]);
        let shape = shape.ok_or_else(|| GpuError::Refused { message: format!("body {i} has the shape {s:?}") })?;
        Ok(unrounded.bodies[i].shape(setup, &shape))
    };
    let shape = (0..n).map(shape).collect::<Result<Vec<_>, GpuError>>()?;
    let mut read = Downloaded { shape, ..Downloaded::default() };
    for (i, shape) in read.shape.iter().enumerate() {
        let (position, orientation, velocity, angular_velocity) = unrounded.bodies[i].pose(setup, shape);
        read.position.push(position);
        read.orientation.push(orientation);
        read.velocity.push(velocity);
        read.angular_velocity.push(angular_velocity);
    }
    Ok(Downloaded { unrounded, ..read })
}
