//! Walls as lines, for pictures of scenes in space: edges of boxes, great circles of spheres, patches of planes.

use super::Wall;
use glam::DVec3;
use std::f64::consts::TAU;

/// Lines along each side of a patch of a plane, and to a turn of a circle.
const PATCH: usize = 6;
const TURN: usize = 96;
/// Lines along a cylinder.
const ALONG: usize = 8;

/// The ends of a line.
pub(crate) type Line = [DVec3; 2];

impl Wall {
    /// Its lines at `time`, about bodies from `low` to `high`.
    pub(crate) fn lines_at(&self, time: f64, low: DVec3, high: DVec3) -> Vec<Line> {
        let Some(moved) = self.moved(time) else { return self.lines(low, high) };
        // A cube that holds the bodies, as the wall sees them.
        let (middle, half) = (moved.back(0.5 * (low + high)), DVec3::splat(0.5 * (high - low).max_element()));
        self.lines(middle - half, middle + half).into_iter().map(|line| line.map(|end| moved.point(end))).collect()
    }

    /// Its lines at time 0.
    fn lines(&self, low: DVec3, high: DVec3) -> Vec<Line> {
        let (middle, size) = (0.5 * (low + high), (high - low).length());
        let unit = |v: [f64; 3]| DVec3::from(v).normalize_or(DVec3::X);
        match *self {
            Wall::HalfSpace { normal, offset, .. } => patch(unit(normal) * offset, unit(normal), middle, size),
            Wall::Channel { normal, center, width, .. } => {
                let (centre, normal) = (DVec3::from(center), unit(normal));
                let sides = [-0.5, 0.5].map(|side| patch(centre + side * width * normal, normal, middle, size));
                sides.concat()
            }
            Wall::Box { minimum, maximum, .. } => edges(minimum.into(), maximum.into()),
            Wall::Sphere { center, radius, .. } => {
                let axes = [[DVec3::X, DVec3::Y], [DVec3::Y, DVec3::Z], [DVec3::Z, DVec3::X]];
                axes.into_iter().flat_map(|axes| circle(center.into(), axes.map(|axis| radius * axis))).collect()
            }
            Wall::Cylinder { center, axis, radius, length, .. } => {
                let (centre, axis) = (DVec3::from(center), unit(axis));
                // One without ends reaches as far as the bodies.
                let half = 0.5 * length.unwrap_or(size);
                let centre = if length.is_some() { centre } else { centre + axis * (middle - centre).dot(axis) };
                let (u, v) = axis.any_orthonormal_pair();
                let ends = [-half, half].map(|along| circle(centre + along * axis, [u, v].map(|side| radius * side)));
                let along = (0..ALONG).map(|k| {
                    let (sin, cos) = (TAU * k as f64 / ALONG as f64).sin_cos();
                    [-half, half].map(|along| centre + radius * (cos * u + sin * v) + along * axis)
                });
                ends.into_iter().flatten().chain(along).collect()
            }
        }
    }
}

/// The twelve edges of a box.
pub(crate) fn edges(low: DVec3, high: DVec3) -> Vec<Line> {
    let corner = |bits: usize| {
        DVec3::from_array(std::array::from_fn(|axis| if bits >> axis & 1 == 0 { low[axis] } else { high[axis] }))
    };
    let along =
        |axis: usize| (0..8).filter(move |bits| bits >> axis & 1 == 0).map(move |bits| (bits, bits | 1 << axis));
    (0..3).flat_map(along).map(|(from, to)| [corner(from), corner(to)]).collect()
}

/// A grid on a plane, as large as the bodies, beside their middle.
fn patch(point: DVec3, normal: DVec3, middle: DVec3, size: f64) -> Vec<Line> {
    let foot = middle - normal * (middle - point).dot(normal);
    let (u, v) = normal.any_orthonormal_pair();
    let places = || (0..=PATCH).map(|k| size * (k as f64 / PATCH as f64 - 0.5));
    let across = |along: DVec3, aside: DVec3| {
        places().map(move |at| [-0.5, 0.5].map(|end| foot + at * aside + end * size * along))
    };
    across(u, v).chain(across(v, u)).collect()
}

fn circle(centre: DVec3, [u, v]: [DVec3; 2]) -> Vec<Line> {
    let at = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / TURN as f64).sin_cos();
        centre + cos * u + sin * v
    };
    (0..TURN).map(|k| [at(k), at(k + 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walls::Walls;

    #[test]
    fn lines_lie_on_their_wall() {
        let (center, normal) = ([1.0, -2.0, 0.5], [0.3, 0.2, 2.0]);
        let walls = [
            Wall::HalfSpace { normal, offset: -1.5, motion: None, friction: None, load: None },
            Wall::Channel { normal, center, width: 3.0, motion: None, friction: None },
            Wall::Box { minimum: [-1.0, -2.0, -3.0], maximum: [2.0, 3.0, 4.0], motion: None, friction: None },
            Wall::Sphere { center, radius: 2.5, motion: None, friction: None },
            Wall::Cylinder { center, axis: normal, radius: 1.5, length: Some(4.0), motion: None, friction: None },
            Wall::Cylinder { center, axis: normal, radius: 1.5, length: None, motion: None, friction: None },
        ];
        for wall in walls {
            let surfaces = Walls::new(&[wall], false);
            let lines = wall.lines(DVec3::splat(-3.0), DVec3::splat(4.0));
            assert!(lines.len() >= 12, "{wall:?}");
            for end in lines.into_iter().flatten() {
                let gaps = surfaces.surfaces().iter().map(|surface| surface.at(end, DVec3::ZERO, 0.0).separation);
                let nearest = gaps.fold(f64::INFINITY, |least, gap| least.min(gap.abs()));
                assert!(nearest < 1e-12, "{wall:?}: {end} is {nearest} off");
            }
        }
    }
}
