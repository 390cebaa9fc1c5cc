//! How much space walls leave: the volume, in the plane the area, of one periodic cell.

use super::enclosure::{HalfSpace, half_spaces};
use super::{Walls, across};
use crate::periodic::Periods;
use crate::separation::Surface;
use glam::DVec3;
use std::f64::consts::PI;

/// A plane and an axis whose cosine is within this of 0 or 1 are parallel or at right angles.
const ALIGNED: f64 = 1e-9;

impl Walls {
    /// The volume that the walls leave in one periodic cell; in a planar scene, whose plane has the z `plane`, the
    /// area. None where they leave a way to infinity, and where planes cut a sphere, or a cylinder at a slant.
    ///
    /// ```
    /// use relcp::periodic::Periods;
    /// use relcp::walls::{Wall, Walls};
    /// let (center, normal) = ([0.0; 3], [0.0, 1.0, 0.0]);
    /// let channel = Wall::Channel { center, normal, width: 2.0, motion: None, friction: None };
    /// let periods = Periods::new([Some(9.0), None, None]);
    /// let area = Walls::new(&[channel], true).space(&periods, Some(0.0)).unwrap();
    /// assert!((area - 18.0).abs() < 1e-12);
    /// ```
    pub fn space(&self, periods: &Periods, plane: Option<f64>) -> Option<f64> {
        if self.is_empty() || !self.are_closed(periods, plane.is_some()) {
            return None;
        }
        let mut planes = of_cell(periods, plane);
        let mut round = Vec::new();
        for surface in self.surfaces() {
            match *surface {
                Surface::Plane { .. } => planes.extend(half_spaces(surface)),
                Surface::Cylinder { axis, .. } if plane.is_some() && !across(axis) => {
                    planes.extend(half_spaces(surface).into_iter().filter(|(normal, _)| normal.z.abs() < ALIGNED));
                }
                _ => round.push(*surface),
            }
        }
        match &round[..] {
            [] => volume(&planes),
            [Surface::Sphere { centre, radius }] => {
                let sides = planes.iter().filter(|(normal, _)| !across(*normal) || plane.is_none());
                let uncut = |(normal, offset): &HalfSpace| normal.dot(*centre) - offset >= *radius * (1.0 - ALIGNED);
                let own = if plane.is_some() { PI * radius * radius } else { 4.0 / 3.0 * PI * radius.powi(3) };
                sides.clone().all(uncut).then_some(own)
            }
            [Surface::Cylinder { centre, axis, radius }] => of_cylinder(&planes, (*centre, *axis, *radius)),
            _ => None,
        }
    }
}

/// The planes of one periodic cell, about the origin, and in a planar scene those half a unit above and below.
fn of_cell(periods: &Periods, plane: Option<f64>) -> Vec<HalfSpace> {
    let along =
        |axis: DVec3, center: f64, length: f64| [(axis, center - 0.5 * length), (-axis, -center - 0.5 * length)];
    let axes = DVec3::AXES.into_iter().zip(periods.lengths());
    let cell = axes.filter_map(|(axis, length)| Some(along(axis, 0.0, length?)));
    cell.chain(plane.map(|z| along(DVec3::Z, z, 1.0))).flatten().collect()
}

/// That of a cylinder between planes across it; other planes may only stand beside it.
fn of_cylinder(planes: &[HalfSpace], (centre, axis, radius): (DVec3, DVec3, f64)) -> Option<f64> {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (normal, offset) in planes {
        let (cosine, depth) = (normal.dot(axis), normal.dot(centre) - offset);
        match cosine.abs() {
            aligned if aligned > 1.0 - ALIGNED && cosine > 0.0 => low = low.max(-depth),
            aligned if aligned > 1.0 - ALIGNED => high = high.min(depth),
            slant if slant < ALIGNED && depth >= radius * (1.0 - ALIGNED) => {}
            _ => return None,
        }
    }
    let length = high - low;
    (length.is_finite() && length > 0.0).then_some(PI * radius * radius * length)
}

