//! A picture of a planar run as vectors: bodies, walls, the periodic cell and text, with the positions and colours of
//! the picture in pixels, without light and shadows.

mod contour;
mod outline;

use super::camera::Camera;
use super::colour::{self, encode};
use super::{Background, Quantity, Scale, backdrop::Backdrop, bonds, caption, scale_bar};
use crate::bodies::Bodies;
use crate::page::{Anchor, Ink, Page, PathBuilder, Words};
use glam::{DVec2, DVec3, Vec3};
use tiny_skia::Rect;

/// The width of the page, in points: 178 mm.
const WIDTH: f32 = 504.6;
/// The size of text, and the widths of outlines and walls, in points.
const TEXT: f32 = 8.0;
const EDGE: f32 = 0.35;
const WALL: f32 = 0.8;
/// The distance of text from the border, and the height of the colour scale, in points.
const BORDER: f32 = 8.0;
const BAR: f32 = 6.0;
/// The width of the colour scale over that of the page, and its number of fields.
const BAR_WIDTH: f32 = 0.16;
const FIELDS: usize = 64;
/// The light of a body's edge over that of the body.
const EDGE_LIGHT: f32 = 0.25;

/// The content of a picture.
pub(super) struct Drawn<'a> {
    pub bodies: &'a Bodies,
    /// A linear colour per body.
    pub colours: &'a [Vec3],
    pub backdrop: &'a Backdrop,
    pub camera: &'a Camera,
    pub background: Background,
    /// Width and height of the corresponding picture in pixels.
    pub size: [u32; 2],
    /// Time and number of bodies, the colour quantity, and the colour scale; none for a picture without text.
    pub words: Option<(String, Quantity, Option<Scale>)>,
}

/// The page of a picture.
pub(super) fn page(drawn: &Drawn<'_>) -> Page {
    let size = drawn.size.map(|side| side as f32);
    let mut page = Page::new("relcp", size, WIDTH / size[0]);
    let [ink, paper] = drawn.background.ink_and_paper().map(super::bytes);
    if drawn.background != Background::Transparent {
        page.shape(rectangle([0.0, 0.0], size), Some(Ink::opaque(paper)), None);
    }
    stands_still(&mut page, drawn, Ink::opaque(ink));
    sticks(&mut page, drawn);
    for i in 0..drawn.bodies.len() {
        let Some(path) = outline::of(drawn.bodies, i, &|point| on_page(drawn, point)) else { continue };
        let colour = drawn.colours[i];
        let edge = Ink::opaque((EDGE_LIGHT * colour).to_array().map(encode));
        page.shape(Some(path), Some(Ink::opaque(colour.to_array().map(encode))), Some((edge, EDGE / page.points)));
    }
    if let Some((state, quantity, scale)) = &drawn.words {
        let mut letters = Letters { size: TEXT / page.points, ink: Ink::opaque(ink), page: &mut page };
        let border = BORDER / letters.page.points;
        letters.write(state, [border, border + 0.75 * letters.size], Anchor::Left);
        scale_of_lengths(&mut letters, drawn.camera.pixels_per_length(), border);
        scale_of_colours(&mut letters, *quantity, *scale, border);
    }
    page
}

/// The position of a point of space on the page.
fn on_page(drawn: &Drawn<'_>, point: DVec3) -> DVec2 {
    let [wide, high] = drawn.size.map(f64::from);
    let at = drawn.camera.to_view(point - drawn.camera.centre) * drawn.camera.pixels_per_length();
    DVec2::new(0.5 * wide + at.x, 0.5 * high - at.y)
}

/// Bonds, behind the bodies.
fn sticks(page: &mut Page, drawn: &Drawn<'_>) {
    let ink = Ink::opaque(bonds::COLOUR.to_array().map(encode));
    for (from, way, diameter) in drawn.bodies.bonds.iter().filter_map(|bond| bonds::stick(drawn.bodies, bond)) {
        let [from, to] = [from, from + way].map(|point| on_page(drawn, point).as_vec2());
        let mut builder = PathBuilder::new();
        builder.move_to(from.x, from.y);
        builder.line_to(to.x, to.y);
        page.shape(builder.finish(), None, Some((ink, (diameter * drawn.camera.pixels_per_length()) as f32)));
    }
}

