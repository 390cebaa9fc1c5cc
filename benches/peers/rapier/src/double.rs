//! Rapier 0.36 in f64.

use rapier_0_36_f64 as engine;

#[path = "v0_36.rs"]
pub mod v0_36;
