//! A page as PDF (ISO 32000), with the letters in it: publishers refuse files whose fonts are not embedded.

use super::{Ink, Mark, Page, Shape, Words, font};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::{CidFontType, FontFlags, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use std::collections::BTreeMap;
use std::io::Write;
use tiny_skia::PathSegment;
use ttf_parser::Face;

/// Numbers of the file's objects. Those of opacities follow.
const CATALOG: i32 = 1;
const PAGES: i32 = 2;
const PAGE: i32 = 3;
const CONTENT: i32 = 4;
const FONT: i32 = 5;
const GLYPHS: i32 = 6;
const DESCRIPTOR: i32 = 7;
const FONT_FILE: i32 = 8;
const LETTERS: i32 = 9;
const INFO: i32 = 10;
const OPACITIES: i32 = 11;

const FONT_NAME: Name<'_> = Name(b"F");

/// Glyphs are named by their number in the font.
const IDENTITY: SystemInfo<'_> = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

/// What a font descriptor gives the stems of an upright font of usual weight.
const STEM: f32 = 80.0;

impl Page {
    pub(super) fn pdf(&self) -> Result<Vec<u8>, String> {
        let face = font::face().ok_or("the font of figures cannot be read")?;
        let opacities = self.opacities();
        let [wide, high] = self.size.map(|side| side * self.points);
        let content = packed(&self.content(&face, &opacities, high))?;
        let mut pdf = Pdf::new();
        pdf.catalog(Ref::new(CATALOG)).pages(Ref::new(PAGES));
        pdf.pages(Ref::new(PAGES)).kids([Ref::new(PAGE)]).count(1);
        let mut page = pdf.page(Ref::new(PAGE));
        page.parent(Ref::new(PAGES)).media_box(Rect::new(0.0, 0.0, wide, high)).contents(Ref::new(CONTENT));
        let mut resources = page.resources();
        resources.fonts().pair(FONT_NAME, Ref::new(FONT));
        let mut states = resources.ext_g_states();
        for number in opacities.values() {
            states.pair(Name(opacity_name(*number).as_bytes()), Ref::new(OPACITIES + number));
        }
        states.finish();
        resources.finish();
        page.finish();
        pdf.stream(Ref::new(CONTENT), &content).filter(Filter::FlateDecode);
        for (alpha, number) in &opacities {
            let alpha = f32::from(*alpha) / 255.0;
            pdf.ext_graphics(Ref::new(OPACITIES + number)).non_stroking_alpha(alpha).stroking_alpha(alpha);
        }
        self.embed(&mut pdf, &face)?;
        pdf.document_info(Ref::new(INFO)).title(TextStr(&self.title));
        Ok(pdf.finish())
    }

    /// Opacities that occur, in 255 parts, and their numbers.
    fn opacities(&self) -> BTreeMap<u8, i32> {
        let inks = self.marks.iter().flat_map(|mark| match mark {
            Mark::Shape(shape) => [shape.fill, shape.line.map(|(ink, _)| ink)],
            Mark::Words(words) => [Some(words.ink), None],
        });
        let mut all: Vec<u8> = inks.flatten().map(part).collect();
        all.sort_unstable();
        all.dedup();
        all.into_iter().zip(0..).collect()
    }

    fn content(&self, face: &Face<'_>, opacities: &BTreeMap<u8, i32>, high: f32) -> Vec<u8> {
        let mut content = Content::new();
        // From units with y down to points with y up.
        content.transform([self.points, 0.0, 0.0, -self.points, 0.0, high]);
        content.set_line_join(LineJoinStyle::RoundJoin);
        for mark in &self.marks {
            match mark {
                Mark::Shape(shape) => {
                    if let Some(ink) = shape.fill {
                        opacity(&mut content, opacities, ink);
                        outline(&mut content, shape);
                        content.fill_nonzero();
                    }
                    if let Some((ink, width)) = shape.line {
                        opacity(&mut content, opacities, ink);
                        content.set_line_width(width);
                        outline(&mut content, shape);
                        content.stroke();
                    }
                }
                Mark::Words(words) => {
                    opacity(&mut content, opacities, words.ink);
                    write_words(&mut content, face, words);
                }
            }
        }
        content.finish().to_vec()
    }

    /// The font: its glyphs by number, their widths, and the letters that they stand for.
    fn embed(&self, pdf: &mut Pdf, face: &Face<'_>) -> Result<(), String> {
        let per_em = 1000.0 / f32::from(face.units_per_em());
        let name = Name(font::NAME.as_bytes());
        let mut outer = pdf.type0_font(Ref::new(FONT));
        outer.base_font(name).encoding_predefined(Name(b"Identity-H"));
        outer.descendant_font(Ref::new(GLYPHS)).to_unicode(Ref::new(LETTERS));
        outer.finish();
        let mut inner = pdf.cid_font(Ref::new(GLYPHS));
        inner.subtype(CidFontType::Type2).base_font(name).system_info(IDENTITY);
        inner.font_descriptor(Ref::new(DESCRIPTOR)).cid_to_gid_map_predefined(Name(b"Identity"));
        let widths = (0..face.number_of_glyphs())
            .map(|glyph| per_em * f32::from(face.glyph_hor_advance(ttf_parser::GlyphId(glyph)).unwrap_or(0)));
        inner.widths().consecutive(0, widths);
        inner.finish();
        let size = face.global_bounding_box();
        let scaled = |value: i16| per_em * f32::from(value);
        let bounds = [size.x_min, size.y_min, size.x_max, size.y_max].map(scaled);
        let cap = scaled(face.capital_height().unwrap_or(face.ascender()));
        let mut descriptor = pdf.font_descriptor(Ref::new(DESCRIPTOR));
        descriptor.name(name).flags(FontFlags::NON_SYMBOLIC).italic_angle(0.0).cap_height(cap).stem_v(STEM);
        descriptor.bbox(Rect::new(bounds[0], bounds[1], bounds[2], bounds[3]));
        descriptor.ascent(scaled(face.ascender())).descent(scaled(face.descender()));
        descriptor.font_file2(Ref::new(FONT_FILE));
        descriptor.finish();
        let file = packed(font::BYTES)?;
        let length = i32::try_from(font::BYTES.len()).map_err(|fault| fault.to_string())?;
        let mut stream = pdf.stream(Ref::new(FONT_FILE), &file);
        stream.filter(Filter::FlateDecode).pair(Name(b"Length1"), length);
        stream.finish();
        let mut letters = UnicodeCmap::new(Name(b"Letters"), IDENTITY);
        for (glyph, letter) in self.letters(face) {
            letters.pair(glyph, letter);
        }
        pdf.cmap(Ref::new(LETTERS), &letters.finish());
        Ok(())
    }

    /// The glyphs of the page's words and their letters.
    fn letters(&self, face: &Face<'_>) -> BTreeMap<u16, char> {
        let words = self.marks.iter().filter_map(|mark| match mark {
            Mark::Words(words) => Some(words),
            Mark::Shape(_) => None,
        });
        words.flat_map(|words| font::glyphs(face, &words.text)).map(|(letter, glyph, _)| (glyph.0, letter)).collect()
    }
}

fn part(ink: Ink) -> u8 {
    (ink.alpha * 255.0).round() as u8
}

fn opacity_name(number: i32) -> String {
    format!("A{number}")
}

fn opacity(content: &mut Content, opacities: &BTreeMap<u8, i32>, ink: Ink) {
    if let Some(number) = opacities.get(&part(ink)) {
        content.set_parameters(Name(opacity_name(*number).as_bytes()));
    }
    let [r, g, b] = ink.rgb.map(|value| f32::from(value) / 255.0);
    content.set_fill_rgb(r, g, b).set_stroke_rgb(r, g, b);
}

fn outline(content: &mut Content, shape: &Shape) {
    let mut last = tiny_skia::Point::zero();
    for segment in shape.path.segments() {
        match segment {
            PathSegment::MoveTo(p) => content.move_to(p.x, p.y),
            PathSegment::LineTo(p) => content.line_to(p.x, p.y),
            // PDF has cubic curves alone.
            PathSegment::QuadTo(a, p) => {
                let toward = |from: f32, to: f32| from + 2.0 / 3.0 * (to - from);
                content.cubic_to(toward(last.x, a.x), toward(last.y, a.y), toward(p.x, a.x), toward(p.y, a.y), p.x, p.y)
            }
            PathSegment::CubicTo(a, b, p) => content.cubic_to(a.x, a.y, b.x, b.y, p.x, p.y),
            PathSegment::Close => content.close_path(),
        };
        if let PathSegment::MoveTo(p)
        | PathSegment::LineTo(p)
        | PathSegment::QuadTo(_, p)
        | PathSegment::CubicTo(_, _, p) = segment
        {
            last = p;
        }
    }
}

fn write_words(content: &mut Content, face: &Face<'_>, words: &Words) {
    let glyphs: Vec<u8> =
        font::glyphs(face, &words.text).iter().flat_map(|(_, glyph, _)| glyph.0.to_be_bytes()).collect();
    let ([x, y], before) = (words.at, words.before());
    // Letters stand upright although y points down.
    let place = match words.upward {
        false => [1.0, 0.0, 0.0, -1.0, x - before, y],
        true => [0.0, -1.0, -1.0, 0.0, x, y + before],
    };
    content.begin_text().set_font(FONT_NAME, words.size).set_text_matrix(place).show(Str(&glyphs)).end_text();
}

fn packed(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).map_err(|fault| fault.to_string())
}
