//! Walls on the device against the CPU's.

mod runs;
pub mod separation;
