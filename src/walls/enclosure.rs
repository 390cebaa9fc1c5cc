//! Whether walls leave a way to infinity.
//!
//! Every surface has bodies on its convex side, so the space that walls leave is convex, and it is unlimited exactly
//! where it has a direction in which one may go for ever: its recession cone (R. T. Rockafellar, Convex Analysis, 1970,
//! section 8). If there is one, then there is one along the axis of a cylinder, at right angles to two planes, to one,
//! or, without planes, along any axis.

use crate::separation::Surface;
use glam::DVec3;

/// A direction that leads towards a plane by no more than this leads along it.
const ALONG: f64 = 1e-9;

/// Whether no body can leave: surfaces, and pairs of planes at right angles to `closed` axes, as periods and the plane
/// of a planar scene are, leave no direction to go for ever.
pub(super) fn is_closed(surfaces: &[Surface], closed: &[DVec3]) -> bool {
    let mut normals: Vec<DVec3> = closed.iter().flat_map(|axis| [*axis, -*axis]).collect();
    let mut along: Option<DVec3> = None;
    for surface in surfaces {
        match *surface {
            Surface::Plane { normal, .. } => normals.push(normal),
            Surface::Sphere { .. } => return true,
            Surface::Cylinder { axis, .. } if along.is_some_and(|other| other.cross(axis).length() > ALONG) => {
                return true;
            }
            Surface::Cylinder { axis, .. } => along = Some(axis),
        }
    }
    let is_open = |direction: DVec3| normals.iter().all(|normal| normal.dot(direction) >= -ALONG);
    !directions(&normals, along).into_iter().any(|direction| is_open(direction) || is_open(-direction))
}

/// The directions that are tried, both ways.
fn directions(normals: &[DVec3], along: Option<DVec3>) -> Vec<DVec3> {
    if let Some(axis) = along {
        return vec![axis];
    }
    let pairs = normals.iter().enumerate().flat_map(|(i, a)| normals[..i].iter().map(|b| a.cross(*b)));
    let single = normals.iter().flat_map(|normal| <[DVec3; 2]>::from(normal.any_orthonormal_pair()));
    pairs.filter(|line| line.length() > ALONG).map(DVec3::normalize).chain(single).chain(DVec3::AXES).collect()
}

/// The least determinant of three unit normals whose planes meet in a point.
const LEAST_CORNER: f64 = 1e-9;
/// How far a corner may be past a plane, in parts of its own size.
const AT_CORNER: f64 = 1e-9;

/// A plane as `normal . x >= offset`.
pub(super) type HalfSpace = (DVec3, f64);

/// A box along the axes that contains all that surfaces leave, the least one where they are planes: from the corners of
/// a polyhedron, with a cube about each sphere and a square tube about each cylinder. An axis that has a period is cut
/// to it, about the origin where no surface bounds it. Along z it is `plane` of a planar scene. None where nothing is
/// left.
pub(super) fn extent(surfaces: &[Surface], periods: &[Option<f64>; 3], plane: Option<f64>) -> Option<[DVec3; 2]> {
    let (mut low, mut high, mut tilted) = (DVec3::NEG_INFINITY, DVec3::INFINITY, Vec::new());
    for (normal, offset) in surfaces.iter().flat_map(half_spaces) {
        match DVec3::AXES.iter().position(|axis| axis.cross(normal) == DVec3::ZERO) {
            Some(axis) if normal[axis] > 0.0 => low[axis] = low[axis].max(offset / normal[axis]),
            Some(axis) => high[axis] = high[axis].min(offset / normal[axis]),
            None => tilted.push((normal, offset)),
        }
    }
    for (axis, length) in periods.iter().enumerate().filter_map(|(axis, length)| Some((axis, (*length)?))) {
        if low[axis].is_finite() && high[axis].is_finite() {
            high[axis] = high[axis].min(low[axis] + length);
        } else {
            (low[axis], high[axis]) = (-0.5 * length, 0.5 * length);
        }
    }
    if let Some(z) = plane {
        (low.z, high.z) = (z, z);
    }
    let faces = (0..3).flat_map(|axis| [(DVec3::AXES[axis], low[axis]), (-DVec3::AXES[axis], -high[axis])]);
    let planes: Vec<HalfSpace> = faces.filter(|(_, offset)| offset.is_finite()).chain(tilted).collect();
    corners(&planes)
}

