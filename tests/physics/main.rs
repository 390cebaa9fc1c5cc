//! What drives bodies beside contact, each against its closed form, and on a device against the CPU.
#![allow(clippy::unwrap_used)]

#[path = "../gpu/device.rs"]
mod device;
mod drag;
mod fixed;
mod flow;
mod forces;
mod moving_walls;
mod orientation;
mod scenes;
mod strain;
mod thermal;
