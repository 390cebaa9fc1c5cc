//! Visibility: bodies are sorted from front to back and assigned to the tiles of the picture that their bounds touch;
//! then each tile casts its rays. Tiles are independent, so the result does not depend on threads.

use super::camera::{Bounds, Camera};
use super::intersect::{first_hit, normal};
use super::rays::Rays;
use crate::bodies::Bodies;
use crate::gpu::GpuError;
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

/// Rays along a pixel's side: 2 x 2 per pixel.
pub(super) const SUPERSAMPLING: usize = 2;
/// Rays along a tile's side. 64 x 64 samples of 16 bytes fill 64 KiB, about a core's own cache.
pub(super) const TILE: usize = 64;
/// The value of [`Sample::body`] without a visible body.
pub(super) const NOTHING: u32 = u32::MAX;

/// The first hit of a ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct Sample {
    /// The body's index, or [`NOTHING`].
    pub body: u32,
    /// The surface's height toward the viewer, from the camera's centre, in lengths.
    pub height: f32,
    /// The surface's unit normal along the camera's right and up; the rest points to the viewer.
    pub normal: [f32; 2],
}

const EMPTY: Sample = Sample { body: NOTHING, height: f32::NEG_INFINITY, normal: [0.0; 2] };

/// All rays of a picture, tile after tile.
pub(super) struct Samples {
    /// Rays in a row of the picture.
    pub width: usize,
    /// Rows of rays.
    pub height: usize,
    columns: usize,
    tiles: Vec<Sample>,
}

impl Samples {
    /// Casts the rays of a picture of `width` times `height` pixels.
    pub fn cast(bodies: &Bodies, camera: &Camera, width: u32, height: u32) -> Samples {
        let grid = Grid::new(camera, width, height);
        let drawn = grid.front_to_back(bodies, camera);
        let (first, members) = grid.bin(&drawn);
        grid.cast(&drawn, &first, &members)
    }

    /// The same on a device, or on the CPU if only it supports the bodies.
    pub fn cast_on(
        rays: &Rays,
        bodies: &Bodies,
        camera: &Camera,
        width: u32,
        height: u32,
    ) -> Result<Samples, GpuError> {
        let grid = Grid::new(camera, width, height);
        let drawn = grid.front_to_back(bodies, camera);
        let (first, members) = grid.bin(&drawn);
        let tiles = rays.cast(&drawn, (&first, &members), grid.tiles[0], grid.scale)?;
        let cast = |tiles| Samples { width: grid.size[0], height: grid.size[1], columns: grid.tiles[0], tiles };
        Ok(tiles.map_or_else(|| grid.cast(&drawn, &first, &members), cast))
    }

    /// The hit of the ray in column `x` and row `y` from the top left.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> &Sample {
        let tile = y / TILE * self.columns + x / TILE;
        &self.tiles[tile * TILE * TILE + y % TILE * TILE + x % TILE]
    }

    /// As [`Samples::at`], with nothing outside the picture.
    #[inline]
    pub fn near(&self, x: isize, y: isize) -> &Sample {
        if x < 0 || y < 0 || x as usize >= self.width || y as usize >= self.height {
            &EMPTY
        } else {
            self.at(x as usize, y as usize)
        }
    }
}

/// A body to draw and the samples it may cover.
pub(super) struct Drawn {
    pub body: u32,
    pub bounds: Bounds,
    /// Centre in samples from the top left.
    pub x: f64,
    pub y: f64,
    /// First and last covered column and row.
    pub columns: [usize; 2],
    pub rows: [usize; 2],
}

struct Grid {
    size: [usize; 2],
    tiles: [usize; 2],
    /// Samples per length.
    scale: f64,
}

impl Grid {
    fn new(camera: &Camera, width: u32, height: u32) -> Grid {
        let size = [width, height].map(|side| side as usize * SUPERSAMPLING);
        let scale = camera.pixels_per_length() * SUPERSAMPLING as f64;
        Grid { size, tiles: size.map(|side| side.div_ceil(TILE)), scale }
    }

