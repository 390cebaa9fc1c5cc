//! Environment variables of graphics drivers.
//!
//! If a variable must be set, the program restarts itself with it.

use super::arguments::{Backend, Compute};
use relcp::gpu::Gpu;
use relcp::internals::program::restart_with;
use relcp::scene::Scene;
use std::path::Path;

/// The threads of Mesa's software adapter.
const THREADS: &str = "LP_NUM_THREADS";

/// The largest number of bodies for which Mesa's software adapter computes in the calling thread. Otherwise it wakes
/// its threads for every dispatch and waits for them. Up to about this number of bodies, one workgroup solves for the
/// multipliers, so a second thread has little to do: on two cores a colony to 64 cells takes 0.4 of the time without
/// threads, 200 ellipsoids 0.67. 1,000 scattered ellipsoids still take 0.78, but a crowded colony of 1,024 cells more
/// than with threads.
const MOST_BODIES_ALONE: f64 = 400.0;

/// Lets a software adapter compute a small scene in the calling thread, unless the environment sets its number of
/// threads. Hardware is unaffected, and bits do not depend on it.
pub(super) fn compute_alone(arguments: &Compute, scene: &Scene, source: Option<&Path>) {
    let asks = arguments.backend == Backend::Gpu && std::env::var_os(THREADS).is_none();
    // The standard input cannot be read again.
    let again = source != Some(Path::new("-"));
    if asks && again && scene.bodies_at_end() <= MOST_BODIES_ALONE {
        restart_with(THREADS, "0".as_ref());
    }
}

/// Lets a software adapter compute many scenes in the program's own threads: see [`devices_of_many`].
pub(super) fn compute_side_by_side(arguments: &Compute, members: usize, threads: usize, source: &Path) {
    let asks = arguments.backend == Backend::Gpu && std::env::var_os(THREADS).is_none();
    if asks && source != Path::new("-") && members >= threads && threads > 1 {
        restart_with(THREADS, "0".as_ref());
    }
}

/// The number of devices that share the members of a batch. A software adapter without threads computes in the calling
/// thread, so each thread has a device. These need not wait for each other at every dispatch, as the adapter's threads
/// do.
pub(super) fn devices_of_many(gpu: &Gpu, threads: usize) -> usize {
    let alone = gpu.is_software() && std::env::var_os(THREADS).is_some_and(|value| value == "0");
    if alone { threads.max(1) } else { 1 }
}
