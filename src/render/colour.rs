//! Colours of bodies, chosen in Oklab, where equal steps look equal (Ottosson, "A perceptual color space for image
//! processing", 2020), and kept as linear light.

use super::Colour;
use crate::bodies::Bodies;
use crate::shape::{Centreline, Geometry, Shape};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Lightness and chroma of the orientation hues: about the largest chroma in sRGB at one lightness for all hues.
const HUE_LIGHTNESS: f32 = 0.74;
const HUE_CHROMA: f32 = 0.125;
/// The hue (radians) of an axis to the right; the others follow at twice their angle.
const HUE_START: f32 = 0.45;
/// The colour of bodies without an axis, and of all bodies in a plain picture.
const PLAIN: [f32; 3] = [0.76, -0.035, -0.06];
/// A ramp of (lightness, a, b), from dark blue over green to yellow.
const RAMP: [[f32; 3]; 5] =
    [[0.52, 0.0, -0.14], [0.62, -0.08, -0.07], [0.72, -0.13, 0.04], [0.82, -0.07, 0.15], [0.91, 0.01, 0.16]];

/// Linear red, green and blue of every body.
pub(super) fn of_bodies(bodies: &Bodies, colour: Colour) -> Vec<Vec3> {
    match colour {
        Colour::Plain => vec![linear(PLAIN); bodies.len()],
        Colour::Orientation => (0..bodies.len()).into_par_iter().map(|i| by_axis(bodies, i)).collect(),
        Colour::Generation => on_ramp(&map(&bodies.lineage, |l| f64::from(l.generation))),
        Colour::Age => on_ramp(&map(&bodies.lineage, |l| l.birth)),
        Colour::Size => on_ramp(&map(&bodies.shape, Shape::bounding_radius)),
    }
}

fn map<T>(items: &[T], value: impl Fn(&T) -> f64) -> Vec<f64> {
    items.iter().map(value).collect()
}

/// An axis has no sign, so its hue follows twice its angle in the x-y plane; the colour pales as the axis leaves the
/// plane.
fn by_axis(bodies: &Bodies, i: usize) -> Vec3 {
    let Some(axis) = axis(&bodies.shape[i].geometry()) else { return linear(PLAIN) };
    let Some(axis) = (bodies.orientation[i] * axis).try_normalize() else { return linear(PLAIN) };
    let (x, y) = (axis.x as f32, axis.y as f32);
    hue([x, y], (axis.z * axis.z) as f32)
}

/// The hue of an axis with these components in the plane; `pale` is the squared component out of it.
pub(super) fn hue([x, y]: [f32; 2], pale: f32) -> Vec3 {
    let (cos, sin) = (HUE_START.cos(), HUE_START.sin());
    // (cos, sin) of twice the angle, times the squared length in the plane.
    let (a, b) = (x * x - y * y, 2.0 * x * y);
    linear([
        HUE_LIGHTNESS + 0.16 * pale,
        HUE_CHROMA * (a * cos - b * sin),
        HUE_CHROMA * (a * sin + b * cos) + 0.02 * pale,
    ])
}

/// The body's axis of orientation in its own axes; a ball has none.
fn axis(geometry: &Geometry) -> Option<DVec3> {
    match *geometry {
        Geometry::Centreline { curve: Centreline::Point, .. } | Geometry::Convex(_) => None,
        Geometry::Centreline { .. } => Some(DVec3::Z),
        Geometry::Ellipsoid { radii } => {
            let longest = radii.max_element();
            let all_equal = radii.min_element() == longest;
            let axes = [(radii.z, DVec3::Z), (radii.y, DVec3::Y), (radii.x, DVec3::X)];
            (!all_equal).then(|| axes.into_iter().find(|(r, _)| *r == longest).map(|(_, e)| e)).flatten()
        }
    }
}

/// Colours from the ramp by rank among the distinct values, so that a few outliers do not use most of it; NaN is at its
/// start.
fn on_ramp(values: &[f64]) -> Vec<Vec3> {
    let mut distinct: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    distinct.sort_unstable_by(f64::total_cmp);
    distinct.dedup();
    let last = distinct.len().saturating_sub(1).max(1) as f32;
    let at = |value: &f64| {
        let rank = distinct.partition_point(|v| v < value).min(distinct.len().saturating_sub(1));
        ramp(rank as f32 / last)
    };
    values.par_iter().map(at).collect()
}

/// The ramp's colour at a position from 0 to 1.
pub(super) fn ramp(part: f32) -> Vec3 {
    let place = part * (RAMP.len() - 1) as f32;
    let below = (place as usize).min(RAMP.len() - 2);
    let (from, to) = (Vec3::from(RAMP[below]), Vec3::from(RAMP[below + 1]));
    linear(from.lerp(to, place - below as f32).to_array())
}

/// Oklab to linear sRGB, clipped to the sRGB gamut.
pub(super) fn linear([lightness, a, b]: [f32; 3]) -> Vec3 {
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    Vec3::new(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    )
    .clamp(Vec3::ZERO, Vec3::ONE)
}

/// The sRGB byte of linear light (IEC 61966-2-1).
pub(super) fn encode(linear: f32) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

/// The linear light of a byte of sRGB.
pub(super) fn decode(byte: u8) -> f32 {
    let v = f32::from(byte) / 255.0;
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}
