//! The buffers that the host fills again in each round.

use crate::gpu::{Gpu, GpuError};

/// A buffer that the host fills again in each round.
pub(super) struct Table {
    label: &'static str,
    usage: wgpu::BufferUsages,
    raw: wgpu::Buffer,
    version: u64,
}

/// Bytes of a new table.
const FIRST_BYTES: u64 = 1 << 16;

impl Table {
    fn new(gpu: &Gpu, label: &'static str, usage: wgpu::BufferUsages) -> Result<Self, GpuError> {
        let raw = Table::buffer(gpu, label, usage, FIRST_BYTES)?;
        Ok(Table { label, usage, raw, version: 0 })
    }

    fn buffer(gpu: &Gpu, label: &'static str, usage: wgpu::BufferUsages, size: u64) -> Result<wgpu::Buffer, GpuError> {
        let usage =
            usage | if usage.contains(wgpu::BufferUsages::MAP_READ) { usage } else { wgpu::BufferUsages::COPY_DST };
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        gpu.scoped(label, || gpu.device.create_buffer(&descriptor))
    }

    pub fn raw(&self) -> &wgpu::Buffer {
        &self.raw
    }

    pub fn version(&self) -> u64 {
        self.version
    }

    pub fn reserve(&mut self, gpu: &Gpu, bytes: u64) -> Result<(), GpuError> {
        if bytes > self.raw.size() {
            self.raw = Table::buffer(gpu, self.label, self.usage, bytes.next_power_of_two())?;
            self.version += 1;
        }
        Ok(())
    }
}

/// The tables of an ensemble.
pub(super) struct Tables {
    /// The members' rows of each dispatch.
    pub rows: Table,
    /// The parameters of each dispatch.
    pub parameters: Table,
    /// The bytes that members write.
    pub upload: Table,
    /// An intermediate buffer for copies: a buffer cannot be copied to itself.
    pub scratch: Table,
    /// The bytes that members read.
    pub staging: Table,
    /// The writes, copies and clears that a kernel executes.
    pub pieces: Table,
}

impl Tables {
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let table = |label, usage| Table::new(gpu, label, usage);
        Ok(Tables {
            rows: table("members", wgpu::BufferUsages::STORAGE)?,
            parameters: table("members' parameters", wgpu::BufferUsages::STORAGE)?,
            upload: table("members' writes", wgpu::BufferUsages::COPY_SRC)?,
            scratch: table("members' copies", wgpu::BufferUsages::COPY_SRC)?,
            staging: table("members' read-back", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST)?,
            pieces: table("members' pieces", wgpu::BufferUsages::STORAGE)?,
        })
    }
}
