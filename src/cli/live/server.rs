//! The server: connections to this computer alone, each with a thread of its own, and not too many.

use super::answer::Answer;
use super::desk::Desk;
use super::request;
use super::routes::{Door, answer};
use crate::cli::exit::CliError;
use std::collections::BTreeMap;
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// The most connections at a time. With two handles each they are far fewer than the files that a process may open, and
/// the run opens some too.
const MOST_CONNECTIONS: usize = 128;
/// Bytes of a connection's stack; it answers from what others have made.
const STACK: usize = 256 << 10;
/// The rest of a listener after a failure, such as too many open files of this process.
const AFTER_FAILURE: Duration = Duration::from_millis(50);

/// An open port, before there is a run.
pub(in crate::cli) struct Server {
    listener: TcpListener,
    door: Door,
}

/// The connections that are open, by their numbers in order of age. Those that have not sent their request yet have
/// their stream, so that the oldest of them can be closed for a new one.
#[derive(Default)]
struct Open {
    all: BTreeMap<u64, Option<TcpStream>>,
    next: u64,
}

/// A connection that counts for as long as it lives.
struct Counted {
    open: Arc<Mutex<Open>>,
    number: u64,
}

impl Open {
    /// Counts a connection, if there is room or can be made.
    fn admit(open: &Arc<Mutex<Open>>, stream: &TcpStream) -> Option<Counted> {
        let mut all = lock(open);
        if all.all.len() >= MOST_CONNECTIONS {
            let oldest = all.all.iter().find(|(_, stream)| stream.is_some()).map(|(number, _)| *number)?;
            let idle = all.all.remove(&oldest).flatten()?;
            // Its thread finds the end and goes; one that has gone already needs none.
            let _ = idle.shutdown(Shutdown::Both);
        }
        let number = all.next;
        all.next += 1;
        all.all.insert(number, stream.try_clone().ok());
        Some(Counted { open: open.clone(), number })
    }
}

impl Counted {
    /// It has sent its request, and is closed for no other one any more.
    fn asks(&self) {
        if let Some(stream) = lock(&self.open).all.get_mut(&self.number) {
            *stream = None;
        }
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        lock(&self.open).all.remove(&self.number);
    }
}

/// A thread that panicked has ended the program, so the lock is always whole.
fn lock(open: &Mutex<Open>) -> MutexGuard<'_, Open> {
    open.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Server {
    /// Opens a port of 127.0.0.1: this one, or one that is free.
    pub fn open(port: Option<u16>) -> Result<Self, CliError> {
        let refuse = |why: String| CliError::Usage(format!("cannot serve the page of a live run: {why}"));
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port.unwrap_or(0))).map_err(|why| match port {
            Some(port) => refuse(format!("port {port}: {why}; name another --port, or none for a free one")),
            None => refuse(why.to_string()),
        })?;
        let port = listener.local_addr().map_err(|why| refuse(why.to_string()))?.port();
        let door = Door::new(port).map_err(refuse)?;
        Ok(Server { listener, door })
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        self.door.address()
    }

    /// Answers connections until the program ends.
    pub(super) fn serve(self, desk: Arc<Desk>) -> Result<(), CliError> {
        let Server { listener, door } = self;
        let door = Arc::new(door);
        let open = Arc::<Mutex<Open>>::default();
        let serve = move || {
            for stream in listener.incoming() {
                match stream {
                    Ok(stream) => connect(stream, &desk, &door, &open),
                    Err(_) => std::thread::sleep(AFTER_FAILURE),
                }
            }
        };
        let thread = std::thread::Builder::new().name("page".into()).spawn(serve);
        thread.map(drop).map_err(|why| CliError::Usage(format!("cannot start a thread for the page: {why}")))
    }
}

fn connect(stream: TcpStream, desk: &Arc<Desk>, door: &Arc<Door>, open: &Arc<Mutex<Open>>) {
    // Where all others wait for answers, the connection ends without one.
    let Some(counted) = Open::admit(open, &stream) else { return };
    let (desk, door) = (desk.clone(), door.clone());
    let work = move || {
        converse(stream, &counted, &desk, &door);
    };
    // Where the system gives no thread, the connection ends.
    drop(std::thread::Builder::new().name("connection".into()).stack_size(STACK).spawn(work));
}

/// Reads a request and answers it. A client that goes is no fault of the run.
fn converse(mut stream: TcpStream, counted: &Counted, desk: &Desk, door: &Door) {
    let read = request::read(&mut stream);
    counted.asks();
    let answered = match read {
        Ok(request) => answer(&request, desk, door),
        Err(Some((status, why))) => (Answer::refuse(status, why), false),
        Err(None) => return,
    };
    let (answer, tells_end) = answered;
    let sent = answer.send(&mut stream);
    if tells_end && sent.is_ok() {
        desk.told().end_is_known = true;
        desk.ring();
    }
}
