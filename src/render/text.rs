//! Text and marks in a picture: the letters of the program's own font, as large as the picture asks.

use super::Image;
use crate::page::{outline, width_of};
use tiny_skia::{Color, FillRule, LineJoin, Paint, Path, Pixmap, Stroke, Transform};

/// A mark has one more pixel per side for every this many rows of the picture.
const ROWS_A_DOT: u32 = 540;
/// Rows of the picture to a letter's em: 14 pixels in a picture of 540 rows, as in captions of figures.
const ROWS_AN_EM: f32 = 540.0 / 14.0;
/// The least em in pixels that can be read.
const LEAST_EM: f32 = 12.0;
/// The height of capitals and digits, in parts of an em: that of Roboto.
const CAPITAL: f32 = 0.711;
/// The width of the paper around letters, in parts of an em.
const RIM: f32 = 0.35;
/// Pictures narrower or lower than this, in pixels, have no text.
const LEAST_SIDE: u32 = 160;

/// Left, top, width and height in pixels.
pub(super) type Mark = [usize; 4];

/// Pixels along a dot's side; `None` if the picture is too small for text.
pub(super) fn dot(image: &Image) -> Option<usize> {
    (image.width.min(image.height) >= LEAST_SIDE).then(|| (image.height / ROWS_A_DOT).max(1) as usize)
}

/// The em of a picture's text in pixels.
pub(super) fn em(image: &Image) -> f32 {
    (image.height as f32 / ROWS_AN_EM).max(LEAST_EM)
}

/// The width of a text in pixels.
pub(super) fn width(text: &str, em: f32) -> usize {
    width_of(text, em).ceil() as usize
}

/// The height of its capitals in pixels.
pub(super) fn height(em: f32) -> usize {
    (CAPITAL * em).round() as usize
}

/// Writes a text whose capitals' top left corner is at `left` and `top` in `ink`, on a rim of `paper` so that it is
/// legible over bodies.
pub(super) fn write(image: &mut Image, text: &str, [left, top]: [usize; 2], em: f32, [ink, paper]: [[u8; 3]; 2]) {
    let (rim, high) = ((RIM * em).ceil() as usize, height(em));
    // Descenders, too.
    let (wide, tall) = (width(text, em) + 2 * rim, high + 2 * rim + em as usize / 3);
    let Some(path) = outline(text, em) else { return };
    let Some(mut pixels) = Pixmap::new(wide as u32, tall as u32) else { return };
    let place = Transform::from_translate(rim as f32, (rim + high) as f32);
    let rounded = Stroke { width: RIM * em, line_join: LineJoin::Round, ..Stroke::default() };
    for (colour, stroke) in [(paper, Some(&rounded)), (ink, None)] {
        put(&mut pixels, &path, colour, stroke, place);
    }
    let columns = image.width as usize;
    for (k, pixel) in pixels.pixels().iter().enumerate() {
        let (x, y) = ((left + k % wide).wrapping_sub(rim), (top + k / wide).wrapping_sub(rim));
        if x >= columns || y >= image.height as usize {
            continue;
        }
        let kept = 255 - u32::from(pixel.alpha());
        let own = [pixel.red(), pixel.green(), pixel.blue()];
        for (below, own) in image.pixels[3 * (y * columns + x)..][..3].iter_mut().zip(own) {
            *below = (u32::from(own) + (u32::from(*below) * kept + 127) / 255).min(255) as u8;
        }
    }
}

fn put(pixels: &mut Pixmap, path: &Path, [r, g, b]: [u8; 3], stroke: Option<&Stroke>, place: Transform) {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color(Color::from_rgba8(r, g, b, 255));
    match stroke {
        Some(stroke) => pixels.stroke_path(path, &paint, stroke, place, None),
        None => pixels.fill_path(path, &paint, FillRule::Winding, place, None),
    }
}

