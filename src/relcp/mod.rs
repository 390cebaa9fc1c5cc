//! The step and the simulation.
mod report;
mod simulation;
pub use report::{Phases, StepReport};
pub use simulation::{Fault, Simulation, State, Warm};
