//! The bodies on the device: positions as integer lattice cells and remainders, orientations and lengths as coarse and
//! fine parts, so that neighbours' differences are exact at any distance from the origin and steps far under a rounding
//! add up.

use super::Setup;
use crate::bodies::Bodies;
use crate::dynamics::Spin;
use crate::gpu::{Buffer, Gpu, GpuError, Precision, Recorder};
use crate::shape::Shape;
use crate::step::{State, Unrounded};
use glam::{DQuat, DVec3};
use std::ops::Range;

/// The pitch of orientations, as in `shaders/common/orientation.wgsl`: a quaternion's numbers are multiples of it and a
/// remainder.
const TURN_PITCH: f64 = 1.0 / 1_048_576.0;

/// Where the numbers of a body in [`Unrounded::numbers`] are, behind the three of its remainder.
const ORIENTATION: Range<usize> = 3..11;
const VELOCITY: Range<usize> = 11..14;
const TURN: Range<usize> = 14..17;
/// Coarse part, fine part, and the length that is prescribed.
const LENGTH: Range<usize> = 17..20;

/// Where bodies are and how they move: one state of all of them.
pub(super) struct Poses {
    pub cells: Buffer,
    pub remainders: Buffer,
    /// Two vectors a body: coarse and fine.
    pub orientations: Buffer,
    /// Two vectors a body: velocity, and angular velocity or momentum, as [`Setup::keeps_momentum`] says.
    pub twists: Buffer,
}

/// What bodies are.
pub(super) struct Shapes {
    /// Sizes and tag.
    pub shapes: Buffer,
    /// Growing lengths, coarse and fine.
    pub lengths: Buffer,
}

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

impl Poses {
    pub fn new(gpu: &Gpu, precision: Precision, bodies: u64) -> Result<Self, GpuError> {
        let real = precision.bytes();
        Ok(Poses {
            cells: Buffer::new(gpu, "cells", 16, bodies)?,
            remainders: Buffer::new(gpu, "remainders", 4 * real, bodies)?,
            orientations: Buffer::new(gpu, "orientations", 8 * real, bodies)?,
            twists: Buffer::new(gpu, "twists", 8 * real, bodies)?,
        })
    }

    pub fn write(&self, gpu: &Gpu, precision: Precision, of: &Unrounded) {
        let cells: Vec<[i32; 4]> = of.cells.iter().map(|[x, y, z]| [*x, *y, *z, 0]).collect();
        self.cells.write(gpu, 0, bytemuck::cast_slice(&cells));
        self.remainders.write(gpu, 0, &precision.encode(of.numbers.iter().flat_map(|n| [n[0], n[1], n[2], 0.0])));
        self.orientations.write(
            gpu,
            0,
            &precision.encode(of.numbers.iter().flat_map(|n| n[ORIENTATION].iter().copied())),
        );
        let twists = of.numbers.iter().flat_map(|n| [&n[VELOCITY], &[0.0], &n[TURN], &[0.0]]).flatten().copied();
        self.twists.write(gpu, 0, &precision.encode(twists));
    }

    pub fn all(&self) -> [&Buffer; 4] {
        [&self.cells, &self.remainders, &self.orientations, &self.twists]
    }

    /// Makes room for more bodies.
    pub fn reserve(&mut self, gpu: &Gpu, record: &mut Recorder<'_>, bodies: u64) -> Result<(), GpuError> {
        for buffer in [&mut self.cells, &mut self.remainders, &mut self.orientations, &mut self.twists] {
            buffer.reserve_and_keep(gpu, record, bodies)?;
        }
        Ok(())
    }

    /// Copies the first `bodies` of another state.
    pub fn copy_from(&self, record: &mut Recorder<'_>, from: &Poses, bodies: u64) {
        for (from, to) in from.all().into_iter().zip(self.all()) {
            record.copy(from, 0, to, 0, bodies * from.element() as u64);
        }
    }
}

impl Shapes {
    pub fn new(gpu: &Gpu, precision: Precision, bodies: u64, growing: bool) -> Result<Self, GpuError> {
        Ok(Shapes {
            shapes: Buffer::new(gpu, "shapes", 4 * precision.bytes(), bodies)?,
            lengths: Buffer::new(gpu, "lengths", 2 * precision.bytes(), if growing { bodies } else { 1 })?,
        })
    }

