//! What is sent back: a status, a few headers, the bytes, and the end of the connection.

use serde::Serialize;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::time::Duration;

/// The longest time for which a client may take nothing of its answer.
const PATIENCE: Duration = Duration::from_secs(10);
/// What a client has sent in vain is read before the end, so that the system does not take back its answer: so much,
/// and within this time.
const MOST_IN_VAIN: usize = 1 << 20;
const PATIENCE_IN_VAIN: Duration = Duration::from_millis(200);

/// For every answer: nothing is kept, guessed, told to other pages or shown inside of them.
const HEADERS: &str = "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
                       Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
                       Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; style-src \
                       'unsafe-inline'; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action \
                       'none'\r\n";

/// An answer.
pub(super) struct Answer {
    status: u16,
    kind: &'static str,
    allow: Option<&'static str>,
    bytes: Vec<u8>,
    /// Bytes after these.
    rest: Option<Arc<super::desk::Frame>>,
}

impl Answer {
    pub fn html(bytes: Vec<u8>) -> Self {
        Answer { status: 200, kind: "text/html; charset=utf-8", allow: None, bytes, rest: None }
    }

    pub fn json<T: Serialize>(status: u16, value: &T) -> Self {
        // What these answers hold always has a JSON form.
        let mut bytes = serde_json::to_vec(value).unwrap_or_default();
        bytes.push(b'\n');
        Answer { status, kind: "application/json", allow: None, bytes, rest: None }
    }

    pub fn json_text(bytes: &[u8]) -> Self {
        Answer { status: 200, kind: "application/json", allow: None, bytes: bytes.into(), rest: None }
    }

    /// A document with its length before it, and a state.
    pub fn state(document: &[u8], frame: Option<Arc<super::desk::Frame>>) -> Self {
        let mut bytes = Vec::from((document.len() as u32).to_le_bytes());
        bytes.extend(document);
        Answer { status: 200, kind: "application/octet-stream", allow: None, bytes, rest: frame }
    }

    /// A refusal with its reason.
    pub fn refuse(status: u16, why: &str) -> Self {
        Answer::json(status, &super::desk::Refusal::new(why))
    }

    /// A refusal of a method.
    pub fn only(method: &'static str) -> Self {
        Answer { allow: Some(method), ..Answer::refuse(405, &format!("this address knows the method {method} only")) }
    }

    /// Sends it and ends the connection.
    pub fn send(&self, stream: &mut TcpStream) -> io::Result<()> {
        stream.set_write_timeout(Some(PATIENCE))?;
        let rest = self.rest.as_ref().map_or(&[][..], |frame| &frame.bytes);
        let (status, kind, length) = (self.status, self.kind, self.bytes.len() + rest.len());
        let allow = self.allow.map_or(String::new(), |method| format!("Allow: {method}\r\n"));
        let reason = reason(status);
        let head = format!(
            "HTTP/1.1 {status} {reason}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{allow}{HEADERS}\r\n"
        );
        stream.write_all(&[head.as_bytes(), &self.bytes].concat())?;
        stream.write_all(rest)?;
        stream.flush()?;
        stream.shutdown(Shutdown::Write)?;
        drain(stream)
    }
}

/// Reads what is left, for a while.
fn drain(stream: &mut TcpStream) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE_IN_VAIN))?;
    let mut part = [0; 4096];
    let mut count = 0;
    while count < MOST_IN_VAIN {
        match stream.read(&mut part)? {
            0 => break,
            read => count += read,
        }
    }
    Ok(())
}

fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        409 => "Conflict",
        411 => "Length Required",
        413 => "Content Too Large",
        415 => "Unsupported Media Type",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Error",
    }
}