    /// Casts all rays, on the CPU.
    fn cast(&self, drawn: &[Drawn], first: &[usize], members: &[u32]) -> Samples {
        let mut tiles = vec![EMPTY; self.tiles[0] * self.tiles[1] * TILE * TILE];
        tiles.par_chunks_mut(TILE * TILE).enumerate().for_each(|(tile, samples)| {
            let corner = [tile % self.tiles[0] * TILE, tile / self.tiles[0] * TILE];
            for &member in &members[first[tile]..first[tile + 1]] {
                self.cast_one(&drawn[member as usize], corner, samples);
            }
        });
        Samples { width: self.size[0], height: self.size[1], columns: self.tiles[0], tiles }
    }

    /// The bodies that cover at least one sample, from the nearest to the viewer on, equal ones by index.
    fn front_to_back(&self, bodies: &Bodies, camera: &Camera) -> Vec<Drawn> {
        let mut drawn: Vec<Drawn> =
            (0..bodies.len()).into_par_iter().filter_map(|i| self.place(bodies, camera, i)).collect();
        let front = |d: &Drawn| d.bounds.centre.z + d.bounds.reach.z;
        drawn.par_sort_by(|a, b| front(b).total_cmp(&front(a)));
        drawn
    }

    fn place(&self, bodies: &Bodies, camera: &Camera, i: usize) -> Option<Drawn> {
        let bounds = camera.bounds(bodies, i)?;
        let x = self.size[0] as f64 / 2.0 + bounds.centre.x * self.scale;
        let y = self.size[1] as f64 / 2.0 - bounds.centre.y * self.scale;
        let columns = covered(x, bounds.reach.x * self.scale, self.size[0])?;
        let rows = covered(y, bounds.reach.y * self.scale, self.size[1])?;
        Some(Drawn { body: u32::try_from(i).ok()?, bounds, x, y, columns, rows })
    }

    /// For each tile, the drawn bodies that may cover a sample of it, in order: offsets into one list.
    fn bin(&self, drawn: &[Drawn]) -> (Vec<usize>, Vec<u32>) {
        let mut first = vec![0; self.tiles[0] * self.tiles[1] + 1];
        for d in drawn {
            self.each_tile(d, |tile| first[tile + 1] += 1);
        }
        for tile in 1..first.len() {
            first[tile] += first[tile - 1];
        }
        let mut members = vec![0; first[first.len() - 1]];
        let mut next = first.clone();
        for (k, d) in drawn.iter().enumerate() {
            self.each_tile(d, |tile| {
                members[next[tile]] = k as u32;
                next[tile] += 1;
            });
        }
        (first, members)
    }

    fn each_tile(&self, drawn: &Drawn, mut act: impl FnMut(usize)) {
        for row in drawn.rows[0] / TILE..=drawn.rows[1] / TILE {
            for column in drawn.columns[0] / TILE..=drawn.columns[1] / TILE {
                act(row * self.tiles[0] + column);
            }
        }
    }

    /// Casts one body's rays in the tile that begins at `corner`.
    fn cast_one(&self, drawn: &Drawn, corner: [usize; 2], samples: &mut [Sample]) {
        let Bounds { geometry, axes: [right, up, toward], centre, reach } = &drawn.bounds;
        let front = (centre.z + reach.z) as f32;
        let [rows, columns] = [(drawn.rows, corner[1]), (drawn.columns, corner[0])]
            .map(|(range, start)| range[0].max(start)..(range[1] + 1).min(start + TILE));
        for y in rows {
            let line = *up * ((drawn.y - (y as f64 + 0.5)) / self.scale);
            let row = &mut samples[(y - corner[1]) * TILE..][..TILE];
            for x in columns.clone() {
                let sample = &mut row[x - corner[0]];
                if sample.height >= front {
                    continue;
                }
                let origin = line + *right * ((x as f64 + 0.5 - drawn.x) / self.scale);
                let Some(t) = first_hit(geometry, origin, -*toward) else { continue };
                let height = (centre.z - t) as f32;
                if height > sample.height {
                    let normal = normal(geometry, origin - *toward * t);
                    *sample = Sample {
                        body: drawn.body,
                        height,
                        normal: [normal.dot(*right) as f32, normal.dot(*up) as f32],
                    };
                }
            }
        }
    }
}

