//! The device of a program that was built without the feature `gpu`: there is none.

use super::{AdapterReport, Choice, GpuError, PipelineReport, Precision, StageUse};
use std::sync::Arc;

/// An open device: there is none.
pub enum Gpu {}

impl Gpu {
    /// Says that there is no device.
    ///
    /// # Errors
    /// [`GpuError::NotBuilt`], always.
    pub fn open(_choice: &Choice) -> Result<Gpu, GpuError> {
        Err(GpuError::NotBuilt)
    }

    /// Says that nothing is asked of the device for long.
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

    /// The numbers that it computes with where none are asked for.
    pub fn default_precision(&self) -> Precision {
        match *self {}
    }

    /// What one should know of the adapter.
    pub fn warnings(&self) -> Vec<String> {
        match *self {}
    }

    /// Whether it computes in a precision.
    ///
    /// # Errors
    /// None: there is no value to ask.
    pub fn check(&self, _precision: Precision) -> Result<(), GpuError> {
        match *self {}
    }

    /// Bytes of all buffers at once, at most.
    pub fn peak_bytes(&self) -> u64 {
        match *self {}
    }

    /// Makes drivers compile kernels at once.
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

    /// The pipelines made so far.
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

/// Many scenes on one device: there is none.
pub enum Ensemble {}

impl Ensemble {
    /// An ensemble on a device, of which there is none.
    ///
    /// # Errors
    /// None: there is no value to ask.
    pub fn new(gpu: Arc<Gpu>) -> Result<Ensemble, GpuError> {
        match *gpu {}
    }

    /// Members with so many bodies each that fit at once, about.
    pub fn members_that_fit(&self, _bodies: u64) -> u64 {
        match *self {}
    }

    /// How many members there are now.
    pub fn members(&self) -> usize {
        match *self {}
    }

    /// A device for one more member.
    pub fn member(&self) -> Arc<Gpu> {
        match *self {}
    }
}
