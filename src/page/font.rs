//! The letters of a page: Roboto Regular, in the program itself, as a machine may have no font.

use tiny_skia::{Path, PathBuilder, Transform};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// See `assets/fonts/README.md` for where it is from.
pub(super) const BYTES: &[u8] = include_bytes!("../../assets/fonts/Roboto-Regular.ttf");

/// The font's name, in files that name it.
pub(super) const NAME: &str = "Roboto";

/// The width of a letter that the font does not have, in parts of an em.
const UNKNOWN: f32 = 0.5;

/// The font; `None` is a fault of the program that a test finds.
pub(super) fn face() -> Option<Face<'static>> {
    Face::parse(BYTES, 0).ok()
}

/// Glyphs of a text and how far each moves on, in parts of an em. Letters that the font does not have are its box.
pub(super) fn glyphs(face: &Face<'_>, text: &str) -> Vec<(char, GlyphId, f32)> {
    let em = f32::from(face.units_per_em());
    let glyph = |letter: char| {
        let id = face.glyph_index(letter).unwrap_or(GlyphId(0));
        (letter, id, face.glyph_hor_advance(id).map_or(UNKNOWN, |advance| f32::from(advance) / em))
    };
    text.chars().map(glyph).collect()
}

/// The width of a text whose em is `size` high.
pub(crate) fn width_of(text: &str, size: f32) -> f32 {
    face().map_or(0.0, |face| size * glyphs(&face, text).iter().map(|(.., advance)| advance).sum::<f32>())
}

/// The outline of a text that begins at the origin, for an em of `size`, y down.
pub(crate) fn outline(text: &str, size: f32) -> Option<Path> {
    let face = face()?;
    let scale = size / f32::from(face.units_per_em());
    let (mut pen, mut x) = (Pen(PathBuilder::new()), 0.0);
    for (_, glyph, advance) in glyphs(&face, text) {
        let mut own = Pen(PathBuilder::new());
        if face.outline_glyph(glyph, &mut own).is_some() {
            let placed = Transform::from_row(scale, 0.0, 0.0, -scale, x, 0.0);
            if let Some(path) = own.0.finish().and_then(|path| path.transform(placed)) {
                pen.0.push_path(&path);
            }
        }
        x += size * advance;
    }
    pen.0.finish()
}

struct Pen(PathBuilder);

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.0.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.0.close();
    }
}