/// The first and last sample centre within `reach` of `centre`, of `count` samples at 0.5, 1.5, ...
fn covered(centre: f64, reach: f64, count: usize) -> Option<[usize; 2]> {
    let first = (centre - reach - 0.5).ceil().max(0.0);
    let last = (centre + reach - 0.5).floor().min(count as f64 - 1.0);
    (first <= last).then_some([first as usize, last as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::NO_GROUP;
    use crate::render::View;
    use crate::separation::Placed;
    use crate::shape::Shape;
    use glam::{DQuat, DVec3};
    use std::f64::consts::{FRAC_PI_2, PI};

    fn body(shape: Shape, position: DVec3, orientation: DQuat) -> Bodies {
        let mut bodies = Bodies::default();
        bodies.push(Placed { shape, position, orientation }, NO_GROUP);
        bodies
    }

    /// The area that a single body covers, by counting rays.
    fn counted(bodies: &Bodies, planar: bool) -> f64 {
        let view = View { width: 300, height: 260, planar, ..View::default() };
        let camera = Camera::fit(bodies, &view);
        let samples = Samples::cast(bodies, &camera, view.width, view.height);
        let seen = samples.tiles.iter().filter(|s| s.body == 0).count();
        seen as f64 / (camera.pixels_per_length() * SUPERSAMPLING as f64).powi(2)
    }

    fn assert_within_a_percent(counted: f64, exact: f64, what: &str) {
        assert!((counted / exact - 1.0).abs() < 0.01, "{what}: {counted} for {exact}");
    }

    #[test]
    fn bodies_cover_their_projected_area() {
        let turns = [0.0, 0.4, 1.1, 2.5].map(|a| DQuat::from_euler(glam::EulerRot::XYZ, a, 1.7 * a, 0.3));
        for orientation in turns {
            for planar in [true, false] {
                let toward = Camera::fit(&Bodies::default(), &View { planar, ..View::default() }).toward;
                let n = orientation.inverse() * toward;
                let count = |shape| counted(&body(shape, DVec3::new(7.0, -3.0, 2.0), orientation), planar);
                assert_within_a_percent(count(Shape::Sphere { radius: 1.3 }), PI * 1.69, "sphere");
                let sine = (1.0 - n.z * n.z).sqrt();
                let rod = PI * 0.25 + 3.0 * sine;
                assert_within_a_percent(count(Shape::Spherocylinder { diameter: 1.0, length: 4.0 }), rod, "rod");
                let [a, b, c] = [0.5, 0.8, 2.0];
                let shadow = PI * DVec3::new(b * c * n.x, a * c * n.y, a * b * n.z).length();
                assert_within_a_percent(count(Shape::Ellipsoid { radii: [a, b, c] }), shadow, "ellipsoid");
            }
        }
        let ring = Shape::Torus { major_radius: 2.0, minor_radius: 0.4 };
        let flat = counted(&body(ring, DVec3::ONE, DQuat::IDENTITY), true);
        assert_within_a_percent(flat, PI * (2.4 * 2.4 - 1.6 * 1.6), "flat ring");
        let upright = counted(&body(ring, DVec3::ONE, DQuat::from_rotation_x(FRAC_PI_2)), true);
        assert_within_a_percent(upright, 4.0 * 2.0 * 0.4 + PI * 0.16, "upright ring");
    }

    #[test]
    fn the_nearest_body_is_seen_in_any_order() {
        let ball = Shape::Sphere { radius: 1.0 };
        for heights in [[0.0, 0.5, -0.5], [0.5, 0.0, -0.5], [-0.5, 0.0, 0.5]] {
            let mut bodies = Bodies::default();
            for z in heights {
                bodies.push(Placed { shape: ball, position: DVec3::Z * z, orientation: DQuat::IDENTITY }, NO_GROUP);
            }
            let view = View { width: 40, height: 40, planar: true, ..View::default() };
            let samples = Samples::cast(&bodies, &Camera::fit(&bodies, &view), 40, 40);
            let front = heights.iter().position(|z| *z == 0.5).unwrap() as u32;
            assert!(samples.tiles.iter().all(|s| s.body == front || s.body == NOTHING));
            let middle = samples.at(40, 40);
            assert!((f64::from(middle.height) - 1.5).abs() < 1e-2, "{middle:?}");
        }
    }
}
