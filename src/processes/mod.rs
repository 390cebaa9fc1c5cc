//! Processes that take one simulation together, by the machine's MPI (Message Passing Interface Forum, "MPI: A
//! Message-Passing Interface Standard, Version 3.1", 2015): who they are and what they exchange, no more.
//!
//! Every process holds the whole state and takes the same decisions from the same numbers. What they share is the work:
//! each computes its part of a loop, then all take the parts of all, in one order ([`Processes::gather`]). So the bits
//! are those of one process. Process 0 leads: it alone reads arguments, writes files and hears the user, and says what
//! is done next ([`Processes::tell`], [`Processes::hear`]).
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
pub use absent::Processes;
#[cfg(feature = "mpi")]
pub(crate) use group::Parcel;
#[cfg(feature = "mpi")]
pub use group::Processes;
#[cfg(feature = "mpi")]
pub use session::{NoSession, Session};
#[cfg(feature = "mpi")]
pub use traffic::Traffic;

use std::ops::Range;

/// A part of a loop over so many places, for each of some processes: consecutive, of about the same length.
pub(crate) fn parts(places: usize, processes: usize) -> Vec<Range<usize>> {
    let edge = |process: usize| (process as u128 * places as u128 / processes as u128) as usize;
    (0..processes).map(|process| edge(process)..edge(process + 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::parts;

    #[test]
    fn parts_hold_each_place_once_and_are_of_about_one_length() {
        for (places, processes) in [(0, 3), (1, 4), (10, 3), (1_000, 7)] {
            let parts = parts(places, processes);
            assert!(parts.iter().cloned().flatten().eq(0..places), "{places} {processes}");
            let lengths = parts.iter().map(ExactSizeIterator::len);
            assert!(lengths.clone().max().unwrap() - lengths.min().unwrap() <= 1, "{places} {processes}");
        }
    }
}
