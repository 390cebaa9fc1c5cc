//! Pairs of bodies that bonds keep from colliding, on the device: they are marked as far.

use super::Setup;
use super::lists::Lists;
use super::source::{base, with_flags};
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, fragment, functions, kernels};

functions! {
    pub(super) Part = struct PartArgs<'a> { count: u64, lists: &'a Lists, parted: &'a Buffer }
}

kernels! {
    /// The kernel of pairs that do not collide.
    pub(super) struct PartedKernels for setup: &Setup {
        part: Part = with_flags(base(setup, "parted")).include(fragment!("dynamics/parted.wgsl")),
    }
}

/// The pairs that do not collide.
pub(super) struct Parted {
    parted: Buffer,
    written: Vec<[u32; 2]>,
    kernels: PartedKernels,
}

impl Parted {
    /// None yet; `None` in a scene without such bonds.
    pub fn new(gpu: &Gpu, setup: &Setup) -> Result<Option<Self>, GpuError> {
        if !setup.bonds.any_without_contact() {
            return Ok(None);
        }
        let parted = Buffer::new(gpu, "pairs without contact", 8, 1)?;
        Ok(Some(Parted { parted, written: Vec::new(), kernels: PartedKernels::make(gpu, setup)? }))
    }

    /// Sets the pairs: the lower body first, ascending.
    pub fn write(&mut self, gpu: &Gpu, pairs: &[[u32; 2]]) -> Result<(), GpuError> {
        if self.written != pairs {
            self.parted.reserve(gpu, pairs.len() as u64)?;
            self.parted.write(gpu, 0, bytemuck::cast_slice(pairs));
            self.written = pairs.to_vec();
        }
        Ok(())
    }

    /// Records that these pairs are marked as far.
    pub fn part(&self, record: &mut Recorder<'_>, lists: &Lists) {
        let (count, parted) = (self.written.len() as u64, &self.parted);
        self.kernels.part.call(record, lists.pairs_count, PartArgs { count, lists, parted });
    }
}
