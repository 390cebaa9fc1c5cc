//! What takes steps ([`crate::step::Stepper`]) and carries out their verbs ([`crate::step::Verbs`]): the CPU in f64, or
//! a device.

pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
