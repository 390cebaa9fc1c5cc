//! Text and marks in a picture, in a built-in dot font, without fonts of the machine.

use super::Image;

/// Dots of a glyph: rows of five bits, the leftmost highest.
pub(super) const GLYPH: [usize; 2] = [5, 7];
/// Dots from one glyph to the next.
const ADVANCE: usize = GLYPH[0] + 1;
/// A dot has one more pixel per side for every this many rows of the picture.
const ROWS_A_DOT: u32 = 540;
/// Pictures narrower or lower than this, in pixels, have no text.
const LEAST_SIDE: u32 = 160;

const GLYPHS: [(char, [u8; GLYPH[1]]); 42] = [
    ('0', [14, 17, 17, 17, 17, 17, 14]),
    ('1', [4, 12, 4, 4, 4, 4, 14]),
    ('2', [14, 17, 1, 6, 8, 16, 31]),
    ('3', [14, 17, 1, 6, 1, 17, 14]),
    ('4', [2, 6, 10, 18, 31, 2, 2]),
    ('5', [31, 16, 30, 1, 1, 17, 14]),
    ('6', [14, 16, 16, 30, 17, 17, 14]),
    ('7', [31, 1, 2, 2, 4, 4, 4]),
    ('8', [14, 17, 17, 14, 17, 17, 14]),
    ('9', [14, 17, 17, 15, 1, 1, 14]),
    ('.', [0, 0, 0, 0, 0, 4, 4]),
    ('-', [0, 0, 0, 14, 0, 0, 0]),
    ('+', [0, 4, 4, 31, 4, 4, 0]),
    ('=', [0, 0, 31, 0, 31, 0, 0]),
    ('>', [8, 4, 2, 1, 2, 4, 8]),
    (' ', [0; GLYPH[1]]),
    ('a', [0, 0, 14, 1, 15, 17, 15]),
    ('b', [16, 16, 30, 17, 17, 17, 30]),
    ('c', [0, 0, 14, 16, 16, 17, 14]),
    ('d', [1, 1, 15, 17, 17, 17, 15]),
    ('e', [0, 0, 14, 17, 31, 16, 14]),
    ('f', [6, 9, 8, 28, 8, 8, 8]),
    ('g', [0, 0, 15, 17, 15, 1, 14]),
    ('h', [16, 16, 30, 17, 17, 17, 17]),
    ('i', [4, 0, 12, 4, 4, 4, 14]),
    ('j', [2, 0, 6, 2, 2, 18, 12]),
    ('k', [16, 16, 18, 20, 24, 20, 18]),
    ('l', [12, 4, 4, 4, 4, 4, 14]),
    ('m', [0, 0, 26, 21, 21, 21, 21]),
    ('n', [0, 0, 30, 17, 17, 17, 17]),
    ('o', [0, 0, 14, 17, 17, 17, 14]),
    ('p', [0, 0, 30, 17, 30, 16, 16]),
    ('q', [0, 0, 15, 17, 15, 1, 1]),
    ('r', [0, 0, 22, 25, 16, 16, 16]),
    ('s', [0, 0, 15, 16, 14, 1, 30]),
    ('t', [8, 8, 28, 8, 8, 9, 6]),
    ('u', [0, 0, 17, 17, 17, 19, 13]),
    ('v', [0, 0, 17, 17, 17, 10, 4]),
    ('w', [0, 0, 17, 17, 21, 21, 10]),
    ('x', [0, 0, 17, 10, 4, 10, 17]),
    ('y', [0, 0, 17, 17, 15, 1, 14]),
    ('z', [0, 0, 31, 2, 4, 8, 31]),
];

/// Left, top, width and height in pixels.
pub(super) type Mark = [usize; 4];

/// Pixels along a dot's side; `None` if the picture is too small for text.
pub(super) fn dot(image: &Image) -> Option<usize> {
    (image.width.min(image.height) >= LEAST_SIDE).then(|| (image.height / ROWS_A_DOT).max(1) as usize)
}

/// The width of a text in pixels.
pub(super) fn width(text: &str, dot: usize) -> usize {
    (text.chars().count() * ADVANCE * dot).saturating_sub(dot)
}

/// The marks of a text whose first letter's top left corner is at `left` and `top`. A letter that the font lacks is
/// blank.
pub(super) fn marks(text: &str, left: usize, top: usize, dot: usize) -> Vec<Mark> {
    let mut marks = Vec::new();
    for (k, letter) in text.chars().enumerate() {
        let Some((_, rows)) = GLYPHS.iter().find(|(glyph, _)| *glyph == letter) else { continue };
        for (row, bits) in rows.iter().enumerate() {
            for column in (0..GLYPH[0]).filter(|c| bits >> (GLYPH[0] - 1 - c) & 1 == 1) {
                marks.push([left + (k * ADVANCE + column) * dot, top + row * dot, dot, dot]);
            }
        }
    }
    marks
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

    #[test]
    fn glyphs_are_all_different() {
        for (k, (letter, rows)) in GLYPHS.iter().enumerate() {
            assert!(GLYPHS[..k].iter().all(|(other, drawn)| other != letter && drawn != rows), "{letter}");
            assert!(rows.iter().all(|row| row >> GLYPH[0] == 0));
        }
    }

    #[test]
    fn numbers_are_short_and_have_glyphs() {
        for (value, expected) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.123_456, "0.1235"),
            (131_072.0, "131100"),
            (1234.56, "1235"),
            (2.5e-7, "2.5e-7"),
            (-3.0e9, "-3e9"),
        ] {
            let text = number(value, 4);
            assert_eq!(text, expected);
            assert!(text.chars().all(|letter| GLYPHS.iter().any(|(glyph, _)| *glyph == letter)));
        }
    }

    #[test]
    fn what_is_outside_the_picture_is_left_out() {
        let mut image = Image { width: 20, height: 10, pixels: vec![255; 600], alpha: None };
        let far = marks("wide words", 15, 5, 1);
        draw(&mut image, &far, 1, [0; 3], [200; 3]);
        draw(&mut image, &[[0, 0, 2, 2]], 3, [0; 3], [200; 3]);
        assert_eq!(
            (image.pixel(1, 1), image.pixel(4, 4), image.pixel(6, 6)),
            (Some([0; 3]), Some([200; 3]), Some([255; 3]))
        );
    }
}
