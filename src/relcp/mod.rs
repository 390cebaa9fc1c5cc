//! The timestep, the simulation that repeats it, and what it reports.

mod accuracy;
mod keep;
mod report;
mod simulation;
mod step;

pub use keep::{Keep, Kept};
pub use report::{Phases, StepReport};
pub use simulation::{Compute, Fault, Simulation, State, Warm, contacts};
pub use step::step;
