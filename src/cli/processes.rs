//! `relcp run --backend mpi`: one run on several processes. Rank 0 does what the program does alone; the others
//! execute its commands and print nothing.

use super::arguments::{Compute as Computing, Run as Arguments};
use super::exit::{CliError, Exit};
use super::interrupt::Interrupt;
use super::{compute as computing, output};
use relcp::processes::{Processes, Session, Traffic};
use relcp::run::{follow, together};
use relcp::simulation::Compute;
use std::io::{self, Write};
use std::sync::OnceLock;

/// The function that runs a scene on rank 0.
type Lead = fn(&Arguments) -> Result<Exit, CliError>;

/// The processes, once MPI has begun.
static PROCESSES: OnceLock<Processes> = OnceLock::new();

/// Rank 0. On drop it tells the other ranks to exit.
struct Leading(Session);

impl Drop for Leading {
    fn drop(&mut self) {
        together(self.0.processes()).end();
    }
}

/// Initializes MPI, leads on rank 0 and follows on the others.
pub(super) fn run(arguments: &Arguments, lead: Lead) -> Result<Exit, CliError> {
    let session = match Session::begin() {
        Ok(session) => session,
        Err(fault) if fault.is_for(0) => return Err(CliError::Usage(fault.to_string())),
        // Rank 0 reports it and fails. If another rank failed first, `mpirun` would end rank 0 before its message.
        Err(_) => return Ok(Exit::Done),
    };
    let processes = session.processes();
    let _ = PROCESSES.set(processes);
    if processes.rank() == 0 {
        let _leading = Leading(session);
        return lead(arguments);
    }
    computing::set_threads(&arguments.compute)?;
    // Rank 0 handles signals.
    let _ignored = Interrupt::ignore();
    follow(processes, Exit::Internal as u8, output::message);
    Ok(Exit::Done)
}

/// What computes the run.
pub(super) fn compute(arguments: &Computing) -> Result<Compute, CliError> {
    computing::cpu(arguments)?;
    match PROCESSES.get() {
        Some(processes) => Ok(Compute::Together(together(*processes))),
        None => Err(computing::no_mpi()),
    }
}

/// The traffic between rank 0 and the others.
pub(super) fn traffic(out: &mut dyn Write) -> io::Result<()> {
    let Some(processes) = PROCESSES.get() else { return Ok(()) };
    let Traffic { messages, bytes, gathers, gathered, time } = Traffic::so_far();
    let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    writeln!(
        out,
        "  {} processes: rank 0 sent {messages} messages of {:.1} MiB, took part in {gathers} gathers of {:.1} MiB, \
         {:.2} s in all",
        processes.size(),
        mebibytes(bytes),
        mebibytes(gathered),
        time.as_secs_f64()
    )
}