/// Walls and the edges of the periodic cell.
fn stands_still(page: &mut Page, drawn: &Drawn<'_>, ink: Ink) {
    let (scale, [wide, high]) = (drawn.camera.pixels_per_length(), drawn.size.map(f64::from));
    let at = |x: f64, y: f64| {
        let parts = DVec3::new(x - 0.5 * wide, 0.5 * high - y, 0.0) / scale;
        (drawn.camera.centre + drawn.camera.to_space(parts)).with_z(0.0)
    };
    let line = WALL / page.points;
    if drawn.backdrop.has_walls() {
        page.shape(contour::zero([wide, high], |x, y| drawn.backdrop.inside(at(x, y))), None, Some((ink, line)));
    }
    for [from, to] in drawn.backdrop.edges(at(0.0, high), at(wide, 0.0)) {
        let [from, to] = [from, to].map(|point| on_page(drawn, point).as_vec2());
        let mut builder = PathBuilder::new();
        builder.move_to(from.x, from.y);
        builder.line_to(to.x, to.y);
        page.shape(builder.finish(), None, Some((Ink { alpha: 0.5, ..ink }, line)));
    }
}

struct Letters<'a> {
    page: &'a mut Page,
    size: f32,
    ink: Ink,
}

impl Letters<'_> {
    fn write(&mut self, text: &str, at: [f32; 2], anchor: Anchor) {
        let words = Words { text: text.into(), at, size: self.size, anchor, upward: false, ink: self.ink };
        self.page.words(words);
    }
}

fn rectangle([x, y]: [f32; 2], [wide, high]: [f32; 2]) -> Option<crate::page::Path> {
    Rect::from_xywh(x, y, wide, high).map(PathBuilder::from_rect)
}

/// The bar of a round length, in the lower left corner.
fn scale_of_lengths(letters: &mut Letters<'_>, pixels_per_length: f64, border: f32) {
    let [wide, high] = letters.page.size;
    let Some((length, label)) = scale_bar::round_length(scale_bar::LONGEST * f64::from(wide) / pixels_per_length)
    else {
        return;
    };
    let bar = (length * pixels_per_length) as f32;
    let thick = 0.2 * letters.size;
    letters.page.shape(rectangle([border, high - border - thick], [bar, thick]), Some(letters.ink), None);
    letters.write(&label, [border + 0.5 * bar, high - border - 2.5 * thick], Anchor::Middle);
}

