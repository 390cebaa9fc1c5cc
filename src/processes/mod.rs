//! Processes that take one simulation together, by the machine's MPI (Message Passing Interface Forum, "MPI: A
//! Message-Passing Interface Standard, Version 3.1", 2015): who they are and what they exchange, no more.
//!
//! All take the same decisions from the same numbers. Each does the work on the bodies of its domain, and numbers of
//! all are joined in one order, so that the bits are those of one process. Rank 0 leads: it alone reads arguments,
//! writes files, handles the user's requests, and says what is done next ([`Processes::broadcast`],
//! [`Processes::receive`]).

mod group;
mod session;
mod traffic;

pub(crate) use group::Parcel;
pub use group::Processes;
pub use session::{Session, SessionError};
pub use traffic::Traffic;

/// The first byte of a command of rank 0. This one: end.
pub(crate) const END: u8 = 0;
/// Start from a scene and a state.
pub(crate) const START: u8 = 1;
/// Take a step.
pub(crate) const STEP: u8 = 2;
/// Gather the state.
pub(crate) const GATHER: u8 = 3;
/// Start from a part of a state.
pub(crate) const START_PART: u8 = 4;