/// The planes of a polyhedron about what a surface leaves.
pub(super) fn half_spaces(surface: &Surface) -> Vec<HalfSpace> {
    let about = |centre: DVec3, radius: f64, axes: &[DVec3]| {
        let both = axes.iter().flat_map(|axis| [*axis, -*axis]);
        both.map(|normal| (normal, normal.dot(centre) - radius)).collect()
    };
    match *surface {
        Surface::Plane { point, normal } => vec![(normal, normal.dot(point))],
        Surface::Sphere { centre, radius } => about(centre, radius, &DVec3::AXES),
        Surface::Cylinder { centre, axis, radius } => {
            // Along the axes of space where the cylinder is along one of them.
            let first = DVec3::AXES.into_iter().find(|other| other.dot(axis) == 0.0);
            let first = first.unwrap_or_else(|| axis.any_orthonormal_vector());
            about(centre, radius, &[first, axis.cross(first)])
        }
    }
}

/// The box of all points in which three planes meet and that are past none.
pub(super) fn corners(planes: &[HalfSpace]) -> Option<[DVec3; 2]> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (i, (a, at_a)) in planes.iter().enumerate() {
        for (j, (b, at_b)) in planes[..i].iter().enumerate() {
            let line = a.cross(*b);
            for (c, at_c) in &planes[..j] {
                let determinant = line.dot(*c);
                if determinant.abs() < LEAST_CORNER {
                    continue;
                }
                let corner = (*at_a * b.cross(*c) + *at_b * c.cross(*a) + *at_c * line) / determinant;
                let slack = AT_CORNER * (1.0 + corner.length());
                if planes.iter().all(|(normal, offset)| normal.dot(corner) >= offset - slack) {
                    (low, high) = (low.min(corner), high.max(corner));
                }
            }
        }
    }
    (low.x <= high.x).then_some([low, high])
}

#[cfg(test)]
mod tests {
    use super::super::{Wall, Walls};
    use super::*;

    fn closed(walls: &str, planar: bool) -> bool {
        let walls: Vec<Wall> = serde_json::from_str(walls).unwrap();
        let plane = [DVec3::Z];
        is_closed(Walls::new(&walls, planar).surfaces(), if planar { &plane } else { &[] })
    }

    #[test]
    fn containers_are_closed_and_what_has_an_opening_is_not() {
        let sphere = r#"{"sphere": {"center": [1, 2, 0], "radius": 3}}"#;
        let boxed = r#"{"box": {"minimum": [0, 0, -1], "maximum": [2, 3, 1]}}"#;
        let tube = r#"{"cylinder": {"center": [0, 0, 0], "axis": [0.2, -0.1, 1], "radius": 6.5}}"#;
        let capped = r#"{"cylinder": {"center": [0, 0, 0], "axis": [0.2, -0.1, 1], "radius": 6.5, "length": 13}}"#;
        let disc = r#"{"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 6.5}}"#;
        let crossed = r#"{"cylinder": {"center": [0, 0, 0], "axis": [1, 0, 0], "radius": 6.5}}"#;
        let channel = r#"{"channel": {"center": [0, 0, 0], "normal": [0.3, 1, 0], "width": 2}}"#;
        let end = r#"{"half_space": {"normal": [1, -0.3, 0], "offset": -4}}"#;
        let other_end = r#"{"half_space": {"normal": [-1, 0.4, 0], "offset": -4}}"#;
        let floor = r#"{"half_space": {"normal": [0, 0, 1], "offset": 0}}"#;
        for (walls, in_plane, in_space) in [
            (vec![], false, false),
            (vec![sphere], true, true),
            (vec![boxed], true, true),
            (vec![disc], true, false),
            (vec![tube], false, false),
            (vec![tube, floor], false, false),
            (vec![tube, disc], true, true),
            (vec![disc, crossed], true, true),
            (vec![capped], true, true),
            (vec![channel], false, false),
            (vec![channel, end], false, false),
            (vec![channel, end, other_end], true, false),
            (vec![floor], false, false),
        ] {
            let text = format!("[{}]", walls.join(", "));
            // A tilted tube is no wall of a planar scene.
            if !text.contains("-0.1") {
                assert_eq!(closed(&text, true), in_plane, "in the plane: {text}");
            }
            assert_eq!(closed(&text, false), in_space, "in space: {text}");
        }
    }

