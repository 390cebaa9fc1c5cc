//! Coulomb friction in steps, against closed forms, balances and geometry.
#![allow(clippy::unwrap_used)]

mod closed_forms;
mod locked;
mod piles;
mod restitution;
mod scenes;
mod settings;
mod surfaces;
