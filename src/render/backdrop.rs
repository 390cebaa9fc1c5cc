//! What stands still behind the bodies of a planar picture: the walls, grey outside of them, and the periodic cell.
//!
//! Every pixel that shows no body asks the walls' own surfaces how far it is from them, so that a wall of any kind is
//! drawn where bodies meet it.

use super::image::Image;
use super::{Camera, View};
use crate::bodies::Bodies;
use crate::periodic::Periods;
use crate::scene::Scene;
use crate::walls::Walls;
use glam::DVec3;
use rayon::prelude::*;

/// Half the thickness of a line, in parts of the picture's smaller side.
const HALF_LINE: f64 = 1.0 / 900.0;

/// How much ink is in what is outside of the walls.
const OUTSIDE: f64 = 0.14;

/// What stands still in a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Backdrop {
    pub walls: Walls,
    pub periods: Periods,
}

impl Backdrop {
    /// Of a scene.
    pub fn of(scene: &Scene) -> Self {
        Backdrop { walls: scene.walls(), periods: scene.periods() }
    }

    /// Draws it behind the bodies of a picture seen along z; nothing in other pictures.
    pub fn draw(&self, image: &mut Image, view: &View, camera: &Camera, ink: [u8; 3], paper: [u8; 3]) {
        let along_z = camera.toward == DVec3::Z;
        if !view.planar || !along_z || (self.walls.is_empty() && self.periods.is_none()) {
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
                let line = |distance: f64| (half_line + 0.5 - distance).clamp(0.0, 1.0);
                let grey = OUTSIDE * (0.5 - inside).clamp(0.0, 1.0);
                let part = grey.max(line(inside.abs())).max(0.5 * line(edge));
                for (channel, (ink, paper)) in pixel.iter_mut().zip(ink.into_iter().zip(paper)) {
                    *channel = (f64::from(paper) + part * (f64::from(ink) - f64::from(paper))).round() as u8;
                }
            }
        });
    }

    /// Draws it into the [`picture`](super::picture) of these bodies.
    pub fn behind(&self, image: &mut Image, view: &View, bodies: &Bodies) {
        let [ink, paper] = view.background.ink_and_paper().map(super::bytes);
        self.draw(image, view, &Camera::fit(bodies, view), ink, paper);
    }

    /// How far a point is inside of all walls; negative outside, infinite without walls.
    fn inside(&self, point: DVec3) -> f64 {
        let gaps = self.walls.surfaces().iter().map(|surface| surface.at(point, DVec3::ZERO, 0.0).separation);
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// How far a point is from the edges of the periodic cell; infinite without one.
    fn edge(&self, point: DVec3) -> f64 {
        let axes = self.periods.lengths().into_iter().zip(point.to_array()).take(2);
        axes.filter_map(|(length, x)| Some((x.abs() - 0.5 * length?).abs())).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::NO_GROUP;
    use crate::render::{Background, picture};
    use crate::separation::Placed;
    use crate::shape::Shape;
    use crate::walls::Wall;
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
        let wall = Wall::Channel { normal: [0.0, 1.0, 0.0], center: [0.0; 3], width: 4.0 };
        let backdrop = Backdrop { walls: Walls::new(&[wall], true), ..Backdrop::default() };
        let image = drawn(&backdrop, true);
        let shade = |x: u32, y: u32| image.pixel(x, y).unwrap()[0];
        // The bodies' extent of 8 takes 92 % of the width: a length is 23 pixels, the walls are 46 from the middle.
        assert_eq!(shade(100, 100), 255);
        assert!(shade(100, 54) < 200 && shade(100, 146) < 200, "{} {}", shade(100, 54), shade(100, 146));
        assert!((215..250).contains(&shade(100, 20)) && (215..250).contains(&shade(100, 190)));
        // In space it is left out.
        assert_eq!(drawn(&backdrop, false), drawn(&Backdrop::default(), false));
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