    /// Writes shapes; where bodies grow their lengths too.
    pub fn write(&self, gpu: &Gpu, setup: &Setup, shapes: &[Shape], of: &Unrounded) {
        let precision = setup.precision;
        let numbers = |shape: &Shape| {
            let (tag, [x, y, z]) = shape.code();
            [x, y, z, f64::from(tag)]
        };
        self.shapes.write(gpu, 0, &precision.encode(shapes.iter().flat_map(numbers)));
        if setup.growth.is_some() {
            self.lengths.write(
                gpu,
                0,
                &precision.encode(of.numbers.iter().flat_map(|n| [n[LENGTH.start], n[LENGTH.start + 1]])),
            );
        }
    }

    pub fn reserve(&mut self, gpu: &Gpu, record: &mut Recorder<'_>, bodies: u64) -> Result<(), GpuError> {
        self.shapes.reserve_and_keep(gpu, record, bodies)?;
        self.lengths.reserve_and_keep(gpu, record, bodies)?;
        Ok(())
    }

    pub fn copy_from(&self, record: &mut Recorder<'_>, from: &Shapes, bodies: u64) {
        record.copy(&from.shapes, 0, &self.shapes, 0, bodies * from.shapes.element() as u64);
        record.copy(&from.lengths, 0, &self.lengths, 0, bodies * from.lengths.element() as u64);
    }
}

/// An orientation as its coarse part, multiples of a pitch, and the rest.
pub(super) fn coarse_and_fine(q: &DQuat) -> [f64; 8] {
    let q = q.to_array();
    let coarse = q.map(|x| (x / TURN_PITCH).round() * TURN_PITCH);
    std::array::from_fn(|i| if i < 4 { coarse[i] } else { q[i - 4] - coarse[i - 4] })
}

/// A length as a coarse part, a multiple of the pitch, and the rest.
pub(super) fn split_length(length: f64, pitch: f64) -> [f64; 2] {
    let coarse = (length / pitch).round() * pitch;
    [coarse, length - coarse]
}

/// The numbers that a device of this kind holds of a state: those that it had, or those of the bodies.
pub(super) fn unrounded(setup: &Setup, state: &State) -> Result<Unrounded, GpuError> {
    let own = |unrounded: &&Unrounded| unrounded.kind == kind(setup) && is_of(setup, unrounded, &state.bodies);
    match state.unrounded.as_ref().filter(own) {
        Some(unrounded) => Ok(unrounded.clone()),
        None => of_bodies(setup, &state.bodies),
    }
}

fn kind(setup: &Setup) -> [f64; 3] {
    let length_pitch = if setup.growth.is_some() { setup.length_pitch } else { 0.0 };
    [setup.precision.bytes() as f64, setup.lattice.pitch(), length_pitch]
}

/// Whether the bodies are what these numbers are rounded to.
fn is_of(setup: &Setup, unrounded: &Unrounded, bodies: &Bodies) -> bool {
    let rounded = |i: usize| {
        let shape = unrounded.shape(setup, i, &bodies.shape[i]);
        let pose = unrounded.pose(setup, i, &shape);
        let held = (bodies.position[i], bodies.orientation[i], bodies.velocity[i], bodies.angular_velocity[i]);
        shape == bodies.shape[i] && pose == held
    };
    unrounded.cells.len() == bodies.len() && unrounded.numbers.len() == bodies.len() && (0..bodies.len()).all(rounded)
}

fn of_bodies(setup: &Setup, bodies: &Bodies) -> Result<Unrounded, GpuError> {
    let (mut cells, mut numbers) = (Vec::with_capacity(bodies.len()), Vec::with_capacity(bodies.len()));
    for i in 0..bodies.len() {
        let mut own = [0.0; Unrounded::NUMBERS];
        let mut cell = [0; 3];
        for (axis, x) in bodies.position[i].to_array().into_iter().enumerate() {
            (cell[axis], own[axis]) = setup.lattice.split(x)?;
        }
        own[ORIENTATION].copy_from_slice(&coarse_and_fine(&bodies.orientation[i]));
        let (velocity, mut turn) = (bodies.velocity[i], bodies.angular_velocity[i]);
        if setup.keeps_momentum() {
            turn = Spin::new(bodies.shape[i].unit_inertia()).momentum(bodies.orientation[i], turn);
        }
        own[VELOCITY].copy_from_slice(&velocity.to_array());
        own[TURN].copy_from_slice(&turn.to_array());
        if setup.growth.is_some() {
            let length = bodies.shape[i].growing_length().unwrap_or(0.0);
            let [coarse, fine] = split_length(length, setup.length_pitch);
            own[LENGTH].copy_from_slice(&[coarse, fine, length]);
        }
        cells.push(cell);
        numbers.push(own);
    }
    Ok(Unrounded { kind: kind(setup), cells, numbers })
}

