//! Light, contact shadows and outlines, from the hits of the rays.
//!
//! The darkening near contacts is the estimator of McGuire, Osman, Bukowski and Hennessy, "The Alchemy screen-space
//! ambient obscurance algorithm" (2011), with a fixed pattern of neighbours for each ray of a pixel, so that no noise
//! remains.

use super::camera::Camera;
use super::raster::{NOTHING, SUPERSAMPLING, Sample, Samples};
use super::shadow::Shadow;
use glam::{DVec3, Vec2, Vec3};

/// The main light from the upper left and the weak one from the lower right, along right, up and toward.
pub(super) const KEY_LIGHT: Vec3 = Vec3::new(-0.46, 0.60, 0.655);
const FILL_LIGHT: Vec3 = Vec3::new(0.72, -0.25, 0.647);
const KEY: f32 = 0.78;
const FILL: f32 = 0.16;
/// Halfway between the main light and the viewer.
const HALFWAY: Vec3 = Vec3::new(-0.2529, 0.3298, 0.9095);
/// Ambient light: from above, and from below.
const SKY: f32 = 0.34;
const GROUND: f32 = 0.16;
/// A soft gleam of the main light.
const GLEAM: f32 = 0.13;
const GLEAM_SHARPNESS: i32 = 24;
/// The neighbours of a ray, and the turns of their spiral.
const NEIGHBOURS: usize = 11;
const SPIRAL_TURNS: f32 = 3.0;
/// The density of the spiral near its start; 1 spaces it evenly.
const SPIRAL_DENSITY: f32 = 1.5;
/// How strongly neighbours darken.
const OBSCURANCE: f32 = 1.0;
/// A neighbour this little above the tangent plane (sine of the angle) does not darken: the surface itself curves.
const OBSCURANCE_BIAS: f32 = 0.06;
/// The darkening reaches this many body thicknesses, but at most this part of the picture's height.
const REACH_THICKNESSES: f32 = 1.5;
const REACH_OF_PICTURE: f32 = 0.06;
/// The smallest useful reach in samples.
const LEAST_REACH: f32 = 1.5;
/// Outlines fade in between these thicknesses of a body in pixels; on thinner bodies they would hide the colour.
const OUTLINE_FROM: f32 = 3.0;
const OUTLINE_FULL: f32 = 9.0;
/// The thicknesses of a body, in pixels, at which its outline becomes two and three samples wide.
const OUTLINE_WIDER: [f32; 2] = [7.0, 60.0];
/// The part of the light on an outline.
const OUTLINE_LIGHT: f32 = 0.16;

/// The inputs of shading beside the samples.
pub(super) struct Shading<'a> {
    pub samples: &'a Samples,
    pub camera: &'a Camera,
    /// The shadows of the main light, if they are drawn.
    pub shadow: Option<&'a Shadow>,
    /// Linear colour of each body.
    pub colours: &'a [Vec3],
    /// Thickness of each body in pixels.
    pub thickness: &'a [f32],
    pub background: Vec3,
    /// Length per sample.
    pub sample_length: f32,
    /// The median thickness of bodies in samples.
    pub typical: f32,
}

/// A position near a sample.
pub(super) struct Neighbour {
    /// Samples to the right and down.
    right: isize,
    down: isize,
    /// The same in lengths to the right and up.
    plane: Vec2,
}

