//! The one buffer that contains all arrays of all members. It grows between rounds, by a copy of the whole buffer;
//! offsets in it do not change.

use crate::gpu::{Gpu, GpuError};
use range_alloc::RangeAllocator;
use std::ops::Range;

/// Offsets and sizes are multiples of this. Elements of kernels' arrays have 4 to 256 bytes, some with factors 3 and 5,
/// and an offset must be a whole number of elements; otherwise the kernel reports a fault.
const UNIT: u64 = 3840;

/// Bytes of a new arena: enough for some ten small scenes.
const FIRST_BYTES: u64 = 4 << 20;

/// The buffer of an arena, and its used ranges.
pub(super) struct Arena {
    pub raw: wgpu::Buffer,
    /// The number of buffers that the arena has had.
    pub version: u64,
    ranges: RangeAllocator<u64>,
    /// Bytes from here on have never been used, so they are zero.
    untouched: u64,
    pub taken: u64,
    pub peak: u64,
}

fn buffer(gpu: &Gpu, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let descriptor = wgpu::BufferDescriptor { label: Some("arena"), size: bytes, usage, mapped_at_creation: false };
    gpu.scoped("arena", || gpu.device.create_buffer(&descriptor))
}

/// The largest size of an arena: one binding, with words that are counted by `u32`.
pub(super) fn most_bytes(gpu: &Gpu) -> u64 {
    let most = gpu.limits.max_storage_buffer_binding_size.min(gpu.limits.max_buffer_size);
    most.min(4 * u64::from(u32::MAX)) / UNIT * UNIT
}

impl Arena {
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let bytes = (FIRST_BYTES / UNIT * UNIT).min(most_bytes(gpu));
        let (raw, ranges) = (buffer(gpu, bytes)?, RangeAllocator::new(0..bytes));
        Ok(Arena { raw, version: 0, ranges, untouched: 0, taken: 0, peak: 0 })
    }

    /// Allocates at least `bytes` bytes. Also returns whether the range may contain old data.
    ///
    /// # Errors
    /// [`GpuError::Limit`] if the arena cannot be that large, [`GpuError::OutOfMemory`].
    pub fn take(&mut self, gpu: &Gpu, label: &'static str, bytes: u64) -> Result<(Range<u64>, bool), GpuError> {
        let bytes = bytes.max(1).next_multiple_of(UNIT);
        let range = match self.ranges.allocate_range(bytes) {
            Ok(range) => range,
            Err(_) => {
                self.grow(gpu, label, bytes)?;
                let full = |_| GpuError::OutOfMemory { what: label.into() };
                self.ranges.allocate_range(bytes).map_err(full)?
            }
        };
        self.taken += bytes;
        self.peak = self.peak.max(self.taken);
        let used = range.start < self.untouched;
        self.untouched = self.untouched.max(range.end);
        Ok((range, used))
    }

    /// Frees a range. No later work may use it.
    pub fn leave(&mut self, range: Range<u64>) {
        self.taken -= range.end - range.start;
        self.ranges.free_range(range);
    }

    /// Moves to a buffer of at least twice the size, with `bytes` more of free memory.
    fn grow(&mut self, gpu: &Gpu, label: &'static str, bytes: u64) -> Result<(), GpuError> {
        let (size, most) = (self.raw.size(), most_bytes(gpu));
        let needs = size + bytes;
        if needs > most {
            let what = format!("{label} among the {} MiB of the members beside it", self.taken >> 20);
            return Err(GpuError::Limit { what, needs, has: most, adapter: gpu.name().into() });
        }
        let grown = (2 * size).max(needs).next_multiple_of(UNIT).min(most);
        let raw = buffer(gpu, grown)?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.raw, 0, &raw, 0, size);
        gpu.submitted(gpu.queue.submit([encoder.finish()]));
        log::debug!("arena: from {size} to {grown} bytes");
        self.raw = raw;
        self.version += 1;
        self.ranges.grow_to(grown);
        Ok(())
    }
}
