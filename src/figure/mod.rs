//! Figures that go into a paper as they are: one column or a page wide, text of eight points, colours that colour-blind
//! readers tell apart (Okabe and Ito 2008; times by the viridis scale), the names of curves at their ends or over
//! the axes and not on the data.

pub(crate) mod backend;
pub(crate) mod drawing;
pub(crate) mod ends;
pub(crate) mod head;

pub use crate::page::Format;
use crate::page::Page;

/// A figure, in any of its formats.
#[derive(Clone, Debug)]
pub struct Figure(Page);

impl Figure {
    /// Its file.
    ///
    /// # Errors
    /// A message.
    pub fn file(&self, format: Format) -> Result<Vec<u8>, String> {
        self.0.file(format)
    }

    /// It as SVG.
    pub fn svg(&self) -> String {
        self.0.svg()
    }
}
