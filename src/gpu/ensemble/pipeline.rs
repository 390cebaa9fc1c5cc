//! A compiled merged kernel and its bindings.

use super::merge::{self, HEAD};
use super::tables::Tables;
use crate::gpu::lock::lock;
use crate::gpu::{Gpu, GpuError};
use std::sync::Mutex;

/// The largest number of members that one dispatch serves. It fills a device, and the rows of a dispatch fit in one
/// binding.
pub(super) const MOST_TOGETHER: usize = 256;

/// Every adapter accepts multiples of this as the offsets of a dispatch's rows and parameters.
pub(super) const ALIGNMENT: usize = 256;

/// The versions of the arena, the table and the parameters for which a bind group was created.
type Version = [u64; 3];

/// A buffer at a binding: its first `size` bytes, or all of it.
pub(super) fn part(binding: u32, buffer: &wgpu::Buffer, size: Option<u64>) -> wgpu::BindGroupEntry<'_> {
    let size = size.and_then(std::num::NonZeroU64::new);
    let resource = wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size });
    wgpu::BindGroupEntry { binding, resource }
}

/// A merged kernel, ready to be dispatched.
pub(in crate::gpu) struct Pipeline {
    pub id: u64,
    name: String,
    pub pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    /// Bytes of one element of each array.
    pub strides: Vec<u64>,
    /// Bytes of one member's parameters.
    pub parameters: Option<u64>,
    group: Mutex<Option<(Version, wgpu::BindGroup)>>,
}

impl Pipeline {
    /// Merges and compiles a kernel.
    ///
    /// # Errors
    /// An error of the device or in the kernel.
    pub fn new(gpu: &Gpu, name: &str, module: &naga::Module, info: &naga::valid::ModuleInfo) -> Result<Self, String> {
        let merged = merge::merged(module, info)?;
        let arrays = merged.strides.len() as u32;
        let storages = arrays + 2 + u32::from(merged.parameters.is_some());
        let most = gpu.limits.max_storage_buffers_per_shader_stage;
        if storages > most {
            return Err(format!("an ensemble binds {storages} storage buffers to it, and the adapter has {most}"));
        }
        let entry = |binding, read_only, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only },
                has_dynamic_offset,
                min_binding_size: None,
            },
            count: None,
        };
        let mut entries = vec![entry(0, true, true)];
        entries.extend((1..=arrays + 1).map(|binding| entry(binding, false, false)));
        entries.extend(merged.parameters.map(|_| entry(arrays + 2, true, true)));
        let layout = wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries };
        let module = merged.module;
        let made = gpu.scoped(name, || {
            let layout = gpu.device.create_bind_group_layout(&layout);
            let pipeline = crate::gpu::kernel::pipeline(gpu, name, module, &layout);
            (layout, pipeline)
        });
        let (layout, pipeline) = made.map_err(|e| e.to_string())?;
        let (strides, parameters) = (merged.strides, merged.parameters);
        Ok(Pipeline {
            id: gpu.new_id(),
            name: name.into(),
            pipeline,
            layout,
            strides,
            parameters,
            group: Mutex::default(),
        })
    }

    /// The number of words of a member's row.
    pub fn row_words(&self) -> usize {
        HEAD + self.strides.len()
    }

    /// The beginnings of a member's arrays, in elements.
    ///
    /// # Errors
    /// [`GpuError::Kernel`] if one is not at a whole element.
    pub fn begins(&self, bytes: impl Iterator<Item = u64>) -> Result<Vec<u32>, GpuError> {
        let begin = |(at, stride): (u64, &u64)| {
            let whole = at.is_multiple_of(*stride).then(|| u32::try_from(at / stride).ok()).flatten();
            let message = || format!("a member's array cannot begin at byte {at}, with elements of {stride}");
            whole.ok_or_else(|| GpuError::Kernel { kernel: self.name.clone(), message: message() })
        };
        bytes.zip(&self.strides).map(begin).collect()
    }

    /// The bind group. It is created again after the arena or a table has grown.
    pub(super) fn group(&self, gpu: &Gpu, arena: (&wgpu::Buffer, u64), tables: &Tables) -> wgpu::BindGroup {
        let version = [arena.1, tables.rows.version(), tables.parameters.version()];
        let mut known = lock(&self.group);
        if let Some((_, group)) = known.as_ref().filter(|(of, _)| *of == version) {
            return group.clone();
        }
        let rows = (4 * self.row_words() * MOST_TOGETHER) as u64;
        let arrays = self.strides.len() as u32;
        let mut entries = vec![part(0, tables.rows.raw(), Some(rows))];
        entries.extend((1..=arrays + 1).map(|binding| part(binding, arena.0, None)));
        let parameters = self.parameters.map(|bytes| bytes * MOST_TOGETHER as u64);
        entries.extend(parameters.map(|bytes| part(arrays + 2, tables.parameters.raw(), Some(bytes))));
        let descriptor = wgpu::BindGroupDescriptor { label: Some(&self.name), layout: &self.layout, entries: &entries };
        let group = gpu.device.create_bind_group(&descriptor);
        *known = Some((version, group.clone()));
        group
    }
}