impl Shading<'_> {
    /// The linear light of a pixel; `None` if it shows only the background.
    pub fn pixel(&self, x: usize, y: usize, pattern: &[Vec<Neighbour>]) -> Option<Vec3> {
        let (mut sum, mut seen) = (Vec3::ZERO, false);
        for (k, neighbours) in pattern.iter().enumerate() {
            let (x, y) = (x * SUPERSAMPLING + k % SUPERSAMPLING, y * SUPERSAMPLING + k / SUPERSAMPLING);
            let sample = self.samples.at(x, y);
            if sample.body == NOTHING {
                sum += self.background;
            } else {
                sum += self.light(x, y, sample, neighbours);
                seen = true;
            }
        }
        seen.then(|| sum / pattern.len() as f32)
    }

    /// For each ray of a pixel, the neighbours that may darken it: a spiral, denser near its start.
    pub fn pattern(&self) -> Vec<Vec<Neighbour>> {
        let rays = SUPERSAMPLING * SUPERSAMPLING;
        let reach = self.reach();
        let count = if reach < LEAST_REACH { 0 } else { NEIGHBOURS };
        let neighbour = |turn: f32, k: usize| {
            let part = (k as f32 + 0.5 + turn) / (count as f32 + 0.5);
            let angle = std::f32::consts::TAU * (part * SPIRAL_TURNS + turn);
            let offset = (Vec2::from_angle(angle) * (reach * part.powf(SPIRAL_DENSITY))).round();
            Neighbour {
                right: offset.x as isize,
                down: offset.y as isize,
                plane: Vec2::new(offset.x, -offset.y) * self.sample_length,
            }
        };
        (0..rays).map(|ray| (0..count).map(|k| neighbour(ray as f32 / rays as f32, k)).collect()).collect()
    }

    /// The reach of the darkening, in samples.
    fn reach(&self) -> f32 {
        (self.typical * REACH_THICKNESSES).min(self.samples.height as f32 * REACH_OF_PICTURE)
    }

    fn light(&self, x: usize, y: usize, sample: &Sample, neighbours: &[Neighbour]) -> Vec3 {
        let normal = full_normal(sample);
        let colour = self.colours[sample.body as usize];
        let open = self.open(x, y, sample, normal, neighbours);
        let outline = 1.0 - (1.0 - OUTLINE_LIGHT) * self.outline(x, y, sample);
        let ambient = GROUND + (SKY - GROUND) * (0.5 + 0.5 * normal.y);
        let key = KEY * normal.dot(KEY_LIGHT).max(0.0) * self.lit(x, y, sample, normal);
        let direct = key + FILL * normal.dot(FILL_LIGHT).max(0.0);
        let gleam = GLEAM * normal.dot(HALFWAY).max(0.0).powi(GLEAM_SHARPNESS) * key;
        // Obscured light still bounces: the direct part darkens less than the ambient one.
        (colour * (ambient * open + direct * (0.35 + 0.65 * open)) + Vec3::splat(gleam * open)) * outline
    }

    /// The part of the main light that reaches a sample.
    fn lit(&self, x: usize, y: usize, sample: &Sample, normal: Vec3) -> f32 {
        let Some(shadow) = self.shadow else { return 1.0 };
        let right = (x as f64 + 0.5 - self.samples.width as f64 / 2.0) * f64::from(self.sample_length);
        let up = (self.samples.height as f64 / 2.0 - y as f64 - 0.5) * f64::from(self.sample_length);
        let seen = DVec3::new(right, up, f64::from(sample.height));
        let point = self.camera.centre + self.camera.to_space(seen);
        let ray = x % SUPERSAMPLING + SUPERSAMPLING * (y % SUPERSAMPLING);
        shadow.lit(point, self.camera.to_space(normal.as_dvec3()), ray)
    }

    /// The openness of the surroundings of a sample, from 0 to 1.
    fn open(&self, x: usize, y: usize, sample: &Sample, normal: Vec3, neighbours: &[Neighbour]) -> f32 {
        if neighbours.is_empty() {
            return 1.0;
        }
        let reach = self.reach() * self.sample_length;
        let mut sum = 0.0;
        for neighbour in neighbours {
            let other = self.samples.near(x as isize + neighbour.right, y as isize + neighbour.down);
            if other.body == NOTHING {
                continue;
            }
            let to = neighbour.plane.extend(other.height - sample.height);
            let squared = to.length_squared();
            let above = to.dot(normal) - OBSCURANCE_BIAS * squared.sqrt();
            // The second term of the divisor: a neighbour at the same position does not count.
            sum += above.max(0.0) / (squared + 0.01 * reach * reach);
        }
        (1.0 - OBSCURANCE * reach * sum / neighbours.len() as f32).max(0.0)
    }

    /// The weight of the outline at a sample, from 0 to 1: a body's own edge in front of another body or of the
    /// background.
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
