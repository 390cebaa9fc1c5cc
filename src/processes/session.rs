//! The beginning and the end of MPI in a program.

use super::Processes;
use mpi::Threading;
use mpi::environment::Universe;
use std::sync::OnceLock;

/// The rank of this process, known after MPI has ended too.
static OWN_RANK: OnceLock<usize> = OnceLock::new();

/// An initialized MPI. Dropping it finalizes MPI.
pub struct Session {
    processes: Processes,
    _universe: Universe,
}

/// Why MPI cannot start.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SessionError {
    /// This process has already initialized MPI.
    #[error("this process has already initialized MPI")]
    AlreadyInitialized,
    /// A thread of a pool takes the steps, and MPI allows only the main thread.
    #[error("this machine's MPI allows calls from the main thread only (MPI_THREAD_SERIALIZED is needed); use another")]
    Threads,
    /// Different programs give different bits or deadlock.
    #[error(
        "rank {other} runs another program (version {theirs}) than rank 0 (version {ours}); start the same program on all nodes"
    )]
    DifferentPrograms {
        /// The first rank that differs.
        other: usize,
        /// The version of rank 0 and the size of its program in bytes.
        ours: String,
        /// Those of the other rank.
        theirs: String,
    },
}

impl SessionError {
    /// Whether this rank reports the error: rank 0, if all have it.
    pub fn is_for(&self, rank: usize) -> bool {
        match self {
            SessionError::AlreadyInitialized => true,
            SessionError::Threads | SessionError::DifferentPrograms { .. } => own_rank() == rank,
        }
    }
}

fn own_rank() -> usize {
    OWN_RANK.get().copied().unwrap_or(0)
}

impl Session {
    /// Initializes MPI. All processes of the launch must call it and run the same program.
    ///
    /// # Errors
    /// A [`SessionError`], the same on all processes.
    pub fn begin() -> Result<Session, SessionError> {
        let (universe, threads) =
            mpi::initialize_with_threading(Threading::Multiple).ok_or(SessionError::AlreadyInitialized)?;
        let session = Session { processes: Processes::all(), _universe: universe };
        let _ = OWN_RANK.set(session.processes.rank());
        if threads < Threading::Serialized {
            return Err(SessionError::Threads);
        }
        same_program(session.processes, &program())?;
        Ok(session)
    }

    /// The processes.
    pub fn processes(&self) -> Processes {
        self.processes
    }
}

/// The version and size of this program: two builds of one version seldom have the same size.
fn program() -> String {
    let size = std::env::current_exe().and_then(std::fs::metadata).map_or(0, |file| file.len());
    format!("{} of {size} bytes", env!("CARGO_PKG_VERSION"))
}

fn same_program(processes: Processes, own: &str) -> Result<(), SessionError> {
    let words = |text: &str| -> Vec<u64> {
        let bytes = text.bytes().chain(std::iter::repeat(b' ')).take(64).collect::<Vec<u8>>();
        bytes.chunks_exact(8).map(|word| u64::from_le_bytes(std::array::from_fn(|k| word[k]))).collect()
    };
    let text = |words: &[u64]| {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        String::from_utf8_lossy(&bytes).trim_end().to_owned()
    };
    let all = processes.all_gather(&words(own));
    let of: Vec<String> = all.chunks(8).map(text).collect();
    match of.iter().position(|other| *other != of[0]) {
        Some(other) => Err(SessionError::DifferentPrograms { other, ours: of[0].clone(), theirs: of[other].clone() }),
        None => Ok(()),
    }
}
