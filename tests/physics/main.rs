//! What drives bodies beside contact, each against its closed form, and on a device against the CPU.
#![allow(clippy::unwrap_used)]

mod bending;
mod body_drag;
mod bonds;
mod bonds_on_device;
mod chains_in_heat;
mod contact_forces;
mod daughters;
#[path = "../common/device.rs"]
mod device;
mod double_pendulum;
mod drag;
mod fields;
mod final_scene;
mod fixed;
mod flow;
mod fluid;
mod forces;
mod growing_ellipsoids;
mod held_bonds;
mod implicit_bonds;
mod joints;
mod knots;
mod loaded_walls;
mod motion;
mod moving_walls;
mod nutrients;
mod orientation;
mod pressed_ring;
mod propulsion;
mod removal;
mod scenes;
mod shear;
mod species;
mod stokes;
mod strain;
mod thermal;
mod traps;
