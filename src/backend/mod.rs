//! What carries out the verbs of a step ([`crate::step::Backend`]): the CPU in f64, or a device.

pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
