//! The choice of the CPU or a device for a study, from the arguments.

use super::arguments::{Arguments, Backend, Precision as Wanted};
use super::fault::LabError;
use super::output;
use relcp::gpu::{AdapterReport, Choice, GpuError, Precision, adapters};
use relcp::scene::Scene;
use relcp::simulation::Compute;

/// Sets the number of threads. The default is one per core.
pub fn set_threads(arguments: &Arguments) -> Result<(), LabError> {
    if let Some(threads) = arguments.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        pool.map_err(|e| LabError::Usage(format!("cannot start {threads} threads: {e}")))?;
    }
    Ok(())
}

/// Returns the adapter choice of the arguments.
pub fn choice(arguments: &Arguments) -> Choice {
    Choice { name: arguments.adapter.clone(), software: arguments.backend == Backend::Gpu, ..Choice::default() }
}

/// Returns the backend for many concurrent runs: with `auto` the CPU, whose cores they share.
pub fn settle_many(arguments: &Arguments, scene: &Scene) -> Result<Compute, LabError> {
    match arguments.backend {
        Backend::Auto | Backend::Cpu => cpu(arguments),
        Backend::Gpu => Ok(open(arguments, scene)?),
    }
}

/// Returns the backend that is measured in addition to the CPU: with `auto` a suitable hardware device, if there is
/// one. Returns `None` if only the CPU is measured.
pub fn beside_the_cpu(arguments: &Arguments, scene: &Scene) -> Result<Option<Compute>, LabError> {
    match arguments.backend {
        Backend::Cpu => cpu(arguments).map(|_| None),
        Backend::Gpu => Ok(Some(open(arguments, scene)?)),
        Backend::Auto => {
            let Some(adapter) = hardware(arguments) else { return cpu(arguments).map(|_| None) };
            open(arguments, scene).map(Some).or_else(|fault| {
                output::message_once(&format!("{} is not used: {fault}", adapter.name));
                cpu(arguments).map(|_| None)
            })
        }
    }
}

/// Returns the CPU, if it supports all options.
pub fn cpu(arguments: &Arguments) -> Result<Compute, LabError> {
    if arguments.precision == Some(Wanted::F32) {
        return Err(LabError::Usage("the CPU computes in f64; omit --precision, or use --backend gpu".into()));
    }
    if arguments.adapter.is_some() {
        return Err(LabError::Usage(
            "--adapter names a device, and this run is computed on the CPU; say --backend gpu".into(),
        ));
    }
    Ok(Compute::Cpu)
}

/// Returns the first suitable hardware adapter.
fn hardware(arguments: &Arguments) -> Option<AdapterReport> {
    adapters(&choice(arguments)).into_iter().find(|adapter| adapter.taken && adapter.is_hardware())
}

fn open(arguments: &Arguments, scene: &Scene) -> Result<Compute, GpuError> {
    let precision = arguments.precision.map(|wanted| match wanted {
        Wanted::F32 => Precision::F32,
        Wanted::F64 => Precision::F64,
    });
    let compute = Compute::open_in(&choice(arguments), precision, scene)?;
    if let Compute::Gpu { gpu, .. } = &compute {
        for warning in gpu.warnings() {
            output::message_once(&format!("warning: {warning}"));
        }
    }
    Ok(compute)
}
