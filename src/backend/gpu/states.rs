//! The bodies on the device and their states within a step.
//!
//! Positions are integer lattice cells and remainders; orientations and lengths are coarse and fine parts. So
//! differences between neighbours are exact at any distance from the origin, and steps far smaller than a rounding
//! error accumulate.

use super::Setup;
use super::part::Part;
use crate::gpu::{Buffer, Gpu, GpuError, Precision, Recorder, arrays};
use crate::shape::Shape;
use crate::step::{Unrounded, UnroundedBody};

/// Positions, orientations and velocities of all bodies in one state.
pub(super) struct Poses {
    pub cells: Buffer,
    pub remainders: Buffer,
    /// Two vectors per body: coarse and fine.
    pub orientations: Buffer,
    /// Two vectors per body: velocity, and angular velocity or momentum, according to [`Setup::keeps_momentum`].
    pub twists: Buffer,
}

arrays! { Poses { cells, remainders, orientations, twists } }

/// The shapes of all bodies in one state.
pub(super) struct Shapes {
    /// Sizes and tag.
    pub shapes: Buffer,
    /// Growing lengths, coarse and fine.
    pub lengths: Buffer,
}

arrays! { Shapes { shapes, lengths } }

/// The states of a step by name. States that a scene does not need are not created; another state serves instead.
pub(super) struct States {
    /// The last accepted state.
    pub accepted: Poses,
    pub trial: Poses,
    /// In scenes with growth, the step's start; otherwise the accepted state is the start.
    start: Option<Poses>,
    /// The middle of a midpoint step.
    middle: Option<Poses>,
    /// The state where first rows are made, if this is not the beginning of a part: extrapolated with the last
    /// velocities or with the flow of a changing cell.
    ahead: Option<Poses>,
    /// The shapes of the last accepted state.
    pub accepted_shapes: Shapes,
    /// In scenes with growth, the shapes at the end of the present part.
    end_shapes: Option<Shapes>,
    /// In scenes with growth and midpoint steps, the shapes in the middle.
    middle_shapes: Option<Shapes>,
}

impl States {
    pub fn new(gpu: &Gpu, setup: &Setup, bodies: u64) -> Result<Self, GpuError> {
        let grows = setup.growth.is_some();
        let poses = || Poses::new(gpu, setup.precision, bodies);
        let shapes = || Shapes::new(gpu, setup.precision, bodies, grows);
        Ok(States {
            accepted: poses()?,
            trial: poses()?,
            start: grows.then(poses).transpose()?,
            middle: setup.midpoint.then(poses).transpose()?,
            ahead: (setup.leads_ahead() || setup.strain.is_some()).then(poses).transpose()?,
            accepted_shapes: shapes()?,
            end_shapes: grows.then(shapes).transpose()?,
            middle_shapes: (grows && setup.midpoint).then(shapes).transpose()?,
        })
    }

    /// Writes the accepted state.
    pub fn write(&self, gpu: &Gpu, setup: &Setup, shapes: &[Shape], of: &Unrounded) {
        self.accepted.write(gpu, setup.precision, of);
        self.accepted_shapes.write(gpu, setup, shapes, of);
    }

    /// Reserves memory for more bodies.
    pub fn reserve(&mut self, gpu: &Gpu, record: &mut Recorder<'_>, bodies: u64) -> Result<(), GpuError> {
        let own = [&mut self.accepted, &mut self.trial];
        for poses in own.into_iter().chain(&mut self.start).chain(&mut self.middle).chain(&mut self.ahead) {
            poses.reserve(gpu, record, bodies)?;
        }
        let own = std::iter::once(&mut self.accepted_shapes);
        for shapes in own.chain(&mut self.end_shapes).chain(&mut self.middle_shapes) {
            shapes.reserve(gpu, record, bodies)?;
        }
        Ok(())
    }

    /// Records the start of a step with the first `bodies` of the accepted state.
    pub fn begin(&self, record: &mut Recorder<'_>, bodies: u64) {
        if let Some(start) = &self.start {
            start.copy_from(record, &self.accepted, bodies);
        }
        if let Some(end) = &self.end_shapes {
            end.copy_from(record, &self.accepted_shapes, bodies);
        }
    }

    /// Records that the present lengths are those in the middle.
    pub fn keep_lengths(&self, record: &mut Recorder<'_>, bodies: u64) {
        if let Some(middle) = &self.middle_shapes {
            middle.copy_from(record, self.end_shapes(), bodies);
        }
    }

    /// Makes the trial the accepted state.
    pub fn accept(&mut self) {
        std::mem::swap(&mut self.accepted, &mut self.trial);
        if let Some(end) = &mut self.end_shapes {
            std::mem::swap(&mut self.accepted_shapes, end);
        }
    }

    /// The poses at the step's start.
    pub fn start(&self) -> &Poses {
        self.start.as_ref().unwrap_or(&self.accepted)
    }

    /// The poses in the step's middle.
    pub fn middle(&self) -> &Poses {
        self.middle.as_ref().unwrap_or_else(|| self.start())
    }

    /// The poses at the beginning of a part.
    pub fn here(&self, part: Part) -> &Poses {
        if part == Part::FromMiddle { self.middle() } else { self.start() }
    }

    /// The poses where the first rows of a part are made: `ahead`, or those at its beginning.
    pub fn first(&self, part: Part, ahead: bool) -> &Poses {
        self.ahead.as_ref().filter(|_| ahead).unwrap_or_else(|| self.here(part))
    }

    /// The shapes at the end of the present part.
    pub fn end_shapes(&self) -> &Shapes {
        self.end_shapes.as_ref().unwrap_or(&self.accepted_shapes)
    }

    /// The shapes in the first rows of a part: with the lengths at its end, or in the middle with the lengths there.
    pub fn here_shapes(&self, part: Part) -> &Shapes {
        let middle = self.middle_shapes.as_ref().filter(|_| part == Part::FromMiddle);
        middle.unwrap_or_else(|| self.end_shapes())
    }
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
        let vector = |[x, y, z]: [f64; 3]| [x, y, z, 0.0];
        let cells: Vec<[i32; 4]> =
            of.bodies.iter().map(|UnroundedBody { cell: [x, y, z], .. }| [*x, *y, *z, 0]).collect();
        let remainders = of.bodies.iter().flat_map(|body| vector(body.remainder));
        let orientations = of.bodies.iter().flat_map(|body| body.orientation);
        let twists = of.bodies.iter().flat_map(|body| [vector(body.velocity), vector(body.turning)]);
        self.cells.write(gpu, 0, bytemuck::cast_slice(&cells));
        self.remainders.write(gpu, 0, &precision.encode(remainders));
        self.orientations.write(gpu, 0, &precision.encode(orientations.flatten()));
        self.twists.write(gpu, 0, &precision.encode(twists.flatten()));
    }

    pub fn all(&self) -> [&Buffer; 4] {
        [&self.cells, &self.remainders, &self.orientations, &self.twists]
    }

    /// Reserves memory for more bodies.
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

    /// Writes shapes, and in scenes with growth also lengths.
    pub fn write(&self, gpu: &Gpu, setup: &Setup, shapes: &[Shape], of: &Unrounded) {
        let precision = setup.precision;
        let numbers = |shape: &Shape| setup.exponents.numbers(shape);
        self.shapes.write(gpu, 0, &precision.encode(shapes.iter().flat_map(numbers)));
        if setup.growth.is_some() {
            self.lengths.write(gpu, 0, &precision.encode(of.bodies.iter().flat_map(|body| body.length)));
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
