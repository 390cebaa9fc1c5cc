//! Bodies that do not move, on the device. Their motions are set to zero, and two of them never form a pair.

use super::candidates::Lists;
use super::source::{Kernels, base, numbers, with_flags};
use super::{Setup, words};
use crate::gpu::{Buffer, Gpu, GpuError, Kernel, Recorder, fragment, kernels};

kernels! {
    /// The kernels of bodies that do not move.
    pub(super) struct HeldKernels for setup: &Setup {
        hold: Kernel = base(setup, "hold").include(fragment!("dynamics/hold.wgsl")),
        ignore: Kernel = numbers(with_flags(base(setup, "ignore"))).include(fragment!("dynamics/ignore.wgsl")),
    }
}

/// Which of the bodies that a run starts with do not move. Those that are born move.
pub(super) struct Held {
    flags: Buffer,
    bodies: u64,
}

impl Held {
    /// Of a flag for each body; none where there are no flags.
    pub fn new(gpu: &Gpu, flags: &[bool]) -> Result<Option<Self>, GpuError> {
        if flags.is_empty() {
            return Ok(None);
        }
        let words: Vec<u32> = flags.iter().map(|fixed| u32::from(*fixed)).collect();
        let flags = Buffer::with(gpu, "fixed bodies", 4, bytemuck::cast_slice(&words))?;
        Ok(Some(Held { flags, bodies: words.len() as u64 }))
    }

    /// Takes the flags of other bodies.
    pub fn write(&mut self, gpu: &Gpu, flags: &[bool]) -> Result<(), GpuError> {
        let words: Vec<u32> = flags.iter().map(|fixed| u32::from(*fixed)).collect();
        self.flags.reserve(gpu, words.len() as u64)?;
        self.flags.write(gpu, 0, bytemuck::cast_slice(&words));
        self.bodies = words.len() as u64;
        Ok(())
    }

    /// Records that fixed bodies have no motion.
    pub fn hold(&self, kernels: &Kernels, record: &mut Recorder<'_>, motions: &Buffer) {
        let Some(kernels) = &kernels.held else { return };
        let buffers = [("is_fixed", &self.flags), ("motions", motions)];
        record.run(&kernels.hold, &words([self.bodies as u32, 0, 0, 0]), &buffers, self.bodies);
    }

    /// Records that pairs of which neither part moves are far.
    pub fn ignore(&self, kernels: &Kernels, record: &mut Recorder<'_>, lists: &Lists) {
        let Some(kernels) = &kernels.held else { return };
        let buffers = [("pairs", &lists.pairs), ("is_fixed", &self.flags), ("contacts", &lists.contacts)];
        let parameters = words([lists.pairs_count as u32, self.bodies as u32, 0, 0]);
        record.run(&kernels.ignore, &parameters, &buffers, lists.pairs_count);
    }
}