    #[test]
    fn the_box_about_what_walls_leave() {
        let of = |text: &str, periods: [Option<f64>; 3], planar: bool| {
            let walls: Vec<Wall> = serde_json::from_str(text).unwrap();
            extent(Walls::new(&walls, planar).surfaces(), &periods, planar.then_some(0.0))
        };
        let near = |found: Option<[DVec3; 2]>, low: [f64; 3], high: [f64; 3]| {
            let [a, b] = found.unwrap();
            assert!((a - DVec3::from(low)).length() < 1e-12 && (b - DVec3::from(high)).length() < 1e-12, "{a} {b}");
        };
        let boxed = r#"{"box": {"minimum": [0, 0, -1], "maximum": [2, 3, 1]}}"#;
        let sphere = r#"{"sphere": {"center": [1, 2, 0], "radius": 3}}"#;
        near(of(&format!("[{boxed}]"), [None; 3], false), [0.0, 0.0, -1.0], [2.0, 3.0, 1.0]);
        near(of(&format!("[{boxed}]"), [None; 3], true), [0.0, 0.0, 0.0], [2.0, 3.0, 0.0]);
        near(of(&format!("[{sphere}, {boxed}]"), [None; 3], false), [0.0, 0.0, -1.0], [2.0, 3.0, 1.0]);
        let tube = r#"{"cylinder": {"center": [1, 0, 5], "axis": [0, 0, 2], "radius": 2, "length": 4}}"#;
        near(of(&format!("[{tube}]"), [None; 3], false), [-1.0, -2.0, 3.0], [3.0, 2.0, 7.0]);
        // A channel between two tilted ends: x + y = 4 meets y = -1 at x = 5.
        let wedge = r#"[{"channel": {"center": [0, 0, 0], "normal": [0, 1, 0], "width": 2}},
            {"half_space": {"normal": [1, 0, 0], "offset": 0}},
            {"half_space": {"normal": [-1, -1, 0], "offset": -2.8284271247461903}}]"#;
        near(of(wedge, [None; 3], true), [0.0, -1.0, 0.0], [5.0, 1.0, 0.0]);
        assert_eq!(of(wedge, [None; 3], false).map(|[low, _]| low.z), None, "open along z");
        // Periods: about the origin, or what a surface cuts.
        near(of(wedge, [None, None, Some(6.0)], false), [0.0, -1.0, -3.0], [5.0, 1.0, 3.0]);
        near(of(&format!("[{boxed}]"), [Some(1.5), None, Some(20.0)], false), [0.0, 0.0, -1.0], [1.5, 3.0, 1.0]);
        let apart = r#"{"box": {"minimum": [9, 9, 9], "maximum": [10, 10, 10]}}"#;
        assert_eq!(of(&format!("[{boxed}, {apart}]"), [None; 3], false), None);
    }

    #[test]
    fn periods_close_a_channel() {
        let walls: Vec<Wall> =
            serde_json::from_str(r#"[{"channel": {"center": [0, 0, 0], "normal": [0, 1, 0], "width": 2}}]"#).unwrap();
        let surfaces = Walls::new(&walls, true).surfaces().to_vec();
        assert!(is_closed(&surfaces, &[DVec3::Z, DVec3::X]));
        assert!(!is_closed(&surfaces, &[DVec3::Z, DVec3::Y]));
        assert!(is_closed(&[], &DVec3::AXES));
    }
}
