//! Measured studies: what a table of the documentation is made from.

mod bandwidth;
pub mod hard;
pub mod inertia;
mod machine;
pub mod paper;
mod plot;
pub mod solvers;
mod state;
mod table;
pub mod throughput;
pub mod work_precision;

pub use bandwidth::copy_bandwidth;
pub(crate) use machine::machine;
pub use state::{StudyError, tiled};
