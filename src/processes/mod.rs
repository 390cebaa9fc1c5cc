//! Processes that take one simulation together, by the machine's MPI (Message Passing Interface Forum, "MPI: A
//! Message-Passing Interface Standard, Version 3.1", 2015): who they are and what they exchange, no more.
//!
//! All take the same decisions from the same numbers. Each does the work on the bodies of its domain, and numbers of
//! all are joined in one order, so that the bits are those of one process. Rank 0 leads: it alone reads arguments,
//! writes files and hears the user, and says what is done next ([`Processes::tell`], [`Processes::hear`]).

mod group;
mod session;
mod traffic;

pub(crate) use group::Parcel;
pub use group::Processes;
pub use session::{NoSession, Session};
pub use traffic::Traffic;

/// What rank 0 says to the others, as the first byte of a message: there is nothing more to do.
pub(crate) const END: u8 = 0;
/// To start from a scene and a state.
pub(crate) const START: u8 = 1;
/// To take a step.
pub(crate) const STEP: u8 = 2;
/// To give the parts of the state.
pub(crate) const GATHER: u8 = 3;
/// To start each from a part of a state.
pub(crate) const START_WITH_A_PART: u8 = 4;
