//! The timestep, the simulation that repeats it, and what it reports.

mod accuracy;
mod algorithm;
mod contacts;
mod keep;
mod passing;
mod piece;
mod report;
mod retry;
mod simulation;
mod unresolved;

pub use algorithm::{Plan, step};
pub use contacts::{ImageContact, contacts, image_contacts};
pub use keep::{Keep, Kept};
pub(crate) use passing::may_pass;
pub use passing::{Passed, passed};
pub use piece::{Crowd, Piece, Waiting};
pub use report::{Phases, StepReport};
pub use simulation::{Compute, Fault, Simulation, State, Warm};
pub use unresolved::Unresolved;
