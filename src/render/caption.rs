//! The text in a run's picture: time and number of bodies in the upper left corner, the colour quantity in the lower
//! right one.

use super::colour::{hue, ramp};
use super::scale::Scale;
use super::text;
use super::{Image, Quantity};
use crate::record::Snapshot;
use glam::Vec3;
use std::f32::consts::PI;

/// The width of the colour scale over that of the picture.
const WIDTH: f64 = 0.16;
/// The thickness of the scale, and the distance of all text from the border, in dots.
const THICKNESS: usize = 5;
const BORDER: usize = 14;
/// The gap between text and the scale, in dots.
const GAP: usize = 5;

/// More groups than these have a scale in place of their names.
const MOST_SWATCHES: usize = 12;

/// The colours of ink and of paper.
pub(super) type Inks = [[u8; 3]; 2];

/// The text of time and number of bodies.
pub(super) fn words(state: &Snapshot) -> String {
    format!("t={}  n={}", text::number(state.time, 6), state.bodies.len())
}

/// The labels at the ends of the colour scale; `None` without a scale.
pub(super) fn ends(quantity: Quantity, scale: Option<Scale>) -> Option<[String; 2]> {
    match (quantity, scale) {
        (Quantity::Plain, _) => None,
        (Quantity::Orientation, _) => Some(["0".into(), "180".into()]),
        (_, None) => None,
        (_, Some(scale)) => {
            let more = if scale.largest > scale.high { ">" } else { "" };
            Some([text::number(scale.low, 4), format!("{more}{}", text::number(scale.high, 4))])
        }
    }
}

/// The linear colour at a part of the scale, from 0 to 1.
pub(super) fn shade(quantity: Quantity, part: f32) -> Vec3 {
    match quantity {
        Quantity::Orientation => hue([(PI * part).cos(), (PI * part).sin()], 0.0),
        _ => ramp(part),
    }
}

/// Writes time and number of bodies.
pub(super) fn state(image: &mut Image, state: &Snapshot, [ink, paper]: Inks) {
    let Some(dot) = text::dot(image) else { return };
    let em = text::em(image);
    text::write(image, &words(state), [BORDER * dot; 2], em, [ink, paper]);
}

/// The name of the colour quantity, and the scale with its ends.
pub(super) fn legend(
    image: &mut Image,
    (quantity, scale): (Quantity, Option<Scale>),
    groups: &[String],
    [ink, paper]: Inks,
) {
    let Some(dot) = text::dot(image) else { return };
    if let (Quantity::Group, Some(scale), 1..=MOST_SWATCHES) = (quantity, scale, groups.len()) {
        return swatches(image, scale, groups, [ink, paper]);
    }
    let Some(ends) = ends(quantity, scale) else { return };
    let width = (WIDTH * f64::from(image.width)) as usize;
    let (right, bottom) = ((image.width as usize).saturating_sub(BORDER * dot), image.height as usize - BORDER * dot);
    let (left, top) = (right.saturating_sub(width), bottom - THICKNESS * dot);
    text::fill(image, [left - dot, top - dot, right - left + 2 * dot, (THICKNESS + 2) * dot], ink);
    for x in left..right {
        let part = (x - left) as f32 / (right - left - 1).max(1) as f32;
        text::fill(image, [x, top, 1, THICKNESS * dot], super::bytes(shade(quantity, part)));
    }
    let em = text::em(image);
    let [above, title] = [1, 2].map(|line| top.saturating_sub(line * (text::height(em) + GAP * dot)));
    let at_right = |words: &str| right.saturating_sub(text::width(words, em));
    let name = quantity.name();
    let middle = left + ((right - left).saturating_sub(text::width(name, em))) / 2;
    for (words, at) in [(&*ends[0], [left, above]), (&ends[1], [at_right(&ends[1]), above]), (name, [middle, title])] {
        text::write(image, words, at, em, [ink, paper]);
    }
}

/// The names of groups, each after its colour, one below the other in the lower right corner.
fn swatches(image: &mut Image, scale: Scale, groups: &[String], [ink, paper]: Inks) {
    let Some(dot) = text::dot(image) else { return };
    let em = text::em(image);
    let (side, line) = (text::height(em), text::height(em) + GAP * dot);
    let widest = groups.iter().map(|name| text::width(name, em)).max().unwrap_or(0);
    let left = (image.width as usize).saturating_sub(BORDER * dot + widest + 2 * side);
    for (k, name) in groups.iter().enumerate() {
        let top = (image.height as usize).saturating_sub(BORDER * dot + (groups.len() - k) * line);
        // Groups are numbered from 1.
        let span = (scale.high - scale.low).max(f64::MIN_POSITIVE);
        let part = (((k + 1) as f64 - scale.low) / span).clamp(0.0, 1.0);
        text::fill(image, [left.saturating_sub(dot), top.saturating_sub(dot), side + 2 * dot, side + 2 * dot], ink);
        text::fill(image, [left, top, side, side], super::bytes(shade(Quantity::Group, part as f32)));
        text::write(image, name, [left + 2 * side, top], em, [ink, paper]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_have_their_colours_and_names_and_many_have_a_scale() {
        let mut image = Image { width: 400, height: 300, pixels: vec![255; 400 * 300 * 3], alpha: None };
        let scale = Scale { low: 0.0, high: 2.0, largest: 2.0 };
        let names = |count: usize| (0..count).map(|k| format!("strain {k}")).collect::<Vec<_>>();
        legend(&mut image, (Quantity::Group, Some(scale)), &names(2), [[0; 3], [255; 3]]);
        let has =
            |image: &Image, colour: [u8; 3]| image.pixels.chunks_exact(3).filter(|pixel| *pixel == colour).count();
        let [half, whole, none] = [0.5, 1.0, 0.0].map(|part| super::super::bytes(ramp(part)));
        assert!(has(&image, half) > 40 && has(&image, whole) > 40 && has(&image, none) == 0);
        let mut many = Image { pixels: vec![255; 400 * 300 * 3], ..image.clone() };
        legend(&mut many, (Quantity::Group, Some(scale)), &names(13), [[0; 3], [255; 3]]);
        assert!(has(&many, none) > 0);
    }
}