/// The volume of a polyhedron: of the pyramids from a point of it to its faces, a face being what the other planes
/// leave of a large square. None where nothing is left.
fn volume(planes: &[HalfSpace]) -> Option<f64> {
    let [low, high] = super::enclosure::corners(planes)?;
    let (inside, reach) = (0.5 * (low + high), 2.0 * (high - low).length());
    let of_face = |(i, (normal, offset)): (usize, &HalfSpace)| {
        let depth = normal.dot(inside) - offset;
        let foot = inside - depth * *normal;
        let (u, v) = normal.any_orthonormal_pair();
        let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        let mut face: Vec<DVec3> = corners.iter().map(|(a, b)| foot + reach * (a * u + b * v)).collect();
        for (j, other) in planes.iter().enumerate().filter(|(j, _)| *j != i) {
            // One of two equal planes has the face.
            let same =
                other.0.dot(*normal) > 1.0 - ALIGNED && (other.1 - offset).abs() <= ALIGNED * (1.0 + offset.abs());
            match same {
                true if j < i => return 0.0,
                true => {}
                false => face = clipped(&face, other),
            }
        }
        depth * area(&face) / 3.0
    };
    Some(planes.iter().enumerate().map(of_face).sum())
}

/// What a plane leaves of a convex polygon.
fn clipped(polygon: &[DVec3], (normal, offset): &HalfSpace) -> Vec<DVec3> {
    let height = |point: DVec3| normal.dot(point) - offset;
    let next = polygon.iter().cycle().skip(1);
    let edge = |(from, to): (&DVec3, &DVec3)| {
        let (a, b) = (height(*from), height(*to));
        let kept = (a >= 0.0).then_some(*from);
        let cut = ((a >= 0.0) != (b >= 0.0)).then(|| *from + a / (a - b) * (*to - *from));
        [kept, cut]
    };
    polygon.iter().zip(next).flat_map(edge).flatten().collect()
}

fn area(polygon: &[DVec3]) -> f64 {
    let Some(first) = polygon.first() else { return 0.0 };
    let twice: DVec3 = polygon.windows(2).map(|pair| (pair[0] - *first).cross(pair[1] - *first)).sum();
    0.5 * twice.length()
}

#[cfg(test)]
mod tests {
    use super::super::Wall;
    use super::*;

    fn space(walls: &str, periods: [Option<f64>; 3], planar: bool) -> Option<f64> {
        let walls: Vec<Wall> = serde_json::from_str(walls).unwrap();
        Walls::new(&walls, planar).space(&Periods::new(periods), planar.then_some(0.0))
    }

    #[test]
    fn what_walls_leave_is_known_in_closed_form() {
        let open = [None; 3];
        let room = r#"{"box": {"minimum": [1, 2, -3], "maximum": [3, 5, 4]}}"#;
        let cut = r#"{"half_space": {"normal": [-1, -1, 0], "offset": -4.242640687119285}}"#;
        let ball = r#"{"sphere": {"center": [5, 0, 0], "radius": 2}}"#;
        let tube = r#"{"cylinder": {"center": [0, 0, 1], "axis": [0, 0, 1], "radius": 2}}"#;
        let can = r#"{"cylinder": {"center": [0, 1, 0], "axis": [1, 0, 0], "radius": 2, "length": 5}}"#;
        let floor = r#"{"half_space": {"normal": [0, 1, 0], "offset": 0}}"#;
        let lid = r#"{"half_space": {"normal": [0, -1, 0], "offset": -4}}"#;
        let of = |walls: &[&str]| format!("[{}]", walls.join(","));
        for (walls, periods, planar, expected) in [
            (of(&[room]), open, false, Some(42.0)),
            (of(&[room]), open, true, Some(6.0)),
            // Less the triangle beyond x + y = 6, of legs 2; twice the same plane counts once.
            (of(&[room, cut]), open, true, Some(4.0)),
            (of(&[room, cut, cut]), open, false, Some(28.0)),
            (of(&[ball]), open, false, Some(32.0 / 3.0 * PI)),
            (of(&[ball]), open, true, Some(4.0 * PI)),
            (of(&[ball, cut]), open, true, None),
            (of(&[tube]), open, true, Some(4.0 * PI)),
            (of(&[tube]), open, false, None),
            (of(&[tube]), [None, None, Some(7.0)], false, Some(28.0 * PI)),
            (of(&[can]), open, false, Some(20.0 * PI)),
            (of(&[can]), open, true, Some(20.0)),
            (of(&[floor, lid]), [Some(3.0), None, None], true, Some(12.0)),
            (of(&[floor, lid]), [Some(3.0), None, Some(2.0)], false, Some(24.0)),
            (of(&[floor, lid]), open, true, None),
            (of(&[]), [Some(3.0); 3], false, None),
        ] {
            let found = space(&walls, periods, planar);
            let near = match (found, expected) {
                (Some(found), Some(expected)) => (found / expected - 1.0).abs() < 1e-12,
                _ => found == expected,
            };
            assert!(near, "{walls} {periods:?} planar {planar}: {found:?}, not {expected:?}");
        }
    }
}
