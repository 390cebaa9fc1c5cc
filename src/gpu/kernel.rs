//! A compute pipeline. Its bindings come from the validated source.
//!
//! Binding 0 may be a uniform: the parameters of one dispatch. All other bindings are storage buffers, bound by the
//! names of their variables. A source need not number them.

use super::banks::{self, Banked};
use super::ensemble::Pipeline;
use super::lock::lock;
use super::{Buffer, Gpu, GpuError, PipelineReport, Precision, Source};
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// A kernel, ready to be dispatched.
#[derive(Clone)]
pub struct Kernel {
    pub(super) name: String,
    module: Arc<naga::Module>,
    precision: Precision,
    bindings: Arc<[Binding]>,
    pub(super) runs: Runs,
    /// The pipelines for arrays in several banks, by the banks of each array.
    banked: Arc<Mutex<HashMap<Vec<u32>, Arc<Compiled>>>>,
    /// Bytes of the parameters; zero for a kernel without parameters.
    pub(super) parameters: u64,
    pub(super) workgroup: u32,
}

/// The compiled forms of a kernel.
#[derive(Clone)]
pub(super) enum Runs {
    /// For a device that is not a member of an ensemble.
    Alone(Arc<Compiled>),
    /// For the members of an ensemble.
    Together(Arc<Pipeline>),
}

/// A pipeline and its layout.
pub(super) struct Compiled {
    pub id: u64,
    pub pipeline: wgpu::ComputePipeline,
    pub layout: wgpu::BindGroupLayout,
}

/// A bound variable.
pub(super) struct Binding {
    pub name: String,
    number: u32,
    pub uniform: bool,
    pub ty: naga::Handle<naga::Type>,
    read_only: bool,
    bytes: u64,
    /// Bytes from one element of an array to the next; zero for other types.
    stride: u64,
}

/// Parses a source, and validates it with the capabilities that every adapter has, plus 64-bit floats if the source
/// uses them.
///
/// # Errors
/// naga's message with the line.
pub(crate) fn validate(source: &Source) -> Result<naga::Module, String> {
    let code = source.code();
    let mut module = naga::front::wgsl::parse_str(code).map_err(|e| e.emit_to_string(code))?;
    number(&mut module);
    check(&module, source.precision(), code)?;
    Ok(module)
}

/// Numbers the variables of a source without binding numbers in order, the parameters first.
fn number(module: &mut naga::Module) {
    if module.global_variables.iter().any(|(_, variable)| variable.binding.is_some()) {
        return;
    }
    let is_uniform = |variable: &naga::GlobalVariable| variable.space == naga::AddressSpace::Uniform;
    let mut next = u32::from(module.global_variables.iter().any(|(_, variable)| is_uniform(variable)));
    for (_, variable) in module.global_variables.iter_mut() {
        let binding = if is_uniform(variable) { 0 } else { next };
        if is_uniform(variable) || matches!(variable.space, naga::AddressSpace::Storage { .. }) {
            variable.binding = Some(naga::ResourceBinding { group: 0, binding });
            next += u32::from(binding > 0 || !is_uniform(variable));
        }
    }
}

/// Validates a module; `code` is its source text, for messages.
pub(super) fn check(
    module: &naga::Module,
    precision: Precision,
    code: &str,
) -> Result<naga::valid::ModuleInfo, String> {
    let mut capabilities = naga::valid::Capabilities::empty();
    if precision == Precision::F64 {
        capabilities |= naga::valid::Capabilities::FLOAT64;
    }
    let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities);
    validator.validate(module).map_err(|e| e.emit_to_string(code))
}

