//! One HTTP request: read within a time and a size, whatever the client does.

use httparse::{EMPTY_HEADER, Status};
use std::io::Read;
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// The most bytes of a request's head; browsers send less than a thousandth of a megabyte to this page.
const MOST_HEAD: usize = 16 << 10;
/// The most header lines.
const MOST_HEADERS: usize = 64;
/// The most bytes of a body: thousands of changed keys.
pub(super) const MOST_BODY: usize = 64 << 10;
/// The longest time in which a request must be there as a whole.
const PATIENCE: Duration = Duration::from_secs(5);

/// What matters of a request.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Request {
    pub method: String,
    pub path: String,
    pub query: String,
    pub host: Option<String>,
    pub origin: Option<String>,
    pub content_type: Option<String>,
    pub body: Vec<u8>,
}

/// Why there is no request: a status and a sentence. None: the client has gone or sent nothing.
pub(super) type Unread = Option<(u16, &'static str)>;

/// The head of a request, and the length of its body.
struct Head {
    request: Request,
    /// Bytes of the head.
    length: usize,
    body: usize,
}

/// Reads a request.
pub(super) fn read(stream: &mut TcpStream) -> Result<Request, Unread> {
    let until = Instant::now() + PATIENCE;
    let mut bytes = Vec::new();
    let head = loop {
        let found = if bytes.is_empty() { None } else { head(&bytes)? };
        match found {
            Some(head) => break head,
            None if bytes.len() >= MOST_HEAD => return Err(Some((431, "the head of the request is too large"))),
            None => more(stream, &mut bytes, until)?,
        }
    };
    let mut body = bytes.split_off(head.length);
    while body.len() < head.body {
        more(stream, &mut body, until)?;
    }
    body.truncate(head.body);
    Ok(Request { body, ..head.request })
}

/// Reads what is there, at most until then.
fn more(stream: &mut TcpStream, bytes: &mut Vec<u8>, until: Instant) -> Result<(), Unread> {
    let late = || if bytes.is_empty() { None } else { Some((408, "the request did not come as a whole in time")) };
    let left = until.saturating_duration_since(Instant::now());
    if left.is_zero() {
        return Err(late());
    }
    stream.set_read_timeout(Some(left)).map_err(|_| None)?;
    let mut part = [0; 4096];
    match stream.read(&mut part) {
        Ok(0) => Err(None),
        Ok(count) => {
            bytes.extend(&part[..count]);
            Ok(())
        }
        Err(why) if why.kind() == std::io::ErrorKind::Interrupted => Ok(()),
        Err(_) => Err(late()),
    }
}

/// The head, if it is there as a whole.
fn head(bytes: &[u8]) -> Result<Option<Head>, Unread> {
    let mut headers = [EMPTY_HEADER; MOST_HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let length = match parsed.parse(bytes) {
        Ok(Status::Complete(length)) => length,
        Ok(Status::Partial) => return Ok(None),
        Err(httparse::Error::TooManyHeaders) => return Err(Some((431, "the request has too many headers"))),
        Err(_) => return Err(Some((400, "this is no HTTP request"))),
    };
    let (path, query) = parsed.path.map(|path| path.split_once('?').unwrap_or((path, ""))).unwrap_or_default();
    let mut request = Request {
        method: parsed.method.unwrap_or_default().into(),
        path: path.into(),
        query: query.into(),
        ..Request::default()
    };
    let mut body = None;
    for header in parsed.headers.iter() {
        let Ok(value) = std::str::from_utf8(header.value) else { continue };
        let value = value.trim();
        let once = |place: &mut Option<String>| match place.replace(value.to_owned()) {
            None => Ok(()),
            Some(_) => Err(Some((400, "the request has a header twice"))),
        };
        match header.name.to_ascii_lowercase().as_str() {
            "host" => once(&mut request.host)?,
            "origin" => once(&mut request.origin)?,
            "content-type" => once(&mut request.content_type)?,
            "content-length" => once(&mut body)?,
            "transfer-encoding" => return Err(Some((411, "a body must come with its Content-Length"))),
            _ => {}
        }
    }
    let body = match body {
        None if request.method == "POST" => return Err(Some((411, "a body must come with its Content-Length"))),
        None => 0,
        // A sign is no digit.
        Some(digits) => match digits.bytes().all(|digit| digit.is_ascii_digit()).then(|| digits.parse::<usize>()) {
            Some(Ok(length)) => length,
            _ => return Err(Some((400, "Content-Length must be a number"))),
        },
    };
    if body > MOST_BODY {
        return Err(Some((413, "the body is larger than 64 kB")));
    }
    Ok(Some(Head { request, length, body }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(text: &str) -> Option<u16> {
        head(text.as_bytes()).err().flatten().map(|(status, _)| status)
    }

    #[test]
    fn a_head_is_taken_apart() {
        let text = "POST /t/change?x=1 HTTP/1.1\r\nHost: 127.0.0.1:8\r\ncontent-LENGTH: 3\r\nContent-Type:  application/json \r\n\r\n{}!";
        let found = head(text.as_bytes()).unwrap().unwrap();
        assert_eq!((found.request.path.as_str(), found.request.query.as_str(), found.body), ("/t/change", "x=1", 3));
        assert_eq!((found.length, found.request.host.as_deref()), (text.len() - 3, Some("127.0.0.1:8")));
        assert_eq!(found.request.content_type.as_deref(), Some("application/json"));
        for end in 1..text.len() - 3 {
            assert!(head(&text.as_bytes()[..end]).unwrap().is_none(), "{end}");
        }
    }

    #[test]
    fn what_is_no_request_is_refused() {
        assert_eq!(status("\u{0}\u{1}\r\n\r\n"), Some(400));
        assert_eq!(status("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"), Some(400));
        for length in ["-1", "+1", "1e3", "", "9999999999999999999999"] {
            let text = format!("POST / HTTP/1.1\r\nContent-Length: {length}\r\n\r\n");
            assert_eq!(status(&text), Some(400), "{length}");
        }
        assert_eq!(status("POST / HTTP/1.1\r\nContent-Length: 65537\r\n\r\n"), Some(413));
        assert_eq!(status("POST / HTTP/1.1\r\n\r\n"), Some(411));
        assert_eq!(status("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n"), Some(411));
        let many: String = (0..MOST_HEADERS + 1).map(|k| format!("h{k}: 1\r\n")).collect();
        assert_eq!(status(&format!("GET / HTTP/1.1\r\n{many}\r\n")), Some(431));
    }
}
