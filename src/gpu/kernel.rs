//! A compute pipeline, its bindings read from the validated source.
//!
//! Binding 0 may be a uniform: the parameters of one dispatch. The others are storage buffers, in order.

use super::device::{PipelineReport, lock};
use super::{Gpu, GpuError, Source};
use std::time::Instant;

/// A kernel, ready to be dispatched.
pub struct Kernel {
    pub(super) name: String,
    pub(super) id: u64,
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    /// Bytes of the parameters, zero where there are none.
    pub(super) parameters: u64,
    pub(super) storages: usize,
    pub(super) workgroup: u32,
}

/// What one binding is.
struct Binding {
    number: u32,
    uniform: bool,
    read_only: bool,
    bytes: u64,
}

/// Parses and validates a source against what every adapter has.
///
/// # Errors
/// What naga says, with the line.
pub(crate) fn validate(source: &Source) -> Result<naga::Module, String> {
    let module = naga::front::wgsl::parse_str(source.code()).map_err(|e| e.emit_to_string(source.code()))?;
    let mut capabilities = naga::valid::Capabilities::empty();
    if source.precision() == super::Precision::F64 {
        capabilities |= naga::valid::Capabilities::FLOAT64;
    }
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|e| e.emit_to_string(source.code()))?;
    Ok(module)
}

fn bindings(module: &naga::Module) -> Result<Vec<Binding>, String> {
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).map_err(|e| e.to_string())?;
    let of = |variable: &naga::GlobalVariable| {
        let number = variable.binding.map(|b| b.binding)?;
        let bytes = u64::from(layouter[variable.ty].size);
        match variable.space {
            naga::AddressSpace::Uniform => Some(Binding { number, uniform: true, read_only: true, bytes }),
            naga::AddressSpace::Storage { access } => {
                let read_only = !access.contains(naga::StorageAccess::STORE);
                Some(Binding { number, uniform: false, read_only, bytes })
            }
            _ => None,
        }
    };
    let mut found: Vec<Binding> = module.global_variables.iter().filter_map(|(_, v)| of(v)).collect();
    found.sort_by_key(|b| b.number);
    Ok(found)
}

impl Kernel {
    /// Validates and compiles a source.
    ///
    /// # Errors
    /// [`GpuError::Kernel`] with the place in the source.
    pub fn new(gpu: &Gpu, source: &Source) -> Result<Self, GpuError> {
        let begun = Instant::now();
        let refused = |message: String| GpuError::Kernel { kernel: source.name().to_owned(), message };
        gpu.check(source.precision())?;
        let module = validate(source).map_err(refused)?;
        let bindings = bindings(&module).map_err(refused)?;
        let entries: Vec<wgpu::BindGroupLayoutEntry> = bindings
            .iter()
            .map(|b| wgpu::BindGroupLayoutEntry {
                binding: b.number,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: match b.uniform {
                        true => wgpu::BufferBindingType::Uniform,
                        false => wgpu::BufferBindingType::Storage { read_only: b.read_only },
                    },
                    has_dynamic_offset: b.uniform,
                    min_binding_size: std::num::NonZeroU64::new(if b.uniform { b.bytes } else { 0 }),
                },
                count: None,
            })
            .collect();
        let made = gpu.scoped(source.name(), || {
            let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(source.name()),
                entries: &entries,
            });
            let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(source.name()),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(source.name()),
                source: wgpu::ShaderSource::Wgsl(source.code().into()),
            });
            let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(source.name()),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..Default::default()
                },
                cache: None,
            });
            (layout, pipeline)
        });
        let (layout, pipeline) = made.map_err(|e| refused(e.to_string()))?;
        let seconds = begun.elapsed().as_secs_f64();
        lock(&gpu.pipelines).push(PipelineReport { name: source.name().to_owned(), seconds });
        let uniform = bindings.iter().find(|b| b.uniform);
        Ok(Kernel {
            name: source.name().to_owned(),
            id: gpu.new_id(),
            pipeline,
            layout,
            parameters: uniform.map_or(0, |b| b.bytes),
            storages: bindings.iter().filter(|b| !b.uniform).count(),
            workgroup: source.workgroup(),
        })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }
}
