//! The GPU runtime: adapters, devices, kernels assembled from WGSL, buffers, recorded work and read-backs.
//!
//! It knows nothing of bodies, rows or solvers. Kernels are written in `shaders/` over the number type `real`, which is `f32` or,
//! where the adapter has it, `f64` ([`Precision`]). Nothing here waits for ever, and every fault of a device is a [`GpuError`].

mod adapter;
mod banks;
mod buffer;
mod device;
mod error;
mod kernel;
mod lattice;
mod periods;
mod precision;
mod profile;
mod recorder;
mod scan;
mod self_test;
mod sort;
mod source;
#[cfg(test)]
mod test_device;
mod timing;

pub use adapter::{AdapterReport, Choice, adapters};
pub use buffer::Buffer;
pub use device::{Counters, Gpu, PipelineReport};
pub use error::GpuError;
pub use kernel::Kernel;
#[cfg(test)]
pub(crate) use kernel::validate;
pub use lattice::Lattice;
pub(crate) use lattice::MOST_CELL;
pub use periods::LatticePeriods;
pub use precision::Precision;
pub use profile::{BufferUse, Profile};
pub use recorder::Recorder;
pub use scan::Scan;
pub use sort::Sort;
pub use source::{Fragment, Source, WORKGROUP};
#[cfg(test)]
pub(crate) use test_device::{precisions, test_device};
pub use timing::StageTime;

/// A WGSL fragment of the folder `shaders/`, by its path there.
macro_rules! fragment {
    ($path:literal) => {
        $crate::gpu::Fragment {
            name: $path,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $path)),
        }
    };
}
pub(crate) use fragment;
