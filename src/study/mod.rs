//! Measured studies: what a table of the documentation is made from.

#[cfg(feature = "gpu")]
mod bandwidth;
#[cfg(feature = "gpu")]
pub mod device;
pub mod hard;
pub mod inertia;
mod machine;
pub mod paper;
mod plot;
pub mod solvers;
mod state;
mod table;
pub mod throughput;
pub mod work_precision;

#[cfg(feature = "gpu")]
pub use bandwidth::copy_bandwidth;
pub use machine::machine;
pub use state::{StudyError, tiled};

/// Without the feature `gpu` there is no device whose bandwidth could be measured.
#[cfg(not(feature = "gpu"))]
fn copy_bandwidth(gpu: &crate::gpu::Gpu) -> Result<f64, crate::gpu::GpuError> {
    match *gpu {}
}
