//! Locates a key in JSON text: from a path of keys and indices to bytes, lines and columns.
//!
//! serde does not keep the location of a typed value. This module finds it from the path, so that a fault found later
//! still points into the file.

/// A range of bytes of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// The value at a path, and the key that introduces it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found {
    /// The key with its quotes; none for an array's element or the whole text.
    pub key: Option<Place>,
    /// The value.
    pub value: Place,
    /// How many of the path's segments were found.
    pub depth: usize,
}

/// The line and column, from 1, of a byte; the column counts characters.
pub(super) fn line_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text.as_bytes()[..byte.min(text.len())];
    let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |p| p + 1);
    let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
    // Bytes 0b10xxxxxx continue a character.
    let column = 1 + before[line_start..].iter().filter(|&&b| b & 0xC0 != 0x80).count();
    (line, column)
}

/// The byte offset of a line and column as serde_json counts them: from 1, in bytes.
pub(super) fn byte_of(text: &str, line: usize, column: usize) -> usize {
    let mut start = 0;
    for _ in 1..line {
        match text[start..].find('\n') {
            Some(p) => start += p + 1,
            None => return text.len(),
        }
    }
    let mut byte = (start + column.saturating_sub(1)).min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

/// The largest number of path segments that are tried as one key with dots: an override's key has no more. Each try
/// scans the text.
const MAX_PARTS: usize = 32;

/// Finds the value at `path`, or its nearest existing ancestor. `None` if the text up to there is not JSON. A key with
/// dots in it, as in sweeps, is found by its parts.
pub(super) fn locate(text: &str, path: &[String]) -> Option<Found> {
    let mut scan = Scan { text, at: 0 };
    scan.space();
    let mut found = Found { key: None, value: Place { start: scan.at, end: text.len() }, depth: 0 };
    while found.depth < path.len() {
        let rest = &path[found.depth..];
        let start = scan.at;
        let mut entered = None;
        let mut taken = 0;
        while entered.is_none() && taken < rest.len().min(MAX_PARTS) {
            taken += 1;
            scan.at = start;
            entered = match scan.peek() {
                Some(b'{') => scan.enter_object(&rest[..taken].join("."))?,
                Some(b'[') if taken == 1 => scan.enter_array(&rest[0])?,
                _ => None,
            };
        }
        let Some(key) = entered else { break };
        found = Found { key: key.0, value: Place { start: scan.at, end: scan.at }, depth: found.depth + taken };
    }
    scan.at = found.value.start;
    scan.skip_value()?;
    found.value.end = scan.at;
    Some(found)
}

/// The path of the first list in JSON text that is neither the value of one of `keys` nor inside the list of one of
/// `nested` nor anywhere inside of `free`.
///
/// serde accepts a list in place of an object, in the order of its keys; scene files do not allow this.
pub(super) fn misplaced_list(text: &str, keys: &[&str], nested: &[&str], free: &str) -> Option<Vec<String>> {
    let mut scan = Scan { text, at: 0 };
    let mut open: Vec<Open> = Vec::new();
    loop {
        scan.space();
        match scan.peek()? {
            b'"' => {
                let string = scan.string()?;
                scan.space();
                if let (Some(b':'), Some(Open::Object(key))) = (scan.peek(), open.last_mut()) {
                    *key = string;
                }
                continue;
            }
            b'{' => open.push(Open::Object(Place { start: scan.at, end: scan.at })),
            b'[' => {
                let is_free = |o: &Open| matches!(o, Open::Object(key) if name(text, *key) == free);
                let fits = match open.as_slice() {
                    open if open.iter().any(is_free) => true,
                    [.., Open::Object(key)] => keys.contains(&name(text, *key).as_str()),
                    [.., Open::Object(key), Open::List(_)] => nested.contains(&name(text, *key).as_str()),
                    _ => false,
                };
                if !fits {
                    return Some(open.iter().map(|o| o.segment(text)).collect());
                }
                open.push(Open::List(0));
            }
            b'}' | b']' => {
                open.pop();
            }
            b',' => {
                if let Some(Open::List(index)) = open.last_mut() {
                    *index += 1;
                }
            }
            _ => {}
        }
        scan.at += 1;
    }
}

/// A container that is open: an object at its last key, or a list at an index.
enum Open {
    Object(Place),
    List(usize),
}

impl Open {
    fn segment(&self, text: &str) -> String {
        match self {
            Open::Object(key) => name(text, *key),
            Open::List(index) => index.to_string(),
        }
    }
}

/// The key whose location, with quotes, is `key`.
fn name(text: &str, key: Place) -> String {
    text.get(key.start..key.end).and_then(|t| serde_json::from_str(t).ok()).unwrap_or_default()
}

struct Scan<'a> {
    text: &'a str,
    at: usize,
}

/// The result of entering a container: the key's location, if the container has keys.
struct Entered(Option<Place>);

