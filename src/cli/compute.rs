//! Chooses the backend of a run, the CPU or a device, by the arguments.

use super::arguments::{Backend, Compute as Arguments, Precision as Wanted};
use super::exit::CliError;
use super::output;
#[cfg(feature = "mpi")]
use super::processes::compute as by_processes;
use relcp::gpu::{Choice, GpuError, Precision};
use relcp::scene::Scene;
use relcp::simulation::{Compute, worth_a_device};

/// The error of a command that does not support `--backend mpi`.
pub(super) fn no_mpi() -> CliError {
    let why = if cfg!(feature = "mpi") {
        "--backend mpi is for `relcp run` alone; the members of a sweep share nothing: start them as jobs with relcp \
         batch --index (docs/clusters.md)"
    } else {
        "this program was built without MPI; build it with --features mpi on the machine whose MPI it is to use \
         (docs/clusters.md), or omit --backend mpi"
    };
    CliError::Usage(why.into())
}

#[cfg(not(feature = "mpi"))]
fn by_processes(_: &Arguments) -> Result<Compute, CliError> {
    Err(no_mpi())
}

/// Sets the number of threads.
pub(super) fn set_threads(arguments: &Arguments) -> Result<(), CliError> {
    // Processes that share a machine share its cores.
    let default = (arguments.backend == Backend::Mpi).then_some(1);
    set_thread_count(arguments.threads.or(default))
}

/// Sets the number of threads; by default one per core.
pub(super) fn set_thread_count(threads: Option<u16>) -> Result<(), CliError> {
    if let Some(threads) = threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        pool.map_err(|e| CliError::Usage(format!("cannot start {threads} threads: {e}")))?;
    }
    Ok(())
}

/// The adapter that the arguments request.
fn choice(arguments: &Arguments) -> Choice {
    Choice { name: arguments.adapter.clone(), software: true, ..Choice::default() }
}

/// The backend: with `auto` the CPU. Options that it does not support are refused.
pub(super) fn settle(arguments: &Arguments, scene: &Scene) -> Result<Compute, CliError> {
    match arguments.backend {
        Backend::Auto | Backend::Cpu => cpu(arguments),
        Backend::Gpu => open(arguments, scene).map_err(CliError::from),
        Backend::Mpi => by_processes(arguments),
    }
}

/// Prints a hint if a hardware GPU may be faster than the CPU that `auto` uses, for so many concurrent runs.
pub(super) fn propose_device(arguments: &Arguments, scene: &Scene, runs: usize) {
    if arguments.backend == Backend::Auto
        && let Some(why) = worth_a_device(scene, runs)
    {
        output::message(&format!("note: {why}; try --backend gpu"));
    }
}

/// The CPU, if it supports all options.
pub(super) fn cpu(arguments: &Arguments) -> Result<Compute, CliError> {
    if arguments.precision == Some(Wanted::F32) {
        return Err(CliError::Usage("the CPU computes in f64; omit --precision, or use --backend gpu".into()));
    }
    if arguments.adapter.is_some() {
        return Err(CliError::Usage(
            "--adapter names a device, but the CPU computes this run; add --backend gpu".into(),
        ));
    }
    Ok(Compute::Cpu)
}

/// The precision to use on a device.
fn precision(arguments: &Arguments) -> Option<Precision> {
    arguments.precision.map(|wanted| match wanted {
        Wanted::F32 => Precision::F32,
        Wanted::F64 => Precision::F64,
    })
}

fn open(arguments: &Arguments, scene: &Scene) -> Result<Compute, GpuError> {
    let compute = Compute::open_in(&choice(arguments), precision(arguments), scene)?;
    if let Compute::Gpu { gpu, .. } = &compute {
        for warning in gpu.warnings() {
            output::message_once(&format!("warning: {warning}"));
        }
    }
    Ok(compute)
}
