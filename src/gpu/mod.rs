//! The GPU runtime: adapters, devices, kernels assembled from WGSL, buffers, recorded work and read-backs.
//!
//! It knows nothing of bodies, rows or solvers. Kernels are written in `shaders/` over the number type `real`, which is
//! `f32` or, where the adapter has it, `f64` ([`Precision`]). Nothing here waits for ever, and every fault of a device
//! is a [`GpuError`].
//!
//! Without the feature `gpu` there is no device: [`Gpu`] has no value, and opening one says so.

#[cfg(not(feature = "gpu"))]
mod absent;
#[cfg(feature = "gpu")]
mod adapter;
#[cfg(feature = "gpu")]
mod banks;
#[cfg(feature = "gpu")]
mod buffer;
mod choice;
#[cfg(feature = "gpu")]
mod device;
mod error;
#[cfg(feature = "gpu")]
mod kernel;
#[cfg(feature = "gpu")]
mod lattice;
#[cfg(feature = "gpu")]
mod periods;
mod precision;
mod profile;
#[cfg(feature = "gpu")]
mod recorder;
#[cfg(feature = "gpu")]
mod scan;
#[cfg(feature = "gpu")]
mod self_test;
#[cfg(feature = "gpu")]
mod sort;
#[cfg(feature = "gpu")]
mod source;
#[cfg(all(test, feature = "gpu"))]
mod test_device;
#[cfg(feature = "gpu")]
mod timing;

#[cfg(not(feature = "gpu"))]
pub use absent::{Gpu, adapters};
#[cfg(feature = "gpu")]
pub use adapter::adapters;
#[cfg(feature = "gpu")]
pub use buffer::Buffer;
pub use choice::{AdapterReport, Choice};
#[cfg(feature = "gpu")]
pub use device::Gpu;
pub use error::GpuError;
#[cfg(feature = "gpu")]
pub use kernel::Kernel;
#[cfg(all(test, feature = "gpu"))]
pub(crate) use kernel::validate;
#[cfg(feature = "gpu")]
pub use lattice::Lattice;
#[cfg(feature = "gpu")]
pub(crate) use lattice::MOST_CELL;
#[cfg(feature = "gpu")]
pub use periods::LatticePeriods;
pub use precision::Precision;
pub use profile::{BufferUse, Counters, PipelineReport, Profile, StageTime};
#[cfg(feature = "gpu")]
pub use recorder::Recorder;
#[cfg(feature = "gpu")]
pub use scan::Scan;
#[cfg(feature = "gpu")]
pub use sort::Sort;
#[cfg(feature = "gpu")]
pub use source::{Fragment, Source, WORKGROUP};
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
