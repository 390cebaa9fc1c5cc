//! What computes the steps: the CPU or a device.

#[cfg(feature = "gpu")]
use crate::backend::gpu::Device;
use crate::gpu::{Choice, Gpu, GpuError, Precision};
#[cfg(feature = "gpu")]
use crate::lcp;
use crate::scene::Scene;
use std::sync::Arc;

/// What computes the steps.
#[derive(Clone, Default)]
#[non_exhaustive]
pub enum Compute {
    /// The CPU, in f64.
    #[default]
    Cpu,
    /// A device.
    Gpu {
        /// The device.
        gpu: Arc<Gpu>,
        /// The numbers that its kernels compute with.
        precision: Precision,
    },
}

impl Compute {
    /// Whether a device can take all steps that a scene asks for.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for what only the CPU does; [`GpuError::NotBuilt`] without the feature `gpu`.
    #[cfg(feature = "gpu")]
    pub fn check(scene: &Scene) -> Result<(), GpuError> {
        Device::check(&scene.model())
    }

    /// Whether a device can take all steps that a scene asks for: there is none.
    ///
    /// # Errors
    /// [`GpuError::NotBuilt`], always.
    #[cfg(not(feature = "gpu"))]
    pub fn check(_scene: &Scene) -> Result<(), GpuError> {
        Err(GpuError::NotBuilt)
    }

    /// Opens the first device that fits the choice, to compute a scene in a precision. What only the CPU does is
    /// refused before one is opened.
    ///
    /// # Errors
    /// A [`GpuError`]: no device fits, or it cannot do what the scene asks for.
    pub fn open(choice: &Choice, precision: Precision, scene: &Scene) -> Result<Self, GpuError> {
        Compute::check(scene)?;
        #[cfg(feature = "gpu")]
        lcp::gpu::Solver::check(scene.solver.kind)?;
        let gpu = Gpu::open(choice)?;
        gpu.check(precision)?;
        Ok(Compute::Gpu { gpu: Arc::new(gpu), precision })
    }
}
