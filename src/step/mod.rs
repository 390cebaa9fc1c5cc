//! The timestep: its algorithm, the verbs that a backend carries out, and what a step reports.

mod accuracy;
pub(crate) mod algorithm;
pub(crate) mod backend;
mod contacts;
mod dump;
mod fault;
pub(crate) mod keep;
pub(crate) mod model;
mod parting;
pub(crate) mod passing;
pub(crate) mod piece;
mod report;
mod retry;
mod settings;
mod shaking;
mod state;
#[cfg(test)]
mod stub;
pub(crate) mod surplus;
mod two_sided;
mod unresolved;

pub(crate) use algorithm::{Plan, step};
pub(crate) use backend::{Divided, Failed, Keeper, LIFE_WORDS, Lives, Overlap, RetryBackend, Stepper, Take, Verbs};
#[cfg(feature = "files")]
pub(crate) use contacts::deepest_pair_but;
pub(crate) use contacts::max_overlap_but;
#[cfg(feature = "gpu")]
pub(crate) use contacts::{Candidate, candidates};
pub use contacts::{Contact, contacts, max_overlap};
pub(crate) use dump::MOST_DUMPED;
pub use dump::{Dump, DumpWhen};
pub use fault::Fault;
pub(crate) use keep::Keep;
pub use keep::SavedLcp;
pub(crate) use model::Model;
#[cfg(feature = "gpu")]
pub(crate) use passing::DEEPER;
pub use passing::Passed;
#[cfg(feature = "mpi")]
pub(crate) use passing::farthest_and_thinnest;
#[cfg(any(feature = "gpu", feature = "mpi"))]
pub(crate) use passing::may_pass;
pub(crate) use passing::passed;
pub(crate) use piece::{Crowd, Piece};
pub use report::{Phases, StepReport};
#[cfg(any(feature = "files", test))]
pub(crate) use report::{step_figures, step_phases};
pub use settings::{ContactSettings, Method, OnFailure, Recursion, Rows, Stepping, Time};
pub(crate) use shaking::Shake;
pub use state::{State, Unrounded, UnroundedBody};
pub(crate) use surplus::Surplus;
#[cfg(feature = "gpu")]
pub(crate) use two_sided::GAP;
pub(crate) use two_sided::TORN;
pub use two_sided::{Effect, FrictionReport, Guard, Loosened, TwoSided};
pub use unresolved::{Hindrance, Unresolved, Wedge};
