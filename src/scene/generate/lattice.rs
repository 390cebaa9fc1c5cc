//! Bodies of one shape on a lattice: so many along each axis, or all that are inside of a region.

use super::super::orientation::{ALONG_X, along};
use super::isotropic::{rotation, rotation_in_plane};
use super::{Lattice, LatticeKind};
use crate::bodies::Bodies;
use crate::periodic::Periods;
use crate::separation::Placed;
use crate::shape::Shape;
use crate::walls::{Wall, Walls};
use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;

/// The most sites of the box about a region that are tried, as many as a scene may have bodies.
const MOST_SITES: f64 = (1 << 24) as f64;

impl LatticeKind {
    /// Whether it is a sheet in the x-y plane.
    pub(in super::super) fn is_sheet(self) -> bool {
        self != LatticeKind::Cubic
    }

    /// The distance between rows along y, in spacings.
    fn row_height(self) -> f64 {
        if self == LatticeKind::Hexagonal { 0.75_f64.sqrt() } else { 1.0 }
    }

    /// How far a row is displaced along x, in spacings.
    fn row_shift(self, row: i64) -> f64 {
        if self == LatticeKind::Hexagonal && row.rem_euclid(2) == 1 { 0.5 } else { 0.0 }
    }
}

impl Lattice {
    /// The number of its bodies, at most `u64::MAX`.
    pub(in super::super) fn count(&self) -> u64 {
        if let Some(counts) = self.counts {
            return counts.iter().fold(1, |product, n| product.saturating_mul(*n));
        }
        match self.grid_inside() {
            Some(grid) if grid.sites() <= MOST_SITES => self.sites_inside(&grid).len() as u64,
            Some(grid) => grid.sites() as u64,
            None => 0,
        }
    }

    /// Whether its region, where it has one, leaves no way out.
    pub(in super::super) fn is_enclosed(&self) -> bool {
        self.region.is_none_or(|region| {
            Walls::new(&[region], self.kind.is_sheet()).are_closed(&Periods::NONE, self.kind.is_sheet())
        })
    }

    /// The farthest coordinate of a site.
    pub(in super::super) fn farthest(&self) -> f64 {
        let center = DVec3::from(self.center.unwrap_or_default()).abs();
        let half = match (self.counts, self.box_inside()) {
            (Some(counts), _) => 0.5 * self.spacing * DVec3::from_array(counts.map(|n| n as f64)),
            (None, Some([low, high])) => low.abs().max(high.abs()),
            (None, None) => DVec3::ZERO,
        };
        (center + half).max_element()
    }

    /// A site of the lattice: with a region, about which all others are counted.
    fn origin(&self) -> DVec3 {
        let middle = || self.region.as_ref().map_or(DVec3::ZERO, Wall::reference);
        self.center.map_or_else(middle, DVec3::from)
    }

    fn box_inside(&self) -> Option<[DVec3; 2]> {
        let sheet = self.kind.is_sheet();
        let plane = sheet.then(|| self.origin().z);
        self.region.and_then(|region| Walls::new(&[region], sheet).extent(&Periods::NONE, plane))
    }

    /// The site at a column, a row and a layer counted from `origin`.
    fn site(&self, origin: DVec3, [column, row, layer]: [i64; 3]) -> DVec3 {
        let x = column as f64 + self.kind.row_shift(row);
        origin + self.spacing * DVec3::new(x, self.kind.row_height() * row as f64, layer as f64)
    }

    /// The sites of `counts`, row by row, with the middle of the lattice at the center.
    fn sites_counted(&self, counts: [u64; 3]) -> Vec<DVec3> {
        let [columns, rows, layers] = counts.map(|n| n as i64);
        let last = DVec3::new((columns - 1) as f64, self.kind.row_height() * (rows - 1) as f64, (layers - 1) as f64);
        // Every second row of triangles is displaced by half a spacing.
        let shift = if rows > 1 { self.kind.row_shift(1) } else { 0.0 };
        let origin = self.origin() - 0.5 * self.spacing * (last + shift * DVec3::X);
        let row = |row: i64, layer: i64| (0..columns).map(move |column| self.site(origin, [column, row, layer]));
        (0..layers).flat_map(|layer| (0..rows).flat_map(move |of| row(of, layer))).collect()
    }

    /// The rows of the box about the region.
    fn grid_inside(&self) -> Option<Grid> {
        let [low, high] = self.box_inside()?;
        let origin = self.origin();
        let height = DVec3::new(1.0, self.kind.row_height(), 1.0) * self.spacing;
        let (first, last) = ((low - origin) / height, (high - origin) / height);
        let mut grid = Grid { first: first.floor(), last: last.ceil() };
        if self.kind.is_sheet() {
            (grid.first.z, grid.last.z) = (0.0, 0.0);
        }
        Some(grid)
    }

    /// The sites whose bodies are wholly inside the region, row by row.
    fn sites_inside(&self, grid: &Grid) -> Vec<DVec3> {
        let region: Vec<Wall> = self.region.into_iter().collect();
        let (walls, origin) = (Walls::new(&region, self.kind.is_sheet()), self.origin());
        // In whatever orientation, a body is inside where its bounding sphere is.
        let ball = Shape::Sphere { radius: self.shape.bounding_radius() };
        let (shape, orientation) = if self.random { (ball, DQuat::IDENTITY) } else { (self.shape, orientation(self)) };
        let is_inside = |position: &DVec3| walls.deepest(&Placed { shape, position: *position, orientation }).is_none();
        let [x, y, z] = [0, 1, 2].map(|axis| grid.first[axis] as i64..=grid.last[axis] as i64);
        let mut sites = Vec::new();
        for layer in z {
            for row in y.clone() {
                sites.extend(x.clone().map(|column| self.site(origin, [column, row, layer])).filter(is_inside));
            }
        }
        sites
    }

    fn sites(&self) -> Vec<DVec3> {
        match (self.counts, self.grid_inside()) {
            (Some(counts), _) => self.sites_counted(counts),
            (None, Some(grid)) => self.sites_inside(&grid),
            (None, None) => Vec::new(),
        }
    }
}

/// The columns, rows and layers of a box, the first and the last.
struct Grid {
    first: DVec3,
    last: DVec3,
}

impl Grid {
    fn sites(&self) -> f64 {
        (self.last - self.first + DVec3::ONE).element_product()
    }
}

/// The orientation of all bodies that have none of their own.
pub(in super::super) fn orientation(lattice: &Lattice) -> DQuat {
    match (lattice.axis, lattice.angle) {
        (Some(axis), _) => along(DVec3::from(axis)),
        (None, Some(angle)) => DQuat::from_rotation_z(angle.to_radians()) * ALONG_X,
        (None, None) if lattice.kind.is_sheet() => ALONG_X,
        (None, None) => DQuat::IDENTITY,
    }
}

/// Places all bodies, row by row. Orientations in a planar scene are drawn in the plane.
pub(super) fn add(lattice: &Lattice, planar: bool, random: &mut ChaCha8Rng, bodies: &mut Bodies, group: u32) {
    let (shape, same) = (lattice.shape, orientation(lattice));
    let lies = planar && !matches!(shape, Shape::Sphere { .. });
    for position in lattice.sites() {
        let orientation = match (lattice.random, lies) {
            (false, _) => same,
            (true, true) => rotation_in_plane(random),
            (true, false) => rotation(random),
        };
        bodies.push(Placed { shape, position, orientation }, group);
    }
}