/// The bound variables of a module, in the order of their numbers.
pub(super) fn bindings(module: &naga::Module) -> Result<Vec<Binding>, String> {
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).map_err(|e| e.to_string())?;
    let of = |variable: &naga::GlobalVariable| {
        let (number, ty) = (variable.binding.map(|b| b.binding)?, variable.ty);
        let bytes = u64::from(layouter[variable.ty].size);
        let name = variable.name.clone()?;
        let stride = match module.types[variable.ty].inner {
            naga::TypeInner::Array { stride, .. } => u64::from(stride),
            _ => 0,
        };
        let (uniform, read_only) = match variable.space {
            naga::AddressSpace::Uniform => (true, true),
            naga::AddressSpace::Storage { access } => (false, !access.contains(naga::StorageAccess::STORE)),
            _ => return None,
        };
        Some(Binding { name, number, uniform, ty, read_only, bytes, stride })
    };
    let mut found: Vec<Binding> = module.global_variables.iter().filter_map(|(_, v)| of(v)).collect();
    found.sort_by_key(|b| b.number);
    Ok(found)
}

impl Kernel {
    /// Validates and compiles a source, unless the device already has its kernel.
    ///
    /// # Errors
    /// [`GpuError::Kernel`] with the position in the source.
    pub fn new(gpu: &Gpu, source: &Source) -> Result<Self, GpuError> {
        let refused = |message: String| GpuError::Kernel { kernel: source.name().to_owned(), message };
        gpu.check(source.precision())?;
        if let Some(member) = &gpu.member {
            let make = || Kernel::compile(member.device(), source, true).map_err(refused);
            return member.core().kernels().kernel(source, make);
        }
        gpu.kernels.kernel(source, || Kernel::compile(gpu, source, false).map_err(refused))
    }

    fn compile(gpu: &Gpu, source: &Source, together: bool) -> Result<Self, String> {
        let smaller = source.on_software().filter(|_| gpu.is_software());
        let source = smaller.as_ref().unwrap_or(source);
        let module = validate(source)?;
        let bindings = bindings(&module)?;
        let runs = match together {
            true => {
                let info = check(&module, source.precision(), source.code())?;
                Runs::Together(Arc::new(Pipeline::new(gpu, source.name(), &module, &info)?))
            }
            false => Runs::Alone(Arc::new(compile(gpu, source.name(), module.clone(), &bindings)?)),
        };
        let uniform = bindings.iter().find(|b| b.uniform);
        Ok(Kernel {
            name: source.name().to_owned(),
            parameters: uniform.map_or(0, |b| b.bytes),
            workgroup: source.workgroup(),
            module: Arc::new(module),
            precision: source.precision(),
            bindings: bindings.into(),
            runs,
            banked: Arc::default(),
        })
    }

    pub(super) fn module(&self) -> &naga::Module {
        &self.module
    }

    /// Whether no other owner has this kernel.
    pub(super) fn is_idle(&self) -> bool {
        Arc::strong_count(&self.banked) == 1
    }

    /// The storage variables, in the order of their bindings.
    fn storages(&self) -> impl ExactSizeIterator<Item = &Binding> {
        self.bindings[usize::from(self.parameters > 0)..].iter()
    }

    /// Checks the number of bytes of parameters and the number of buffers.
    ///
    /// # Errors
    /// [`GpuError::Kernel`] with the expected numbers.
    pub(super) fn check_counts(&self, parameters: &[u8], buffers: &[&Buffer]) -> Result<(), GpuError> {
        let (got, needed) = (parameters.len() as u64, self.parameters);
        if got != needed {
            return Err(self.refused(format!("it takes {needed} bytes of parameters and was given {got}")));
        }
        match (self.storages().nth(buffers.len()), buffers.len() > self.storages().len()) {
            (Some(binding), _) => Err(self.refused(format!("its variable {} was given no buffer", binding.name))),
            (None, true) => Err(self.refused("a buffer was bound to no variable of it".into())),
            (None, false) => Ok(()),
        }
    }

