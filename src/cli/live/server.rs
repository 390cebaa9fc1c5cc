//! The server: connections to this computer alone, each with a thread of its own, and not too many.

use super::answer::Answer;
use super::desk::Desk;
use super::request;
use super::routes::{Door, answer};
use crate::cli::exit::CliError;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// The most connections at a time: far fewer than the files that a process may open, since the run opens some too.
const MOST_CONNECTIONS: usize = 256;
/// Bytes of a connection's stack; it answers from what others have made.
const STACK: usize = 256 << 10;
/// The rest of a listener after a failure, such as too many open files of this process.
const AFTER_FAILURE: Duration = Duration::from_millis(50);

/// An open port, before there is a run.
pub(in crate::cli) struct Server {
    listener: TcpListener,
    door: Door,
}

/// A connection that counts for as long as it lives.
struct Counted(Arc<AtomicUsize>);

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
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
        let open = Arc::<AtomicUsize>::default();
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

fn connect(stream: TcpStream, desk: &Arc<Desk>, door: &Arc<Door>, open: &Arc<AtomicUsize>) {
    let counted = Counted(open.clone());
    if open.fetch_add(1, Ordering::Relaxed) >= MOST_CONNECTIONS {
        // The connection ends without an answer.
        return;
    }
    let (desk, door) = (desk.clone(), door.clone());
    let work = move || {
        let _counted = counted;
        converse(stream, &desk, &door);
    };
    // Where the system gives no thread, the connection ends.
    drop(std::thread::Builder::new().name("connection".into()).stack_size(STACK).spawn(work));
}

/// Reads a request and answers it. A client that goes is no fault of the run.
fn converse(mut stream: TcpStream, desk: &Desk, door: &Door) {
    let answered = match request::read(&mut stream) {
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
