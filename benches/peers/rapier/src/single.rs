//! Rapier 0.36 in f32.

use rapier_0_36 as engine;

#[path = "v0_36.rs"]
pub mod v0_36;
