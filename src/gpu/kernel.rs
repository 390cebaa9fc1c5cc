//! A compute pipeline, its bindings read from the validated source.
//!
//! Binding 0 may be a uniform: the parameters of one dispatch. The others are storage buffers, in order.

use super::banks::{self, Banked};
use super::device::lock;
use super::{Gpu, GpuError, PipelineReport, Precision, Source};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// A kernel, ready to be dispatched.
pub struct Kernel {
    pub(super) name: String,
    source: Source,
    bindings: Vec<Binding>,
    compiled: Arc<Compiled>,
    /// The same for arrays in so many banks each.
    banked: Mutex<HashMap<Vec<u32>, Arc<Compiled>>>,
    /// Bytes of the parameters, zero where there are none.
    pub(super) parameters: u64,
    pub(super) storages: usize,
    pub(super) workgroup: u32,
}

/// A pipeline and its layout.
pub(super) struct Compiled {
    pub id: u64,
    pub pipeline: wgpu::ComputePipeline,
    pub layout: wgpu::BindGroupLayout,
}

/// What one binding is.
struct Binding {
    name: String,
    number: u32,
    uniform: bool,
    read_only: bool,
    bytes: u64,
    /// Bytes from one element to the next of an array; zero for others.
    stride: u64,
}

/// Parses and validates a source against what every adapter has.
///
/// # Errors
/// What naga says, with the line.
pub(crate) fn validate(source: &Source) -> Result<naga::Module, String> {
    validate_text(source.code(), source.precision())
}

fn validate_text(code: &str, precision: Precision) -> Result<naga::Module, String> {
    let module = naga::front::wgsl::parse_str(code).map_err(|e| e.emit_to_string(code))?;
    let mut capabilities = naga::valid::Capabilities::empty();
    if precision == Precision::F64 {
        capabilities |= naga::valid::Capabilities::FLOAT64;
    }
    naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|e| e.emit_to_string(code))?;
    Ok(module)
}

