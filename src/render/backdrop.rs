//! The background of a picture: the walls at that time, the periodic cell, and in a planar picture the scene's first
//! field.
//!
//! In a planar picture, the distance from the walls' own surfaces is evaluated at every pixel without a body, so a wall
//! of any kind is drawn where bodies meet it, and the outside is grey. In other pictures walls are lines behind the
//! bodies.

use super::image::Image;
use super::{Camera, View};
use crate::bodies::Bodies;
use crate::fields::{Border, Concentration, Field};
use crate::periodic::{Periodic, Periods};
use crate::scene::Scene;
use crate::walls::{Line, Wall, WallState, Walls, edges, standing};
use glam::DVec3;
use rayon::prelude::*;
use tiny_skia::{FillRule, Mask, PathBuilder, Stroke, Transform};

/// Half the thickness of a line over the picture's smaller side.
const HALF_LINE: f64 = 1.0 / 900.0;

/// The part of ink in the area outside the walls, and in lines of walls in space.
const OUTSIDE: f64 = 0.14;
const IN_SPACE: f64 = 0.55;

/// The colour of the largest concentration of a field, and the part of it in that place.
const OF_FIELD: [u8; 3] = [38, 139, 160];
const FULL: f64 = 0.55;

/// A field that is drawn.
#[derive(Clone, Debug)]
pub(crate) struct DrawnField {
    of: Concentration,
    /// The concentration with the full colour.
    most: f64,
    periodic: [bool; 3],
}

/// The background of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Backdrop {
    pub walls: Walls,
    pub periods: Periods,
    /// The scene's walls.
    pub scene_walls: Vec<Wall>,
    /// The cell, whose lengths may change.
    pub cell: Option<Periodic>,
    /// The time.
    pub time: f64,
    /// The names of the scene's groups.
    pub groups: Vec<String>,
    /// The largest concentration of the first field that the scene names, in its borders or at the start.
    pub most_named: f64,
    pub field: Option<DrawnField>,
}

impl Backdrop {
    /// The background of a scene at its start.
    pub fn of(scene: &Scene) -> Self {
        let (time, cell) = (scene.time.start, scene.periodic);
        let (walls, periods, groups) = (scene.walls(), scene.periods(), scene.group_names());
        let most_named = scene.fields.values().next().map_or(0.0, largest);
        Backdrop { walls, periods, scene_walls: scene.walls.clone(), cell, time, groups, most_named, field: None }
    }

    /// That of a state at a time, with these walls under a load and concentrations.
    pub fn of_state(&self, time: f64, walls: &[WallState], fields: &[Concentration]) -> Backdrop {
        let periodic = self.periods.lengths().map(|length| length.is_some());
        let field = fields.first().map(|of| {
            let most = of.values.iter().copied().fold(self.most_named, f64::max);
            DrawnField { of: of.clone(), most, periodic }
        });
        Backdrop { field, ..self.at(time, walls) }
    }

    /// The same at another time, with walls under a load where these states have them.
    pub fn at(&self, time: f64, states: &[WallState]) -> Backdrop {
        let periods = self.cell.map_or(self.periods, |cell| cell.at(time));
        let (walls, scene_walls) = (self.walls.at(time).gone(states), standing(&self.scene_walls, states));
        Backdrop { walls, scene_walls, periods, time, ..self.clone() }
    }

    /// Draws it behind the bodies of a picture.
    pub fn draw(&self, image: &mut Image, view: &View, camera: &Camera, ink: [u8; 3], paper: [u8; 3]) {
        if self.walls.is_empty() && self.periods.is_none() && self.field.is_none() {
            return;
        }
        if !view.planar || camera.toward != DVec3::Z {
            self.draw_lines(image, camera, ink, paper);
            return;
        }
        let (width, height, scale) = (image.width as usize, image.height as usize, camera.pixels_per_length());
        let half_line = (HALF_LINE * width.min(height) as f64).max(0.5);
        image.pixels.par_chunks_mut(3 * width).enumerate().for_each(|(row, pixels)| {
            for (column, pixel) in pixels.chunks_exact_mut(3).enumerate().filter(|(_, pixel)| *pixel == paper) {
                let right = column as f64 + 0.5 - 0.5 * width as f64;
                let up = 0.5 * height as f64 - row as f64 - 0.5;
                let point = camera.centre + camera.to_space(DVec3::new(right, up, 0.0) / scale);
                let point = point.with_z(0.0);
                let (inside, edge) = (scale * self.inside(point), scale * self.edge(point));
                self.tint(pixel, point);
                let line = |distance: f64| (half_line + 0.5 - distance).clamp(0.0, 1.0);
                let grey = OUTSIDE * (0.5 - inside).clamp(0.0, 1.0);
                let part = grey.max(line(inside.abs())).max(0.5 * line(edge));
                let below = [pixel[0], pixel[1], pixel[2]];
                mix(pixel, ink, below, part);
            }
        });
    }

