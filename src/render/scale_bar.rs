//! A bar of a round length with its number, in the lower left corner.

use super::Image;
use super::text;

/// The largest length of the bar over the picture's width.
pub(super) const LONGEST: f64 = 0.16;

/// Draws the bar in `ink`, edged by `paper` so that it is legible over bodies.
pub(super) fn draw(image: &mut Image, pixels_per_length: f64, ink: [u8; 3], paper: [u8; 3]) {
    let Some(dot) = text::dot(image) else { return };
    let Some((length, label)) = round_length(LONGEST * f64::from(image.width) / pixels_per_length) else { return };
    let (left, bottom) = (14 * dot, image.height as usize - 14 * dot);
    let bar = (length * pixels_per_length).round() as usize;
    let mut marks = vec![[left, bottom - 2 * dot, bar, 2 * dot]];
    for x in [left, left + bar.saturating_sub(dot)] {
        marks.push([x, bottom - 5 * dot, dot, 5 * dot]);
    }
    text::draw(image, &marks, dot, ink, paper);
    let em = text::em(image);
    let start = left + (bar / 2).saturating_sub(text::width(&label, em) / 2);
    text::write(image, &label, [start, bottom.saturating_sub(8 * dot + text::height(em))], em, [ink, paper]);
}

/// The largest of 1, 2 and 5 times a power of ten that is at most `longest`, and its text.
pub(super) fn round_length(longest: f64) -> Option<(f64, String)> {
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
            let mut image = Image { width: 800, height: 600, pixels: vec![255; 800 * 600 * 3], alpha: None };
            draw(&mut image, scale, [0; 3], [255; 3]);
            let (length, _) = round_length(LONGEST * 800.0 / scale).unwrap();
            let row = 600 - 14 - 1;
            let inked = (0..800).filter(|x| image.pixel(*x, row) == Some([0; 3])).count();
            assert_eq!(inked as f64, (length * scale).round());
        }
    }
}
