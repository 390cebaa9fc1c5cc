//! The bodies on the device: positions as integer lattice cells and remainders, orientations and lengths as coarse and
//! fine parts, so that neighbours' differences are exact at any distance from the origin and steps far under a rounding
//! add up.

use super::Setup;
use crate::dynamics::Spin;
use crate::gpu::{Buffer, Gpu, GpuError, Precision, Recorder};
use crate::shape::Shape;
use glam::{DQuat, DVec3};

/// The pitch of orientations, as in `shaders/common/orientation.wgsl`: a quaternion's numbers are multiples of it and a
/// remainder.
const TURN_PITCH: f64 = 1.0 / 1_048_576.0;

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

/// A pose as numbers.
pub(super) struct Downloaded {
    pub position: Vec<DVec3>,
    pub orientation: Vec<DQuat>,
    pub velocity: Vec<DVec3>,
    pub angular_velocity: Vec<DVec3>,
    pub shape: Vec<Shape>,
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

    pub fn write(&self, gpu: &Gpu, setup: &Setup, bodies: &crate::bodies::Bodies) -> Result<(), GpuError> {
        let (precision, lattice) = (setup.precision, &setup.lattice);
        let mut cells: Vec<i32> = Vec::with_capacity(4 * bodies.len());
        let mut remainders = Vec::with_capacity(4 * bodies.len());
        for position in &bodies.position {
            for x in position.to_array() {
                let (cell, remainder) = lattice.split(x)?;
                cells.push(cell);
                remainders.push(remainder);
            }
            cells.push(0);
            remainders.push(0.0);
        }
        self.cells.write(gpu, 0, bytemuck::cast_slice(&cells));
        self.remainders.write(gpu, 0, &precision.encode(remainders));
        self.orientations.write(gpu, 0, &precision.encode(bodies.orientation.iter().flat_map(coarse_and_fine)));
        let twist = |i: usize| {
            let (u, mut w) = (bodies.velocity[i], bodies.angular_velocity[i]);
            if setup.keeps_momentum() {
                w = Spin::new(bodies.shape[i].unit_inertia()).momentum(bodies.orientation[i], w);
            }
            [u.x, u.y, u.z, 0.0, w.x, w.y, w.z, 0.0]
        };
        self.twists.write(gpu, 0, &precision.encode((0..bodies.len()).flat_map(twist)));
        Ok(())
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

    /// Writes shapes; with a length pitch the growing lengths too.
    pub fn write(&self, gpu: &Gpu, precision: Precision, shapes: &[Shape], length_pitch: Option<f64>) {
        let numbers = |shape: &Shape| {
            let (tag, [x, y, z]) = shape.code();
            [x, y, z, f64::from(tag)]
        };
        self.shapes.write(gpu, 0, &precision.encode(shapes.iter().flat_map(numbers)));
        if let Some(pitch) = length_pitch {
            let parts = |shape: &Shape| split_length(shape.growing_length().unwrap_or(0.0), pitch);
            self.lengths.write(gpu, 0, &precision.encode(shapes.iter().flat_map(parts)));
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

/// Reads bodies back: one wait.
pub(super) fn download(
    gpu: &Gpu,
    setup: &Setup,
    poses: &Poses,
    shapes: &Shapes,
    bodies: u64,
) -> Result<Downloaded, GpuError> {
    let (precision, lattice, growing) = (setup.precision, &setup.lattice, setup.growth.is_some());
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
    let cells: Vec<i32> = bytemuck::pod_collect_to_vec(&read[0]);
    let [remainders, orientations, twists, sizes, lengths] = [1, 2, 3, 4, 5].map(|i| precision.decode(&read[i]));
    let n = bodies as usize;
    let vector = |x: &[f64]| DVec3::new(x[0], x[1], x[2]);
    let axis = |i: usize, k: usize| lattice.join(cells[4 * i + k], remainders[4 * i + k]);
    let quaternion = |i: usize| {
        let part = |k: usize| orientations[8 * i + k] + orientations[8 * i + 4 + k];
        DQuat::from_xyzw(part(0), part(1), part(2), part(3)).normalize()
    };
    let shape = |i: usize| {
        let s = &sizes[4 * i..4 * i + 4];
        let shape = Shape::from_code(s[3] as u32, [s[0], s[1], s[2]]);
        let shape = shape.ok_or_else(|| GpuError::Refused { message: format!("body {i} has the shape {s:?}") })?;
        Ok(match growing {
            true => shape.grown(lengths[2 * i] + lengths[2 * i + 1]).unwrap_or(shape),
            false => shape,
        })
    };
    let shape = (0..n).map(shape).collect::<Result<Vec<_>, GpuError>>()?;
    let orientation: Vec<_> = (0..n).map(quaternion).collect();
    let angular_velocity = |i: usize| {
        let kept = vector(&twists[8 * i + 4..]);
        if setup.keeps_momentum() { Spin::new(shape[i].unit_inertia()).velocity(orientation[i], kept) } else { kept }
    };
    Ok(Downloaded {
        position: (0..n).map(|i| DVec3::new(axis(i, 0), axis(i, 1), axis(i, 2))).collect(),
        velocity: (0..n).map(|i| vector(&twists[8 * i..])).collect(),
        angular_velocity: (0..n).map(angular_velocity).collect(),
        orientation,
        shape,
    })
}
