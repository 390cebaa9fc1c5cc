//! A bar of a round length with its number, in the lower left corner.

use super::Image;

/// Pictures narrower or lower than this (pixels) have no room for a bar.
const LEAST_SIDE: u32 = 160;
/// The bar takes at most this part of the picture's width.
const LONGEST: f64 = 0.16;
/// Pictures are drawn with one more pixel to a dot for each of these many rows.
const ROWS_A_DOT: u32 = 540;
/// Dots of a glyph: rows of five bits, the leftmost highest.
const GLYPH: [usize; 2] = [5, 7];
const GLYPHS: [(char, [u8; 7]); 13] = [
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
    ('e', [0, 0, 14, 17, 31, 16, 14]),
];

/// Draws the bar in `ink`, edged by `paper` so that it can be read over bodies.
pub(super) fn draw(image: &mut Image, pixels_per_length: f64, ink: [u8; 3], paper: [u8; 3]) {
    if image.width < LEAST_SIDE || image.height < LEAST_SIDE {
        return;
    }
    let Some((length, label)) = round_length(LONGEST * f64::from(image.width) / pixels_per_length) else { return };
    let dot = (image.height / ROWS_A_DOT).max(1) as usize;
    let (left, bottom) = (14 * dot, image.height as usize - 14 * dot);
    let bar = (length * pixels_per_length).round() as usize;
    let mut marks = vec![[left, bottom - 2 * dot, bar, 2 * dot]];
    for x in [left, left + bar.saturating_sub(dot)] {
        marks.push([x, bottom - 5 * dot, dot, 5 * dot]);
    }
    let advance = (GLYPH[0] + 1) * dot;
    let start = left + (bar / 2).saturating_sub((label.len() * advance - dot) / 2);
    for (k, letter) in label.chars().enumerate() {
        let Some((_, rows)) = GLYPHS.iter().find(|(glyph, _)| *glyph == letter) else { continue };
        for (row, bits) in rows.iter().enumerate() {
            for column in (0..GLYPH[0]).filter(|c| bits >> (GLYPH[0] - 1 - c) & 1 == 1) {
                marks.push([start + k * advance + column * dot, bottom - (7 + GLYPH[1] - row) * dot, dot, dot]);
            }
        }
    }
    for &[x, y, width, height] in &marks {
        fill(image, [x - dot, y - dot, width + 2 * dot, height + 2 * dot], paper);
    }
    for &mark in &marks {
        fill(image, mark, ink);
    }
}

/// The greatest of 1, 2 and 5 times a power of ten that is at most `longest`, and how it is written.
fn round_length(longest: f64) -> Option<(f64, String)> {
    if !(longest.is_finite() && longest > 0.0) {
        return None;
    }
    let exponent = longest.log10().floor() as i32;
    [(5, exponent), (2, exponent), (1, exponent), (5, exponent - 1)].into_iter().find_map(|(digit, exponent)| {
        let text = format!("{digit}e{exponent}");
        let length: f64 = text.parse().ok()?;
        let label = if (-3..=4).contains(&exponent) { format!("{length}") } else { text };
        (length > 0.0 && length <= longest).then_some((length, label))
    })
}

fn fill(image: &mut Image, [x, y, width, height]: [usize; 4], colour: [u8; 3]) {
    let columns = image.width as usize;
    for row in y..(y + height).min(image.height as usize) {
        for column in x..(x + width).min(columns) {
            image.pixels[3 * (row * columns + column)..][..3].copy_from_slice(&colour);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_round_and_as_long_as_they_may_be() {
        let label = |longest| round_length(longest).map(|(_, label)| label);
        for (longest, expected) in [
            (1.0, "1"),
            (1.99, "1"),
            (2.0, "2"),
            (4.9, "2"),
            (99.0, "50"),
            (60_000.0, "50000"),
            (300_000.0, "2e5"),
            (0.07, "0.05"),
            (0.0011, "0.001"),
            (0.00099, "5e-4"),
        ] {
            assert_eq!(label(longest).as_deref(), Some(expected), "{longest}");
        }
        for none in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(label(none), None);
        }
    }

    #[test]
    fn the_bar_is_as_long_as_it_says() {
        for scale in [0.37, 1.0, 13.0, 1e5] {
            let mut image = Image { width: 800, height: 600, pixels: vec![255; 800 * 600 * 3] };
            draw(&mut image, scale, [0; 3], [255; 3]);
            let (length, _) = round_length(LONGEST * 800.0 / scale).unwrap();
            let row = 600 - 14 - 1;
            let inked = (0..800).filter(|x| image.pixel(*x, row) == Some([0; 3])).count();
            assert_eq!(inked as f64, (length * scale).round());
        }
    }

    #[test]
    fn every_letter_of_a_label_has_a_glyph() {
        for exponent in -12..12 {
            for digit in [1.0, 2.0, 5.0] {
                let (_, label) = round_length(digit * 10f64.powi(exponent)).unwrap();
                assert!(label.chars().all(|letter| GLYPHS.iter().any(|(glyph, _)| *glyph == letter)), "{label}");
            }
        }
    }
}
