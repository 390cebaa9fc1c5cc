//! Pages of vector marks, written as SVG, PDF or PNG: what figures and vector pictures are made of.
//!
//! Places are in units of the page, x to the right and y down. All three files hold the same marks in the same places;
//! a page has no date and no name of a machine, so that the same marks are the same bytes.

mod font;
mod pdf;
mod png;
mod svg;

pub(crate) use font::{outline, width_of};
pub(crate) use tiny_skia::{Path, PathBuilder};

/// A file's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Format {
    /// Scalable vectors, for browsers and drawing programs.
    Svg,
    /// A page for LaTeX and printers, with its letters in it.
    Pdf,
    /// Pixels, 300 to the inch.
    Png,
}

impl Format {
    /// The end of a file's name.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Svg => "svg",
            Format::Pdf => "pdf",
            Format::Png => "png",
        }
    }
}

/// A colour, and how opaque it is, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ink {
    pub rgb: [u8; 3],
    pub alpha: f32,
}

impl Ink {
    pub fn opaque(rgb: [u8; 3]) -> Self {
        Ink { rgb, alpha: 1.0 }
    }
}

/// An outline that is filled, or drawn with a line of some width, or both.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    pub path: Path,
    pub fill: Option<Ink>,
    pub line: Option<(Ink, f32)>,
}

/// The point of a line of words that stands at their place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Left,
    Middle,
    Right,
}

/// A line of words: `at` is a point of its baseline, `size` the height of an em.
#[derive(Clone, Debug)]
pub(crate) struct Words {
    pub text: String,
    pub at: [f32; 2],
    pub size: f32,
    pub anchor: Anchor,
    /// Read upwards, as the name of a vertical axis is.
    pub upward: bool,
    pub ink: Ink,
}

impl Words {
    /// How far the first letter begins before the place, along the line.
    fn before(&self) -> f32 {
        match self.anchor {
            Anchor::Left => 0.0,
            Anchor::Middle => 0.5 * width_of(&self.text, self.size),
            Anchor::Right => width_of(&self.text, self.size),
        }
    }
}

#[derive(Clone, Debug)]
enum Mark {
    Shape(Shape),
    Words(Words),
}

/// Marks, the later above the earlier.
#[derive(Clone, Debug)]
pub(crate) struct Page {
    /// Width and height in units.
    pub size: [f32; 2],
    /// Points (1/72 inch) in a unit.
    pub points: f32,
    pub title: String,
    marks: Vec<Mark>,
}

impl Page {
    pub fn new(title: &str, size: [f32; 2], points: f32) -> Self {
        Page { size, points, title: title.into(), marks: Vec::new() }
    }

    /// Draws an outline. One without extent (`None`) is no mark.
    pub fn shape(&mut self, path: Option<Path>, fill: Option<Ink>, line: Option<(Ink, f32)>) {
        self.marks.extend(path.map(|path| Mark::Shape(Shape { path, fill, line })));
    }

    pub fn words(&mut self, words: Words) {
        if !words.text.is_empty() {
            self.marks.push(Mark::Words(words));
        }
    }

    /// The file's bytes.
    ///
    /// # Errors
    /// What went wrong, in words: a page without extent, pixels that do not fit into memory.
    pub fn file(&self, format: Format) -> Result<Vec<u8>, String> {
        match format {
            Format::Svg => Ok(self.svg().into_bytes()),
            Format::Pdf => self.pdf(),
            Format::Png => self.png(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Ink = Ink { rgb: [0; 3], alpha: 1.0 };

    /// A grey square and a word beside it, read along both directions.
    fn page() -> Page {
        let mut page = Page::new("a <page>", [200.0, 100.0], 0.5);
        let square = PathBuilder::from_rect(tiny_skia::Rect::from_ltrb(10.0, 20.0, 60.0, 70.0).unwrap());
        page.shape(Some(square), Some(Ink { rgb: [255, 0, 0], alpha: 0.5 }), Some((BLACK, 2.0)));
        let words = Words {
            text: "t < 1 °".into(),
            at: [80.0, 50.0],
            size: 20.0,
            anchor: Anchor::Left,
            upward: false,
            ink: BLACK,
        };
        page.words(words.clone());
        page.words(Words { at: [190.0, 90.0], upward: true, ..words });
        page
    }

    #[test]
    fn an_svg_has_its_size_in_millimetres_and_its_words_escaped() {
        let svg = page().svg();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{svg}");
        assert!(svg.contains("width=\"35.28mm\"") && svg.contains("viewBox=\"0 0 200 100\""), "{svg}");
        assert!(svg.contains("t &lt; 1 °") && svg.contains("<title>a &lt;page&gt;</title>"), "{svg}");
        assert!(svg.contains("fill=\"#ff0000\" fill-opacity=\"0.5\"") && svg.contains("rotate(-90"), "{svg}");
    }

    #[test]
    fn a_png_has_300_pixels_an_inch_and_letters() {
        let bytes = page().file(Format::Png).unwrap();
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        // 100 points by 50.
        assert_eq!((info.width, info.height), (417, 208));
        assert_eq!(reader.info().pixel_dims.unwrap().xppu, 11811);
        let pixel = |x: u32, y: u32| &pixels[3 * (y * info.width + x) as usize..][..3];
        assert_eq!((pixel(2, 2), pixel(73, 94)), (&[255; 3][..], &[255, 127, 127][..]));
        // The words are dark somewhere in their place, and nowhere beyond it.
        let dark = |x: std::ops::Range<u32>, y: std::ops::Range<u32>| {
            y.into_iter().flat_map(|y| x.clone().map(move |x| (x, y))).filter(|(x, y)| pixel(*x, *y)[0] < 100).count()
        };
        assert!(dark(160..330, 60..110) > 100 && dark(350..417, 90..200) > 50);
        assert_eq!(dark(160..330, 110..208), 0);
    }

    #[test]
    fn a_pdf_has_its_letters_and_is_the_same_every_time() {
        let bytes = page().file(Format::Pdf).unwrap();
        assert!(bytes.starts_with(b"%PDF-1.7") && bytes.trim_ascii_end().ends_with(b"%%EOF"));
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("/FontFile2") && text.contains("/MediaBox [0 0 100 50]") && text.contains("/ToUnicode"));
        assert_eq!(bytes, page().file(Format::Pdf).unwrap());
    }

    #[test]
    fn words_are_as_wide_as_their_letters() {
        assert_eq!(width_of("", 10.0), 0.0);
        assert!(width_of("iii", 10.0) < width_of("mmm", 10.0));
        // A letter that the font does not have takes some room, too.
        assert!(width_of("\u{4e00}", 10.0) > 1.0);
    }
}
