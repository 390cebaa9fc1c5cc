//! Pictures of bodies by ray casting against the smooth surfaces themselves, on the CPU or a device.
//!
//! Rays are parallel, 2 x 2 per pixel, and are intersected with each body's exact surface, by the closed form of its
//! family (`intersect`). A picture's bytes are the same for any number of threads. A device may cast the rays
//! ([`Rays`]).
//!
//! [`picture`] draws bodies, [`render`](fn@render) a run's states into files, [`Reel`] in memory, and [`fn@movie`]
//! makes a movie.

mod animation;
mod backdrop;
mod bonds;
mod camera;
mod caption;
mod colour;
mod convex_hit;
mod error;
mod frames;
mod gauge_hit;
mod image;
mod intersect;
mod movie;
mod painter;
mod quantity;
mod raster;
#[cfg(feature = "gpu")]
mod rays;
#[cfg(not(feature = "gpu"))]
#[path = "rays_absent.rs"]
mod rays;
mod reel;
mod scale;
mod scale_bar;
mod shade;
mod shadow;
mod text;
mod vector;

pub(crate) use backdrop::Backdrop;
pub use camera::Camera;
pub use error::RenderError;
pub use frames::MOVIE;
pub use frames::{Fit, Frames, Rendered, RenderedFrame, render, render_on};
pub(crate) use frames::{inside, interval};
pub use image::Image;
pub use movie::{ENDINGS, Encoder, MovieKind, movie};
pub use quantity::Quantity;
pub use rays::Rays;
pub use reel::{Reel, still, still_file};
pub use scale::Scale;

use crate::bodies::Bodies;
use crate::gpu::GpuError;
use glam::Vec3;
use raster::Samples;
use rayon::prelude::*;
use shade::Shading;
use shadow::Shadow;
use std::convert::Infallible;

/// The median thickness of bodies, in pixels, from which shadows are drawn: for thinner bodies they would be speckles.
const SHADOW_FROM: f32 = 1.5;

/// Pixels of the picture per pixel of the light's own picture: soft edges need no finer ones.
const SHADOW_COARSENESS: u32 = 2;

/// The quantity that a body's colour shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Colour {
    /// The direction of its axis: half a turn in the x-y plane is a full turn of the hue, which pales out of that
    /// plane.
    #[default]
    Orientation,
    /// Divisions since its founder, by rank from the fewest (dark blue) to the most (yellow).
    Generation,
    /// Time of birth, by rank from the first (dark blue) to the last (yellow).
    Age,
    /// Its bounding radius, by rank from the smallest (dark blue) to the largest (yellow).
    Size,
    /// Nothing.
    Plain,
}

/// The background.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Background {
    /// White.
    #[default]
    White,
    /// Nearly black.
    Dark,
    /// Transparent: each pixel has the opacity of its content. Text is as on white.
    Transparent,
}

impl Background {
    /// The linear colours of text and of its background.
    fn ink_and_paper(self) -> [Vec3; 2] {
        match self {
            Background::White | Background::Transparent => [[0.25, 0.0, 0.0], [1.0, 0.0, 0.0]],
            Background::Dark => [[0.85, 0.0, 0.0], [0.17, 0.0, -0.015]],
        }
        .map(colour::linear)
    }
}

/// The side from which bodies are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Against z: x to the right, y up.
    Top,
    /// Along y: x to the right, z up.
    Front,
    /// Against x: y to the right, z up.
    Right,
    /// From the front and above, z up.
    Oblique,
}

/// The size and the appearance of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// Width in pixels, clamped to 1 to [`View::LARGEST_SIDE`].
    pub width: u32,
    /// Height in pixels; as `width`.
    pub height: u32,
    /// The colour quantity.
    pub colour: Colour,
    /// Seen along z, x to the right and y up; otherwise from the front and above.
    pub planar: bool,
    /// The background.
    pub background: Background,
    /// A bar of a round length and its number, in the lower left corner.
    pub scale_bar: bool,
}

impl View {
    /// The largest number of pixels in a row or a column: at 64 bytes per pixel, the largest square picture takes 16
    /// GiB.
    pub const LARGEST_SIDE: u32 = 16_384;
}

impl Default for View {
    fn default() -> Self {
        View {
            width: 1920,
            height: 1080,
            colour: Colour::default(),
            planar: false,
            background: Background::default(),
            scale_bar: true,
        }
    }
}

/// The picture of all bodies of a scene, as large as possible.
///
/// Bodies that are not finite are omitted; without bodies the picture is empty.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use relcp::{bodies::{Bodies, NO_GROUP}, render::{View, picture}, separation::Placed, shape::Shape};
/// let mut bodies = Bodies::default();
/// let shape = Shape::Torus { major_radius: 2.0, minor_radius: 0.5 };
/// bodies.push(Placed { shape, position: DVec3::ZERO, orientation: DQuat::IDENTITY }, NO_GROUP);
/// let image = picture(&bodies, &View { width: 80, height: 80, planar: true, ..View::default() });
/// assert_eq!(image.pixel(40, 40), Some([255; 3])); // through the hole
/// assert_ne!(image.pixel(10, 40), Some([255; 3]));
/// ```
pub fn picture(bodies: &Bodies, view: &View) -> Image {
    picture_by(bodies, view, &Camera::fit(bodies, view))
}

