//! The device of a program built without the feature `gpu`: opening one always fails.

use super::{AdapterReport, Choice, GpuError, PipelineReport, Precision, StageUse};
use std::sync::Arc;

/// An open device. The type has no value.
pub enum Gpu {}

impl Gpu {
    /// Returns the error that no device exists.
    ///
    /// # Errors
    /// [`GpuError::NotBuilt`], always.
    pub fn open(_choice: &Choice) -> Result<Gpu, GpuError> {
        Err(GpuError::NotBuilt)
    }

    /// Tells the device that no requests follow for a while.
    pub fn rest(&self) {
        match *self {}
    }

    /// The adapter's name.
    pub fn name(&self) -> &str {
        match *self {}
    }

    /// The driver and its version.
    pub fn driver(&self) -> &str {
        match *self {}
    }

    /// Whether the adapter is a software one.
    pub fn is_software(&self) -> bool {
        match *self {}
    }

    /// The default precision.
    pub fn default_precision(&self) -> Precision {
        match *self {}
    }

    /// Warnings about the adapter.
    pub fn warnings(&self) -> Vec<String> {
        match *self {}
    }

    /// Whether the adapter supports a precision.
    ///
    /// # Errors
    /// None: the type has no value.
    pub fn check(&self, _precision: Precision) -> Result<(), GpuError> {
        match *self {}
    }

    /// The largest number of bytes of all buffers at once.
    pub fn peak_bytes(&self) -> u64 {
        match *self {}
    }

    /// Makes drivers compile kernels when they are created.
    pub fn compile_at_once(&self) {
        match *self {}
    }

    /// Times stages from now on.
    pub fn start_timing(&self) {
        match *self {}
    }

    pub(super) fn buffers(&self) -> Vec<(String, u64)> {
        match *self {}
    }

    /// The pipelines created so far.
    pub fn pipelines(&self) -> Vec<PipelineReport> {
        match *self {}
    }

    pub(super) fn profiled(&self) -> (f64, Vec<StageUse>) {
        match *self {}
    }
}

/// All adapters that this program can use: none.
pub fn adapters(_choice: &Choice) -> Vec<AdapterReport> {
    Vec::new()
}

/// Many scenes on one device. The type has no value.
pub enum Ensemble {}

impl Ensemble {
    /// An ensemble on a device; it cannot exist.
    ///
    /// # Errors
    /// None: the type has no value.
    pub fn new(gpu: Arc<Gpu>) -> Result<Ensemble, GpuError> {
        match *gpu {}
    }

    /// The approximate number of members with this many bodies each that fit at once.
    pub fn members_that_fit(&self, _bodies: u64) -> u64 {
        match *self {}
    }

    /// The present number of members.
    pub fn members(&self) -> usize {
        match *self {}
    }

    /// A device for one more member.
    pub fn member(&self) -> Arc<Gpu> {
        match *self {}
    }
}
