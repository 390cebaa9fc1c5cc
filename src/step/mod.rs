//! The timestep: its algorithm, the verbs that a backend carries out, and what a step reports.

mod accuracy;
mod algorithm;
mod backend;
mod contacts;
mod dump;
mod fault;
mod keep;
mod model;
mod passing;
mod piece;
mod report;
mod retry;
mod settings;
mod state;
mod unresolved;

pub use algorithm::{Plan, step};
pub use backend::{Backend, Overlap, RetryBackend};
pub use contacts::{Contact, contacts, max_overlap};
pub(crate) use dump::MOST_DUMPED;
pub use dump::{Dump, DumpWhen};
pub use fault::Fault;
pub use keep::{Keep, SavedLcp};
pub use model::Model;
#[cfg(feature = "gpu")]
pub(crate) use passing::may_pass;
pub use passing::{Passed, passed};
pub use piece::{Crowd, Piece};
pub use report::{Phases, StepReport};
pub use settings::{ContactSettings, Method, OnFailure, Recursion, Rows, Stepping, Time};
pub use state::State;
pub use unresolved::Unresolved;