/// The colour quantity and its scale, in the lower right corner.
fn scale_of_colours(letters: &mut Letters<'_>, quantity: Quantity, scale: Option<Scale>, border: f32) {
    let Some([low, high_end]) = caption::ends(quantity, scale) else { return };
    let [wide, high] = letters.page.size;
    let (bar, thick) = (BAR_WIDTH * wide, BAR / letters.page.points);
    let (left, top) = (wide - border - bar, high - border - thick);
    for field in 0..FIELDS {
        let light = caption::shade(quantity, field as f32 / (FIELDS - 1) as f32);
        let field_wide = bar / FIELDS as f32;
        // Fields overlap, so that no gap shows between them.
        let own = [if field + 1 == FIELDS { field_wide } else { 1.5 * field_wide }, thick];
        let colour = Ink::opaque(light.to_array().map(colour::encode));
        letters.page.shape(rectangle([left + field as f32 * field_wide, top], own), Some(colour), None);
    }
    let frame = Some((letters.ink, EDGE / letters.page.points));
    letters.page.shape(rectangle([left, top], [bar, thick]), None, frame);
    let above = top - 0.4 * letters.size;
    letters.write(&low, [left, above], Anchor::Left);
    letters.write(&high_end, [left + bar, above], Anchor::Right);
    letters.write(quantity.name(), [left + 0.5 * bar, above - 1.25 * letters.size], Anchor::Middle);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::NO_GROUP;
    use crate::page::Format;
    use crate::periodic::Periods;
    use crate::render::View;
    use crate::separation::Placed;
    use crate::shape::Shape;
    use crate::walls::{Wall, Walls};
    use glam::DQuat;

    fn bodies() -> Bodies {
        let mut bodies = Bodies::default();
        let turn = DQuat::from_rotation_z(0.4) * DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let shapes = [
            (Shape::Sphere { radius: 0.7 }, DQuat::IDENTITY),
            (Shape::Spherocylinder { diameter: 0.8, length: 2.4 }, turn),
            (Shape::Ellipsoid { radii: [0.4, 0.6, 1.1] }, turn * DQuat::from_rotation_z(0.8)),
            (Shape::Torus { major_radius: 0.8, minor_radius: 0.25 }, DQuat::IDENTITY),
            (Shape::Torus { major_radius: 0.8, minor_radius: 0.25 }, turn),
        ];
        for (k, (shape, orientation)) in shapes.into_iter().enumerate() {
            let position = DVec3::new(2.6 * k as f64, (k % 2) as f64, 0.0);
            bodies.push(Placed { shape, position, orientation }, NO_GROUP);
        }
        bodies
    }

    fn drawn(backdrop: &Backdrop, words: Option<(String, Quantity, Option<Scale>)>) -> Page {
        let (bodies, size) = (bodies(), [900, 300]);
        let view = View { width: size[0], height: size[1], planar: true, ..View::default() };
        let colours = vec![Vec3::new(1.0, 0.0, 0.0); bodies.len()];
        let camera = Camera::fit(&bodies, &view);
        let background = Background::White;
        page(&Drawn { bodies: &bodies, colours: &colours, backdrop, camera: &camera, background, size, words })
    }

    #[test]
    fn vectors_cover_what_the_rays_meet() {
        let page = drawn(&Backdrop::default(), None);
        let (bodies, view) =
            (bodies(), View { width: 900, height: 300, planar: true, scale_bar: false, ..View::default() });
        let rays = crate::render::picture(&bodies, &view);
        let bytes = page.file(Format::Png).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let scale = f64::from(info.width) / 900.0;
        let red = |x: u32, y: u32| {
            let [x, y] = [x, y].map(|at| ((f64::from(at) + 0.5) * scale) as u32);
            pixels[3 * (y * info.width + x) as usize + 1] < 128
        };
        let each = || (0..300_u32).flat_map(|y| (0..900_u32).map(move |x| (x, y)));
        let met = |(x, y): &(u32, u32)| rays.pixel(*x, *y) != Some([255; 3]);
        let (covered, differ) = (each().filter(met).count(), each().filter(|at| met(at) != red(at.0, at.1)).count());
        // Pixels on an outline may differ.
        assert!(covered > 20_000 && differ * 25 < covered, "{differ} of {covered}");
    }

    #[test]
    fn walls_cells_words_and_scales_are_vectors() {
        let wall = Wall::Channel {
            normal: [0.0, 1.0, 0.0],
            center: [5.0, 0.0, 0.0],
            width: 4.0,
            motion: None,
            friction: None,
        };
        let walls = Walls::new(&[wall], true);
        let backdrop = Backdrop { walls, periods: Periods::new([Some(8.0), None, None]), ..Backdrop::default() };
        let scale = Scale { low: 0.0, high: 2.5, largest: 3.0 };
        let svg = drawn(&backdrop, Some(("t=1  n=5".into(), Quantity::Pressure, Some(scale)))).svg();
        let bare = drawn(&Backdrop::default(), None).svg();
        for words in ["t=1  n=5", ">pressure<", ">0<", "&gt;2.5", ">2<"] {
            assert!(svg.contains(words) && !bare.contains(words), "{words}: {svg}");
        }
        // Five bodies and paper; then a path for the channel, two for the cell, a bar, fields and their frame.
        assert_eq!(bare.matches("<path").count(), 6);
        assert_eq!(svg.matches("<path").count(), 6 + 1 + 2 + 1 + FIELDS + 1);
    }
}
