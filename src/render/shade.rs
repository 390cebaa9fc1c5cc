//! Light, contact shadows and outlines, from what the rays have met.
//!
//! The darkening near contacts is the estimator of McGuire, Osman, Bukowski and Hennessy, "The Alchemy screen-space
//! ambient obscurance algorithm" (2011), with a fixed pattern of neighbours for each ray of a pixel, so that no noise remains.

use super::raster::{NOTHING, SUPERSAMPLING, Sample, Samples};
use glam::{Vec2, Vec3};

/// The main light from the upper left and the weak one from the lower right, along right, up and toward.
const KEY_LIGHT: Vec3 = Vec3::new(-0.46, 0.60, 0.655);
const FILL_LIGHT: Vec3 = Vec3::new(0.72, -0.25, 0.647);
const KEY: f32 = 0.78;
const FILL: f32 = 0.16;
/// Light from all sides: from above, and from below.
const SKY: f32 = 0.34;
const GROUND: f32 = 0.16;
/// A soft gleam of the main light.
const GLEAM: f32 = 0.10;
const GLEAM_SHARPNESS: i32 = 24;
/// Neighbours of one ray, and the turns of their spiral: the two share no factor.
const NEIGHBOURS: usize = 10;
const SPIRAL_TURNS: f32 = 3.0;
/// How strongly neighbours darken.
const OBSCURANCE: f32 = 1.1;
/// A neighbour this little above the tangent plane (sine of the angle) does not darken: the surface itself curves.
const OBSCURANCE_BIAS: f32 = 0.06;
/// The darkening reaches this many body thicknesses, but not beyond this part of the picture's height.
const REACH_THICKNESSES: f32 = 1.0;
const REACH_OF_PICTURE: f32 = 0.06;
/// Samples: a nearer neighbourhood than this shows nothing.
const LEAST_REACH: f32 = 1.5;
/// Outlines appear between these thicknesses of a body in pixels; below, they would be all that is seen.
const OUTLINE_FROM: f32 = 3.0;
const OUTLINE_FULL: f32 = 9.0;
/// A body's thickness in pixels at which its outline is two and three samples wide.
const OUTLINE_WIDER: [f32; 2] = [7.0, 60.0];
/// How much of the light an outline leaves.
const OUTLINE_LIGHT: f32 = 0.16;

/// What the shading needs to know beside the samples.
pub(super) struct Shading<'a> {
    pub samples: &'a Samples,
    /// Linear colour of each body.
    pub colours: &'a [Vec3],
    /// Thickness of each body in pixels.
    pub thickness: &'a [f32],
    pub background: Vec3,
    /// Lengths to a sample.
    pub sample_length: f32,
    /// Thickness in samples of a middling body.
    pub typical: f32,
}

impl Shading<'_> {
    /// The linear light of a pixel.
    pub fn pixel(&self, x: usize, y: usize, pattern: &[Vec<Vec2>]) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for (k, offsets) in pattern.iter().enumerate() {
            let (sx, sy) = (x * SUPERSAMPLING + k % SUPERSAMPLING, y * SUPERSAMPLING + k / SUPERSAMPLING);
            sum += self.sample(sx, sy, offsets);
        }
        sum / pattern.len() as f32
    }

    /// For each ray of a pixel, the neighbours (in samples, right and down) that may darken it.
    pub fn pattern(&self) -> Vec<Vec<Vec2>> {
        let rays = SUPERSAMPLING * SUPERSAMPLING;
        let reach = (self.typical * REACH_THICKNESSES).min(self.samples.height as f32 * REACH_OF_PICTURE);
        let count = if reach < LEAST_REACH { 0 } else { NEIGHBOURS };
        (0..rays)
            .map(|ray| {
                let turn = ray as f32 / rays as f32;
                (0..count)
                    .map(|k| {
                        let part = (k as f32 + 0.5 + turn) / (count as f32 + 0.5);
                        Vec2::from_angle(std::f32::consts::TAU * (part * SPIRAL_TURNS + turn)) * (reach * part)
                    })
                    .collect()
            })
            .collect()
    }

    fn sample(&self, x: usize, y: usize, offsets: &[Vec2]) -> Vec3 {
        let sample = self.samples.at(x, y);
        if sample.body == NOTHING {
            return self.background;
        }
        let normal = full_normal(sample);
        let colour = self.colours[sample.body as usize];
        let open = self.open(x, y, sample, normal, offsets);
        let outline = 1.0 - (1.0 - OUTLINE_LIGHT) * self.outline(x, y, sample);
        let half = (KEY_LIGHT + Vec3::Z).normalize();
        let ambient = GROUND + (SKY - GROUND) * (0.5 + 0.5 * normal.y);
        let direct = KEY * normal.dot(KEY_LIGHT).max(0.0) + FILL * normal.dot(FILL_LIGHT).max(0.0);
        let gleam = GLEAM * normal.dot(half).max(0.0).powi(GLEAM_SHARPNESS);
        // Obscured light still bounces: the direct part darkens less than the ambient one.
        (colour * (ambient * open + direct * (0.35 + 0.65 * open)) + Vec3::splat(gleam * open)) * outline
    }

    /// How open the surroundings of a sample are, from 0 to 1.
    fn open(&self, x: usize, y: usize, sample: &Sample, normal: Vec3, offsets: &[Vec2]) -> f32 {
        if offsets.is_empty() {
            return 1.0;
        }
        let reach = offsets[offsets.len() - 1].length() * self.sample_length;
        let mut sum = 0.0;
        for offset in offsets {
            let (dx, dy) = (offset.x.round() as isize, offset.y.round() as isize);
            let other = self.samples.near(x as isize + dx, y as isize + dy);
            if other.body == NOTHING {
                continue;
            }
            let plane = Vec2::new(dx as f32, -(dy as f32)) * self.sample_length;
            let to = plane.extend(other.height - sample.height);
            let squared = to.length_squared();
            let above = to.dot(normal) - OBSCURANCE_BIAS * squared.sqrt();
            // The divisor's second term: a neighbour in the same place says nothing.
            sum += above.max(0.0) / (squared + 0.01 * reach * reach);
        }
        (1.0 - OBSCURANCE * reach * sum / offsets.len() as f32).max(0.0)
    }

    /// How much of an outline a sample is, from 0 to 1: a body's own edge in front of another one or of nothing.
    fn outline(&self, x: usize, y: usize, sample: &Sample) -> f32 {
        let thickness = self.thickness[sample.body as usize];
        let strength = ((thickness - OUTLINE_FROM) / (OUTLINE_FULL - OUTLINE_FROM)).clamp(0.0, 1.0);
        if strength == 0.0 {
            return 0.0;
        }
        let width = 1 + OUTLINE_WIDER.iter().filter(|&&least| thickness >= least).count() as isize;
        let (x, y) = (x as isize, y as isize);
        let edge = |dx: isize, dy: isize| {
            let other = self.samples.near(x + dx, y + dy);
            other.body != sample.body && other.height <= sample.height
        };
        let near = [(width, 0), (-width, 0), (0, width), (0, -width)].iter().any(|&(dx, dy)| edge(dx, dy))
            || (width > 1 && {
                // On the diagonal, the same distance in whole samples.
                let w = (width * 5 + 3) / 7;
                [(w, w), (-w, w), (w, -w), (-w, -w)].iter().any(|&(dx, dy)| edge(dx, dy))
            });
        if near { strength } else { 0.0 }
    }
}

fn full_normal(sample: &Sample) -> Vec3 {
    let [x, y] = sample.normal;
    Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}
