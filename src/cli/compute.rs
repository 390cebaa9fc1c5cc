//! What computes a run: the CPU or a device, as the arguments say.

use super::arguments::{Backend, Compute as Arguments, Precision as Wanted};
use super::exit::CliError;
use super::output;
#[cfg(feature = "mpi")]
use super::processes::compute as by_processes;
use relcp::gpu::{AdapterReport, Choice, Gpu, GpuError, Precision, adapters};
use relcp::scene::Scene;
use relcp::simulation::Compute;
use std::sync::Arc;

/// Why `--backend mpi` does not compute here.
pub(super) fn no_mpi() -> CliError {
    let why = if cfg!(feature = "mpi") {
        "--backend mpi is for `relcp run` alone; the members of a sweep share nothing: start them as jobs with relcp \
         batch --index (docs/clusters.md)"
    } else {
        "this program was built without MPI; build it with --features mpi on the machine whose MPI it is to use \
         (docs/clusters.md), or leave --backend mpi out"
    };
    CliError::Usage(why.into())
}

#[cfg(not(feature = "mpi"))]
fn by_processes(_: &Arguments) -> Result<Compute, CliError> {
    Err(no_mpi())
}

/// Settles how many threads there are.
pub(super) fn set_threads(arguments: &Arguments) -> Result<(), CliError> {
    // Processes that share a machine share its cores.
    let default = (arguments.backend == Backend::Mpi).then_some(1);
    set_thread_count(arguments.threads.or(default))
}

/// Settles how many threads there are; without a number, one a core.
pub(super) fn set_thread_count(threads: Option<u16>) -> Result<(), CliError> {
    if let Some(threads) = threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        pool.map_err(|e| CliError::Usage(format!("cannot start {threads} threads: {e}")))?;
    }
    Ok(())
}

/// The adapter that the arguments ask for.
pub(super) fn choice(arguments: &Arguments) -> Choice {
    Choice { name: arguments.adapter.clone(), software: arguments.backend == Backend::Gpu, ..Choice::default() }
}

/// What computes one run: with `auto` the CPU, until a hardware device is measured to be faster. What was asked for
/// beside it is not given up silently.
pub(super) fn settle(arguments: &Arguments, scene: &Scene) -> Result<Compute, CliError> {
    let of_device = arguments.precision == Some(Wanted::F32) || arguments.adapter.is_some();
    match arguments.backend {
        // Adapters are looked for at the first trial, as that takes longer than many runs.
        Backend::Auto if !of_device || hardware(arguments).is_some() => {
            Ok(Compute::automatic(&choice(arguments), precision(arguments)))
        }
        Backend::Auto | Backend::Cpu => cpu(arguments),
        Backend::Gpu => open(arguments, scene).map_err(CliError::from),
        Backend::Mpi => by_processes(arguments),
    }
}

/// What computes many runs side by side: with `auto` the CPU, whose cores they share.
pub(super) fn settle_many(arguments: &Arguments, scene: &Scene) -> Result<Compute, CliError> {
    match arguments.backend {
        Backend::Auto | Backend::Cpu => cpu(arguments),
        Backend::Gpu => open(arguments, scene).map_err(CliError::from),
        Backend::Mpi => by_processes(arguments),
    }
}

/// The device that may compute many runs side by side, with its precision; none where the CPU does. With `auto` it is a
/// hardware device, or the one that `--adapter` names. A message says why such a device cannot compute the scene.
pub(super) fn device_of_many(arguments: &Arguments, scene: &Scene) -> Result<Option<(Arc<Gpu>, Precision)>, CliError> {
    let compute = match arguments.backend {
        Backend::Auto => {
            let named = arguments.adapter.is_some();
            let choice = Choice { software: named, ..choice(arguments) };
            // A software adapter computes where it is asked for by its name, as `taken` counts it.
            let fits = |adapter: &AdapterReport| if named { adapter.taken } else { adapter.automatic };
            let Some(adapter) = adapters(&choice).into_iter().find(fits) else {
                return cpu(arguments).map(|_| None);
            };
            match Compute::open_in(&choice, precision(arguments), scene) {
                Ok(compute) => compute,
                Err(fault) => {
                    output::message_once(&format!("{} is not used: {fault}", adapter.name));
                    return cpu(arguments).map(|_| None);
                }
            }
        }
        _ => settle_many(arguments, scene)?,
    };
    match compute {
        Compute::Gpu { gpu, precision } => Ok(Some((gpu, precision))),
        _ => Ok(None),
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

/// The first hardware adapter that fits.
fn hardware(arguments: &Arguments) -> Option<AdapterReport> {
    adapters(&choice(arguments)).into_iter().find(|adapter| adapter.automatic)
}

/// The precision that is asked for on a device.
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