fn bindings(module: &naga::Module) -> Result<Vec<Binding>, String> {
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).map_err(|e| e.to_string())?;
    let of = |variable: &naga::GlobalVariable| {
        let number = variable.binding.map(|b| b.binding)?;
        let bytes = u64::from(layouter[variable.ty].size);
        let name = variable.name.clone()?;
        let stride = match module.types[variable.ty].inner {
            naga::TypeInner::Array { stride, .. } => u64::from(stride),
            _ => 0,
        };
        match variable.space {
            naga::AddressSpace::Uniform => {
                Some(Binding { name, number, uniform: true, read_only: true, bytes, stride })
            }
            naga::AddressSpace::Storage { access } => {
                let read_only = !access.contains(naga::StorageAccess::STORE);
                Some(Binding { name, number, uniform: false, read_only, bytes, stride })
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
        let refused = |message: String| GpuError::Kernel { kernel: source.name().to_owned(), message };
        gpu.check(source.precision())?;
        let bindings = bindings(&validate(source).map_err(refused)?).map_err(refused)?;
        let compiled = compile(gpu, source.name(), source.code(), &bindings).map_err(refused)?;
        let uniform = bindings.iter().find(|b| b.uniform);
        Ok(Kernel {
            name: source.name().to_owned(),
            parameters: uniform.map_or(0, |b| b.bytes),
            storages: bindings.iter().filter(|b| !b.uniform).count(),
            workgroup: source.workgroup(),
            source: source.clone(),
            bindings,
            compiled: Arc::new(compiled),
            banked: Mutex::default(),
        })
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The pipeline for storage arrays in so many banks each; compiled when it is first asked for.
    pub(super) fn compiled(&self, gpu: &Gpu, banks: &[u32]) -> Result<Arc<Compiled>, GpuError> {
        if banks.iter().all(|banks| *banks <= 1) {
            return Ok(self.compiled.clone());
        }
        if let Some(compiled) = lock(&self.banked).get(banks) {
            return Ok(compiled.clone());
        }
        let compiled = Arc::new(self.compile_banked(gpu, banks)?);
        lock(&self.banked).insert(banks.to_vec(), compiled.clone());
        Ok(compiled)
    }

    fn compile_banked(&self, gpu: &Gpu, banks: &[u32]) -> Result<Compiled, GpuError> {
        let refused = |message: String| GpuError::Kernel { kernel: self.name.clone(), message };
        let (needs, has) = (banks.iter().sum(), gpu.limits.max_storage_buffers_per_shader_stage);
        if needs > has {
            let (kernel, adapter) = (self.name.clone(), gpu.name().to_owned());
            return Err(GpuError::Bindings { kernel, needs, has, adapter });
        }
        let storages: Vec<&Binding> = self.bindings.iter().filter(|b| !b.uniform).collect();
        let mut arrays = Vec::new();
        for (binding, banks) in storages.iter().zip(banks).filter(|(_, banks)| **banks > 1) {
            if binding.stride == 0 || !gpu.bank_bytes().is_multiple_of(binding.stride) {
                return Err(refused(format!("{} cannot be split", binding.name)));
            }
            let elements = gpu.bank_bytes() / binding.stride;
            arrays.push(Banked { name: binding.name.clone(), banks: *banks, elements, writable: !binding.read_only });
        }
        let names: Vec<String> = storages.iter().map(|b| b.name.clone()).collect();
        let first = u32::from(self.parameters > 0);
        let code = banks::rewrite(self.source.code(), first, &names, &arrays);
        let bindings = bindings(&validate_text(&code, self.source.precision()).map_err(refused)?).map_err(refused)?;
        compile(gpu, &self.name, &code, &bindings).map_err(refused)
    }
}

fn compile(gpu: &Gpu, name: &str, code: &str, bindings: &[Binding]) -> Result<Compiled, String> {
    let begun = Instant::now();
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
    let made = gpu.scoped(name, || {
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries });
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(code.into()),
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
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
    let (layout, pipeline) = made.map_err(|e| e.to_string())?;
    if gpu.compiles_at_once() {
        use_once(gpu, name, &layout, &pipeline, bindings).map_err(|e| e.to_string())?;
    }
    let seconds = begun.elapsed().as_secs_f64();
    lock(&gpu.pipelines).push(PipelineReport { name: name.to_owned(), seconds });
    Ok(Compiled { id: gpu.new_id(), pipeline, layout })
}

/// Dispatches one workgroup with parameters and buffers of zeros, and waits: the driver has compiled it then.
fn use_once(
    gpu: &Gpu,
    name: &str,
    layout: &wgpu::BindGroupLayout,
    pipeline: &wgpu::ComputePipeline,
    bindings: &[Binding],
) -> Result<(), GpuError> {
    /// Enough for what a kernel binds beside arrays whose length it is told.
    const BYTES: u64 = 4096;
    gpu.scoped(name, || {
        let buffer = |b: &Binding| {
            let usage = if b.uniform { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE };
            let size = b.bytes.max(BYTES).next_multiple_of(16);
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(name),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let buffers: Vec<wgpu::Buffer> = bindings.iter().map(buffer).collect();
        let entries: Vec<_> = bindings
            .iter()
            .zip(&buffers)
            .map(|(b, buffer)| {
                let size = std::num::NonZeroU64::new(if b.uniform { b.bytes } else { buffer.size() });
                let resource = wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size });
                wgpu::BindGroupEntry { binding: b.number, resource }
            })
            .collect();
        let descriptor = wgpu::BindGroupDescriptor { label: Some(name), layout, entries: &entries };
        let group = gpu.device.create_bind_group(&descriptor);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        let offsets: &[u32] = if bindings.iter().any(|b| b.uniform) { &[0] } else { &[] };
        pass.set_bind_group(0, &group, offsets);
        pass.dispatch_workgroups(1, 1, 1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    })?;
    gpu.wait()
}