impl Scan<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn space(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    /// Skips a string and returns its location, with quotes.
    fn string(&mut self) -> Option<Place> {
        let start = self.at;
        if self.peek()? != b'"' {
            return None;
        }
        self.at += 1;
        loop {
            match self.peek()? {
                b'"' => break,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
        self.at += 1;
        Some(Place { start, end: self.at })
    }

    /// Skips one value of any kind, without recursion.
    fn skip_value(&mut self) -> Option<()> {
        let mut open = 0_usize;
        loop {
            self.space();
            match self.peek()? {
                b'"' => {
                    self.string()?;
                }
                b'{' | b'[' => {
                    open += 1;
                    self.at += 1;
                    continue;
                }
                b'}' | b']' => {
                    open = open.checked_sub(1)?;
                    self.at += 1;
                }
                b',' | b':' if open > 0 => {
                    self.at += 1;
                    continue;
                }
                _ => {
                    let start = self.at;
                    while self.peek().is_some_and(|b| !b" \t\r\n,:]}[{\"".contains(&b)) {
                        self.at += 1;
                    }
                    if self.at == start {
                        return None;
                    }
                }
            }
            if open == 0 {
                return Some(());
            }
        }
    }

    /// Moves to the value of a key of the object that starts here. `Some(None)`: the object lacks the key.
    fn enter_object(&mut self, key: &str) -> Option<Option<Entered>> {
        self.at += 1;
        loop {
            self.space();
            if self.peek()? == b'}' {
                return Some(None);
            }
            let place = self.string()?;
            self.space();
            if self.peek()? != b':' {
                return None;
            }
            self.at += 1;
            self.space();
            let name = serde_json::from_str::<String>(self.text.get(place.start..place.end)?).ok()?;
            if name == key {
                return Some(Some(Entered(Some(place))));
            }
            self.skip_value()?;
            self.space();
            match self.peek()? {
                b',' => self.at += 1,
                b'}' => return Some(None),
                _ => return None,
            }
        }
    }

    /// Moves to an element of the array that starts here. `Some(None)`: the array is shorter.
    fn enter_array(&mut self, index: &str) -> Option<Option<Entered>> {
        let Ok(index) = index.parse::<usize>() else { return Some(None) };
        self.at += 1;
        for _ in 0..index {
            self.space();
            if self.peek()? == b']' {
                return Some(None);
            }
            self.skip_value()?;
            self.space();
            match self.peek()? {
                b',' => self.at += 1,
                b']' => return Some(None),
                _ => return None,
            }
        }
        self.space();
        if self.peek()? == b']' { Some(None) } else { Some(Some(Entered(None))) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(text: &str, dotted: &str) -> (String, usize) {
        let path: Vec<String> = dotted.split('.').map(str::to_owned).collect();
        let found = locate(text, &path).unwrap();
        (text[found.value.start..found.value.end].to_owned(), found.depth)
    }

    #[test]
    fn values_are_found_through_objects_arrays_and_escapes() {
        let text = r#"{ "a": [1, {"b,}": "x\"]"}, [2, 3.5e1]], "\u0063": {"d": true} }"#;
        assert_eq!(at(text, "a.0"), ("1".into(), 2));
        assert_eq!(at(text, "a.1.b,}"), (r#""x\"]""#.into(), 3));
        assert_eq!(at(text, "a.2.1"), ("3.5e1".into(), 3));
        assert_eq!(at(text, "c.d"), ("true".into(), 2));
        assert_eq!(at(text, "c.missing"), (r#"{"d": true}"#.into(), 1));
        assert_eq!(at(r#"{"g": {"a": 0, "a.b.c": [5, 6]}}"#, "g.a.b.c.1"), ("0".into(), 2));
        assert_eq!(at(r#"{"g": {"a.b.c": [5, 6]}}"#, "g.a.b.c.1"), ("6".into(), 5));
        assert_eq!(at(text, "a.7"), (r#"[1, {"b,}": "x\"]"}, [2, 3.5e1]]"#.into(), 1));
    }

    #[test]
    fn lines_and_columns_count_characters_and_come_back() {
        let text = "{\n  \"\u{e9}\": 1\n}";
        assert_eq!(line_column(text, text.find('1').unwrap()), (2, 8));
        assert_eq!(line_column("", 0), (1, 1));
        assert_eq!(byte_of(text, 2, 9), text.find('1').unwrap());
        assert_eq!(byte_of(text, 99, 99), text.len());
    }

    #[test]
    fn broken_text_gives_none_or_an_ancestor_and_never_panics() {
        let text = r#"{"a": [1, {"b": "\u00e9"}], "c": "#;
        for end in 0..text.len() {
            for path in ["a.1.b", "c", "a.9"] {
                let path: Vec<String> = path.split('.').map(str::to_owned).collect();
                if let Some(found) = locate(&text[..end], &path) {
                    assert!(found.value.end <= end);
                }
            }
        }
    }
}