    /// Tints a pixel by the concentration at its point.
    fn tint(&self, pixel: &mut [u8], point: DVec3) {
        let Some(DrawnField { of, most, periodic }) = &self.field else { return };
        if *most > 0.0 && of.grid.holds_in_plane(point) {
            let below = [pixel[0], pixel[1], pixel[2]];
            mix(pixel, OF_FIELD, below, FULL * of.grid.at(&of.values, point, *periodic) / most);
        }
    }

    /// Draws it as lines.
    fn draw_lines(&self, image: &mut Image, camera: &Camera, ink: [u8; 3], paper: [u8; 3]) {
        let (width, height, scale) = (image.width, image.height, camera.pixels_per_length());
        let half_line = (HALF_LINE * f64::from(width.min(height))).max(0.5);
        let Some(mut mask) = Mask::new(width, height) else { return };
        let mut builder = PathBuilder::new();
        for [from, to] in self.lines(camera, 0.5 * f64::from(width.min(height)) / scale) {
            let [from, to] = [from, to].map(|point| {
                let at = camera.to_view(point - camera.centre) * scale;
                [0.5 * f64::from(width) + at.x, 0.5 * f64::from(height) - at.y].map(|x| x as f32)
            });
            builder.move_to(from[0], from[1]);
            builder.line_to(to[0], to[1]);
        }
        let stroke = Stroke { width: 2.0 * half_line as f32, ..Stroke::default() };
        let Some(drawn) = builder.finish().and_then(|path| path.stroke(&stroke, 1.0)) else { return };
        mask.fill_path(&drawn, FillRule::Winding, true, Transform::identity());
        for (pixel, part) in image.pixels.chunks_exact_mut(3).zip(mask.data()).filter(|(pixel, _)| *pixel == paper) {
            mix(pixel, ink, paper, IN_SPACE * f64::from(*part) / 255.0);
        }
    }

    /// The lines of walls and of the periodic cell in a camera's view, up to `reach` from its centre.
    fn lines(&self, camera: &Camera, reach: f64) -> Vec<Line> {
        let [low, high] = [-reach, reach].map(|reach| camera.centre + DVec3::splat(reach));
        let mut lines: Vec<Line> =
            self.scene_walls.iter().flat_map(|wall| wall.lines_at(self.time, low, high)).collect();
        if !self.periods.is_none() {
            let lengths = self.periods.lengths();
            let end = |axis: usize, open: f64, sign: f64| lengths[axis].map_or(open, |length| 0.5 * sign * length);
            let corner =
                |open: DVec3, sign: f64| DVec3::from_array(std::array::from_fn(|axis| end(axis, open[axis], sign)));
            lines.extend(edges(corner(low, -1.0), corner(high, 1.0)));
        }
        lines
    }

    /// Draws it into the [`picture`](super::picture) of these bodies.
    pub fn behind(&self, image: &mut Image, view: &View, bodies: &Bodies) {
        let [ink, paper] = view.background.ink_and_paper().map(super::bytes);
        self.draw(image, view, &Camera::fit(bodies, view), ink, paper);
    }

    /// Whether there are walls.
    pub fn has_walls(&self) -> bool {
        !self.walls.is_empty()
    }

    /// The visible edges of the periodic cell between two corners of a picture; along an open axis they cross the
    /// picture.
    pub fn edges(&self, low: DVec3, high: DVec3) -> Vec<[DVec3; 2]> {
        let lengths = self.periods.lengths();
        let span =
            [0, 1].map(|axis| lengths[axis].map_or([low[axis], high[axis]], |length| [-0.5 * length, 0.5 * length]));
        let mut edges = Vec::new();
        if lengths[0].is_some() {
            edges.extend(span[0].map(|x| span[1].map(|y| DVec3::new(x, y, 0.0))));
        }
        if lengths[1].is_some() {
            edges.extend(span[1].map(|y| span[0].map(|x| DVec3::new(x, y, 0.0))));
        }
        edges
    }

