//! The GPU path against the CPU's, on whatever adapter there is.
//!
//! Without an adapter these tests are skipped, each with a visible line, unless `RELCP_REQUIRE_GPU` is set: then they fail.
#![allow(clippy::unwrap_used)]

mod broad_phase;
mod device;
mod separation;
mod faults;
mod lattice;
mod sort;
mod rows;
mod lcp;
mod runs;
mod steps;
