//! Writes scenes with all defaults, exact numbers, and one body for each line.

use super::Scene;
use serde::Serialize;
use serde_json::ser::Formatter;
use std::io::{self, Write};

impl Scene {
    /// This scene as JSON: one line a body, numbers that come back to the same bits.
    ///
    /// ```
    /// # use relcp::Scene;
    /// let scene = Scene::built_in("two-ellipsoids")?;
    /// assert_eq!(Scene::parse(&scene.to_json(), "copy")?, scene);
    /// # Ok::<(), relcp::Error>(())
    /// ```
    pub fn to_json(&self) -> String {
        let mut bytes = Vec::new();
        match self.write_json(&mut bytes) {
            Ok(()) => String::from_utf8(bytes).unwrap_or_default(),
            Err(_) => String::new(),
        }
    }

    /// Writes [`Scene::to_json`]'s text.
    ///
    /// # Errors
    /// What the writer fails with.
    pub fn write_json<W: Write>(&self, writer: W) -> io::Result<()> {
        let mut serializer = serde_json::Serializer::with_formatter(writer, SceneFormatter::default());
        self.serialize(&mut serializer)?;
        serializer.into_inner().write_all(b"\n")
    }
}

/// The JSON Schema of scene files, for editors and other programs.
///
/// ```
/// let schema = relcp::scene::schema();
/// assert!(schema["properties"]["time"].is_object());
/// ```
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Scene).to_value()
}

/// The scene's keys and the elements of its lists each on a line of their own, everything deeper on that line.
#[derive(Default)]
struct SceneFormatter {
    /// Open containers: whether each breaks lines.
    open: Vec<bool>,
    /// Whether the container that closes next has an element.
    filled: bool,
}

impl SceneFormatter {
    fn begin<W: ?Sized + Write>(&mut self, writer: &mut W, bracket: &[u8], breaks: bool) -> io::Result<()> {
        self.open.push(breaks);
        self.filled = false;
        writer.write_all(bracket)
    }

    fn end<W: ?Sized + Write>(&mut self, writer: &mut W, bracket: &[u8]) -> io::Result<()> {
        if self.open.pop().unwrap_or(false) && self.filled {
            self.new_line(writer)?;
        } else if self.filled && bracket == b"}" {
            writer.write_all(b" ")?;
        }
        self.filled = true;
        writer.write_all(bracket)
    }

    fn separate<W: ?Sized + Write>(&self, writer: &mut W, first: bool, inset: bool) -> io::Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        if self.open.last().copied().unwrap_or(false) {
            self.new_line(writer)
        } else if !first || inset {
            writer.write_all(b" ")
        } else {
            Ok(())
        }
    }

    fn new_line<W: ?Sized + Write>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        self.open.iter().try_for_each(|_| writer.write_all(b"  "))
    }
}

impl Formatter for SceneFormatter {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        let breaks = self.open.len() == 1;
        self.begin(writer, b"[", breaks)
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.end(writer, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.separate(writer, first, false)
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        let breaks = self.open.is_empty();
        self.begin(writer, b"{", breaks)
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.end(writer, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.separate(writer, first, true)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }
}
