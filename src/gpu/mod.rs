//! The GPU runtime: adapters, devices, kernels assembled from WGSL, buffers, recorded work and read-backs.
//!
//! It does not depend on bodies, rows or solvers. The kernels in `shaders/` use the number type `real`, which is `f32`
//! or, where the adapter supports it, `f64` ([`Precision`]). Every wait has a limit, and every fault of a device is a
//! [`GpuError`].
//!
//! Without the feature `gpu` there is no device: [`Gpu`] has no value, and opening one returns an error that says so.

#[cfg(not(feature = "gpu"))]
mod absent;
#[cfg(feature = "gpu")]
mod adapter;
#[cfg(feature = "gpu")]
mod banks;
#[cfg(feature = "gpu")]
pub(crate) mod buffer;
#[cfg(all(test, feature = "gpu"))]
mod checks;
mod choice;
#[cfg(feature = "gpu")]
mod device;
#[cfg(feature = "gpu")]
mod ensemble;
mod error;
#[cfg(feature = "gpu")]
pub(crate) mod function;
#[cfg(feature = "gpu")]
pub(crate) mod kernel;
#[cfg(feature = "gpu")]
mod kernel_cache;
#[cfg(feature = "gpu")]
pub(crate) mod lattice;
#[cfg(feature = "gpu")]
mod lock;
#[cfg(feature = "gpu")]
mod pending;
#[cfg(feature = "gpu")]
pub(crate) mod periods;
mod precision;
mod profile;
#[cfg(feature = "gpu")]
pub(crate) mod recorder;
#[cfg(feature = "gpu")]
pub(crate) mod scan;
#[cfg(feature = "gpu")]
mod self_test;
#[cfg(feature = "gpu")]
pub(crate) mod sort;
#[cfg(feature = "gpu")]
pub(crate) mod source;
#[cfg(feature = "gpu")]
pub(crate) mod table;
#[cfg(feature = "gpu")]
mod tally;
#[cfg(all(test, feature = "gpu"))]
mod test_device;
#[cfg(feature = "gpu")]
mod timing;

#[cfg(not(feature = "gpu"))]
pub use absent::{Ensemble, Gpu, adapters};
#[cfg(feature = "gpu")]
pub use adapter::adapters;
#[cfg(feature = "gpu")]
pub(crate) use buffer::Buffer;
#[cfg(all(test, feature = "gpu"))]
pub(crate) use checks::validate;
pub use choice::{AdapterReport, Choice};
#[cfg(feature = "gpu")]
pub use device::Gpu;
#[cfg(feature = "gpu")]
pub use ensemble::{Ensemble, Rounds};
pub use error::GpuError;
#[cfg(feature = "gpu")]
pub(crate) use function::{Argument, Function, arguments, arrays, functions};
#[cfg(feature = "gpu")]
pub(crate) use kernel::Kernel;
#[cfg(feature = "gpu")]
pub(crate) use lattice::Lattice;
#[cfg(feature = "gpu")]
pub(crate) use lattice::MOST_CELL;
#[cfg(feature = "gpu")]
pub(crate) use periods::LatticePeriods;
pub use precision::Precision;
pub use profile::{BufferUse, Counters, PipelineReport, Profile, StageUse};
#[cfg(feature = "gpu")]
pub(crate) use recorder::{Recorder, Size};
#[cfg(feature = "gpu")]
pub(crate) use scan::Scan;
#[cfg(feature = "gpu")]
pub(crate) use sort::Sort;
#[cfg(feature = "gpu")]
pub(crate) use source::{Extension, Fragment, Source, WORKGROUP};
#[cfg(feature = "gpu")]
pub(crate) use table::{Made, kernels};
#[cfg(all(test, feature = "gpu"))]
pub(crate) use test_device::{precisions, test_device};

/// A WGSL fragment of the folder `shaders/`, by its path there.
#[cfg(feature = "gpu")]
macro_rules! fragment {
    ($path:literal) => {
        $crate::gpu::Fragment {
            name: $path,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $path)),
        }
    };
}
#[cfg(feature = "gpu")]
pub(crate) use fragment;
