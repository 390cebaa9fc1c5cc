//! The areas of walls' surfaces, over which their pressure is taken; in a planar scene the lengths of their sections.

use super::{Wall, across};
use crate::periodic::Periods;
use glam::DVec3;
use std::f64::consts::PI;

impl Wall {
    /// The area of each of its [surfaces](Wall::surfaces); none where a surface has no end. Planes and tubes that go on
    /// along periods have the area in one cell.
    pub(crate) fn areas(&self, periods: &Periods, planar: bool) -> Vec<Option<f64>> {
        match *self {
            Wall::HalfSpace { .. } => vec![of_plane(periods, planar)],
            Wall::Channel { .. } => vec![of_plane(periods, planar); 2],
            Wall::Box { minimum, maximum, .. } => of_box(DVec3::from(maximum) - DVec3::from(minimum), planar),
            Wall::Sphere { radius, .. } => vec![Some(if planar { 2.0 } else { 4.0 * radius } * PI * radius)],
            Wall::Cylinder { axis, radius, length, .. } => {
                // One without ends goes on along the only period that it can be parallel to.
                let along = length.or_else(|| along_periods(periods, planar, 1));
                match planar {
                    true if across(DVec3::from(axis).normalize_or(DVec3::X)) => vec![Some(2.0 * PI * radius)],
                    true => with_ends(along.map(|along| 2.0 * along), 2.0 * radius, length.is_some()),
                    false => {
                        let round = along.map(|along| 2.0 * PI * radius * along);
                        with_ends(round, PI * radius * radius, length.is_some())
                    }
                }
            }
        }
    }
}

/// A surface, and two flat ends where there are any.
fn with_ends(round: Option<f64>, end: f64, ends: bool) -> Vec<Option<f64>> {
    let mut areas = vec![round];
    areas.resize(if ends { 3 } else { 1 }, Some(end));
    areas
}

/// The area of the faces of a box with these sides, in the order of its surfaces.
fn of_box(sides: DVec3, planar: bool) -> Vec<Option<f64>> {
    let face = |axis: usize| {
        let others = (0..3).filter(|other| *other != axis && !(planar && *other == 2));
        Some(others.map(|other| sides[other]).product())
    };
    let axes = if planar { 0..2 } else { 0..3 };
    axes.flat_map(|axis| [face(axis); 2]).collect()
}

/// The area of a plane in a periodic cell: walls are parallel to all periods.
fn of_plane(periods: &Periods, planar: bool) -> Option<f64> {
    along_periods(periods, planar, if planar { 1 } else { 2 })
}

/// The product of the periods, if there are so many. In a sheared cell the periods' parallelogram has this area too.
fn along_periods(periods: &Periods, planar: bool, number: usize) -> Option<f64> {
    let lengths = periods.lengths();
    let known = || lengths.iter().take(if planar { 2 } else { 3 }).flatten();
    (known().count() == number).then(|| known().product())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_those_of_the_surfaces() {
        let (open, cell) = (Periods::NONE, Periods::new([Some(3.0), Some(5.0), None]));
        let tube = Periods::new([None, None, Some(4.0)]);
        let floor = Wall::HalfSpace { normal: [0.0, 0.0, 2.0], offset: 0.0, motion: None, friction: None, load: None };
        let sides =
            Wall::Channel { normal: [0.0, 1.0, 0.0], center: [0.0; 3], width: 2.0, motion: None, friction: None };
        let room = Wall::Box { minimum: [0.0; 3], maximum: [2.0, 3.0, 5.0], motion: None, friction: None };
        let ball = Wall::Sphere { center: [0.0; 3], radius: 2.0, motion: None, friction: None };
        let can = |length: Option<f64>, axis: [f64; 3]| Wall::Cylinder {
            center: [0.0; 3],
            axis,
            radius: 0.5,
            length,
            motion: None,
            friction: None,
        };
        let (z, x) = ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        for (wall, periods, planar, expected) in [
            (floor, open, false, vec![None]),
            (floor, cell, false, vec![Some(15.0)]),
            (sides, Periods::new([Some(3.0), None, None]), false, vec![None; 2]),
            (sides, Periods::new([Some(3.0), None, None]), true, vec![Some(3.0); 2]),
            (room, open, false, [15.0, 15.0, 10.0, 10.0, 6.0, 6.0].map(Some).to_vec()),
            (room, open, true, [3.0, 3.0, 2.0, 2.0].map(Some).to_vec()),
            (ball, open, false, vec![Some(16.0 * PI)]),
            (ball, open, true, vec![Some(4.0 * PI)]),
            (can(None, z), open, false, vec![None]),
            (can(None, z), tube, false, vec![Some(4.0 * PI)]),
            (can(Some(6.0), z), open, false, [6.0 * PI, 0.25 * PI, 0.25 * PI].map(Some).to_vec()),
            (can(Some(6.0), z), open, true, vec![Some(PI)]),
            (can(Some(6.0), x), open, true, [12.0, 1.0, 1.0].map(Some).to_vec()),
        ] {
            let found = wall.areas(&periods, planar);
            assert_eq!(found.len(), wall.surfaces(planar).len(), "{wall:?}");
            let near = |(a, b): (&Option<f64>, &Option<f64>)| match (a, b) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-12,
                _ => a == b,
            };
            assert!(found.iter().zip(&expected).all(near), "{wall:?}, planar {planar}: {found:?}");
        }
    }
}