    /// Checks that buffers, in the order of their bindings, match their variables.
    ///
    /// # Errors
    /// [`GpuError::Kernel`] for a buffer that is too small, or whose element size does not match the array.
    pub(super) fn check_sizes(&self, buffers: &[&Buffer]) -> Result<(), GpuError> {
        for (binding, buffer) in self.storages().zip(buffers) {
            let (name, label, element) = (&binding.name, buffer.label(), buffer.element() as u64);
            if binding.stride > 0 && !element.is_multiple_of(binding.stride) {
                let stride = binding.stride;
                let sizes = format!("elements of {stride} bytes, the buffer \"{label}\" has elements of {element}");
                return Err(self.refused(format!("its array {name} has {sizes}")));
            }
            if buffer.bytes() < binding.bytes {
                let (needs, has) = (binding.bytes, buffer.bytes());
                let sizes = format!("{needs} bytes, the buffer \"{label}\" has {has}");
                return Err(self.refused(format!("its variable {name} takes {sizes}")));
            }
        }
        Ok(())
    }

    fn refused(&self, message: String) -> GpuError {
        GpuError::Kernel { kernel: self.name.clone(), message }
    }

    /// The pipeline for these numbers of banks of each storage array, compiled at its first use.
    pub(super) fn compiled(&self, gpu: &Gpu, banks: &[u32]) -> Result<Arc<Compiled>, GpuError> {
        if banks.iter().all(|banks| *banks <= 1) {
            return match &self.runs {
                Runs::Alone(compiled) => Ok(compiled.clone()),
                Runs::Together(_) => Err(self.refused("it is an ensemble's".into())),
            };
        }
        if let Some(compiled) = lock(&self.banked).get(banks) {
            return Ok(compiled.clone());
        }
        let compiled = Arc::new(self.compile_banked(gpu, banks)?);
        lock(&self.banked).insert(banks.to_vec(), compiled.clone());
        Ok(compiled)
    }

    fn compile_banked(&self, gpu: &Gpu, banks: &[u32]) -> Result<Compiled, GpuError> {
        let refused = |message: String| self.refused(message);
        let (needs, has) = (banks.iter().sum(), gpu.limits.max_storage_buffers_per_shader_stage);
        if needs > has {
            let (kernel, adapter) = (self.name.clone(), gpu.name().to_owned());
            return Err(GpuError::Bindings { kernel, needs, has, adapter });
        }
        let mut arrays = Vec::new();
        for (binding, banks) in self.storages().zip(banks).filter(|(_, banks)| **banks > 1) {
            if binding.stride == 0 || !gpu.bank_bytes().is_multiple_of(binding.stride) {
                return Err(refused(format!("{} cannot be split", binding.name)));
            }
            let elements = gpu.bank_bytes() / binding.stride;
            arrays.push(Banked { name: binding.name.clone(), banks: *banks, elements });
        }
        let info = check(&self.module, self.precision, "").map_err(refused)?;
        let mut module = (*self.module).clone();
        banks::split(&mut module, &info, &arrays).map_err(refused)?;
        check(&module, self.precision, "").map_err(refused)?;
        let bindings = bindings(&module).map_err(refused)?;
        compile(gpu, &self.name, module, &bindings).map_err(refused)
    }
}

/// The pipeline of a module.
pub(super) fn pipeline(
    gpu: &Gpu,
    name: &str,
    module: naga::Module,
    layout: &wgpu::BindGroupLayout,
) -> wgpu::ComputePipeline {
    let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    });
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(name),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            zero_initialize_workgroup_memory: false,
            ..Default::default()
        },
        cache: None,
    })
}

fn compile(gpu: &Gpu, name: &str, module: naga::Module, bindings: &[Binding]) -> Result<Compiled, String> {
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
        let pipeline = pipeline(gpu, name, module, &layout);
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

/// Dispatches one workgroup with zeros as parameters and buffers, and waits, so that the driver compiles the kernel.
fn use_once(
    gpu: &Gpu,
    name: &str,
    layout: &wgpu::BindGroupLayout,
    pipeline: &wgpu::ComputePipeline,
    bindings: &[Binding],
) -> Result<(), GpuError> {
    /// Large enough for every variable except arrays whose length is a parameter.
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
