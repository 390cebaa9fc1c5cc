//! Measured studies: what a table of the documentation is made from.

mod bandwidth;
pub mod solvers;
mod state;
pub mod throughput;

pub use bandwidth::copy_bandwidth;
pub use state::{StudyError, tiled};