impl Unrounded {
    /// The lengths that bodies are to have.
    pub(super) fn prescribed(&self) -> impl Iterator<Item = f64> {
        self.numbers.iter().map(|n| n[LENGTH.end - 1])
    }

    /// Sets them.
    pub(super) fn prescribe(&mut self, lengths: &[f64]) {
        for (n, length) in self.numbers.iter_mut().zip(lengths) {
            n[LENGTH.end - 1] = *length;
        }
    }

    /// A body of this shape, but for its length.
    fn shape(&self, setup: &Setup, i: usize, shape: &Shape) -> Shape {
        let [coarse, fine] = [self.numbers[i][LENGTH.start], self.numbers[i][LENGTH.start + 1]];
        let grown = setup.growth.as_ref().and_then(|_| shape.grown(coarse + fine));
        grown.unwrap_or(*shape)
    }

    /// Position, orientation, velocity and angular velocity of a body.
    fn pose(&self, setup: &Setup, i: usize, shape: &Shape) -> (DVec3, DQuat, DVec3, DVec3) {
        let (cells, n) = (self.cells[i], &self.numbers[i]);
        let axis = |k: usize| setup.lattice.join(cells[k], n[k]);
        let part = |k: usize| n[ORIENTATION.start + k] + n[ORIENTATION.start + 4 + k];
        let orientation = DQuat::from_xyzw(part(0), part(1), part(2), part(3)).normalize();
        let turn = DVec3::from_slice(&n[TURN]);
        let angular = match setup.keeps_momentum() {
            true => Spin::new(shape.unit_inertia()).velocity(orientation, turn),
            false => turn,
        };
        (DVec3::new(axis(0), axis(1), axis(2)), orientation, DVec3::from_slice(&n[VELOCITY]), angular)
    }
}

/// Reads bodies back: one wait.
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
    let numbers = |i: usize| {
        let mut own = [0.0; Unrounded::NUMBERS];
        own[..3].copy_from_slice(&remainders[4 * i..4 * i + 3]);
        own[ORIENTATION].copy_from_slice(&orientations[8 * i..8 * i + 8]);
        own[VELOCITY].copy_from_slice(&twists[8 * i..8 * i + 3]);
        own[TURN].copy_from_slice(&twists[8 * i + 4..8 * i + 7]);
        if growing {
            own[LENGTH.start..LENGTH.start + 2].copy_from_slice(&lengths[2 * i..2 * i + 2]);
        }
        own
    };
    let n = bodies as usize;
    let unrounded = Unrounded {
        kind: kind(setup),
        cells: cells.iter().map(|[x, y, z, _]| [*x, *y, *z]).collect(),
        numbers: (0..n).map(numbers).collect(),
    };
    let shape = |i: usize| {
        let s = &sizes[4 * i..4 * i + 4];
        let shape = Shape::from_code(s[3] as u32, [s[0], s[1], s[2]]);
        let shape = shape.ok_or_else(|| GpuError::Refused { message: format!("body {i} has the shape {s:?}") })?;
        Ok(unrounded.shape(setup, i, &shape))
    };
    let shape = (0..n).map(shape).collect::<Result<Vec<_>, GpuError>>()?;
    let mut read = Downloaded { shape, ..Downloaded::default() };
    for (i, shape) in read.shape.iter().enumerate() {
        let (position, orientation, velocity, angular_velocity) = unrounded.pose(setup, i, shape);
        read.position.push(position);
        read.orientation.push(orientation);
        read.velocity.push(velocity);
        read.angular_velocity.push(angular_velocity);
    }
    Ok(Downloaded { unrounded, ..read })
}
