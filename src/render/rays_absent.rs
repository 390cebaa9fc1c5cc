//! A program that was built without the feature `gpu` casts rays on the CPU only.

use super::raster::{Drawn, Sample};
use crate::gpu::{Gpu, GpuError};
use std::sync::Arc;

/// A device that casts rays: without the feature it has no value.
pub enum Rays {}

impl Rays {
    /// Compiles the kernel; never called, because no device exists.
    ///
    /// # Errors
    /// None: it is never called.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, GpuError> {
        match *gpu {}
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        match *self {}
    }

    pub(super) fn cast(
        &self,
        _drawn: &[Drawn],
        (_first, _members): (&[usize], &[u32]),
        _columns: usize,
        _scale: f64,
    ) -> Result<Option<Vec<Sample>>, GpuError> {
        match *self {}
    }
}
