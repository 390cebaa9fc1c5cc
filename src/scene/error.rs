//! Why a scene was refused: the problem, its location, and what was expected.

#[cfg(feature = "files")]
use super::excerpt::Excerpt;
#[cfg(feature = "files")]
use super::place::Place;
#[cfg(feature = "files")]
use miette::{Diagnostic, LabeledSpan, SourceCode};
use std::borrow::Cow;
use std::fmt;

/// The longest name, key or message, in characters. A longer one loses its middle, so that a message fits a terminal
/// whatever the scene contains. No message of the program itself is longer.
const LONGEST_KEY: usize = 200;
const LONGEST_MESSAGE: usize = 1_000;

/// The kind of fault in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FaultKind {
    /// A file could not be read.
    Io,
    /// No built-in scene has the name.
    UnknownScene,
    /// The text is not JSON.
    Syntax,
    /// A key that does not exist.
    UnknownKey,
    /// A required key is missing.
    MissingKey,
    /// A key that appears twice in one object.
    DuplicateKey,
    /// A value of the wrong type.
    WrongType,
    /// A value that is not allowed, by itself or in combination with others.
    BadValue,
    /// A scene larger than a run can hold.
    TooLarge,
    /// An override that is not `KEY=VALUE`, or whose key cannot be resolved.
    BadOverride,
    /// A rule of `generate` could not place its bodies.
    Placement,
    /// The caller requested a stop while bodies were placed.
    Interrupted,
}

/// A scene was refused.
///
/// It has the key (dotted: `bodies.0.position.1`, as in overrides), and, for a scene read from text, the line and the
/// column. With the feature `files` it is a `miette::Diagnostic` that points into the text.
///
/// ```
/// # #[cfg(feature = "files")] {
/// let error = relcp::Scene::parse("{\n  \"name\": \"x\",\n  \"tme\": {}\n}", "x.json").unwrap_err();
/// assert_eq!((error.key(), error.line(), error.column()), ("tme", Some(3), Some(3)));
/// assert!(error.to_string().contains("`time`"));
/// # }
/// ```
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct SceneError(Box<Fault>);

#[derive(Debug)]
struct Fault {
    kind: FaultKind,
    origin: Option<String>,
    key: String,
    message: String,
    help: Option<String>,
    #[cfg(feature = "files")]
    excerpt: Option<Excerpt>,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(origin) = &self.origin {
            write!(f, "{}", shortened(origin, LONGEST_KEY))?;
            if let Some((line, column)) = self.line_column() {
                write!(f, ":{line}:{column}")?;
            }
            write!(f, ": ")?;
        }
        if !self.key.is_empty() {
            write!(f, "{}: ", shortened(&self.key, LONGEST_KEY))?;
        }
        write!(f, "{}", shortened(&self.message, LONGEST_MESSAGE))
    }
}

impl Fault {
    #[cfg(feature = "files")]
    fn line_column(&self) -> Option<(usize, usize)> {
        self.excerpt.as_ref().map(|excerpt| excerpt.line_column)
    }

    #[cfg(not(feature = "files"))]
    fn line_column(&self) -> Option<(usize, usize)> {
        None
    }
}

/// The text, or if it has more than `longest` characters, both ends of it.
pub(super) fn shortened(text: &str, longest: usize) -> Cow<'_, str> {
    let count = text.chars().count();
    if count <= longest {
        return text.into();
    }
    let half = longest / 2;
    let head: String = text.chars().take(half).collect();
    let tail: String = text.chars().skip(count - half).collect();
    format!("{head} … {tail}").into()
}

impl SceneError {
    pub(crate) fn new(kind: FaultKind, key: impl fmt::Display, message: impl Into<String>) -> Self {
        SceneError(Box::new(Fault {
            kind,
            origin: None,
            key: key.to_string(),
            message: message.into(),
            help: None,
            #[cfg(feature = "files")]
            excerpt: None,
        }))
    }

    pub(crate) fn bad(key: impl fmt::Display, message: impl Into<String>) -> Self {
        Self::new(FaultKind::BadValue, key, message)
    }

    pub(crate) fn with_help(mut self, help: impl Into<String>) -> Self {
        self.0.help = Some(help.into());
        self
    }

    /// The same fault of a key below another one, without a location.
    #[cfg(feature = "files")]
    pub(crate) fn under(mut self, key: &str) -> Self {
        (self.0.origin, self.0.excerpt) = (None, None);
        self.0.key = format!("{key}.{}", self.0.key);
        self
    }

    /// Sets the origin of the text with the fault, without a location.
    #[cfg(feature = "files")]
    pub(crate) fn of(mut self, origin: &str) -> Self {
        self.0.origin = Some(origin.to_owned());
        self
    }

    /// Sets the location of the fault to a range of bytes of the text.
    #[cfg(feature = "files")]
    pub(crate) fn at(mut self, origin: &str, text: &str, place: Place) -> Self {
        self.0.excerpt = Some(Excerpt::of(&shortened(origin, LONGEST_KEY), text, place));
        self.of(origin)
    }

    /// Shows the fault in this text instead, in which every byte has the same offset as in the text that was parsed.
    #[cfg(feature = "files")]
    pub(crate) fn shown_in(mut self, text: &str) -> Self {
        if let (Some(excerpt), Some(origin)) = (&self.0.excerpt, &self.0.origin) {
            self.0.excerpt = Some(Excerpt::of(&shortened(origin, LONGEST_KEY), text, excerpt.place));
        }
        self
    }

    /// The kind of fault.
    pub fn kind(&self) -> FaultKind {
        self.0.kind
    }

    /// The dotted key of the fault; empty for the scene as a whole.
    pub fn key(&self) -> &str {
        &self.0.key
    }

    /// The problem and the expected value, without the location.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// A hint, if there is one.
    pub fn help_text(&self) -> Option<&str> {
        self.0.help.as_deref()
    }

    /// The file, built-in scene or override concerned.
    pub fn origin(&self) -> Option<&str> {
        self.0.origin.as_deref()
    }

    /// The line, from 1, if the scene was read from text.
    pub fn line(&self) -> Option<usize> {
        self.0.line_column().map(|p| p.0)
    }

    /// The column in characters, from 1, if the scene was read from text.
    pub fn column(&self) -> Option<usize> {
        self.0.line_column().map(|p| p.1)
    }
}

#[cfg(feature = "files")]
impl Diagnostic for SceneError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.0.help.as_ref().map(|h| Box::new(h) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.excerpt.as_ref().map(|excerpt| excerpt as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.0.excerpt.as_ref()?.place;
        let label = LabeledSpan::new(Some("here".to_owned()), place.start, place.end - place.start);
        Some(Box::new(std::iter::once(label)))
    }
}