    /// The distance of a point from the nearest wall; negative outside, infinite without walls.
    pub fn inside(&self, point: DVec3) -> f64 {
        let gaps = self.walls.surfaces().iter().map(|surface| surface.at(point, DVec3::ZERO, 0.0).separation);
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// The distance of a point from the edges of the periodic cell; infinite without one.
    fn edge(&self, point: DVec3) -> f64 {
        let axes = self.periods.lengths().into_iter().zip(point.to_array()).take(2);
        axes.filter_map(|(length, x)| Some((x.abs() - 0.5 * length?).abs())).fold(f64::INFINITY, f64::min)
    }
}

/// The largest concentration that a field's settings name.
fn largest(field: &Field) -> f64 {
    let at_borders = field.boundary.each().into_iter().flatten().map(|border| match border {
        Border::Value(value) => value,
        Border::Closed => 0.0,
    });
    let held = field.held.iter().map(|held| held.value);
    at_borders.chain(held).chain(field.values.iter().copied()).fold(field.initial, f64::max)
}

/// Mixes a part of ink into paper.
fn mix(pixel: &mut [u8], ink: [u8; 3], paper: [u8; 3], part: f64) {
    for (channel, (ink, paper)) in pixel.iter_mut().zip(ink.into_iter().zip(paper)) {
        *channel = (f64::from(paper) + part * (f64::from(ink) - f64::from(paper))).round() as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::NO_GROUP;
    use crate::render::{Background, picture};
    use crate::separation::Placed;
    use crate::shape::Shape;
    use glam::DQuat;

    fn drawn(backdrop: &Backdrop, planar: bool) -> Image {
        let mut bodies = Bodies::default();
        let shape = Shape::Sphere { radius: 1.0 };
        for x in [-3.0, 3.0] {
            let placed = Placed { shape, position: DVec3::X * x, orientation: DQuat::IDENTITY };
            bodies.push(placed, NO_GROUP);
        }
        let view = View { width: 200, height: 200, planar, scale_bar: false, ..View::default() };
        let mut image = picture(&bodies, &view);
        let [ink, paper] = Background::White.ink_and_paper().map(crate::render::bytes);
        backdrop.draw(&mut image, &view, &Camera::fit(&bodies, &view), ink, paper);
        image
    }

    #[test]
    fn a_channel_is_a_band_between_lines_with_grey_outside() {
        let wall =
            Wall::Channel { normal: [0.0, 1.0, 0.0], center: [0.0; 3], width: 4.0, motion: None, friction: None };
        let backdrop = Backdrop { walls: Walls::new(&[wall], true), ..Backdrop::default() };
        let image = drawn(&backdrop, true);
        let shade = |x: u32, y: u32| image.pixel(x, y).unwrap()[0];
        // The bodies' extent of 8 takes 92 % of the width: a length is 23 pixels, the walls are 46 from the middle.
        assert_eq!(shade(100, 100), 255);
        assert!(shade(100, 54) < 200 && shade(100, 146) < 200, "{} {}", shade(100, 54), shade(100, 146));
        assert!((215..250).contains(&shade(100, 20)) && (215..250).contains(&shade(100, 190)));
    }

    #[test]
    fn a_box_in_space_is_lines_behind_the_bodies() {
        let wall = Wall::Box { minimum: [-2.5, -2.0, -2.0], maximum: [2.5, 2.0, 2.0], motion: None, friction: None };
        let scene_walls = vec![wall];
        let backdrop = Backdrop { walls: Walls::new(&[wall], false), scene_walls, ..Backdrop::default() };
        let (with, without) = (drawn(&backdrop, false), drawn(&Backdrop::default(), false));
        let changed = with.pixels.chunks_exact(3).zip(without.pixels.chunks_exact(3)).filter(|(a, b)| a != b);
        let (inked, over) = changed.fold((0, 0), |(n, over), (_, old)| (n + 1, over + usize::from(old != [255; 3])));
        assert!(inked > 500 && over == 0, "{inked} {over}");
    }

    #[test]
    fn a_periodic_cell_is_a_frame() {
        let periods = Periods::new([Some(8.0), Some(6.0), None]);
        let image = drawn(&Backdrop { periods, ..Backdrop::default() }, true);
        let shade = |x: u32, y: u32| image.pixel(x, y).unwrap()[0];
        assert!(shade(100, 31) < 230 && shade(100, 169) < 230 && shade(8, 100) < 230);
        assert_eq!(shade(100, 100), 255);
    }
}
