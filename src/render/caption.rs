//! The text in a run's picture: time and number of bodies in the upper left corner, the colour quantity in the lower
//! right one.

use super::colour::{hue, ramp};
use super::scale::Scale;
use super::text::{self, GLYPH};
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
    let marks = text::marks(&words(state), BORDER * dot, BORDER * dot, dot);
    text::draw(image, &marks, dot, ink, paper);
}

/// The name of the colour quantity, and the scale with its ends.
pub(super) fn legend(image: &mut Image, quantity: Quantity, scale: Option<Scale>, [ink, paper]: Inks) {
    let Some(dot) = text::dot(image) else { return };
    let Some(ends) = ends(quantity, scale) else { return };
    let width = (WIDTH * f64::from(image.width)) as usize;
    let (right, bottom) = ((image.width as usize).saturating_sub(BORDER * dot), image.height as usize - BORDER * dot);
    let (left, top) = (right.saturating_sub(width), bottom - THICKNESS * dot);
    text::fill(image, [left - dot, top - dot, right - left + 2 * dot, (THICKNESS + 2) * dot], ink);
    for x in left..right {
        let part = (x - left) as f32 / (right - left - 1).max(1) as f32;
        text::fill(image, [x, top, 1, THICKNESS * dot], super::bytes(shade(quantity, part)));
    }
    let [above, title] = [1, 2].map(|line| top - line * (GLYPH[1] + GAP) * dot);
    let at_right = |words: &str| right.saturating_sub(text::width(words, dot));
    let mut marks = text::marks(&ends[0], left, above, dot);
    marks.extend(text::marks(&ends[1], at_right(&ends[1]), above, dot));
    let name = quantity.name();
    let middle = left + ((right - left).saturating_sub(text::width(name, dot))) / 2;
    marks.extend(text::marks(name, middle, title, dot));
    text::draw(image, &marks, dot, ink, paper);
}
