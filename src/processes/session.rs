//! The beginning and the end of MPI in a program.

use super::Processes;
use mpi::Threading;
use mpi::environment::Universe;
use std::sync::OnceLock;

/// The number of this process, which stays known when MPI has ended.
static OWN_RANK: OnceLock<usize> = OnceLock::new();

/// MPI, from its beginning in this process until it is dropped.
pub struct Session {
    processes: Processes,
    _universe: Universe,
}

/// Why processes cannot begin together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoSession {
    /// MPI runs already in this process, or has ended in it.
    #[error("MPI was already begun in this process")]
    Begun,
    /// Steps are taken by a thread of a pool.
    #[error("this machine's MPI allows calls from the main thread only (MPI_THREAD_SERIALIZED is needed); use another")]
    Threads,
    /// Processes of different programs give different bits, or wait for each other for ever.
    #[error(
        "process {other} runs another program (version {theirs}) than rank 0 (version {ours}); start the same program on all nodes"
    )]
    Mixed {
        /// The first process that differs.
        other: usize,
        /// The version of rank 0, and the size of its program in bytes.
        ours: String,
        /// That of the other one.
        theirs: String,
    },
}

impl NoSession {
    /// Whether the process of this rank is the one to say it: where all know it, the first.
    pub fn is_for(&self, rank: usize) -> bool {
        match self {
            NoSession::Begun => true,
            NoSession::Threads | NoSession::Mixed { .. } => own_rank() == rank,
        }
    }
}

fn own_rank() -> usize {
    OWN_RANK.get().copied().unwrap_or(0)
}

impl Session {
    /// Begins MPI. All processes that were started together must do so, and run the same program.
    ///
    /// # Errors
    /// A [`NoSession`], the same on all processes.
    pub fn begin() -> Result<Session, NoSession> {
        let (universe, threads) = mpi::initialize_with_threading(Threading::Multiple).ok_or(NoSession::Begun)?;
        let session = Session { processes: Processes::all(), _universe: universe };
        let _ = OWN_RANK.set(session.processes.rank());
        if threads < Threading::Serialized {
            return Err(NoSession::Threads);
        }
        same_program(session.processes, &program())?;
        Ok(session)
    }

    /// The processes.
    pub fn processes(&self) -> Processes {
        self.processes
    }
}

/// The version of this program and its size: two builds of one version seldom have the same.
fn program() -> String {
    let size = std::env::current_exe().and_then(std::fs::metadata).map_or(0, |file| file.len());
    format!("{} of {size} bytes", env!("CARGO_PKG_VERSION"))
}

fn same_program(processes: Processes, own: &str) -> Result<(), NoSession> {
    let words = |text: &str| -> Vec<u64> {
        let bytes = text.bytes().chain(std::iter::repeat(b' ')).take(64).collect::<Vec<u8>>();
        bytes.chunks_exact(8).map(|word| u64::from_le_bytes(std::array::from_fn(|k| word[k]))).collect()
    };
    let text = |words: &[u64]| {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        String::from_utf8_lossy(&bytes).trim_end().to_owned()
    };
    let all = processes.gather(&words(own));
    let of: Vec<String> = all.chunks(8).map(text).collect();
    match of.iter().position(|other| *other != of[0]) {
        Some(other) => Err(NoSession::Mixed { other, ours: of[0].clone(), theirs: of[other].clone() }),
        None => Ok(()),
    }
}