/// As [`picture`], with a given camera, such as one for all pictures of a movie.
pub fn picture_by(bodies: &Bodies, view: &View, camera: &Camera) -> Image {
    let paint = |inks| {
        let Ok(image) = painted(bodies, view, camera, &colour::of_bodies(bodies, view.colour), inks, on_cpu);
        image
    };
    match view.background {
        Background::Transparent => Image::between(paint(inks_on(WHITE)), &paint(inks_on(BLACK))),
        background => paint(background.ink_and_paper()),
    }
}

/// The papers on which a transparent picture is drawn, to determine its opacity.
const WHITE: Vec3 = Vec3::ONE;
const BLACK: Vec3 = Vec3::ZERO;

/// The ink of a transparent picture, with one of these papers.
fn inks_on(paper: Vec3) -> [Vec3; 2] {
    [Background::Transparent.ink_and_paper()[0], paper]
}

/// As [`picture_by`], with the rays cast by a device. Its pixels differ from the CPU's by rounding.
///
/// # Errors
/// A [`GpuError`] if the device fails.
pub fn picture_on(rays: &Rays, bodies: &Bodies, view: &View, camera: &Camera) -> Result<Image, GpuError> {
    let colours = colour::of_bodies(bodies, view.colour);
    let paint = |inks| painted(bodies, view, camera, &colours, inks, on_device(rays));
    match view.background {
        Background::Transparent => Ok(Image::between(paint(inks_on(WHITE))?, &paint(inks_on(BLACK))?)),
        background => paint(background.ink_and_paper()),
    }
}

/// Casts rays on the CPU.
fn on_cpu(bodies: &Bodies, camera: &Camera, width: u32, height: u32) -> Result<Samples, Infallible> {
    Ok(Samples::cast(bodies, camera, width, height))
}

/// Casts rays on a device.
fn on_device(rays: &Rays) -> impl Fn(&Bodies, &Camera, u32, u32) -> Result<Samples, GpuError> {
    |bodies, camera, width, height| Samples::cast_on(rays, bodies, camera, width, height)
}

/// As [`picture_by`], with a linear colour per body, ink and paper, and a function that casts the rays.
fn painted<E>(
    bodies: &Bodies,
    view: &View,
    camera: &Camera,
    colours: &[Vec3],
    [ink, paper]: [Vec3; 2],
    cast: impl Fn(&Bodies, &Camera, u32, u32) -> Result<Samples, E>,
) -> Result<Image, E> {
    let [width, height] = [view.width, view.height].map(|side| side.clamp(1, View::LARGEST_SIDE));
    let with_bonds = bonds::added(bodies, colours);
    let (bodies, colours) = with_bonds.as_ref().map_or((bodies, colours), |(bodies, colours)| (bodies, colours));
    let samples = cast(bodies, camera, width, height)?;
    let scale = camera.pixels_per_length();
    let thickness: Vec<f32> = bodies.shape.iter().map(|s| (s.thickness() * scale) as f32).collect();
    let typical = median(&thickness);
    // Bodies in one plane hardly cast shadows on each other.
    let shadow = match !view.planar && typical >= SHADOW_FROM {
        true => {
            let light = camera.to_space(shade::KEY_LIGHT.as_dvec3()).normalize();
            let side = width.max(height) / SHADOW_COARSENESS;
            Some(Shadow::cast(bodies, light, f64::from(typical) / scale, side, &cast)?)
        }
        false => None,
    };
    let shading = Shading {
        samples: &samples,
        camera,
        shadow: shadow.as_ref(),
        colours,
        thickness: &thickness,
        background: paper,
        sample_length: (1.0 / (scale * raster::SUPERSAMPLING as f64)) as f32,
        typical: typical * raster::SUPERSAMPLING as f32,
    };
    let (pattern, background) = (shading.pattern(), bytes(paper));
    let mut pixels = vec![0; 3 * width as usize * height as usize];
    pixels.par_chunks_mut(3 * width as usize).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            pixel.copy_from_slice(&shading.pixel(x, y, &pattern).map_or(background, bytes));
        }
    });
    let mut image = Image { width, height, pixels, alpha: None };
    if view.scale_bar && !bodies.is_empty() {
        scale_bar::draw(&mut image, scale, bytes(ink), background);
    }
    Ok(image)
}

fn bytes(light: Vec3) -> [u8; 3] {
    light.to_array().map(colour::encode)
}

/// The median of the finite values; zero without any.
fn median(values: &[f32]) -> f32 {
    let mut finite: Vec<f32> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let middle = finite.len() / 2;
    if finite.is_empty() { 0.0 } else { *finite.select_nth_unstable_by(middle, f32::total_cmp).1 }
}
