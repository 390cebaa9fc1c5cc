//! A page as pixels on white, 300 to the inch, for slides and programs that show no vectors.

use super::{Ink, Mark, Page, Words, font};
use tiny_skia::{Color, FillRule, LineJoin, Paint, Path, Pixmap, Stroke, Transform};

/// Pixels in a point, and in a metre.
const PIXELS_A_POINT: f32 = 300.0 / 72.0;
const PIXELS_A_METRE: u32 = 11_811;

impl Page {
    pub(super) fn png(&self) -> Result<Vec<u8>, String> {
        let scale = self.points * PIXELS_A_POINT;
        let [width, height] = self.size.map(|side| (side * scale).round() as u32);
        let mut pixels =
            Pixmap::new(width, height).ok_or_else(|| format!("no picture has {width} by {height} pixels"))?;
        pixels.fill(Color::WHITE);
        let scaled = Transform::from_scale(scale, scale);
        for mark in &self.marks {
            match mark {
                Mark::Shape(shape) => {
                    fill(&mut pixels, &shape.path, shape.fill, scaled);
                    if let Some((ink, width)) = shape.line {
                        let stroke = Stroke { width, line_join: LineJoin::Round, ..Stroke::default() };
                        pixels.stroke_path(&shape.path, &paint(ink), &stroke, scaled, None);
                    }
                }
                Mark::Words(words) => {
                    if let Some(path) = font::outline(&words.text, words.size) {
                        fill(&mut pixels, &path, Some(words.ink), placed(words).post_concat(scaled));
                    }
                }
            }
        }
        encoded(&pixels).map_err(|fault| fault.to_string())
    }
}

/// From a line of words that begins at the origin to its place.
fn placed(words: &Words) -> Transform {
    let turned = if words.upward { Transform::from_rotate(-90.0) } else { Transform::identity() };
    Transform::from_translate(-words.before(), 0.0).post_concat(turned).post_translate(words.at[0], words.at[1])
}

fn fill(pixels: &mut Pixmap, path: &Path, ink: Option<Ink>, transform: Transform) {
    if let Some(ink) = ink {
        pixels.fill_path(path, &paint(ink), FillRule::Winding, transform, None);
    }
}

fn paint(ink: Ink) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    let [r, g, b] = ink.rgb;
    paint.set_color_rgba8(r, g, b, (ink.alpha * 255.0).round() as u8);
    paint
}

fn encoded(pixels: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    let dims = png::PixelDimensions { xppu: PIXELS_A_METRE, yppu: PIXELS_A_METRE, unit: png::Unit::Meter };
    encoder.set_pixel_dims(Some(dims));
    // On white nothing shines through.
    let rgb: Vec<u8> = pixels.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
    encoder.write_header()?.write_image_data(&rgb)?;
    Ok(bytes)
}
