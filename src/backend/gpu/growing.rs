//! Growth and division on the device. The host decides which bodies divide and draws the random rotations: lengths are
//! prescribed, so it needs no read-back. A kernel moves and rotates the daughters. Only if pressure slows growth, the
//! state is read back in each step.

use super::Setup;
use super::ancestry::{Ancestry, Growing};
use super::source::base;
use super::start::Start;
use super::states::{Poses, Shapes, States};
use super::unrounded::split_length;
use crate::dynamics::growth::Turn;
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, Source, arrays, fragment, functions, kernels};
use crate::shape::gpu::{add_shapes_to, add_tags_to};

functions! {
    pub(super) Grow = struct GrowArgs<'a> { bodies: u64, shapes: &'a Shapes, own: &'a GrowthBuffers }
    pub(super) Reshape = struct ReshapeArgs<'a> { bodies: u64, shapes: &'a Shapes, own: &'a GrowthBuffers }
    pub(super) Divide = struct DivideArgs<'a> {
        divisions: u64, own: &'a GrowthBuffers, start: &'a Poses, shapes: &'a Shapes,
    }
}

kernels! {
    /// The kernels of growth and division.
    pub(super) struct GrowthKernels for setup: &Setup {
        grow: Grow = with_lengths(setup, "grow").include(fragment!("dynamics/grow.wgsl")),
        divide: Divide = with_lengths(setup, "divide").include(fragment!("dynamics/divide.wgsl")),
        /// Sets the radii of growing ellipsoids to those at their lengths.
        reshape: Option<Reshape> = setup.grows_ellipsoids()
            .then(|| base(setup, "reshape").include(fragment!("dynamics/reshape.wgsl"))),
    }
}

/// A source with the functions for shapes and growing lengths.
fn with_lengths(setup: &Setup, name: &str) -> Source {
    let source = base(setup, name).real("LENGTH_PITCH", setup.length_pitch);
    match setup.grows_ellipsoids() {
        true => add_tags_to(source).include(fragment!("dynamics/growing_ellipsoids.wgsl")),
        false => add_shapes_to(source),
    }
}

/// The inputs of the growth kernels, written by the host. The buffers are kept, because for new buffers the device
/// would have to bind all its kernels again.
pub(super) struct GrowthBuffers {
    /// The relative growth of each body in a part of a step.
    growths: Buffer,
    /// The divisions of a step.
    divisions: Buffer,
    indices: Buffer,
    /// The radii of curvature of the tips of bodies, where ellipsoids grow.
    tips: Buffer,
    /// In scenes with growth.
    kernels: Option<GrowthKernels>,
}

arrays! { GrowthBuffers { growths, divisions, indices, tips } }

impl GrowthBuffers {
    pub fn new(gpu: &Gpu, setup: &Setup, ancestry: &mut Ancestry) -> Result<Self, GpuError> {
        let real = setup.precision.bytes();
        let mut made = GrowthBuffers {
            growths: Buffer::new(gpu, "growths", real, ancestry.growing.len() as u64)?,
            divisions: Buffer::new(gpu, "divisions", 12 * real, 0)?,
            indices: Buffer::new(gpu, "dividing bodies", 8, 0)?,
            tips: Buffer::new(gpu, "tips", 2 * real, 0)?,
            kernels: Made::make(gpu, setup.growth.is_some().then_some(setup))?,
        };
        made.write_changed(gpu, setup, ancestry)?;
        made.write_tips(gpu, setup, ancestry, 0)?;
        Ok(made)
    }

    /// Writes the tips of the bodies from number `from` on, or of all where the device lost them.
    pub fn write_tips(&mut self, gpu: &Gpu, setup: &Setup, ancestry: &Ancestry, from: usize) -> Result<(), GpuError> {
        if !setup.grows_ellipsoids() {
            return Ok(());
        }
        let from = if self.tips.reserve(gpu, ancestry.growing.len() as u64)? { 0 } else { from };
        let place = from as u64 * self.tips.element() as u64;
        self.tips.write(gpu, place, &setup.precision.encode(ancestry.growing[from..].iter().flat_map(Growing::tips)));
        Ok(())
    }

