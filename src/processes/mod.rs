//! Processes that take one simulation together, by the machine's MPI (Message Passing Interface Forum, "MPI: A
//! Message-Passing Interface Standard, Version 3.1", 2015): who they are and what they exchange, no more.
//!
//! All take the same decisions from the same numbers. Each does the work on the bodies of its domain, and numbers of
//! all are joined in one order, so that the bits are those of one process. Rank 0 leads: it alone reads arguments,
//! writes files and hears the user, and says what is done next ([`Processes::tell`], [`Processes::hear`]).
//!
//! Without the feature `mpi` there is no other process: [`Processes`] has no value.

#[cfg(not(feature = "mpi"))]
mod absent;
#[cfg(feature = "mpi")]
mod group;
#[cfg(feature = "mpi")]
mod session;
#[cfg(feature = "mpi")]
mod traffic;

#[cfg(not(feature = "mpi"))]
pub(crate) use absent::Parcel;
#[cfg(not(feature = "mpi"))]
pub use absent::Processes;
#[cfg(feature = "mpi")]
pub(crate) use group::Parcel;
#[cfg(feature = "mpi")]
pub use group::Processes;
#[cfg(feature = "mpi")]
pub use session::{NoSession, Session};
#[cfg(feature = "mpi")]
pub use traffic::Traffic;
