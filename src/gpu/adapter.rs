//! The list of adapters and the choice of one.

use super::choice::SOFTWARE;
use super::{AdapterReport, Choice, GpuError};

pub(super) fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    // Our own kernels write the indirect dispatches; the validation of each costs 20 times as much as the dispatch.
    descriptor.flags = wgpu::InstanceFlags::empty();
    wgpu::Instance::new(descriptor)
}

fn kind(info: &wgpu::AdapterInfo) -> &'static str {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => "discrete",
        wgpu::DeviceType::IntegratedGpu => "integrated",
        wgpu::DeviceType::VirtualGpu => "virtual",
        wgpu::DeviceType::Cpu => SOFTWARE,
        wgpu::DeviceType::Other => "other",
    }
}

/// The rank of an adapter: better ones first.
fn rank(info: &wgpu::AdapterInfo) -> u8 {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

pub(super) fn is_software(info: &wgpu::AdapterInfo) -> bool {
    info.device_type == wgpu::DeviceType::Cpu
}

pub(super) fn driver(info: &wgpu::AdapterInfo) -> String {
    format!("{} {}", info.driver, info.driver_info).trim().to_owned()
}

/// All adapters, better ones first; equal ones in the system's order.
fn listed(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters
}

/// The limits that every kernel needs and the adapter does not meet.
fn lacks(adapter: &wgpu::Adapter) -> Vec<String> {
    let mut lacks = Vec::new();
    let wanted = wgpu::Limits::default();
    let has = adapter.limits();
    wanted.check_limits_with_fail_fn(&has, false, |name, wanted, has| {
        // relcp draws nothing with the device, so limits of textures and render passes do not matter.
        let compute = ["compute", "storage_buffer", "buffer_size", "bind_groups", "uniform_buffer", "bindings_per"];
        if compute.iter().any(|part| name.contains(part)) {
            lacks.push(format!("{name}: {has}, not {wanted}"));
        }
    });
    lacks
}

/// The first adapter that fits the choice.
pub(super) fn find(instance: &wgpu::Instance, choice: &Choice) -> Result<wgpu::Adapter, GpuError> {
    pick(&listed(instance), choice)
}

/// The first of these adapters that fits the choice.
fn pick(all: &[wgpu::Adapter], choice: &Choice) -> Result<wgpu::Adapter, GpuError> {
    let fits = |adapter: &&wgpu::Adapter| {
        let info = adapter.get_info();
        let named = choice.name.as_ref().is_none_or(|n| info.name.to_lowercase().contains(&n.to_lowercase()));
        named && (choice.software || !is_software(&info)) && lacks(adapter).is_empty()
    };
    if let Some(adapter) = all.iter().find(fits) {
        return Ok(adapter.clone());
    }
    let found: Vec<String> = all.iter().map(|adapter| described(adapter, choice)).collect();
    Err(GpuError::NoAdapter {
        wanted: choice.name.as_ref().map_or_else(String::new, |name| format!(" named {name}")),
        found: if found.is_empty() { "none".into() } else { found.join("; ") },
    })
}

fn described(adapter: &wgpu::Adapter, choice: &Choice) -> String {
    let info = adapter.get_info();
    let lacks = lacks(adapter);
    let why = if !lacks.is_empty() {
        format!(" (too small: {})", lacks.join(", "))
    } else if is_software(&info) && !choice.software {
        return format!("{} (software, taken only on request)", info.name);
    } else {
        String::new()
    };
    format!("{} ({}){why}", info.name, kind(&info))
}

/// All adapters of this machine, with a flag for the one that would be used.
pub fn adapters(choice: &Choice) -> Vec<AdapterReport> {
    let all = listed(&instance());
    let taken = pick(&all, &Choice { software: true, ..choice.clone() }).ok().map(|adapter| adapter.get_info());
    let report = |adapter: &wgpu::Adapter| {
        let (info, limits, features) = (adapter.get_info(), adapter.limits(), adapter.features());
        AdapterReport {
            kind: kind(&info),
            interface: format!("{:?}", info.backend),
            driver: driver(&info),
            f64: features.contains(wgpu::Features::SHADER_F64),
            timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
            max_buffer: limits.max_buffer_size,
            max_binding: limits.max_storage_buffer_binding_size,
            storage_buffers: limits.max_storage_buffers_per_shader_stage,
            workgroup: limits.max_compute_invocations_per_workgroup,
            lacks: lacks(adapter),
            taken: taken.as_ref() == Some(&info),
            name: info.name,
        }
    };
    all.iter().map(report).collect()
}
