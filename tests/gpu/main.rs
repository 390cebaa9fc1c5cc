//! The GPU path against the CPU's, on whatever adapter there is.
//!
//! Without an adapter these tests are skipped, each with a visible line, unless `RELCP_REQUIRE_GPU` is set: then they
//! fail.
#![allow(clippy::unwrap_used)]

mod branches;
mod broad_phase;
mod contacts;
mod degenerate;
#[path = "../common/device.rs"]
mod device;
#[path = "../common/directions.rs"]
mod directions;
mod ensemble;
mod faults;
mod friction;
mod inertia;
mod lattice;
mod lcp;
mod long;
mod midpoint;
mod passing;
mod periodic;
mod profile;
#[path = "../common/reference_pairs.rs"]
mod reference_pairs;
mod render;
mod resume;
#[allow(dead_code)]
#[path = "../friction/scenes.rs"]
mod rough;
mod rows;
mod runs;
mod separation;
mod sort;
mod steps;
#[path = "../common/systems.rs"]
mod systems;
mod traffic;
mod two_sided;
mod walls;
