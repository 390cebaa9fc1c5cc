//! The part of a scene's text that a message shows: the line of the fault and its neighbours, cut if they are long.

use super::place::{self, Place};
use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

/// The longest line in bytes; a longer one is cut to fit a terminal.
const LONGEST_LINE: usize = 120;

/// A cut line shows this many bytes before the fault, and as many from its start.
const AROUND: usize = 50;

/// Marks a cut in a line.
const CUT: &str = "…";

/// A few lines of a text, the location of the fault in the whole text, and the fault's line and column, from 1.
#[derive(Debug)]
pub(super) struct Excerpt {
    name: String,
    text: String,
    /// The byte offset of `text` in the whole text.
    start: usize,
    /// The line of that byte, from 0.
    first_line: usize,
    pub place: Place,
    pub line_column: (usize, usize),
}

impl Excerpt {
    /// Takes the line of the fault with the lines before and after it, or a part of the line if it is long.
    pub fn of(name: &str, text: &str, place: Place) -> Self {
        let line_column = place::line_column(text, place.start);
        let line = line_at(text, place.start);
        let short = |line: &Place| line.end - line.start <= LONGEST_LINE;
        let place = Place { start: place.start, end: place.end.clamp(place.start, line.end.max(place.start)) };
        let name = name.to_owned();
        if !short(&line) {
            let (start, text, place) = cut(text, line, place);
            return Excerpt { name, text, start, first_line: line_column.0 - 1, place, line_column };
        }
        let before = line.start.checked_sub(1).map(|byte| line_at(text, byte)).filter(short);
        let after = Some(line.end + 1).filter(|byte| *byte < text.len()).map(|byte| line_at(text, byte)).filter(short);
        let (start, end) = (before.map_or(line.start, |l| l.start), after.map_or(line.end, |l| l.end));
        let first_line = line_column.0 - 1 - usize::from(before.is_some());
        Excerpt { name, text: text[start..end].to_owned(), start, first_line, place, line_column }
    }
}

/// The part of a long line around a location: its byte offset, its text, and the location, clipped to the text. The
/// mark of the cut replaces bytes of the line, so that the location keeps its offset from the start.
fn cut(text: &str, line: Place, place: Place) -> (usize, String, Place) {
    let from = boundary(text, place.start.saturating_sub(AROUND));
    let to = boundary(text, (place.start + AROUND).min(line.end)).max(place.start);
    let head = from >= line.start + CUT.len();
    let start = if head { from - CUT.len() } else { line.start };
    let shown = &text[if head { from } else { line.start }..to];
    let tail = if to < line.end { CUT } else { "" };
    let text = format!("{}{shown}{tail}", if head { CUT } else { "" });
    (start, text, Place { start: place.start, end: place.end.min(to) })
}

/// The last character boundary at or before a byte.
fn boundary(text: &str, mut byte: usize) -> usize {
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

/// The line that contains a byte, without its line end.
fn line_at(text: &str, byte: usize) -> Place {
    let bytes = text.as_bytes();
    let byte = byte.min(bytes.len());
    let start = bytes[..byte].iter().rposition(|b| *b == b'\n').map_or(0, |p| p + 1);
    let end = bytes[byte..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |p| byte + p);
    Place { start, end }
}

impl SourceCode for Excerpt {
    /// These lines are shown whatever lines the caller requests; a request without context lines gets the fault's own
    /// line and column.
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        _: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let whole = SourceSpan::from((self.start, self.text.len()));
        let (span, line, column) = match before {
            0 => (*span, self.line_column.0 - 1, self.line_column.1 - 1),
            _ => (whole, self.first_line, 0),
        };
        let lines = self.text.lines().count();
        let contents =
            MietteSpanContents::new_named(self.name.clone(), self.text.as_bytes(), span, line, column, lines);
        Ok(Box::new(contents))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, start: usize, length: usize) -> Excerpt {
        Excerpt::of("x", text, Place { start, end: start + length })
    }

    /// Checks that the excerpt has the same text at the location as the whole text.
    fn holds(text: &str, start: usize, length: usize) {
        let excerpt = of(text, start, length);
        let Place { start, end } = excerpt.place;
        assert_eq!(excerpt.text[start - excerpt.start..end - excerpt.start], text[start..end]);
        assert!(excerpt.text.len() <= 3 * (LONGEST_LINE + 1), "{} bytes", excerpt.text.len());
    }

    #[test]
    fn short_lines_are_shown_with_their_neighbours() {
        let text = "{\n  \"a\": 1,\n  \"b\": 2,\n  \"c\": 3\n}";
        let excerpt = of(text, text.find("2").unwrap(), 1);
        assert_eq!(excerpt.text, "  \"a\": 1,\n  \"b\": 2,\n  \"c\": 3");
        assert_eq!((excerpt.line_column, excerpt.first_line), ((3, 8), 1));
        for start in 0..text.len() {
            holds(text, start, 1.min(text.len() - start));
        }
    }

    #[test]
    fn long_lines_are_cut_around_the_fault() {
        let body = "{\"shape\":\"ö\",\"position\":[0,1,2]},";
        let text = format!("{{\"bodies\":[{}{{}}]}}", body.repeat(4_000));
        let starts = (0..text.len()).filter(|start| text.is_char_boundary(*start));
        for start in starts.step_by(997).chain([0, 1, 2, 3, 4, text.len() - 1]) {
            let start = (0..=start).rev().find(|byte| text.is_char_boundary(*byte)).unwrap();
            let length = text[start..].chars().next().map_or(0, char::len_utf8);
            holds(&text, start, length);
            assert_eq!(of(&text, start, length).line_column.0, 1);
        }
    }
}
