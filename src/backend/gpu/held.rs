//! Bodies that do not move, on the device. Their motions are set to zero, and two of them never form a pair.

use super::Setup;
use super::lists::Lists;
use super::source::{base, numbers, with_flags};
use crate::gpu::{Buffer, Gpu, GpuError, Made, Recorder, fragment, functions, kernels};

functions! {
    pub(super) Hold = struct HoldArgs<'a> { bodies: u64, is_fixed: &'a Buffer, motions: &'a Buffer }
    pub(super) Ignore = struct IgnoreArgs<'a> { flagged: u64, lists: &'a Lists, is_fixed: &'a Buffer }
}

kernels! {
    /// The kernels of bodies that do not move.
    pub(super) struct HeldKernels for setup: &Setup {
        hold: Hold = base(setup, "hold").include(fragment!("dynamics/hold.wgsl")),
        ignore: Ignore = numbers(with_flags(base(setup, "ignore"))).include(fragment!("dynamics/ignore.wgsl")),
    }
}

/// Which of the initial bodies of a run do not move. Daughters always move.
pub(super) struct Held {
    flags: Buffer,
    bodies: u64,
    kernels: HeldKernels,
}

impl Held {
    /// From one flag per body; `None` without flags.
    pub fn new(gpu: &Gpu, setup: &Setup, flags: &[bool]) -> Result<Option<Self>, GpuError> {
        if flags.is_empty() {
            return Ok(None);
        }
        let words: Vec<u32> = flags.iter().map(|fixed| u32::from(*fixed)).collect();
        let flags = Buffer::with(gpu, "fixed bodies", 4, bytemuck::cast_slice(&words))?;
        Ok(Some(Held { flags, bodies: words.len() as u64, kernels: HeldKernels::make(gpu, setup)? }))
    }

    /// Writes new flags.
    pub fn write(&mut self, gpu: &Gpu, flags: &[bool]) -> Result<(), GpuError> {
        let words: Vec<u32> = flags.iter().map(|fixed| u32::from(*fixed)).collect();
        self.flags.reserve(gpu, words.len() as u64)?;
        self.flags.write(gpu, 0, bytemuck::cast_slice(&words));
        self.bodies = words.len() as u64;
        Ok(())
    }

    /// Records that the motions of fixed bodies are set to zero.
    pub fn hold(&self, record: &mut Recorder<'_>, motions: &Buffer) {
        let (bodies, is_fixed) = (self.bodies, &self.flags);
        self.kernels.hold.call(record, bodies, HoldArgs { bodies, is_fixed, motions });
    }

    /// Records that pairs of two fixed parts are marked as far.
    pub fn ignore(&self, record: &mut Recorder<'_>, lists: &Lists) {
        let (flagged, is_fixed) = (self.bodies, &self.flags);
        self.kernels.ignore.call(record, lists.pairs_count, IgnoreArgs { flagged, lists, is_fixed });
    }
}
