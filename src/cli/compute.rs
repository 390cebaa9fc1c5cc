//! What computes a run: the CPU or a device, as the arguments say.

use super::arguments::{Backend, Compute as Arguments, Precision as Wanted};
use super::exit::CliError;
use super::output;
use relcp::gpu::{AdapterReport, Choice, GpuError, Precision, adapters};
use relcp::scene::Scene;
use relcp::simulation::Compute;
use std::sync::OnceLock;

/// Settles how many threads there are.
pub(super) fn set_threads(arguments: &Arguments) -> Result<(), CliError> {
    set_thread_count(arguments.threads)
}

/// Settles how many threads there are; without a number, one a core.
pub(super) fn set_thread_count(threads: Option<u16>) -> Result<(), CliError> {
    if let Some(threads) = threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        pool.map_err(|e| CliError::Usage(format!("{threads} threads cannot be had: {e}")))?;
    }
    Ok(())
}

/// The adapter that the arguments ask for.
pub(super) fn choice(arguments: &Arguments) -> Choice {
    Choice { name: arguments.adapter.clone(), software: arguments.backend == Backend::Gpu, ..Choice::default() }
}

/// Settles what computes a scene, and says so where it is not what one might expect.
pub(super) fn settle(arguments: &Arguments, scene: &Scene) -> Result<Compute, CliError> {
    match arguments.backend {
        Backend::Cpu => cpu(arguments),
        Backend::Gpu => open(arguments, scene).map_err(CliError::from),
        Backend::Auto => automatic(arguments, scene),
    }
}

/// The CPU, if nothing is asked for that it has not.
pub(super) fn cpu(arguments: &Arguments) -> Result<Compute, CliError> {
    if arguments.precision == Some(Wanted::F32) {
        return Err(CliError::Usage("the CPU computes in f64; leave --precision out, or say --backend gpu".into()));
    }
    if arguments.adapter.is_some() {
        return Err(CliError::Usage(
            "--adapter names a device, and this run is computed on the CPU; say --backend gpu".into(),
        ));
    }
    Ok(Compute::Cpu)
}

/// A hardware GPU if there is one that can do it, else the CPU. What was asked for beside it is not given up silently.
fn automatic(arguments: &Arguments, scene: &Scene) -> Result<Compute, CliError> {
    // Looked for once, also where there are many runs.
    static HARDWARE: OnceLock<Option<AdapterReport>> = OnceLock::new();
    let find = || adapters(&choice(arguments)).into_iter().find(|adapter| adapter.automatic);
    let Some(adapter) = HARDWARE.get_or_init(find) else { return cpu(arguments) };
    match open(arguments, scene) {
        Ok(compute) => Ok(compute),
        Err(fault) => {
            output::message_once(&format!("{} is not used: {fault}", adapter.name));
            cpu(arguments)
        }
    }
}

fn open(arguments: &Arguments, scene: &Scene) -> Result<Compute, GpuError> {
    let precision = match arguments.precision {
        None | Some(Wanted::F32) => Precision::F32,
        Some(Wanted::F64) => Precision::F64,
    };
    let compute = Compute::open(&choice(arguments), precision, scene)?;
    if let Compute::Gpu { gpu, .. } = &compute {
        for warning in gpu.warnings() {
            output::message_once(&format!("warning: {warning}"));
        }
    }
    Ok(compute)
}
