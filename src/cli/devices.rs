//! `relcp devices`: the adapters of this machine.

use super::arguments::Devices;
use super::exit::{CliError, Exit};
use super::output;
use relcp::gpu::{AdapterReport, Choice, adapters};
use serde_json::json;

pub(super) fn devices(arguments: &Devices) -> Result<Exit, CliError> {
    let found = adapters(&Choice { name: arguments.adapter.clone(), software: true, ..Choice::default() });
    if arguments.print.json {
        output::json(&json!({ "adapters": found }))?;
    } else if !arguments.print.quiet {
        output::write(|out| {
            if found.is_empty() {
                writeln!(
                    out,
                    "no adapter: no Vulkan, Metal or DirectX 12 driver was found; runs are computed on the CPU"
                )?;
            }
            for adapter in &found {
                let AdapterReport { name, kind, interface, driver, .. } = adapter;
                writeln!(out, "{name}\n  {kind}, {interface}, driver {driver}")?;
                let has = |yes: bool| if yes { "yes" } else { "no" };
                let mib = |bytes: u64| bytes >> 20;
                let (buffer, binding) = (mib(adapter.max_buffer), mib(adapter.max_binding));
                writeln!(out, "  largest buffer {buffer} MiB, largest binding {binding} MiB")?;
                let (buffers, group) = (adapter.storage_buffers, adapter.workgroup);
                writeln!(out, "  {buffers} storage buffers a kernel, {group} invocations a workgroup")?;
                writeln!(out, "  f64 {}, timestamps {}", has(adapter.f64), has(adapter.timestamps))?;
                writeln!(out, "  {}", verdict(adapter))?;
            }
            match found.is_empty() {
                true => Ok(()),
                false => writeln!(out, "without --backend gpu, runs are computed on the CPU"),
            }
        })?;
    }
    Ok(if found.iter().any(|adapter| adapter.taken) { Exit::Done } else { Exit::Device })
}

fn verdict(adapter: &AdapterReport) -> String {
    if !adapter.lacks.is_empty() {
        return format!("cannot be used: {}", adapter.lacks.join("; "));
    }
    match (adapter.taken, adapter.is_hardware()) {
        (true, true) => "used by --backend gpu".into(),
        (true, false) => "used by --backend gpu; a software adapter is slower than the CPU backend".into(),
        (false, _) => "not used unless named with --adapter: another one comes first".into(),
    }
}
