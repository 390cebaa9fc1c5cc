//! What drives bodies beside contact, each against its closed form, and on a device against the CPU.
#![allow(clippy::unwrap_used)]

#[path = "../gpu/device.rs"]
mod device;
mod drag;
mod fields;
mod fixed;
mod forces;
mod motion;
mod orientation;
mod scenes;
mod thermal;
mod traps;