/// Draws marks in `ink`, edged by `paper` so that they are legible over bodies.
pub(super) fn draw(image: &mut Image, marks: &[Mark], dot: usize, ink: [u8; 3], paper: [u8; 3]) {
    for &[x, y, width, height] in marks {
        let (left, top) = (x.saturating_sub(dot), y.saturating_sub(dot));
        fill(image, [left, top, x - left + width + dot, y - top + height + dot], paper);
    }
    for &mark in marks {
        fill(image, mark, ink);
    }
}

/// Fills the part of a rectangle that is inside the picture.
pub(super) fn fill(image: &mut Image, [x, y, width, height]: Mark, colour: [u8; 3]) {
    let columns = image.width as usize;
    for row in y..(y + height).min(image.height as usize) {
        for column in x..(x + width).min(columns) {
            image.pixels[3 * (row * columns + column)..][..3].copy_from_slice(&colour);
        }
    }
}

/// A number with at most `digits` significant digits, with an exponent instead of many zeros.
pub(super) fn number(value: f64, digits: usize) -> String {
    let short = format!("{value:.*e}", digits.saturating_sub(1));
    match short.parse::<f64>() {
        Ok(0.0) => "0".into(),
        Ok(rounded) if (1e-3..1e6).contains(&rounded.abs()) => rounded.to_string(),
        Ok(rounded) => format!("{rounded:e}"),
        Err(_) => short,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blank(width: u32, height: u32) -> Image {
        Image { width, height, pixels: vec![255; (3 * width * height) as usize], alpha: None }
    }

    #[test]
    fn letters_are_as_large_as_the_picture_asks_and_stand_where_they_are_put() {
        for scale in [1_u32, 2, 4] {
            let mut image = blank(400 * scale, 540 * scale);
            let em = em(&image);
            write(&mut image, "H0l", [20 * scale as usize; 2], em, [[0; 3], [255; 3]]);
            let dark = |x: u32, y: u32| image.pixel(x, y).is_some_and(|[r, ..]| r < 128);
            let inked: Vec<(u32, u32)> = (0..image.height)
                .flat_map(|y| (0..image.width).map(move |x| (x, y)))
                .filter(|(x, y)| dark(*x, *y))
                .collect();
            let span = |of: fn(&(u32, u32)) -> u32| {
                let all = || inked.iter().map(of);
                (all().min().unwrap(), all().max().unwrap() + 1)
            };
            let ((left, right), (top, bottom)) = (span(|at| at.0), span(|at| at.1));
            let near = |a: u32, b: u32| a.abs_diff(b) <= 2 * scale;
            assert!(near(left, 21 * scale) && near(right, 20 * scale + width("H0l", em) as u32), "{left} {right}");
            assert!(near(top, 20 * scale) && near(bottom, 20 * scale + height(em) as u32), "{top} {bottom}");
        }
        assert_eq!(em(&blank(400, 300)), LEAST_EM);
    }

    #[test]
    fn numbers_are_short() {
        for (value, expected) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.123_456, "0.1235"),
            (131_072.0, "131100"),
            (1234.56, "1235"),
            (2.5e-7, "2.5e-7"),
            (-3.0e9, "-3e9"),
        ] {
            assert_eq!(number(value, 4), expected);
        }
    }

    #[test]
    fn what_is_outside_the_picture_is_left_out() {
        let mut image = Image { width: 20, height: 10, pixels: vec![255; 600], alpha: None };
        write(&mut image, "wide words", [15, 8], 12.0, [[0; 3], [255; 3]]);
        assert!((0..14).all(|x| (0..10).all(|y| image.pixel(x, y) == Some([255; 3]))));
        draw(&mut image, &[[0, 0, 2, 2]], 3, [0; 3], [200; 3]);
        assert_eq!(
            (image.pixel(1, 1), image.pixel(4, 4), image.pixel(6, 6)),
            (Some([0; 3]), Some([200; 3]), Some([255; 3]))
        );
    }
}