    /// Writes the growth of bodies whose rates have changed.
    pub fn write_changed(&mut self, gpu: &Gpu, setup: &Setup, ancestry: &mut Ancestry) -> Result<(), GpuError> {
        let lost = self.growths.reserve(gpu, ancestry.growing.len() as u64)?;
        let real = setup.precision.bytes() as u64;
        for (first, growths) in ancestry.changed_growths(lost) {
            self.growths.write(gpu, first as u64 * real, &setup.precision.encode(growths));
        }
        Ok(())
    }

    /// Records the growth of the bodies in a part of the step.
    pub fn record(&self, record: &mut Recorder<'_>, shapes: &Shapes, bodies: u64) {
        let Some(kernels) = &self.kernels else { return };
        kernels.grow.call(record, bodies, GrowArgs { bodies, shapes, own: self });
        if let Some(reshape) = &kernels.reshape {
            reshape.call(record, bodies, ReshapeArgs { bodies, shapes, own: self });
        }
    }

    /// Writes the divisions of a step: 12 numbers and two indices per division.
    fn write_divisions(
        &mut self,
        gpu: &Gpu,
        setup: &Setup,
        numbers: Vec<f64>,
        indices: &[[u32; 2]],
        count: u64,
    ) -> Result<(), GpuError> {
        self.divisions.reserve(gpu, count)?;
        self.divisions.write(gpu, 0, &setup.precision.encode(numbers));
        self.indices.reserve(gpu, count)?;
        self.indices.write(gpu, 0, bytemuck::cast_slice(indices));
        Ok(())
    }
}

impl Start {
    /// Sets the bodies of the step: those of the accepted state, of which some divide, grown over the first part.
    pub(super) fn grow(
        &mut self,
        gpu: &Gpu,
        setup: &Setup,
        states: &mut States,
        (old, slowing): (u64, &[f64]),
    ) -> Result<(), GpuError> {
        let due = self.ancestry.due().to_vec();
        self.bodies = old + due.len() as u64;
        let mut record = gpu.record();
        record.stage("growth");
        states.reserve(gpu, &mut record, self.bodies)?;
        states.begin(&mut record, old);
        if !due.is_empty() {
            let count = self.divide(gpu, setup, &due, slowing)?;
            self.record_divisions(&mut record, states, count);
        }
        self.growth.write_changed(gpu, setup, &mut self.ancestry)?;
        self.growth.record(&mut record, states.end_shapes(), self.bodies);
        record.submit()
    }

    /// Writes the divisions of the bodies in `due` for the kernel. Returns their number.
    fn divide(&mut self, gpu: &Gpu, setup: &Setup, due: &[usize], slowing: &[f64]) -> Result<u64, GpuError> {
        let Some(cells) = &setup.growth else { return Ok(0) };
        let mut numbers = Vec::with_capacity(12 * due.len());
        let mut indices: Vec<[u32; 2]> = Vec::with_capacity(due.len());
        let old = self.ancestry.group.len();
        for &mother in due {
            let Some(species) = cells.of(self.ancestry.group[mother]) else { continue };
            let degrees = species.growth.reorientation_degrees;
            let mut random = Turn::stream(cells.seed, self.ancestry.lineage[mother].id);
            let turns = [(); 2].map(|()| Turn::draw(&mut random, degrees, setup.planar));
            let slowing = slowing.get(mother).copied().unwrap_or(0.0);
            let (mother, upper, half) = self.ancestry.divide(&species, mother, self.time, slowing);
            let [coarse, fine] = split_length(half, setup.length_pitch);
            numbers.extend([coarse, fine, 0.0, 0.0]);
            numbers.extend(turns.iter().flat_map(|turn| turn.in_body(setup.planar).to_array()));
            indices.push([mother as u32, upper as u32]);
        }
        let count = due.len() as u64;
        self.growth.write_divisions(gpu, setup, numbers, &indices, count)?;
        self.growth.write_tips(gpu, setup, &self.ancestry, old)?;
        let lost = self.groups_of.reserve(gpu, self.ancestry.group.len() as u64)?;
        let from = if lost { 0 } else { old };
        self.groups_of.write(gpu, 4 * from as u64, bytemuck::cast_slice(&self.ancestry.group[from..]));
        Ok(count)
    }

    /// Records the replacement of mothers by two daughters.
    fn record_divisions(&self, record: &mut Recorder<'_>, states: &States, divisions: u64) {
        let Some(kernels) = &self.growth.kernels else { return };
        let (own, start, shapes) = (&self.growth, states.start(), states.end_shapes());
        kernels.divide.call(record, divisions, DivideArgs { divisions, own, start, shapes });
    }
}
