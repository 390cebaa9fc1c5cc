//! The path of a key during validation, formatted only for a fault.

use std::fmt;

#[derive(Clone, Copy)]
enum Part<'a> {
    Root,
    Name(&'a str),
    Index(usize),
}

/// One key and its path from the root. Displayed dotted: `bodies.0.position.1`.
#[derive(Clone, Copy)]
pub(super) struct Key<'a> {
    parent: Option<&'a Key<'a>>,
    part: Part<'a>,
}

impl Key<'static> {
    /// The scene itself.
    pub const ROOT: Key<'static> = Key { parent: None, part: Part::Root };
}

impl<'a> Key<'a> {
    /// A key of this object.
    pub fn field(&'a self, name: &'a str) -> Key<'a> {
        Key { parent: Some(self), part: Part::Name(name) }
    }

    /// An element of this array.
    pub fn index(&'a self, index: usize) -> Key<'a> {
        Key { parent: Some(self), part: Part::Index(index) }
    }
}

impl fmt::Display for Key<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(parent) = self.parent {
            parent.fmt(f)?;
            if !matches!(parent.part, Part::Root) {
                write!(f, ".")?;
            }
        }
        match self.part {
            Part::Root => Ok(()),
            Part::Name(name) => write!(f, "{name}"),
            Part::Index(index) => write!(f, "{index}"),
        }
    }
}
